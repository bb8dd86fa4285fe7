# SPDX-License-Identifier: Apache-2.0
"""What the doctor reports of a machine and of a robot; whatever is broken there, it continues and reports it."""

from __future__ import annotations

import importlib.util
import json
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

from rai_missions.cli.doctor import MachineFinding
from rai_missions.cli.doctor.finding import tried
from rai_missions.cli.doctor.machine import EXTRAS
from rai_missions.cli.doctor.robot import loads, reach
from rai_missions.cli.doctor.ros import ros
from rai_missions.cli.main import main
from rai_missions.errors import install_command
from rai_missions.profile import Robot, load_profile, wanted
from tests.connectors.test_mqtt import Broker, needs_broker
from tests.ros2 import lock_free_domain

ROOT = Path(__file__).parents[3]
HAS_ROS = importlib.util.find_spec("rclpy") is not None
with_ros = pytest.mark.skipif(not HAS_ROS, reason="ROS 2 is not installed: pip install -e '.[ros]'")
SERVER = """
import json, sys
from rai_missions.connectors.ros2 import open_connector
connector = open_connector({})
connector.start()
connector.serve("/beacon/flash", "std_srvs/srv/Trigger", lambda _: {"success": True})
connector.serve("/beacon/light", "std_srvs/srv/SetBool", lambda _: {"success": True})
connector.expect("services", "/beacon/awaited", "std_srvs/srv/Trigger")
connector.subscribe("/beacon/hoped_for", "std_msgs/msg/Bool", lambda _: None)
print("ready", flush=True)
sys.stdin.read()
connector.stop()
"""


@pytest.fixture
def environment(tmp_path: Path) -> Iterator[dict[str, str]]:
    """Loopback, a domain of its own, and no ROS but the one of this interpreter."""
    domain, lock = lock_free_domain()
    own = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "FASTRTPS"))}
    with lock:
        yield own | {
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(tmp_path),
            "PYTHONPATH": str(ROOT),
        }


def broken(environment: Mapping[str, str], folder: Path, code: str) -> dict[str, str]:
    """An environment in which another rclpy is found first."""
    (folder / "rclpy.py").write_text(code)
    return {**environment, "PYTHONPATH": os.pathsep.join((str(folder), str(ROOT)))}


def statuses(found: list[MachineFinding]) -> set[str]:
    return {each.status for each in found}


def robot(**words: object) -> Robot:
    return Robot.model_validate({"name": "beacon", "connector": {"kind": "ros2"}, **words})


def test_without_ros_both_ways_to_it_are_reported_and_nothing_is_missing() -> None:
    (only,) = ros({}, has_wheels=False)
    assert only.status == "absent"
    assert "source /opt/ros" in only.remedy and "pip install" in only.remedy and "never both" in only.remedy


def test_a_sourced_ros_and_wheels_are_not_to_meet() -> None:
    (only,) = ros({"ROS_DISTRO": "jazzy"}, has_wheels=True)
    assert only.status == "missing"
    assert str(only).startswith("missing ROS jazzy is sourced and ROS wheels are installed: use one")


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("raise ImportError('librcl.so: cannot open shared object file')", "librcl.so: cannot open shared object file"),
        ("import os; os.abort()", "it crashed (SIGABRT)"),
        ("import sys; sys.exit(3)", "it ended with 3"),
    ],
)
def test_an_rclpy_that_does_not_load_ends_nothing_but_its_own_process(
    environment: dict[str, str], tmp_path: Path, code: str, message: str
) -> None:
    (only,) = ros(broken(environment, tmp_path, code), has_wheels=True)
    assert only.status == "missing"
    assert message in only.what and only.remedy


def test_a_probe_that_hangs_is_left(environment: dict[str, str], tmp_path: Path) -> None:
    hanging = broken(environment, tmp_path, "import threading; threading.Event().wait()")
    assert "nothing came back within 2 s" in tried("load", None, hanging, within_s=2).fault


@with_ros
def test_a_ros_that_works_is_reported_with_its_middleware_and_its_reach(environment: dict[str, str]) -> None:
    found = list(ros(environment, has_wheels=True))
    assert statuses(found) == {"ok"}, found
    reported = "\n".join(map(str, found))
    assert (
        "middleware rmw_" in reported
        and "only nodes of this machine meet" in reported
        and "loopback met after" in reported
    )


@with_ros
@pytest.mark.parametrize(
    ("variable", "value", "status", "message"),
    [
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "", "warns", "is not set, which is SUBNET: it multicasts to the network"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCAL", "missing", "LOCAL is not known"),
        ("ROS_LOCALHOST_ONLY", "1", "ok", "an older word"),
        ("ROS_DOMAIN_ID", "", "ok", "shared with all"),
        ("ROS_DOMAIN_ID", "150", "warns", "also given to other programs"),
        ("ROS_DOMAIN_ID", "x", "missing", "is no domain"),
    ],
)
def test_what_the_variables_mean_is_reported(
    environment: dict[str, str], variable: str, value: str, status: str, message: str
) -> None:
    from rai_missions.cli.doctor.ros import (  # what follows starts nodes, which some of these cannot have
        _domain,
        _range,
    )

    found = [each(environment | {variable: value}) for each in (_range, _domain)]
    assert [each.status for each in found if message in str(each)] == [status], found


@with_ros
def test_a_robot_that_is_there_is_found_and_what_it_lacks_is_named(environment: dict[str, str]) -> None:
    import subprocess
    import sys

    profile = robot(
        connector={"kind": "ros2", "namespace": "/beacon", "arguments": ["-r", "dimmer:=/beacon/light"]},
        services={
            "flash": {"service": "/beacon/flash"},
            "light": {"service": "/beacon/light"},
            "horn": {"service": "/beacon/flahs"},
            "awaited": {"service": "/beacon/awaited"},
            "spark": {"service": "flash"},
            "dim": {"service": "dimmer", "type": "std_srvs/srv/SetBool"},
            "sirens": {"service": "flahs"},
        },
        blackboard={"hoped_for": {"topic": "/beacon/hoped_for", "type": "std_msgs/msg/Bool"}},
        topics={"speech": {"topic": "/beacon/speech", "type": "std_msgs/msg/String"}},
        events={"stop_now": {"topic": "/beacon/flahs", "type": "std_msgs/msg/Empty"}},
    )
    words = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": environment}
    with subprocess.Popen([sys.executable, "-W", "ignore", "-c", SERVER], **words) as server:  # type: ignore[call-overload]
        assert server.stdout.readline() == "ready\n"
        there, found, within_s = "services/flash: service /beacon/flash", dict[str, MachineFinding](), 1.0
        while there not in found:  # on a busy machine two processes take longer to find each other
            within_s *= 2
            found = {each.what: each for each in reach(profile, environment, within_s=within_s)}
        server.stdin.close()
    assert found[there].status == "ok"
    lacking = found["services/horn: service /beacon/flahs is not there"]
    assert lacking.status == "missing" and "did you mean '/beacon/flash'?" in lacking.remedy
    for each in ("services/spark: service flash (/beacon/flash)", "services/dim: service dimmer (/beacon/light)"):
        assert found[each].status == "ok", "a relative name, and one that is remapped"
    lacking = found["services/sirens: service flahs (/beacon/flahs) is not there"]
    assert lacking.status == "missing" and "did you mean '/beacon/flash'?" in lacking.remedy
    awaited = "services/awaited: service /beacon/awaited", "blackboard/hoped_for: topic /beacon/hoped_for"
    for each in awaited:  # a mission that waits for its robot is no robot
        assert found[f"{each} is not there"].status == "missing"
    other = found["services/light: service /beacon/light is there as std_srvs/srv/SetBool"]
    assert other.status == "missing" and "std_srvs/srv/Trigger" in other.remedy
    assert found["topics/speech: topic /beacon/speech has no listener"].status == "absent"
    silent = found["events/stop_now: topic /beacon/flahs is not published now"]
    assert silent.status == "absent" and not silent.remedy, "an e-stop is published when it is pressed"


@pytest.mark.long
@with_ros
def test_a_field_that_a_type_has_not_is_reported(environment: dict[str, str]) -> None:
    source = {"topic": "/battery", "type": "sensor_msgs/msg/BatteryState", "field": "percent"}
    found = list(reach(robot(blackboard={"battery": source}), environment, within_s=0.1))
    (reported,) = (each for each in found if each.what == "blackboard/battery/field")
    assert reported.status == "missing" and "has no field 'percent' (did you mean 'percentage'?)" in reported.remedy


@pytest.mark.long
@with_ros
def test_a_robot_that_is_not_there_and_a_type_that_is_not_here_are_reported(environment: dict[str, str]) -> None:
    profile = robot(actions={"go": {"action": "/go", "type": "nobodys_msgs/action/Go"}})
    types, nothing = reach(profile, environment, within_s=0.1)
    assert str(types).startswith("missing actions/go/type: nobodys_msgs/action/Go: no ROS package 'nobodys_msgs'")
    assert "nothing of the robot 'beacon' is there over ros2" in nothing.what
    where = f"(ROS_DOMAIN_ID, here {environment['ROS_DOMAIN_ID']}) and the discovery range (here LOCALHOST)"
    assert where in nothing.remedy


def test_a_type_s_name_runs_no_package_that_has_no_such_types(environment: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "evil").mkdir()
    (tmp_path / "evil" / "__init__.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    found = {**environment, "PYTHONPATH": os.pathsep.join((str(tmp_path), str(ROOT)))}
    answer = tried("types", [["evil/msg/Thing", "msg"], ["this/msg/Zen", "msg"]], found)
    assert answer.value == ["the package 'evil' has no message types", "the package 'this' has no message types"]
    assert not (tmp_path / "ran").exists()


def test_a_broker_that_is_not_there_is_reported() -> None:
    pytest.importorskip("paho")
    profile = robot(connector={"kind": "mqtt", "port": 1}, services={"flash": {"service": "flash"}})
    (only,) = reach(profile, dict(os.environ))
    assert only.status == "missing" and "mqtt" in only.what


@needs_broker
def test_a_robot_behind_a_broker_is_known_by_what_it_publishes(tmp_path: Path) -> None:
    broker = Broker(tmp_path)
    battery = {"topic": "/battery", "type": "std_msgs/msg/Float64"}
    profile = robot(
        connector={"kind": "mqtt", "port": broker.port},
        blackboard={"battery": battery},
        services={"flash": {"service": "/flash"}},
        topics={"lamp": {"topic": "/lamp", "type": "std_msgs/msg/Bool"}},
    )
    (nothing,) = reach(profile, dict(os.environ), within_s=0.1)
    assert "nothing of the robot 'beacon' is there over mqtt" in nothing.what
    assert nothing.remedy == "start the robot or its simulation, and compare what the connector names of both"
    broker.keep("/battery", b'{"data": 0.5}')
    found = {each.what: each.status for each in reach(profile, dict(os.environ))}
    assert found == {
        "blackboard/battery: topic /battery": "ok",
        "services/flash: service /flash cannot be looked for: mqtt keeps to itself who serves it": "absent",
        "topics/lamp: topic /lamp cannot be looked for: mqtt keeps to itself who listens": "absent",
    }
    broker.stop()


@pytest.mark.parametrize(
    ("connector", "status", "message"),
    [
        ({"kind": "local", "world": "orchard"}, "ok", "is simulated with the run"),
        ({"kind": "local", "world": "orchart"}, "missing", "did you mean 'orchard'?"),
        ({"kind": "local", "wrold": "orchard"}, "missing", "did you mean 'world'?"),
        ({"kind": "rosbridge"}, "missing", "no connector of kind 'rosbridge'; there is: local, mqtt, ros2"),
    ],
)
def test_a_robot_of_another_kind_is_reported_by_its_profile(
    connector: dict[str, str], status: str, message: str
) -> None:
    (only,) = reach(robot(connector=connector), {})
    assert only.status == status and message in str(only)


def test_everything_that_a_shipped_profile_names_is_looked_for() -> None:
    found = list(wanted(load_profile(ROOT / "missions/tractor/robot.nav2.json")))
    assert {("actions", "/navigate_to_pose"), ("services", "/tractor1/stop"), ("topics", "/tractor1/battery")} <= {
        (each.mode, each.name) for each in found
    }


def test_the_packages_of_each_extra_of_a_user_are_looked_for() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    of_users = {*next(iter(Requirement(each).extras for each in extras["all"])), "ray"}
    assert {extra: set(packages) for extra, packages, _ in EXTRAS} == {
        extra: {Requirement(each).name for each in extras[extra]} for extra in of_users
    }


def test_a_profile_at_fault_is_reported_on_stderr(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "robot.json").write_text('{"format": 1}')
    assert main(["doctor", "--robot", str(tmp_path / "robot.json")]) == 2
    assert "name" in capsys.readouterr().err


def test_what_check_refuses_of_a_conversation_doctor_refuses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    conversation = {"language": "xx", "phrases": {"fetch it (now": {}}}
    profile = {"format": 1, "name": "rob", "connector": {"kind": "local"}, "conversation": conversation}
    (tmp_path / "robot.json").write_text(json.dumps(profile))
    given, mission = ["--robot", str(tmp_path / "robot.json")], str(ROOT / "missions/tractor/mission.json")
    assert main(["check", mission, *given]) == 2
    wrong = [line for line in capsys.readouterr().err.splitlines() if "/conversation/" in line]
    assert main(["doctor", *given]) == 2
    reported = capsys.readouterr().err
    assert len(wrong) == 1 and all(line.partition("/conversation/")[2] in reported for line in wrong)


PYTHON_ROBOT = """
from rai_missions import PythonRobot
robot = PythonRobot("turtle")
robot.fact("x", every_s=1)(lambda: 1.0)
robot.fact("docked")
robot.action("drive")(lambda goal, run: None)
robot.service("horn")(lambda request: None)
"""


RULES = """
robot.rules["docked"] = [{"answer": %s}]
"""


@pytest.mark.parametrize(
    ("source", "status", "words"),
    [
        (PYTHON_ROBOT + RULES % "'undock'", "ok", "loads: facts x"),
        (PYTHON_ROBOT + RULES % "7", "missing", "/rules/docked/0/answer: 7 is not text"),
        (PYTHON_ROBOT, "ok", "loads: facts x, docked; services horn; actions drive; topics none"),
        (PYTHON_ROBOT + "made = robot\ndef robot(): return made", "ok", "loads: it is made by robot(), once a run"),
        (
            PYTHON_ROBOT + "robot.conversation = {'phrases': {'drive (home': {}}}",
            "missing",
            "/conversation/phrases/drive (home: the phrase 'drive (home' is not closed",
        ),
        ("robot = 5", "missing", "does not load"),
        ("import nowhere", "missing", "does not load"),
    ],
)
def test_what_a_robot_in_python_offers_is_named(tmp_path: Path, source: str, status: str, words: str) -> None:
    (tmp_path / "my_robot.py").write_text(source)
    found = loads(tmp_path / "my_robot.py")
    assert (found.status, words in str(found)) == (status, True), found


@pytest.mark.parametrize(
    ("origin", "line"),
    [({"url": "file:///home/ann/my%20rai", "dir_info": {"editable": True}}, "pip install '/home/ann/my rai[sim]'"),
     ({"url": "file:///work", "dir_info": {}}, "pip install '.[sim]'"),
     ({"url": "https://host/r.git", "vcs_info": {"vcs": "git", "commit_id": "12ab"}},
      "pip install 'rai-missions[sim] @ git+https://host/r.git@12ab'"),
     ({"url": "file:///r-1.whl", "archive_info": {}}, "pip install 'rai-missions[sim] @ file:///r-1.whl'"),
     ({}, "pip install 'rai-missions[sim]'")],
)  # fmt: skip
def test_an_extra_is_installed_from_where_the_package_came_from(origin: dict[str, Any], line: str) -> None:
    assert install_command("sim", origin, Path("/work")) == line
