# SPDX-License-Identifier: Apache-2.0
"""A connector's life: options, starts and stops without a leak, stamps, and a process that has its own ROS affairs."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from rai_missions.connectors.connector import Message, Reply, Report
from rai_missions.connectors.contract import Inbox, PatientServer
from rai_missions.connectors.ros2 import open_connector
from rai_missions.errors import ConnectorError, UsageError

STRING, TRIGGER, FIBONACCI = "std_msgs/msg/String", "std_srvs/srv/Trigger", "test_msgs/action/Fibonacci"
Open = Callable[..., Any]
ROOT = Path(__file__).parents[3]


class Willing(PatientServer):
    """It accepts every goal, and never ends one."""

    def accept(self, goal_id: str, goal: Any, report: Callable[[Report], None]) -> None:
        report(Report(goal_id, "accepted", {}))


def program(text: str) -> subprocess.CompletedProcess[str]:
    """A user's program, run to its end."""
    return subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(text)],
        capture_output=True,
        text=True,
        timeout=180,
        cwd=ROOT,
        check=False,
    )


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"nod": "x"}, "connector: no option 'nod'; did you mean 'node'?"),
        ({"node": 3}, "connector/node: 3 is no str"),
        ({"sim_time": 1}, "connector/sim_time: 1 is no bool"),
        ({"domain_id": 900}, "connector/domain_id: 900 is no ROS domain; one goes from 0 to 232"),
        ({"discovery_s": 0}, "connector/discovery_s: 0 is no time to be found in; give seconds above 0"),
        ({"arguments": "-r"}, "connector/arguments: '-r' is no list of texts, such as [\"-r\", \"/a:=/b\"]"),
        ({"qos": []}, "connector/qos: [] is given where an object belongs"),
        ({"qos": {"/t": {"depth": 0}}},
         "connector/qos//t/depth: 0 is no number of messages; give 1 (the newest wins) to 10000"),
        ({"qos": {"/t": {"durability": "latch"}}},
         "connector/qos//t/durability: 'latch' is not known; did you mean 'latched'?"),
        ({"qos": {"/t": {"history": 3}}},
         "connector/qos//t: no option 'history'; there is: depth, durability, reliability"),
    ],
)  # fmt: skip
def test_an_option_that_is_not_understood_is_reported_with_what_is(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(UsageError) as caught:
        open_connector(options)
    assert str(caught.value) == sentence


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(
    "options",
    [{"node": "not a name"}, {"namespace": "1/2"}, {"arguments": ["-r", "nonsense:=:="]}, {"arguments": ["-x"]}],
)
def test_what_ros_does_not_take_is_refused_at_the_start(options: dict[str, Any]) -> None:
    connector = open_connector(options)
    with pytest.raises(UsageError, match=r"^connector: ROS "):
        connector.start()
    connector.stop()


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("is_simulated", [False, True])
@pytest.mark.parametrize("given", ["true", "false", "3", "'true'", "[true]"])
def test_the_time_of_a_launch_file_is_that_of_the_profile_or_refused(given: str, is_simulated: bool) -> None:
    connector = open_connector({"sim_time": is_simulated, "arguments": ["-p", f"use_sim_time:={given}"]})
    if is_simulated or given == "false":  # what the profile gives comes before the command line
        connector.start()
        assert connector._session.runtime.node.get_parameter("use_sim_time").value is is_simulated
    else:
        with pytest.raises(UsageError, match=r"^parameter 'use_sim_time': .* add \"sim_time\": true to its connector"):
            connector.start()
        assert not connector.running
    connector.stop()


def test_the_profile_names_the_node_and_renames_topics(open_ros: Open) -> None:
    received = Inbox[Message]()
    other = open_ros(node="ears", namespace="/robot", arguments=["-r", "/a:=/b"], parameters={"speed": 1.5})
    other.subscribe("/a", STRING, received)
    open_ros().publish("/b", STRING, {"data": "x"})
    assert received.wait(bool, "the topic was renamed")[0].topic == "/a"
    node = other._session.runtime.node
    assert node.get_fully_qualified_name() == "/robot/ears"
    assert node.get_parameter("speed").value == 1.5


def check_lives(times: int) -> None:
    connector = open_connector({})

    def live() -> None:
        connector.start()
        replies, reports = Inbox[Reply](), Inbox[Report]()
        connector.subscribe("/life", STRING, lambda _message: None)
        connector.publish("/life", STRING, {"data": "x"})
        connector.serve("/life/call", TRIGGER, lambda _request: {})
        connector.call("/life/no_one", TRIGGER, {}, on_reply=replies)
        connector.offer("/life/do", FIBONACCI, Willing())
        connector.send_goal("/life/do", FIBONACCI, {}, goal_id="g", on_report=reports)
        connector.stop()
        assert [reply.outcome for reply in replies.all] == ["unavailable"], "each call is answered once"

    def held() -> tuple[int, int, int]:
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return threading.active_count(), len(os.listdir("/proc/self/fd")), pages * os.sysconf("SC_PAGE_SIZE") // 2**20

    for _ in range(times // 10):
        live()
    before = held()
    for _ in range(times):
        live()
    until, tick = time.monotonic() + 30.0, threading.Event()
    while (after := held())[0] > before[0] and time.monotonic() < until:
        tick.wait(0.05)  # on a busy machine a thread that is to end has yet to do so
    assert after[0] <= before[0], "no thread is left"  # one of an earlier test may have ended meanwhile
    assert after[1] <= before[1] + 2, "no file is left open"
    assert after[2] <= before[2] + max(20, times // 20), f"{after[2] - before[2]} MiB are left"


@pytest.mark.long
@pytest.mark.usefixtures("alone")
def test_thirty_lives_leave_nothing_behind() -> None:
    check_lives(30)


@pytest.mark.drill
@pytest.mark.usefixtures("alone")
def test_a_thousand_lives_leave_nothing_behind() -> None:
    check_lives(1000)


@pytest.mark.usefixtures("alone")
def test_stop_cancels_a_hundred_goals_that_were_sent_at_once(open_ros: Open) -> None:
    connector, server = open_ros(), Willing()
    connector.offer("/crowd", FIBONACCI, server)
    reports = Inbox[Report]()
    for index in range(100):
        connector.send_goal("/crowd", FIBONACCI, {"order": index}, goal_id=f"g{index}", on_report=reports)
    reports.wait(lambda all_: len(all_) == 100, "every goal is accepted")
    connector.stop()
    assert {goal_id for asked, goal_id in server.asked.all if asked == "cancel"} == {f"g{i}" for i in range(100)}


@pytest.mark.usefixtures("alone")
def test_a_stop_from_a_callback_ends_it_without_a_deadlock(open_ros: Open) -> None:
    connector, done = open_ros(), threading.Event()

    def on_message(_message: Message) -> None:
        connector.stop()
        done.set()

    connector.subscribe("/stop", STRING, on_message)
    thread = connector._session.runtime._thread
    connector.publish("/stop", STRING, {"data": "now"})
    assert done.wait(30)
    thread.join(30)
    assert not thread.is_alive()
    connector.start()
    assert connector._session is not None, "it can be started again"


@pytest.mark.usefixtures("alone")
def test_a_stop_from_a_callback_ends_the_calls_that_wait(open_ros: Open) -> None:
    connector, replies = open_ros(), Inbox[Reply]()
    connector.serve("/slow", TRIGGER, lambda _: connector.stop() or Future())
    connector.call("/slow", TRIGGER, {}, on_reply=replies)
    (reply,) = replies.wait(bool, "the call ends with the connector")
    assert (reply.outcome, reply.why) == ("unavailable", "the connector was stopped")


@pytest.mark.usefixtures("alone")
def test_a_goal_and_a_call_end_where_ros_makes_no_client_for_them(open_ros: Open) -> None:
    """Names that are too long for DDS only below the node's namespace are known by rclpy alone."""
    connector, name = open_ros(namespace="/" + "n" * 160), "a" * 90
    reports, replies, surveys = Inbox[Report](), Inbox[Reply](), Inbox[str]()
    connector.send_goal(name, FIBONACCI, {"order": 1}, goal_id="g", on_report=reports)
    connector.find_goal(name, FIBONACCI, goal_id="found", on_report=reports)
    connector.call(name, TRIGGER, {}, on_reply=replies)
    connector.survey(name, FIBONACCI, within_s=1.0, on_result=surveys)
    ends = reports.wait(lambda all_: len(all_) == 2, "each goal has an end")
    assert {each.goal_id: each.status for each in ends} == {"g": "rejected", "found": "lost"}
    assert [each.outcome for each in replies.wait(bool, "the call is answered")] == ["failed"]
    assert surveys.wait(bool, "the survey ends") == [""]


@pytest.mark.usefixtures("alone")
def test_a_callback_that_raises_stops_no_other(open_ros: Open, caplog: pytest.LogCaptureFixture) -> None:
    connector, received = open_ros(), Inbox[Message]()

    def fail(_message: Message) -> None:
        raise RuntimeError("broken ear")

    connector.subscribe("/ears", STRING, fail)
    connector.subscribe("/ears", STRING, received)
    for text in ("one", "two"):
        connector.publish("/ears", STRING, {"data": text})
    received.wait(lambda all_: len(all_) == 2, "the other ear receives everything")
    assert "broken ear" in caplog.text


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize(("age_s", "at"), [(0.0, 50.0), (2.0, 48.0), (1e6, 50.0 - 1e6), (-30.0, 50.0)])
def test_a_header_stamp_is_reported_on_the_runs_clock(open_ros: Open, age_s: float, at: float) -> None:
    connector, received = open_ros(now=lambda: 50.0), Inbox[Message]()
    connector.subscribe("/stamped", "std_msgs/msg/Header", received)
    begin = time.time()
    connector.publish("/stamped", "std_msgs/msg/Header", {"stamp": begin - age_s})
    message = received.wait(bool, "it was published")[0]
    took_s = time.time() - begin if age_s >= 0 else 0.0  # what is under way grows older
    assert at - took_s - 1e-3 <= message.at <= at + 1e-3


@pytest.mark.usefixtures("alone")
def test_a_message_without_a_stamp_is_from_now(open_ros: Open) -> None:
    connector, received = open_ros(now=lambda: 50.0), Inbox[Message]()
    connector.subscribe("/stamped", "std_msgs/msg/Header", received)
    connector.publish("/stamped", "std_msgs/msg/Header", {"frame_id": "map"})
    assert received.wait(bool, "it was published")[0].at == 50.0


@pytest.mark.usefixtures("alone")
def test_simulated_time_is_what_the_clock_reports(open_ros: Open) -> None:
    connector, received = open_ros(sim_time=True), Inbox[Message]()
    connector.subscribe("/any", STRING, received)
    clock = Inbox[Message]()
    connector.subscribe("/clock", "rosgraph_msgs/msg/Clock", clock)
    connector.publish("/clock", "rosgraph_msgs/msg/Clock", {"clock": 77.5})
    clock.wait(bool, "time has come")
    deadline = time.monotonic() + 30
    while not received.all or received.all[-1].at != 77.5:
        assert time.monotonic() < deadline, received.all
        count = len(received.all)
        connector.publish("/any", STRING, {"data": "x"})
        received.wait(lambda all_: len(all_) > count, "it was published")  # noqa: B023 - asked at once


@pytest.mark.usefixtures("alone")
def test_what_is_wrong_is_reported_as_the_contract_states(open_ros: Open) -> None:
    connector, replies, reports = open_ros(), Inbox[Reply](), Inbox[Report]()
    connector.subscribe("/t", STRING, lambda _message: None)
    connector.serve("/s", TRIGGER, lambda _request: {})
    connector.offer("/a", FIBONACCI, Willing())
    with pytest.raises(ConnectorError, match="/t is a std_msgs/msg/String, not a std_msgs/msg/Int32"):
        connector.publish("/t", "std_msgs/msg/Int32", {"data": 1})
    with pytest.raises(ConnectorError, match="no message type 'Strin'"):
        connector.publish("/u", "std_msgs/msg/Strin", {"data": "x"})
    connector.publish("/u", STRING, {"data": "x"})
    with pytest.raises(UsageError, match="/s is served already"):
        connector.serve("/s", TRIGGER, lambda _request: {})
    with pytest.raises(UsageError, match="/a is served already"):
        connector.offer("/a", FIBONACCI, PatientServer())
    connector.call("/s", TRIGGER, {"x": 1}, on_reply=replies)
    assert replies.all == [Reply("failed", {}, "/s/x: std_srvs/srv/Trigger_Request has no such field")]
    connector.send_goal("/a", FIBONACCI, {"order": "x"}, goal_id="g", on_report=reports)
    assert reports.all == [Report("g", "rejected", {}, "/a/order: 'x' is no whole number, as int32 asks")]
    connector.send_goal("/a", FIBONACCI, {"order": 1}, goal_id="g", on_report=reports)
    with pytest.raises(UsageError, match="goal 'g' is still running"):
        connector.send_goal("/a", FIBONACCI, {"order": 1}, goal_id="g", on_report=reports)


def test_what_is_not_started_reports_it() -> None:
    connector, replies, reports = open_connector({}), Inbox[Reply](), Inbox[Report]()
    connector.publish("/t", STRING, {"data": "x"})
    connector.cancel_goal("g")
    connector.call("/s", TRIGGER, {}, on_reply=replies)
    connector.send_goal("/a", FIBONACCI, {}, goal_id="g", on_report=reports)
    assert [reply.outcome for reply in replies.all] == ["unavailable"]
    assert [report.status for report in reports.all] == ["rejected"]
    with pytest.raises(UsageError, match="not started"):
        connector.subscribe("/t", STRING, lambda _message: None)


def test_importing_the_room_loads_no_ros() -> None:
    text = "import rai_missions, rai_missions.connectors.ros2, sys; assert 'rclpy' not in sys.modules"
    assert program(text).returncode == 0


def test_without_rclpy_one_sentence_states_how_to_get_it() -> None:
    done = program(
        """
        import sys; sys.modules["rclpy"] = None
        from rai_missions.connectors.ros2 import open_connector
        try:
            open_connector({})
        except Exception as error:
            print(type(error).__name__, error)
        """
    )
    assert done.stdout.startswith("UsageError a connector of kind 'ros2' needs rclpy, which does not load")
    assert "[ros]'" in done.stdout and "source /opt/ros/" in done.stdout


def test_a_process_that_forgets_to_stop_ends_as_usual_and_leaves_no_goal(peer: Any) -> None:
    done = program(
        f"""
        import threading
        from rai_missions.connectors.ros2 import open_connector
        connector, running = open_connector({{}}), threading.Event()
        connector.start()
        connector.send_goal("/{peer.name}/fibonacci", "{FIBONACCI}", {{"order": 1}}, goal_id="{"ab" * 16}",
                            on_report=lambda report: report.status == "accepted" and running.set())
        assert running.wait(30)
        """
    )
    assert (done.returncode, done.stderr) == (0, "")
    peer.lines.wait(lambda reported: ["canceled", "ab" * 16] in reported, "its goal is canceled at the exit")


def test_it_lives_next_to_a_program_that_spins_rclpy_itself(peer: Any) -> None:
    done = program(
        f"""
        import threading, time, rclpy
        from rclpy.executors import SingleThreadedExecutor
        from std_msgs.msg import String
        from rai_missions.connectors.contract import Inbox
        from rai_missions.connectors.ros2 import open_connector
        rclpy.init()
        node, executor = rclpy.create_node("users_own"), SingleThreadedExecutor()
        executor.add_node(node)
        echo = node.create_publisher(String, "/echo", 10)
        node.create_subscription(String, "/speech", echo.publish, 10)
        thread = threading.Thread(target=executor.spin, daemon=True); thread.start()
        for _ in range(3):
            connector, received, replies = open_connector({{}}), Inbox(30.0), Inbox(30.0)
            connector.start()
            connector.subscribe("/echo", "{STRING}", received)
            while not node.count_subscribers("/echo"):
                time.sleep(0.01)
            connector.publish("/speech", "{STRING}", {{"data": "x"}})
            connector.call("/{peer.name}/trigger", "{TRIGGER}", {{}}, on_reply=replies)
            assert replies.wait(bool, "answered")[0].outcome == "succeeded"
            received.wait(bool, "the user's node receives and speaks")
            connector.stop()
        assert rclpy.ok() and thread.is_alive()
        executor.shutdown(); thread.join(); node.destroy_node(); rclpy.shutdown()
        """
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_an_interrupt_that_shuts_ros_down_loses_goals_and_answers_calls(peer: Any) -> None:
    done = program(
        f"""
        import os, signal, rclpy
        from rai_missions.connectors.contract import Inbox
        from rai_missions.connectors.ros2 import open_connector
        rclpy.init()
        connector, reports, replies, late = open_connector({{}}), Inbox(30.0), Inbox(30.0), Inbox(30.0)
        connector.start()
        connector.send_goal("/{peer.name}/fibonacci", "{FIBONACCI}", {{"order": 1}}, goal_id="g", on_report=reports)
        reports.wait(bool, "accepted")
        connector.call("/{peer.name}/hang", "{TRIGGER}", {{}}, on_reply=replies)
        try:
            os.kill(os.getpid(), signal.SIGINT)
            replies.wait(bool, "answered")
        except KeyboardInterrupt:
            replies.wait(bool, "answered")
        reports.wait(lambda all_: all_[-1].status == "lost", "lost")
        connector.call("/{peer.name}/trigger", "{TRIGGER}", {{}}, on_reply=late)
        print(replies.all[0].outcome, late.wait(bool, "answered")[0].outcome)
        connector.stop()
        """
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "unavailable unavailable\n", "")


@pytest.mark.long
def test_a_call_whose_client_is_made_while_ros_is_shut_down_is_unavailable(peer: Any) -> None:
    done = program(
        f"""
        from rclpy.node import Node
        from rai_missions.connectors.contract import Inbox
        from rai_missions.connectors.ros2 import open_connector
        create = Node.create_client
        def shut(node, *args, **options):
            node.context.try_shutdown()
            return create(node, *args, **options)
        Node.create_client = shut
        connector, replies = open_connector({{}}), Inbox(30.0)
        connector.start()
        connector.call("/{peer.name}/trigger", "{TRIGGER}", {{}}, on_reply=replies)
        print(replies.wait(bool, "answered")[0].outcome)
        connector.stop()
        """
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "unavailable\n", "")
