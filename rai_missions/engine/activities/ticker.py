# SPDX-License-Identifier: Apache-2.0
"""What a chart wants of whatever ticks its behaviour trees.

Rule: a tick is pure. All that a tree remembers is in its `TreeState`; leaves are started and ended by the chart,
with the machines that the states of the same words use, and their outcomes are given to the next tick.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

from rai_missions.engine.templates import FilledTemplate
from rai_missions.guards.view import View
from rai_missions.states.tree import TreeNode

__all__ = ("Leaf", "LoopRound", "TickResult", "Ticker", "TreeState", "Trees")

Status = Literal["invalid", "running", "success", "failure"]


class Leaf(NamedTuple):
    """How far a leaf that the chart runs has come."""

    run: int
    """Which of its runs this is: 1 for the first; a leaf that is started again counts on."""
    outcome: str = ""
    """Empty while it runs; then the outcome of its activity (`succeeded`, …, or an option's name)."""


class TreeState(NamedTuple):
    """All that a tree remembers between two ticks. Frozen, and plain enough for JSON.

    What `nodes` holds for a node is the ticker's own affair: status, memory, counters, deadlines.
    """

    nodes: Mapping[str, Any] = {}
    """Path of the node → what it remembers."""
    leaves: Mapping[str, Leaf] = {}
    """Path of each action, call, decision or behaviour leaf that runs, until the tick that reads its outcome."""


class LoopRound(NamedTuple):
    """A round of a loop that has ended in a tick."""

    path: str
    """Of the loop's child; the round is one run of it."""
    counted: bool
    """The loop has a number of rounds."""
    at_once: bool
    """It has begun in the same tick."""
    continues: bool
    """The loop still runs: its next tick begins the next round."""


class TickResult(NamedTuple):
    """What a tick did."""

    state: TreeState
    status: Status
    """The root's; `success` and `failure` end the tree."""
    started: tuple[str, ...] = ()
    """Paths of the leaves that the chart is to start, in order."""
    ended: tuple[str, ...] = ()
    """Paths of the running leaves that the chart is to end, in order; they are ended before any is started."""
    writes: tuple[tuple[str, Any], ...] = ()
    """What `set` leaves wrote, in order; later nodes of the same tick have seen it."""
    published: tuple[tuple[str, FilledTemplate], ...] = ()
    """Topic and message of each `publish` leaf."""
    trace: tuple[tuple[str, str, Status], ...] = ()
    """What was called, in order: (path, `initialise` | `update` | `terminate`, status), as py_trees orders them.

    The status is what the node had before (`initialise`), returns (`update`), or has from now on (`terminate`). Empty
    where the ticker does not write it down.
    """
    begun: tuple[str, ...] = ()
    """Paths of the loops' children of which a run has begun in this tick and continues."""
    rounds: tuple[LoopRound, ...] = ()
    """The rounds of loops that have ended."""
    waits: tuple[str, ...] = ()
    """Paths of the waits and timeouts that have begun in this tick and run, in order."""


class Ticker(Protocol):
    """Compiled for one tree."""

    loops: int
    """How many rounds of loops can end in one tick."""

    def tick(
        self,
        state: TreeState,
        view: View,
        outcomes: Mapping[str, str],
        late_s: float = 0.0,
        changed: Collection[str] | None = None,
    ) -> TickResult:
        """Tick once, as py_trees does.

        Args:
            state: As the last tick left it; `TreeState()` for the first.
            view: What is known, and the time.
            outcomes: Path of a running leaf → the outcome that its activity has reported since; of a behaviour in
                Python its last status.
            late_s: How much later than now what is begun is carried out, in seconds; a `timeout` counts from then.
            changed: All that `reads` of this state names and that is another than at the last tick, by the same words,
                what the tree has written itself left out; None where that is not known. More does no harm.
        """

    def stop(self, state: TreeState, view: View) -> TickResult:
        """End whatever runs: the state that holds the tree is left."""

    def wake_at(self, state: TreeState, view: View) -> float:
        """The next instant at which a wait, a timeout or a guard's age can change something; infinity for none."""

    def reads(self, state: TreeState) -> frozenset[str]:
        """What wants a tick once it is another: keys at which the next may look (`*` for any), `presence` of states."""

    def watches(self, state: TreeState, names: Collection[str]) -> bool:
        """Whether one of these, which has changed, is among `reads`; `*` there is any key."""

    def shift(self, state: TreeState, by_s: float) -> TreeState:
        """The state as it would be had everything happened so much later, in seconds: what a pause makes of it."""


@runtime_checkable
class Trees(Protocol):
    """What a chart is given as `ticker`: compiles trees."""

    def compile(self, root: TreeNode, place: str, keys: Mapping[str, Any], state: str) -> Ticker:
        """A ticker for one tree, which shares nothing with any other.

        Args:
            root: The tree.
            place: Its JSON pointer in the mission.
            keys: The mission's keys.
            state: The state that runs it; `elapsed_s` counts from its entry.
        """
