# SPDX-License-Identifier: Apache-2.0
"""A run that is killed at any instant continues where it was: each thing that it does is an instant to die at."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import read, verify
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.open_run import open_run
from rai_missions.replay.replay import replay
from rai_missions.runtime.result import Result
from tests.replay.mortal import Fate, Land, live
from tests.rigs.runs import ReplyingAnswerer

ROBOT = Robot.model_validate({
    "name": "tried",
    "actions": {"move": {"action": "/move", "type": "x/action/X", "uses": ["base"]},
                "turn": {"action": "/turn", "type": "x/action/X", "uses": ["base"]},
                "look": {"action": "/look", "type": "x/action/X", "uses": ["head"]}},
    "services": {"horn": {"service": "/horn", "type": "std_srvs/srv/Trigger", "repeat": True},
                 "lamp": {"service": "/lamp", "type": "std_srvs/srv/Trigger"}},
    "events": {"go": {"posted": True}},
    "topics": {"light": {"topic": "/lamp_topic", "type": "std_msgs/msg/Bool", "repeat": True}},
})  # fmt: skip
MISSION = Mission.model_validate({
    "name": "much", "initial": "first",
    "blackboard": {"rounds": {"type": "integer", "source": "mission", "initial": 0}},
    "states": {
        "first": {"action": "move", "timeout_s": 60, "entry": [{"set": "rounds", "add": 1}],
                  "transitions": [{"on": "succeeded", "to": "deciding"}]},
        "deciding": {"decision": {"question": "On?", "options": {"on": {"about": "on"}, "stop": {"about": "stop"}},
                                  "ask": ["someone"], "deadline_s": 30, "fallback": "stop"},
                     "transitions": [{"on": "on", "to": "both",
                                      "do": [{"publish": "light", "message": {"data": True}}]},
                                     {"on": "stop", "to": "given_up"}]},
        "both": {"parallel": {
            "body": {"initial": "turning", "states": {
                "turning": {"action": "turn", "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "turned"}]},
                "turned": {"final": "succeeded"}}},
            "head": {"initial": "looking", "states": {
                "looking": {"tree": {"sequence": [{"action": "look", "timeout_s": 20}, {"call": "horn"},
                                                  {"wait_s": 2}]},
                            "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "looked"}]},
                "looked": {"final": "succeeded"}}}},
            "transitions": [{"on": "succeeded", "to": "waiting"}]},
        "waiting": {"transitions": [{"after_s": 5, "to": "again"}]},
        "again": {"transitions": [{"when": {"key": "rounds", "<": 2}, "to": "first"},
                                  {"when": {"key": "rounds", ">=": 2}, "to": "honking"}]},
        "honking": {"call": "horn", "timeout_s": 5, "transitions": [{"on": "succeeded", "to": "over"}]},
        "over": {"final": "succeeded", "requires": {"key": "rounds", "==": 2}},
        "given_up": {"final": "aborted"}},
})  # fmt: skip


def land() -> Land:
    return Land([], {"move": 3.0, "turn": 4.0, "look": 2.0}, {})


class Ended(NamedTuple):
    """How a run ended, as its journal has it."""

    outcome: str | None
    why: str


def lived(
    path: Path,
    there: Land,
    fates: list[Fate],
    mission: Mission = MISSION,
    robot: Robot = ROBOT,
    dead_s: float = 0.0,
    answerers: Mapping[str, Any] | None = None,
    named: Mapping[str, Any] | None = None,
) -> Ended:
    """Die as often as there are fates, then live to the end; between two lives the robot is alone for a while."""
    answerers = answerers if answerers is not None else {"someone": ReplyingAnswerer("on")}
    for fate in (*fates, Fate()):
        if path.exists() and has_ended(path, mission, named):
            break
        if live(path, there, mission, robot, answerers, fate, named) is not None:
            break
        for _ in range(int(dead_s / there.period_s)):
            there.step()
    replayed = replay(path, mission=mission)
    return Ended(replayed.outcome, replayed.why)


def has_ended(path: Path, mission: Mission | None = None, named: Mapping[str, Any] | None = None) -> bool:
    with read(path) as record:
        last = record.last()
    if last is None or last.step.outcome is None:
        return False
    try:
        open_run(path, mission=mission, named=named).record.close()
    except UsageError:
        return True
    return False


def entered(path: Path) -> list[str]:
    with read(path) as record:
        return [name for step in record.steps() for name in step.entered]


def holds(path: Path, there: Land, mission: Mission | None = None) -> None:
    """What is so after any number of deaths."""
    with read(path) as record:
        steps = [step.seq for step in record.steps()]
    assert steps == sorted(set(steps)), "no step was lost and none was done twice"
    assert verify(path) == ()
    replayed = replay(path, mission=mission)
    assert replayed.holds, replayed.difference
    goals = [goal_id for _, goal_id in there.started]
    assert len(goals) == len(set(goals)), "no goal was started twice"
    assert there.running == [], "no goal runs without an owner"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, list[str], list[str], int]:
    """The run without a death: its result, the states entered, the actions started, the things it did."""
    path, there, fate = tmp_path_factory.mktemp("whole") / "run.journal", land(), Fate()
    result = live(path, there, MISSION, ROBOT, {"someone": ReplyingAnswerer("on")}, fate)
    assert result is not None and result.outcome == "succeeded"
    return result, entered(path), [action for action, _ in there.started], fate.count


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.drill)])
def test_whatever_it_was_doing_when_it_was_killed_the_run_ends_as_if_it_had_not_been(
    tmp_path: Path, undisturbed: tuple[Result, list[str], list[str], int], every: int
) -> None:
    """Right before and right after every so manyth thing that it does."""
    result, states, actions, things = undisturbed
    assert things > 40
    for turn in range(0, 2 * things, every):
        at, is_done = divmod(turn, 2)
        path, there = tmp_path / f"{turn}.journal", land()
        ended = lived(path, there, [Fate(at, is_done=bool(is_done))])
        where = f"killed {'after' if is_done else 'before'} {at} of {things}"
        assert ended == (result.outcome, result.why), where
        assert sorted(entered(path)) == sorted(states), where
        assert sorted(action for action, _ in there.started) == sorted(actions), where
        holds(path, there)


@settings(deadline=None, max_examples=10)
@given(
    st.lists(st.tuples(st.integers(0, 60), st.booleans()), min_size=2, max_size=6), st.sampled_from([0.0, 1.0, 20.0])
)
def test_it_may_be_killed_again_and_again_also_while_it_takes_itself_up(
    tmp_path_factory: pytest.TempPathFactory, deaths: list[tuple[int, bool]], dead_s: float
) -> None:
    path, there = tmp_path_factory.mktemp("often") / "run.journal", land()
    ended = lived(path, there, [Fate(at, is_done=is_done) for at, is_done in deaths], dead_s=dead_s)
    assert ended.outcome == "succeeded"
    holds(path, there)


CALLING = Mission.model_validate({
    "name": "calling", "initial": "lighting",
    "states": {
        "lighting": {"call": "lamp", "timeout_s": 5, "transitions": [
            {"on": "uncertain", "to": "unsure"}, {"on": "succeeded", "to": "done"}]},
        "unsure": {"final": "aborted"},
        "done": {"final": "canceled"}},
})  # fmt: skip


@pytest.mark.parametrize("is_done", [False, True], ids=["before", "after"])
def test_what_may_not_be_done_twice_is_done_once_at_most_and_doubt_is_reported(
    tmp_path: Path, *, is_done: bool
) -> None:
    outcomes = set()
    for at in range(12):
        path, there = tmp_path / f"{at}.journal", land()
        ended = lived(path, there, [Fate(at, is_done=is_done)], CALLING)
        assert there.called["/lamp"] <= 1
        assert ended.outcome != "canceled" or there.called["/lamp"] == 1, "nothing is reported as done that was not"
        outcomes.add(ended.outcome)
        holds(path, there)
    assert outcomes == {"aborted", "canceled"}


WAITING = Mission.model_validate({
    "name": "waiting", "initial": "waiting",
    "states": {"waiting": {"transitions": [{"after_s": 20, "to": "done"}]}, "done": {"final": "canceled"}},
})  # fmt: skip


@settings(deadline=None, max_examples=12)
@given(st.lists(st.integers(0, 12), min_size=1, max_size=5))
def test_a_timer_has_the_time_that_was_left(tmp_path_factory: pytest.TempPathFactory, deaths: list[int]) -> None:
    path, there = tmp_path_factory.mktemp("wait") / "run.journal", land()
    lived(path, there, [Fate(at, is_done=True) for at in deaths], WAITING)
    assert 20 <= there.at <= 20 + 1.5 * len(deaths), "no more is lost than what no row held yet"


def test_a_mission_that_has_changed_meanwhile_is_not_continued_with(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    assert live(path, land(), WAITING, ROBOT, {}, Fate(5)) is None
    with pytest.raises(DefinitionError, match="the mission has changed since the run began"):
        open_run(path, mission=CALLING)
    with pytest.raises(DefinitionError, match="the robot profile has changed since the run began: actions"):
        open_run(path, robot=ROBOT.model_copy(update={"actions": {}}))
    open_run(path, mission=WAITING, robot=ROBOT).record.close()
