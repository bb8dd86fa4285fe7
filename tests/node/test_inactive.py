# SPDX-License-Identifier: Apache-2.0
"""A run whose node is not active: through no door does more reach it than what ends it, and none begins to move."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.agents.talk.orders import RunOrders
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Order
from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.node import MissionNode
from rai_missions.node.lifecycle_callbacks import DEACTIVATION
from rai_missions.node.order import WORDS, OrderReply, read_order
from rai_missions.node.transport import Carrier
from rai_missions.node.web_operator import ACTS, WebOrders
from rai_missions.profile.conversation import ORDERS
from tests.node.scenes import Client, FakeRobot, mission, robot
from tests.node.test_run_session import AskingRun

WHY = "the node is inactive"
GIVEN: dict[str, dict[str, Any]] = {
    "answer": {"question": 1, "option": "left"},
    "post": {"event": "go"},
    "control": {"to": "operator"},
}
DOORS = [
    *((door, order) for door, orders in (("node", WORDS), ("page", ACTS)) for order in orders if order != "start"),
    *(("talk", order) for order in ORDERS),
]


@pytest.mark.parametrize(("door", "order"), DOORS)
def test_only_what_ends_a_run_reaches_it_where_its_node_is_not_active(door: str, order: str) -> None:
    run, taken, refused = AskingRun(), list[Event](), list[str]()
    run.send("ask")
    run.runner.closed = WHY
    run.runner.post = run.runner.post_urgent = taken.append  # type: ignore[method-assign]
    if door == "talk":
        given = Order(1, order, "operator", "terminal", "", question=1, option="left")  # type: ignore[arg-type]
        RunOrders(run.runner).perform(given, lambda end: refused.append(end.refused))
    elif door == "page":
        text = json.dumps({"command": order, **GIVEN.get(order, {})})
        WebOrders(run.session, answers=True, note=print).submit(text, lambda _, why: refused.append(why))
    else:
        read = read_order(json.dumps({"command": order, **GIVEN.get(order, {})}))
        assert not isinstance(read, OrderReply)
        run.session.submit(read, lambda reply: refused.append(reply.why))
    if order in ("cancel", "stop", "e_stop"):
        assert len(taken) == 1 and not refused
    else:
        assert not taken and refused == [WHY]


@pytest.fixture
def connector() -> Iterator[LocalConnector]:
    found = LocalConnector()
    found.start()
    yield found
    found.stop()


@pytest.mark.parametrize("resumed", [False, True])
@pytest.mark.parametrize("labels", [["deactivate"], ["deactivate", "cleanup"]])
def test_a_run_that_begins_once_its_node_was_deactivated_is_put_to_rest(
    connector: LocalConnector, tmp_path: Path, resumed: bool, labels: list[str]
) -> None:
    path = tmp_path / "run.journal"
    if resumed:
        with Journal.create(path, Header(dump(mission()))) as journal:
            journal.write(Chart(mission(), CompiledTrees()).start(), since=0.0)
    setting = RunConfig(mission(), journal=path, resume=path if resumed else None)
    node = MissionNode(setting, "errand", managed=False, carrier=Carrier(connector, True, False))
    node.run()
    client = Client(connector, "/errand")
    assert all(client.change(label) for label in labels), "before its run is prepared"
    with prepare(node.joined(setting)) as prepared:
        thread = threading.Thread(target=node.attend(prepared.runner).run)
        thread.start()
        if resumed and labels == ["deactivate"]:
            client.await_status("it is paused", lifecycle="inactive", mode="paused")
            assert client.change("activate")
            client.await_status("it continues", lifecycle="active", mode="running")
            assert client.call("cancel")["success"]
        thread.join(30)
        node.conclude()
        client.await_status("it is canceled", outcome="canceled")
    node.stop()


@pytest.mark.parametrize("by", [DEACTIVATION, "Ann", "operator (~/pause)"])
@pytest.mark.parametrize("labels", [(), ("deactivate",), ("deactivate", "cleanup")])
def test_a_run_that_was_killed_in_a_pause_continues_by_who_paused_it(
    connector: LocalConnector, tmp_path: Path, by: str, labels: tuple[str, ...]
) -> None:
    path, chart = tmp_path / "run.journal", Chart(mission(), CompiledTrees())
    with Journal.create(path, Header(dump(mission()))) as journal:
        journal.write(chart.start(), since=0.0)
        journal.write(chart.send(Event("pause", 1.0, {"by": by}, "command")), since=0.0)
    setting = RunConfig(mission(), journal=path, resume=path)
    node = MissionNode(setting, "errand", managed=False, carrier=Carrier(connector, True, False))
    node.run()
    client = Client(connector, "/errand")
    assert all(client.change(label) for label in labels), "before its run is prepared"
    with prepare(node.joined(setting)) as prepared:
        thread = threading.Thread(target=node.attend(prepared.runner).run)
        thread.start()
        if "cleanup" not in labels:
            is_active = by != DEACTIVATION and not labels
            client.await_status("it is paused", lifecycle="active" if is_active else "inactive", mode="paused")
            assert client.change("activate") is not is_active
            client.await_status("the node is active", lifecycle="active")
            if by == DEACTIVATION:
                client.await_status("it continues", mode="running")
            else:
                assert client.call("resume")["success"], "a person continues what a person has paused"
            assert client.call("cancel")["success"]
        thread.join(30)
        node.conclude()
        client.await_status("it is canceled", outcome="canceled")
    node.stop()


def test_a_run_that_continues_shows_which_facts_it_waits_for(connector: LocalConnector, tmp_path: Path) -> None:
    errand = mission(ready_s=600.0)
    path, chart = tmp_path / "run.journal", Chart(errand, CompiledTrees())
    with Journal.create(path, Header(dump(errand))) as journal:
        for step in (chart.write("there", False, at=0.0), chart.start()):
            journal.write(step, since=0.0)
    setting = RunConfig(errand, robot({"kind": "local"}), journal=path, resume=path)
    node = MissionNode(setting, "errand", managed=False, carrier=Carrier(connector, True, True))
    node.run()
    client, there = Client(connector, "/errand"), FakeRobot(connector)
    with prepare(node.joined(setting)) as prepared:
        thread = threading.Thread(target=node.attend(prepared.runner).run)
        thread.start()
        client.await_status("it waits", mode="running", active=["waiting"], waits="waits for the robot: there")
        there.arrive()
        client.await_status("it continues", mode="running", waits="")
        assert client.call("cancel")["success"]
        thread.join(30)
        node.conclude()
    node.stop()
