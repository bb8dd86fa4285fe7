# SPDX-License-Identifier: Apache-2.0
"""What a machine of an activity is: a pure function from what was to what is, what is to be done, and how it ended.

Rule: a machine keeps nothing. Its state is a frozen value in the snapshot; time, facts and numbers come from the desk.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from rai_missions.event import Event
from rai_missions.guards.guard import Site, Test, View

__all__ = ("Desk", "Machine", "Outcome", "Turn")


class Outcome(NamedTuple):
    """How an activity ended."""

    name: str
    """`succeeded`, `failed`, `timed_out`, `rejected`, `canceled`, `unverified`, or an option."""
    data: Mapping[str, Any] = {}
    """`event.<field>` (for an option: `answer.<name>`) in the rows it fires."""
    why: str = ""


class Turn(NamedTuple):
    """What a machine makes of something that happened."""

    state: Any
    """The activity's state from now on: a frozen value."""
    effects: tuple[Any, ...] = ()
    """What the performer is to do, as values of `step.py`."""
    outcome: Outcome | None = None
    writes: tuple[tuple[str, Any], ...] = ()
    """Keys and their new values."""
    notes: tuple[str, ...] = ()
    """What a reader of the journal should know: a refused proposal, a stale answer."""


class Desk(Protocol):
    """What lies before a machine: the view, numbers, who holds control, and the goals that nobody may forget."""

    view: View
    owner: str
    """The state, or `state#path` for a leaf of a tree."""
    site: Site

    def next_number(self) -> int:
        """A fresh number for a start or a question."""

    def holds_control(self) -> bool:
        """Whether control is where this state wants it."""


class Machine(Protocol):
    """One kind of activity, compiled for one owner."""

    def begin(self, desk: Desk) -> Turn:
        """The state is active: start."""

    def hear(self, state: Any, event: Event, desk: Desk) -> Turn | None:
        """Something happened that may concern it; None where it does not. `tick` stands for time or facts."""

    def leave(self, state: Any, desk: Desk) -> Turn:
        """The state is left: end what runs."""

    def wake_at(self, state: Any, view: View) -> float:
        """The next instant at which `hear` may say something new without an event."""

    def reads(self, state: Any) -> frozenset[str]:
        """The keys whose change it wants to hear of, as a `tick`."""


Tests = Mapping[str, Test]
