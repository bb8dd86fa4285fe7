# SPDX-License-Identifier: Apache-2.0
"""What publishers offer, as bags of ROS 2 write it: the YAML text of `offered_qos_profiles`.

Source: rosbag2_storage, `qos.cpp`, of version 9 of the bags' metadata (Jazzy and later), whose policies are words.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

__all__ = ("offered_quality",)


def offered_quality(profiles: Iterable[Any]) -> str:
    """A YAML list with an entry for each publisher; empty without one.

    Args:
        profiles: rclpy's `QoSProfile` of each.
    """
    return "".join(_entry(profile) for profile in profiles)


def _entry(profile: Any) -> str:
    fields = {
        "history": _word(profile.history),
        "depth": str(profile.depth),
        "reliability": _word(profile.reliability),
        "durability": _word(profile.durability),
        "deadline": _time(profile.deadline),
        "lifespan": _time(profile.lifespan),
        "liveliness": _word(profile.liveliness),
        "liveliness_lease_duration": _time(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": str(bool(profile.avoid_ros_namespace_conventions)).lower(),
    }
    lines = [f"{name}: {value}" for name, value in fields.items()]
    return "- " + "\n  ".join(lines) + "\n"


def _word(policy: Any) -> str:
    return str(policy.name).lower()


def _time(duration: Any) -> str:
    seconds, nanoseconds = divmod(int(duration.nanoseconds), 10**9)
    return f"\n    sec: {seconds}\n    nsec: {nanoseconds}"
