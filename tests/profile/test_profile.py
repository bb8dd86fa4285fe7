# SPDX-License-Identifier: Apache-2.0
"""A robot profile is read, refused with every fault, and held against a mission."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.errors import ConnectorError, DefinitionError, UsageError
from rai_missions.guards import Compare
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile, load_profile, missing, missing_world, parse_profile, robot_facts
from rai_missions.states import Final
from tests.profile.profiles import MISSION, PROFILE, altered, mission, robot


def refused(change: dict[str, Any]) -> list[str]:
    with pytest.raises(DefinitionError) as fault:
        parse_profile(json.dumps(altered(PROFILE, change)))
    return [str(each) for each in fault.value.faults]


def test_a_profile_comes_back_as_it_was_written() -> None:
    assert parse_profile(dump_profile(robot())) == robot()
    assert json.loads(dump_profile(robot())) == altered(PROFILE, {"services/horn/type": None})


def test_a_profile_states_what_tools_may_touch_and_nothing_of_it_is_left_empty() -> None:
    assert robot().tools is not None and robot().tools.never == ("/cmd_vel", "*/e_stop")
    plain = parse_profile(json.dumps(altered(PROFILE, {"tools": {}}))).tools
    assert plain is not None and (plain.read, plain.write, plain.never) == (("*",), (), ())
    assert parse_profile(json.dumps(altered(PROFILE, {"tools": None}))).tools is None
    assert refused({"tools": {"write": [""]}}) == ["/tools/write/0: an empty pattern in 'write' is no name; drop it"]
    assert refused({"tools": {"never": ["*/e_stop", "cmd_vel"]}}) == [
        "/tools/never/1: 'cmd_vel' fits no name, since each begins with a slash; write '/cmd_vel'"
    ]
    assert refused({"tools": {"wrote": []}})[0].startswith("/tools/wrote: ")


def test_a_profile_is_read_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "identity").mkdir()
    path = tmp_path / "robot.json"
    path.write_text(json.dumps({"$schema": "x", **PROFILE, "identity": "identity/"}))
    assert load_profile(path).name == "tractor1, simulated"


@pytest.mark.parametrize(
    ("identity", "message"),
    [
        ("../elsewhere", "lies outside the profile's own folder"),
        ("/etc", "lies outside"),
        ("link", "lies outside"),
        ("none", "there is no folder 'none' next to the profile"),
        ("robot.json", "there is no folder"),
        ("a\0b", "no folder's name"),
    ],
)
def test_an_identity_lies_next_to_its_profile(tmp_path: Path, identity: str, message: str) -> None:
    (tmp_path / "elsewhere").mkdir()
    here = tmp_path / "here"
    here.mkdir()
    (here / "link").symlink_to(tmp_path / "elsewhere")
    path = here / "robot.json"
    path.write_text(json.dumps({**PROFILE, "identity": identity}))
    with pytest.raises(DefinitionError, match=f"/identity: .*{message}"):
        load_profile(path)


@pytest.mark.parametrize("content", [b"", b"[]", b"\xff\xfe", b'{"format": 1, ', b'"x"', b"{" * 5000])
def test_a_file_that_is_no_profile_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "robot.json").write_bytes(content)
    with pytest.raises(DefinitionError):
        load_profile(tmp_path / "robot.json")


def test_a_file_that_is_not_there_is_the_callers_affair(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no file"):
        load_profile(tmp_path / "none.json")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": 2}, "/format: no such choice: 2; it is 1"),
        ({"connector": {"world": "orchard"}}, "/connector: a connector has a 'kind'"),
        ({"control": {"autonmy": {"service": "/x"}}}, "/control/autonmy: no one called 'autonmy' can hold control"),
        ({"events/anomaly/during": "drive"}, "/events/anomaly/during: 'anomaly' is received during 'drive', which is"),
        ({"blackboard/battery/topic": ""}, "/blackboard/battery/topic: '' is too short; it has 1 letter or more"),
        ({"actions/drive_alleys/start": ""}, "/actions/drive_alleys/start: '' is too short"),
        ({"services/horn/service": ""}, "/services/horn/service: '' is too short"),
        (
            {"blackboard/battery/topic": None},
            "/blackboard/battery: a source is a 'topic' or a 'service', this is neither",
        ),
        (
            {"blackboard/battery/service": "/s"},
            "/blackboard/battery: a source is a 'topic' or a 'service', this is both",
        ),
        (
            {"blackboard/battery/every_s": 1.0},
            "/blackboard/battery: '/tractor1/battery' is a topic and speaks by itself: drop 'every_s'",
        ),
        (
            {"blackboard/battery/request": {"a": 1}},
            "/blackboard/battery: a topic is not asked; 'request' belongs to a 'service'",
        ),
        (
            {"events/anomaly": {"topic": "/t", "request": {"a": 1}}},
            "/events/anomaly: a topic is not asked; 'request' belongs to a 'service'",
        ),
        (
            {"blackboard/obstacle/as": "pose"},
            "/blackboard/obstacle: 'json' and 'as' are two ways to read one field; keep one",
        ),
        ({"blackboard/battery/as": "video"}, "/blackboard/battery/as: no such choice: 'video'"),
        ({"events/anomaly/every_s": None}, "/events/anomaly: '/tractor1/current_state' is a service and is asked"),
        (
            {"events/go/topic": "/go"},
            "/events/go: an event is 'posted' or received on a topic or service, not both; drop one",
        ),
        (
            {"actions/go_home/start": "/x"},
            "/actions/go_home: an action has a server, 'action', or is composed, 'start' …; this is both",
        ),
        (
            {"actions/drive_alleys/start": None},
            "/actions/drive_alleys: an action has a server, 'action', or is composed",
        ),
        ({"actions/drive_alleys/succeeded": None}, "/actions/drive_alleys: a composed action needs 'succeeded'"),
        (
            {"actions/go_home/cancel": "/x"},
            "/actions/go_home: the server of '/navigate_to_pose' reports how it ends: drop cancel",
        ),
        ({"actions/drive_alleys/goal": {"a": 1}}, "/actions/drive_alleys: a composed action has no server: drop goal"),
        ({"services/horn/colour": "red"}, "/services/horn/colour:"),
        ({"rules/assessing": [{"when": {"key": "a"}, "answer": "b"}]}, "/rules/assessing/0/when"),
        ({"services/Horn": {"service": "/x"}}, "'Horn' is not a name"),
        ({"hri_below": "/alpha"}, "/hri_below: a robot has no 'hri_below'; it belongs in 'conversation'"),
        ({"write": ["/horn"]}, "/write: a robot has no 'write'; it belongs in 'tools'"),
        ({"topic": "/t"}, "/topic: a robot has no 'topic'; did you mean 'topics'?"),
    ],
)
def test_a_fault_is_reported_with_its_place(change: dict[str, Any], message: str) -> None:
    assert any(message in fault for fault in refused(change)), refused(change)


def test_every_fault_is_reported_at_once() -> None:
    assert len(refused({"format": 2, "name": 3, "services/horn/service": None})) == 3


def test_the_engine_learns_what_conflicts_what_is_kept_and_what_ends_an_action() -> None:
    known = robot_facts(robot({"actions/horn": {"action": "/horn", "type": "x/action/Horn", "repeat": True}}))
    assert known.uses == {"drive_alleys": {"base"}, "go_home": {"base"}, "horn": None}
    assert (known.keep, known.repeat) == (frozenset({"go_home"}), frozenset({"horn"}))
    assert known.succeeded == {
        "drive_alleys": Compare.model_validate({"key": "alleys_driven", ">=": {"key": "alleys"}})
    }
    assert known.failed == {}
    assert known.conflict("drive_alleys", "go_home")
    assert known.conflict("horn", "go_home")
    assert known.conflict("no_one_knows", "go_home")


def test_actions_that_use_nothing_in_common_do_not_conflict() -> None:
    known = robot_facts(robot({"actions/arm": {"action": "/arm", "uses": ["arm"]}}))
    assert not known.conflict("arm", "go_home")


# -- goals, requests, replies -----------------------------------------------------------------------------------------


def test_a_goal_is_written_as_the_server_wants_it() -> None:
    goal = robot().actions["go_home"].goal_of({"home": {"x": 1.0, "y": 2.0, "frame": "map"}})
    assert goal["behavior_tree"] == ""
    assert goal["pose"]["header"] == {"frame_id": "map"}
    assert goal["pose"]["pose"]["position"] == {"x": 1.0, "y": 2.0, "z": 0.0}


@pytest.mark.parametrize(
    ("given", "message"),
    [({}, "needs 'home', and the mission gives: nothing"), ({"home": 3}, "3 is given where a pose belongs")],
)
def test_a_goal_that_lacks_what_the_server_wants_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ConnectorError, match=message):
        robot().actions["go_home"].goal_of(given)


def test_what_the_mission_gives_is_over_what_the_profile_gives() -> None:
    service = robot({"services/horn/request": {"times": 1, "tone": {"pitch": 440, "loud": True}}}).services["horn"]
    assert service.request_of({"tone": {"pitch": 220}}) == {"times": 1, "tone": {"pitch": 220, "loud": True}}


@pytest.mark.parametrize(
    ("rule", "outcome", "reply", "good"),
    [
        (None, "succeeded", {"success": True}, True),
        (None, "succeeded", {"success": False, "message": "no"}, False),
        (None, "succeeded", {}, True),
        (None, "timed_out", {"success": True}, False),
        ({"key": "code", "==": 0}, "succeeded", {"code": 0, "success": False}, True),
        ({"key": "code", "==": 0}, "succeeded", {}, False),
    ],
)
def test_a_reply_is_a_success_where_the_profile_states_it(
    rule: dict[str, Any] | None, outcome: str, reply: dict[str, Any], good: bool
) -> None:
    service = robot({"services/horn/succeeded": rule} if rule else {}).services["horn"]
    assert service.succeeded(outcome, reply) is good


def test_a_result_is_renamed_and_made_plain() -> None:
    change = {"actions/go_home/result": {"error": "error.code"}}
    assert robot(change).actions["go_home"].result_of({"error": {"code": 3}}) == {"error": 3}
    assert robot().actions["go_home"].result_of({"took_s": float("nan")}) == {"took_s": None}


# -- a mission and a robot --------------------------------------------------------------------------------------------


def test_a_robot_that_has_all_that_a_mission_uses_lacks_nothing() -> None:
    assert missing(mission(), robot()) == ()


@pytest.mark.parametrize(("connector", "is_missing"), [
    ({"kind": "local"}, True), ({"kind": "local", "world": "orchard"}, False), ({"kind": "ros2"}, False),
])  # fmt: skip
def test_a_profile_without_a_world_has_no_other_side(connector: dict[str, Any], is_missing: bool) -> None:
    alone = Mission(name="alone", initial="done", states={"done": Final("succeeded")})
    with_connector = robot().model_copy(update={"connector": connector})
    assert [each.place for each in missing_world(mission(), with_connector)] == ["/connector"] * is_missing
    assert not list(missing_world(alone, with_connector))


def test_a_robot_without_anything_lacks_everything() -> None:
    assert [fault.place for fault in missing(mission(), Robot(name="bare"))] == [
        "/blackboard/alleys_driven",
        "/blackboard/battery",
        "/blackboard/camera",
        "/blackboard/obstacle",
        "/blackboard/pose",
        "/events/anomaly",
        "/events/go",
        "/actions/drive_alleys",
        "/actions/go_home",
        "/services/horn",
        "/topics/status",
    ]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"blackboard/battery": None, "blackboard/batery": PROFILE["blackboard"]["battery"]},
            "/blackboard/battery: missing; the mission uses it at /blackboard/battery; did you mean 'batery'?",
        ),
        (
            {"actions/go_home": None, "actions/go_hom": PROFILE["actions"]["go_home"]},
            "/actions/go_home: missing; the mission uses it at /states/returning/action; did you mean 'go_hom'?",
        ),
        (
            {"services/horn": None},
            "/services/horn: missing; the mission uses it at /states/warning/tree/sequence/0/call; name what",
        ),
        (
            {"topics/status": None},
            "/topics/status: missing; the mission uses it at /states/driving/entry/0/publish; name what",
        ),
        ({"events/anomaly": None}, "/events/anomaly: missing; the mission uses it at /events/anomaly; there is: go"),
        (
            {"events/anomaly/fields": {"sad": "message"}},
            "/events/anomaly/fields/reported: missing; the mission's 'anomaly' has it; there is: sad",
        ),
        (
            {"blackboard/alleys": {"topic": "/alleys"}},
            "/blackboard/alleys: the mission's 'alleys' is of source 'argument' and not the robot's to write",
        ),
        (
            {"blackboard/battery": {"topic": "/b", "type": "std_msgs/msg/String"}},
            "/blackboard/battery: its messages give 'string', and the mission's 'battery' is of type 'number'; name "
            "the 'field' that is meant, or add \"json\": true if that text is JSON",
        ),
        (
            {"blackboard/camera": {"topic": "/b", "type": "geometry_msgs/msg/PoseStamped"}},
            "/blackboard/camera: its messages give 'pose', and the mission's 'camera' is of type 'image'",
        ),
        (
            {"actions/go_home/goal": {"speed": {"from": "speed"}}},
            "/actions/go_home/goal: it takes 'speed' from the mission, which gives no such field",
        ),
        (
            {"actions/drive_alleys/start": {"service": "/go", "request": {"data": {"from": "speed"}}}},
            "/actions/drive_alleys/start/request: it takes 'speed' from the mission, which gives no such field",
        ),
        (
            {"services/horn/request": {"data": {"from": "loud"}}},
            "/services/horn/request: it takes 'loud' from the mission, which gives no such field",
        ),
        (
            {"topics/status/message": {"data": {"from": "dta"}}},
            "/topics/status/message: it takes 'dta' from the mission, which gives no such field",
        ),
        (
            {"actions/drive_alleys/failed": {"key": "batery", "<": 0.1}},
            "/actions/drive_alleys/failed: the mission has no key 'batery'; did you mean 'battery'?",
        ),
        (
            {"actions/drive_alleys/failed": {"in": "asessing"}},
            "/actions/drive_alleys/failed: the mission has no state 'asessing'; did you mean 'assessing'?",
        ),
        (
            {"rules": {"asessing": []}},
            "/rules/asessing: the mission asks nothing in a state 'asessing'; did you mean 'assessing'?",
        ),
        (
            {"rules/assessing": [{"answer": "stopp"}]},
            "/rules/assessing/0/answer: 'assessing' has no option 'stopp'; did you mean 'stop'?",
        ),
        (
            {"rules/assessing": [{"when": {"key": "obstcle.height_m", "<": 1}, "answer": "stop"}]},
            "/rules/assessing/0/when: the mission has no key 'obstcle'; did you mean 'obstacle'?",
        ),
    ],
)
def test_what_a_profile_lacks_is_reported_with_its_place(change: dict[str, Any], message: str) -> None:
    faults = [str(fault) for fault in missing(mission(), robot(change))]
    assert len(faults) == 1
    assert message in faults[0]


def test_a_rule_that_answers_with_an_option_that_asks_for_values_is_reported() -> None:
    times: dict[str, Any] = {"type": "object", "properties": {"times": {"type": "integer"}}}
    place = f"states/assessing/decision/options/{robot().rules['assessing'][0].answer}/parameters"
    assert missing(mission({place: times}), robot()) == (), "it may do without"
    (found,) = missing(mission({place: times | {"required": ["times"]}}), robot())
    assert str(found).startswith("/rules/assessing/0/answer: a rule gives no parameters, and ")


def test_a_key_that_an_included_mission_brings_is_shared_or_named_in_full(tmp_path: Path) -> None:
    floor = {"floor": {"type": "integer", "source": "robot", "max_age_s": 2}}
    own = {
        "initial": "on",
        "states": {"on": {"transitions": [{"on": "stop", "to": "off"}]}, "off": {"final": "failed"}},
    }
    (tmp_path / "ride.json").write_text(
        json.dumps({"name": "ride", "blackboard": floor, "events": ["stop"], **own}), encoding="utf-8"
    )
    riding = {"mission": "ride.json", "transitions": [{"on": "failed", "to": "over"}]}
    states = {"riding": riding, "over": {"final": "aborted"}}
    (tmp_path / "m.json").write_text(
        json.dumps({"name": "m", "blackboard": floor, "initial": "riding", "states": states}), encoding="utf-8"
    )
    here = {"topic": "/floor", "type": "std_msgs/msg/Int32"}
    sources = {"name": "r", "blackboard": {"floor": here}}
    faults = [str(each) for each in missing(load(tmp_path / "m.json"), Robot.model_validate(sources))]
    assert faults == [
        f"/{sort}/riding~1{name}: missing; the mission uses it at /{sort}/riding~1{name}; the mission in 'riding' has "
        f'it as \'{name}\': share it there, "with": {{"{name}": {given}}}, or name it here'
        for sort, name, given in (("blackboard", "floor", '{"from": …}'), ("events", "stop", '"…"'))
    ]


def test_a_number_may_come_as_an_integer() -> None:
    assert missing(mission(), robot({"blackboard/battery": {"topic": "/b", "type": "std_msgs/msg/Int32"}})) == ()


def test_a_profile_may_have_more_than_a_mission_uses() -> None:
    more = {
        "actions/dance": {"start": "/dance", "succeeded": {"key": "danced", "==": True}},
        "services/sing": {"service": "/s"},
    }
    assert missing(mission(), robot(more)) == ()


def test_an_event_that_the_mission_raises_itself_need_not_come_from_the_robot() -> None:
    raised = {"states/driving/transitions": MISSION["states"]["driving"]["transitions"][1:]}
    assert [fault.place for fault in missing(mission(raised), robot())] == ["/events/tired"]
