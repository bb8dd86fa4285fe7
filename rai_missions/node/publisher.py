# SPDX-License-Identifier: Apache-2.0
"""What the node publishes: status, control, steps, transitions, replies, diagnostics.

Rule: each status is numbered here, under one lock, so that revisions rise in the order in which they are published.
The run's thread only hands over; messages are made on the publisher's.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable

from rai_missions.agents.run_claims import RunClaims
from rai_missions.connectors.connector import Message
from rai_missions.connectors.worker import Worker
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError
from rai_missions.mission.json_reader import parse_json
from rai_missions.node.diagnostics import Symptoms, array_of
from rai_missions.node.lifecycle_table import NodeTransition
from rai_missions.node.managed_lifecycle import EVENT_TYPE, event_fields
from rai_missions.node.names import NodeName
from rai_missions.node.order import OrderReply
from rai_missions.node.rosout import LOG, LogLines, lines_of
from rai_missions.node.run_host import RunHost
from rai_missions.node.run_session import RunSession
from rai_missions.node.services import STRING
from rai_missions.node.status_message import StatusMessage, step_fields, step_text, text_of
from rai_missions.node.transport import LOG_TOPIC, PACKAGE, Carrier
from rai_missions.plain_data import carried
from rai_missions.redaction import cut, logger
from rai_missions.runtime.lifecycle import Status

__all__ = ("StatusPublisher",)

log = logger(__name__)

DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
LONGEST_QUEUE = 10_000
"""Messages that may wait to be published; beyond that the oldest are dropped."""
DIAGNOSE_S, FAREWELL_S = 1.0, 5.0
IDLE = StatusMessage(0, "", "", "", "", "", "", "idle", "autonomy")


class StatusPublisher:
    """Publishes for one node.

    Args:
        carrier: What carries it; started before anything is published.
        name: The node's.
        host: Has the node's runs.
        lifecycle: The label of the node's state, and why its last transition failed.
    """

    def __init__(
        self, carrier: Carrier, name: NodeName, host: RunHost, lifecycle: Callable[[], tuple[str, str]]
    ) -> None:
        self._carrier, self._name, self._host, self._lifecycle = carrier, name, host, lifecycle
        self._lock = threading.Lock()
        self._last = IDLE
        self._holder = ""
        self._instance = uuid.uuid4().hex[:12]
        self._strangers: set[str] = set()
        self._claims = RunClaims(carrier.connector, name.namespace, instance=self._instance, node=name.path)
        self._outlet = Worker("publisher", limit=LONGEST_QUEUE, keep="newest")
        self.lines = LogLines(self._logger, self.log)
        self._on_status: Callable[[StatusMessage], None] = lambda _: None

    @property
    def _logger(self) -> str:
        """The node's name as ROS writes that of its logger."""
        return self._name.path.strip("/").replace("/", ".")

    def follow(self, on_status: Callable[[StatusMessage], None]) -> None:
        """Have something called with each status that is published, on the publisher's thread."""
        self._on_status = on_status

    def open(self) -> None:
        """Publish from now on: how things are, and the lines of the log."""
        self._outlet.start()
        self._outlet.post(self._diagnose)
        self._outlet.every(DIAGNOSE_S, self._diagnose)
        self.lines.open()
        self.changed()

    def close(self) -> None:
        """Publish what waits, and end; it may be opened again."""
        self.lines.close()
        self._outlet.close(FAREWELL_S)

    def log(self, line: dict[str, object]) -> None:
        """Publish a line of the log."""
        self._outlet.post(lambda: self._carrier.connector.publish(LOG_TOPIC, LOG, carried(line)))

    def changed(self) -> None:
        """Something may have changed: report it, if it has."""
        with self._lock:
            now = self._now()
            if now._replace(questions=()) == self._last._replace(at=0.0, questions=()) and _numbers(now) == _numbers(
                self._last
            ):
                return
            self._last = latest = now._replace(revision=self._last.revision + 1, at=time.time())
            self._outlet.post(lambda: self._publish_status(latest))

    def _now(self) -> StatusMessage:
        """How things are, under the revision of the last status."""
        session, (mission, version), (label, fault) = self._host.session, self._host.about, self._lifecycle()
        idle = IDLE._replace(
            revision=self._last.revision,
            node=self._name.path,
            instance=self._instance,
            mission=mission,
            version=version,
            lifecycle=label,
            fault=fault,
        )
        if session is None:
            return idle
        result = session.result
        status = session.status or Status(0, session.mode, self._last.control, ())
        now = idle._replace(
            run=session.runner.run_id,
            mode=session.mode,
            questions=session.questions(),
            control=status.control,
            active=status.active,
            open_goals=status.open_goals if result is None else result.open_goals,
            why=session.error or (status.why if result is None else result.why),
        )
        if session.is_over:
            return now._replace(outcome=session.mode)
        return now._replace(waits=status.waits, held_by=status.held_by, held_since=status.held_since or 0.0)

    def step(self, step: Step, run: str) -> None:
        """A step was made; one that changed nothing is left out."""
        if not (step.ignored and step.event.kind in ("write", "tick", "feedback")):
            self._outlet.post(lambda: self._publish_step(step, run))
        for line in lines_of(step, self._logger) if step.effects else ():
            self.log(line)

    def moved(self, way: NodeTransition) -> None:
        """The node's lifecycle has moved."""
        fields = event_fields(way)
        self._outlet.post(lambda: self._publish("transition_event", EVENT_TYPE, fields))
        self.changed()

    def reply(self, reply: OrderReply) -> None:
        """Report what became of an order."""
        text = text_of({"id": reply.id, "success": reply.success, "why": reply.why})
        self._outlet.post(lambda: self._publish("reply", STRING, {"data": text}))

    def receive(self, message: Message) -> None:
        """A status was published under the node's name; by another, if it is none of ours."""
        try:
            found = parse_json(str(message.data.get("data", "")).encode("utf-8", "replace"))
        except DefinitionError:
            found = {}
        stranger = cut(found.get("instance", ""), 64) if isinstance(found, dict) else ""
        if stranger != self._instance and stranger not in self._strangers and len(self._strangers) < 16:
            self._strangers.add(stranger)
            log.warning("another node is called %s too; give one of them another name with --node", self._name.path)

    def receive_run(self, message: Message) -> None:
        """A program has reported what its run commands."""
        self._claims.receive(message)

    # -- on the publisher's thread --------------------------------------------------------------------------------

    def _publish_status(self, status: StatusMessage) -> None:
        self._publish("status", STRING, {"data": text_of(status.data())})
        if self._carrier.typed:
            self._publish("mission_status", f"{PACKAGE}/msg/MissionStatus", status.fields())
        if status.control != self._holder:
            self._holder = status.control
            self._publish("control", STRING, {"data": status.control})
        self._on_status(status)
        self._diagnose()

    def _publish_step(self, step: Step, run: str) -> None:
        text = step_text(step, run)
        self._publish("step", STRING, {"data": text})
        if self._carrier.typed:
            self._publish("mission_step", f"{PACKAGE}/msg/Step", step_fields(step, run, text))

    def _diagnose(self) -> None:
        with self._lock:
            status = self._last
        session, robot = self._host.session, self._host.robot
        stale, sources = (session.stale(), session.sources()) if session is not None else ((), {})
        symptoms = Symptoms(stale, len(self._strangers), sources, self._rivals(session))
        fields = array_of(status, symptoms, at=time.time(), robot=robot.name if robot is not None else "")
        self._carrier.connector.publish("/diagnostics", DIAGNOSTICS, carried(fields))

    def _rivals(self, session: RunSession | None) -> tuple[str, ...]:
        """Report what the run commands; a sentence of each other mission that commands it too."""
        if session is None:
            return self._claims.exchange(None, ())
        is_live = self._carrier.robots and not session.is_over
        return self._claims.exchange(session.runner, session.commands if is_live else ())

    def _publish(self, name: str, type_name: str, fields: dict[str, object]) -> None:
        self._carrier.connector.publish(self._name.below(name), type_name, carried(fields))


def _numbers(status: StatusMessage) -> tuple[int, ...]:
    return tuple(each.question.number for each in status.questions)
