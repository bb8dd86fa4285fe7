# SPDX-License-Identifier: Apache-2.0
"""What holds whenever the operator takes control and gives it back: for what needs it, a hold is a pause."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import Handover, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.laws.test_chart import happenings
from tests.oracles.documents import Taste, charts
from tests.oracles.documents import scripts as plain_scripts
from tests.rigs.charts import ScriptedRobot
from tests.rigs.laws import drill
from tests.strategies import mission_documents

Json = dict[str, Any]
Script = list[tuple[tuple[Any, ...], float]]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
PASSING = ("seq", "_wake", "_quick", "_listening", "_held_since", "_paused_at", "event")
"""What a snapshot reports about the way rather than of where it led."""
KEPT = ("accepted", "result", "proposal", "event", "write", "tick")


def under(control: str, document: Json) -> Json:
    """The same mission, each state of which needs the control of one."""

    def states(room: Json) -> Json:
        return {name: state(each) for name, each in room.items()}

    def state(given: Json) -> Json:
        inner: Json = {word: states(given[word]) for word in ("states", "parallel") if word in given}
        return {**{word: value for word, value in given.items() if word != "control"}, **inner}

    left = {word: value for word, value in document.items() if word not in ("transitions", "invariants")}
    rooms = {name: {**each, "control": control} for name, each in states(document["states"]).items()}
    return {**left, "states": rooms}


class Play:
    """A chart that is stopped, for a while, while things happen; every word that stops it has one that does the rest.

    Args:
        document: The mission.
        stop: What stops it.
        go: What has it continue.
    """

    def __init__(self, document: Json, stop: Event, go: Event) -> None:
        self.chart, self.robot, self.stops = (
            Chart(Mission.model_validate(document), CompiledTrees()),
            ScriptedRobot(),
            (stop, go),
        )
        self.steps: list[Step] = []
        self.at = 0.0
        self.chart.send(Event("agent", 0.0, {"by": "robot"}, "control"))
        self.receive(self.chart.start(0.0))

    def receive(self, step: Step) -> None:
        self.steps.append(self.robot.follow(step))

    def play(self, script: Script) -> None:
        """What was drawn; a command stops it where it runs, and has it continue where it does not."""
        stopped = False
        for drawn, wait in script:
            self.at += wait
            event = self.robot.event(drawn, self.at)
            if drawn[0] == "command":
                event, stopped = self.stops[stopped]._replace(at=self.at), not stopped
            self.receive(self.chart.send(event))
        if stopped:
            self.receive(self.chart.send(self.stops[1]._replace(at=self.at)))

    def state(self) -> Json:
        return {name: value for name, value in self.chart.snapshot().items() if name not in PASSING}


def stops() -> st.SearchStrategy[Script]:
    """What happens, with many an instant at which the mission is stopped, or continues."""
    return happenings(commands=False).flatmap(
        lambda script: st.lists(st.integers(0, len(script)), max_size=6).map(lambda places: cut(script, places))
    )


def cut(script: Script, places: list[int]) -> Script:
    made = [(drawn, wait) for drawn, wait in script if drawn[0] in KEPT]
    for place in sorted(places, reverse=True):
        made.insert(min(place, len(made)), (("command", "stop"), 1.0))
    return made


HELD = (mission_documents(), stops(), st.sampled_from(["operator", "nobody"]))
"""A mission, what happens to it, and who holds it up."""


def holds_like_a_pause(document: Json, script: Script, holder: str) -> None:
    document = under("agent", document)
    held = Play(
        document,
        Event(holder, data={"by": "operator", "role": "operator"}, kind="control"),
        Event("agent", data={"by": "operator", "role": "operator"}, kind="control"),
    )
    paused = Play(document, Event("pause", kind="command"), Event("resume", kind="command"))
    for each in (held, paused):
        each.play(script)
    assert held.state() == paused.state()
    assert [step.moves for step in held.steps] == [step.moves for step in paused.steps]
    assert not any(isinstance(effect, Handover) for step in held.steps for effect in step.effects)


@lenient
@given(*HELD)
def test_for_what_needs_control_a_hold_is_a_pause(document: Json, script: Script, holder: str) -> None:
    holds_like_a_pause(document, script, holder)


test_for_what_needs_control_a_hold_is_a_pause_however_often_it_is_tried = drill(
    holds_like_a_pause, *HELD, tried=settings(lenient, max_examples=3000)
)


# -- a hold makes no difference but of time -------------------------------------------------------------------------

TASTE = Taste(delayed=True, outcomes=True)


def waits_out(document: Json, script: list[tuple[Any, ...]], holds: list[tuple[int, float]]) -> None:
    """The run with holds cut in is the run without, later."""
    document = under("agent", document)
    one, other = (Chart(Mission.model_validate(document)) for _ in range(2))
    moves: list[list[Any]] = [[], []]
    for chart, ours in zip((one, other), moves, strict=True):
        chart.send(Event("agent", 0.0, {"by": "robot"}, "control"))
        ours.extend(chart.start(0.0).moves)
    at, late = 0.0, 0.0
    for index, (word, what, wait) in enumerate(script):
        at += wait
        moves[0] += one.send(_event(word, what, at)).moves
        part = wait / (1 + sum(place == index for place, _ in holds))
        here = at - wait
        for _, long in (each for each in holds if each[0] == index):
            here += part
            for to, then in (("operator", here + late), ("agent", here + late + long)):
                moves[1] += other.send(Event(to, then, {"by": "operator", "role": "operator"}, "control")).moves
            late += long
        moves[1] += other.send(_event(word, what, at + late)).moves
    assert moves[0] == moves[1] and (one.active, one.outcome) == (other.active, other.outcome)


def _event(word: str, what: Any, at: float) -> Event:
    if word == "write":
        return Event(what[0], at, {"value": what[1]}, "write")
    return Event(what, at) if word == "event" else Tick(at)


# -- given back in a pause ------------------------------------------------------------------------------------------


def ends_in_a_pause(document: Json, script: Script, holder: str) -> None:
    """It makes no difference whether the operator gives control back in a pause that ends then."""
    document = under("agent", document)
    stop = Event(holder, data={"by": "operator", "role": "operator"}, kind="control")
    go = Event("agent", data={"by": "operator", "role": "operator"}, kind="control")
    one, other = Play(document, stop, go), Pausing(document, stop, go)
    for each in (one, other):
        each.play(script)
    assert one.state() == other.state()


class Pausing(Play):
    """Someone pauses it as soon as it is held, and resumes it once control is given back."""

    def receive(self, step: Step) -> None:
        super().receive(step)
        chart = self.chart
        if chart.mode == ("running" if chart.held_by else "paused"):
            super().receive(chart.send(Event("pause" if chart.held_by else "resume", chart.at, kind="command")))


@lenient
@given(*HELD)
def test_a_pause_within_a_hold_makes_no_difference(document: Json, script: Script, holder: str) -> None:
    ends_in_a_pause(document, script, holder)


test_a_pause_within_a_hold_makes_no_difference_however_often_it_is_tried = drill(
    ends_in_a_pause, *HELD, tried=settings(lenient, max_examples=3000)
)


def long_holds() -> st.SearchStrategy[list[tuple[int, float]]]:
    return st.lists(st.tuples(st.integers(0, 8), st.sampled_from([0.0, 4.0, 64.0, 1024.0])), max_size=4)


@lenient
@given(charts(TASTE), plain_scripts(timed=True, writes=True), long_holds())
def test_a_hold_makes_no_difference_but_of_time(
    document: Json, script: list[tuple[Any, ...]], holds: list[tuple[int, float]]
) -> None:
    waits_out(document, script, holds)


test_a_hold_makes_no_difference_but_of_time_however_often_it_is_tried = drill(
    waits_out,
    charts(TASTE),
    plain_scripts(timed=True, writes=True),
    long_holds(),
    tried=settings(lenient, max_examples=3000),
)


# -- in part held ---------------------------------------------------------------------------------------------------


def controls() -> st.SearchStrategy[list[tuple[int, str, str]]]:
    """Where in a script control changes hands, to whom, and by whom."""
    hands = st.sampled_from(["operator", "operator", "nobody", "autonomy", "agent"])
    return st.lists(st.tuples(st.integers(0, 14), hands, st.sampled_from(["operator", "robot"])), max_size=5)


def transitions(document: Json) -> Iterator[tuple[str, str]]:
    """The place of each state, and its name."""

    def inside(room: Json, place: str) -> Iterator[tuple[str, str]]:
        for name, state in room.items():
            yield f"{place}/{name}", name
            for word in ("states", "parallel"):
                yield from inside(state.get(word, {}), f"{place}/{name}/{word}")

    return inside(document["states"], "/states")


def leaves_alone_what_is_held(document: Json, script: Script, hands: list[tuple[int, str, str]]) -> None:
    names = dict(transitions(document))
    chart, robot, at = Chart(Mission.model_validate(document), CompiledTrees()), ScriptedRobot(), 0.0
    robot.follow(chart.start(0.0))
    for index, (drawn, wait) in enumerate(script):
        at += wait
        held = chart.held
        step = robot.follow(chart.send(robot.event(drawn, at)))
        if chart.held_by:  # else it was given back, and takes what it missed
            taken = {names.get(place.rpartition("/transitions/")[0]) for move in step.moves for place in move.taken}
            assert not taken & held, "a held state takes no transition"
            assert not any(isinstance(effect, Handover) for effect in step.effects), "control is not asked for"
        for _, to, by in (each for each in hands if each[0] == index):
            role = {"role": "operator"} if by == "operator" else {}
            robot.follow(chart.send(Event(to, at, {"by": by, **role}, "control")))
    given = Event("autonomy", at + 1.0, {"by": "operator", "role": "operator"}, "control")
    robot.follow(chart.send(given))
    assert not chart.held and not chart.snapshot()["_kept"] and not chart.snapshot()["_laid_by"]


@lenient
@given(mission_documents(), happenings(commands=False), controls())
def test_a_held_state_does_nothing_until_it_is_given_back(
    document: Json, script: Script, hands: list[tuple[int, str, str]]
) -> None:
    leaves_alone_what_is_held(document, script, hands)


test_a_held_state_does_nothing_until_it_is_given_back_however_often_it_is_tried = drill(
    leaves_alone_what_is_held,
    mission_documents(),
    happenings(commands=False),
    controls(),
    tried=settings(lenient, max_examples=3000),
)
