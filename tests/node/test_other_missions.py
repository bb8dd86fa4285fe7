# SPDX-License-Identifier: Apache-2.0
"""Two missions on one robot: each node names the other, and what both command; over a connector in this process."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.health import OK, WARN
from rai_missions.agents.mission import MissionAgent, RunConfig, prepare
from rai_missions.agents.other_missions import FORGET_S, MOST, RUNS_TOPIC, OtherMissions, RunClaim
from rai_missions.agents.run_claims import claiming, full_name
from rai_missions.connectors.connector import Data, Message
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError
from rai_missions.node import MissionNode
from rai_missions.node.transport import Carrier
from tests.node.scenes import PATIENCE_S, Client, FakeRobot, mission, robot

MINE = RunClaim("i1", "/mine", "errand", "r1", frozenset({"/base/drive", "/horn"}))
OTHER = RunClaim("i2", "/other", "patrol", "r2", frozenset({"/base/drive", "/lamp"}))


@pytest.fixture
def connector() -> Iterator[LocalConnector]:
    connector = LocalConnector()
    connector.start()
    yield connector
    connector.stop()


@pytest.mark.parametrize(
    ("below", "robots", "is_rival"), [("/a", True, True), ("/b", True, False), ("/a", False, False)]
)
def test_each_of_two_missions_on_one_robot_names_the_other_and_what_both_command(
    connector: LocalConnector, caplog: pytest.LogCaptureFixture, below: str, robots: bool, is_rival: bool
) -> None:
    found: dict[str, Inbox[dict[str, Any]]] = {name: Inbox(PATIENCE_S) for name in ("first", "second")}
    claims: Inbox[Message] = Inbox(PATIENCE_S)
    connector.subscribe(RUNS_TOPIC, "std_msgs/msg/String", claims)
    connector.subscribe("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", lambda message: _sort(found, message))
    FakeRobot(connector, "/a"), FakeRobot(connector, "/b")
    nodes = [
        MissionNode(RunConfig(mission(), robot({"kind": "local"}, at)), name, carrier=Carrier(connector, robots, False))
        for name, at in (("first", "/a"), ("second", below))
    ]
    with caplog.at_level(logging.WARNING, "rai_missions.agents.run_claims"):
        try:
            for node in nodes:
                node.run()
                client = Client(connector, node.name.path)
                client.activate()
                client.start()
            if is_rival:
                for name, other in (("first", "second"), ("second", "first")):
                    status = found[name].wait(lambda all_: all_[-1]["level"] == WARN, f"{name} warns")[-1]
                    assert status["message"].startswith(
                        f"the node /{other} commands the same robot (mission errand, run "
                    )
                    assert status["message"].endswith("): /a/move; cancel one of the two missions")
                Client(connector, "/second").call("cancel")
                found["first"].wait(lambda all_: all_[-1]["level"] == OK, "it warns no longer")
            else:
                for name in found:
                    found[name].wait(lambda all_: len(all_) > 4 and all_[-1]["mode"] == "running", f"{name} has looked")
                    assert not any(each["rivals"] for each in found[name].all)
        finally:
            for node in nodes:
                node.stop()
    assert len([each for each in caplog.messages if "commands the same robot" in each]) == (2 if is_rival else 0)
    claimed = [json.loads(each.data["data"]) for each in claims.all]
    assert all(each["run"] and each["mission"] == "errand" for each in claimed if each["commands"])


@pytest.fixture
def warned() -> Iterator[Inbox[str]]:
    found: Inbox[str] = Inbox(PATIENCE_S)
    handler = logging.Handler()
    handler.emit = lambda record: found(record.getMessage())  # type: ignore[method-assign]
    log = logging.getLogger("rai_missions.agents.run_claims")
    log.addHandler(handler)
    yield found
    log.removeHandler(handler)
    assert all(
        each.startswith("a program without a node commands the same robot (mission errand") for each in found.all
    )


def test_two_runs_without_a_node_name_each_other(connector: LocalConnector, tmp_path: Path, warned: Inbox[str]) -> None:
    profile = robot({"kind": "mqtt"}, "/a")
    with ExitStack() as stack:
        for name in ("first", "second"):
            config = RunConfig(mission(), profile, connector=connector, journal=tmp_path / f"{name}.journal")
            made = stack.enter_context(prepare(config))
            stack.enter_context(claiming(made.runner, profile, connector, name))
        warned.wait(lambda all_: len(all_) > 1, "each names the other")


class Away(LocalConnector):
    """Carries nothing at first, as where a broker is away."""

    refused = 0

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        if topic == RUNS_TOPIC and self.refused < 1:
            self.refused += 1
            raise ConnectorError(f"nothing can be published on {topic}: the broker is gone")
        super().publish(topic, type_name, message)


def test_a_claim_that_a_broker_does_not_carry_is_made_again_without_a_word(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    connector, profile, claims = Away(), robot({"kind": "mqtt"}, "/a"), Inbox[Message](PATIENCE_S)
    connector.start()
    connector.subscribe(RUNS_TOPIC, "std_msgs/msg/String", claims)
    config = RunConfig(mission(), profile, connector=connector, journal=tmp_path / "run.journal")
    with prepare(config) as made, claiming(made.runner, profile, connector, "only"):
        claims.wait(bool, "the claim is made again")
    connector.stop()
    assert connector.refused == 1
    assert caplog.messages == []


def test_two_runs_of_programs_in_python_name_each_other(connector: LocalConnector, warned: Inbox[str]) -> None:
    FakeRobot(connector, "/a")
    agents = [MissionAgent(RunConfig(mission(), robot({"kind": "mqtt"}, "/a"), connector=connector)) for _ in range(2)]
    try:
        for agent in agents:
            agent.run()
        warned.wait(lambda all_: len(all_) > 1, "each names the other")
    finally:
        for agent in agents:
            agent.stop()


def _sort(found: dict[str, Inbox[dict[str, Any]]], message: Any) -> None:
    for status in message.data["status"]:
        values = {each["key"]: each["value"] for each in status["values"]}
        found[status["name"].strip("/").partition(":")[0]](status | values)


def test_only_what_both_command_makes_a_rival_and_a_run_that_is_silent_is_over() -> None:
    others = OtherMissions()
    others.receive(OTHER.text(), 10.0)
    others.receive(MINE.text(), 10.0)
    assert others.rivals(MINE, 10.0) == (OTHER._replace(commands=frozenset({"/base/drive"})),)
    assert others.rivals(MINE._replace(commands=frozenset({"/horn"})), 10.0) == ()
    assert others.rivals(MINE, 10.0 + FORGET_S) == ()


def test_a_rival_is_news_once_a_run_and_what_is_remembered_of_a_long_life_is_bounded() -> None:
    others = OtherMissions()
    assert others.news(MINE, [OTHER]) == (OTHER,)
    assert others.news(MINE, [OTHER]) == ()
    assert others.news(MINE._replace(run="r9"), [OTHER]) == (OTHER,)
    for number in range(10 * MOST):
        each = OTHER._replace(run=f"r{number + 10}")
        assert others.news(MINE, [each]) == (each,)
    assert others.news(MINE, [OTHER]) == (OTHER,), "what is long over is forgotten"


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"commands": 3}', '{"instance": "x", "commands": [3, null]}', "\ud800"]
)
def test_what_is_no_report_of_a_run_is_left_out(text: str) -> None:
    others = OtherMissions()
    others.receive(text, 0.0)
    assert others.rivals(MINE, 0.0) == ()


def test_a_relative_name_is_one_of_the_node_s_namespace() -> None:
    assert full_name("drive", "fields/north") == "/fields/north/drive"
    assert full_name("drive", "") == "/drive"
    assert full_name("/drive", "fields") == "/drive"
