# SPDX-License-Identifier: Apache-2.0
"""The gate at work: receives commands and requests over a connector, and passes on what its rules let through.

Rule: what is published leaves in the order of the rules' effects, whichever thread brought what. So nothing of a former
holder follows the stop that ended its hold.
"""

from __future__ import annotations

import json
import math
import threading
import time
import uuid
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Data, Message, OnMessage
from rai_missions.connectors.worker import SerialQueue
from rai_missions.gate.config import GateWords
from rai_missions.gate.memory import Memory
from rai_missions.gate.rules import step
from rai_missions.gate.state import (
    COMMANDERS,
    ActuatorCommand,
    Alive,
    Answer,
    ControlChange,
    Gate,
    GateEffect,
    GateEvent,
    Halt,
    Pass,
    PublishStatus,
    Refuse,
    Request,
    TimeUpdate,
    status_of,
)
from rai_missions.plain_data import json_value
from rai_missions.redaction import cut, logger
from rai_missions.runtime.clock import Clock, WallClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.states.control import HOLDERS

__all__ = ("GateAgent",)

log = logger(__name__)

STRING, EMPTY, TRIGGER = "std_msgs/msg/String", "std_msgs/msg/Empty", "std_srvs/srv/Trigger"


class GateAgent:
    """Serves a gate over a connector: passes on what the holder of control commands, and stops the rest; an `Agent`.

    Args:
        words: Its configuration.
        connector: Started by its maker; its `now` is the clock's.
        clock: Time; the wall's by default.
        observe: Receives each effect of the rules once it was carried out, in order.
        memory: Who held control when a gate was here last; without one it begins with its safe holder.
    """

    def __init__(
        self,
        words: GateWords,
        connector: Connector,
        *,
        clock: Clock | None = None,
        observe: Callable[[GateEffect], None] | None = None,
        memory: Memory | None = None,
    ) -> None:
        self._words, self._connector, self._observe, self._memory = words, connector, observe, memory
        self._clock: Clock = clock if clock is not None else WallClock()
        self._rules, self._topics = words.rules, {each.topic: each for each in words.commands}
        self._lock = threading.Lock()
        self._mailbox = Mailbox()
        self._waits_until = math.inf
        self._turns = SerialQueue()
        self._is_over = False
        self._is_closed = True
        self._closes: list[Close] = []
        self._thread: threading.Thread | None = None
        self._identity = [time.time(), uuid.uuid4().hex[:8]]
        first = memory.first(words.safe) if memory is not None else words.safe
        self.gate = Gate(holder=first, since=self._clock.now())
        """What it knows now."""
        self.gives_way = False
        """Another gate of this name was here before, so this one has ended: two would make two holders."""

    # -- its life --------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Begin on a thread of its own; returns at once."""
        if self._thread is None:
            self._is_over = False
            self._thread = threading.Thread(target=self.serve, name="gate")
            self._thread.start()

    def stop(self) -> None:
        """End, and leave the actuators stopped."""
        self.end()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join()

    def end(self) -> None:
        """Have `serve` return; from any thread, or a signal's handler."""
        self._is_over = True
        self._mailbox.wake()

    def serve(self) -> None:
        """Stay there until `end`."""
        try:
            self.open()
            while not self._is_over:
                with self._lock:
                    self._waits_until = self.gate.wake_at(self._rules)
                self._clock.wait(self._mailbox, self._waits_until, paced=False)
                self._mailbox.take()
                self.tick()
        finally:
            self.close()

    def open(self) -> None:
        """Stop the actuators, publish who holds control, and listen.

        Raises:
            ConnectorError: A type is not there, or a stop is no message of its topic's type.
        """
        name, self._is_closed = self._words.name, False
        for _, error in self._publish_stops():
            raise error
        if self._memory is not None:
            self._memory.note(self.gate.holder)
        for who in COMMANDERS:
            below = f"{name}/{who}"
            for topic in self._words.commands:
                self._subscribe(f"{below}{topic.topic}", topic.type, partial(self._command, who, topic.topic))
            self._subscribe(f"{below}/alive", EMPTY, partial(self._live, who))
            self._subscribe(f"{below}/request", STRING, partial(self._ask_by_message, who))
            for to in HOLDERS:
                service = f"{below}/hand_to_{to}"
                self._closes.append(self._connector.serve(service, TRIGGER, partial(self._serve, to, who)))
        self._subscribe(f"{name}/status", STRING, self._look_at_gate)
        self.tick()

    def close(self) -> None:
        """Receive nothing more, and stop the actuators."""
        while self._closes:
            self._closes.pop()()
        with self._lock:
            self._is_closed = True
        self._turns.post(partial(self._do, Halt("the gate has ended")))

    def _subscribe(self, topic: str, kind: str, on_message: OnMessage) -> None:
        self._closes.append(self._connector.subscribe(topic, kind, on_message))

    # -- what happens ----------------------------------------------------------------------------------------------

    def tick(self) -> None:
        """Do what is due."""
        self._take(TimeUpdate)

    def ask(self, to: str, by: str) -> Mapping[str, Any]:
        """Ask for control to go to someone; the answer is a std_srvs/srv/Trigger's."""
        for each in self._take(lambda at: Request(at, to, by)):
            if isinstance(each, Answer):
                holds = f"{to} holds control, grant {each.revision}"
                return {"success": not each.why, "message": each.why or holds}
        return {"success": False, "message": "the gate has ended"}

    def _serve(self, to: str, by: str, _: Data) -> Data:
        return self.ask(to, by)

    def _live(self, who: str, _: Message) -> None:
        self._take(lambda at: Alive(at, who))

    def _ask_by_message(self, who: str, message: Message) -> None:
        """`{"to": "agent"}`, or the name alone."""
        text = str(message.data.get("data", ""))
        request = json_value(text, text)
        to, by = (request.get("to"), request.get("by", who)) if isinstance(request, Mapping) else (request, who)
        if by != who:
            log.warning("%s asked for control in the name of %.60s; it speaks for itself alone", who, by)
        self.ask(cut(to, 60), who if by == who else cut(f"{who} as {by}", 60))

    def _look_at_gate(self, message: Message) -> None:
        """A status of this name: our own, or another gate's."""
        try:
            began, identity = json.loads(message.data["data"])["gate"]
            is_older = [float(began), str(identity)] < self._identity
        except (KeyError, TypeError, ValueError, OverflowError, RecursionError):
            return
        if is_older and not self.gives_way:
            self.gives_way = True
            log.critical("another gate is at %s already; this one ends", self._words.name)
            self.end()

    def _command(self, who: str, topic: str, message: Message) -> None:
        made = message.at if message.age_s is not None else math.inf
        self._take(lambda at: ActuatorCommand(at, who, topic, message.data, made))

    # -- what is done ----------------------------------------------------------------------------------------------

    def _take(self, happening: Callable[[float], GateEvent]) -> tuple[GateEffect, ...]:
        """Ask the rules, and do what they state."""
        with self._lock:
            if self._is_closed:
                return ()
            self.gate, done = step(self._rules, self.gate, happening(self._clock.now()))
            for effect in done:
                self._turns.put(partial(self._do, effect))
            if self.gate.wake_at(self._rules) < self._waits_until:
                self._mailbox.wake()
        self._turns.run()
        return done

    def _do(self, effect: GateEffect) -> None:
        try:
            if isinstance(effect, Pass):
                words = self._topics[effect.command.topic]
                self._connector.publish(words.topic, words.type, effect.command.data)
            elif isinstance(effect, ControlChange | Halt):
                for topic, error in self._publish_stops():
                    log.error("the stop of %s was not published", topic, exc_info=error)
                if self._memory is not None and isinstance(effect, ControlChange):
                    self._memory.note(effect.holder)
            elif isinstance(effect, PublishStatus):
                self._publish(effect.gate)
            if self._observe is not None:
                self._observe(effect)
        except Exception:
            log.exception("not done: %.200s", effect)
        if isinstance(effect, ControlChange):
            log.info("control goes from %s to %s: %s", effect.former, effect.holder, effect.why)
        elif isinstance(effect, Refuse):
            log.debug("refused: %s", effect)

    def _publish_stops(self) -> list[tuple[str, Exception]]:
        """Stop what each topic moves, whatever becomes of the others; returns the topics that failed, and why."""
        failed = list[tuple[str, Exception]]()
        for each in self._words.commands:
            if each.stop_message is None:
                continue
            try:
                self._connector.publish(each.topic, each.type, each.stop_message)
            except Exception as error:  # noqa: BLE001 - of whatever connector
                failed.append((each.topic, error))
        return failed

    def _publish(self, gate: Gate) -> None:
        status = {"gate": self._identity, **status_of(gate, self._rules), "commands": list(self._topics)}
        self._connector.publish(f"{self._words.name}/status", STRING, {"data": json.dumps(status)})
        self._connector.publish(f"{self._words.name}/holder", STRING, {"data": gate.holder})
