# SPDX-License-Identifier: Apache-2.0
"""Sequence, selector and parallel of a compiled tree.

Rule: the order in which children are ticked and stopped, and which child is the current one, are py_trees' own
(py_trees 2.4, `composites.py`); what is left out is what would change nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.trees.node import FAILURE, INVALID, RUNNING, STATUSES, SUCCESS, CompiledNode
from rai_missions.engine.trees.tick import Tick

__all__ = ("CompiledComposite", "CompiledSelector", "CompiledSequence")


@cache
def placed(status: Status, current: int) -> Mapping[str, Any]:
    """What a composite remembers whose current child has a number; composites share it."""
    return {"status": status, "child": current}


class CompiledComposite(CompiledNode):
    """Children, of which one is the current one.

    Args:
        children: In the order written.
        memory: It continues at the child that runs.
    """

    __slots__ = ("current", "lead", "memory_", "top")
    doubts_later = True

    def __init__(self, children: Sequence[Any], *, memory: bool = False) -> None:
        super().__init__(children)
        self.memory_ = memory
        self.lead = children[0].quick if children else None
        """The guard of its first child, if that is a check whose tick a composite makes by itself.

        Where it has ended the last visit and comes to the same, this visit changes nothing.
        """
        self.current = -1
        """The number of the current child; -1 for none."""
        self.top = -1
        """No child with a higher number is anything but invalid."""

    def stop(self, now: Tick) -> None:
        self._stop_from(0, now)
        self.current = -1
        self.status, self.idle = INVALID, False
        now.touched.append(self)

    def _stop_from(self, first: int, now: Tick) -> None:
        """Stop the children from a number on."""
        children = self.children
        for number in range(first, self.top + 1):
            child = children[number]
            if child.status is not INVALID:
                child.stop(now)
        self.top = min(self.top, first - 1)

    def _among_seen(self, number: int, passes: Status, now: Tick, *, restarts: bool) -> int:
        """Tick those from a number on that are not idle, among the children at which the last tick has looked.

        One that is idle would report the same.

        Args:
            number: The number of the first.
            passes: The report after which the next one follows.
            now: The tick.
            restarts: A child is stopped before it is ticked.

        Returns:
            The number of the first child that it had no reason to look at; less than 0 where one has ended the visit,
            of which `~` is the number.
        """
        children, seen = self.children, self.current
        end = len(children) - 1
        while number <= seen:
            rest = self.todo >> number
            number += (rest & -rest).bit_length() - 1 if rest else end + 1
            if number > seen:
                return seen + 1 if children[seen].status is passes and seen < end else ~seen
            child = children[number]
            if restarts and not child.renews and child.status is not INVALID:
                child.stop(now)
            status = child.tick(now)
            if not child.idle:
                self.todo |= child.bit
            elif self.todo & child.bit:
                self.todo ^= child.bit
            if status is not passes or number == end:
                return ~number
            number += 1
        return number

    def _among_rest(self, number: int, passes: Status, now: Tick, *, restarts: bool) -> int:
        """Tick all from a number on; gives the number of the child whose report counts. See `_among_seen`."""
        children = self.children
        self.todo &= (1 << number) - 1
        for child in children[number:] if number else children:
            test = child.quick
            if test is not None:
                status = SUCCESS if test(now.sight) is True else FAILURE
                if status is not child.status:
                    child.status = status
                    now.touched.append(child)
                child.idle = True
            else:
                if child.status is INVALID:
                    pass
                elif restarts and not child.renews:
                    child.stop(now)
                elif child.doubts_later:
                    child.todo = -1
                else:
                    child.doubt()
                status = child.tick(now)
                if not child.idle:
                    self.todo |= child.bit
            if status is not passes:
                return number
            number += 1
        return number - 1

    def _end_again(self) -> Status:
        """End as the last tick did, at the first child; gives the status."""
        self.idle = self.children[0].idle = True
        self.todo = 0
        return self.status

    def doubt(self) -> None:
        """See `CompiledNode.doubt`; the children are put in doubt where they are visited."""
        self.idle = False
        self.todo = -1

    def memory(self) -> Mapping[str, Any] | None:
        if self.current < 0:
            return super().memory()
        return placed(self.status, self.current)

    def recall(self, memory: Mapping[str, Any]) -> None:
        self.status = STATUSES[memory.get("status", INVALID)]
        self.current = memory.get("child", -1)
        self.top = len(self.children) - 1

    def sees(self, child: Any) -> bool:
        """The child that runs, those before it without memory; of what has ended, those up to the one that decided."""
        if self.status is RUNNING and self.memory_:
            return bool(child.place == self.current)
        return child.place <= self.current or self.status is INVALID


class CompiledSequence(CompiledComposite):
    """One after the other, until one fails.

    One that has ended stops its children and begins with the first. A child that is idle would come to the same again,
    so it is neither stopped nor ticked.
    """

    __slots__ = ()

    def tick(self, now: Tick) -> Status:
        lead = self.lead
        if lead is not None and self.status is FAILURE and self.top == 0 and lead(now.sight) is not True:
            return self._end_again()
        begins, memory, children = self.status is not RUNNING, self.memory_, self.children
        first = self.current if memory and not begins else 0
        number = first
        if self.todo >= 0 and number <= self.current:
            number = self._among_seen(number, SUCCESS, now, restarts=begins)
        number = ~number if number < 0 else self._among_rest(number, SUCCESS, now, restarts=begins)
        child = children[number]
        status: Status = child.status
        if self.top > number:
            self._stop_from(number + 1, now)
        self.top = number
        if memory and status is RUNNING:
            self.idle = child.idle
        elif memory and not begins:
            self.doubt()
        else:
            self.idle = not self.todo & ((2 << number) - 1)
        if status is not self.status or number != self.current:
            self.status, self.current = status, number
            now.touched.append(self)
        return status


class CompiledSelector(CompiledComposite):
    """One after the other, until one succeeds or runs.

    One that has ended begins with the first, and stops none; with memory, one that runs stops those that it has passed.
    """

    __slots__ = ()
    renews = False

    def tick(self, now: Tick) -> Status:
        lead = self.lead
        if lead is not None and self.status is SUCCESS and self.top == 0 and lead(now.sight) is True:
            return self._end_again()
        begins, memory, last = self.status is not RUNNING, self.memory_, self.current
        children, first = self.children, 0
        if memory and not begins:
            first = last
            for child in children[:last]:
                if child.status is not INVALID:
                    child.stop(now)
        number = first
        if self.todo >= 0 and number <= self.current:
            number = self._among_seen(number, FAILURE, now, restarts=False)
        number = ~number if number < 0 else self._among_rest(number, FAILURE, now, restarts=False)
        child = children[number]
        status: Status = child.status
        if status is not FAILURE and self.top > number and number != (0 if begins else last):
            self._stop_from(number + 1, now)
        if self.top < number:
            self.top = number
        if status is RUNNING and memory:
            self.idle = number == first and child.idle
        elif memory and not begins:
            self.doubt()
        else:
            self.idle = not self.todo & ((2 << number) - 1) and (status is RUNNING or self.top == number)
        if status is not self.status or number != self.current:
            self.status, self.current = status, number
            now.touched.append(self)
        return status
