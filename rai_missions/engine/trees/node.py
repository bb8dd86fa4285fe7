# SPDX-License-Identifier: Apache-2.0
"""What a node of a compiled tree is, and when a tick may pass it over.

Rule: `idle` is True only where a tick of the node would change nothing and do nothing, as long as its facts and the
time at which it wakes are the same. What has ended is idle only where a stop and then a tick would do so as well.
Rule: what was not looked at by the last tick may have changed unseen: before it is ticked again it is put in doubt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.view import Site, Test

__all__ = ("FAILURE", "INVALID", "PLAIN", "RUNNING", "STATUSES", "SUCCESS", "CompiledNode")

INVALID: Status = "invalid"
RUNNING: Status = "running"
SUCCESS: Status = "success"
FAILURE: Status = "failure"
STATUSES: Mapping[str, Status] = {INVALID: INVALID, RUNNING: RUNNING, SUCCESS: SUCCESS, FAILURE: FAILURE}
"""A status as it comes from a file → the same that nodes compare by identity."""
PLAIN: Mapping[str, Mapping[str, Any]] = {status: {"status": status} for status in STATUSES}
"""What a node remembers that remembers nothing but its status."""


class CompiledNode:
    """A node of one tree, with all that it remembers while it is live."""

    __slots__ = ("bit", "children", "idle", "number", "parent", "path", "place", "shown", "site",
                 "status", "todo")  # fmt: skip

    loops = False
    """Each run of its child is a round."""
    counted = False
    """The rounds of the loop have a number."""
    renews = True
    """A tick after its end comes to the same as a stop and then a tick."""
    writes: tuple[str, ...] = ()
    """The keys that a tick of it may write."""
    role: Literal["", "activity", "waits"] = ""
    """What the ticker keeps it for while it runs: the chart runs it, or it has a deadline."""

    doubts_later = False
    """It puts its children in doubt as its tick comes to them, where its `todo` is less than 0."""
    quick: Test | None = None
    """Of a check that depends on keys, states and time alone, its guard: a composite makes its tick by itself."""

    def __init__(self, children: Sequence[Any] = ()) -> None:
        self.status: Status = INVALID
        self.idle = False
        self.children: Sequence[Any] = children
        self.todo = 0
        """The children that are not idle, as bits by their place; valid for those that the last tick looked at."""
        self.bit = 1
        """Its own bit in its parent's `todo`."""
        self.number, self.path = 0, ""
        self.parent: Any = None
        self.site: Site | None = None
        """What it depends on, where it looks at anything."""
        self.shown: Mapping[str, Any] | None = None
        """What it remembers in the state that the ticker has shown last."""
        self.place = 0
        """Its number among its parent's children."""
        for place, child in enumerate(children):
            child.parent, child.place, child.bit = self, place, 1 << place

    def tick(self, now: Tick) -> Status:
        """Tick it, and all below it that is not idle."""
        raise NotImplementedError

    def stop(self, now: Tick) -> None:
        """Make it invalid; it is not invalid before."""
        for child in self.children:
            if child.status is not INVALID:
                child.stop(now)
        self.status, self.idle = INVALID, False
        now.touched.append(self)

    def become(self, status: Status, now: Tick) -> Status:
        """Have a status from now on."""
        if status is not self.status:
            self.status = status
            now.touched.append(self)
        return status

    def wake(self) -> None:
        """Have the next tick visit it."""
        node = self
        while node.idle:
            node.idle = False
            parent = node.parent
            if parent is None:
                return
            parent.todo |= node.bit
            node = parent

    def doubt(self) -> None:
        """Have the next tick that comes here visit all that is below as well."""
        self.idle = False
        self.todo = -1
        for child in self.children:
            if child.status is not INVALID:
                child.doubt()

    # -- what outlives a tick

    def memory(self) -> Mapping[str, Any] | None:
        """What it remembers, as plain values; None for a node that is as it was made."""
        return None if self.status is INVALID else PLAIN[self.status]

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Be where a memory was made."""
        self.status = STATUSES[memory.get("status", INVALID)]

    # -- what the next tick may look at

    def sees(self, child: Any) -> bool:
        """Whether the next tick of it may look at a child, if nothing but facts and time change."""
        return True

    def is_seen(self) -> bool:
        """Whether the next tick of the tree may look at it."""
        node, parent = self, self.parent
        while parent is not None:
            if not parent.sees(node):
                return False
            node, parent = parent, parent.parent
        return True

    @property
    def looks(self) -> bool:
        """Whether what the next tick would do here depends on its keys."""
        return True

    def deadline(self) -> float:
        """The instant at which time alone changes something, while it runs; infinity for none."""
        return math.inf
