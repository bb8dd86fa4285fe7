# SPDX-License-Identifier: Apache-2.0
"""How the lives of a run end: chosen by chance, from outside or by itself, and what the run was doing then.

Rule: what it was doing is read from the journal and from the robot after the death, not from what was planned.
"""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.connectors.contract import Inbox
from rai_missions.engine.step import Ask, CallService, StartGoal
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import StepRow, read
from rai_missions.replay.open_run import open_run
from tests.replay.instants import INSTANTS, Instant

__all__ = ("Nursery", "Plan", "doing", "has_begun", "plan", "wait_until")

ROOT = Path(__file__).parents[2]
WORDS = ("asked", "runs", "ended", "horn", "lamp")
WHERE = {"waiting": "a timer pending", "looking": "in a tree", "both": "in a parallel region"}
LOOK_S, PATIENCE_S = 0.005, 120.0
LONGEST_S = 8.0
"""After so long a life whose instant does not come is left to itself."""


class Plan(NamedTuple):
    """When a life is to end."""

    kind: str
    """`time`, `word` of the robot's, `unread` (a goal ends while the process is frozen), or `instant`."""
    delay_s: float = 0.0
    """So long after that it is killed from outside, if it lives still."""
    word: str = ""
    instant: Instant | None = None


def plan(chance: random.Random) -> Plan:
    """The next one."""
    kind = chance.choices(("time", "word", "unread", "instant"), (25, 15, 8, 52))[0]
    if kind == "instant":
        name = chance.choice(list(INSTANTS))
        nth = chance.randint(1, INSTANTS[name].often)
        return Plan(kind, chance.uniform(2.0, 5.0), instant=Instant(name, nth, chance.random() < 0.5))
    longest_s = 2.5 if kind == "time" else 0.15
    return Plan(kind, chance.uniform(0.0, longest_s), chance.choice(WORDS) if kind == "word" else "runs")


def wait_until(is_so: Callable[[], bool], within_s: float) -> bool:
    """Watch another process: nothing reports of what it does."""
    until = time.monotonic() + within_s
    while not is_so():
        if time.monotonic() > until:
            return False
        time.sleep(LOOK_S)
    return True


class Nursery:
    """The process from which lives are forked, from outside: one life at a time.

    Args:
        folder: Where what they state goes.
        environment: Of every life.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder, self._reports = folder, Inbox[dict[str, Any]](PATIENCE_S)
        self._process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", "tests.replay.zygote", str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=dict(environment),
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        self._count = 0

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._reports(json.loads(line))

    def _order(self, **wish: Any) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(wish) + "\n")
        self._process.stdin.flush()

    def begin(self, words: Sequence[str], instant: Instant | None = None) -> None:
        """A life."""
        self._reports.wait(lambda reported: bool(reported), "everything is loaded")
        self._count = len(self._reports.all)
        self._order(words=list(words), out=str(self.out), instant=instant)
        self._reports.wait(lambda reported: len(reported) > self._count, "a life begins")

    @property
    def out(self) -> Path:
        """What the life reports."""
        return self._folder / "out.txt"

    def signal(self, number: signal.Signals) -> None:
        self._order(signal=int(number))

    @property
    def status(self) -> int | None:
        """How the life has ended, as `subprocess` has it."""
        found = self._reports.all[self._count + 1 :]
        return int(found[0]["status"]) if found else None

    def ends(self) -> int:
        """Wait for its end."""
        self._reports.wait(lambda reported: len(reported) > self._count + 1, "a life ends")
        return int(self.status or 0)

    def carry_out(self, plan: Plan, robot_reports: list[Any]) -> int:
        """Have a life end as planned, or in its own way if that comes first; how it ended."""
        before = len(robot_reports)

        def is_over() -> bool:
            return self.status is not None

        def states(word: str) -> Callable[[], bool]:
            return lambda: is_over() or any(reported[0] == word for reported in robot_reports[before:])

        if plan.kind in ("word", "unread") and not wait_until(states(plan.word), LONGEST_S):
            return self.ends()
        wait_until(is_over, plan.delay_s)
        if plan.kind == "unread" and not is_over():
            self.signal(signal.SIGSTOP)
            wait_until(lambda: robot_reports[-1][0] == "ended", 1.0)
        if not is_over():
            self.signal(signal.SIGKILL)
        return self.ends()

    def close(self) -> None:
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait(30)
        self._reader.join()
        self._process.stdout.close()


def has_begun(journal: Path) -> bool:
    """There is a run to continue with."""
    try:
        with read(journal) as record:
            return bool(record.header.run)
    except (UsageError, DefinitionError):
        return False


def doing(journal: Path, rows_before: int, robot_reports: Sequence[Any]) -> Iterator[str]:
    """What a run was doing when it died, in the words in which it is counted.

    Args:
        journal: The run's.
        rows_before: How many rows it had when the life began; 0 for the first.
        robot_reports: By the robot, since the run began.
    """
    if not has_begun(journal):
        yield "before its first row"
        return
    with read(journal) as record:
        new = [row for row in record.rows() if row.row >= rows_before]
    if rows_before and not any(isinstance(row, StepRow) and row.step.event.name == "open_run" for row in new):
        yield "in the resume itself"
    try:
        taken = open_run(journal)
    except UsageError:
        yield "after its last row"
        return
    taken.record.close()
    active, under = taken.resumption.chart.active, taken.resumption.under
    yield from (words for state, words in WHERE.items() if state in active)
    if not active:
        yield "before the start"
    if under.unsure:
        yield "between a write and its confirmation"
    for effect in under.open.values():
        if isinstance(effect, Ask):
            yield "in a decision"
        elif isinstance(effect, CallService):
            yield "a service called"
        elif isinstance(effect, StartGoal):
            yield _of_goal(effect, under.accepted, robot_reports)


def _of_goal(start: StartGoal, accepted: set[int], robot_reports: Sequence[Any]) -> str:
    """How far a goal is that the journal knows no end of."""
    asked = [at for at, reported in enumerate(robot_reports) if reported == ["asked", start.goal["order"]]]
    if not asked:
        return "a goal written, and not at its server"
    others = {reported[1] for reported in robot_reports[: asked[0]] if reported[0] == "runs"}
    mine = [reported for reported in robot_reports[asked[0] :] if reported[0] == "runs" and reported[1] not in others]
    if not mine:
        return "a goal sent, and not accepted"
    is_over = any(reported == ["ended", each[1]] for each in mine for reported in robot_reports)
    if is_over:
        return "a goal finished, and unread"
    return "a goal running" if start.number in accepted else "a goal accepted, and unread"
