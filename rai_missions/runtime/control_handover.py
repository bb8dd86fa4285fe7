# SPDX-License-Identifier: Apache-2.0
"""Has control handed over where the actuators are, and reports there that the run is alive.

Rule: who holds control is what the robot reports. Where that has a source of its own, no reply of a service counts.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import Connector, Reply
from rai_missions.event import Event, Origin
from rai_missions.profile import Robot, ServiceEntry
from rai_missions.redaction import logger
from rai_missions.runtime.scheduler import Scheduler

__all__ = ("Handovers",)

log = logger(__name__)

Wish = tuple[str, str, Origin | None]
"""Who is to have control, who asks, and in which role."""
ANSWERED_S = 10.0
"""A handover that is not answered by then has failed."""


class Handovers:
    """What a run has to do with control.

    Args:
        robot: The profile; without a service for it control changes at once.
        connector: How the robot is reached.
        scheduler: When the run reports that it is alive, and where acknowledgements go.
        on_lost: Receives who does not get control that was asked for, and whether that was refused; from any thread.
    """

    def __init__(
        self,
        robot: Robot,
        connector: Connector | None,
        scheduler: Scheduler,
        on_lost: Callable[[str, bool], None],
    ) -> None:
        self._robot, self._connector = robot, connector
        self._scheduler, self._lost = scheduler, on_lost
        self.letting_go: bool | None = None
        """True while an e-stop waits for control to be with `nobody`; None where it never had to."""

    def open(self) -> None:
        """Report that the run is alive, for as long as its scheduler is run."""
        self._report_alive()

    def hand_over(self, to: str, by: str, role: Origin | None = None) -> None:
        """Have control handed over; the acknowledgement comes back as an event.

        Args:
            to: Who is to have it.
            by: Who asks, for people.
            role: Whose request it is; None for the mission's own.
        """
        robot = self._robot
        entry = robot.control.get(to)
        if robot.holder is not None and entry is None:
            log.warning("control does not go to %s: the profile's 'control' has no service for it", to)
            self._lost(to, False)
        elif entry is None or self._connector is None:
            self._acknowledged(to, by, role)
        else:
            self._call(self._connector, entry, (to, by, role), lambda: None)

    def let_go(self, done: Callable[[], None]) -> None:
        """The e-stop has taken control from everybody: so it shall be where the actuators are.

        Args:
            done: Called when it is, or cannot be; from any thread. `letting_go` is false by then.
        """
        entry = self._robot.control.get("nobody")
        if entry is None or self._connector is None or self.letting_go is not None:
            return
        self.letting_go = True

        def over() -> None:
            self.letting_go = False
            done()

        self._call(self._connector, entry, ("nobody", "mission", None), over)
        # A connector that breaks its promise, and never reports that no answer came, holds up no stop.
        self._scheduler.call_at(self._scheduler.now() + 2 * ANSWERED_S, over)

    def _call(self, connector: Connector, entry: ServiceEntry, wish: Wish, done: Callable[[], None]) -> None:
        to, _, role = wish

        def answered(reply: Reply) -> None:
            if not entry.succeeded(reply.outcome, reply.data):
                log.warning("control does not go to %s: %s", to, reply.why or reply.data.get("message", reply.outcome))
                self._lost(to, reply.outcome == "succeeded")
            elif self._robot.holder is None:
                self._acknowledged(*wish)
            done()

        service = entry.service.replace("{by}", "operator" if role == "operator" else "agent")
        try:
            connector.call(service, entry.type, entry.request_of({}), on_reply=answered, timeout_s=ANSWERED_S)
        except (Exception, SystemExit):
            log.exception("control could not be handed to %s", to)
            self._lost(to, False)
            done()

    def _acknowledged(self, to: str, by: str, role: Origin | None) -> None:
        data = {"by": by} if role is None else {"by": by, "role": role}
        self._scheduler.post(Event(to, self._scheduler.now(), data, "control"))

    def _report_alive(self) -> None:
        entry = self._robot.alive
        if entry is None or self._connector is None:
            return
        try:
            self._connector.publish(entry.topic, entry.type, {})
        except (Exception, SystemExit):
            log.exception("the actuators' side cannot be reported to that the run is alive")
        self._scheduler.call_at(self._scheduler.now() + entry.every_s, self._report_alive)
