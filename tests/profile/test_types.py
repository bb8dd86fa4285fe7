# SPDX-License-Identifier: Apache-2.0
"""Which types a mission meets on a robot, and what is notified of those that are not here."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, endpoints, lacking, load_profile

MISSIONS = Path(__file__).parents[2] / "missions"
SHIPPED = sorted(MISSIONS.glob("*/robot.*.json"))


@pytest.mark.parametrize("profile", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_every_type_of_a_shipped_profile_is_met_with_its_place(profile: Path) -> None:
    robot = load_profile(profile)
    missions = [path for path in profile.parent.glob("*.json") if not path.name.startswith("robot.")]
    found = [each for mission in missions for each in endpoints(robot, load(mission))]
    assert all(each.type.split("/")[1] == each.kind for each in found)
    text = profile.read_text(encoding="utf-8")
    assert {each.type for each in found} >= {kind for kind in ("nav2_msgs/action/NavigateToPose",) if kind in text}
    received = set(robot.blackboard)
    assert received == {each.place[1] for each in found if each.place[0] == "blackboard"}


MISSION = Mission.model_validate(
    {
        "name": "m",
        "blackboard": {"here": {"type": "boolean", "source": "robot", "max_age_s": 5}},
        "initial": "a",
        "states": {
            "a": {
                "action": "go",
                "timeout_s": 9,
                "exit": [{"publish": "light"}],
                "transitions": [{"on": "failed", "to": "b"}],
            },
            "b": {"call": "bell", "timeout_s": 2, "transitions": [{"on": "succeeded", "to": "c"}]},
            "c": {"action": "made", "timeout_s": 9, "transitions": [{"on": "failed", "to": "z"}]},
            "z": {"final": "aborted"},
        },
    }
)
ROBOT = Robot.model_validate(
    {
        "name": "r",
        "blackboard": {
            "here": {"topic": "/here", "type": "p/msg/Here"},
            "there": {"topic": "/there", "type": "p/msg/T"},
        },
        "actions": {
            "go": {"action": "/go", "type": "p/action/Go"},
            "made": {"start": {"service": "/s", "type": "p/srv/S"}, "succeeded": {"key": "here", "==": True}},
            "fly": {"action": "/fly", "type": "p/action/Fly"},
        },
        "services": {
            "bell": {"service": "/bell", "type": "p/srv/Bell"},
            "horn": {"service": "/horn", "type": "p/srv/Horn"},
        },
        "topics": {"light": {"topic": "/light", "type": "p/msg/Light"}},
        "control": {"agent": {"service": "/hand", "type": "p/srv/Hand"}},
        "holder": {"topic": "/holder", "type": "p/msg/Holder"},
        "alive": {"topic": "/alive", "type": "p/msg/Alive"},
    }
)


def test_what_the_mission_does_not_use_need_not_be_here() -> None:
    assert [(each.type_place, each.kind, each.type) for each in endpoints(ROBOT, MISSION)] == [
        ("/blackboard/here/type", "msg", "p/msg/Here"),
        ("/holder/type", "msg", "p/msg/Holder"),
        ("/actions/go/type", "action", "p/action/Go"),
        ("/services/bell/type", "srv", "p/srv/Bell"),
        ("/actions/made/start", "srv", "p/srv/S"),
        ("/control/agent", "srv", "p/srv/Hand"),
        ("/topics/light/type", "msg", "p/msg/Light"),
        ("/alive/type", "msg", "p/msg/Alive"),
    ]


def test_what_is_not_here_is_reported_all_at_once_with_why() -> None:
    faults = lacking(MISSION, ROBOT, lambda name, kind: "" if kind == "msg" else f"no {name}")
    assert [str(fault) for fault in faults] == [
        "/actions/go/type: no p/action/Go",
        "/services/bell/type: no p/srv/Bell",
        "/actions/made/start: no p/srv/S",
        "/control/agent: no p/srv/Hand",
    ]
    assert lacking(MISSION, ROBOT, lambda _name, _kind: "") == ()
