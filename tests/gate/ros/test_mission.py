# SPDX-License-Identifier: Apache-2.0
"""A mission hands control over across ROS 2: a real runner, a real gate, a connector each."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest

from rai_missions.connectors.contract import Inbox
from rai_missions.gate import GateAgent, gate_words
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner

Open = Callable[..., Any]
BOOL, TRIGGER, TWIST = "std_msgs/msg/Bool", "std_srvs/srv/Trigger", "geometry_msgs/msg/Twist"
LATCHED = {"/gate/holder": {"durability": "latched", "depth": 1}}
MISSION: dict[str, Any] = {
    "name": "crossing_over",
    "ready_s": 30,
    "blackboard": {"there": {"type": "boolean", "source": "robot", "optional": True}},
    "initial": "crossing",
    "states": {
        "crossing": {
            "control": "agent",
            "handover_s": 30,
            "action": "cross",
            "timeout_s": 60,
            "achieved": {"key": "there", "==": True},
            "transitions": [{"on": "succeeded", "to": "over"}],
        },
        "over": {"final": "succeeded", "requires": {"key": "there", "==": True}},
    },
}
ROBOT: dict[str, Any] = {
    "name": "gated",
    "connector": {"kind": "ros2"},
    "blackboard": {"there": {"topic": "/there", "type": BOOL}},
    "actions": {
        "cross": {"start": "/cross", "cancel": "/halt", "succeeded": {"key": "there", "==": True}, "uses": ["base"]}
    },
    "control": {who: f"/gate/{{by}}/hand_to_{who}" for who in ("autonomy", "agent", "operator", "nobody")},
    "holder": {"topic": "/gate/holder", "type": "std_msgs/msg/String"},
    "alive": {"topic": "/gate/agent/alive"},
}


class Robotic:
    """The robot's side: what crosses and halts, the gate before it, and what arrives at its base."""

    def __init__(self, open_ros: Open, **gate: Any) -> None:
        self.clock = WallClock()
        words = gate_words({"leases": {"agent": 1.0}, **gate})
        self.connector = open_ros(now=self.clock.now, **words.options())
        self.gate = GateAgent(words, self.connector, clock=self.clock)
        self.base = open_ros(qos=LATCHED)
        self.orders: Inbox[tuple[str, str]] = Inbox(30.0)
        """What the robot was ordered to do, and who held control then."""
        for service in ("/cross", "/halt"):
            self.base.serve(service, TRIGGER, lambda _, service=service: self._do(service))
        self.gate.run()

    def _do(self, service: str) -> Mapping[str, Any]:
        self.orders((service, self.gate.gate.holder))
        return {"success": True, "message": ""}

    def ask(self, by: str, to: str) -> str:
        replies: Inbox[Any] = Inbox(30.0)
        self.base.call(f"/gate/{by}/hand_to_{to}", TRIGGER, {}, on_reply=replies, timeout_s=20.0)
        (reply,) = replies.wait(bool, "the gate has answered")
        return str(reply.data["message"])


@pytest.fixture
def robotic(open_ros: Open) -> Iterator[Robotic]:
    made = Robotic(open_ros)
    yield made
    made.gate.stop()


def begin(open_ros: Open, **state: Any) -> tuple[Runner, Callable[[], Result]]:
    """A run on a thread of its own, and what waits for its end."""
    states = {**MISSION["states"], "crossing": {**MISSION["states"]["crossing"], **state}}
    clock, results = WallClock(), Inbox[Result](60.0)
    runner = Runner(
        Mission.model_validate({**MISSION, "states": states}),
        robot=Robot.model_validate(ROBOT),
        connector=open_ros(now=clock.now, qos=LATCHED),
        clock=clock,
    )
    thread = threading.Thread(target=lambda: results(runner.run()))
    thread.start()

    def end() -> Result:
        (result,) = results.wait(bool, "the run has ended")
        thread.join()
        return result

    return runner, end


def test_control_goes_over_and_back_and_what_the_agent_does_follows_it(open_ros: Open, robotic: Robotic) -> None:
    _, end = begin(open_ros)
    robotic.orders.wait(lambda reported: ("/cross", "agent") in reported, "it crosses, once the agent has control")
    assert robotic.ask("operator", "operator").startswith("operator holds control")
    robotic.orders.wait(lambda reported: reported[-1][0] == "/halt", "what the agent did is stopped")
    assert robotic.ask("agent", "agent") == "the operator has control and has not given it back"
    robotic.ask("operator", "agent")
    robotic.orders.wait(lambda reported: reported[-1] == ("/cross", "agent"), "it continues when control is given back")
    robotic.base.publish("/there", BOOL, {"data": True})
    assert end().outcome == "succeeded"
    assert [service for service, _ in robotic.orders.all] == ["/cross", "/halt", "/cross"]


def test_an_e_stop_leaves_control_unheld_where_the_actuators_are(open_ros: Open, robotic: Robotic) -> None:
    runner, end = begin(open_ros)
    robotic.orders.wait(lambda reported: ("/cross", "agent") in reported, "it crosses")
    runner.kill()
    assert end().outcome == "aborted"
    assert robotic.gate.gate.holder == "nobody"
    assert "only the operator can lift it" in robotic.ask("autonomy", "autonomy")


def test_a_run_that_begins_while_the_operator_has_control_waits_for_the_hand_back(
    open_ros: Open, robotic: Robotic
) -> None:
    robotic.ask("operator", "operator")
    _, end = begin(open_ros, handover_s=1.0)
    robotic.ask("operator", "autonomy")
    robotic.orders.wait(lambda reported: reported[-1] == ("/cross", "agent"), "it begins when control is given back")
    robotic.base.publish("/there", BOOL, {"data": True})
    assert end().outcome == "succeeded"


def test_a_gate_that_has_gone_acknowledges_nothing(open_ros: Open, robotic: Robotic) -> None:
    robotic.gate.stop()
    _, end = begin(open_ros, handover_s=1.0)
    assert end().why == "crossing: rejected (agent was not given control in time)" and robotic.orders.all == []


def test_a_run_that_hangs_loses_control(open_ros: Open, robotic: Robotic) -> None:
    holders: Inbox[Any] = Inbox(30.0)
    robotic.base.subscribe("/gate/holder", "std_msgs/msg/String", holders)
    runner, end = begin(open_ros)
    robotic.orders.wait(lambda reported: ("/cross", "agent") in reported, "it crosses")
    holders.wait(lambda all_: all_[-1].data["data"] == "agent", "the gate reports it")
    free = threading.Event()
    runner.call_soon(lambda: free.wait(30.0))
    holders.wait(lambda all_: all_[-1].data["data"] == "autonomy", "the gate has noticed")
    free.set()
    robotic.orders.wait(
        lambda reported: reported[-1][0] == "/halt", "the run learns of it, and stops what needs control"
    )
    runner.kill()
    end()


def test_over_ros_only_the_holder_s_commands_arrive_and_a_stop_comes_first(open_ros: Open, robotic: Robotic) -> None:
    arrived: Inbox[float] = Inbox(30.0)
    robotic.base.subscribe("/cmd_vel", TWIST, lambda received: arrived(received.data["linear"]["x"]))
    speaker = open_ros()

    def command(who: str, x: float) -> None:
        speaker.publish(f"/gate/{who}/cmd_vel", TWIST, {"linear": {"x": x}})

    command("autonomy", 1.0)
    arrived.wait(lambda all_: 1.0 in all_, "autonomy drives")
    robotic.ask("agent", "agent")
    command("autonomy", 1.5)
    while robotic.gate.gate.refused.get("autonomy", 0) < 1:
        robotic.gate.tick()
    robotic.ask("operator", "operator")
    command("operator", 3.0)
    arrived.wait(lambda all_: 3.0 in all_, "the operator drives")
    assert 1.5 not in arrived.all
    robotic.gate.stop()
    arrived.wait(lambda all_: all_[-1] == 0.0, "a gate that ends leaves a stop")
