# SPDX-License-Identifier: Apache-2.0
"""Who serves a name: known by the identities of its endpoints, so that a server that died and came back is another.

Rule: a server is gone when none of the endpoints that were there is there, or when its node has come back as another.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

__all__ = ("Peers", "are_gone", "servers_of_action", "servers_of_service")

Peers = frozenset[tuple[bytes, str]]
"""The identities of a server's endpoints, each with its node's name."""


def servers_of_action(node: Node, action: str) -> Callable[[], Peers]:
    """Looks up who serves an action: whoever publishes its status."""
    topic = f"{node.resolve_service_name(action)}/_action/status"
    return lambda: _peers(node.get_publishers_info_by_topic(topic))


def servers_of_service(node: Node, service: str) -> Callable[[], Peers]:
    """Looks up who serves a service: whoever reads its requests, under the name that DDS knows them by."""
    topic = f"rq{node.resolve_service_name(service)}Request"
    return lambda: _peers(node.get_subscriptions_info_by_topic(topic, no_mangle=True))


def _peers(found: list[Any]) -> Peers:
    return frozenset((bytes(each.endpoint_gid), f"{each.node_namespace}/{each.node_name}") for each in found)


def are_gone(then: Peers, now: Peers) -> bool:
    """Whether the servers that were there then are there no more; unknown ones are taken to be there."""
    left = then & now
    if not then or not left:
        return bool(then)
    reborn = {name for identity, name in now - then}
    return all(name in reborn for identity, name in left)
