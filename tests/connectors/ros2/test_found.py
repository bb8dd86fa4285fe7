# SPDX-License-Identifier: Apache-2.0
"""Goals of a process that was killed, found by another: found running, found ended, or gone."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import uuid
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from rai_missions.connectors.connector import Report
from rai_missions.connectors.contract import Inbox, PatientServer
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.profile import Robot
from rai_missions.runtime.goals import Goals, id_of_goal
from tests.connectors.ros2.peer_process import ABORT, DROPPED, FIBONACCI, RUN, SLOW_TO_ACCEPT, SUCCEED, Peer

Open = Callable[..., Any]
SENDER = """
import json, sys, threading
from rai_missions.connectors.ros2 import open_connector
connector = open_connector({})
connector.start()
for goal_id, order, until in json.loads(sys.argv[2]):
    done = threading.Event()
    def report(one, until=until, done=done):
        if one.status == until:
            done.set()
    connector.send_goal(sys.argv[1], "test_msgs/action/Fibonacci", {"order": order}, goal_id=goal_id, on_report=report)
    done.wait(60)
print("sent", flush=True)
threading.Event().wait()
"""


class Left(NamedTuple):
    """Goals of a process that was killed."""

    runs: str
    unwanted: str
    """It runs too, and the next process wants its end at once."""
    succeeded: str
    failed: str
    unheard: str
    """It has succeeded too; every second reply about it is dropped."""


@pytest.fixture(scope="module")
def left(peer_of_module: Peer) -> Left:
    """Sent by a process that was killed once their server had reported of each."""
    left = Left(*(uuid.uuid4().hex for _ in range(4)), dropped_id())
    ends = ("accepted", "accepted", "succeeded", "failed", "succeeded")
    send_and_die(peer_of_module, [*zip(left, (RUN, RUN, SUCCEED, ABORT, SUCCEED), ends, strict=True)])
    return left


def send_and_die(peer: Peer, goals: list[tuple[str, int, str]]) -> None:
    """Have a process send goals, each an id, an order and the report that is waited for, and be killed."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", SENDER, action_of(peer), json.dumps(goals)], stdout=subprocess.PIPE
    )
    assert process.stdout is not None
    with process.stdout:
        assert process.stdout.readline() == b"sent\n"
        process.kill()
        process.wait()


def action_of(peer: Peer) -> str:
    return f"/{peer.name}/fibonacci"


def dropped_id() -> str:
    """The id of a goal about which every second reply is dropped."""
    return DROPPED + uuid.uuid4().hex[len(DROPPED) :]


def found(connector: Any, action: str, goal_id: str) -> Inbox[Report]:
    received: Inbox[Report] = Inbox(30.0)
    connector.find_goal(action, FIBONACCI, goal_id=goal_id, on_report=received)
    return received


def test_a_goal_that_runs_is_found_and_its_end_is_reported(open_ros: Open, peer: Peer, left: Left) -> None:
    connector = open_ros()
    received = found(connector, action_of(peer), left.runs)
    received.wait(lambda reported: [each.status for each in reported][:1] == ["accepted"], "it runs")
    connector.cancel_goal(left.runs)
    received.wait(lambda reported: reported[-1].status == "canceled", "it was canceled")


def test_a_goal_that_is_unwanted_before_its_server_is_found_is_ended_there(
    open_ros: Open, peer: Peer, left: Left
) -> None:
    connector = open_ros()
    received = found(connector, action_of(peer), left.unwanted)
    connector.cancel_goal(left.unwanted)
    received.wait(lambda reported: bool(reported) and reported[-1].status == "canceled", "its server has ended it")
    assert ["end wanted", left.unwanted] in [list(line) for line in peer.lines.all]


@pytest.mark.parametrize("end", ["succeeded", "failed"])
def test_a_goal_that_ended_unheard_is_found_with_its_result(ours: Any, peer: Peer, left: Left, end: str) -> None:
    received = found(ours, action_of(peer), getattr(left, end))
    received.wait(lambda reported: bool(reported) and reported[-1].status == end, f"it has {end}")


def test_a_goal_that_no_server_knows_is_lost(open_ros: Open, ours: Any, peer: Peer) -> None:
    received = found(ours, action_of(peer), uuid.uuid4().hex)
    received.wait(lambda reported: [each.status for each in reported] == ["lost"], "it is lost")
    received = found(open_ros(discovery_s=0.2), "/no_one/serves", uuid.uuid4().hex)
    received.wait(
        lambda reported: (
            [(each.status, each.why) for each in reported] == [("lost", "no server offers /no_one/serves")]
        ),
        "no server is there",
    )


def test_a_goal_whose_server_was_away_when_it_was_looked_for_is_ended_before_the_next_is_sent(
    open_ros: Open, own_peer: Peer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long it was away: how long a lost goal is chased counts while a server is there."""
    goal_id, other, action = uuid.uuid4().hex, Inbox[Report](30.0), action_of(own_peer)
    send_and_die(own_peer, [(goal_id, RUN, "accepted")])
    own_peer.signal(signal.SIGSTOP)
    with monkeypatch.context() as patched:
        patched.setattr("rai_missions.connectors.ros2.goal_client.CHASE_S", 0.0)
        connector = open_ros(discovery_s=0.2)
        received = found(connector, action, goal_id)
        received.wait(lambda reported: [each.status for each in reported] == ["lost"], "no server is there")
    own_peer.signal(signal.SIGCONT)
    received.wait(lambda reported: reported[-1].status == "over", "its server is back, and has ended it")
    assert ["end wanted", goal_id] in [list(line) for line in own_peer.lines.all]
    connector.send_goal(action, FIBONACCI, {"order": SUCCEED}, goal_id=uuid.uuid4().hex, on_report=other)
    other.wait(lambda reported: reported[-1].status == "succeeded", "the next is pursued")


def test_goals_that_their_server_knows_nothing_of_are_sent_again_and_no_one_asks_for_their_end(
    ours: Any, peer: Peer
) -> None:
    """A word on the way to end them would end those that are sent under the same ids."""
    action = action_of(peer)
    sent: dict[str, Inbox[Report]] = {uuid.uuid4().hex: Inbox(30.0) for _ in range(4)}

    def again(goal_id: str) -> Callable[[Report], None]:
        def lost(report: Report) -> None:
            assert report.status == "lost"
            ours.send_goal(action, FIBONACCI, {"order": RUN}, goal_id=goal_id, on_report=sent[goal_id])

        return lost

    for goal_id in sent:
        ours.find_goal(action, FIBONACCI, goal_id=goal_id, on_report=again(goal_id))
    for received in sent.values():
        received.wait(lambda report: "accepted" in [each.status for each in report], "it runs")
    for goal_id, received in sent.items():
        ours.cancel_goal(goal_id)
        received.wait(lambda report: report[-1].status == "canceled", "it was canceled")

    def ended(lines: list[Any]) -> list[str]:
        return sorted(line[1] for line in lines if line[0] == "end wanted" and line[1] in sent)

    reported = peer.lines.wait(lambda lines: len(ended(lines)) >= len(sent), "the server was asked to end each")
    assert ended(reported) == sorted(sent)


def test_a_goal_that_its_server_has_yet_to_accept_is_found_by_being_sent_again(
    open_ros: Open, ours: Any, peer: Peer
) -> None:
    move = {"action": action_of(peer), "type": FIBONACCI}
    robot, events = Robot.model_validate({"name": "robot", "actions": {"move": move}}), Inbox[str](30.0)
    run = uuid.uuid4().hex
    goals = Goals(
        run, robot, ours, on_event=lambda kind, name, number, data: events(name), later=lambda seconds, do: None
    )
    effect, before = StartGoal(1, "moving", "move", {"order": SLOW_TO_ACCEPT}), Inbox[Report](30.0)
    goal_id = id_of_goal(run, effect.number, effect.owner)
    ours.find_goal(action_of(peer), FIBONACCI, goal_id=uuid.uuid4().hex, on_report=before)
    before.wait(bool, "this connector knows the server")
    open_ros().send_goal(action_of(peer), FIBONACCI, effect.goal, goal_id=goal_id, on_report=lambda report: None)
    peer.lines.wait(lambda lines: ["asked", SLOW_TO_ACCEPT] in [list(line) for line in lines], "it was asked")
    goals.resume(effect, accepted=False, on_doubt=lambda: events("doubt"))
    events.wait(bool, "its server has decided")
    goals.cancel(CancelGoal(effect.number, effect.action))
    events.wait(lambda reported: reported[-1] == "canceled", "it was canceled")
    assert [each for each in events.all if each != "feedback"] == ["accepted", "canceled"]


def test_a_goal_that_our_server_has_yet_to_accept_is_found_by_being_sent_again(open_ros: Open, ours: Any) -> None:
    server, goal_id, action = PatientServer(), uuid.uuid4().hex, f"/slow_{uuid.uuid4().hex[:6]}"
    open_ros().offer(action, FIBONACCI, server)
    open_ros().send_goal(action, FIBONACCI, {"order": 3}, goal_id=goal_id, on_report=lambda report: None)
    server.asked.wait(bool, "it was asked")
    found(ours, action, goal_id).wait(lambda reported: [each.status for each in reported] == ["lost"], "it is unknown")
    received, other = Inbox[Report](30.0), uuid.uuid4().hex
    ours.send_goal(action, FIBONACCI, {"order": 3}, goal_id=goal_id, on_report=received)
    ours.send_goal(action, FIBONACCI, {"order": 3}, goal_id=other, on_report=lambda report: None)
    server.asked.wait(lambda asked: ("accept", other) in asked, "what was sent before has come")
    server.send(goal_id, "accepted")
    received.wait(lambda reported: reported[0].status == "accepted", "it is executed")
    server.send(goal_id, "succeeded", {"sequence": [1]})
    received.wait(lambda reported: reported[-1].status == "succeeded", "it has succeeded")
    assert server.asked.all == [("accept", goal_id), ("accept", other)]


def test_a_goal_is_found_although_the_first_reply_about_it_is_dropped(ours: Any, peer: Peer, left: Left) -> None:
    received = found(ours, action_of(peer), dropped_id())
    received.wait(lambda reported: [each.status for each in reported] == ["lost"], "no server knows it")
    received = found(ours, action_of(peer), left.unheard)
    received.wait(lambda reported: reported[-1].status == "succeeded", "it has succeeded")


def test_a_goal_whose_acceptance_is_dropped_is_accepted_once_its_server_executes_it(ours: Any, peer: Peer) -> None:
    goal_id, received = dropped_id(), Inbox[Report](30.0)
    ours.send_goal(action_of(peer), FIBONACCI, {"order": RUN}, goal_id=goal_id, on_report=received)
    received.wait(lambda reported: [each.status for each in reported][:1] == ["accepted"], "it runs")
    ours.cancel_goal(goal_id)
    received.wait(lambda reported: reported[-1].status == "canceled", "it was canceled")
    assert [each.status for each in received.all if each.status != "feedback"] == ["accepted", "canceled"]
    peer.lines.wait(lambda lines: ["dropped", goal_id] in lines, "the server's answer was dropped")
