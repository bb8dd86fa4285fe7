# SPDX-License-Identifier: Apache-2.0
"""The gate on an in-process connector, with a clock that only the test moves."""

from __future__ import annotations

import itertools
import json
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rai_missions.connectors.connector import Data, Message, Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError
from rai_missions.gate import GateAgent, GateWords, gate_words
from rai_missions.gate.gate import EMPTY, STRING, TRIGGER
from rai_missions.gate.state import ControlChange, GateEffect, Pass, Refuse
from rai_missions.runtime.clock import WallClock
from rai_missions.testing import Inbox, check_agent
from tests.rigs.runs import ManualClock

TWIST = "geometry_msgs/msg/Twist"


class Rig:
    """A gate, and everybody around it."""

    def __init__(self, words: GateWords | None = None, connector: type[LocalConnector] = LocalConnector) -> None:
        self.clock = ManualClock()
        self.connector = connector(now=self.clock.now)
        self.connector.start()
        self.effects: list[GateEffect] = []
        self.base: list[float] = []
        """What arrives at the actuators: how fast they shall go."""
        self.status: list[dict[str, Any]] = []
        self.holders: list[str] = []
        self.connector.subscribe("/cmd_vel", TWIST, lambda received: self.base.append(speed(received.data)))
        self.connector.subscribe("/gate/status", STRING, self._receive)
        self.connector.subscribe("/gate/holder", STRING, lambda received: self.holders.append(received.data["data"]))
        self.agent = GateAgent(words or GateWords(), self.connector, clock=self.clock, observe=self.effects.append)
        self.agent.open()

    def _receive(self, received: Message) -> None:
        if received.data["data"].startswith('{"gate"'):
            self.status.append(json.loads(received.data["data"]))

    def command(self, who: str, x: float, **fields: Any) -> None:
        self.connector.publish(f"/gate/{who}/cmd_vel", TWIST, {"linear": {"x": x}, **fields})

    def ask(self, to: str, by: str) -> Reply:
        replies: list[Reply] = []
        self.connector.call(f"/gate/{by}/hand_to_{to}", TRIGGER, {}, on_reply=replies.append)
        (reply,) = replies
        return reply

    def at(self, at: float) -> None:
        self.clock.at = at
        self.agent.tick()


def speed(data: Any) -> float:
    return float(data.get("linear", {}).get("x", 0.0))


@pytest.fixture
def rig() -> Iterator[Rig]:
    made = Rig()
    yield made
    made.agent.close()


def test_the_holder_is_let_through_the_others_are_refused_and_counted(rig: Rig) -> None:
    rig.command("autonomy", 1.0)
    rig.command("agent", 2.0)
    rig.command("operator", 3.0)
    assert rig.base == [0.0, 1.0], "a stop as the gate begins, then what the holder commands"
    rig.at(1.0)
    assert rig.status[-1]["refused"] == {"autonomy": 0, "agent": 1, "operator": 1}
    assert rig.status[-1]["passed"] == {"autonomy": 1, "agent": 0, "operator": 0}
    assert rig.status[-1]["last_command_age_s"] == {"autonomy": 1.0, "agent": 1.0, "operator": 1.0}
    assert rig.status[-1]["last_refusal"] == "operator on /cmd_vel: autonomy holds control"


def test_a_stop_is_published_before_the_new_holder_s_first_command(rig: Rig) -> None:
    rig.command("autonomy", 1.0)
    reply = rig.ask("agent", "agent")
    assert reply.data == {"success": True, "message": "agent holds control, grant 1"}
    rig.command("autonomy", 1.0)
    rig.command("agent", 2.0)
    assert rig.base == [0.0, 1.0, 0.0, 2.0] and rig.holders == ["autonomy", "agent"]


def test_a_request_that_the_rules_refuse_reports_why(rig: Rig) -> None:
    assert rig.ask("operator", "operator").data["success"]
    reply = rig.ask("agent", "agent")
    assert reply.data == {"success": False, "message": "the operator has control and has not given it back"}
    assert rig.ask("agent", "operator").data["success"]
    assert rig.ask("nobody", "autonomy").data["success"], "anyone who sees danger may take control from everybody"
    assert rig.ask("agent", "agent").data["message"].startswith("control is with 'nobody' since the stop")


@pytest.mark.parametrize("text", ['{"to": "agent"}', "agent", '{"to": "agent", "by": "agent"}'])
def test_control_can_be_asked_for_by_a_message(rig: Rig, text: str) -> None:
    rig.connector.publish("/gate/agent/request", STRING, {"data": text})
    assert rig.status[-1]["holder"] == "agent"


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"to": "bob"}', "[" * 100_000, '{"to": {"to": "agent"}}'])
def test_a_message_that_asks_for_nothing_sensible_is_refused_and_counted(rig: Rig, text: str) -> None:
    rig.connector.publish("/gate/agent/request", STRING, {"data": text})
    assert rig.status[-1]["holder"] == "autonomy" and rig.status[-1]["requests_refused"]["agent"] == 1


def test_no_one_asks_in_another_s_name(rig: Rig) -> None:
    rig.connector.publish("/gate/agent/request", STRING, {"data": '{"to": "agent", "by": "operator"}'})
    assert rig.status[-1]["holder"] == "autonomy"
    assert "no one called 'agent as operator' can ask for control" in rig.status[-1]["last_refusal"]


def test_names_of_strangers_are_not_kept(rig: Rig) -> None:
    for name in ("agent", "x1", "x2"):
        rig.connector.publish("/gate/agent/request", STRING, {"data": json.dumps({"to": "moon", "by": name})})
    assert rig.agent.gate.requests_refused == {"agent": 1}
    assert "agent as x2" in rig.status[-1]["last_refusal"]


def test_a_silent_agent_loses_control_at_the_instant_at_which_its_lease_ends(rig: Rig) -> None:
    rig.ask("agent", "agent")
    rig.clock.at = 0.4
    rig.connector.publish("/gate/agent/alive", EMPTY, {})
    rig.at(0.8)
    assert rig.status[-1]["holder"] == "agent"
    rig.at(0.9)
    assert rig.status[-1]["holder"] == "autonomy" and rig.base == [0.0, 0.0, 0.0]
    assert rig.status[-1]["why"] == "agent was silent for 0.5 s"


def test_a_command_older_than_its_grant_is_refused_where_it_states_when_it_was_made(rig: Rig) -> None:
    rig.clock.at = 2.0
    rig.ask("agent", "agent")
    for speed_, stamp in ((5.0, 1.9), (6.0, 0.0), (7.0, 2.0)):
        rig.command("agent", speed_, header={"stamp": {"sec": int(stamp), "nanosec": round(stamp % 1 * 1e9)}})
    assert rig.base == [0.0, 0.0, 6.0, 7.0], "a stamp of zero reports nothing"


def test_what_a_listener_of_the_actuators_does_comes_after_what_it_listens_to(rig: Rig) -> None:
    def grasp(received: Any) -> None:
        if speed(received.data) == 1.0:
            rig.ask("agent", "agent")
            rig.command("agent", 2.0)
            rig.command("autonomy", 1.5)

    rig.connector.subscribe("/cmd_vel", TWIST, grasp)
    rig.command("autonomy", 1.0)
    assert rig.base == [0.0, 1.0, 0.0, 2.0]
    assert [type(each) for each in rig.effects if isinstance(each, Pass | Refuse)] == [Pass, Pass, Refuse]


def test_several_topics_are_guarded_alike_and_stopped_as_each_is() -> None:
    commands = [
        {"topic": "/cmd_vel", "type": TWIST},
        {"topic": "/arm", "type": "std_msgs/msg/String", "stop": {"data": "hold"}},
        {"topic": "/lamp", "type": "std_msgs/msg/String"},
    ]
    rig = Rig(gate_words({"commands": commands}))
    lines: list[str] = []
    for topic in ("/arm", "/lamp"):
        rig.connector.subscribe(topic, STRING, lambda received: lines.append(received.data["data"]))
    rig.connector.publish("/gate/autonomy/lamp", STRING, {"data": "on"})
    rig.connector.publish("/gate/agent/arm", STRING, {"data": "grasp"})
    rig.ask("agent", "agent")
    rig.connector.publish("/gate/agent/arm", STRING, {"data": "grasp"})
    assert lines == ["on", "hold", "grasp"]
    rig.agent.close()


class HalfDown(LocalConnector):
    """A connector of which some topics are down."""

    down: frozenset[str] = frozenset()

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        if topic in self.down:
            raise ConnectorError(f"{topic} is down")
        super().publish(topic, type_name, message)


def test_a_stop_that_fails_holds_up_neither_the_others_nor_the_handover(caplog: pytest.LogCaptureFixture) -> None:
    commands = [
        {"topic": "/cmd_vel", "type": TWIST},
        {"topic": "/arm", "type": "std_msgs/msg/String", "stop": {"data": "hold"}},
    ]
    rig = Rig(gate_words({"commands": commands}), HalfDown)
    lines: list[str] = []
    rig.connector.subscribe("/arm", STRING, lambda received: lines.append(received.data["data"]))
    rig.connector.down = frozenset({"/cmd_vel"})  # type: ignore[attr-defined]
    assert rig.ask("agent", "agent").data["success"]
    assert lines == ["hold"] and rig.holders[-1] == "agent"
    assert any(isinstance(effect, ControlChange) for effect in rig.effects)
    assert "the stop of /cmd_vel was not published" in caplog.text
    rig.agent.close()
    assert lines == ["hold", "hold"]


def test_a_gate_that_ends_leaves_a_stop_and_lets_nothing_through(rig: Rig) -> None:
    rig.command("autonomy", 1.0)
    rig.agent.close()
    rig.command("autonomy", 1.0)
    assert rig.base == [0.0, 1.0, 0.0]
    assert rig.agent.ask("agent", "agent") == {"success": False, "message": "the gate has ended"}


def test_of_two_gates_the_later_one_ends(rig: Rig) -> None:
    def report(began: float) -> bool:
        other = {**rig.status[-1], "gate": [began, "another"]}
        rig.connector.publish("/gate/status", STRING, {"data": json.dumps(other)})
        return rig.agent.gives_way

    ours = rig.status[-1]["gate"][0]
    assert not report(ours + 1.0)
    for text in ("", "[]", "{}", '{ "gate": 3}', '{ "gate": ["x", "y"]}', '{ "gate": [1' + "0" * 400 + ', "y"]}'):
        rig.connector.publish("/gate/status", STRING, {"data": text})
    assert not rig.agent.gives_way
    assert report(ours - 1.0)


def test_a_stop_that_cannot_be_published_is_reported_as_the_gate_begins() -> None:
    connector = LocalConnector()
    connector.start()
    connector.subscribe("/cmd_vel", STRING, lambda _: None)
    with pytest.raises(ConnectorError, match="/cmd_vel is a std_msgs/msg/String, not a geometry_msgs/msg/Twist"):
        GateAgent(GateWords(), connector).open()


def test_the_gate_is_an_agent() -> None:
    connector = LocalConnector()
    connector.start()
    check_agent(lambda: GateAgent(GateWords(), connector))


def test_on_the_wall_s_clock_silence_is_noticed_without_anybody_s_help() -> None:
    clock, changed = WallClock(), Inbox[Any](30.0)
    connector = LocalConnector(now=clock.now)
    connector.start()
    connector.subscribe("/gate/holder", STRING, changed)
    agent = GateAgent(gate_words({"leases": {"agent": 0.05}, "status_s": 60.0}), connector, clock=clock)
    agent.run()
    changed.wait(lambda reported: bool(reported), "the gate has begun")
    assert agent.ask("agent", "agent")["success"]
    changed.wait(
        lambda reported: [each.data["data"] for each in reported[-2:]] == ["agent", "autonomy"], "it was noticed"
    )
    agent.stop()


def test_from_many_threads_nothing_is_lost_and_nothing_of_a_former_holder_comes_late() -> None:
    rig = Rig(gate_words({"leases": {}}))
    rounds = 200

    def play(who: str) -> Callable[[], None]:
        def go() -> None:
            for number in range(rounds):
                rig.command(who, {"autonomy": 1.0, "agent": 2.0}[who])
                if number % 10 == 0:
                    rig.agent.ask(who, who)

        return go

    threads = [threading.Thread(target=play(who)) for who in ("autonomy", "agent")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    gate = rig.agent.gate
    verdicts = [each for each in rig.effects if isinstance(each, Pass | Refuse)]
    assert len(verdicts) == 2 * rounds == sum(gate.passed.values()) + sum(gate.refused.values())
    stretches = [arrived for arrived, before in zip(rig.base, [0.0, *rig.base], strict=False) if arrived != before]
    assert all(0.0 in pair for pair in itertools.pairwise(stretches)), "a stop between any two holders"
    rig.agent.close()
