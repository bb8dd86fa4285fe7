# SPDX-License-Identifier: Apache-2.0
"""Who serves a service is known with the names that DDS has, and without."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

Open = Callable[..., Any]
TRIGGER = "std_srvs/srv/Trigger"


class WithoutDdsNames:
    """A real node whose middleware knows no name but those of ROS, as Zenoh."""

    def __init__(self, node: Any) -> None:
        self._node = node

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def get_subscriptions_info_by_topic(self, topic: str, no_mangle: bool = False) -> list[Any]:
        return [] if no_mangle else list(self._node.get_subscriptions_info_by_topic(topic))


@pytest.mark.parametrize("has_dds_names", [True, False])
def test_who_serves_a_service_is_known_and_gone_once_it_is(open_ros: Open, has_dds_names: bool) -> None:
    from rai_missions.connectors.ros2.endpoints import are_gone, servers_of_service, types_of_service

    ours, server = open_ros(), open_ros(node="the_server", namespace="/a")
    runtime = ours._session.runtime
    node = runtime.node if has_dds_names else WithoutDdsNames(runtime.node)
    look = servers_of_service(node, "/a/flash")

    tick = threading.Event()

    def seen(is_there: bool) -> tuple[dict[bytes, str], set[str]]:
        """The servers and their types, once there are some, or none."""
        for _ in range(300):
            done = runtime.ask(lambda: (dict(look()), types_of_service(node, "/a/flash")), ({}, set()))
            if bool(done[0]) == is_there:
                return done
            tick.wait(0.05)
        raise AssertionError(done)

    assert seen(False) == ({}, set())
    close = server.serve("/a/flash", TRIGGER, lambda _: {"success": True, "message": ""})
    then, types = seen(True)
    assert types == {TRIGGER}
    assert (list(then) == [b"/a/the_server"]) is not has_dds_names
    assert not are_gone(then, then)
    close()
    assert are_gone(then, seen(False)[0])
