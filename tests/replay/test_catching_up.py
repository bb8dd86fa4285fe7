# SPDX-License-Identifier: Apache-2.0
"""A resumed run catches up: what has arrived counts at its instant, and what it asks for late has its whole time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.profile import dump_profile
from rai_missions.replay.open_run import open_run
from rai_missions.runtime.clock import ContinuedClock, SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from tests.rigs.runs import Rig, ScriptedWorld, mission, robot

Json = dict[str, Any]
WINDOW_S = 2.0
"""For so long a battery that no one reports any more is waited for."""
ENDS: Json = {"early": {"final": "canceled"}, "late": {"final": "failed"}}


def resumed(
    path: Path,
    states: Json,
    moments: Mapping[float, Callable[[Rig], object]],
    before: Iterable[Event] = (),
    **words: Any,
) -> list[Step]:
    """The steps of a run that was killed at 0 s, with a battery that was known and after what came `before`."""
    killed = mission({**states, **ENDS})
    chart = Chart(killed)
    with Journal.create(path, Header(dump(killed), dump_profile(robot()), run="run")) as journal:
        journal.write(chart.start(), since=0.0)
        journal.write(chart.write("battery", 0.5), since=0.0)
        for event in before:
            journal.write(chart.send(event), since=0.0)
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Rig(killed, journal=journal, begin=taken.resumption, **words)
        rig.stage.play({at: lambda do=do: do(rig) for at, do in moments.items()})  # type: ignore[misc]
        rig.run()
    taken.record.close()
    return rig.steps


def reached(steps: list[Step]) -> tuple[str, float]:
    """The final that a run came to, and when."""
    last = next(step for step in steps if step.outcome is not None)
    return last.entered[-1], last.at


@pytest.mark.parametrize(("at", "expected"), [(0.5, "early"), (1.5, "late")])
def test_an_event_and_a_timer_happen_in_the_order_of_their_instants(tmp_path: Path, at: float, expected: str) -> None:
    waiting = {"waiting": {"transitions": [{"on": "go", "to": "early"}, {"after_s": 1, "to": "late"}]}}
    assert reached(resumed(tmp_path / "run.journal", waiting, {at: lambda rig: rig.post("go")}))[0] == expected


def test_a_fact_that_was_not_known_counts_when_it_arrives(tmp_path: Path) -> None:
    waiting = {"waiting": {"transitions": [{"when": {"key": "there", "==": True}, "to": "early"},
                                           {"after_s": 1, "to": "late"}]}}  # fmt: skip
    for at, expected in ((0.5, "early"), (1.5, "late")):
        moments = {at: lambda rig: rig.publish("/there", data=True)}
        assert reached(resumed(tmp_path / f"{at}.journal", waiting, moments))[0] == expected


def test_control_that_is_asked_for_late_may_come_late(tmp_path: Path) -> None:
    states = {"waiting": {"transitions": [{"on": "go", "to": "honking"}]},
              "honking": {"call": "horn", "timeout_s": 0.5, "control": "agent", "handover_s": 1,
                          "transitions": [{"on": "succeeded", "to": "early"},
                                          {"on": ["rejected", "timed_out"], "to": "late"}]}}  # fmt: skip
    steps = resumed(tmp_path / "run.journal", states, {0.5: lambda rig: rig.post("go")})
    assert reached(steps) == ("early", WINDOW_S)


def test_a_timeout_in_a_tree_over_a_call_that_is_made_late_counts_from_the_call(tmp_path: Path) -> None:
    tree = {"timeout": 0.5, "child": {"call": "horn"}}
    states = {"waiting": {"transitions": [{"on": "go", "to": "honking"}]},
              "honking": {"tree": tree, "transitions": [{"on": "succeeded", "to": "early"},
                                                        {"on": "failed", "to": "late"}]}}  # fmt: skip
    steps = resumed(tmp_path / "run.journal", states, {0.5: lambda rig: rig.post("go")})
    assert reached(steps) == ("early", WINDOW_S)


def test_a_cancel_that_is_sent_late_may_be_confirmed_late(tmp_path: Path) -> None:
    states = {"moving": {"action": "move", "transitions": [{"on": "go", "to": "turning"}]},
              "turning": {"action": "turn", "transitions": [{"on": "succeeded", "to": "early"},
                                                            {"on": "rejected", "to": "late"}]}}  # fmt: skip

    def turned(rig: Rig) -> None:
        rig.turn.report("succeeded")

    words = {"cancel_s": 1}
    steps = resumed(
        tmp_path / "run.journal",
        {**states, "moving": {**states["moving"], **words}},
        {0.5: lambda rig: rig.post("go"), 2.5: turned},
    )
    assert reached(steps)[0] == "early"


class Thinker:
    """Needs more time for its answer than a run that was held up would leave."""

    def __init__(self) -> None:
        self.answer: Callable[[Mapping[str, Any]], None] = lambda reported: None
        self.until: list[float] = []

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.until.append(question.until)
        self.answer = answer

    def withdraw(self, number: int) -> None:
        """It does not mind."""


def test_a_question_that_is_asked_again_has_the_time_that_was_left(tmp_path: Path) -> None:
    asking = {"asking": {"decision": {"question": "On?", "options": {"on": {"about": "on"}, "off": {"about": "off"}},
                                      "ask": ["someone"], "deadline_s": 3, "fallback": "off"},
                         "transitions": [{"on": "on", "to": "early"}, {"on": "off", "to": "late"}]}}  # fmt: skip
    thinker = Thinker()
    moments = {4.5: lambda rig: thinker.answer({"option": "on"})}
    steps = resumed(tmp_path / "run.journal", asking, moments, answerers={"someone": thinker})
    assert thinker.until == [5.0]
    assert reached(steps)[0] == "early"


def moving(settle_s: float, *, is_leaf: bool = False) -> Json:
    """A state, or the leaf of a tree, that moves until it is there."""
    move = {"action": "move", "achieved": {"key": "there", "==": True}, "settle_s": settle_s}
    ends = [{"on": "succeeded", "to": "early"}, {"on": ["unverified", "failed"], "to": "late"}]
    return {"moving": {**({"tree": move} if is_leaf else move), "transitions": ends}}


def is_there(rig: Rig) -> None:
    rig.publish("/there", data=True)


@pytest.mark.parametrize("settle_s", [0, 0.5])
def test_a_result_that_comes_before_its_facts_is_no_failure(tmp_path: Path, settle_s: float) -> None:
    moments = {0.5: lambda rig: rig.move.report("succeeded"), 1.5: is_there}
    assert reached(resumed(tmp_path / "run.journal", moving(settle_s), moments)) == ("early", 1.5)


@pytest.mark.parametrize("is_leaf", [False, True])
def test_a_result_whose_facts_were_awaited_is_no_failure(tmp_path: Path, is_leaf: bool) -> None:
    before = [Event("succeeded", 0.0, {}, "result", 1)]
    steps = resumed(tmp_path / "run.journal", moving(0.5, is_leaf=is_leaf), {1.5: is_there}, before)
    assert reached(steps) == ("early", 1.5)


def test_a_step_that_asks_for_nothing_late_states_it_to_a_replay(tmp_path: Path) -> None:
    waiting = {"waiting": {"transitions": [{"after_s": 1, "to": "late"}]}}
    steps = resumed(tmp_path / "run.journal", waiting, {})
    data = next(step.event.data for step in steps if step.event.name == "take_up")
    assert data["present"] == WINDOW_S


@given(st.floats(0, 1e5), st.floats(0, 1e5), st.floats(0, 100))
def test_a_resumed_run_that_has_waited_until_an_instant_is_there(before: float, start: float, wait_s: float) -> None:
    """Rounding must not leave it just before: nothing else moves simulated time, and it would wait for ever."""
    mailbox, world = Mailbox(), SimulatedClock()
    world.wait(mailbox, before, paced=False)
    clock = ContinuedClock(world, start)
    clock.wait(mailbox, start + wait_s, paced=False)
    assert clock.now() >= start + wait_s


def test_the_time_of_a_resumed_run_begins_when_it_looks() -> None:
    stage, mailbox = ScriptedWorld(), Mailbox()
    clock = ContinuedClock(SimulatedClock(stage), 7.0)
    for _ in range(30):
        stage.step()
    assert clock.now() == 7.0, "to connect costs it nothing"
    clock.wait(mailbox, 8.0, paced=False)
    assert clock.now() == pytest.approx(8.0)
    assert stage.at == pytest.approx(4.0)
    mailbox.post(Event("go", 0.0))
    clock.begin()
    assert clock.now() == pytest.approx(8.0), "it begins once"
