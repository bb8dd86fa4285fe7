# SPDX-License-Identifier: Apache-2.0
"""Two servers on one action's name: refused where both live, found out where the second comes later, ended at both.

Rule: the servers are ordinary ones of a node each; what is executing is read from them alone.
"""

from __future__ import annotations

import signal
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.connector import Reply, Report
from rai_missions.connectors.contract import Inbox
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner
from tests.connectors.ros2.peer_process import FIBONACCI, Peer
from tests.connectors.ros2.scripted_server import PROGRAM, Script
from tests.rigs.runs import Plan, PlannedServer

Open = Callable[..., Any]
PATIENCE_S = 30.0
TRIGGER = "std_srvs/srv/Trigger"


class RobotServer(PlannedServer):
    """A planned server in real time; an end of a goal that it is not executing is reported to nothing."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(self._start_timer, time.monotonic, plan)
        self.plan, self.seen, self._timers = plan, Inbox[str](PATIENCE_S), list[threading.Timer]()
        self.die: Callable[[], None] = lambda: None

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        self.seen(goal_id)
        if self.plan.dies is not None:
            self._start_timer(self.plan.dies, lambda: self.die())
        super().accept(goal_id, goal, report)

    def end(self, goal_id: str, how: str) -> None:
        if how == "rejected" or goal_id in self.executing:
            super().end(goal_id, how)

    def close(self) -> None:
        for timer in self._timers:
            timer.cancel()

    def _start_timer(self, seconds: float, do: Callable[[], object]) -> None:
        if seconds == 0.0:
            do()
            return
        self._timers.append(threading.Timer(seconds, do))
        self._timers[-1].daemon = True
        self._timers[-1].start()


class Rig:
    """An action's name, and the servers that come to serve it."""

    def __init__(self, open_ros: Open) -> None:
        self._open, self.name = open_ros, f"/rivals_{uuid.uuid4().hex[:8]}"
        self.servers: list[RobotServer] = []
        self.nodes: list[Any] = []

    def serve(self, plan: Plan) -> RobotServer:
        """One more server, on a node of its own."""
        server, node = RobotServer(plan), self._open()
        node.offer(self.name, FIBONACCI, server)
        server.die = lambda: node._session.runtime.close()  # as a process that is killed: nothing is aborted first
        self.servers.append(server)
        self.nodes.append(node)
        return server

    def wait_for(self, connector: Any, count: int) -> None:
        """Wait until a connector's graph has so many servers."""
        until, tick = time.monotonic() + PATIENCE_S, threading.Event()
        while connector.offered("actions").get(self.name, 0) != count:
            assert time.monotonic() < until, f"there are not {count} servers"
            tick.wait(0.02)

    def wait_until_two_answer(self, connector: Any) -> None:
        """Wait until two servers receive a connector's requests; a server is on the graph before that."""
        until, why = time.monotonic() + PATIENCE_S, ""
        while not why.startswith("more than one server answers"):
            assert time.monotonic() < until, f"two servers do not answer: {why}"
            _, reports = self.send(connector, Script(accept="never").order(0))
            why = until_reported(reports, "rejected")[-1].why

    def send(self, connector: Any, order: int = 1) -> tuple[str, Inbox[Report]]:
        goal_id, reports = uuid.uuid4().hex, Inbox[Report](PATIENCE_S)
        connector.send_goal(self.name, FIBONACCI, {"order": order}, goal_id=goal_id, on_report=reports)
        return goal_id, reports

    def executing(self) -> set[str]:
        return {goal_id for server in self.servers for goal_id in server.executing}

    def close(self) -> None:
        for server in self.servers:
            server.close()
        for node in self.nodes:
            with suppress(Exception):
                node.stop()


@pytest.fixture
def rig(open_ros: Open) -> Iterator[Rig]:
    made = Rig(open_ros)
    yield made
    made.close()


def statuses(reports: Inbox[Report]) -> list[str]:
    return [each.status for each in reports.all]


def until_reported(reports: Inbox[Report], *words: str) -> list[Report]:
    return reports.wait(lambda all_: any(each.status in words for each in all_), f"one of {words}")


def test_a_goal_for_two_servers_is_rejected_and_reaches_neither(ours: Any, rig: Rig) -> None:
    servers = [rig.serve(Plan()), rig.serve(Plan())]
    rig.wait_for(ours, 2)
    _, reports = rig.send(ours)
    (report,) = until_reported(reports, "rejected")
    assert report.why.startswith(f"more than one server answers for {rig.name} (/rai_missions_")
    assert report.why.endswith("); stop all but one")
    assert [server.seen.all for server in servers] == [[], []]


def test_a_server_that_is_on_the_graph_and_does_not_answer_is_no_second_one_and_ends_the_goal_once_it_does(
    ours: Any, rig: Rig
) -> None:
    script = Script(end="runs on")
    with Peer(rig.name[1:], PROGRAM) as frozen, Peer(rig.name[1:], PROGRAM) as living:
        rig.name += "/move"
        rig.wait_for(ours, 2)
        rig.wait_until_two_answer(ours)
        frozen.signal(signal.SIGSTOP)
        goal_id, reports = rig.send(ours, script.order(1))
        until_reported(reports, "accepted")
        ours.cancel_goal(goal_id)
        until_reported(reports, "canceled")
        living.lines.wait(lambda reported: ["over", 1, "canceled"] in reported, "the goal is over")
        frozen.signal(signal.SIGCONT)
        frozen.lines.wait(lambda reported: ["over", 1, "canceled"] in reported, "what it took late is canceled")


def test_a_second_server_that_comes_later_is_reported_and_a_cancel_ends_the_goal_at_both(ours: Any, rig: Rig) -> None:
    first = rig.serve(Plan())
    rig.wait_for(ours, 1)
    goal_id, reports = rig.send(ours)
    until_reported(reports, "accepted")
    rig.serve(Plan())
    until_reported(reports, "contested")
    ours.cancel_goal(goal_id)
    until_reported(reports, "canceled")
    assert statuses(reports) == ["accepted", "contested", "canceled"]
    assert first.executing == set()


@pytest.mark.long
@pytest.mark.parametrize("what", ["service", "goal"])
def test_a_second_server_of_which_half_is_known_yet_takes_no_server_away(
    open_ros: Open, rig: Rig, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While another server is on the graph and not matched yet, ROS reports that none of its name is ready."""
    first, connector = rig.serve(Plan(ends=1.5)), open_ros()
    rig.wait_for(connector, 1)
    if what == "goal":
        _, reports = rig.send(connector)
        until_reported(reports, "accepted")
        monkeypatch.setattr("rclpy.action.ActionClient.server_is_ready", lambda _: False)
        assert until_reported(reports, "succeeded", "lost")[-1].status == "succeeded"
        assert first.executing == set()
        return
    asked, free, replies = Inbox[bool](PATIENCE_S), threading.Event(), Inbox[Reply](PATIENCE_S)

    def answer(_request: Any) -> Mapping[str, Any]:
        asked(True)
        return {"success": free.wait(PATIENCE_S), "message": ""}

    rig.nodes[0].serve(f"{rig.name}/service", TRIGGER, answer)
    connector.call(f"{rig.name}/service", TRIGGER, {}, on_reply=replies)
    asked.wait(bool, "it is asked")
    monkeypatch.setattr("rclpy.client.Client.service_is_ready", lambda _: False)
    threading.Timer(1.5, free.set).start()
    (reply,) = replies.wait(bool, "an answer")
    assert reply.outcome == "succeeded", reply


@pytest.mark.long
@pytest.mark.parametrize(
    ("plans", "end"),
    [
        ((Plan(rejects=True), Plan(accepts=0.3)), "canceled"),
        ((Plan(), Plan(accepts=0.2, cancels=1.0)), "canceled"),
        ((Plan(ends=0.1), Plan(ends=1.5)), "succeeded"),
        ((Plan(ends=0.1), Plan(ends=0.8, end="failed")), "failed"),
        ((Plan(rejects=True), Plan(rejects=True)), "rejected"),
    ],
)
def test_a_goal_that_two_servers_have_ends_when_neither_is_executing_it(
    ours: Any, rig: Rig, plans: tuple[Plan, Plan], end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second was not yet on the graph when the goal was sent."""
    monkeypatch.setattr(
        "rai_missions.connectors.ros2.goal_client.GoalClient.survey", lambda _, reported, within_s=0.0: reported("")
    )
    for plan in plans:
        rig.serve(plan)
    rig.wait_for(ours, 2)
    goal_id, reports = rig.send(ours)
    for server in rig.servers:
        server.seen.wait(bool, "it has the goal")
    if end == "canceled":
        ours.cancel_goal(goal_id)
    reported = until_reported(reports, "succeeded", "failed", "canceled", "rejected")
    assert reported[-1].status == end, reported
    assert rig.executing() == set()


# -- whole runs ---------------------------------------------------------------------------------------------------


def mission() -> Mission:
    ends = ["succeeded", "failed", "rejected", "canceled", "timed_out", "unverified"]
    moving = {"action": "move", "goal": {"order": 1}, "timeout_s": 1.5, "cancel_s": 1.0,
              "transitions": [{"on": ends, "to": "done"}]}  # fmt: skip
    return Mission.model_validate(
        {"format": 1, "name": "rivals", "version": "1.0.0", "initial": "moving", "ready_s": 1.0,
         "states": {"moving": moving, "done": {"final": "failed"}}}
    )  # fmt: skip


def run(rig: Rig, connector: Any) -> Result:
    robot = Robot.model_validate({"name": "rivals", "actions": {"move": {"action": rig.name, "type": FIBONACCI}}})
    return Runner(mission(), robot=robot, connector=connector).run()


def test_a_run_is_refused_while_two_servers_live(ours: Any, rig: Rig) -> None:
    servers = [rig.serve(Plan()), rig.serve(Plan(rejects=True))]
    rig.wait_for(ours, 2)
    with pytest.raises(UsageError, match=f"more than one server answers for {rig.name}"):
        run(rig, ours)
    assert [server.seen.all for server in servers] == [[], []]


@pytest.mark.long
@pytest.mark.parametrize(
    ("plan", "reasons"),
    [
        (Plan(), []),
        (Plan(refuses=True), ["refused"]),
        (Plan(cancels=None), ["orphaned"]),
        (Plan(accepts=None), ["orphaned"]),
        (Plan(dies=0.3), ["lost"]),
    ],
)
def test_a_run_names_what_may_still_be_executing(ours: Any, rig: Rig, plan: Plan, reasons: list[str]) -> None:
    rig.serve(plan)
    result = run(rig, ours)
    assert [goal.reason for goal in result.open_goals] == reasons
    assert bool(rig.executing()) is (bool(reasons) and plan.accepts is not None)


SECONDS = st.sampled_from([0.0, 0.0, 0.3, 1.0])
PLANS = st.builds(
    Plan,
    accepts=st.sampled_from([0.0, 0.0, 0.3, 2.0, None]),
    rejects=st.sampled_from([False, False, True]),
    ends=st.sampled_from([None, 0.1, 0.8, 2.0]),
    end=st.sampled_from(["succeeded", "failed"]),
    cancels=st.sampled_from([0.0, 0.3, 2.0, None]),
    refuses=st.sampled_from([False, False, True]),
    dies=st.sampled_from([None, None, 0.2, 1.2]),
)
quick = settings(
    max_examples=3, deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.explicit, Phase.generate]
)


def hold(open_ros: Open, connector: Any, first: Plan, second: Plan | None, after_s: float) -> None:
    """A run over one server, or two of which the second comes later: nothing executes at its end that it does not name.

    A second server that comes when the goal was sent does not have it, unless it was on its way already.
    """
    rig = Rig(open_ros)
    try:
        rig.serve(first)
        rig.wait_for(connector, 1)
        arrival = threading.Timer(after_s, lambda: rig.serve(second)) if second is not None else None
        if arrival is not None:
            arrival.start()
        try:
            result = run(rig, connector)
        except UsageError:  # both were there in time, and neither has a goal
            assert rig.executing() == set()
            return
        finally:
            if arrival is not None:
                arrival.join()
        executing = rig.executing()
        assert not executing or result.open_goals, (first, second, after_s, executing, result)
        if all(not plan.refuses and plan.cancels is not None and plan.dies is None for plan in (first, second) if plan):
            until = time.monotonic() + 8.0
            while rig.executing() and time.monotonic() < until:
                threading.Event().wait(0.05)
            assert rig.executing() == set(), ("what is accepted late is canceled", first, second, after_s, result)
    finally:
        rig.close()


@quick
@given(PLANS, st.none() | PLANS, SECONDS)
def test_what_executes_when_a_run_has_ended_is_named(
    open_ros: Open, ours: Any, first: Plan, second: Plan | None, after_s: float
) -> None:
    hold(open_ros, ours, first, second, after_s)


@pytest.mark.long
@pytest.mark.drill
@settings(parent=quick, max_examples=60)
@given(PLANS, st.none() | PLANS, SECONDS)
def test_what_executes_when_a_run_has_ended_is_named_over_many_servers(
    open_ros: Open, ours: Any, first: Plan, second: Plan | None, after_s: float
) -> None:
    hold(open_ros, ours, first, second, after_s)
