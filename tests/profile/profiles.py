# SPDX-License-Identifier: Apache-2.0
"""The tractor of the guide, as a mission and as a profile."""

from __future__ import annotations

import copy
from typing import Any

from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot

__all__ = ("MISSION", "PROFILE", "altered", "mission", "robot")

TRIGGER = "std_srvs/srv/Trigger"
DRIVEN = {"key": "alleys_driven", ">=": {"key": "alleys"}}

PROFILE: dict[str, Any] = {
    "format": 1,
    "name": "tractor1, simulated",
    "connector": {"kind": "local", "world": "orchard", "seed": 7},
    "blackboard": {
        "alleys_driven": {"topic": "/tractor1/alleys_driven", "type": "std_msgs/msg/Int32"},
        "battery": {"topic": "/tractor1/battery", "type": "sensor_msgs/msg/BatteryState", "field": "percentage"},
        "camera": {"topic": "/tractor1/camera_image_color", "type": "sensor_msgs/msg/Image"},
        "obstacle": {"topic": "/tractor1/obstacle", "type": "std_msgs/msg/String", "json": True},
        "pose": {"topic": "/tractor1/pose", "type": "geometry_msgs/msg/PoseStamped"},
    },
    "events": {
        "anomaly": {
            "service": "/tractor1/current_state",
            "type": TRIGGER,
            "every_s": 0.2,
            "when": {"key": "message", "==": "STOPPED"},
            "fields": {"reported": "message"},
        },
        "go": {"posted": True},
    },
    "actions": {
        "drive_alleys": {
            "start": "/tractor1/continue",
            "cancel": "/tractor1/stop",
            "succeeded": DRIVEN,
            "uses": ["base"],
        },
        "go_home": {
            "action": "/navigate_to_pose",
            "type": "nav2_msgs/action/NavigateToPose",
            "uses": ["base"],
            "keep": True,
            "goal": {"pose": {"from": "home", "as": "geometry_msgs/msg/PoseStamped"}, "behavior_tree": ""},
        },
    },
    "services": {"horn": {"service": "/tractor1/flash", "type": TRIGGER, "repeat": True}},
    "topics": {"status": {"topic": "/tractor1/status", "type": "std_msgs/msg/String"}},
    "rules": {"assessing": [{"when": {"key": "obstacle.height_m", "<": 0.2}, "answer": "go_on"}, {"answer": "stop"}]},
    "tools": {"read": ["/tractor1/*"], "write": ["/tractor1/flash"], "never": ["/cmd_vel", "*/e_stop"]},
}

MISSION: dict[str, Any] = {
    "format": 1,
    "name": "alleys",
    "blackboard": {
        "alleys": {"type": "integer", "source": "argument", "initial": 6},
        "home": {"type": "pose", "source": "argument", "initial": {"x": 0.0, "y": 0.0}},
        "alleys_driven": {"type": "integer", "source": "robot"},
        "battery": {"type": "number", "source": "robot", "max_age_s": 10},
        "camera": {"type": "image", "source": "robot"},
        "obstacle": {"type": "object", "source": "robot", "optional": True},
        "pose": {"type": "pose", "source": "robot"},
    },
    "events": {"anomaly": {"fields": {"reported": "string"}}, "go": {}, "tired": {}},
    "initial": "driving",
    "states": {
        "driving": {
            "action": "drive_alleys",
            "timeout_s": 900,
            "entry": [{"publish": "status", "message": {"data": "driving"}}],
            "transitions": [
                {"on": "anomaly", "to": "assessing", "do": [{"raise": "tired", "after_s": 5}]},
                {"on": "succeeded", "to": "returning"},
            ],
        },
        "assessing": {
            "decision": {"question": "What now?", "options": {"go_on": {}, "stop": {}}, "fallback": "stop"},
            "transitions": [{"on": "go_on", "to": "warning"}, {"on": "stop", "to": "returning"}],
        },
        "warning": {
            "tree": {"sequence": [{"call": "horn", "timeout_s": 2}, {"wait_s": 1}]},
            "transitions": [{"on": ["succeeded", "failed"], "to": "driving"}],
        },
        "returning": {
            "action": "go_home",
            "goal": {"home": {"from": "home"}},
            "transitions": [{"on": "succeeded", "to": "done"}],
        },
        "done": {"final": "succeeded", "requires": DRIVEN},
    },
}


def altered(document: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    """A document with other values at dotted places; None takes the word out."""
    made = copy.deepcopy(document)
    for place, value in change.items():
        *outer, last = place.split("/")
        inner = made
        for word in outer:
            inner = inner[word]
        if value is None:
            del inner[last]
        else:
            inner[last] = value
    return made


def robot(change: dict[str, Any] | None = None) -> Robot:
    return Robot.model_validate(altered(PROFILE, change or {}))


def mission(change: dict[str, Any] | None = None) -> Mission:
    return Mission.model_validate(altered(MISSION, change or {}))
