# SPDX-License-Identifier: Apache-2.0
"""The parallel of a compiled tree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.trees.composites import CompiledComposite
from rai_missions.engine.trees.node import FAILURE, INVALID, RUNNING, SUCCESS, CompiledNode
from rai_missions.engine.trees.tick import Tick

__all__ = ("CompiledParallel",)


class CompiledParallel(CompiledComposite):
    """All children at each tick; one that is idle would report the same.

    Args:
        children: In the order written.
        policy: `success_on_all`, `success_on_one`, or the numbers of the children that must succeed.
        synchronise: A child that has succeeded is not ticked again.
    """

    __slots__ = ("policy", "synchronise")
    doubts_later = False

    def __init__(self, children: Sequence[Any], policy: str | tuple[int, ...], *, synchronise: bool) -> None:
        super().__init__(children)
        self.policy = policy
        self.synchronise = synchronise and policy != "success_on_one"
        self.top = len(children) - 1

    @property
    def loops(self) -> bool:  # type: ignore[override]
        """The runs of a child that is ticked again after its end are rounds."""
        return not self.synchronise

    def tick(self, now: Tick) -> Status:
        begins, synchronise = self.status is not RUNNING, self.synchronise
        if begins:
            self._restart(now)
        for child in self.children:
            if child.idle and (synchronise or child.status is RUNNING):
                continue
            if not synchronise:
                now.turn(self, child)
            elif child.status is not SUCCESS:
                child.tick(now)
        status, current = self._decided()
        if status is RUNNING and synchronise:
            self.idle = all(child.idle or child.status is SUCCESS for child in self.children)
        elif status is RUNNING:
            self.idle = all(child.idle and child.status is RUNNING for child in self.children)
        elif begins and synchronise:
            self._stop_running(now)
            self.idle = all(child.idle for child in self.children)
        else:
            self._stop_running(now)
            self.doubt()
        if status is not self.status or current != self.current:
            self.status, self.current = status, current
            now.touched.append(self)
        return status

    doubt = CompiledNode.doubt

    def _restart(self, now: Tick) -> None:
        """Stop what has ended, but for what would come to the same again."""
        for child in self.children:
            if child.status is not INVALID and not (self.synchronise and child.idle):
                child.stop(now)

    def _stop_running(self, now: Tick) -> None:
        for child in self.children:
            if child.status is RUNNING:
                child.stop(now)

    def _decided(self) -> tuple[Status, int]:
        """The node's status by its policy, and the number of its current child."""
        statuses = [child.status for child in self.children]
        last, policy = len(statuses) - 1, self.policy
        if FAILURE in statuses:
            return FAILURE, statuses.index(FAILURE)
        if policy == "success_on_all":
            return (SUCCESS if statuses.count(SUCCESS) > last else RUNNING), last
        if policy == "success_on_one":
            if SUCCESS not in statuses:
                return RUNNING, last
            return SUCCESS, last - statuses[::-1].index(SUCCESS)
        if all(statuses[int(number)] is SUCCESS for number in policy):
            return SUCCESS, int(policy[-1])
        return RUNNING, last

    def stop(self, now: Tick) -> None:
        self._stop_running(now)
        self.top = len(self.children) - 1
        super().stop(now)

    def sees(self, child: Any) -> bool:
        return self.status is not RUNNING or not self.synchronise or child.status is not SUCCESS
