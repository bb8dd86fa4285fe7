# SPDX-License-Identifier: Apache-2.0
"""Real processes and a real `kill -9` over ROS 2, with the robot living on: the run ends as if no one had been killed.

Rule: a life is the real command line, forked from a process that has loaded everything and started nothing.
"""

from __future__ import annotations

import os
import random
import signal
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.journal import read
from tests.connectors.ros2.peer_process import Peer
from tests.replay.deaths import Nursery, Plan, doing, has_begun, plan, wait_until
from tests.replay.errand import GOALS, check, written
from tests.replay.instants import INSTANTS, Instant
from tests.rigs.journals import raw_rows_of
from tests.ros2 import on_ros
from tests.tractor.ros2_processes import ros_domain

pytestmark = [on_ros, pytest.mark.sim]
SLACK_S = 0.05


class Errands:
    """Runs with one robot that lives on, and how they were killed."""

    def __init__(self, nursery: Nursery, robot: Peer, folder: Path) -> None:
        self.nursery, self.robot, self.folder = nursery, robot, folder
        self.mission, self.profile = written(folder, robot.name)
        self.killed: Counter[str] = Counter()
        self.planned: Counter[str] = Counter()
        self.kills = self.runs = 0

    def run(self, plans: list[Plan], dead_s: list[float]) -> None:
        """One run that dies by these plans, one after the other, and then lives to its end."""
        journal = self.folder / f"{uuid.uuid4().hex}.journal"
        reported = self.robot.lines.all
        since, lived_s, story = len(reported), 0.0, [str(each) for each in plans]
        wanted = sum(each[0] == "ended" for each in reported) + GOALS
        for each, pause_s in zip([*plans, Plan("none")], [*dead_s, 0.0], strict=True):
            rows = number_of_rows(journal)
            began = time.monotonic()
            self.nursery.begin(self.words(journal, wanted), each.instant)
            status = self.nursery.ends() if each.kind == "none" else self.nursery.carry_out(each, reported)
            lived_s += time.monotonic() - began
            text = self.nursery.out.read_text(errors="replace")
            assert "Traceback" not in text, text
            if status != -signal.SIGKILL:
                assert status == 0 or "has ended, succeeded" in text, (status, text, story)
                break
            self.kills += 1
            self.planned[str(each.instant or each.kind).rstrip(" 0123456789")] += 1
            self.killed.update(set(doing(journal, rows, reported[since:])))
            wait_until(lambda: False, pause_s)
        self.runs += 1
        try:
            check(journal, reported[since:])
            assert clock_at_the_end(journal) <= lived_s + SLACK_S, "the time in which nothing lived does not count"
        except AssertionError as fault:
            raise AssertionError(f"{journal}, killed by {story}; the robot: {reported[since:]}") from fault
        journal.unlink()

    def words(self, journal: Path, wanted: int) -> list[str]:
        if has_begun(journal):
            return ["run", "--resume", str(journal)]
        for left in (journal, journal.with_name(f"{journal.name}-wal")):
            left.unlink(missing_ok=True)
        return ["run", str(self.mission), "--robot", str(self.profile), "--journal", str(journal),
                "--set", f"wanted={wanted}"]  # fmt: skip


def number_of_rows(journal: Path) -> int:
    return len(raw_rows_of(journal)) if has_begun(journal) else 0


def clock_at_the_end(journal: Path) -> float:
    with read(journal) as record:
        last = record.last()
    assert last is not None
    return last.step.at


@pytest.fixture(scope="module")
def errands(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Errands]:
    folder = tmp_path_factory.mktemp("errands")
    with ros_domain(folder / "ros-log") as environment, pytest.MonkeyPatch.context() as patch:
        for name, value in environment.items():
            patch.setenv(name, value)
        nursery = Nursery(folder, environment)
        try:
            with Peer(f"robot_{uuid.uuid4().hex[:6]}", Path(__file__).with_name("robot_process.py")) as robot:
                yield Errands(nursery, robot, folder)
        finally:
            nursery.close()


@pytest.mark.drill  # those that are killed end as it does
def test_an_errand_that_no_one_kills_succeeds(errands: Errands) -> None:
    errands.run([], [])


@pytest.mark.long
def test_it_is_killed_before_and_after_a_write_in_a_decision_and_in_its_resume(errands: Errands) -> None:
    chosen = (
        Instant("a row is written", 2, False), Instant("an answer comes", 1, True),
        Instant("the robot reports again", 1, False), Instant("a service is called", 1, True),
    )  # fmt: skip
    kills = errands.kills
    errands.run([Plan("instant", 30.0, instant=each) for each in chosen], [0.0, 0.5, 0.0, 0.0])
    assert errands.kills == kills + len(chosen)


@pytest.mark.drill
@pytest.mark.parametrize("name", INSTANTS)
def test_a_process_that_dies_at_an_instant_of_a_run_is_followed_by_one_that_continues(
    errands: Errands, name: str
) -> None:
    """Right before and right after; what a resume does is met in the second life."""
    middle = Plan("word", 0.1, "runs")
    before, after = (Plan("instant", 30.0, instant=Instant(name, 1, is_done)) for is_done in (False, True))
    kills = errands.kills
    errands.run([middle, before, after], [0.0, 0.0, 0.0])
    assert errands.kills > kills


@pytest.mark.long
def test_a_goal_that_ends_while_its_process_cannot_read_is_found_ended(errands: Errands) -> None:
    errands.run([Plan("unread", 0.05, "runs")], [0.5])
    assert errands.killed["a goal finished, and unread"]


@pytest.mark.drill
@pytest.mark.timeout(14_400)
def test_a_thousand_kills_lose_nothing_and_do_nothing_twice(errands: Errands) -> None:
    """`RAI_MISSIONS_KILLS` reports how many; `RAI_MISSIONS_SEED` by which chance."""
    seed, began = int(os.environ.get("RAI_MISSIONS_SEED", "20261121")), time.monotonic()
    most, chance = int(os.environ.get("RAI_MISSIONS_KILLS", "1000")), random.Random(seed)
    errands.kills, errands.runs = 0, 0
    while errands.kills < most:
        plans = [plan(chance) for _ in range(chance.randint(3, 20))]
        errands.run(plans, [chance.choice((0.0, 0.0, chance.uniform(0.0, 1.5))) for _ in plans])
        lasted_s = time.monotonic() - began
        print(f"{errands.kills} kills in {errands.runs} runs, {lasted_s:.0f} s, seed {seed}", flush=True)  # noqa: T201
    for what, count in (*errands.killed.most_common(), *sorted(errands.planned.items())):
        print(f"{count:5}  {what}", flush=True)  # noqa: T201 - the figures
