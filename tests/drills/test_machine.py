# SPDX-License-Identifier: Apache-2.0
"""What a machine does to a run: clocks that leap, threads that flood it, weeks that pass."""

from __future__ import annotations

import gc
import threading
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest

from rai_missions.connectors import local
from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import PublishedClock, SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.runner import Runner
from tests.drills.surroundings import AnyAnswers
from tests.rigs.runs import Rig, mission, robot

SEED = 5
THREADS = 8
HOUR_S, DAY_S = 3600, 86_400

# -- threads ---------------------------------------------------------------------------------------------------------

COUNTED: dict[str, Any] = {
    "counting": {"transitions": [
        {"on": "go", "do": [{"set": "count", "add": 1}]},
        {"on": "stop_now", "to": "over"}]},
    "over": {"final": "aborted"},
}  # fmt: skip


def flood(path: Path, each: int) -> None:
    """Eight threads post so many events each; every one is counted once, in its thread's order, and written down."""
    counted = mission(COUNTED)
    with Journal.create(path, Header(dump(counted), "", {})) as journal:
        runner = Runner(counted, robot=robot(), connector=LocalConnector(), journal=journal)
        threads = [threading.Thread(target=_post, args=(runner, number, each)) for number in range(THREADS)]
        ends = threading.Thread(target=_end, args=(runner, threads))
        for thread in (*threads, ends):
            thread.start()
        runner.run()
        ends.join()
    assert runner.view.board["count"].value == THREADS * each
    received: dict[int, list[int]] = {number: [] for number in range(THREADS)}
    with read(path) as record:  # which verifies the chain
        for step in record.steps():
            if step.event.name == "go":
                received[step.event.data["thread"]].append(step.event.data["number"])
    assert all(numbers == list(range(each)) for numbers in received.values()), "none lost, none twice, in order"


def _post(runner: Runner, thread: int, each: int) -> None:
    for number in range(each):
        runner.post(Event("go", runner.view.now(), {"thread": thread, "number": number}))


def _end(runner: Runner, threads: list[threading.Thread]) -> None:
    for thread in threads:
        thread.join()
    runner.post(Event("stop_now", runner.view.now()))


def test_of_ten_thousand_events_from_eight_threads_none_is_lost_and_none_comes_twice(tmp_path: Path) -> None:
    flood(tmp_path / "run.journal", 1_250)


@pytest.mark.drill
def test_of_a_million_events_from_eight_threads_none_is_lost_and_none_comes_twice(tmp_path: Path) -> None:
    flood(tmp_path / "run.journal", 125_000)


# -- clocks ----------------------------------------------------------------------------------------------------------

WAITING: dict[str, Any] = {
    "deaf": {"transitions": [{"when": {"fresh": "battery"}, "to": "moving"}]},
    "moving": {"action": "move", "timeout_s": 20, "transitions": [
        {"when": {"not": {"fresh": "battery"}}, "to": "blind"}, {"on": "timed_out", "to": "late"}]},
    "late": {"final": "failed"}, "blind": {"final": "aborted"},
}  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_a_simulations_clock_that_leaps_never_moves_a_run_back_and_never_by_more_than_was_reported(seed: int) -> None:
    """Steps, resets to zero, repeats and leaps by years; the run's own time only ever grows, a minute at most."""
    random, clock, reported = Random(seed), PublishedClock(silence_s=1e9), 0.0
    clock.advance(reported)
    before = clock.now()
    for _ in range(500):
        step = random.choice([0.1, 0.1, 0.1, 0.0, -0.05, -reported, 1e9, -1e9, 59.0, 61.0])
        reported += step
        clock.advance(reported)
        gone = clock.now() - before
        assert gone == pytest.approx(step if 0 <= step <= 60 else 0.0, abs=1e-5)
        before += gone


@pytest.mark.parametrize("seed", range(10))
def test_a_mission_whose_simulation_is_reset_again_and_again_still_ends_in_its_own_time(seed: int) -> None:
    """The timeout of 20 s is 20 s lived, whatever the numbers on the clock."""
    random, clock, steps = Random(seed), PublishedClock(silence_s=1e9), [0]
    lived = [0.0]
    rig = Rig(WAITING, clock=clock)
    done = threading.Event()

    def reports() -> None:
        reported = 0.0
        while not done.is_set():
            reported = random.choice([reported + 0.5] * 8 + [0.0, reported - 7.0, reported + 1e6])
            rig.publish("/battery", percentage=0.9)
            clock.advance(reported)
            lived[0], steps[0] = clock.now(), steps[0] + 1
            time.sleep(0)

    thread = threading.Thread(target=reports)
    rig.connector.start()
    rig.publish("/battery", percentage=0.9)
    thread.start()
    try:
        result = rig.run()
    finally:
        done.set()
        thread.join()
    assert result.outcome in ("failed", "aborted") and steps[0] > 2
    assert result.duration_s >= 20.0 or rig.entered[-1] == "blind"
    assert rig.move.canceled == rig.move.goals


def test_messages_whose_stamps_leap_back_and_forth_are_as_old_as_they_state_and_never_from_the_future() -> None:
    rig = Rig(WAITING)
    ages: list[float] = []

    def on_result() -> None:
        at = rig.stage.at
        stamp = {0: at, 1: at - 1.5, 2: at + 1e6, 3: -5.0}[rig.stage.steps % 4]
        rig.connector.publish("/battery", "sensor_msgs/msg/BatteryState", {"percentage": 0.9, "stamp": stamp})
        entry = rig.runner.view.board.get("battery")
        ages.append(0.0 if entry is None else rig.clock.now() - entry.at)

    rig.stage.each = on_result
    result = rig.run()
    assert result.why.startswith("'late'") and result.duration_s == pytest.approx(20.1, abs=0.3)
    assert min(ages) >= 0.0, "nothing is newer than now"


def test_a_wall_clock_that_is_set_back_moves_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run never asks what day it is."""
    monkeypatch.setattr(time, "time", lambda: 0.0)
    monkeypatch.setattr(time, "time_ns", lambda: 0)
    rig = Rig(WAITING)
    rig.stage.each = lambda: rig.publish("/battery", percentage=0.9)
    assert rig.run().duration_s == pytest.approx(20.1, abs=0.3)


# -- weeks -----------------------------------------------------------------------------------------------------------

PATROL: dict[str, Any] = {
    "moving": {"action": "move", "timeout_s": 60, "transitions": [
        {"on": "succeeded", "to": "asking"}, {"on": ["failed", "timed_out", "rejected"], "to": "asking"}]},
    "asking": {"decision": {"question": "And now?", "options": {"go_on": {}, "wait": {}, "honk": {}}, "ask": ["agent"],
                            "attempts": 2, "deadline_s": 10, "fallback": "go_on"},
               "transitions": [{"on": "go_on", "to": "moving"}, {"on": "wait", "to": "waiting"},
                               {"on": "honk", "to": "honking"}]},
    "honking": {"tree": {"sequence": [{"call": "horn", "timeout_s": 5}, {"wait_s": 3}]}, "timeout_s": 20,
                "transitions": [{"on": ["succeeded", "failed", "timed_out"], "to": "moving"}]},
    "waiting": {"transitions": [{"after_s": 20, "to": "moving"}, {"when": {"held": {"key": "battery", "<": 0.2},
                                                                          "for_s": 5}, "to": "moving"}]},
    "over": {"final": "aborted"},
}  # fmt: skip


class Patrolled:
    """A robot that patrols for ever; a step is twenty seconds.

    Args:
        seed: All that happens follows from it.
        until_s: When someone stops it.
        at: Notified of each hour that is over.
    """

    period_s = 20.0

    def __init__(self, seed: int, until_s: float, at: Callable[[int], None]) -> None:
        self._random, self._until_s, self._hour = Random(seed), until_s, at
        self.connector = LocalConnector(now=lambda: self.at)
        self.connector.start()
        self._ticks = 0
        self._running: dict[str, Callable[[Report], None]] = {}
        self.connector.offer("/move", "x/action/Move", self)
        self.connector.serve("/horn", "std_srvs/srv/Trigger", lambda _: {"success": True})
        self.runner: Any = None

    @property
    def at(self) -> float:
        return self._ticks * self.period_s

    def step(self) -> None:
        self._ticks += 1
        self.connector.publish("/battery", "sensor_msgs/msg/BatteryState", {"percentage": self._random.random()})
        for goal_id in list(self._running):
            if self._random.random() < 0.2:
                self._end(goal_id, self._random.choice(["succeeded", "failed"]))
        if self.at % HOUR_S == 0:
            self._hour(round(self.at / HOUR_S))
        if self.at >= self._until_s:
            self.runner.kill()

    def accept(self, goal_id: str, goal: Any, report: Callable[[Report], None]) -> None:
        self._running[goal_id] = report
        report(Report(goal_id, "accepted", {}))

    def cancel(self, goal_id: str) -> None:
        self._end(goal_id, "canceled")

    def _end(self, goal_id: str, status: Any) -> None:
        self._running.pop(goal_id)(Report(goal_id, status, {}))


def patrol(path: Path, days: float, at: Callable[[int], None]) -> Mission:
    """A run of so many days, on a journal on disk."""
    patrolled = mission(PATROL)
    world = Patrolled(SEED, days * DAY_S, at)
    with Journal.create(path, Header(dump(patrolled), "", {})) as journal:
        world.runner = Runner(
            patrolled,
            robot=robot(),
            connector=world.connector,
            clock=SimulatedClock(world),
            journal=journal,
            answerers={"agent": AnyAnswers(Random(SEED))},
        )
        result = world.runner.run()
    assert result.outcome == "aborted" and result.steps > 500 * days, "it patrolled"
    return patrolled


@pytest.mark.long
def test_memory_is_flat_over_eight_simulated_hours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local, "MOST_ENDED", 20)  # what is kept of goals that have ended has found its bound by then
    held: list[int] = []

    def weigh(hour: int) -> None:
        if hour == 2:
            tracemalloc.start(1)
        if hour in (4, 6, 8):
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])

    try:
        patrol(tmp_path / "run.journal", 1 / 3, weigh)
    finally:
        tracemalloc.stop()
    assert held[-1] - held[0] < 100_000, f"bytes allocated since the second hour and still held: {held}"
    assert replay(tmp_path / "run.journal").holds


@pytest.mark.drill
def test_memory_is_flat_over_a_simulated_week(tmp_path: Path) -> None:
    pages: list[int] = []

    def weigh(hour: int) -> None:
        if hour % 24 == 0:  # the first day fills what has a bound
            gc.collect()
            pages.append(int(Path("/proc/self/statm").read_text().split()[1]))

    patrol(tmp_path / "run.journal", 7, weigh)
    assert (pages[-1] - pages[0]) * 4096 < 8_000_000, f"resident pages, day by day: {pages}"


def test_a_mailbox_gives_what_eight_threads_put_in_each_in_its_order() -> None:
    mailbox, each = Mailbox(), 2_000
    threads = [
        threading.Thread(target=lambda number=number: [mailbox.post(Event(str(number), float(i))) for i in range(each)])
        for number in range(THREADS)
    ]
    for thread in threads:
        thread.start()
    received: dict[str, list[float]] = {str(number): [] for number in range(THREADS)}
    while sum(map(len, received.values())) < THREADS * each:
        mailbox.wait(30.0)
        event = mailbox.take()
        assert event is not None
        received[event.name].append(event.at)
    assert all(times == [float(i) for i in range(each)] for times in received.values())
