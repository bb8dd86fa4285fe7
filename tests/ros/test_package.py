# SPDX-License-Identifier: Apache-2.0
"""The ROS package in `ros/` states what pyproject.toml states, and declares what the code uses."""

from __future__ import annotations

import ast
import re
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGE = ET.parse(ROOT / "ros" / "package.xml").getroot()
USED = re.compile(r"\"(\w+)/(?:msg|srv|action)/\w*\"")
"""A type's name in the code of the node."""
OF_ROBOTS = {"nav2_msgs", "nav_msgs", "tf2_msgs"}
"""What tools and examples name if a robot has it."""
OF_ROS = {"rclpy", "action_msgs", "unique_identifier_msgs", "rcl_interfaces", "ament_index_python"}


def texts(tag: str) -> set[str]:
    return {each.text or "" for each in PACKAGE.iter(tag)}


def test_package_and_project_state_the_same() -> None:
    project = PROJECT["project"]
    assert texts("name") == {"rai_missions"} == {project["name"].replace("-", "_")}
    assert texts("version") == {project["version"]}
    assert texts("description") == {project["description"]}
    assert texts("license") == {project["license"]}
    assert texts("build_type") == {"ament_python"}
    ours = ET.parse(ROOT / "interfaces" / "rai_missions_msgs" / "package.xml").getroot()
    assert {each.text for each in ours.iter("version")} == {project["version"]}


def test_every_package_of_ros_that_the_connector_and_the_node_use_is_declared() -> None:
    used = set()
    for folder in ("connectors/ros2", "node"):
        for path in (ROOT / "rai_missions" / folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            used |= set(USED.findall(text))
            for node in ast.walk(ast.parse(text)):
                named = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                named += [each.name for each in node.names] if isinstance(node, ast.Import) else []
                used |= {name.split(".")[0] for name in named} & OF_ROS
    assert used - OF_ROBOTS - texts("exec_depend") == set()
    assert {"rclpy", "std_srvs"} <= used, "the search finds what is used"


def test_what_colcon_looks_for_lies_in_the_folder_of_the_package() -> None:
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    for name in (*wheel["packages"], *wheel["force-include"]):
        assert (ROOT / "ros" / name).resolve() == ROOT / name, f"ros/{name} is a link to {name}"
    assert (ROOT / "ros" / "resource" / "rai_missions").is_file(), "the marker of the ament index"


def test_no_rule_of_rosdep_is_claimed_for_packages_of_python() -> None:
    """No release of ROS has them in the versions that pyproject.toml asks for; the guide names pip."""
    declared = {each.text or "" for each in PACKAGE if each.tag.endswith("depend")}
    assert not [name for name in declared if name.startswith("python3-")]
