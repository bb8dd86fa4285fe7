# SPDX-License-Identifier: Apache-2.0
"""What every test of ROS 2 needs: whether it is here, loopback only, domains of their own, quick discovery."""

from __future__ import annotations

import fcntl
import importlib
import importlib.util
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import pytest

__all__ = (
    "ABSENT", "QUICK_DISCOVERY", "connectors", "load_quietly", "lock_free_domain", "on_ros", "skip_below",
    "with_messages",
)  # fmt: skip

QUICK_DISCOVERY = Path(__file__).parent / "connectors/ros2/quick_discovery.xml"
WANTED = ("rclpy", "test_msgs", "sensor_msgs", "std_srvs")
ABSENT = [name for name in WANTED if importlib.util.find_spec(name) is None]
on_ros = pytest.mark.skipif(bool(ABSENT), reason=f"ROS 2 is not installed: {', '.join(ABSENT)}")


def with_messages(package: str) -> pytest.MarkDecorator:
    """Skip where a package of interfaces that the wheels of ROS 2 do not bring was not built."""
    is_absent = importlib.util.find_spec(package) is None
    return pytest.mark.skipif(is_absent, reason=f"{package} is not here: make ros-interfaces")


def lock_free_domain() -> tuple[int, IO[str]]:
    """A ROS domain that no other test on this machine uses, and what holds it until it is closed."""
    for domain in range(1, 102):
        lock = open(Path(tempfile.gettempdir()) / f"rai-missions-ros-domain-{domain}.lock", "a")  # noqa: SIM115
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
        else:
            return domain, lock
    raise RuntimeError("all ROS domains are in use by other tests")


def load_quietly() -> None:
    """Load what warns as it is loaded: a parser that ROS brings along uses a deprecated module."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        importlib.import_module("rosidl_generator_py")


def skip_below(folder: Path, items: list[pytest.Item]) -> None:
    """Skip the tests in a folder where ROS is not here."""
    if ABSENT:
        reason = f"ROS 2 is not installed ({', '.join(ABSENT)}): pip install -e '.[ros,ros-test]'"
        for item in items:
            if folder in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=reason))


def connectors(**usual: Any) -> Iterator[Callable[..., Any]]:
    """For a fixture: opens connectors, started; all are stopped after the test.

    Args:
        usual: Options of each that has none of its own.
    """
    from rai_missions.connectors.ros2 import open_connector

    opened: list[Any] = []

    def open_one(now: Callable[[], float] | None = None, **options: Any) -> Any:
        opened.append(open_connector({**usual, **options}, now=now))
        opened[-1].start()
        return opened[-1]

    yield open_one
    for connector in opened:
        connector.stop()
