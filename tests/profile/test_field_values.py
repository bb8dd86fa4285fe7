# SPDX-License-Identifier: Apache-2.0
"""Values that a goal, a request or a message gives to fields: reported before the start where the type takes none."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import ConnectorError
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, field_faults, unknown_fields
from rai_missions.profile.field_values import misfit, sent_value

MESSAGES = ("BasicTypes", "UnboundedSequences", "Defaults")
SINGLE = st.one_of(
    st.booleans(),
    st.integers(-(2**65), 2**65),
    st.sampled_from([-1, 0, 255, 256, 2**31, 2**32]),
    st.floats(-1e9, 1e9),
    st.integers(-300, 300).map(float),
    st.text("abc", max_size=3),
)
VALUES = SINGLE | st.lists(SINGLE, max_size=3)


@given(st.sampled_from(MESSAGES), st.integers(0, 60), VALUES)
def test_a_constant_is_a_fault_where_the_connector_refuses_it_and_there_alone(
    name: str, number: int, value: Any
) -> None:
    messages = pytest.importorskip("test_msgs.msg")
    from rai_missions.connectors.ros2 import fields_of
    from rai_missions.connectors.ros2.messages import to_message

    fields = fields_of(f"test_msgs/msg/{name}", "msg") or {}
    field = list(fields)[number % len(fields)]
    try:
        to_message(getattr(messages, name), {field: value})
    except ConnectorError:
        refused = True
    else:
        refused = False
    assert bool(misfit(fields, field, sent_value(value, {}))) == refused


TYPES = {
    "go": {
        "pose": {
            "header": {"stamp": {"sec": "int32", "nanosec": "uint32"}, "frame_id": "string"}, "pose": {"x": "double"},
        },
        "flat": {"x": "double", "y": "double", "z": "double", "yaw": "double", "frame": "string"},
        "order": "int32", "speed": "float", "loud": "boolean", "word": "string<22>", "ways": "sequence<double>",
        "names": "string[3]", "deep": "pack/Deep", "points": [{"x": "double"}], "level": "uint8",
    },
}  # fmt: skip
KEYS = {
    "s": Key(str), "n": Key(float), "i": Key(int), "b": Key(bool), "l": Key(list), "p": Key(type="pose"),
    "o": Key(dict, fields={"s": str, "i": int}), "c": Key(type="image"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("path", "item", "sentence"),
    [
        ("order", "four", "takes a whole number as 'order' (int32), not 'four'"),
        ("order", 4.5, "takes a whole number as 'order' (int32), not 4.5"),
        ("level", 256, "takes a whole number from 0 to 255 as 'level' (uint8), not 256"),
        ("speed", True, "takes a number as 'speed' (float), not true"),
        ("loud", 1, "takes true or false as 'loud' (boolean), not 1"),
        ("word", 7, "takes a text as 'word' (string<22>), not 7"),
        ("ways", 7, "takes a list as 'ways' (sequence<double>), not 7"),
        ("ways", [1, "a"], "takes a list, each of whose items is a number, as 'ways' (sequence<double>), not [1, "),
        ("names", [1, 2, 3], "takes a list, each of whose items is a text, as 'names' (string[3]), not [1, 2, 3]"),
        ("pose", "home", "takes a message with header, pose as 'pose', not 'home'"),
        ("order", "i", "takes a whole number as 'order' (int32), not 'i'; for what the key has, write {\"from\": \"i"),
        ("order", {"from": "s"}, "takes a whole number as 'order' (int32), not 's' of type 'string'"),
        ("order", {"from": "o.s"}, "takes a whole number as 'order' (int32), not 'o.s' of type 'string'"),
        ("word", {"from": "n"}, "takes a text as 'word' (string<22>), not 'n' of type 'number'"),
        ("pose", {"from": "p"}, "takes a message with header, pose as 'pose', not 'p' of type 'pose'; write it in the "
         "profile with \"as\": \"geometry_msgs/msg/PoseStamped\", or \"…/Pose\""),
    ],
)  # fmt: skip
def test_a_value_that_a_field_does_not_take_is_named_with_what_the_field_takes(
    path: str, item: Any, sentence: str
) -> None:
    assert misfit(TYPES["go"], path, sent_value(item, KEYS)).startswith(sentence)


@pytest.mark.parametrize(
    ("path", "item"),
    [
        ("order", 4), ("order", 4.0), ("order", {"from": "i"}), ("order", {"from": "n"}), ("order", {"from": "o.i"}),
        ("order", {"from": "o.other"}), ("order", {"from": "event.count"}), ("order", None), ("speed", 1),
        ("ways", []), ("ways", {"from": "l"}), ("points", [{"x": 1}]), ("deep", 7), ("deep", "x"),
        ("flat", {"from": "p"}),
        ("pose.header.stamp", 3.5), ("pose.header.stamp", {"from": "n"}), ("pose", {}), ("ways", {"from": "c"}),
        ("pose", {"from": "p", "as": "geometry_msgs/msg/PoseStamped"}), ("pose", {"$picture": "x"}),
    ],
)  # fmt: skip
def test_a_value_that_a_field_may_take_is_no_fault(path: str, item: Any) -> None:
    assert misfit(TYPES["go"], path, sent_value(item, KEYS)) == ""


def test_the_place_of_a_wrong_value_is_where_the_profile_names_it_or_what_the_mission_gives_it() -> None:
    states = {
        "going": {
            "action": "go", "goal": {"order": {"from": "where"}}, "timeout_s": 5,
            "transitions": [{"on": "succeeded", "to": "over"}],
        },
        "over": {"final": "aborted"},
    }  # fmt: skip
    keys = {"where": {"type": "string", "source": "argument"}}
    mission = Mission.model_validate({"name": "m", "initial": "going", "blackboard": keys, "states": states})
    for goal, fault in (
        ({"speed": "fast"}, "/actions/go/goal/speed: the goal of a s/action/Go takes a number as 'speed' (float), not"),
        ({}, "/actions/go: the mission gives it 'order' at /states/going/goal, and the goal of a s/action/Go takes a"),
    ):
        robot = Robot.model_validate(
            {"name": "r", "actions": {"go": {"action": "/go", "type": "s/action/Go", "goal": goal}}}
        )
        found = unknown_fields(mission, robot, lambda name, part: TYPES["go"] if part == "goal" else None)
        assert str(found[0]).startswith(fault)


def test_a_type_that_a_profile_leaves_out_is_reported_with_its_place() -> None:
    robot = Robot.model_validate(
        {
            "name": "r",
            "connector": {"kind": "ros2"},
            "blackboard": {"floor": {"topic": "/floor"}, "lift": {"service": "/lift", "every_s": 1}},
            "events": {"bell": {"topic": "/bell"}, "unloaded": {"posted": True}},
            "actions": {"ride": {"action": "/ride"}, "go": {"start": "/go", "succeeded": {"key": "up", "==": True}}},
        }
    )
    assert [str(each) for each in field_faults(None, robot)] == [
        "/blackboard/floor/type: the type of the message is missing; one looks like 'std_msgs/msg/String'",
        "/blackboard/lift/type: the type of the service is missing; one looks like 'std_srvs/srv/Trigger'",
        "/events/bell/type: the type of the message is missing; one looks like 'std_msgs/msg/String'",
        "/actions/ride/type: the type of the action is missing; one looks like 'nav2_msgs/action/NavigateToPose'",
    ]


def test_an_item_of_a_list_of_bounded_texts_is_a_text() -> None:
    fields = {"words": "sequence<string<10>, 3>"}
    assert misfit(fields, "words", sent_value(["on"], {})) == ""
    assert "each of whose items is a text" in misfit(fields, "words", sent_value([1], {}))
