# SPDX-License-Identifier: Apache-2.0
"""The runs of one conversation, one after the other: which follows one that is over, and what an interrupt does.

Rule: a run follows another in its world and over its connector, with a journal of its own, and by an order that was
judged. None follows an e-stop, an interrupt, or a run that leaves goals which may still move the robot.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rai_missions.agents.mission import PreparedRun, RunConfig, prepare_next
from rai_missions.conversation.inputs import OrderResult, RefusalKind
from rai_missions.runtime.arguments import argument_faults
from rai_missions.runtime.interrupts import BY

if TYPE_CHECKING:
    from rai_missions.agents.talk.orders import OnOrderEnd
    from rai_missions.conversation import Order
    from rai_missions.runtime.runner import Runner

__all__ = ("TalkRuns",)

NO_INPUT = "operator (end of input)"
"""Who cancels a run that waits for a person's order where no one can give one any more."""
WITHDRAWN = "operator (stop)"
"""Who stops a run that was begun by an order to which a stop came."""


class OrderedRun(NamedTuple):
    """A start that was ordered once a run was over."""

    order: Order
    on_end: OnOrderEnd


class TalkRuns:
    """Which run comes next.

    Args:
        config: What the first run is made of.
        waits: After each run another waits for the order to start it.
        is_reachable: Whether anyone may still order one.
    """

    def __init__(self, config: RunConfig, *, waits: bool, is_reachable: Callable[[], bool]) -> None:
        self._config, self._waits, self._is_reachable = config, waits, is_reachable
        self._lock = threading.Lock()
        self._ordered: OrderedRun | None = None
        self._before: PreparedRun | None = None
        self._is_interrupted = self._is_given_up = False
        self._count = 1

    def begin(self, prepared: PreparedRun) -> Runner:
        """Make a prepared run the one that is talked about from now on; it is not started here."""
        if self._before is None:
            prepared.hold_connector()
        self._before = prepared
        return prepared.runner

    # -- from any thread ----------------------------------------------------------------------------------------------

    def order(self, order: Order, on_end: OnOrderEnd) -> None:
        """Begin another run, since one is over; or, by a stop, none that was ordered."""
        if order.name == "stop":
            self._withdraw(OrderResult(f"it was stopped before it began: {order.role} ({order.channel})", "stopped"))
            on_end(OrderResult())
            return
        before = self._before
        result = self._judged(before, order) if before is not None else OrderResult("no run was prepared", "no_run")
        with self._lock:
            if not result.refused and self._ordered is not None:
                result = OrderResult("another start was ordered before it", "second")
            if not result.refused:
                self._ordered = OrderedRun(order, on_end)
        if result.refused:
            on_end(result)

    def interrupt(self, by: str) -> None:
        """Cancel the run; no other follows."""
        self._is_interrupted = True
        if self._before is not None:
            self._before.runner.cancel(by)

    def kill(self, by: str) -> None:
        """The e-stop."""
        self._is_interrupted = True
        if self._before is not None:
            self._before.runner.kill(by)

    def give_up(self) -> None:
        """No one can order anything any more: a run that waits to be started or resumed ends, now or later."""
        self._is_given_up = True
        self.changed()

    def changed(self) -> None:
        """The status of the run has changed."""
        if self._is_given_up and self._before is not None:
            runner = self._before.runner
            runner.call_soon(lambda: runner.cancel(NO_INPUT) if runner.waits or runner.view.mode == "paused" else None)

    @property
    def is_interrupted(self) -> bool:
        """Whether an interrupt, or an e-stop, ended the talk: no other run follows."""
        return self._is_interrupted

    # -- once a run is over -------------------------------------------------------------------------------------------

    @property
    def is_continued(self) -> bool:
        """Whether another run follows."""
        before = self._before
        if before is None or self._is_interrupted or before.why_last:
            return False
        return self._ordered is not None or (self._waits and not before.runner.waits and self._is_reachable())

    def following(self) -> PreparedRun | None:
        """The run that follows, ready; None where there is no other."""
        before = self._before
        if before is None or not self.is_continued:
            return None
        self._count += 1
        ordered = self._ordered
        given = {**self._config.arguments, **ordered.order.arguments} if ordered is not None else self._config.arguments
        return prepare_next(
            before,
            replace(
                self._config,
                arguments=given,
                waits=ordered is None,
                resume=None,
                journal=self._named(self._config.journal),
                record=self._named(self._config.record),
            ),
        )

    def follow(self, prepared: PreparedRun) -> None:
        """A run that followed is the one that is talked about now; what was ordered is carried out with it.

        A start that was ordered while the run was prepared begins it where it waits; one that was withdrawn meanwhile
        leaves it stopped before its start.
        """
        runner = self.begin(prepared)
        with self._lock:
            ordered, self._ordered = self._ordered, None
        if ordered is not None:
            ordered.on_end(OrderResult.of_start(runner.start(ordered.order.arguments) if runner.waits else ()))
        elif not runner.waits:
            runner.stop(WITHDRAWN)
        if self._is_interrupted:
            runner.cancel(BY)
        self.changed()

    def close(self) -> None:
        """No other run follows."""
        why_last = _why_last(self._before) if self._before is not None else OrderResult()
        self._withdraw(why_last if why_last.refused else OrderResult("the program ends", "closing"))

    def _withdraw(self, result: OrderResult) -> None:
        """No start is ordered any more."""
        with self._lock:
            ordered, self._ordered = self._ordered, None
        if ordered is not None:
            ordered.on_end(result)

    def _judged(self, before: PreparedRun, order: Order) -> OrderResult:
        given = {**self._config.arguments, **order.arguments}
        why_last = _why_last(before)
        return why_last if why_last.refused else OrderResult.of_start(argument_faults(before.mission, given))

    def _named(self, first: str | Path | None) -> Path | None:
        """The file of the next run: `errand-2.journal` after `errand.journal`."""
        return None if first is None else (path := Path(first)).with_stem(f"{path.stem}-{self._count}")


def _why_last(before: PreparedRun) -> OrderResult:
    """Why no other run may follow this one, which is over."""
    kind: RefusalKind = "locked" if before.runner.view.holder == "nobody" else "unsafe"
    return OrderResult(before.why_last, kind) if before.why_last else OrderResult()
