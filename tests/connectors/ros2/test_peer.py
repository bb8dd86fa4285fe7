# SPDX-License-Identifier: Apache-2.0
"""A robot in another process, in plain rclpy: every window of a goal's life, and what becomes of calls and messages."""

from __future__ import annotations

import signal
import uuid
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.contract import ENDS, Inbox
from tests.connectors.ros2.peer_process import (
    ABORT,
    FIBONACCI,
    REJECT,
    RUN,
    SLOW_TO_ACCEPT,
    STUBBORN,
    SUCCEED,
    TRIGGER,
    Peer,
)

STRING = "std_msgs/msg/String"
Open = Callable[..., Any]


def start(connector: Any, peer: Peer, order: int) -> tuple[str, Inbox[Report]]:
    goal_id, reports = uuid.uuid4().hex, Inbox[Report]()
    connector.send_goal(f"/{peer.name}/fibonacci", FIBONACCI, {"order": order}, goal_id=goal_id, on_report=reports)
    return goal_id, reports


def end_of(reports: Inbox[Report]) -> list[str]:
    """What was reported of a goal up to its end, which is the last; a lost one may be over a moment later."""
    reported = reports.wait(lambda all_: any(report.status in ENDS for report in all_), "the goal has ended")
    statuses = [report.status for report in reported]
    return statuses[: next(place for place, status in enumerate(statuses, 1) if status in ENDS)]


def wait_for(reports: Inbox[Report], message: str) -> None:
    reports.wait(lambda all_: any(report.status == message for report in all_), f"it is {message}")


@pytest.mark.parametrize(("order", "end"), [(SUCCEED, "succeeded"), (ABORT, "failed")])
def test_a_goal_ends_as_its_server_reports_and_has_its_result(ours: Any, peer: Peer, order: int, end: str) -> None:
    goal_id, reports = start(ours, peer, order)
    reported = end_of(reports)
    assert (reported[0], reported[-1]) == ("accepted", end)
    assert reports.all[-1] == Report(goal_id, end, {"sequence": [0, 1, 1, 2]})  # type: ignore[arg-type]
    peer.lines.wait(lambda all_: ["runs", goal_id] in all_, "the server knows the goal by our id")


def test_a_goal_that_is_not_taken_is_rejected(ours: Any, peer: Peer) -> None:
    _, reports = start(ours, peer, REJECT)
    assert end_of(reports) == ["rejected"]
    assert "does not take the goal" in reports.all[0].why


def test_feedback_brings_its_fields(ours: Any, peer: Peer) -> None:
    goal_id, reports = start(ours, peer, RUN)
    wait_for(reports, "feedback")
    assert reports.all[1] == Report(goal_id, "feedback", {"sequence": [0]})
    ours.cancel_goal(goal_id)
    assert end_of(reports)[-1] == "canceled"


@pytest.mark.parametrize(
    ("order", "window"),
    [
        *((RUN, window) for window in ("at once", "asked", "accepted", "feedback")),
        *((SLOW_TO_ACCEPT, window) for window in ("at once", "asked")),  # once it is accepted it runs as the others do
    ],
)
def test_a_goal_left_in_any_window_runs_no_more(ours: Any, peer: Peer, order: int, window: str) -> None:
    goal_id, reports = start(ours, peer, order)
    if window == "asked":
        peer.lines.wait(lambda reported: reported[-1][0] in ("asked", "runs"), "the server has the goal")
    elif window != "at once":
        wait_for(reports, window)
    ours.cancel_goal(goal_id)
    reported = end_of(reports)
    assert reported[-1] == "canceled", reported
    if "accepted" in reported:
        peer.lines.wait(lambda all_: ["canceled", goal_id] in all_, "the server has stopped")
    else:
        assert ["runs", goal_id] not in peer.lines.all, "it was never sent"


def test_a_refused_cancel_is_reported_and_the_end_still_comes(ours: Any, peer: Peer) -> None:
    goal_id, reports = start(ours, peer, STUBBORN)
    wait_for(reports, "accepted")
    ours.cancel_goal(goal_id)
    wait_for(reports, "cancel_rejected")
    ours.cancel_goal(goal_id)
    reported = end_of(reports)
    assert reported[-1] == "succeeded"
    assert reported.count("cancel_rejected") == 2, "every cancel is sent and answered"


def test_a_cancel_after_the_end_asks_no_one(ours: Any, peer: Peer) -> None:
    goal_id, reports = start(ours, peer, SUCCEED)
    end_of(reports)
    ours.cancel_goal(goal_id)
    _, again = start(ours, peer, SUCCEED)
    end_of(again)
    assert ["cancel", goal_id] not in peer.lines.all
    assert [report.status for report in reports.all].count("succeeded") == 1


def test_stop_cancels_what_runs_and_what_is_not_accepted_yet(open_ros: Open, peer: Peer) -> None:
    connector = open_ros()
    running, reports = start(connector, peer, RUN)
    wait_for(reports, "accepted")
    asked, before = ["asked", SLOW_TO_ACCEPT], peer.lines.all.count(["asked", SLOW_TO_ACCEPT])
    slow, _ = start(connector, peer, SLOW_TO_ACCEPT)
    peer.lines.wait(lambda reported: reported.count(asked) > before, "the server thinks about it")
    connector.stop()
    results = len(reports.all)
    peer.lines.wait(
        lambda reported: ["canceled", running] in reported and ["canceled", slow] in reported, "neither goal runs on"
    )
    assert len(reports.all) == results, "after the stop nothing is reported"


def test_fifty_goals_at_once_are_all_pursued_and_all_canceled(ours: Any, peer: Peer) -> None:
    started = [start(ours, peer, SUCCEED) for _ in range(50)] + [start(ours, peer, REJECT) for _ in range(50)]
    assert [end_of(reports)[-1] for _, reports in started] == ["succeeded"] * 50 + ["rejected"] * 50
    slow = [start(ours, peer, RUN) for _ in range(4)]  # the peer has eight threads
    for _, reports in slow:
        wait_for(reports, "accepted")
    for goal_id, _ in slow:
        ours.cancel_goal(goal_id)
    assert [end_of(reports)[-1] for _, reports in slow] == ["canceled"] * 4


@pytest.mark.long
def test_goals_are_lost_when_their_server_is_killed(open_ros: Open, own_peer: Peer) -> None:
    connector = open_ros()
    _, running = start(connector, own_peer, RUN)
    wait_for(running, "accepted")
    _, asked = start(connector, own_peer, SLOW_TO_ACCEPT)
    own_peer.lines.wait(lambda reported: ["asked", SLOW_TO_ACCEPT] in reported, "the server thinks about it")
    own_peer.kill()
    assert end_of(running)[-1] == "lost"
    assert end_of(asked) == ["lost"]
    assert "is gone" in running.all[-1].why


@pytest.mark.long
def test_goals_are_lost_when_their_server_starts_again_and_new_ones_reach_it(open_ros: Open, own_peer: Peer) -> None:
    connector = open_ros()
    _, reports = start(connector, own_peer, RUN)
    wait_for(reports, "accepted")
    own_peer.kill()
    with Peer(own_peer.name) as reborn:
        assert end_of(reports)[-1] == "lost"
        goal_id, again = start(connector, reborn, SUCCEED)
        assert end_of(again)[-1] == "succeeded"
        reborn.lines.wait(lambda reported: ["runs", goal_id] in reported, "the new server runs the new goal")


@pytest.mark.long
def test_a_server_that_answers_after_it_was_given_up_changes_nothing_and_its_goal_is_canceled(
    open_ros: Open, own_peer: Peer
) -> None:
    connector = open_ros()
    goal_id, reports = start(connector, own_peer, SLOW_TO_ACCEPT)
    own_peer.lines.wait(lambda content: ["asked", SLOW_TO_ACCEPT] in content, "the server thinks about it")
    own_peer.signal(signal.SIGSTOP)
    assert end_of(reports) == ["lost"]
    own_peer.signal(signal.SIGCONT)
    own_peer.lines.wait(lambda content: ["canceled", goal_id] in content, "what is accepted too late is canceled")
    reported = reports.wait(lambda all_: len(all_) > 1, "it runs no more")
    assert [report.status for report in reported] == ["lost", "over"]


def test_a_call_brings_the_reply(ours: Any, peer: Peer) -> None:
    replies = Inbox[Reply]()
    ours.call("/peer/trigger", TRIGGER, {}, on_reply=replies, timeout_s=30.0)
    assert replies.wait(bool, "it is answered") == [Reply("succeeded", {"success": True, "message": "done"})]


def test_a_reply_that_reports_that_the_server_failed_is_a_failure(ours: Any, peer: Peer) -> None:
    replies = Inbox[Reply]()
    ours.call("/peer/set", "std_srvs/srv/SetBool", {"data": False}, on_reply=replies)
    (reply,) = replies.wait(bool, "it is answered")
    assert (reply.outcome, reply.why) == ("failed", "it is broken")


def test_a_call_that_is_not_answered_is_timed_out_once(ours: Any, peer: Peer) -> None:
    replies, found = Inbox[Reply](), Inbox[Reply]()
    ours.call(f"/{peer.name}/trigger", TRIGGER, {}, on_reply=found)
    found.wait(bool, "the server is found")
    ours.call(f"/{peer.name}/hang", TRIGGER, {}, on_reply=replies, timeout_s=0.5)
    (reply,) = replies.wait(bool, "it is given up")
    assert reply == Reply("timed_out", {}, "/peer/hang has not answered within 0.5 s")


@pytest.mark.long
def test_a_call_whose_server_dies_ends_without_any_timeout(open_ros: Open, own_peer: Peer) -> None:
    connector, replies = open_ros(), Inbox[Reply]()
    connector.call(f"/{own_peer.name}/hang", TRIGGER, {}, on_reply=replies)
    own_peer.lines.wait(lambda reported: ["hangs"] in reported, "the call has arrived")
    own_peer.kill()
    (reply,) = replies.wait(bool, "the server is gone")
    assert (reply.outcome, reply.why, reply.may_have_arrived) == (
        "unavailable",
        f"the server of /{own_peer.name}/hang vanished before it answered",
        True,
    )


def test_a_hundred_calls_at_once_of_an_ordinary_server_are_all_answered(ours: Any, peer: Peer) -> None:
    replies = Inbox[Reply]()
    for _ in range(100):
        ours.call("/peer/trigger", TRIGGER, {}, on_reply=replies)
    reported = replies.wait(lambda all_: len(all_) == 100, "an ordinary server keeps ten requests; none may be lost")
    assert {reply.outcome for reply in reported} == {"succeeded"}


def test_the_first_message_of_a_new_publisher_arrives(open_ros: Open, peer: Peer) -> None:
    word = uuid.uuid4().hex
    open_ros().publish("/peer/ear", STRING, {"data": word})
    peer.lines.wait(lambda reported: ["heard", word] in reported, "nothing is lost while the two find each other")


def test_who_subscribes_later_receives_what_was_latched(open_ros: Open, peer: Peer) -> None:
    received = Inbox[Message]()
    open_ros(qos={"/peer/latched": {"durability": "latched"}}).subscribe("/peer/latched", STRING, received)
    assert received.wait(bool, "it was kept")[0].data == {"data": "kept"}


def test_a_publisher_with_best_effort_is_received_unless_the_profile_insists(open_ros: Open, peer: Peer) -> None:
    received, insisting = Inbox[Message](), Inbox[Message]()
    open_ros(qos={"/peer/hasty": {"reliability": "reliable"}}).subscribe("/peer/hasty", STRING, insisting)
    open_ros().subscribe("/peer/hasty", STRING, received)
    received.wait(lambda all_: len(all_) > 3, "the reader fits its publisher")
    assert insisting.all == []
