# SPDX-License-Identifier: Apache-2.0
"""A stop or pause that comes before the start: nothing moves until it is taken back, however it came."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.replay.replay import replay
from rai_missions.replay.resume import resumption
from rai_missions.runtime.run_options import NewRun
from tests.rigs.runs import KEYS, Rig, mission

STATES: dict[str, Any] = {
    "moving": {"action": "move", "timeout_s": 5, "transitions": [{"on": ["timed_out", "failed"], "to": "over"}]},
    "over": {"final": "aborted"},
}
LATE_S = 0.4
"""When the robot reports what the mission needs to know before it starts."""
NEEDY = mission(STATES, blackboard={**KEYS, "there": {"type": "boolean", "source": "robot"}})
LAST = 0.9
"""When a run of these tests is canceled."""


def moved(rig: Rig) -> list[str]:
    """The goals that the robot was sent, as words."""
    return ["goal"] * len(rig.move.goals)


@pytest.mark.parametrize("command", ["stop", "pause"])
@pytest.mark.parametrize("at", [0.1, 0.3])
def test_nothing_moves_until_it_is_resumed(command: str, at: float) -> None:
    rig, seen = Rig(NEEDY), list[tuple[str, int]]()
    look: Callable[[], None] = lambda: seen.append((rig.runner.view.mode, len(rig.move.goals)))  # noqa: E731
    rig.stage.play(
        {
            at: getattr(rig.runner, command),
            LATE_S: lambda: rig.publish("/there", data=False),
            0.6: look,
            0.7: rig.runner.resume,
            0.8: look,
            LAST: rig.runner.cancel,
        }
    )
    assert rig.run().outcome == "canceled"
    assert seen == [("paused", 0), ("running", 1)]


def test_a_stop_that_waits_with_the_reading_that_allows_the_start_comes_first() -> None:
    rig = Rig(NEEDY)
    rig.stage.play({LATE_S: lambda: (rig.publish("/there", data=False), rig.runner.stop()), LAST: rig.runner.cancel})
    assert rig.run().outcome == "canceled"
    assert moved(rig) == []


def test_the_command_to_start_begins_it_as_well() -> None:
    rig, seen = Rig(NEEDY), list[Any]()
    rig.stage.play(
        {
            0.3: rig.runner.stop,
            LATE_S: lambda: rig.publish("/there", data=False),
            0.6: lambda: seen.append(rig.runner.start({})),
            LAST: rig.runner.cancel,
        }
    )
    rig.run()
    assert seen == [[]] and moved(rig) == ["goal"]


def test_what_waits_for_its_start_waits_for_it_after_a_stop_too() -> None:
    rig, seen = Rig(NEEDY, begin=NewRun(waits=True)), list[str]()
    rig.stage.play(
        {
            0.3: rig.runner.stop,
            LATE_S: lambda: rig.publish("/there", data=False),
            0.5: rig.runner.resume,
            0.6: lambda: seen.append(rig.runner.view.mode),
            LAST: rig.runner.cancel,
        }
    )
    assert rig.run().outcome == "canceled"
    assert (seen, moved(rig)) == (["ready"], [])


def test_its_journal_replays_and_a_resumed_process_still_holds_back(tmp_path: Path) -> None:
    journal = Journal.create(tmp_path / "run.journal", Header(dump(NEEDY)))
    rig = Rig(NEEDY, journal=journal)

    def die() -> None:
        raise SystemExit

    rig.stage.play({0.3: rig.runner.stop, LATE_S: lambda: rig.publish("/there", data=False), 0.6: die})
    with pytest.raises(SystemExit):
        rig.run()
    journal.close()
    again = replay(journal.path)
    assert again.holds, again.difference
    with read(journal.path) as record:
        before = resumption(record, NEEDY)
    assert (before.chart.mode, before.chart.unstarted) == ("paused", True)
    later = Rig(NEEDY, begin=before)
    later.stage.play({LATE_S: lambda: later.publish("/there", data=False), LAST: later.runner.cancel})
    assert later.run().outcome == "canceled"
    assert moved(later) == []


ORDERS = ("stop", "pause", "resume")


@given(st.lists(st.tuples(st.integers(1, 7), st.sampled_from(ORDERS)), max_size=5))
def test_the_robot_moves_if_and_only_if_the_last_order_before_leaves_it_free(orders: list[tuple[int, str]]) -> None:
    rig = Rig(NEEDY)
    rig.stage.play({LATE_S: lambda: rig.publish("/there", data=False), LAST: rig.runner.cancel})
    for tenth, word in orders:
        rig.stage.play({tenth / 10 + 0.01: getattr(rig.runner, word)})
    rig.run()
    is_free = [True]
    for tenth in range(4, 9):
        before = [word for at, word in sorted(orders, key=lambda order: order[0]) if at < tenth]
        is_free.append(not before or before[-1] == "resume")
    assert bool(moved(rig)) == any(is_free[1:])
