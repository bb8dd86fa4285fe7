# SPDX-License-Identifier: Apache-2.0
"""Which connector carries a node: the robot's own, or, where that ends in this process, one to ROS 2.

Rule: what must be known before a connector opens is passed to it here: names, arguments, topics that are latched.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Connector
from rai_missions.connectors.registry import connector_offer, open_offered
from rai_missions.errors import UsageError
from rai_missions.node.names import NodeName, node_name
from rai_missions.profile import Robot

__all__ = ("LOG_TOPIC", "PACKAGE", "Carrier", "name_of", "open_carrier")

LATCHED = ("status", "mission_status", "control")
"""The node's own topics whose last message a late reader receives."""
LOG_TOPIC = "/rosout"
LOG = {"durability": "latched", "depth": 1000}
"""As `rcl` publishes it, for readers that ask for no less."""
PACKAGE = "rai_missions_msgs"


class Carrier(NamedTuple):
    """What carries a node."""

    connector: Connector
    robots: bool
    """It is the robot's as well: missions run over it."""
    typed: bool
    """The types of `rai_missions_msgs` can be used."""


def name_of(given: str, mission: str, robot: Robot | None, ros_arguments: Sequence[str] = ()) -> NodeName:
    """The node's name: the one given, else the profile's, else the mission's.

    Raises:
        UsageError: ROS takes no node of that name.
    """
    is_remote = robot is not None and connector_offer(str(robot.connector["kind"])) is not None
    options = robot.connector if robot is not None and is_remote else {}
    name = given or str(options.get("node") or "") or mission
    return node_name(name, namespace=str(options.get("namespace") or ""), ros_arguments=ros_arguments)


def open_carrier(
    robot: Robot | None, name: NodeName, *, now: Callable[[], float], ros_arguments: Sequence[str]
) -> Carrier:
    """A connector for a node, not started.

    Args:
        robot: The profile.
        name: The node's.
        now: Seconds on the clock of the run that is under way.
        ros_arguments: What follows `--ros-args`.

    Raises:
        UsageError: Its libraries are not here, or an option is not understood.
    """
    options = dict(robot.connector) if robot is not None else {"kind": "local"}
    kind = str(options.pop("kind"))
    offer = connector_offer(kind)
    is_robots = offer is not None
    if offer is None:
        kind, options, offer = "ros2", {}, connector_offer("ros2")
    assert offer is not None
    if kind == "ros2":
        options = _of_ros(options, name, ros_arguments)
    elif ros_arguments:
        raise UsageError(f"--ros-args: the profile's connector is of kind '{kind}', which takes none")
    connector = open_offered(offer, options, now=now if is_robots else None)
    return Carrier(connector, is_robots, kind == "ros2" and importlib.util.find_spec(PACKAGE) is not None)


def _of_ros(options: dict[str, Any], name: NodeName, ros_arguments: Sequence[str]) -> dict[str, Any]:
    latched = {"durability": "latched", "depth": 1}
    qos = {name.below(topic): latched for topic in LATCHED} | {LOG_TOPIC: LOG} | dict(options.get("qos") or {})
    arguments = [*(options.get("arguments") or ()), *ros_arguments]
    return options | {"node": name.name, "namespace": f"/{name.namespace}", "qos": qos, "arguments": arguments}
