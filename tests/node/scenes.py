# SPDX-License-Identifier: Apache-2.0
"""A small mission with a question, a robot made of services, and a client that speaks standard messages."""

from __future__ import annotations

import json
import uuid
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Connector, Message, Reply
from rai_missions.connectors.contract import Inbox
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot

__all__ = ("Client", "FakeRobot", "mission", "robot")

STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
PATIENCE_S = 30.0


def mission(**words: Any) -> Mission:
    """Waits; on `go` it moves until the robot is there, on `ask` it asks the operator, on `guess` a model alone."""
    asked = {"options": {"left": {}, "right": {}}, "deadline_s": 600, "fallback": "right"}
    seen = [{"on": "left", "to": "over"}, {"on": "right", "to": "waiting"}]
    return Mission.model_validate(
        {
            "name": "errand", "version": "1.2.3", "initial": "waiting", "events": ["go", "ask", "guess", "unlisted"],
            "blackboard": {
                "there": {"type": "boolean", "source": "robot", "optional": True, "max_age_s": 600},
                "speed": {"type": "number", "source": "argument", "initial": 1.0},
            },
            "states": {
                "waiting": {
                    "transitions": [
                        {"on": "go", "to": "moving"}, {"on": "ask", "to": "asking"}, {"on": "guess", "to": "guessing"},
                        {"on": "unlisted", "to": "over"},
                    ]
                },
                "moving": {
                    "action": "move", "timeout_s": 600, "achieved": {"key": "there", "==": True},
                    "transitions": [{"on": "succeeded", "to": "done"}],
                },
                "asking": {"decision": {"question": "Which way?", "ask": ["operator"], **asked}, "transitions": seen},
                "guessing": {"decision": {"question": "Guess?", "ask": ["agent"], **asked}, "transitions": seen},
                "done": {"final": "succeeded", "requires": {"key": "there", "==": True}},
                "over": {"final": "aborted"},
            },
            **words,
        }
    )  # fmt: skip


def robot(connector: Mapping[str, Any], below: str = "/robot") -> Robot:
    """Three services' worth of a robot."""
    return Robot.model_validate(
        {
            "name": "fake",
            "connector": dict(connector),
            "blackboard": {"there": {"topic": f"{below}/there", "type": "std_msgs/msg/Bool"}},
            "events": {name: {"posted": True} for name in ("go", "ask", "guess")}
            | {"unlisted": {"topic": f"{below}/unlisted", "type": "std_msgs/msg/Empty"}},
            "actions": {
                "move": {
                    "start": f"{below}/move",
                    "cancel": f"{below}/halt",
                    "succeeded": {"key": "there", "==": True},
                    "uses": ["base"],
                }
            },
        }
    )


class FakeRobot:
    """The robot: reports what it was asked to do, and arrives when it is asked to."""

    def __init__(self, connector: Connector, below: str = "/robot") -> None:
        self.asked: Inbox[str] = Inbox(PATIENCE_S)
        self.obey: Callable[[str], object] = self.asked
        """Reported what the robot is asked to do, before it answers."""
        self._connector, self._below = connector, below
        for word in ("move", "halt"):
            connector.serve(f"{below}/{word}", TRIGGER, self._does(word))

    def _does(self, word: str) -> Callable[[Any], Any]:
        def answer(_request: Any) -> Any:
            self.obey(word)
            return {"success": True, "message": ""}

        return answer

    def arrive(self) -> None:
        self._connector.publish(f"{self._below}/there", "std_msgs/msg/Bool", {"data": True})


class Client:
    """Any program on the graph: it knows the node's name and standard messages."""

    def __init__(self, connector: Connector, path: str) -> None:
        self.connector, self.path = connector, path
        self.statuses: Inbox[dict[str, Any]] = Inbox(PATIENCE_S)
        self.replies: Inbox[dict[str, Any]] = Inbox(PATIENCE_S)
        self.steps: Inbox[dict[str, Any]] = Inbox(PATIENCE_S)
        self.holders: Inbox[str] = Inbox(PATIENCE_S)
        self.moves: Inbox[tuple[str, str]] = Inbox(PATIENCE_S)
        for name, received in (("status", self.statuses), ("reply", self.replies), ("step", self.steps)):
            connector.subscribe(f"{path}/{name}", STRING, _json_to(received))
        connector.subscribe(f"{path}/control", STRING, lambda message: self.holders(message.data["data"]))
        event = "lifecycle_msgs/msg/TransitionEvent"
        connector.subscribe(f"{path}/transition_event", event, lambda received: self.moves(_move(received.data)))

    def call(self, name: str, kind: str = TRIGGER, **request: Any) -> Mapping[str, Any]:
        """Call a service of the node's; its response."""
        replies: Inbox[Reply] = Inbox(PATIENCE_S)
        self.connector.call(f"{self.path}/{name}", kind, request, on_reply=replies, timeout_s=PATIENCE_S)
        (reply,) = replies.wait(bool, f"{name} answers")
        assert reply.outcome == "succeeded", (name, reply)
        return reply.data

    def change(self, label: str = "", number: int = 0) -> bool:
        """Ask for a transition of the node's lifecycle."""
        transition = {"id": number, "label": label}
        return bool(self.call("change_state", "lifecycle_msgs/srv/ChangeState", transition=transition)["success"])

    def state(self) -> str:
        """The node's state."""
        return str(self.call("get_state", "lifecycle_msgs/srv/GetState")["current_state"]["label"])

    def activate(self) -> None:
        assert self.change("configure") and self.change("activate"), self.statuses.all

    def command(self, text: str | None = None, /, **words: Any) -> dict[str, Any]:
        """Send a command, and wait for its reply."""
        name = uuid.uuid4().hex[:8]
        sent = json.dumps({"id": name, **words}) if text is None else text
        before = len(self.replies.all)
        self.connector.publish(f"{self.path}/command", STRING, {"data": sent})

        def on_reply(all_: list[dict[str, Any]]) -> bool:
            return any(each["id"] == name for each in all_) or (text is not None and len(all_) > before)

        reported = self.replies.wait(on_reply, f"a reply to {sent[:200]}")
        return next((each for each in reported if each["id"] == name), reported[-1])

    def await_status(self, what: str, **fields: Any) -> dict[str, Any]:
        """Wait until the latest status states it."""

        def states(all_: list[dict[str, Any]]) -> bool:
            return bool(all_) and all(all_[-1][word] == value for word, value in fields.items())

        return self.statuses.wait(states, what)[-1]

    def start(self) -> None:
        """Start a run, and wait until it runs."""
        assert self.call("start")["success"]
        self.await_status("it runs", mode="running")


def _json_to(received: Inbox[dict[str, Any]]) -> Callable[[Message], None]:
    return lambda message: received(json.loads(message.data["data"]))


def _move(data: Mapping[str, Any]) -> tuple[str, str]:
    return data["transition"]["label"], data["goal_state"]["label"]
