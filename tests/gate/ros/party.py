# SPDX-License-Identifier: Apache-2.0
"""One party of the drill, in plain rclpy: a holder that commands and asks by a die, or the base that receives it all.

Rule: nothing of ours is used here. A command has who sent it (`linear.x`), which it is (`linear.y`) and when it
left (`angular.x`, seconds of the machine's monotonic clock).
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from typing import Any

CODES = {"autonomy": 1.0, "agent": 2.0, "operator": 3.0}
WISHES = {
    "autonomy": ("autonomy",),
    "agent": ("agent", "agent", "agent", "autonomy", "operator"),
    "operator": ("operator", "agent", "autonomy", "agent", "nobody"),
}
PERIOD_S = 0.01


def say(*what: Any) -> None:
    sys.stdout.write(json.dumps(what) + "\n")
    sys.stdout.flush()


def command(twist: Any, who: str, number: int) -> Any:
    made = twist()
    made.linear.x, made.linear.y, made.angular.x = CODES[who], float(number), time.monotonic()
    return made


def base(node: Any) -> Any:
    """Receives what arrives at the actuators; reports it at the end."""
    from geometry_msgs.msg import Twist
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    arrived: list[tuple[float, float, float]] = []
    direct: list[float] = []
    statuses: list[str] = []
    deep = QoSProfile(depth=5000)
    node.create_subscription(
        Twist, "/cmd_vel", lambda m: arrived.append((m.linear.x, m.linear.y, time.monotonic() - m.angular.x)), deep
    )
    node.create_subscription(Twist, "/direct", lambda m: direct.append(time.monotonic() - m.angular.x), deep)
    latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(String, "/gate/status", lambda m: statuses.append(m.data), latched)
    return lambda: say("base", {"arrived": arrived, "direct": direct, "status": [json.loads(s) for s in statuses]})


class Holder:
    """Commands whether it may or not, with drops, delays and silences; asks for control now and then."""

    def __init__(self, node: Any, who: str, seed: int) -> None:
        from geometry_msgs.msg import Twist
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        self.who, self.die, self.twist, self.text, self.trigger = who, random.Random(seed), Twist, String, Trigger
        self.commands = node.create_publisher(Twist, f"/gate/{who}/cmd_vel", 10)
        self.direct = node.create_publisher(Twist, "/direct", 10)
        self.wishes = node.create_publisher(String, f"/gate/{who}/request", 10)
        self.clients = {to: node.create_client(Trigger, f"/gate/{who}/hand_to_{to}") for to in set(WISHES[who])}
        self.late: list[tuple[float, Any]] = []
        self.number, self.sent, self.quiet_until = 0, 0, 0.0
        self.answers = {True: 0, False: 0}
        node.create_timer(PERIOD_S, self.beat)

    def beat(self) -> None:
        now = time.monotonic()
        while self.late and self.late[0][0] <= now:
            self.publish(self.late.pop(0)[1])
        if now < self.quiet_until:
            return
        self.number += 1
        message, fate = command(self.twist, self.who, self.number), self.die.random()
        if fate < 0.05:
            return  # dropped
        if fate < 0.1:
            self.late.append((now + self.die.uniform(0.0, 0.3), message))
            self.late.sort(key=lambda each: each[0])
            return
        if fate < 0.105:
            self.quiet_until = now + self.die.uniform(0.1, 0.9)
        self.publish(message)
        if fate > 0.8:
            self.direct.publish(command(self.twist, self.who, self.number))
        if self.die.random() < 0.04:
            self.ask()

    def publish(self, message: Any) -> None:
        message.angular.x = time.monotonic()
        self.commands.publish(message)
        self.sent += 1

    def ask(self) -> None:
        to = self.die.choice(WISHES[self.who])
        if self.die.random() < 0.3:
            self.wishes.publish(self.text(data=json.dumps({"to": to})))
        elif self.clients[to].service_is_ready():
            self.clients[to].call_async(self.trigger.Request()).add_done_callback(self.count)

    def count(self, done: Any) -> None:
        self.answers[done.result().success] += 1

    def report(self) -> None:
        report = {"sent": self.sent, "granted": self.answers[True], "denied": self.answers[False]}
        say(self.who, report | {"late": len(self.late)})


def known(node: Any) -> bool:
    """Whether the gate is connected both ways: what was published before would be lost."""
    received = [each.get_subscription_count() for each in node.publishers if each.topic_name.endswith("/cmd_vel")]
    return all(received) and bool(received or node.count_publishers("/cmd_vel"))


def main(role: str, domain: int, seed: int) -> None:
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    rclpy.init(domain_id=domain)
    node = rclpy.create_node(f"party_{role}")
    notify = base(node) if role == "base" else Holder(node, role, seed).report
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    over = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), over.set()), daemon=True).start()
    until = time.monotonic() + 20.0
    while not known(node) and time.monotonic() < until:
        time.sleep(0.02)
    say("ready")
    while not over.is_set():
        executor.spin_once(timeout_sec=0.05)
    notify()
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
