# SPDX-License-Identifier: Apache-2.0
"""What holds for every test: no network but loopback, no real model's key, and how long hypothesis looks.

Rule: a test that would reach another machine fails at once and states it.
"""

from __future__ import annotations

import gc
import ipaddress
import os
import signal
import socket
import sys
import tempfile
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

pytest_plugins = ("tests.limits",)

QUICK, FIRST, FRESH, DEEP = "quick", "first", "fresh", "deep"
settings.register_profile(
    QUICK,
    max_examples=10,
    deadline=None,
    derandomize=True,  # the same examples everywhere and every time; `make drill` draws fresh ones
    suppress_health_check=[HealthCheck.too_slow],
)
# Where only the verdict counts, as in `make mutate`, a failing example is not made smaller.
settings.register_profile(FIRST, settings.get_profile(QUICK), max_examples=25, phases=[Phase.explicit, Phase.generate])
settings.register_profile(FRESH, settings.get_profile(QUICK), max_examples=25, derandomize=False)
settings.register_profile(DEEP, max_examples=2000, deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", QUICK))

for name in [name for name in os.environ if name.endswith(("_API_KEY", "_API_TOKEN"))]:
    del os.environ[name]
os.environ.update(LANGSMITH_TRACING="false", LANGCHAIN_TRACING_V2="false")
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it, and so would the runs
STATE_HOME = tempfile.TemporaryDirectory(prefix="rai_missions_state_")
"""What a gate finds again stays here, as long as the process lives."""
os.environ["XDG_STATE_HOME"] = STATE_HOME.name


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
SLOW_MARKS = ("local_model", "long", "sim")
SLOW_FOLDERS = frozenset({"model_process", "prove", "tutorial", "voice"})
"""Folders with tests that take seconds: one of them at the end would keep the other workers waiting."""
DRILL_S = 3600
"""Seconds for a test that is long on purpose, also where it is run by itself."""


OFTEN_S = 1e-6


@pytest.fixture
def changes_threads_often() -> Iterator[None]:
    """The interpreter changes threads as often as it can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(OFTEN_S)
    yield
    sys.setswitchinterval(before)


def is_on_ros(item: pytest.Item) -> bool:
    return bool(ON_ROS & set(getattr(item, "fixturenames", ()))) or item.path.name == "test_ros2.py"


@given(st.none())
def draw_nothing(nothing: None) -> None:
    """With its first example hypothesis looks for who keeps its source of chance, and not among what is frozen."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Nearly all that is loaded stays: no search for garbage meanwhile, and none of it in what was loaded later."""
    gc.disable()
    try:
        return (yield)
    finally:
        draw_nothing()
        gc.collect()
        gc.freeze()
        gc.enable()


def is_slow(item: pytest.Item) -> bool:
    return (
        is_on_ros(item)
        or item.path.parent.name in SLOW_FOLDERS
        or any(item.get_closest_marker(each) for each in SLOW_MARKS)
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The slowest first, so that no worker is left with one at the end; and time for the drills."""
    items.sort(key=lambda item: not is_slow(item))
    for item in items:
        if item.get_closest_marker("drill") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(DRILL_S))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    from tests.workers import ByFile

    return ByFile(config, log)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Two more than there are cores, since much of a test's time is waiting, as for who is to be found.

    Each loads every test, some 8 s of a processor, and needs up to 1.4 GB; with less memory there are fewer. Six on two
    cores took no less time, and two tests waited too long for processes of theirs.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    memory_gb = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9
    return max(cores, min(cores + 2, int(memory_gb / 1.4)))
