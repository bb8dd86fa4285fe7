# SPDX-License-Identifier: Apache-2.0
"""The decorators of a compiled tree: what changes the report of one child.

Rule: what each reports is py_trees' own (py_trees 2.4, `decorators.py`). A child that is idle is not ticked, but for
that of a loop: each of its runs is a round, which the chart counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.trees.deadline import DeadlineNode
from rai_missions.engine.trees.node import FAILURE, INVALID, RUNNING, STATUSES, SUCCESS, CompiledNode
from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.view import Site, Test

__all__ = (
    "REPORTS", "CompiledConverter", "CompiledCount", "CompiledEternalGuard", "CompiledLoop", "CompiledOneShot",
    "CompiledReport", "CompiledTimeout",
)  # fmt: skip

REPORTS: Mapping[str, Mapping[Status, Status]] = {
    "pass_through": {},
    "inverter": {SUCCESS: FAILURE, FAILURE: SUCCESS},
    "failure_is_success": {FAILURE: SUCCESS},
    "success_is_failure": {SUCCESS: FAILURE},
    "running_is_failure": {RUNNING: FAILURE},
    "running_is_success": {RUNNING: SUCCESS},
    "failure_is_running": {FAILURE: RUNNING},
    "success_is_running": {SUCCESS: RUNNING},
    "condition success": {SUCCESS: SUCCESS, FAILURE: RUNNING, RUNNING: RUNNING},
    "condition failure": {SUCCESS: RUNNING, FAILURE: SUCCESS, RUNNING: RUNNING},
    "condition running": {SUCCESS: RUNNING, FAILURE: RUNNING, RUNNING: SUCCESS},
}
"""What a decorator makes of each report of its child, where it is not the same."""


def _as_its_child(decorator: Any) -> bool:
    """Whether a decorator renews."""
    return bool(decorator.child.renews)


class CompiledConverter(CompiledNode):
    """Changes what its child reports.

    Args:
        child: Its child.
        reports: What it makes of each report, where it is not the same.
    """

    __slots__ = ("child", "reports")
    renews = property(_as_its_child)

    def __init__(self, child: Any, reports: Mapping[Status, Status]) -> None:
        super().__init__((child,))
        self.child = child
        self.reports = {status: reports.get(status, status) for status in STATUSES.values()}

    def tick(self, now: Tick) -> Status:
        child = self.child
        status = self.reports[child.status if child.idle else child.tick(now)]
        if status is not RUNNING and child.status is RUNNING:
            child.stop(now)
        self.idle = child.idle
        return self.become(status, now)


class CompiledLoop(CompiledConverter):
    """Begins its child again where that ends and this runs; idle only while a run of its child is."""

    __slots__ = ()
    loops = True

    def tick(self, now: Tick) -> Status:
        child = self.child
        if not (child.idle and child.status is RUNNING):
            now.turn(self, child)
        status = self.reports[child.status]
        if status is not RUNNING and child.status is RUNNING:
            child.stop(now)
        self.idle = child.idle and child.status is RUNNING
        return self.become(status, now)


class CompiledCount(CompiledNode):
    """A loop with a number: how many rounds have ended is remembered while it runs.

    Args:
        child: Its child.
        most: So many rounds end it; -1 is for ever.
        again: With what of its child it begins the next round.
        word: What the number of rounds is called in its memory.
    """

    __slots__ = ("again", "child", "counted", "most", "rounds", "word")
    loops = True
    renews = property(_as_its_child)

    def __init__(self, child: Any, most: int, again: Status, word: str) -> None:
        super().__init__((child,))
        self.child, self.most, self.again, self.word = child, most, again, word
        self.counted = most > 0
        self.rounds = 0

    def tick(self, now: Tick) -> Status:
        child = self.child
        if self.status is not RUNNING:
            self.rounds = 0
        if not (child.idle and child.status is RUNNING):
            now.turn(self, child)
        status = child.status
        if status is self.again:
            self.rounds += 1
            now.touched.append(self)
            if self.rounds != self.most:
                status = RUNNING
        self.idle = child.idle and child.status is RUNNING
        return self.become(status, now)

    def memory(self) -> Mapping[str, Any] | None:
        if self.status is RUNNING and self.counted:
            return {"status": RUNNING, self.word: self.rounds}
        return super().memory()

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.rounds = memory.get(self.word, 0)


class CompiledTimeout(DeadlineNode):
    """Fails, and ends its child, at its deadline.

    Args:
        child: Its child.
        duration_s: The seconds that the child may take.
    """

    __slots__ = ("child", "duration_s")
    renews = property(_as_its_child)

    def __init__(self, child: Any, duration_s: float) -> None:
        super().__init__((child,))
        self.child, self.duration_s = child, duration_s

    def tick(self, now: Tick) -> Status:
        child = self.child
        if self.status is not RUNNING:
            self.begin(now.sight.at + now.late_s + self.duration_s, now)
        status = child.status if child.idle else child.tick(now)
        if status is RUNNING and now.sight.at >= self.until:
            child.stop(now)
            status = FAILURE
        self.idle = child.idle
        return self.become(status, now)


class CompiledEternalGuard(CompiledNode):
    """Runs its child while a guard is true; else it fails and what runs inside is ended.

    Args:
        child: Its child.
        test: The guard.
        site: What it depends on.
        steady: It depends on nothing else.
    """

    __slots__ = ("child", "is_open", "steady", "test")
    renews = False

    def __init__(self, child: Any, test: Test, site: Site, *, steady: bool) -> None:
        super().__init__((child,))
        self.child, self.test, self.site, self.steady = child, test, site, steady
        self.is_open = False
        """The guard was true at the last tick: the child was looked at."""

    def tick(self, now: Tick) -> Status:
        child = self.child
        if self.test(now.sight) is not True:
            self.is_open = False
            if child.status is RUNNING:
                child.stop(now)
            self.idle = self.steady and child.status is INVALID
            return self.become(FAILURE, now)
        if not self.is_open and child.status is not INVALID:
            child.doubt()
        self.is_open = True
        status = child.status if child.idle else child.tick(now)
        self.idle = self.steady and child.idle
        return self.become(status, now)

    def stop(self, now: Tick) -> None:
        super().stop(now)
        self.is_open = False

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.is_open = False

    def sees(self, child: Any) -> bool:
        return self.status is not FAILURE or child.status is FAILURE


class CompiledOneShot(CompiledNode):
    """Runs to its end once, and repeats that end.

    Args:
        child: Its child.
        ends: The statuses that count as its end.
    """

    __slots__ = ("child", "end", "ends")
    renews = False

    def __init__(self, child: Any, ends: Sequence[Status]) -> None:
        super().__init__((child,))
        self.child, self.ends = child, ends
        self.end: Status | None = None

    def tick(self, now: Tick) -> Status:
        child = self.child
        if self.end is not None:
            self.idle = child.status is INVALID
            return self.become(self.end, now)
        status = child.status if child.idle else child.tick(now)
        self.idle = child.idle
        if status in self.ends:
            self.end, self.idle = status, False
            now.touched.append(self)
        return self.become(status, now)

    def memory(self) -> Mapping[str, Any] | None:
        return {"status": self.status, "end": self.end} if self.end is not None else super().memory()

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.end = STATUSES[memory["end"]] if "end" in memory else None

    def sees(self, child: Any) -> bool:
        return self.end is None


class CompiledReport(CompiledNode):
    """Writes the status of its child to a key at each tick, where that has another value; never idle.

    Args:
        child: Its child.
        key: The key.
    """

    __slots__ = ("child", "key")
    renews = False

    def __init__(self, child: Any, key: str) -> None:
        super().__init__((child,))
        self.child, self.key = child, key

    @property
    def writes(self) -> tuple[str, ...]:  # type: ignore[override]
        """The one key that the node writes."""
        return (self.key,)

    def tick(self, now: Tick) -> Status:
        child = self.child
        status: Status = child.status if child.idle else child.tick(now)
        entry = now.sight.board.get(self.key)
        if entry is None or entry.value != status:
            now.write(self.key, status)
        return self.become(status, now)
