# SPDX-License-Identifier: Apache-2.0
"""What a run does on its robot besides goals: messages, control, polls; and what it reports when it breaks off."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.profile import Robot
from rai_missions.runtime.robot_listener import RobotListener
from rai_missions.runtime.scheduler import Scheduler
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import KEYS, Mailbox, ManualClock, Rig, mission, robot

LIT: Any = {
    "waiting": {"transitions": [{"on": "go", "to": "over", "do": [{"publish": "lamp", "message": {"data": True}}]}]},
    "over": {"final": "aborted"},
}
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"


def test_a_message_is_published_where_the_profile_names_its_topic() -> None:
    rig, seen = Rig(LIT), list[Message]()
    rig.connector.subscribe("/lamp", "std_msgs/msg/Bool", seen.append)
    rig.stage.play({1.0: lambda: rig.post("go")})
    rig.run()
    assert [message.data for message in seen] == [{"data": True}]


def test_bytes_in_what_a_robot_sends_keep_neither_event_nor_result_from_the_mission() -> None:
    states = {
        "asking": {"call": "horn", "result": {"count": "size"}, "transitions": [{"on": "succeeded", "to": "moving"}]},
        "moving": {
            "action": "move", "result": {"speed": "best.speed"}, "transitions": [{"on": "succeeded", "to": "alert"}]
        },
        "alert": {"transitions": [{"on": "go", "to": "over"}]},
        "over": {"final": "aborted"},
    }  # fmt: skip
    keys = {**KEYS, "speed": {"type": "number", "source": "mission", "initial": 0.0}}
    events = {"go": {"topic": "/alarm", "type": "x/msg/Alarm"}, **{n: {"posted": True} for n in ("again", "stop_now")}}
    rig = Rig(mission(states, blackboard=keys), robot=robot(events=events))
    rig.answer = {"success": True, "message": "", "size": 3, "map": b"xyz"}
    best = {"id": {"uuid": b"16"}, "speed": 1.5}
    rig.stage.play(
        {
            1.0: lambda: rig.move.report("succeeded", best=best, map=b"x"),
            2.0: lambda: rig.connector.publish("/alarm", "x/msg/Alarm", {"who": {"uuid": b"16"}, "level": 2}),
            3.0: rig.runner.kill,
        }
    )
    rig.run()
    assert rig.entered[-1] == "over"
    assert [write for step in rig.steps for write in step.writes if write[0] in ("count", "speed")][-2:] == [
        ("count", 3),
        ("speed", 1.5),
    ]
    assert rig.steps[-1].event.data == {"who": {}, "level": 2}


def test_control_that_the_robot_tracks_goes_to_no_one_whom_the_profile_does_not_name() -> None:
    states = {"moving": {"control": "agent", "handover_s": 3, "action": "move", "transitions": []}}
    rig = Rig(states, robot=robot(control={"operator": "/give"}, holder={"topic": "/holder", "type": STRING}))
    rig.stage.play({0.1: lambda: rig.connector.publish("/holder", STRING, {"data": "autonomy"})})
    result = rig.run()
    assert result.why == "moving: rejected (agent was not given control in time)"
    assert rig.move.goals == []


def test_a_listener_asks_a_service_until_it_is_closed_and_its_replies_are_of_their_receipt() -> None:
    polled = {"service": "/charge", "type": TRIGGER, "every_s": 1.0, "field": "message"}
    connector, asked, clock = LocalConnector(), list[float](), ManualClock()
    mailbox = Mailbox()
    scheduler = Scheduler(clock, mailbox)

    def charge(_: object) -> dict[str, object]:
        asked.append(clock.at)
        return {"success": True, "message": "0.8"}

    connector.serve("/charge", TRIGGER, charge)
    connector.start()
    listener = RobotListener(
        Robot.model_validate({"name": "one", "blackboard": {"charge": polled}}), connector, scheduler
    )
    listener.open()
    for clock.at in (1.0, 2.0):
        scheduler.run_due()
    listener.close()
    for clock.at in (3.0, 4.0):
        scheduler.run_due()
    connector.stop()
    assert asked == [0.0, 1.0, 2.0]
    read = []
    while (event := mailbox.take()) is not None:
        read.append((event.at, event.data))
    assert read == [(at, {"value": "0.8", "stamp": at}) for at in asked]


class FullJournal(MemoryJournal):
    """A journal that takes no note."""

    def note(self, text: str, data: Any = None) -> int:
        raise ConnectorError("the disk is full")


BROKEN, FULL = (
    "the run breaks off: RuntimeError: the wire",
    "why the run breaks off cannot be written down: the disk is full",
)


@pytest.mark.parametrize(
    ("fault", "journal", "logged"),
    [
        (RuntimeError("the wire"), MemoryJournal(), [BROKEN]),
        (RuntimeError("the wire"), FullJournal(), [BROKEN, FULL]),
        (UsageError("the wire"), MemoryJournal(), []),
        (ConnectorError("the wire"), FullJournal(), [FULL]),
    ],
)
def test_what_the_caller_gets_in_a_sentence_is_not_logged_as_well(
    fault: Exception, journal: MemoryJournal, logged: list[str], monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    rig = Rig(LIT, journal=journal)

    def fails(*_: object) -> None:
        raise fault

    def breaks() -> None:
        monkeypatch.setattr(Chart, "send", fails)
        rig.post("go")

    rig.stage.play({1.0: breaks})
    with pytest.raises(type(fault), match=str(fault)):
        rig.run()
    assert journal.notes == [f"the run breaks off: {type(fault).__name__}: the wire"] * (
        not isinstance(journal, FullJournal)
    )
    assert [record.getMessage() for record in caplog.records] == logged


def test_control_that_is_refused_is_logged_with_the_reason_of_the_robot(caplog: pytest.LogCaptureFixture) -> None:
    states = {"moving": {"control": "agent", "handover_s": 3, "action": "move"}}
    rig = Rig(states, robot=robot(control={"agent": "/give"}))
    rig.connector.serve("/give", TRIGGER, lambda _: {"success": False, "message": "not now"})
    assert rig.run().outcome == "failed"
    assert "control does not go to agent: not now" in caplog.messages


class VanishedServers(LocalConnector):
    """Each call is sent, and its server is gone before it replies."""

    def call(self, *_: object, on_reply: Any, **words: object) -> None:
        on_reply(Reply("unavailable", {}, "the server vanished", may_have_arrived=True))


@pytest.mark.parametrize("repeat", [False, True])
def test_a_call_that_may_have_been_done_has_failed_and_is_uncertain_unless_it_may_be_repeated(*, repeat: bool) -> None:
    horn = {"service": "/horn", "type": TRIGGER, "repeat": repeat}
    away = [{"on": "uncertain", "to": "unsure"}, {"on": "failed", "to": "undone"}, {"on": "rejected", "to": "absent"}]
    ends = {name: {"final": "aborted"} for name in ("unsure", "undone", "absent")}
    states = {"calling": {"call": "horn", "timeout_s": 2, "transitions": away}, **ends}
    rig = Rig(states, robot=robot(services={"horn": horn}), connector=VanishedServers())
    assert rig.run().state == (("undone",) if repeat else ("unsure",))
    data = next(step.event.data for step in rig.book.steps if step.event.name in ("uncertain", "failed"))
    assert data == (
        {"why": "the server vanished; it may have been done"} if repeat else {"what": "call", "name": "horn"}
    )
