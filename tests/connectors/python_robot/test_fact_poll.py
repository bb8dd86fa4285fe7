# SPDX-License-Identifier: Apache-2.0
"""What was done waits for readings that begin after it, and for none that never will."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest

from rai_missions.connectors.python_robot.fact_poll import REFRESH_S, FactPoll, refresh
from rai_missions.connectors.python_robot.robot_time import RobotTime, RunOver


@pytest.fixture
def robot_time() -> Iterator[RobotTime]:
    made = RobotTime()
    made.open()
    yield made
    made.close()


def seconds_of(polls: list[FactPoll]) -> float:
    began = time.monotonic()
    refresh(polls)
    return time.monotonic() - began


def test_a_reading_that_is_wanted_begins_after_that_and_is_waited_for(robot_time: RobotTime) -> None:
    place, values = [0.0], list[float]()
    poll = FactPoll("x", lambda: place[0], 60.0, robot_time=robot_time, on_value=values.append)
    for number in range(1, 200):
        place[0] = float(number)
        refresh([poll])
        assert values[-1] == number, "what is read later than it was done is what was done"
    poll.stop()


def test_no_reading_is_waited_for_once_the_run_is_over(robot_time: RobotTime) -> None:
    """Its thread ended in `sleep`; to wait for it took two seconds."""
    received = threading.Event()
    poll = FactPoll("x", lambda: 1.0, 60.0, robot_time=robot_time, on_value=lambda value: received.set())
    assert received.wait(30)
    robot_time.close()
    assert seconds_of([poll]) < REFRESH_S / 2


def test_no_reading_is_waited_for_whose_thread_has_ended(robot_time: RobotTime) -> None:
    ended = threading.Event()

    def take(value: float) -> None:
        ended.set()
        raise RunOver

    poll = FactPoll("x", lambda: 1.0, 60.0, robot_time=robot_time, on_value=take)
    assert ended.wait(30)
    assert seconds_of([poll]) < REFRESH_S / 2


def test_who_waits_for_a_reading_that_hangs_is_let_go_by_the_end_of_the_run(robot_time: RobotTime) -> None:
    hangs, begun = threading.Event(), threading.Event()

    def read() -> float:
        begun.set()
        hangs.wait(60)
        return 1.0

    poll = FactPoll("x", read, 60.0, robot_time=robot_time, on_value=lambda value: None)
    assert begun.wait(30)
    number, until = poll.want(), time.monotonic() + 60
    waiting = [threading.Thread(target=poll.wait_for, args=(number, until), daemon=True) for _ in range(20)]
    for each in waiting:
        each.start()
    poll.stop()
    ends = time.monotonic() + 10
    for each in waiting:
        each.join(max(0.0, ends - time.monotonic()))
    assert not any(each.is_alive() for each in waiting)
    hangs.set()


def test_a_reading_that_has_ended_is_not_reported_as_late(
    robot_time: RobotTime, caplog: pytest.LogCaptureFixture
) -> None:
    poll = FactPoll("x", lambda: 1.0, 60.0, robot_time=robot_time, on_value=lambda value: None)
    refresh([poll])
    poll.report_first()
    poll.stop()
    assert caplog.records == []
