# SPDX-License-Identifier: Apache-2.0
"""py_trees' composites and decorators, traced, restorable, and with the time that they are given.

Rule: what a node does stays py_trees' own, but for two things: time comes from the view, and an old branch ends before
the one that takes over starts.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.view import Site, Test
from rai_missions.states import tree

__all__ = (
    "PLAIN",
    "ConditionBehaviour",
    "EternalGuardBehaviour",
    "OneShotBehaviour",
    "ParallelBehaviour",
    "RepeatBehaviour",
    "RetryBehaviour",
    "SelectorBehaviour",
    "SequenceBehaviour",
    "StatusToBlackboardBehaviour",
    "TimeoutBehaviour",
    "TracedBehaviour",
)  # fmt: skip

INVALID, RUNNING, SUCCESS, FAILURE = Status.INVALID, Status.RUNNING, Status.SUCCESS, Status.FAILURE
WORDS: dict[Status, Any] = {status: status.value.lower() for status in Status}
STATUSES = {word: status for status, word in WORDS.items()}


class TracedBehaviour(Behaviour if TYPE_CHECKING else object):  # type: ignore[misc]
    """Mixed into a behaviour: where it is, its trace, and what of it outlives a tick."""

    path: str
    round: Tick
    children: list[Any]
    site: Site | None = None
    """What it depends on, where it looks at anything."""
    loops = False
    """Each run of its child is a round: where the child has ended and this runs, the next tick begins it again."""
    counted = False
    """The rounds of the loop have a number."""

    def initialise(self) -> None:
        self.round.trace.append((self.path, "initialise", WORDS[self.status]))
        super().initialise()

    def update(self) -> Status:
        trace = self.round.trace
        place = len(trace)
        trace.append((self.path, "update", "invalid"))
        status: Status = super().update()
        trace[place] = (self.path, "update", WORDS[status])
        return status

    def terminate(self, new_status: Status) -> None:
        self.round.trace.append((self.path, "terminate", WORDS[new_status]))
        super().terminate(new_status)

    def kept(self) -> dict[str, Any]:
        """What it remembers besides its status, as plain values; left out is what it has when it is made."""
        return {}

    def recall(self, memory: dict[str, Any]) -> None:
        """Restore what `kept` holds."""

    def deadline(self) -> float | None:
        """The instant at which time alone changes something, while it runs."""
        return None

    @property
    def looks(self) -> bool:
        """Whether what the next tick would do here depends on its keys."""
        return True

    def ahead(self) -> list[Any]:
        """The children at which the next tick may look, if nothing but facts and time change."""
        return self.children


class CompositeBehaviour(TracedBehaviour, composites.Composite if TYPE_CHECKING else object):  # type: ignore[misc]
    def place(self) -> int:
        """The number of the current child; -1 for none."""
        return -1 if self.current_child is None else self.children.index(self.current_child)

    def kept(self) -> dict[str, Any]:
        return {} if self.current_child is None else {"child": self.place()}

    def recall(self, memory: dict[str, Any]) -> None:
        self.current_child = self.children[memory["child"]] if "child" in memory else None


class _OldFirst(CompositeBehaviour):
    """A composite in which a child can take over from one that still runs: the old one ends first.

    py_trees ticks the child that takes over and then stops the others. Nothing of the second depends on the first, so
    the two are reported in the other order; leaves are started and ended after the tick, the ended ones first.
    """

    decides: Status
    """What of a child ends it."""
    memory: bool
    _moved: tuple[int, int] | None = None
    """Where in the trace the child that takes over begins and ends."""

    def tick(self) -> Iterator[Behaviour]:
        trace, old = self.round.trace, self.current_child if self.status is RUNNING else None
        mark, self._moved = len(trace), None
        for node in super().tick():
            if node is self:
                self._end_old_first()
            elif node.parent is self:
                over = old is not None and node is not old and old.status is RUNNING and self.takes_over(node)
                self._moved = (mark, len(trace)) if over else None
                mark = len(trace)
            yield node

    def takes_over(self, child: Behaviour) -> bool:
        """Whether a child that was ticked now replaces the one that runs."""
        return child.status is RUNNING

    def _end_old_first(self) -> None:
        if self._moved is not None:
            (begin, end), self._moved, trace = self._moved, None, self.round.trace
            trace[begin:] = trace[end:] + trace[begin:end]

    def ahead(self) -> list[Any]:
        """The child that runs, those before it without memory; of what has ended, those up to the one that decided."""
        if self.status is RUNNING:
            current = self.place()
            return self.children[current if self.memory else 0 : current + 1]
        statuses = [child.status for child in self.children]
        if self.status is self.decides and self.decides in statuses:
            return self.children[: statuses.index(self.decides) + 1]
        return self.children

    def stop(self, new_status: Status = INVALID) -> None:
        if new_status is not INVALID:
            self._end_old_first()
        super().stop(new_status)


class SequenceBehaviour(_OldFirst, composites.Sequence):
    decides = FAILURE


class SelectorBehaviour(_OldFirst, composites.Selector):
    decides = SUCCESS

    def takes_over(self, child: Behaviour) -> bool:
        return child.status is not FAILURE


class ParallelBehaviour(CompositeBehaviour, composites.Parallel):
    @property
    def loops(self) -> bool:  # type: ignore[override]
        return not self.policy.synchronise

    def ahead(self) -> list[Any]:
        if self.status is not RUNNING or not self.policy.synchronise:
            return self.children
        return [child for child in self.children if child.status is not SUCCESS]


class DecoratorBehaviour(TracedBehaviour, decorators.Decorator if TYPE_CHECKING else object):  # type: ignore[misc]
    pass


PLAIN: dict[type[tree.TreeNode], type[DecoratorBehaviour]] = {
    kind: type(kind.__name__, (DecoratorBehaviour, getattr(decorators, kind.__name__)), {})
    for kind in tree.TreeNode.kinds.values()
    if issubclass(kind, tree.Decorator) and kind.model_fields.keys() == {"name", "child"}
}
"""The decorators that take nothing but their child: the format's kind → py_trees' own of the same name, traced."""


class ConditionBehaviour(DecoratorBehaviour, decorators.Condition):
    loops = True


class OneShotBehaviour(DecoratorBehaviour, decorators.OneShot):
    def kept(self) -> dict[str, Any]:
        return {} if self.final_status is None else {"end": WORDS[self.final_status]}

    def recall(self, memory: dict[str, Any]) -> None:
        self.final_status = STATUSES[memory["end"]] if "end" in memory else None

    def ahead(self) -> list[Any]:
        return self.children if self.final_status is None else []


class RetryBehaviour(DecoratorBehaviour, decorators.Retry):
    loops = counted = True

    def kept(self) -> dict[str, Any]:
        return {"failures": self.failures} if self.status is RUNNING else {}

    def recall(self, memory: dict[str, Any]) -> None:
        self.failures = memory.get("failures", 0)


class RepeatBehaviour(DecoratorBehaviour, decorators.Repeat):
    loops = True

    @property
    def counted(self) -> bool:  # type: ignore[override]
        return self.num_success > 0

    def kept(self) -> dict[str, Any]:
        return {"success": self.success} if self.status is RUNNING and self.counted else {}

    def recall(self, memory: dict[str, Any]) -> None:
        self.success = memory.get("success", 0)


class _TickTimeout(decorators.Timeout):
    """py_trees' Timeout, with the time of the tick, and at the deadline as well as after it."""

    round: Tick

    def initialise(self) -> None:
        self.finish_time = self.round.sight.at + self.round.sight.late_s + self.duration

    def update(self) -> Status:
        if self.decorated.status is RUNNING and self.round.sight.at >= self.finish_time:
            self.decorated.stop(INVALID)
            return FAILURE
        return self.decorated.status


class TimeoutBehaviour(DecoratorBehaviour, _TickTimeout):
    def kept(self) -> dict[str, Any]:
        return {"until": self.finish_time} if self.status is RUNNING else {}

    def recall(self, memory: dict[str, Any]) -> None:
        self.finish_time = memory.get("until", 0.0)

    def deadline(self) -> float | None:
        return self.finish_time


class _Mirror(decorators.Decorator):
    """Reports what its child reports."""

    def update(self) -> Status:
        return self.decorated.status


class EternalGuardBehaviour(DecoratorBehaviour, _Mirror):
    """py_trees' EternalGuard without its client of the global blackboard."""

    test: Test

    def tick(self) -> Iterator[Behaviour]:
        if self.test(self.round.sight) is not True:
            self.stop(FAILURE)
            yield self
        else:
            yield from super().tick()

    def ahead(self) -> list[Any]:
        is_shut = self.status is FAILURE and self.decorated.status is not FAILURE
        return [] if is_shut else self.children


class _Report(_Mirror):
    """py_trees' StatusToBlackboard, writing a key of the mission where it states something new."""

    key: str
    round: Tick

    def update(self) -> Status:
        status = self.decorated.status
        entry = self.round.sight.board.get(self.key)
        if entry is None or entry.value != WORDS[status]:
            self.round.write(self.key, WORDS[status])
        return status


class StatusToBlackboardBehaviour(DecoratorBehaviour, _Report):
    pass


PLAIN[tree.FailureIsRunning].loops = PLAIN[tree.SuccessIsRunning].loops = True
