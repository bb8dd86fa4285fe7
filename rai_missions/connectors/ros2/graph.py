# SPDX-License-Identifier: Apache-2.0
"""What is on the ROS graph now, as anybody there sees it, and with what the own node was started."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.action import get_action_names_and_types
from rclpy.node import Node

from rai_missions.connectors.connector import Mode

__all__ = ("listed", "offered", "parameters")

HIDDEN = "/_"
"""Stands in the names that ROS keeps for itself, such as the topics and services that an action is made of."""

OF_ROS = ("use_sim_time", "start_type_description_service")
"""Parameters that each node of ROS has."""
OF_QUALITY = "qos_overrides."


def listed(node: Node, mode: Mode) -> Mapping[str, str]:
    """Names and types of a mode, hidden ones left out. On the node's thread only."""
    find = {
        "topics": node.get_topic_names_and_types,
        "services": node.get_service_names_and_types,
        "actions": lambda: get_action_names_and_types(node),
    }
    return {name: ", ".join(sorted(types)) for name, types in sorted(find[mode]()) if HIDDEN not in name}


def offered(node: Node, mode: Mode) -> Mapping[str, int]:
    """How many publish on each topic, or serve each service or action; who only asks is not counted."""
    counts = {
        "topics": node.count_publishers,
        "services": node.count_services,
        "actions": lambda name: node.count_services(f"{name}/_action/send_goal"),
    }
    counted = {name: counts[mode](name) for name in listed(node, mode)}
    return {name: number for name, number in counted.items() if number}


def parameters(node: Node) -> Mapping[str, Any]:
    """The values of a node's parameters but for those that ROS itself declares. On the node's thread only."""
    found = node.get_parameters_by_prefix("")
    return {name: each.value for name, each in found.items() if name not in OF_ROS and not name.startswith(OF_QUALITY)}
