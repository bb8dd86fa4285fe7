# SPDX-License-Identifier: Apache-2.0
"""A node runs missions on a robot in Python: the file is executed once, and makes a robot for each run."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from rai_missions import Mission
from rai_missions.agents.mission import RunConfig
from rai_missions.connectors.local import LocalConnector
from rai_missions.node import MissionNode
from rai_missions.node.transport import Carrier
from rai_missions.profile import read_program
from tests.node.scenes import Client

MISSION = Mission.model_validate(
    {
        "name": "trip", "version": "1", "initial": "driving",
        "blackboard": {"x": {"type": "number", "source": "robot", "max_age_s": 5}},
        "states": {
            "driving": {"action": "drive", "timeout_s": 60, "achieved": {"key": "x", ">=": 1},
                        "transitions": [{"on": "succeeded", "to": "done"}]},
            "done": {"final": "succeeded", "requires": {"key": "x", ">=": 1}},
        },
    }
)  # fmt: skip
FILE = """
from rai_missions import PythonRobot
from pathlib import Path
HERE = Path(__file__).parent
(HERE / "executed").touch(exist_ok=False)

def robot():
    (HERE / f"made{len(list(HERE.glob('made*')))}").touch()
    made, here = PythonRobot("turtle"), {"x": 0.0}
    made.fact("x", every_s=60)(lambda: here["x"])

    @made.action("drive")
    async def drive(goal, run):
        assert here["x"] == 0.0
        await run.sleep(1)
        here["x"] = 1.0

    return made
"""


def have_succeeded(runs: int, statuses: list[dict[str, Any]]) -> bool:
    return len({status["run"] for status in statuses if status["outcome"] == "succeeded"}) == runs


def test_a_node_executes_the_file_once_and_has_a_robot_for_each_run(tmp_path: Path) -> None:
    file = tmp_path / "my_robot.py"
    file.write_text(FILE, encoding="utf-8")
    connector = LocalConnector()
    connector.start()
    setting = RunConfig(MISSION, read_program(file), speed=float("inf"))
    node = MissionNode(setting, "trip", carrier=Carrier(connector, False, False))
    client = Client(connector, node.name.path)
    node.run()
    client.activate()
    for number in (1, 2):  # a run may be over before anyone sees that it runs
        assert client.call("start")["success"]
        client.statuses.wait(partial(have_succeeded, number), f"{number} runs have succeeded")
    node.stop()
    connector.stop()
    assert sorted(each.name for each in tmp_path.iterdir()) == ["executed", "made0", "made1", "my_robot.py"]


def test_what_a_robot_in_python_lacks_keeps_the_node_from_being_configured(tmp_path: Path) -> None:
    file = tmp_path / "my_robot.py"
    file.write_text(FILE.replace('@made.action("drive")', '@made.action("drvie")'), encoding="utf-8")
    connector = LocalConnector()
    connector.start()
    node = MissionNode(RunConfig(MISSION, read_program(file)), "trip", carrier=Carrier(connector, False, False))
    client = Client(connector, node.name.path)
    node.run()
    assert not client.change("configure")
    lacks = "write `@robot.action(\"drive\")`; did you mean 'drvie'?"
    assert node.fault == f"{file}: /actions/drive: missing; the mission uses it at /states/driving/action; {lacks}"
    node.stop()
    connector.stop()
