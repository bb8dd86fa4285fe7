# SPDX-License-Identifier: Apache-2.0
"""Whether ROS 2 works here: where it comes from, whether it loads, which nodes it reaches, and how soon nodes meet."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping

from rai_missions.cli.doctor.finding import MachineFinding, tried
from rai_missions.cli.doctor.interfaces import copies
from rai_missions.cli.doctor.machine import installed
from rai_missions.connectors.ros2 import how_to_install

__all__ = ("ros",)

RANGES = {
    "SUBNET": "it multicasts to the network: every ROS node there receives from this machine and can command it",
    "LOCALHOST": "only nodes of this machine meet",
    "OFF": "only nodes of one process meet",
    "SYSTEM_DEFAULT": "the middleware's own settings decide which nodes meet",
}
"""ROS_AUTOMATIC_DISCOVERY_RANGE → what it means."""
AT_HOME = "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST keeps it on this machine"
LAST_DOMAIN, LAST_SAFE_DOMAIN = 232, 101


def ros(environment: Mapping[str, str] | None = None, *, has_wheels: bool | None = None) -> Iterator[MachineFinding]:
    """Look at ROS.

    Args:
        environment: The variables that ROS reads; this process's own if left out.
        has_wheels: ROS comes from wheels; looked up if left out.
    """
    given = dict(os.environ if environment is None else environment)
    wheels = bool(installed("ros-rclpy")) if has_wheels is None else has_wheels
    sourced = given.get("ROS_DISTRO")
    if not sourced and not wheels:
        yield MachineFinding("absent", "ROS 2", how_to_install())
        return
    yield from copies(given)
    if sourced and wheels:  # libraries would come from either at random
        remedy = "use one: a shell without the sourced ROS, or an environment without the ros-* wheels"
        yield MachineFinding("missing", f"ROS {sourced} is sourced and ROS wheels are installed", remedy)
        return
    where = f"ROS {sourced}, sourced" if sourced else "ROS 2 from wheels"
    loaded = tried("load", None, given)
    if loaded.fault:
        yield MachineFinding("missing", f"{where}: rclpy does not load ({loaded.fault})", how_to_install())
        return
    yield MachineFinding(
        "ok", f"{where}: rclpy in {os.path.dirname(loaded.value['file'])}, middleware {loaded.value['rmw']}"
    )
    yield _range(given)
    yield _domain(given)
    yield _discovery(given)


def _range(given: Mapping[str, str]) -> MachineFinding:
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    if given.get("ROS_LOCALHOST_ONLY") == "1":
        return MachineFinding(
            "ok", f"ROS_LOCALHOST_ONLY=1 (an older word, which goes before {name}): {RANGES['LOCALHOST']}"
        )
    value = given.get(name, "")
    if value and value not in RANGES:
        return MachineFinding("missing", f"{name}={value} is not known", f"set one of {', '.join(RANGES)}")
    peers = f"; and with ROS_STATIC_PEERS={given['ROS_STATIC_PEERS']}" if given.get("ROS_STATIC_PEERS") else ""
    meaning = RANGES[value or "SUBNET"] + peers
    is_open = value in ("", "SUBNET")
    what = f"{name}={value}" if value else f"{name} is not set, which is SUBNET"
    return MachineFinding("warns" if is_open else "ok", f"{what}: {meaning}", AT_HOME if is_open else "")


def _domain(given: Mapping[str, str]) -> MachineFinding:
    domain = given.get("ROS_DOMAIN_ID", "")
    if not domain:
        return MachineFinding("ok", "ROS_DOMAIN_ID is not set, which is 0: shared with all who have not set it either")
    if not domain.isdecimal() or int(domain) > LAST_DOMAIN:
        return MachineFinding(
            "missing", f"ROS_DOMAIN_ID={domain} is no domain", f"set a number from 0 to {LAST_SAFE_DOMAIN}"
        )
    if int(domain) > LAST_SAFE_DOMAIN:
        why = f"its ports are also given to other programs; better a number from 0 to {LAST_SAFE_DOMAIN}"
        return MachineFinding("warns", f"ROS_DOMAIN_ID={domain}: {why}")
    return MachineFinding("ok", f"ROS_DOMAIN_ID={domain}: only nodes of that domain meet")


def _discovery(given: Mapping[str, str]) -> MachineFinding:
    """Tried on loopback whatever is set, so that no other node is disturbed."""
    here = {name: value for name, value in given.items() if name not in ("ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY")}
    found = tried("discovery", None, {**here, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, within_s=60)
    if found.value is not None:
        return MachineFinding("ok", f"two nodes on loopback met after {found.value:.1f} s")
    why = found.fault or "they did not meet"
    remedy = "look for a firewall on loopback, for a middleware's own profile, and for a full /dev/shm"
    return MachineFinding("missing", f"two nodes on loopback ({why})", remedy)
