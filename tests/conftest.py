# SPDX-License-Identifier: Apache-2.0
"""What holds for every test: no network but loopback, no real model's key, and how long hypothesis looks.

Rule: a test that would reach another machine fails at once and says so.
"""

from __future__ import annotations

import ipaddress
import os
import socket
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

QUICK, DEEP = "quick", "deep"
settings.register_profile(
    QUICK,
    max_examples=25,
    deadline=None,
    derandomize=os.environ.get("CI") == "true",
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(DEEP, max_examples=2000, deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", QUICK))

for name in [name for name in os.environ if name.endswith(("_API_KEY", "_API_TOKEN"))]:
    del os.environ[name]
os.environ.update(LANGSMITH_TRACING="false", LANGCHAIN_TRACING_V2="false")


def is_here(host: object) -> bool:
    """Whether a host, by name or by address, is this machine's loopback."""
    text = host.decode() if isinstance(host, bytes) else str(host)
    if text in ("", "localhost"):
        return True
    try:
        return ipaddress.ip_address(text.partition("%")[0]).is_loopback
    except ValueError:
        return False


def refuse(host: object) -> None:
    raise RuntimeError(f"a test tried to reach {host!r}; tests reach nothing but this machine")


class LoopbackSocket(socket.socket):
    """A socket that connects to nothing but loopback and local files."""

    def check(self, address: Any) -> None:
        if self.family in (socket.AF_INET, socket.AF_INET6) and not is_here(address[0]):
            refuse(address[0])

    def connect(self, address: Any) -> None:
        self.check(address)
        super().connect(address)

    def connect_ex(self, address: Any) -> int:
        self.check(address)
        return super().connect_ex(address)


def getaddrinfo_here(host: Any, *args: Any, **kwargs: Any) -> Any:
    if host is not None and not is_here(host):
        refuse(host)
    return getaddrinfo_anywhere(host, *args, **kwargs)


getaddrinfo_anywhere = socket.getaddrinfo
socket.getaddrinfo = getaddrinfo_here
socket.socket = LoopbackSocket  # type: ignore[misc]


ON_ROS = frozenset({"ros", "domain", "graph", "tried"})
"""Fixtures of the tests that start nodes of ROS 2."""
SLOW = ("local_model", "sim")


def is_on_ros(item: pytest.Item) -> bool:
    return bool(ON_ROS & set(getattr(item, "fixturenames", ()))) or item.path.name == "test_ros2.py"


def shares(item: pytest.Item) -> bool:
    """Whether something is made once for all tests of the file, such as a browser."""
    info = getattr(item, "_fixtureinfo", None)
    return info is not None and any(
        made.scope == "module" for known in info.name2fixturedefs.values() for made in known
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slowest first, so that no worker is left with one at the end.

    What is made once a file is made by one worker, who runs the file's tests; so it is with the nodes of ROS.
    """
    for item in items:
        if is_on_ros(item) or shares(item):
            item.add_marker(pytest.mark.xdist_group("/".join(item.path.parts[-3:])))
    items.sort(key=lambda item: not is_on_ros(item) and not any(item.get_closest_marker(each) for each in SLOW))


def pytest_xdist_auto_num_workers() -> int:
    """Two more than there are cores: about half of the time that tests take is waiting, as for who is to be found."""
    return (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1) + 2
