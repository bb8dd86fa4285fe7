# SPDX-License-Identifier: Apache-2.0
"""Who serves a name: known by the identities of its endpoints, so that a server that died and came back is another.

Rule: a server is gone when none of the endpoints that were there is there, or when its node has come back as another.

Actions are looked up by the names of ROS. Services are looked up by the names that DDS gives them, since ROS 2 Jazzy
has no query for the endpoints of a service. A middleware without such names (Zenoh) leaves the names of the nodes that
serve it: a server that is back under its node's name is then the one from before.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from importlib.metadata import version
from typing import Any

from rclpy.node import Node, NodeNameNonExistentError

__all__ = (
    "NO_PEERS", "Peers", "are_gone", "are_replaced", "full_action", "node_of", "servers_of_action",
    "servers_of_service", "types_of_action", "types_of_service", "why_unserved",
)  # fmt: skip

Peers = Mapping[bytes, str]
"""The identities of a server's endpoints, each with its node's name, empty while that is not known.

Where the middleware has none for a service, the node's name is the identity.
"""
NO_PEERS: Peers = {}
FEEDBACK = "/_action/feedback"
REMAPS_ACTIONS = int(version("rclpy").partition(".")[0]) >= 9
REQUEST = re.compile(r"^(?P<package>\w+?)(?:::|/)srv(?:::|/)(?:dds_(?:::|/))?(?P<name>\w+)_Request_?$")
"""A request's type as DDS knows it, `std_srvs::srv::dds_::Trigger_Request_`, or as ROS does."""


def full_action(node: Node, action: str) -> str:
    """The full name of an action, as the graph lists it."""
    return str(node.resolve_topic_name(f"{_own_name(node, action)}{FEEDBACK}")).removesuffix(FEEDBACK)


def _own_name(node: Node, action: str) -> str:
    """The name of which an action's topics and services are made; each of these may be remapped.

    Jazzy remaps no action by its own name. Later distributions do (rcl, pull request 1170).
    """
    return str(node.resolve_topic_name(action)) if REMAPS_ACTIONS else action


def servers_of_action(node: Node, action: str) -> Callable[[], Peers]:
    """Looks up who serves an action: anyone who publishes its status."""
    topic = f"{_own_name(node, action)}/_action/status"
    return lambda: _peers(node.get_publishers_info_by_topic(topic))


def servers_of_service(node: Node, service: str) -> Callable[[], Peers]:
    """Looks up who serves a service: anyone who reads its requests, under the name that DDS knows them by."""
    return lambda: _peers(_readers(node, service)) or dict.fromkeys(_nodes(node, service), "")


def types_of_service(node: Node, service: str) -> set[str]:
    """The types by which a service is served now: `std_srvs/srv/Trigger`."""
    found = (REQUEST.match(each.topic_type) for each in _readers(node, service))
    known = {f"{each['package']}/srv/{each['name']}" for each in found if each is not None}
    return known or {type_name for types in _nodes(node, service).values() for type_name in types}


def types_of_action(node: Node, action: str) -> set[str]:
    """The types by which an action is served now: those of its feedback, which a server alone publishes."""
    topic = f"{_own_name(node, action)}{FEEDBACK}"
    return {each.topic_type.removesuffix("_FeedbackMessage") for each in node.get_publishers_info_by_topic(topic)}


def why_unserved(name: str, type_name: str, types: set[str]) -> str:
    """Why a name has no server that can be asked, with the types of those that serve it as another."""
    others = ", ".join(sorted(types - {type_name}))
    if not others:
        return f"no server offers {name}"
    return f"{name} is served as {others}, and not as the {type_name} that is asked for; mend the type"


def _readers(node: Node, service: str) -> list[Any]:
    """The readers of the requests, as DDS names these."""
    topic = f"rq{node.resolve_service_name(service)}Request"
    found: list[Any] = node.get_subscriptions_info_by_topic(topic, no_mangle=True)
    return found


def _nodes(node: Node, service: str) -> dict[bytes, list[str]]:
    """The nodes that serve it, by their names, with the types; no middleware's names are needed for that."""
    name = node.resolve_service_name(service)
    found: dict[bytes, list[str]] = {}
    for each, namespace in node.get_node_names_and_namespaces() if node.count_services(name) else ():
        try:
            served = dict(node.get_service_names_and_types_by_node(each, namespace))
        except NodeNameNonExistentError:  # it has just gone
            continue
        if name in served:
            found[f"{namespace.rstrip('/')}/{each}".encode()] = served[name]
    return found


def _peers(found: list[Any]) -> Peers:
    return {bytes(each.endpoint_gid): node_of(each) for each in found}


def node_of(endpoint: Any) -> str:
    """The full name of an endpoint's node; empty while that is not known."""
    return "" if "UNKNOWN" in endpoint.node_name else f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def are_gone(then: Peers, now: Peers) -> bool:
    """Whether the servers that were there then are there no more; unknown ones are taken to be there.

    Where they are known, this reports it, and not whether ROS calls a server of the name ready: while another one comes
    or goes and is not matched yet, it calls none so.
    """
    left = then.keys() & now.keys()
    reborn = {now[identity] for identity in now.keys() - then.keys()} - {""}
    return bool(then) and all(now[identity] in reborn for identity in left)


def are_replaced(then: Peers, now: Peers) -> bool:
    """Whether others are there instead of the servers that were there then. No one at all is no proof of it.

    A machine that is busy loses sight of a server that lives.
    """
    return bool(now) and are_gone(then, now)
