# SPDX-License-Identifier: Apache-2.0
"""Nothing that is read as data imports code of its choice: a law over missions, profiles and journals that try.

The working directory holds packages and files under every name that the hostile data names, and is on Python's path,
where a careless program would import from. Each of them reports when it is executed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.check import check
from rai_missions.connectors.registry import connector_offer
from rai_missions.connectors.ros2 import fields_of, why_absent
from rai_missions.errors import MissionError
from rai_missions.journal import Header, Journal
from rai_missions.kinds import _places
from rai_missions.mission.files import dump, load
from rai_missions.profile import load_profile
from rai_missions.replay.replay import replay
from visualize import FORMATS, drawn, picture

EXECUTED: list[str] = []
"""What of the working directory was executed."""
REPORT = "import tests.security.test_imports as law\nlaw.EXECUTED.append(__file__)\n"
ROBOT = REPORT + "from rai_missions import PythonRobot\nrobot = PythonRobot('evil')\n"
NAMES = (
    "evil", "evil:robot", "evil.msg", "evil.robot:robot", "evil/msg/Float64", "evil/srv/Trigger", "evil/action/Go",
    "evil_msgs/msg/Float64", "std_msgs_evil/msg/String", "evil.py", "./evil.py", "../{here}/evil.py", "{cwd}/evil.py",
    "file://{cwd}/evil.py", "__import__('evil')", "${{evil}}", "python:evil", "evil>=0", "sitecustomize",
)  # fmt: skip
GROUPS = ("guards", "activities", "connectors", "worlds", "exporters")

MISSION: dict[str, Any] = {
    "$schema": "mission.schema.json", "format": 1, "name": "trip", "version": "1.0.0", "about": "drive",
    "uses": [], "blackboard": {"x": {"type": "number", "source": "robot", "max_age_s": 3, "about": "place"}},
    "events": {"branch": {"about": "in the way"}}, "initial": "driving",
    "states": {
        "driving": {"action": "drive", "goal": {"to": "home"}, "timeout_s": 60, "achieved": {"key": "x", ">=": 2},
                    "transitions": [{"on": "branch", "to": "asking"}, {"on": "succeeded", "to": "done"}]},
        "asking": {"decision": {"question": "What now?", "evidence": ["x"], "options": {"go": {"about": "g"}, "no": {}},
                                "ask": ["rules", "agent"], "deadline_s": 5, "fallback": "no"},
                   "transitions": [{"on": "go", "to": "hooting"}, {"on": "no", "to": "lost"}]},
        "hooting": {"call": "horn", "timeout_s": 5, "transitions": [{"on": "succeeded", "to": "driving"}]},
        "done": {"final": "succeeded", "requires": {"key": "x", ">=": 2}}, "lost": {"final": "aborted"},
    },
}  # fmt: skip
PROFILE: dict[str, Any] = {
    "$schema": "robot.schema.json", "format": 1, "name": "r", "about": "a robot",
    "connector": {"kind": "ros2", "node": "n", "namespace": "/r", "world": "orchard", "file": "f", "sha256": "0"},
    "blackboard": {"x": {"topic": "/x", "type": "std_msgs/msg/Float64", "field": "data"}},
    "events": {"branch": {"service": "/s", "type": "std_srvs/srv/Trigger", "every_s": 1,
                          "when": {"key": "message", "==": "X"}}},
    "actions": {"drive": {"action": "/drive", "type": "nav2_msgs/action/NavigateToPose", "uses": ["base"]}},
    "services": {"horn": {"service": "/horn", "type": "std_srvs/srv/Trigger"}},
    "topics": {"speech": {"topic": "/speech", "type": "std_msgs/msg/String"}},
    "rules": {"asking": [{"when": {"key": "x", "<": 0.2}, "answer": "go"}]}, "identity": "identity",
    "tools": {"read": ["/x"], "write": ["/y"], "never": ["/z"]},
}  # fmt: skip


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A working directory, on Python's path in every spelling, with a trap behind each of the names."""
    folder = tmp_path / "here"
    for package in ("evil", "evil_msgs", "std_msgs_evil", "langchain_evil"):
        for kind in ("", "msg", "srv", "action", "robot"):
            (folder / package / kind).mkdir(parents=True, exist_ok=True)
            (folder / package / kind / "__init__.py").write_text(ROBOT)
    for name in ("evil.py", "sitecustomize.py"):
        (folder / name).write_text(ROBOT)
    (folder / "identity").mkdir()
    points = "".join(f"[rai_missions.{group}]\nevil = evil:robot\n" for group in GROUPS)
    (folder / "evil-1.0.dist-info").mkdir()
    (folder / "evil-1.0.dist-info/METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1.0\n")
    (folder / "evil-1.0.dist-info/entry_points.txt").write_text(points)
    monkeypatch.chdir(folder)
    for spelling in ("", ".", str(folder)):
        monkeypatch.syspath_prepend(spelling)
    EXECUTED.clear()
    before = set(sys.modules)
    yield folder
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
            del sys.modules[name]


def changed(data: Any, name: str) -> Iterator[Any]:
    """The same data with one of its texts, or one of its words, replaced by a name: each in turn."""
    if isinstance(data, dict):
        for word, item in data.items():
            yield from ({**data, word: each} for each in changed(item, name))
            yield {(name if each == word else each): other for each, other in data.items()}
    elif isinstance(data, list):
        for index, item in enumerate(data):
            yield from ([*data[:index], each, *data[index + 1 :]] for each in changed(item, name))
        yield [*data, name]
    elif isinstance(data, str):
        yield name


def hostile(data: dict[str, Any], folder: Path, share: int) -> Iterator[dict[str, Any]]:
    """Data in which one text is a hostile name.

    Args:
        data: Good data.
        folder: The working directory.
        share: One in so many pairs of place and name; the names take turns over the places.
    """
    names = [name.format(cwd=folder, here=folder.name) for name in NAMES]
    for turn, name in enumerate(names):
        for place, each in enumerate(changed(data, name)):
            if place % share == turn % share:
                yield each


def tried(read: Callable[[], Any]) -> None:
    """Read hostile data; that it is refused is its right, and anything else that it raises is a fault of ours."""
    with suppress(MissionError):
        read()


shares = pytest.mark.parametrize("share", [36, pytest.param(1, marks=pytest.mark.drill)])


def modules_of(folder: Path) -> list[str]:
    return [
        name for name, module in sys.modules.items() if str(getattr(module, "__file__", "")).startswith(str(folder))
    ]


def test_the_traps_work_and_a_robot_that_a_person_names_is_executed(here: Path) -> None:
    tried(lambda: prepare(RunConfig(load(put(here, "mission.json", MISSION)), here / "evil.py")))
    assert [*EXECUTED] == [str(here / "evil.py")]
    import evil  # type: ignore[import-not-found]  # noqa: F401 - what a careless program would do

    assert EXECUTED[1:] == [str(here / "evil/__init__.py")] and modules_of(here)


def put(folder: Path, name: str, data: Any) -> Path:
    file = folder / name
    file.write_text(json.dumps(data), encoding="utf-8")
    return file


@shares
def test_no_mission_imports_code_of_its_choice(share: int, here: Path) -> None:
    def read(data: Any) -> None:
        mission = load(put(here, "mission.json", data))
        check(mission)
        drawn(picture(mission), "md")

    assert "md" in FORMATS
    for data in hostile(MISSION, here, share):
        tried(lambda data=data: read(data))  # type: ignore[misc]
    assert EXECUTED == [] and modules_of(here) == []


@shares
@pytest.mark.parametrize("kind", ["ros2", "local", "python", "evil"])
def test_no_profile_imports_code_of_its_choice(kind: str, share: int, here: Path) -> None:
    if kind == "ros2":
        pytest.importorskip("rclpy")
    mission = load(put(here, "mission.json", MISSION))

    def read(data: Any) -> None:
        file = put(here, "robot.json", data)
        for each in load_profile(file).blackboard.values():
            why_absent(each.type, "msg"), fields_of(each.type, "msg")
        prepare(RunConfig(mission, file)).close()

    connector = PROFILE["connector"] | {"kind": kind}
    for data in hostile(PROFILE | {"connector": connector}, here, share):
        tried(lambda data=data: read(data))  # type: ignore[misc]
    assert EXECUTED == [] and modules_of(here) == []


@shares
def test_no_journal_imports_code_of_its_choice(share: int, here: Path) -> None:
    text = dump(load(put(here, "mission.json", MISSION)))
    programs = PROFILE | {"connector": {"kind": "python", "file": "evil.py"}}
    pairs = [(text, json.dumps(each)) for each in (programs, *hostile(programs, here, 2 * share))]
    pairs += [(json.dumps(each), "") for each in hostile(MISSION, here, 2 * share)]
    for number, (mission, profile) in enumerate(pairs):
        file = here / f"{number}.journal"
        versions = {"evil": "1.0", "./evil.py": "1.0"}
        Journal.create(file, Header(mission, profile, {"x": "evil"}, versions=versions)).close()
        tried(lambda file=file: replay(file))  # type: ignore[misc]
        tried(lambda file=file: prepare(RunConfig(None, resume=file)).close())  # type: ignore[misc]
        file.unlink()
    assert EXECUTED == [] and modules_of(here) == []


def test_what_lies_in_the_working_directory_is_not_installed_however_its_path_is_spelled(here: Path) -> None:
    assert not [each for each in _places() if Path(each).resolve() == here.resolve()]


COMMANDS = ("rai-missions", "python -m rai_missions")
TRAP = "open({file!r}, 'a').write(__name__)\nraise ImportError('a trap')\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_neither_spelling_of_the_command_imports_from_the_working_directory(command: str, tmp_path: Path) -> None:
    folder, caught = tmp_path / "here", tmp_path / "caught"
    folder.mkdir()
    for name in ("langchain_evil", "langchain_core", "mujoco", "py_trees", "pydantic", "rclpy", "transitions"):
        (folder / f"{name}.py").write_text(TRAP.format(file=str(caught)))
    put(folder, "mission.json", MISSION)
    (folder / "identity").mkdir()
    put(folder, "robot.json", PROFILE | {"connector": {"kind": "local"}})
    campaign = {
        "format": 1, "name": "c", "mission": "mission.json", "robot": "robot.json", "decision": "asking",
        "scenes": {"world": "orchard", "seeds": [1]}, "models": ["evil:x"],
    }  # fmt: skip
    put(folder, "campaign.json", campaign)
    script = shutil.which("rai-missions", path=sysconfig.get_path("scripts"))
    start = [sys.executable, "-m", "rai_missions"] if command.startswith("python") else [script or ""]
    if start == [""]:
        pytest.skip("the command is not installed")
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    for order in ("check mission.json", "campaign check campaign.json"):
        done = subprocess.run(
            [*start, *order.split()], check=False, cwd=folder, env=environment, capture_output=True, text=True
        )
        assert not caught.exists(), caught.read_text()
    assert "/models/0: no model provider 'evil'" in done.stderr


def test_no_package_can_offer_to_open_a_robot_in_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    info = tmp_path / "foreign-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: foreign\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[rai_missions.connectors]\npython = foreign\nother = foreign\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert connector_offer("other") is not None
    assert connector_offer("python") is None and connector_offer("local") is None


def test_a_package_of_interfaces_in_the_working_directory_is_refused_by_name(here: Path) -> None:
    pytest.importorskip("rclpy")
    assert why_absent("evil/msg/Float64", "msg") == (
        f"the package 'evil' in {here} is not installed, and is not imported; source the workspace that has it, or "
        "install its wheel"
    )
    assert EXECUTED == []


def test_a_package_of_interfaces_that_the_ament_index_lists_is_imported(
    here: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prefix = tmp_path / "install"
    folder = prefix / "lib/python3/site-packages/sourced_msgs/msg"
    folder.mkdir(parents=True)
    (folder.parent / "__init__.py").write_text("")
    (folder / "__init__.py").write_text("class Load:\n    _TYPE_SUPPORT = None\n")
    monkeypatch.syspath_prepend(str(folder.parents[1]))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    assert "is not installed" in why_absent("sourced_msgs/msg/Load", "msg")
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "sourced_msgs").write_text("")
    assert why_absent("sourced_msgs/msg/Load", "msg") == ""
