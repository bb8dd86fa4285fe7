# SPDX-License-Identifier: Apache-2.0
"""What must have an end: actions, calls, decisions; and who and what a decision asks for."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Iterator

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, RobotUse, StateRef
from rai_missions.check.pointers import pointer
from rai_missions.errors import UsageError, suggestion
from rai_missions.kinds import PackageOffer, named
from rai_missions.mission.option_parameters import schema_fault
from rai_missions.model.references import Interface
from rai_missions.states import State
from rai_missions.states.decision import ACTING_TOOLS, ANSWERERS, LOOKING_TOOLS, answerer_offer
from rai_missions.states.effects import Effect
from rai_missions.states.tree import TreeNode

__all__ = (
    "misspelled_answerers", "unbounded_actions", "unbounded_calls", "unbounded_decisions", "unknown_tools",
    "unlisted_answerers", "unreachable_limits", "wrong_parameters",
)  # fmt: skip


def unbounded_actions(index: MissionIndex) -> Found:
    """An action has a `timeout_s`, or something around it does."""
    for use in _unbounded(index, "action"):
        yield use.place, f"action '{use.name}' has no 'timeout_s', so it may run for ever; add one, in seconds"


def unbounded_calls(index: MissionIndex) -> Found:
    """A call has a `timeout_s`, or something around it does."""
    for use in _unbounded(index, "service"):
        yield use.place, f"call '{use.name}' has no 'timeout_s', so it may wait for ever; add one, in seconds"


def _unbounded(index: MissionIndex, sort: Interface) -> Iterator[RobotUse]:
    """What waits for the robot without an end: no effect, and of a state that makes a tree its leaves alone."""
    for use in index.uses:
        if use.sort == sort and not _waits_elsewhere(use.user) and use.user.timeout_s is None:
            around = use.scope.owner.upward() if use.scope.owner is not None else ()
            if not use.scope.timed and not any(map(_timed, around)):
                yield use


def _waits_elsewhere(user: Effect | State | TreeNode) -> bool:
    return isinstance(user, Effect) or (isinstance(user, State) and user.made() is not None)


def _timed(spot: StateRef) -> bool:
    """Whether a state is left after a while: by its timeout, or by a transition that only time decides."""
    transitions = (transition.definition for transition in spot.transitions)
    return spot.state.timeout_s is not None or any(
        transition.after_s is not None and transition.when is None and bool(transition.to) for transition in transitions
    )


def unbounded_decisions(index: MissionIndex) -> Found:
    """A decision has a `deadline_s`, and a `fallback` for when it has passed."""
    for asked, place, _ in index.asked:
        if asked.deadline_s is None:
            yield place, "the decision has no 'deadline_s', so it may wait for an answer for ever; add one, in seconds"
        if asked.fallback is None:
            free = [name for name, option in asked.options.items() if option.when is None and option.parameters is None]
            remedy = (
                f"name an option that is always open: {', '.join(free)}"
                if free
                else "add an option without 'when', and name it"
            )
            yield place, f"the decision has no 'fallback' for when no one answers; {remedy}"


def unreachable_limits(index: MissionIndex) -> Found:
    """A limit within another is no longer than that one: `within_s`, `deadline_s`, the `timeout_s` around them."""
    for asked, place, spot in index.asked:
        around = min((each.state.timeout_s for each in spot.upward() if each.state.timeout_s is not None), default=None)
        limits = (("within_s", asked.within_s), ("deadline_s", asked.deadline_s), ("timeout_s", around))
        given = [(word, seconds) for word, seconds in limits if seconds is not None]
        for (word, seconds), (other, less) in itertools.pairwise(given):
            if seconds > less:
                yield (
                    f"{place}/{word}",
                    f"{seconds:g} s are never reached, since '{other}' ends it after {less:g} s; write less here, or "
                    "more there",
                )


def unknown_tools(index: MissionIndex) -> Found:
    """`tools` names tools that look: ours, or those that the program brings; none that acts."""
    for asked, place, _ in index.asked:
        for number, name in enumerate(asked.tools):
            if name in ACTING_TOOLS:
                yield f"{place}/tools/{number}", f"the tool '{name}' acts, and a decision may only look; drop it"
            elif name not in LOOKING_TOOLS:
                near = suggestion(name, LOOKING_TOOLS)
                yield f"{place}/tools/{number}", f"no tool '{name}', unless the program brings it{near}"


def misspelled_answerers(index: MissionIndex) -> Found:
    """`ask` names agent, operator, rules or another answerer; nothing that only resembles one of the three."""
    for asked, place, _ in index.asked:
        for number, name in enumerate(asked.ask):
            close = () if name in ANSWERERS else difflib.get_close_matches(name, ANSWERERS, n=1, cutoff=0.75)
            if close and _offering(name) is None:
                yield f"{place}/ask/{number}", f"no one is called '{name}'; did you mean '{close[0]}'?"
            elif name in asked.ask[:number]:
                yield f"{place}/ask/{number}", f"'{name}' is asked twice; raise 'attempts' instead"


def unlisted_answerers(index: MissionIndex) -> Found:
    """The package of an answerer is listed in `uses`; one of the program needs no package."""
    packages = {named(each) for each in index.mission.uses}
    for asked, place, _ in index.asked:
        for number, name in enumerate(asked.ask):
            offering = _offering(name)
            if isinstance(offering, str):
                yield f"{place}/ask/{number}", offering
            elif offering is not None and offering.package not in packages:
                remedy = f'add "uses": ["{offering.package}>={offering.version}"]'
                yield (
                    f"{place}/ask/{number}",
                    f"'{name}' is not asked unless the program brings it; if {offering} is meant, {remedy}",
                )


def _offering(name: str) -> PackageOffer | str | None:
    """Who of other packages offers an answerer; why no one counts, where two do."""
    try:
        return answerer_offer(name)
    except UsageError as error:
        return str(error)


def wrong_parameters(index: MissionIndex) -> Found:
    """An option's `parameters` are a JSON Schema of an object."""
    for asked, place, _ in index.asked:
        for name, option in asked.options.items():
            if option.parameters is not None and (why := schema_fault(option.parameters)):
                remedy = 'write {"type": "object", "properties": {…}}'
                yield (
                    pointer(place, "options", name, "parameters"),
                    f"this is no JSON Schema of an object: {why}; {remedy}",
                )
