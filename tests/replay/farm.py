# SPDX-License-Identifier: Apache-2.0
"""A land with more to do: composed actions, control that is handed over, and keys that are reported again and again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.profile import Robot
from tests.replay.mortal import Land, Wish
from tests.strategies import SIGHTS

__all__ = ("FARMER", "Farm")

TRIGGER, ACTION = "std_srvs/srv/Trigger", "x/action/X"
ACTIONS = ("move", "turn", "look", "drive", "cross", "go_home")


def composed(name: str, *, repeat: bool) -> dict[str, Any]:
    return {"start": f"/{name}_start", "cancel": f"/{name}_stop", "succeeded": {"key": f"{name}s", ">=": 1},
            "uses": [name], "repeat": repeat}  # fmt: skip


FARMER = Robot.model_validate(
    {
        "name": "farmer",
        "blackboard": {
            "hauls": {"topic": "/hauls", "type": "std_msgs/msg/Int32"},
            "tows": {"topic": "/tows", "type": "std_msgs/msg/Int32"},
            "battery": {"topic": "/battery", "type": "std_msgs/msg/Float64"},
            "clear": {"topic": "/clear", "type": "std_msgs/msg/Bool"},
            "pose": {"topic": "/pose", "type": "geometry_msgs/msg/PoseStamped"},
            "obstacle": {"topic": "/obstacle", "type": "std_msgs/msg/String", "json": True},
            "objects": {"topic": "/objects", "type": "std_msgs/msg/String", "json": True},
        },
        "actions": {
            **{
                name: {"action": f"/{name}", "type": ACTION, "uses": ["head" if name == "look" else "base"]}
                for name in ACTIONS
            },
            "kept": {"action": "/look", "type": ACTION, "uses": ["head"], "keep": True},
            "haul": composed("haul", repeat=False),
            "tow": composed("tow", repeat=True),
        },
        "services": {
            "horn": {"service": "/horn", "type": TRIGGER, "repeat": True},
            "lamp": {"service": "/lamp", "type": TRIGGER},
            "replan": {"service": "/replan", "type": TRIGGER},
        },
        "topics": {
            "light": {"topic": "/lamp_topic", "type": "std_msgs/msg/Bool", "repeat": True},
            "lamp": {"topic": "/once_topic", "type": "std_msgs/msg/Bool"},
            "say": {"topic": "/spoken", "type": "std_msgs/msg/String", "repeat": True},
        },
        "events": {name: {"posted": True} for name in ("go", "anomaly", "halt", "poke", "hint")},
        "control": {
            "agent": "/to_agent",
            "autonomy": "/to_autonomy",
            "operator": "/to_operator",
            "nobody": "/to_nobody",
        },
        "holder": {"topic": "/holder", "type": "std_msgs/msg/String"},
    }
)


class Farm(Land):
    """A land with composed actions, a holder of control, and topics.

    Args:
        wishes: What someone outside wants.
        lasts_s: Action → how long it takes; of composed ones, too.
        ends: Action → how its goals end.
        silent: Topics on which nothing is reported.
    """

    def __init__(
        self,
        wishes: Sequence[Wish] = (),
        lasts_s: Mapping[str, float] | None = None,
        ends: Mapping[str, str] | None = None,
        silent: frozenset[str] = frozenset(),
    ) -> None:
        lasts = {**dict.fromkeys(ACTIONS, 3.0), "haul": 3.0, "tow": 3.0, **(lasts_s or {})}
        self.composed = {name: lasts.pop(name) for name in ("haul", "tow")}
        super().__init__(wishes, lasts, ends or {})
        self.until: dict[str, float] = {}
        self.done = dict.fromkeys(self.composed, 0)
        self.holder, self.silent = "autonomy", silent
        for name in self.composed:
            self.connector.serve(f"/{name}_start", TRIGGER, lambda _, name=name: self._start(name))
            self.connector.serve(f"/{name}_stop", TRIGGER, lambda _, name=name: self._stop(name))
        for holder in ("agent", "autonomy", "operator", "nobody"):
            self.connector.serve(f"/to_{holder}", TRIGGER, lambda _, holder=holder: self._hand_over(holder))
        self.connector.serve("/replan", TRIGGER, lambda _: self._serve("/replan"))
        for topic, kind in (("/spoken", "String"), ("/once_topic", "Bool")):
            self.connector.subscribe(
                topic, f"std_msgs/msg/{kind}", lambda _, topic=topic: self.received.update([topic])
            )

    @property
    def running(self) -> list[str]:
        return [*super().running, *self.until]

    def _start(self, name: str) -> Mapping[str, Any]:
        self.started.append((name, f"{name} {len(self.started)}"))
        self.called[f"/{name}_start"] += 1
        self.until.setdefault(name, self.at + self.composed[name])
        return {"success": True, "message": ""}

    def _stop(self, name: str) -> Mapping[str, Any]:
        self.until.pop(name, None)
        return {"success": True, "message": ""}

    def _hand_over(self, to: str) -> Mapping[str, Any]:
        self.holder = to
        return {"success": True, "message": ""}

    def live_on(self) -> None:
        for name in [name for name, until in self.until.items() if until <= self.at]:
            del self.until[name]
            self.done[name] += 1
        states: list[tuple[str, str, Mapping[str, Any]]] = [
            ("/holder", "String", {"data": self.holder}),
            *((f"/{name}s", "Int32", {"data": done}) for name, done in self.done.items()),
            ("/battery", "Float64", {"data": 0.8}),
            ("/clear", "Bool", {"data": True}),
            ("/objects", "String", {"data": SEEN}),
        ]
        for topic, kind, message in states:
            if topic not in self.silent:
                self.connector.publish(topic, f"std_msgs/msg/{kind}", message)
        if "/pose" not in self.silent:
            self.connector.publish("/pose", "geometry_msgs/msg/PoseStamped", POSE)


SEEN = json.dumps(SIGHTS[0])
POSE = {
    "header": {"frame_id": "map"},
    "pose": {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
}
