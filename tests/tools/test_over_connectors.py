# SPDX-License-Identifier: Apache-2.0
"""The tools do on every connector what they state, in the modes that it has."""

from __future__ import annotations

import threading
from typing import Any, get_args, get_type_hints

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.contract import ENDS, Inbox, PatientServer
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import MissionError
from rai_missions.tools import Allowlist, Toolbox
from rai_missions.tools.goals import ToolGoal
from tests.tools.conftest import PATIENCE_S, RepeatingPublisher, ToolRig

STRING, TRIGGER, FIBONACCI = "std_msgs/msg/String", "std_srvs/srv/Trigger", "test_msgs/action/Fibonacci"
REPORTED = {
    "rejected": "rejected",
    "succeeded": "succeeded",
    "failed": "aborted",
    "canceled": "canceled",
    "lost": "lost",
}
MOVES = ("accepted", "rejected", "feedback", "succeeded", "failed", "canceled", "cancel_rejected", "cancel")
STATUSES = get_args(get_type_hints(Report)["status"])
KNOWN = {"accepted": "running", "feedback": "running", "cancel_rejected": "running", **REPORTED}


def needs(tried: ToolRig, mode: Any) -> None:
    if mode not in tried.connector.modes:
        pytest.skip(f"it carries no {mode}")


# ── Topics ──────────────────────────────────────────────────────────────────────────────────────────────────────


def test_the_newest_message_comes_with_its_age_and_its_field(tried: ToolRig) -> None:
    with RepeatingPublisher(tried.connector, "/tools/text", STRING, lambda: {"data": "x"}):
        look = tried.box().looking
        reported = look.receive_message("/tools/text", type_name=STRING, timeout_s=PATIENCE_S, max_age_s=20.0)
        part = look.receive_message("/tools/text", field="data", timeout_s=PATIENCE_S)
    assert (reported.data["message"]["data"], part.data["message"]) == ("x", "x")
    assert 0 <= reported.data["age_s"] <= 20
    assert part.data["type"] == STRING, "found out from the robot, or from who listened before"


def test_what_no_one_reports_is_unknown_and_not_an_error(tried: ToolRig) -> None:
    reported = tried.box().looking.receive_message("/tools/silent", type_name=STRING, timeout_s=0.05)
    assert reported.data["message"] is None
    assert reported.words.startswith("Nothing was received on /tools/silent within 0.05 s.")
    assert reported.words.endswith("What is so now is unknown.")


def test_what_is_published_is_received(tried: ToolRig) -> None:
    received: Inbox[Message] = Inbox(PATIENCE_S)
    close = tried.connector.subscribe("/tools/received", STRING, received)
    tried.box().acting.publish_message("/tools/received", {"data": "hello"}, timeout_s=PATIENCE_S)
    (message,) = received.wait(bool, "it was published")
    assert message.data["data"] == "hello"
    close()


def test_what_is_there_is_listed_with_its_type(tried: ToolRig) -> None:
    close = tried.connector.serve("/tools/listed", TRIGGER, lambda _: {"success": True, "message": ""})
    look, tick = tried.box().looking, threading.Event()
    rows: list[dict[str, Any]] = []
    for _ in range(int(PATIENCE_S / 0.05)):
        rows = look.list_services("listed").data["services"]
        if rows:
            break
        tick.wait(0.05)
    assert rows == [{"name": "/tools/listed", "type": TRIGGER, "write": True}]
    close()


# ── Services ────────────────────────────────────────────────────────────────────────────────────────────────────


def test_a_call_reports_what_was_answered(tried: ToolRig) -> None:
    close = tried.connector.serve("/tools/flash", TRIGGER, lambda _: {"success": True, "message": "done"})
    reported = tried.box().acting.call_service("/tools/flash", type_name=TRIGGER, timeout_s=PATIENCE_S)
    close()
    assert reported.words == "The service /tools/flash answered."
    assert (reported.data["done"], reported.data["reply"]) == (True, {"success": True, "message": "done"})


def test_a_call_that_was_refused_is_reported_as_not_done(tried: ToolRig) -> None:
    close = tried.connector.serve("/tools/horn", TRIGGER, lambda _: {"success": False, "message": "no horn"})
    reported = tried.box().acting.call_service("/tools/horn", type_name=TRIGGER, timeout_s=PATIENCE_S)
    close()
    assert "did NOT do it" in reported.words
    assert (reported.data["done"], reported.data["reply"]["message"]) == (False, "no horn")


def test_a_service_that_raises_has_failed(tried: ToolRig) -> None:
    def answer(_: Any) -> Any:
        raise ValueError("no lamp")

    close = tried.connector.serve("/tools/lamp", TRIGGER, answer)
    reported = tried.box().acting.call_service("/tools/lamp", type_name=TRIGGER, timeout_s=PATIENCE_S)
    close()
    assert reported.data["done"] is False
    assert "no lamp" in reported.text()


def test_a_service_that_is_not_there_has_done_nothing(tried: ToolRig) -> None:
    reported = tried.box().acting.call_service("/tools/no_one", type_name=TRIGGER, timeout_s=1.0)
    assert reported.data["outcome"] in ("unavailable", "timed_out")
    assert reported.data["done"] is False


def test_a_service_that_vanishes_with_a_request_may_have_done_it() -> None:
    class Vanishing(LocalConnector):
        def call(self, *_: Any, on_reply: Any, **__: Any) -> None:
            on_reply(Reply("unavailable", {}, "the server vanished", may_have_arrived=True))

    box = Toolbox(Vanishing(), Allowlist(write=("*",)), now=lambda: 0.0)
    reported = box.acting.call_service("/tools/gone", type_name=TRIGGER)
    assert "whether it did what was asked is unknown" in reported.words
    assert reported.data["done"] is False


# ── Actions ─────────────────────────────────────────────────────────────────────────────────────────────────────


class Server(PatientServer):
    """Does what the test reports, and takes a goal at once if that is the first thing reported."""

    def __init__(self, first: str = "") -> None:
        super().__init__()
        self._first = first

    def accept(self, goal_id: str, goal: Any, report: Any) -> None:
        super().accept(goal_id, goal, report)
        if self._first:
            self.send(goal_id, self._first)


def started(tried: ToolRig, box: Toolbox, server: Server, name: str) -> str:
    """A goal that the server has been asked for; its id."""
    reported = box.acting.start_action(
        name, {"order": 1}, type_name=FIBONACCI, timeout_s=0.0 if not server._first else PATIENCE_S
    )
    server.asked.wait(bool, "a goal was sent")
    return str(reported.data["goal_id"])


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(moves=st.lists(st.sampled_from(MOVES), max_size=7), number=st.integers(0, 10**9))
def test_the_outcome_that_is_reported_is_the_servers(tried: ToolRig, moves: list[str], number: int) -> None:
    needs(tried, "actions")
    server, box = Server(), tried.box()
    close = tried.connector.offer("/tools/law", FIBONACCI, server)
    try:
        goal_id = started(tried, box, server, "/tools/law")
        for move in (*moves, "succeeded"):
            if move == "cancel":
                tried.connector.cancel_goal(goal_id)
            else:
                server.send(goal_id, move)
        reported = box.acting.watch_action(goal_id, timeout_s=PATIENCE_S)
    finally:
        close()
    end = next(move for move in (*moves, "succeeded") if move in ENDS)
    # ROS has no word for a goal that is rejected after all, or canceled though no one asked: such a one is aborted.
    is_ros = not isinstance(tried.connector, LocalConnector)
    expected = {REPORTED[end]} | ({"aborted"} if is_ros and end in ("canceled", "rejected") else set())
    assert reported.data["is_over"]
    assert reported.data["state"] in expected, f"{reported.words} after {moves}"
    assert reported.words.count("SUCCEEDED") == (reported.data["state"] == "succeeded")


@pytest.mark.parametrize("end", ["succeeded", "failed", "canceled"])
def test_every_end_has_words_of_its_own(tried: ToolRig, end: str) -> None:
    needs(tried, "actions")
    server, box = Server("accepted"), tried.box()
    close = tried.connector.offer("/tools/ends", FIBONACCI, server)
    goal_id = started(tried, box, server, "/tools/ends")
    assert "still running" in box.acting.watch_action(goal_id).words
    if end == "canceled":
        box.acting.cancel_action(goal_id, timeout_s=0.0)
        server.asked.wait(lambda asked: ("cancel", goal_id) in asked, "the cancel came")
    server.send(goal_id, end, {"sequence": [1, 2]})
    reported = box.acting.watch_action(goal_id, timeout_s=PATIENCE_S)
    close()
    word = {"succeeded": "has SUCCEEDED", "failed": "was ABORTED", "canceled": "was CANCELED"}[end]
    assert word in reported.words
    assert ("SUCCEEDED" in reported.words) == (end == "succeeded")
    assert list(reported.data["result"].get("sequence", [1, 2])) == [1, 2]


def test_a_goal_that_is_rejected_never_ran(tried: ToolRig) -> None:
    needs(tried, "actions")
    server, box = Server("rejected"), tried.box()
    close = tried.connector.offer("/tools/rejects", FIBONACCI, server)
    reported = box.acting.start_action("/tools/rejects", {"order": 1}, type_name=FIBONACCI, timeout_s=PATIENCE_S)
    close()
    assert "was REJECTED by the server and never ran" in reported.words
    assert (reported.data["state"], reported.data["is_over"]) == ("rejected", True)


def test_feedback_is_reported_and_the_goal_is_not_over(tried: ToolRig) -> None:
    needs(tried, "actions")
    server, box = Server("accepted"), tried.box()
    close = tried.connector.offer("/tools/feeds", FIBONACCI, server)
    goal_id = started(tried, box, server, "/tools/feeds")
    server.send(goal_id, "feedback", {"sequence": [4]})
    tick = threading.Event()
    for _ in range(int(PATIENCE_S / 0.02)):
        if box.acting.watch_action(goal_id).data["feedbacks"]:
            break
        tick.wait(0.02)
    reported = box.acting.watch_action(goal_id)
    server.send(goal_id, "succeeded")
    box.acting.watch_action(goal_id, timeout_s=PATIENCE_S)
    close()
    assert (reported.data["state"], list(reported.data["feedback"]["sequence"])) == ("running", [4])
    assert '"newest feedback"' in reported.text()


def test_a_cancel_that_is_refused_and_one_that_is_not_confirmed_are_reported_as_such(tried: ToolRig) -> None:
    needs(tried, "actions")
    server, box = Server("accepted"), tried.box()
    close = tried.connector.offer("/tools/stubborn", FIBONACCI, server)
    goal_id = started(tried, box, server, "/tools/stubborn")
    waiting = box.acting.cancel_action(goal_id, timeout_s=0.0)
    assert "it was asked to cancel and has not confirmed" in waiting.words
    server.asked.wait(lambda asked: ("cancel", goal_id) in asked, "the cancel came")
    server.send(goal_id, "succeeded")
    reported = box.acting.cancel_action(goal_id, timeout_s=PATIENCE_S)
    close()
    assert "has SUCCEEDED" in reported.words, "what ended before the cancel was not canceled"


def test_stop_cancels_what_still_runs_and_names_what_no_one_confirmed(tried: ToolRig) -> None:
    needs(tried, "actions")
    server, box = Server("accepted"), tried.box()
    close = tried.connector.offer("/tools/stopped", FIBONACCI, server)
    first, second = (started(tried, box, server, "/tools/stopped") for _ in range(2))
    server.send(first, "succeeded")
    box.acting.watch_action(first, timeout_s=PATIENCE_S)
    left = box.stop(0.2)
    assert [(each.goal_id, each.state, each.cancel) for each in left] == [(second, "running", "asked")]
    server.asked.wait(lambda asked: ("cancel", second) in asked, "what still ran is canceled")
    assert ("cancel", first) not in server.asked.all
    with pytest.raises(MissionError, match="the tools were stopped"):
        box.acting.start_action("/tools/stopped", type_name=FIBONACCI)
    server.send(second, "canceled")
    close()


@given(st.lists(st.sampled_from(STATUSES)))
def test_after_its_end_nothing_changes_how_a_goal_is(status: list[Any]) -> None:
    """Even if a connector continued reporting."""
    goal = ToolGoal("g", "/a")
    for each in status:
        goal.receive(Report("other", each, {}))
        goal.receive(Report("g", each, {"n": each}))
    ends = [each for each in status if each in ENDS]
    known = [KNOWN[each] for each in status if each in KNOWN]
    expected = REPORTED[ends[0]] if ends else known[-1] if known else "sent"
    assert goal.state_now.state == expected
    assert goal.state_now.is_over == bool(ends)
    if ends:
        assert goal.state_now.result == {"n": ends[0]}


def test_a_goal_that_is_executing_after_its_end_is_reported_so_until_it_is_not() -> None:
    goal = ToolGoal("g", "/a")
    for status in ("accepted", "contested", "succeeded", "stray"):
        goal.receive(Report("g", status, {}))
    assert "YET a server is executing it" in goal.state_now.words()
    goal.receive(Report("g", "over", {}))
    assert goal.state_now.words().endswith("has SUCCEEDED; it is executing nowhere any more")
