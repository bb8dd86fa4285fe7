# SPDX-License-Identifier: Apache-2.0
"""What the gate adds to a command's way, against a relay in plain rclpy and no relay at all; a process each, one run.

A command leaves every 10 ms, in turn on each way; the base reports how long it took.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

WAYS = {"direct": "/direct", "plain relay": "/relayed", "gate": "/cmd_vel"}
FROM = {"direct": "/direct", "plain relay": "/asked", "gate": "/gate/autonomy/cmd_vel"}
COUNT, PERIOD_S, DOMAIN = 1000, 0.01, 91


def relay() -> None:
    """The floor: what comes on one topic continues to another."""
    import rclpy
    from geometry_msgs.msg import Twist

    rclpy.init(domain_id=DOMAIN)
    node = rclpy.create_node("relay")
    publisher = node.create_publisher(Twist, WAYS["plain relay"], 1)
    node.create_subscription(Twist, FROM["plain relay"], publisher.publish, 1)
    with contextlib.suppress(rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


def speak() -> None:
    """Anyone who commands."""
    import rclpy
    from geometry_msgs.msg import Twist

    rclpy.init(domain_id=DOMAIN)
    node = rclpy.create_node("speaker")
    publishers = [node.create_publisher(Twist, topic, 10) for topic in FROM.values()]
    while not all(each.get_subscription_count() for each in publishers):
        time.sleep(0.05)
    time.sleep(1.0)
    for number in range(COUNT * len(publishers)):
        message = Twist()
        message.linear.x, message.angular.x = 1.0, time.monotonic()
        publishers[number % len(publishers)].publish(message)
        time.sleep(PERIOD_S)


def base(speaker: subprocess.Popen[bytes]) -> dict[str, list[float]]:
    """Receive until all that command have ended; how many seconds each command took."""
    import rclpy
    from geometry_msgs.msg import Twist

    rclpy.init(domain_id=DOMAIN)
    node = rclpy.create_node("base")
    took: dict[str, list[float]] = {way: [] for way in WAYS}

    def on_message(way: str, message: Any) -> None:
        if message.linear.x:
            took[way].append(time.monotonic() - message.angular.x)

    for way, topic in WAYS.items():
        node.create_subscription(Twist, topic, lambda message, way=way: on_message(way, message), 100)
    while speaker.poll() is None:
        rclpy.spin_once(node, timeout_sec=0.1)
    return took


def main() -> None:
    if importlib.util.find_spec("rclpy") is None:
        print("ROS 2 is not installed here; nothing is measured")
        return
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp())
    script, python = str(Path(__file__)), [sys.executable, "-W", "ignore"]
    gate = subprocess.Popen([*python, "-m", "rai_missions.cli.main", "gate", "--domain", str(DOMAIN), "--quiet"])
    plain = subprocess.Popen([*python, script, "relay"])
    speaker = subprocess.Popen([*python, script, "speak"])
    try:
        for way, all_ in base(speaker).items():
            ordered = sorted(1e3 * each for each in all_)
            median, p99 = ordered[len(ordered) // 2], ordered[int(len(ordered) * 0.99)]
            print(f"{way:12} {len(ordered):5} of {COUNT}: median {median:.3f} ms, p99 {p99:.3f} ms")
    finally:
        for each in (gate, plain, speaker):
            each.terminate()
            each.wait()


if __name__ == "__main__":
    {"relay": relay, "speak": speak}.get(sys.argv[1] if sys.argv[1:] else "", main)()
