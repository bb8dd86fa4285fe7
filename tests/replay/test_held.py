# SPDX-License-Identifier: Apache-2.0
"""A run that is held survives its process, and a migration: nothing fails because a person took control meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.open_run import open_run
from tests.replay.farm import Farm
from tests.replay.mortal import Fate, Wish, live
from tests.replay.test_kills import Ended, holds, lived

TAKEN_S, BACK_S = 1.0, 30.0
DOCUMENT: dict[str, Any] = {
    "name": "taken", "version": "1.0.0", "initial": "moving", "events": {"go": {}},
    "states": {
        "moving": {"action": "move", "control": "autonomy", "timeout_s": 8, "handover_s": 2,
                   "transitions": [{"on": "go", "to": "waiting"}]},
        "waiting": {"control": "agent", "handover_s": 2, "transitions": [{"after_s": 4, "to": "over"}]},
        "over": {"final": "canceled"},
    },
}  # fmt: skip
STATES = DOCUMENT["states"]
MISSION = Mission.model_validate(DOCUMENT)
ROBOT = Robot.model_validate(
    {
        "name": "watched",
        "actions": {"move": {"action": "/move", "type": "x/action/X", "uses": ["base"]}},
        "events": {"go": {"posted": True}},
        "control": {holder: f"/to_{holder}" for holder in ("agent", "autonomy", "operator", "nobody")},
        "holder": {"topic": "/holder", "type": "std_msgs/msg/String"},
    }
)
ENDED = Ended("canceled", "'over' was reached")


def farm() -> Farm:
    """The operator takes control, someone reports `go`, and the operator gives control back."""
    there = Farm(lasts_s={"move": 6.0})

    def hand(to: str) -> Any:
        return lambda runner: there._hand_over(to)

    there._wishes += [
        Wish(TAKEN_S, hand("operator"), lambda runner: runner.view.held_by == "operator"),
        Wish(2.0, lambda runner: runner.post(Event("go")), lambda runner: bool(runner.view.snapshot()["_kept"])),
        Wish(BACK_S, hand("autonomy"), lambda runner: not runner.view.held_by),
    ]
    return there


@pytest.fixture(scope="module")
def things(tmp_path_factory: pytest.TempPathFactory) -> int:
    """How much a run does that no one kills; it ends as it should, and later for as long as it was held."""
    there, fate = farm(), Fate()
    result = live(tmp_path_factory.mktemp("whole") / "run.journal", there, MISSION, ROBOT, {}, fate)
    assert result is not None and Ended(result.outcome, result.why) == ENDED
    assert BACK_S + 4.0 <= there.at <= BACK_S + 6.0
    return fate.count


@pytest.mark.parametrize("every", [11, pytest.param(1, marks=pytest.mark.drill)])
@pytest.mark.parametrize("dead_s", [0.0, 7.0])
def test_a_run_that_is_killed_while_it_is_held_continues_and_fails_for_nothing(
    tmp_path: Path, things: int, dead_s: float, every: int
) -> None:
    """Right before and right after every so manyth thing that it does, some of them twice."""
    for turn in range(0, 2 * things, every):
        at, is_done = divmod(turn, 2)
        path, there = tmp_path / f"{turn}.journal", farm()
        fates = [Fate(at, is_done=bool(is_done)), *[Fate(turn // 3)] * (turn % 3 == 1)]
        assert lived(path, there, fates, MISSION, ROBOT, dead_s, {}) == ENDED, (turn, things)
        holds(path, there, MISSION)


def held_in(path: Path) -> tuple[str, frozenset[str]]:
    """By whom a run that was cut short is held, and which of its states are."""
    taken = open_run(path)
    taken.record.close()
    return taken.resumption.chart.held_by, taken.resumption.chart.held


def migrated(path: Path, there: Farm, mission: Mission, waits: int, **words: Any) -> Path:
    """A run that was killed in its hold, in another mission."""
    assert live(path, there, MISSION, ROBOT, {}, Fate(waits, what="wait")) is None
    assert held_in(path) == ("operator", {"moving"})
    return migrate(path, mission, Map(**words), to=path.with_name("new.journal")).journal


def changed(**states: Any) -> Mission:
    return Mission.model_validate({**DOCUMENT, "version": "2.0.0", "states": {**DOCUMENT["states"], **states}})


@pytest.mark.parametrize("waits", [2, 3])
def test_a_run_that_is_migrated_while_it_is_held_stays_held_and_continues(tmp_path: Path, waits: int) -> None:
    there, now = farm(), changed(over={"final": "aborted"})
    path = migrated(tmp_path / "run.journal", there, now, waits)
    assert held_in(path) == ("operator", {"moving"})
    result = live(path, there, now, ROBOT, {}, Fate())
    assert result is not None and (result.outcome, result.why) == ("aborted", "'over' was reached")
    assert BACK_S + 4.0 <= there.at <= BACK_S + 8.0
    holds(path, there, now)


def test_a_held_state_that_is_renamed_by_a_migration_is_held_under_its_new_name(tmp_path: Path) -> None:
    there, states = farm(), {("driving" if name == "moving" else name): each for name, each in STATES.items()}
    now = Mission.model_validate({**DOCUMENT, "version": "2.0.0", "states": states, "initial": "driving"})
    path = migrated(tmp_path / "run.journal", there, now, 3, states={"moving": "driving"})
    assert held_in(path) == ("operator", {"driving"})
    result = live(path, there, now, ROBOT, {}, Fate())
    assert result is not None and Ended(result.outcome, result.why) == ENDED
    holds(path, there, now)
