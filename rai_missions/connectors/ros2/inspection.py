# SPDX-License-Identifier: Apache-2.0
"""What is wrong with what the graph has under a name: two servers, a quality that does not fit, no clock.

Rule: only the graph is read; no request and no message is sent. On the runtime's thread only.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSCompatibility, QoSProfile, ReliabilityPolicy, qos_check_compatible

from rai_missions.connectors.connector import ConnectorMode, Hindrance
from rai_missions.connectors.ros2.config import DEFAULT, Options, QosProfile, is_conventional
from rai_missions.connectors.ros2.endpoints import Peers, node_of, servers_of_action, servers_of_service
from rai_missions.connectors.ros2.publishers import profile

__all__ = ("hindrances", "unlatched")

CLOCK = "/clock"
UNKNOWN = "a node that is not known yet"


def hindrances(node: Node, options: Options, wanted: Iterable[tuple[ConnectorMode, str, bool]]) -> Iterator[Hindrance]:
    """What hinders a mission to use what is there.

    Args:
        node: A node that knows the graph.
        options: The connector's.
        wanted: Mode, name, and whether the mission publishes there.
    """
    for mode, name, is_ours in wanted:
        if mode == "topics":
            yield from _of_topic(node, name, options.quality(name), is_ours=is_ours)
        else:
            look = servers_of_action if mode == "actions" else servers_of_service
            yield from _of_servers(name, look(node, name)())
    has_clock = bool(node.count_publishers(CLOCK))
    if options.sim_time and not has_clock:
        remedy = "start the simulation, or take 'sim_time' out of the connector"
        yield Hindrance(CLOCK, "is not published, and with 'sim_time' time does not pass", remedy)
    elif has_clock and not options.sim_time:
        remedy = (
            'if the robot follows it, add "sim_time": true to the connector; else its stamps count as old or future'
        )
        yield Hindrance(CLOCK, "is published, and the connector has no 'sim_time'", remedy, is_fatal=False)


def _of_servers(name: str, servers: Peers) -> Iterator[Hindrance]:
    if len(servers) > 1:
        counts = Counter(each or UNKNOWN for each in servers.values())
        nodes = " and ".join(
            node if count == 1 else f"{node} ({count} times)" for node, count in sorted(counts.items())
        )
        yield Hindrance(name, f"has {len(servers)} servers: {nodes}", "end all but one, or give each a namespace")


def _of_topic(node: Node, topic: str, quality: QosProfile, *, is_ours: bool) -> Iterator[Hindrance]:
    look = node.get_subscriptions_info_by_topic if is_ours else node.get_publishers_info_by_topic
    others = list(look(topic))
    if not is_ours and (why := unlatched(topic, quality, others)):
        yield Hindrance(topic, *why, is_fatal=False)
    if not is_ours and is_conventional(quality):
        quality = replace(quality, durability="volatile")
    ours = profile(quality, "reliable" if is_ours else "best_effort")  # a reader takes less where it may
    for each in others:
        offered, wished = (ours, each.qos_profile) if is_ours else (each.qos_profile, ours)
        if qos_check_compatible(offered, wished)[0] == QoSCompatibility.ERROR:
            who, lacking = node_of(each) or UNKNOWN, _lacking(offered, wished)
            what = f"does not reach {who}, which asks for" if is_ours else f"is not received from {who}, which lacks"
            yield Hindrance(topic, f"{what} {lacking}", f"correct connector/qos/{topic} or that node")


def _lacking(offered: QoSProfile, wished: QoSProfile) -> str:
    """The policies of which less is offered than wished for, in the words of a profile."""
    is_late = wished.durability == DurabilityPolicy.TRANSIENT_LOCAL != offered.durability
    is_lossy = wished.reliability == ReliabilityPolicy.RELIABLE != offered.reliability
    words = [word for word, is_lacking in (("'reliable'", is_lossy), ("'latched'", is_late)) if is_lacking]
    return " and ".join(words) or "a quality that is not offered"


def unlatched(topic: str, quality: QosProfile, publishers: Iterable[Any]) -> tuple[str, str] | None:
    """What is lost of a latched topic that is read as any other, and the remedy; None where nothing is."""
    is_latched = any(each.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in publishers)
    if not is_latched or quality is not DEFAULT:
        return None
    remedy = f'add to the connector: "qos": {{"{topic}": {{"durability": "latched"}}}}'
    return "is latched, and what was published before is not received", remedy
