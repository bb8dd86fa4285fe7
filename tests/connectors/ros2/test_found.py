# SPDX-License-Identifier: Apache-2.0
"""Goals of a process that was killed, found by another: found running, found ended, or gone."""

from __future__ import annotations

import subprocess
import sys
import uuid
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.connector import Report
from rai_missions.connectors.contract import Inbox
from tests.connectors.ros2.peer_process import ABORT, DROPPED, FIBONACCI, RUN, SUCCEED, Peer

Open = Callable[..., Any]
SENDER = """
import sys, threading
from rai_missions.connectors.ros2 import open_connector
connector = open_connector({})
connector.start()
until, action, goal_id, order = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
done = threading.Event()
def report(one):
    if one.status == until:
        done.set()
connector.send_goal(action, "test_msgs/action/Fibonacci", {"order": order}, goal_id=goal_id, on_report=report)
done.wait(60)
print("sent", flush=True)
threading.Event().wait()
"""


def send_and_die(action: str, goal_id: str, order: int, until: str) -> None:
    """Send a goal from a process that is killed once the server has reported something of it."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", SENDER, until, action, goal_id, str(order)], stdout=subprocess.PIPE
    )
    assert process.stdout is not None
    with process.stdout:
        assert process.stdout.readline() == b"sent\n"
        process.kill()
        process.wait()


def found(connector: Any, action: str, goal_id: str) -> Inbox[Report]:
    received: Inbox[Report] = Inbox(30.0)
    connector.find_goal(action, FIBONACCI, goal_id=goal_id, on_report=received)
    return received


def test_a_goal_that_runs_is_found_and_its_end_is_reported(open_ros: Open, peer: Peer) -> None:
    goal_id, action = uuid.uuid4().hex, f"/{peer.name}/fibonacci"
    send_and_die(action, goal_id, RUN, "accepted")
    connector = open_ros()
    received = found(connector, action, goal_id)
    received.wait(lambda reported: [each.status for each in reported][:1] == ["accepted"], "it runs")
    connector.cancel_goal(goal_id)
    received.wait(lambda reported: reported[-1].status == "canceled", "it was canceled")


def test_a_goal_that_ended_unheard_is_found_with_its_result(open_ros: Open, peer: Peer) -> None:
    for order, end in ((SUCCEED, "succeeded"), (ABORT, "failed")):
        goal_id, action = uuid.uuid4().hex, f"/{peer.name}/fibonacci"
        send_and_die(action, goal_id, order, end)
        received = found(open_ros(), action, goal_id)
        received.wait(lambda reported, end=end: bool(reported) and reported[-1].status == end, f"it has {end}")


def test_a_goal_that_no_server_knows_is_lost(open_ros: Open, peer: Peer) -> None:
    received = found(open_ros(), f"/{peer.name}/fibonacci", uuid.uuid4().hex)
    received.wait(lambda reported: [each.status for each in reported] == ["lost"], "it is lost")
    received = found(open_ros(discovery_s=0.2), "/no_one/serves", uuid.uuid4().hex)
    received.wait(
        lambda reported: (
            [(each.status, each.why) for each in reported] == [("lost", "no server offers /no_one/serves")]
        ),
        "no server is there",
    )


def test_goals_that_their_server_knows_nothing_of_are_sent_again_and_no_one_asks_for_their_end(
    open_ros: Open, peer: Peer
) -> None:
    """A word on the way to end them would end those that are sent under the same ids."""
    connector, action = open_ros(), f"/{peer.name}/fibonacci"
    sent: dict[str, Inbox[Report]] = {uuid.uuid4().hex: Inbox(30.0) for _ in range(4)}

    def again(goal_id: str) -> Callable[[Report], None]:
        def lost(report: Report) -> None:
            assert report.status == "lost"
            connector.send_goal(action, FIBONACCI, {"order": RUN}, goal_id=goal_id, on_report=sent[goal_id])

        return lost

    for goal_id in sent:
        connector.find_goal(action, FIBONACCI, goal_id=goal_id, on_report=again(goal_id))
    for received in sent.values():
        received.wait(lambda report: "accepted" in [each.status for each in report], "it runs")
    for goal_id, received in sent.items():
        connector.cancel_goal(goal_id)
        received.wait(lambda report: report[-1].status == "canceled", "it was canceled")

    def ended(lines: list[Any]) -> list[str]:
        return sorted(line[1] for line in lines if line[0] == "end wanted" and line[1] in sent)

    reported = peer.lines.wait(lambda lines: len(ended(lines)) >= len(sent), "the server was asked to end each")
    assert ended(reported) == sorted(sent)


def dropped_id() -> str:
    """The id of a goal about which every second reply is dropped."""
    return DROPPED + uuid.uuid4().hex[len(DROPPED) :]


def test_a_goal_is_found_although_the_first_reply_about_it_is_dropped(open_ros: Open, peer: Peer) -> None:
    action, ended = f"/{peer.name}/fibonacci", dropped_id()
    received = found(open_ros(), action, dropped_id())
    received.wait(lambda reported: [each.status for each in reported] == ["lost"], "no server knows it")
    send_and_die(action, ended, SUCCEED, "succeeded")
    received = found(open_ros(), action, ended)
    received.wait(lambda reported: reported[-1].status == "succeeded", "it has succeeded")


def test_a_goal_whose_acceptance_is_dropped_is_accepted_once_its_server_executes_it(open_ros: Open, peer: Peer) -> None:
    connector, goal_id, received = open_ros(), dropped_id(), Inbox[Report](30.0)
    connector.send_goal(f"/{peer.name}/fibonacci", FIBONACCI, {"order": RUN}, goal_id=goal_id, on_report=received)
    received.wait(lambda reported: [each.status for each in reported][:1] == ["accepted"], "it runs")
    connector.cancel_goal(goal_id)
    received.wait(lambda reported: reported[-1].status == "canceled", "it was canceled")
    assert [each.status for each in received.all if each.status != "feedback"] == ["accepted", "canceled"]
    peer.lines.wait(lambda lines: ["dropped", goal_id] in lines, "the server's answer was dropped")
