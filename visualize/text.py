# SPDX-License-Identifier: Apache-2.0
"""What a reviewer must know of a state, an option or a tree node, in words.

Rule: nothing that changes what the robot does is left out; how the words are laid out is the writers' affair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rai_missions.errors import pointer
from rai_missions.mission.mission import Mission
from rai_missions.states import Default, State
from rai_missions.states.control import CONTROLLERS
from rai_missions.states.decision import DecisionSpec
from rai_missions.states.effects import Effect
from rai_missions.states.transition import Transition
from visualize.model import Choice, Twig

__all__ = ("canceled", "child_pointer", "choices", "controlled", "effects", "trigger", "twigs")


def child_pointer(place: str, *steps: str) -> str:
    """A JSON pointer (RFC 6901) some steps further."""
    return place + pointer(steps)


def trigger(transition: Transition) -> str:
    """What fires a transition; empty where its guard alone does; a history's default leads `without memory`."""
    if isinstance(transition, Default):
        return transition.words()
    if transition.after_s is not None:
        return f"after {transition.after_s:g} s"
    words = " or ".join("any event" if name == "*" else name for name in transition.on)
    return f"{words} of {transition.of}" if transition.of else words


def controlled(holder: str) -> str:
    """Who commands the actuators, by the word of `control`: `controlled by the mission itself`; empty for none.

    The format's `agent` is the mission's own program here, and a model where a decision asks it; a reader sees neither.
    """
    return f"controlled by {CONTROLLERS.get(holder, holder)}" if holder else ""


def canceled(mission: Mission) -> str:
    """Where a cancel leads."""
    if mission.on_cancel:
        return f"cancel: leads to {mission.on_cancel}, at most {mission.cancel_s:g} s; it ends canceled"
    return "cancel: everything is left and its goals are canceled; it ends canceled"


def effects(given: Iterable[Effect]) -> tuple[str, ...]:
    """Effects as a person would state them, with what they send."""
    return tuple(effect.details() for effect in given)


def _names(schema: Mapping[str, Any] | None) -> tuple[str, ...]:
    """The parameters that a schema names; a mission at fault may state anything there."""
    named = (schema or {}).get("properties")
    return tuple(named) if isinstance(named, Mapping) else ()


def choices(asked: DecisionSpec, place: str) -> tuple[Choice, ...]:
    """The options of a decision that is at a JSON pointer."""
    return tuple(
        Choice(
            name=name,
            place=child_pointer(place, "options", name),
            about=option.about,
            guard=option.when.words() if option.when is not None else "",
            parameters=_names(option.parameters),
            fallback=name == asked.fallback,
        )
        for name, option in asked.options.items()
    )


def twigs(state: State, place: str) -> Iterator[Twig]:
    """The nodes of a state's tree, outer before inner."""
    above: dict[str, tuple[str, str, int]] = {}
    for path, node in state.nodes().items():
        branches = tuple(node.branches())
        for number, (branch_path, _) in enumerate(branches, 1):
            branch = branch_path.partition("/")[2] if branch_path.startswith("then/") else ""
            ordered = number if len(branches) > 1 and not branch else 0
            above[f"{path}/{branch_path}".lstrip("/")] = (path, branch, ordered)
        parent, branch, number = above.get(path, (None, "", 0))
        asked, here = node.question(), place + state.within(f"#{path}")
        offered = choices(asked, f"{here}/decision") if asked else ()
        words = f"{node.name}: {node.words()}" if node.name else node.words()
        yield Twig(path, parent, node.word, words, branch, offered, number)
