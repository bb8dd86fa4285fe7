# SPDX-License-Identifier: Apache-2.0
"""What can happen to a mission now: every event that the chart would not refuse, with the values that it takes.

Rule: what is offered was tried on a branch of the chart, and changed something there; what it does is never guessed.
Rule: facts, and the passing of time, are always offered: that they change nothing now is an answer, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import GOAL_ENDS
from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.activities.behaviour import BehaviourActivity
from rai_missions.engine.activities.call import replies_to
from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree import TreeActivity, TreeMachine
from rai_missions.engine.decision import Offer, Question
from rai_missions.engine.semantics.hold import live
from rai_missions.engine.semantics.reports import WATCHED
from rai_missions.engine.state import TABLE
from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import UsageError
from rai_missions.event import Event, EventKind, Tick
from rai_missions.keys import Key, type_error
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import is_number
from rai_missions.replay.play.choice import ChoiceKind, Input, Passage, PlayChoice, perform
from rai_missions.replay.play.fields import (
    Field,
    arguments_of,
    assembled,
    key_fields,
    key_values,
    operands,
    parameter_fields,
)
from rai_missions.replay.play.passage import fading, next_change
from rai_missions.states.control import CONTROLLERS, HOLDERS
from rai_missions.states.decision import answerer_words

__all__ = ("OpenChoices", "settled")

COMMANDS = {
    "pause": "the operator pauses the mission", "resume": "the operator resumes the mission",
    "cancel": "the operator cancels the mission", "kill": "the operator presses the e-stop",
}  # fmt: skip
UNCHANGED = frozenset({"past", "passing", "number", "payload"})
"""What a run remembers that any step changes."""
WHY = Field("why", "string", None, False, about="the reason, in words")
MOST_ROUNDS = 3
INVALID = "?"
"""The name of no option."""


class RunningActivity(NamedTuple):
    """An activity that runs, or a leaf of a tree."""

    owner: str
    machine: Machine
    state: Any


class OpenChoices:
    """Finds what can happen to a mission.

    Args:
        mission: One that `check` finds no error in.
    """

    def __init__(self, mission: Mission) -> None:
        self._mission, self._examples = mission, operands(mission)
        self._has_control = any(state.control is not None for _, _, state in mission.walk())
        self._payloads = _payloads(mission)

    def now(self, chart: Chart, started: Mapping[int, StartGoal]) -> list[PlayChoice]:
        """Everything that can happen now, what is rare last.

        Args:
            chart: The run.
            started: Number → the goals that were started in it.
        """
        base = settled(chart)
        tried = (tested(base, choice) for choice in self._possible(chart, started))
        found = [choice for choice in tried if choice is not None]
        return sorted(found, key=lambda choice: (choice.is_rare, not choice.is_awaited))

    def _possible(self, chart: Chart, started: Mapping[int, StartGoal]) -> Iterator[PlayChoice]:
        yield from self._start(chart)
        yield from self._answers(chart)
        yield from self._reports(chart, started)
        yield from self._events()
        yield from self._keys(chart)
        yield from self._time(chart)
        yield from self._control(chart)
        for name, words in COMMANDS.items():
            yield _of(Event(name, kind="command", data={"by": "operator"}), "command", words)

    # -- before the start, and what is known ----------------------------------------------------------------------

    def _start(self, chart: Chart) -> Iterator[PlayChoice]:
        if chart.mode != "ready":
            return
        keys = self._mission.blackboard
        given = {name: keys[name] for name in self._mission.needed_arguments() if name not in chart.view.board}
        facts = {name: keys[name] for name in chart.unreported}
        if not given and not facts:
            yield _of(Event("start", kind="command"), "start", "the mission starts")._replace(is_awaited=True)
        if given:
            named = f"argument {next(iter(given))} is" if len(given) == 1 else f"arguments {', '.join(given)} are"
            words, about = f"the {named} given", "a run is refused without"
            yield self._writing("arguments", words, given, chart)._replace(kind="start", about=about, is_awaited=True)
        if facts:
            about = "a run waits for them before it starts"
            words = f"the robot reports {', '.join(facts) if len(facts) < 4 else f'its {len(facts)} facts'}"
            yield self._writing("readings", words, facts, chart)._replace(kind="start", about=about, is_awaited=True)

    def _keys(self, chart: Chart) -> Iterator[PlayChoice]:
        fresh = fading(chart)
        for name, key in self._mission.blackboard.items():
            if key.source == "robot" or (key.source == "argument" and chart.unstarted):
                words = f"the robot reports {name}" if key.source == "robot" else f"the argument {name} is given"
                yield self._writing(f"key {name}", words, {name: key}, chart)._replace(about=key.about, key=name)
        for name, end in fresh.items() if not chart.unstarted and chart.outcome is None else ():
            passage = partial(_pass, until=end, but=(name,))
            about = f"until {end:.3g} s"
            yield PlayChoice(f"stale {name}", "stale", f"{name} goes stale", passage, about=about, key=name)

    def _writing(self, name: str, words: str, keys: Mapping[str, Key], chart: Chart) -> PlayChoice:
        board = chart.view.board
        fields = tuple(
            field
            for each, key in keys.items()
            for field in key_fields(each, key, board[each].value if each in board else None, self._examples)
        )

        def inputs(now: Chart, given: Mapping[str, Any]) -> list[Input]:
            written = dict(key_values(keys, assembled(fields, given), now.at))
            for each, value in written.items():
                if why := type_error(keys[each], value, written=True):
                    raise UsageError(f"'{each}' is not written: {why}")
            return [Event(each, now.at, {"value": value}, "write") for each, value in written.items()]

        return PlayChoice(name, "key", words, inputs, fields)

    # -- events and time ------------------------------------------------------------------------------------------

    def _events(self) -> Iterator[PlayChoice]:
        for name, event in self._mission.events.items():
            kinds = {**dict.fromkeys(self._payloads.get(name, ()), "json"), **event.fields}
            fields, event_here = arguments_of(kinds), Event(name)
            yield _of(event_here, "event", f"event {name}", fields=fields)._replace(about=event.about)
        if "uncertain" in self._payloads:
            fields = arguments_of(dict.fromkeys(self._payloads["uncertain"], "json"))
            yield _of(Event("uncertain", kind="doubt"), "event", "no one knows whether it was done", fields=fields)

    def _time(self, chart: Chart) -> Iterator[PlayChoice]:
        due = next_change(chart)
        if chart.unstarted or (chart.outcome is not None and due is None):
            return
        if due is not None:
            words = f"time passes until something changes, in {due - chart.at:.3g} s"
            yield PlayChoice("next", "time", words, partial(_pass, until=due))
        seconds = Field("seconds", "number", 1.0, about="facts of the robot stay fresh meanwhile")
        yield PlayChoice("time", "time", "time passes", _wait, (seconds,))

    # -- reports --------------------------------------------------------------------------------------------------

    def _reports(self, chart: Chart, started: Mapping[int, StartGoal]) -> Iterator[PlayChoice]:
        pending = {number: each for each in inside(chart) for number in each.machine.awaits(each.state)}
        for goal in chart.state.goals.values():
            yield from self._goal(goal, pending.get(goal.number))
        for number in sorted(pending.keys() - chart.state.goals.keys()):
            each = pending[number]
            if isinstance(each.state, BehaviourActivity):
                for status in ("success", "failure"):
                    event = Event("behaviour", 0.0, {"status": status}, "behaviour", number)
                    words = f"the behaviour of {each.owner.rstrip('#')} ends: {status}"
                    yield _of(event, "behaviour", words, each.owner, name=f"behaviour {number} {status}")
            elif not isinstance(each.state, DecisionActivity):
                service = str(getattr(getattr(each.machine, "definition", None), "call", each.owner))
                yield from self._call(number, service, each)
        for number, service in chart.state.calls.items():
            yield from self._call(number, service, None)
        for number in sorted(started.keys() - chart.state.goals.keys()):
            goal_of = started[number]
            event = Event(goal_of.action, 0.0, {"owner": goal_of.owner}, "stray", number)
            yield _of(
                event,
                "goal",
                f"{goal_of.action} (goal {number}) executes, though its end was reported",
                goal_of.owner,
                name=f"goal {number} stray",
            )._replace(is_rare=True)

    def _goal(self, goal: Goal, pending: RunningActivity | None) -> Iterator[PlayChoice]:
        number, named = goal.number, f"{goal.action} (goal {goal.number})"
        if goal.phase in ("sent", "withdrawn"):
            event = Event(goal.action, 0.0, {}, "accepted", number)
            yield _of(event, "goal", f"{named} is accepted", goal.owner, name=f"goal {number} accepted")
        for end in GOAL_ENDS:
            event = Event(end, 0.0, {}, "result", number)
            fields = self._results(end, pending)
            yield _of(event, "goal", f"{named}: {end}", goal.owner, name=f"goal {number} {end}", fields=fields)
        for kind in _seldom(goal):
            event = Event(goal.action, 0.0, {}, kind, number)
            words = f"{named}: {WATCHED[kind]}"
            yield _of(event, "goal", words, goal.owner, name=f"goal {number} {kind}")._replace(is_rare=True)

    def _call(self, number: int, service: str, pending: RunningActivity | None) -> Iterator[PlayChoice]:
        owner = pending.owner if pending is not None else ""
        for reply in replies_to(pending.machine if pending is not None else None):
            event, words = Event(reply, 0.0, {}, "result", number), f"{service} (call {number}): {reply}"
            fields = self._results(reply, pending)
            yield _of(event, "call", words, owner, name=f"call {number} {reply}", fields=fields)

    def _results(self, end: str, pending: RunningActivity | None) -> tuple[Field, ...]:
        """What a report may bring along: what the mission keeps of it, what its transitions read, and why."""
        definition = getattr(pending.machine, "definition", None) if pending is not None else None
        kept: Mapping[str, str] = getattr(definition, "result", {}) if end == "succeeded" else {}
        keys = self._mission.blackboard
        kinds = {**dict.fromkeys(self._payloads.get(end, ()), "json")}
        kinds |= {field: keys[key].type if key in keys else "json" for key, field in kept.items()}
        return (*arguments_of(kinds), *(() if end == "succeeded" or "why" in kinds else (WHY,)))

    # -- answers and control --------------------------------------------------------------------------------------

    def _answers(self, chart: Chart) -> Iterator[PlayChoice]:
        for question in chart.questions:
            for offer in question.options:
                yield _answer(question, offer)
            words = f"{answerer_words(question.asked)} cannot answer"
            event = Event(question.asked, 0.0, {"absent": "no one is there"}, "proposal", question.number)
            yield _of(event, "answer", words, question.owner, name=f"answer {question.number} absent")._replace(
                is_awaited=True
            )
            event = Event(question.asked, 0.0, {"option": INVALID, "parameters": {}}, "proposal", question.number)
            words = f"{answerer_words(question.asked)} gives an answer that is no option"
            yield _of(event, "answer", words, question.owner, name=f"answer {question.number} invalid")._replace(
                is_awaited=True
            )

    def _control(self, chart: Chart) -> Iterator[PlayChoice]:
        if not self._has_control or chart.outcome is not None:
            return
        for holder in HOLDERS:
            named = CONTROLLERS[holder]
            is_asked = holder in chart.wanted
            if holder == "operator" and not chart.taken and not is_asked:
                words, by = "the operator takes control", "operator"
            elif holder == chart.holder:
                continue
            elif chart.held_by:
                words, by = f"the operator gives control to {named}", "operator"
            else:
                words, by = (f"control is with {named}{', as was asked' if is_asked else ''}", "mission")
            data = {"by": by, "role": "operator"} if by == "operator" else {"by": by}
            choice = _of(Event(holder, 0.0, data, "control"), "control", words, name=f"control {holder}")
            yield choice._replace(is_awaited=is_asked)


def _seldom(goal: Goal) -> tuple[EventKind, ...]:
    """What a goal's servers can do outside its course: refuse a cancel, be gone or be two, come back."""
    is_canceled, is_gone = goal.phase in ("canceling", "withdrawn", "orphaned"), goal.is_lost or goal.phase == "lost"
    found: tuple[EventKind, ...] = () if is_gone else ("lost", "contested")
    found += ("refused",) if is_canceled and not goal.is_refused else ()
    return (*found, "over") if is_gone or goal.phase in ("canceling", "orphaned") else found


def inside(chart: Chart) -> Iterator[RunningActivity]:
    """Every activity that runs, the leaves of trees by themselves."""
    for name, machine, state in live(chart.program, chart.state):
        if isinstance(state, TreeActivity) and isinstance(machine, TreeMachine):
            for path, leaf in state.leaves.items():
                yield RunningActivity(f"{name}#{path}", machine.leaf_machines[path].machine, leaf.state)
        else:
            yield RunningActivity(name, machine, state)


def settled(chart: Chart) -> Chart:
    """A branch of a chart on which nothing is due at this instant: what time does is no merit of an event."""
    base = chart.branch()
    for _ in range(MOST_ROUNDS):
        if base.wake_at is None or base.wake_at > base.at:
            break
        base.send(Tick(base.at))
    return base


def tested(chart: Chart, choice: PlayChoice) -> PlayChoice | None:
    """A choice, where the chart would take it, and something would be different then; else None.

    What it would bring with other values is not known: a choice of an event with values of its own is kept.
    """
    if choice.kind in ("key", "stale", "time", "start"):
        return choice if choice.kind != "key" or chart.outcome is None else None
    probe = chart.branch()
    steps = [step for given in choice.inputs(probe, {}) for step in perform(probe, given)]
    if any(step.refusal for step in steps):
        return None
    judged = [verdict for step in steps if (verdict := step.verdict) and verdict.option not in ("", INVALID)]
    refused = next((verdict.why for verdict in judged if not verdict.accepted), "")
    is_open = choice.kind == "event" and bool(choice.fields)
    return choice._replace(refused=refused) if is_open or has_changed(chart, probe, steps) else None


def has_changed(before: Chart, after: Chart, steps: list[Step]) -> bool:
    """Whether steps have done more than to let an instant pass."""
    if not all(step.ignored for step in steps):
        return True
    return any(
        getattr(before.state, name) != getattr(after.state, name) for name, _, holds in TABLE if holds not in UNCHANGED
    )


def _of(
    event: Event, kind: ChoiceKind, words: str, owner: str = "", *, name: str = "", fields: tuple[Field, ...] = ()
) -> PlayChoice:
    """The choice of one event, with the values that are given in its data."""
    return PlayChoice(
        name or f"{kind} {event.name}" if kind != "start" else "start",
        kind,
        words,
        _bringing(event, fields),
        fields,
        owner.partition("#")[0],
    )


def _bringing(event: Event, fields: tuple[Field, ...]) -> Callable[[Chart, Mapping[str, Any]], list[Input]]:
    def inputs(chart: Chart, given: Mapping[str, Any]) -> list[Input]:
        return [event._replace(at=chart.at, data={**event.data, **assembled(fields, given)})]

    return inputs


def _answer(question: Question, offer: Offer) -> PlayChoice:
    fields = parameter_fields(offer.parameters)

    def inputs(chart: Chart, given: Mapping[str, Any]) -> list[Input]:
        data = {"option": offer.name, "parameters": assembled(fields, given)}
        return [Event(question.asked, chart.at, data, "proposal", question.number)]

    name, words = f"answer {question.number} {offer.name}", f"{answerer_words(question.asked)} answers {offer.name}"
    return PlayChoice(name, "answer", words, inputs, fields, question.state, offer.about, is_awaited=True)


def _pass(chart: Chart, given: Mapping[str, Any], *, until: float, but: tuple[str, ...] = ()) -> list[Input]:
    assembled((), given)
    return [Passage(until, but)]


def _wait(chart: Chart, given: Mapping[str, Any]) -> list[Input]:
    seconds = given.get("seconds", 1.0)
    if not is_number(seconds) or not 0 < seconds < 1e9:
        raise UsageError(f"time passes by a number of seconds above 0, not {seconds!r}")
    return [Passage(chart.at + seconds)]


def _payloads(mission: Mission) -> dict[str, list[str]]:
    """Event or outcome → the fields of its payload that the transitions which it fires read."""
    found: dict[str, list[str]] = {}
    for _, transition in mission.every_transition():
        paths = [
            name.partition(".")[2]
            for part in transition.everything()
            for refers, name, _ in part.references()
            if refers.sort == "path" and name.startswith("event.")
        ]
        for trigger in transition.on:
            here = found.setdefault(trigger, [])
            here += [path.partition(".")[0] for path in paths if path.partition(".")[0] not in here]
    return found
