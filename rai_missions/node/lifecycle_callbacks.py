# SPDX-License-Identifier: Apache-2.0
"""What the transitions of a node's lifecycle do to its mission.

Rule: what only the connector's own thread could complete is never waited for; such a transition ends when the run has.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rai_missions.errors import UsageError
from rai_missions.node.managed_lifecycle import Finish
from rai_missions.node.order import ClientOrder, OrderReply, ignore_reply
from rai_missions.node.order_server import OrderServer
from rai_missions.node.run_session import RunSession

__all__ = ("DEACTIVATION", "LifecycleCallbacks")

INACTIVE = "the node is inactive; activate it first"
DEACTIVATION = "operator (deactivate)"
"""Who pauses a mission whose node is deactivated."""
UNCONFIGURED = "the node is unconfigured; configure and activate it first"


class LifecycleCallbacks:
    """The acts of one node, by the transition's label.

    Args:
        commands: Where its mission is begun and steered.
        ready: Reads and checks what a run is made of; raises where it is at fault.
        finalized: Called once the node has been shut down.
    """

    def __init__(self, commands: OrderServer, *, ready: Callable[[], None], finalized: Callable[[], None]) -> None:
        self._commands, self._ready, self._finalized = commands, ready, finalized
        self._is_to_resume = False
        commands.close(UNCONFIGURED)

    def by_label(self) -> Mapping[str, Callable[[Finish], None]]:
        """As `ManagedLifecycle` takes them."""
        return {
            "configure": self.configure,
            "activate": self.activate,
            "deactivate": self.deactivate,
            "cleanup": self.clean_up,
            "shutdown": self.shut_down,
            "error": self.recover,
        }

    def configure(self, finish: Finish) -> None:
        """Read and check; what is at fault leaves the node unconfigured."""
        self._ready()
        self._commands.close(INACTIVE)
        finish("")

    def activate(self, finish: Finish) -> None:
        """Take orders. Nothing moves by itself, but a mission that `deactivate` has paused continues."""
        self._commands.open()
        session = self._commands.live
        if not self._is_to_resume or session is None or session.mode != "paused":
            self._is_to_resume = False
            finish("")
            return

        def end(reply: OrderReply) -> None:
            self._is_to_resume = self._remains(reply)
            if self._is_to_resume:
                self._commands.close(INACTIVE)
            finish(reply.why if self._is_to_resume else "")

        self._commands.settle(ClientOrder("resume", "operator (activate)", role="operator"), end)

    def deactivate(self, finish: Finish) -> None:
        """Pause the mission that runs; one that has not begun to move yet is canceled."""
        session = self._commands.live
        if session is not None and session.mode == "canceling":
            raise UsageError("the mission is being canceled; deactivate the node when that has ended")
        if session is None or session.mode == "paused":
            self._commands.close(INACTIVE)
            finish("")
            return
        word = "cancel" if session.mode == "ready" else "pause"

        def end(reply: OrderReply) -> None:
            if self._remains(reply):
                finish(reply.why)
                return
            self._is_to_resume = word == "pause"
            self._commands.close(INACTIVE)
            finish("")

        self._commands.settle(ClientOrder(word, DEACTIVATION, role="operator"), end)

    def attend(self, session: RunSession) -> bool:
        """A run is about to begin; one whose node is not active by now is put to rest before it moves.

        Returns:
            Whether it resumes in the pause of a node that was deactivated, which this one is to be as well.
        """
        mode, closed = session.mode, self._commands.closed
        is_deactivated = mode == "paused" and session.runner.view.resumed_mode_by == DEACTIVATION
        is_late = closed == INACTIVE and mode == "running"
        self._is_to_resume = is_deactivated or is_late
        if is_late:
            session.runner.pause(DEACTIVATION)
        elif closed and not (closed == INACTIVE and mode == "paused"):
            session.runner.cancel(DEACTIVATION)
        return is_deactivated and not closed

    def _remains(self, reply: OrderReply) -> bool:
        """Whether a mission is under way as it was, because it refused an order."""
        return not reply.success and self._commands.live is not None

    def clean_up(self, finish: Finish) -> None:
        """Cancel the mission that is under way; it ends when that has ended."""
        self._wind_up("cancel", "operator (cleanup)")
        self._commands.when_idle(lambda: finish(""))

    def shut_down(self, finish: Finish) -> None:
        """As `clean_up`, for good."""

        def end() -> None:
            finish("")
            self._finalized()

        self._wind_up("cancel", "operator (shutdown)")
        self._commands.when_idle(end)

    def recover(self, finish: Finish) -> None:
        """Something broke: nothing that was begun continues."""
        self._wind_up("e_stop", "the node, which broke off")
        finish("")

    def _wind_up(self, word: str, by: str) -> None:
        self._commands.close(UNCONFIGURED)
        self._is_to_resume = False
        session = self._commands.live
        if session is not None:
            session.submit(ClientOrder(word, by, role="operator"), ignore_reply)
