# SPDX-License-Identifier: Apache-2.0
"""What one tick sees and what it does, while it lasts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.templates import FilledTemplate
from rai_missions.guards.view import Test, Truth, View
from rai_missions.keys import Stamped

__all__ = ("Tick", "TickView")


class TickView:
    """A view in which what the tree has written in this tick is seen already.

    Args:
        view: What is known at the start of the tick.
        state: The state that runs the tree.
        began: When the tree was ticked first; represents the state's entry where the view does not know it.
        held: Held guard → since when its inner guard has been true; the tree keeps these itself.
    """

    def __init__(self, view: View, state: str, began: float, held: Mapping[str, float]) -> None:
        self._view, self._own = view, False
        self.at, self.active, self.event, self.answer = view.at, view.active, view.event, view.answer
        self.began, self.board = began, view.board
        self.entered: Mapping[str, float] = view.entered if state in view.entered else {**view.entered, state: began}
        self.true_since: Mapping[str, float] = held
        self.late_s = 0.0
        """How much later than now what is begun is carried out, in seconds."""

    def write(self, key: str, value: Any) -> None:
        """Let the rest of the tick see a value."""
        if not self._own:
            self.board, self._own = self.board.copy(), True
        self.board[key] = Stamped(value, self.at)

    def note_held(self, guards: Mapping[str, Test]) -> None:
        """Note since when the inner guards of `held` have been true, whether the next tick looks at them or not."""
        held = dict(self.true_since)
        for name, test in guards.items():
            if test(self) is True:
                held.setdefault(name, self.at)
            else:
                held.pop(name, None)
        self.true_since = held

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        return self._view.named(name, arguments)

    def note(self, text: str) -> None:
        self._view.note(text)


class Tick:
    """One tick: its sight, the outcomes that leaves have come to, and what is to be done about it.

    Live nodes of a tree share one `Tick` for good; `begin` makes it that of the next tick.
    """

    sight: Any
    """What is seen: a `View`, of a tree that writes or counts time a `TickView`."""
    late_s: float
    """How much later than now what is begun is carried out, in seconds."""
    outcomes: dict[str, str]
    started: dict[str, None]
    ended: dict[str, None]
    writes: list[tuple[str, Any]]
    published: list[tuple[str, FilledTemplate]]
    trace: list[tuple[str, str, Status]]
    """What was called, where that is written down."""
    touched: list[Any]
    """The nodes that may remember something else than before."""
    waits: list[Any]
    """The waits and timeouts that have begun."""
    turned: list[tuple[Any, Any, bool]]
    """Loop, child, and whether the child had begun in this tick: of each run of a loop's child that has ended."""
    turning: list[Any]
    """The children of loops of which a run has begun."""

    __slots__ = (
        "_on_write", "ended", "late_s", "outcomes", "published", "sight", "started", "touched", "trace", "turned",
        "turning", "waits", "writes",
    )  # fmt: skip

    def __init__(self, on_write: Callable[[str], None] | None = None) -> None:
        self._on_write = on_write
        self.started, self.ended, self.writes, self.published, self.trace = {}, {}, [], [], []
        self.touched, self.waits, self.turned, self.turning = [], [], [], []

    def clear(self) -> None:
        """Forget what was done."""
        self.touched.clear()
        if self.started or self.ended or self.writes or self.published or self.trace:
            self.started, self.ended, self.writes, self.published, self.trace = {}, {}, [], [], []
        if self.waits or self.turned or self.turning:
            self.waits, self.turned, self.turning = [], [], []

    def begin(self, sight: Any, outcomes: Mapping[str, str], late_s: float = 0.0) -> None:
        """Become the next tick."""
        self.clear()
        self.look(sight, outcomes, late_s)

    def look(self, sight: Any, outcomes: Mapping[str, str], late_s: float) -> None:
        """Become the next tick where nothing was done in the last one."""
        self.sight, self.outcomes, self.late_s = sight, dict(outcomes) if outcomes else {}, late_s

    def start(self, path: str) -> None:
        """Ask for the start of a leaf's activity; what came of an earlier one no longer counts."""
        self.outcomes.pop(path, None)
        self.started[path] = None

    def end(self, path: str) -> None:
        """Ask for the end of a leaf's activity, unless it was not begun before this tick or has ended by itself."""
        if path in self.started:
            del self.started[path]
        elif self.outcomes.pop(path, None) is None:
            self.ended[path] = None

    def take(self, path: str) -> str:
        """The outcome of a leaf's activity, once; empty while it runs."""
        return self.outcomes.pop(path, "")

    def write(self, key: str, value: Any) -> None:
        """Write a key; the rest of the tick sees it."""
        self.writes.append((key, value))
        self.sight.write(key, value)
        if self._on_write is not None:
            self._on_write(key)

    def turn(self, loop: Any, child: Any) -> None:
        """Tick a loop's child, and note what becomes of the run."""
        begins = child.status != "running"
        if begins:
            self.turning.append(child)
        if child.tick(self) != "running":
            self.turned.append((loop, child, begins))
