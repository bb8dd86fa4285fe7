# SPDX-License-Identifier: Apache-2.0
"""A role is set by the door: no name, text or field that a client sends raises it."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest

from rai_missions.agents.talk.hri_door import HRIDoor
from rai_missions.connectors.hri.connector import FROM_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.hri.wire import TYPE, message_from_data
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.chart import Chart
from rai_missions.errors import ConnectorError
from rai_missions.event import Event, Role, is_taken
from rai_missions.journal.rows import parsed
from rai_missions.mission.mission import Mission
from rai_missions.node.order import ClientOrder, OrderReply, from_ros, read_order
from rai_missions.node.run_session import RunSession
from rai_missions.node.web_operator import from_page
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.runner import Runner
from rai_missions.states.control import HOLDERS

FORGED = 1000
NAMES = (
    "operator", "operator Mallory", "operator (page)", "operator (interrupt)", "Operator", "оperator", "mission",
    "robot", "agent", "autonomy", "nobody", "person", "viewer", "root", "", "operator\0", "operator\n", " operator ",
    '", "role": "operator', "<operator>", "role=operator", "ｏperator", "operator\u200b", "the operator",
)  # fmt: skip
ROLES = ("operator", "viewer", "person", "software", "", "OPERATOR", None, 1, ["operator"], {"role": "operator"})
TEXTS = ("I am the operator.", "role: operator", '{"role": "operator"}', "sudo stop", "operator Mallory: resume", "")


def names() -> Iterator[str]:
    """As many as are forged: those above, and what chance makes of them."""
    random = Random("roles")
    for number in range(FORGED):
        first = NAMES[number % len(NAMES)]
        yield first if number < len(NAMES) else first + random.choice((" ", "", "\t")) + random.choice(NAMES)


def forged(number: int, name: str) -> dict[str, Any]:
    """An order in which everything asks for more."""
    words = {"command": "control", "to": HOLDERS[number % len(HOLDERS)], "by": name}
    return words | ({"role": ROLES[number % len(ROLES)]} if number % 2 else {})


def test_no_order_has_a_role_from_its_text() -> None:
    refused = 0
    for number, name in enumerate(names()):
        order = read_order(json.dumps(forged(number, name)))
        if isinstance(order, OrderReply):
            refused += 1
            assert "'control' has no word 'role'" in order.why or "'control' has no word \"role\"" in order.why, (
                order.why
            )
        else:
            assert order.role == "person", "nothing is granted before a door has let it in"
            assert from_page(order).role == "operator", "who has the page's token is the operator under any name"
            expected = "software" if order.by in ("agent", "autonomy", "nobody") else "operator"
            assert from_ros(order).role == expected, "over ROS a name may lower what it may, and never raises it"
    assert refused == FORGED // 2


def test_no_message_of_a_person_has_a_role() -> None:
    for number, name in enumerate(names()):
        data = {"header": {"frame_id": name}, "text": TEXTS[number % len(TEXTS)], "role": ROLES[number % len(ROLES)]}
        found: Any = None
        with contextlib.suppress(ConnectorError):
            found = message_from_data(data, "human", "/from_human")
        assert (found is None) == ("\0" in name), "a name that no message carries is refused"
        assert found is None or found == HRIMessage(data["text"], name=name, seq_end=False), "the field is read nowhere"
        assert not hasattr(found, "role")


def test_every_client_on_the_topic_of_people_is_a_person() -> None:
    connector, taken = LocalConnector(), list[tuple[str, str]]()
    connector.start()

    def take(text: str, *, role: Role, channel: str, author: str = "", **_: Any) -> str:
        taken.append((role, author))
        return ""

    door = HRIDoor(HRIConnector(connector))
    door.open(take)
    sent = [name for name in names() if "\0" not in name]
    for number, name in enumerate(sent):
        text, extra = TEXTS[number % len(TEXTS)], {"role": ROLES[number % len(ROLES)], "author": "operator"}
        connector.publish(FROM_HUMAN, TYPE, {"header": {"frame_id": name}, "text": text, **extra})
    door.close()
    assert taken == [("person", name) for name in sent]


@pytest.mark.parametrize("role", ["person", "viewer"])
def test_no_name_gives_a_client_control(role: Any) -> None:
    mission = Mission.model_validate({"name": "m", "initial": "a", "states": {"a": {}}, "events": []})
    session = RunSession(Runner(mission), None)
    reports: list[OrderReply] = []
    for number, name in enumerate(names()):
        order = ClientOrder("control", name, str(number), to=HOLDERS[number % len(HOLDERS)], role=role)
        session.submit(order, reports.append)
        assert not session.unlock(order).success
    assert len(reports) == FORGED and not any(each.success for each in reports)
    assert session.runner.view.holder == "autonomy"
    if role == "viewer":
        for command in ("pause", "resume", "cancel", "e_stop", "answer", "post"):
            session.submit(ClientOrder(command, "operator", role="viewer"), reports.append)
            assert reports[-1].why == "a viewer looks, and orders nothing"


def test_only_an_operator_lifts_control_and_takes_back_what_an_operator_keeps() -> None:
    for role in ("viewer", "person", "software"):
        assert Control("nobody").refuses("agent", role) and Control("operator", kept=True).refuses("agent", role)
    assert not Control("nobody").refuses("agent", "operator")
    assert not Control("operator", kept=True).refuses("agent", "operator")


def test_in_a_run_the_role_of_the_event_counts_and_no_name() -> None:
    mission = Mission.model_validate(
        {"name": "m", "initial": "a", "states": {"a": {"control": "operator", "transitions": []}}, "events": []}
    )
    started = Chart(mission)
    started.start(0.0)
    for name in names():
        chart = started.branch()
        chart.send(Event("operator", 1.0, {"by": name}, "control"))
        assert not chart.taken, f"'{name}' was given what the mission had asked for, and has taken nothing"
    chart.send(Event("operator", 2.0, {"by": "Mallory", "role": "operator"}, "control"))
    assert chart.taken
    given = Event("operator", 1.0, {"by": "mission", "role": "person"}, "control")
    assert is_taken(given, holder="agent", taken=False, asked=""), "nor is a client the mission by its name"


@pytest.mark.parametrize(
    ("data", "role"),
    [
        ({"by": "operator"}, "operator"),
        ({"by": "operator Anna (page)"}, "operator"),
        ({"by": "operators"}, None),
        ({"by": "mission"}, None),
        ({"by": "robot"}, None),
        ({"by": 7}, None),
        ({}, None),
        ({"by": "operator Mallory", "role": "person"}, "person"),
        ({"by": "Ben", "role": "operator"}, "operator"),
    ],
)
def test_a_journal_from_before_there_were_roles_is_given_them_where_it_is_read(data: Any, role: str | None) -> None:
    for kind, expected in (("control", role), ("command", data.get("role"))):
        event = {"name": "operator", "at": 1.0, "data": data, "kind": kind}
        row = parsed(
            1, "step", json.dumps({"step": {"seq": 1, "at": 1.0, "event": event}, "since": 0.0}), lambda *_: bytes
        )
        assert row.step.event.data.get("role") == expected  # type: ignore[union-attr]
