# SPDX-License-Identifier: Apache-2.0
"""What a client may do to a mission through its node, and what it is reported; over a connector in this process."""

from __future__ import annotations

import json
import logging
import math
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.agents.mission import RunConfig
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.journal import read
from rai_missions.mission.files import dump
from rai_missions.node import MissionNode
from rai_missions.node.order import LONGEST, ClientOrder, OrderReply
from rai_missions.node.transport import Carrier
from rai_missions.testing import check_agent
from tests.node.conftest import Scene
from tests.node.scenes import Client, mission, robot

ORDERS = ("start", "pause", "resume", "cancel", "e_stop", "control")
ALLOWED = {
    "idle": {"start": "running"},
    "running": {"pause": "paused", "cancel": "idle", "e_stop": "stopped", "control": "running"},
    "paused": {"resume": "running", "cancel": "idle", "e_stop": "stopped", "control": "paused"},
    "stopped": {"control": "idle"},
}
"""Mode → the orders that make sense in it, and what it is then."""


def obeys(client: Client, orders: list[str]) -> None:
    """Give the orders one after the other; each is taken where the lifecycle allows it, and nowhere else."""
    mode = "idle"
    for order in orders:
        reported = client.call(order) if order != "control" else client.command(command="control", to="operator")
        assert reported["success"] is (order in ALLOWED[mode]), (mode, order, reported)
        assert reported["success"] or reported.get("message") or reported["why"], f"a refused '{order}' states why"
        mode = ALLOWED[mode].get(order, mode)
        if reported["success"] and order in ("cancel", "e_stop"):
            client.await_status("it is over", outcome="canceled" if order == "cancel" else "aborted")
        elif reported["success"] and mode != "idle":
            client.await_status(f"it is {mode}", mode=mode)
    if mode in ("running", "paused"):
        client.call("e_stop")
        client.await_status("it is over", outcome="aborted")
        mode = "stopped"
    if mode == "stopped":
        assert client.command(command="control", to="operator")["success"]


def revisions_rise(client: Client) -> None:
    revisions = [status["revision"] for status in client.statuses.all]
    assert revisions == sorted(set(revisions)), "every status has a higher revision than the one before"


@given(orders=st.lists(st.sampled_from(ORDERS), max_size=7))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_orders_are_taken_where_the_lifecycle_allows_them_and_refused_elsewhere(
    active: Client, orders: list[str]
) -> None:
    obeys(active, orders)
    revisions_rise(active)


@pytest.fixture(scope="module")
def active() -> Any:
    connector = LocalConnector()
    connector.start()
    node = MissionNode(RunConfig(mission(), robot({"kind": "local"})), carrier=Carrier(connector, True, False))
    client = Client(connector, node.name.path)
    node.run()
    client.activate()
    yield client
    node.stop()
    connector.stop()


@pytest.mark.parametrize(
    ("file", "text", "called"),
    [
        ("orchard-2.json", "", "/errand"),
        ("mission.json", "{", "/mission"),
        ("2nd-try.json", "{", "/_2nd_try"),
    ],
)
def test_a_node_without_a_name_has_its_mission_s_and_else_its_file_s(
    open_scene: Callable[..., Scene], tmp_path: Path, file: str, text: str, called: str
) -> None:
    path = tmp_path / file
    path.write_text(text or dump(mission()))
    scene = open_scene("", mission=path)
    assert scene.node.name.path == called
    scene.client.await_status("it reports whose node it is", mission="" if text else "errand")


def test_a_node_does_nothing_before_it_is_configured_and_activated(scene: Scene) -> None:
    reported = scene.client.call("start")
    assert reported == {"success": False, "message": "the node is unconfigured; configure and activate it first"}
    assert scene.client.change("configure")
    assert scene.client.call("start")["message"] == "the node is inactive; activate it first"
    assert scene.client.change("activate")
    assert scene.client.call("start")["success"]


def test_a_run_goes_from_start_to_its_end_and_again(scene: Scene) -> None:
    scene.client.activate()
    for count in (1, 2):
        scene.client.start()
        assert scene.client.command(command="post", event="go")["success"]
        scene.robot.asked.wait(lambda asked, n=count: asked.count("move") == n, "the robot moves")  # type: ignore[misc]
        scene.robot.arrive()
        status = scene.client.await_status("it is over", outcome="succeeded")
        assert status["why"] == "'done' was reached, and there is true"
    assert len({status["run"] for status in scene.client.statuses.all} - {""}) == 2
    revisions_rise(scene.client)


def test_deactivating_pauses_the_mission_and_activating_continues_with_it(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    scene.client.command(command="post", event="go")
    scene.robot.asked.wait(lambda asked: asked == ["move"], "the robot moves")
    assert scene.client.change("deactivate") and scene.client.state() == "inactive"
    scene.robot.asked.wait(lambda asked: asked == ["move", "halt"], "the robot halts")
    assert scene.client.call("resume")["message"] == "the node is inactive; activate it first"
    assert scene.client.change("activate")
    scene.robot.asked.wait(lambda asked: asked == ["move", "halt", "move"], "the robot moves again")


def test_a_mission_that_a_person_has_paused_stays_so_when_the_node_is_activated(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.call("pause")["success"]
    assert scene.client.change("deactivate") and scene.client.change("activate")
    scene.client.await_status("the node is active", lifecycle="active", mode="paused")


def test_cleaning_up_cancels_the_mission_and_ends_when_that_has_ended(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.change("deactivate") and scene.client.change("cleanup")
    scene.client.await_status("it is unconfigured", lifecycle="unconfigured", outcome="canceled")
    assert scene.client.change("configure")


def test_after_an_e_stop_nothing_begins_until_an_operator_has_taken_control(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.call("e_stop")["success"]
    scene.client.await_status("it is over", outcome="aborted", control="nobody")
    assert scene.client.call("start")["message"].startswith('control is with "nobody" since the stop')
    for by, to in (("agent", "operator"), ("nobody", "operator"), ("Ann", "autonomy")):
        assert "control is with 'nobody' since the stop" in scene.client.command(command="control", to=to, by=by)["why"]
    assert not scene.client.call("start")["success"]
    assert scene.client.command(command="control", to="operator", by="Ann")["success"]
    scene.client.await_status("the operator has it", control="operator")
    assert scene.client.call("start")["success"]


def test_an_inactive_node_can_still_be_stopped(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.change("deactivate")
    assert scene.client.call("e_stop")["success"]
    scene.client.await_status("it is over", outcome="aborted", control="nobody")


def test_shutting_down_cancels_the_mission_and_finalizes_the_node(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.change("shutdown")
    scene.client.await_status("it is finalized", lifecycle="finalized", outcome="canceled")
    assert scene.node.wait(30) and not scene.client.change("configure")
    labels = [label for label, _ in scene.client.moves.wait(lambda all_: len(all_) == 6, "every move is reported")]
    assert labels == [
        "configure",
        "transition_success",
        "activate",
        "transition_success",
        "shutdown",
        "transition_success",
    ]


def test_what_is_at_fault_leaves_the_node_unconfigured_until_it_is_mended(
    open_scene: Callable[..., Scene], tmp_path: Path
) -> None:
    file = tmp_path / "errand.json"
    file.write_text('{"format": 1, "name": "errand", "initial": "nowhere", "states": {"over": {"final": "aborted"}}}')
    scene = open_scene(mission=file)
    assert not scene.client.change("configure")
    status = scene.client.await_status("it is unconfigured", lifecycle="unconfigured", fault=scene.node.fault)
    assert "/initial: no state 'nowhere'" in status["fault"]
    file.write_text(json.dumps({"format": 1, **mission().written()}))
    assert scene.client.change("configure")
    scene.client.await_status("it is inactive", lifecycle="inactive", fault="", mission="errand", version="1.2.3")


def test_an_error_that_no_one_foresaw_goes_through_errorprocessing(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.CRITICAL + 1)
    monkeypatch.setattr("rai_missions.node.run_host.readied", lambda _setting: 1 / 0)
    assert not scene.client.change("configure")
    ways = scene.client.moves.wait(lambda all_: len(all_) == 3, "every move is reported")
    assert ways == [
        ("configure", "configuring"),
        ("transition_error", "errorprocessing"),
        ("transition_success", "unconfigured"),
    ]
    assert (
        scene.client.await_status("why", lifecycle="unconfigured")["fault"]
        == "configure: ZeroDivisionError: division by zero"
    )


def test_a_question_is_in_the_status_until_it_is_answered(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    scene.client.command(command="post", event="ask")
    asked = scene.client.await_status("a question", active=["asking"])["question"]
    assert (asked["text"], asked["asked"], asked["state"]) == ("Which way?", "operator", "asking")
    assert [option["name"] for option in asked["options"]] == ["left", "right"] and 0 < asked["left_s"] <= 600
    reported = scene.client.command(command="answer", question=asked["number"], option="left", by="Ann")
    assert reported["success"]
    scene.client.await_status("it is over", outcome="aborted", question=None)


def test_an_answer_that_does_not_count_reports_why(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    reported = scene.client.command(command="answer", question=7, option="left")
    assert reported["why"] == "question 7 is not open; open: none"
    scene.client.command(command="post", event="ask")
    number = scene.client.await_status("a question", active=["asking"])["question"]["number"]
    reported = scene.client.command(command="answer", question=number, option="fly")
    assert not reported["success"] and "'fly' was not offered; offered: left, right" in reported["why"]


def test_a_client_answers_no_question_that_the_mission_does_not_ask_the_operator(
    open_scene: Callable[..., Scene],
) -> None:
    class Patient:
        def ask(self, question: Any, answer: Any) -> None: ...

        def withdraw(self, number: int) -> None: ...

    scene = open_scene(answerers={"agent": Patient()})
    scene.client.activate()
    scene.client.start()
    scene.client.command(command="post", event="guess")
    number = scene.client.await_status("a question", active=["guessing"])["question"]["number"]
    reported = scene.client.command(command="answer", question=number, option="left")
    assert reported["why"] == f"question {number} is not for the operator; it is asked of agent"
    scene.client.await_status("nothing has moved", active=["guessing"])


def test_an_event_that_the_profile_does_not_list_as_posted_is_refused(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    results = scene.client.command(command="post", event="unlisted")
    assert results["why"] == "the robot profile lists no posted event 'unlisted'; there is: ask, go, guess"
    assert scene.client.command(command="post", event="go", data={"by": "x", "request": "y"})["success"]
    results = scene.client.command(command="post", event="ask")
    assert (results["success"], results["why"]) == (True, "nothing in the mission reacts to it now")


def test_control_is_asked_for_by_its_rules(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    assert scene.client.command(command="control", to="operator")["success"]
    scene.client.holders.wait(lambda all_: all_[-1] == "operator", "the operator holds control")
    reported = scene.client.command(command="control", to="autonomy", by="autonomy")
    assert reported["why"] == "the operator has control and has not given it back"
    reported = scene.client.command(command="control", to="pilot")
    assert reported["why"].startswith("no one called 'pilot' can hold control; there is: agent, ")
    assert scene.client.command(command="control", to="autonomy", by="Ann")["success"]
    scene.client.holders.wait(lambda all_: all_[-1] == "autonomy", "it is given back")


def test_a_state_that_waits_for_control_is_notified_of(open_scene: Callable[..., Scene]) -> None:
    states = mission().model_dump(mode="json", by_alias=True, exclude_unset=True)["states"]
    states["asking"]["control"] = "agent"
    scene = open_scene(mission=mission(states=states))
    scene.client.activate()
    scene.client.start()
    scene.client.command(command="post", event="ask")
    asked = scene.client.await_status("the question is asked", active=["asking"], control="agent")
    assert asked["waits"] == ""
    assert scene.client.command(command="control", to="autonomy")["success"]
    reported = scene.client.await_status("control is away", control="autonomy", questions=[])
    assert reported["waits"] == "asking waits until control is with agent; autonomy has it"
    assert scene.client.command(command="control", to="agent", by="agent")["success"], "it was given, not taken"
    scene.client.await_status("it is asked again", control="agent", waits="")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "an order is not understood"), ("[]", "an order is a JSON object"), ("", "command: null is none"),
        ('{"command": "paus"}', "command: 'paus' is none; did you mean 'pause'?"),
        ('{"command": "start", "arguments": [1]}', "arguments: [1] is not an object"),
        ('{"command": "answer", "question": true, "option": "a"}', "question: true is not a whole number"),
        ('{"command": "answer", "question": 1}', "'answer' needs the word 'option'"),
        ('{"command": "pause", "too": 1}', "'pause' has no word 'too'"),
        ('{"command": "start", "arguments": {"a": NaN}}', "an order is not understood"),
        ("x" * (LONGEST + 1), f"an order of {LONGEST + 1} characters is not read; {LONGEST} are the most"),
    ],
)  # fmt: skip
def test_what_is_no_order_is_answered_with_why(active: Client, text: str, why: str) -> None:
    reported = active.command(text)
    assert not reported["success"] and reported["why"].startswith(why), reported


def test_arguments_come_with_the_start_and_are_checked(scene: Scene) -> None:
    scene.client.activate()
    reported = scene.client.command(command="start", arguments={"sped": 2})
    assert "the mission takes no argument 'sped'; did you mean 'speed'" in reported["why"]
    assert "does not fit" in scene.client.command(command="start", arguments={"speed": "fast"})["why"]
    assert scene.client.command(command="start", arguments={"speed": 2})["success"]


def test_who_did_what_is_in_the_journal(open_scene: Callable[..., Scene], tmp_path: Path) -> None:
    file = tmp_path / "run.journal"
    scene = open_scene(journals=lambda: file)
    scene.client.activate()
    scene.client.command(command="start", by="Ann")
    scene.client.await_status("it runs", mode="running")
    scene.client.call("pause")
    scene.client.command(command="resume", by="Ben\n\x1b[2J")
    scene.client.call("cancel")
    scene.client.await_status("it is over", outcome="canceled")
    with read(file) as record:
        commands = [step.event for step in record.steps() if step.event.kind == "command"]
        notes = [note.text for note in record.notes()]
    done = [(event.name, event.data["by"]) for event in commands if event.data]
    assert done == [("pause", "operator (~/pause)"), ("resume", "Ben  [2J"), ("cancel", "operator (~/cancel)")]
    assert notes == ["started by Ann"]


def test_each_step_that_did_something_is_published(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    scene.client.command(command="post", event="go")
    reported = scene.client.steps.wait(
        lambda all_: any(step["event"]["name"] == "accepted" for step in all_) or len(all_) >= 2, "steps"
    )
    assert reported[0]["moves"][0]["entered"] == ["waiting"] and {step["run"] for step in reported} == {
        reported[0]["run"]
    }


def test_keys_that_are_not_fresh_are_reported_in_the_diagnostics(open_scene: Callable[..., Scene]) -> None:
    there = {"type": "boolean", "source": "robot", "optional": True, "max_age_s": 0.01}
    speed = {"type": "number", "source": "argument", "initial": 1.0}
    scene = open_scene(mission=mission(blackboard={"there": there, "speed": speed}))
    received: Inbox[str] = Inbox(30.0)
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    scene.client.connector.subscribe(
        "/diagnostics", kind, lambda reported: received(reported.data["status"][0]["message"])
    )
    scene.client.activate()
    scene.client.start()
    scene.robot.arrive()
    received.wait(lambda all_: all_[-1] == "not fresh: there", "the key is stale")


def kept_busy(scene: Scene) -> threading.Event:
    """A run that takes no order until this is set."""
    scene.client.activate()
    scene.client.start()
    is_busy, is_free = threading.Event(), threading.Event()
    scene.robot.obey = lambda _word: is_busy.set() or is_free.wait(30)  # on the run's own thread, in this process
    scene.node.ask(ClientOrder("post", event="go"), within_s=0.0)
    assert is_busy.wait(30)
    return is_free


@pytest.fixture
def busy_for_any_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """No order is dropped, however slow this machine is."""
    monkeypatch.setattr("rai_missions.runtime.requests.GOOD_FOR_S", math.inf)


@pytest.mark.usefixtures("busy_for_any_time")
def test_a_busy_run_is_paused_late_and_the_node_is_deactivating_until_then(scene: Scene) -> None:
    is_free = kept_busy(scene)
    assert scene.client.change("deactivate") and scene.client.state() == "deactivating"
    assert not scene.client.change("activate")
    is_free.set()
    scene.client.await_status("both are at rest", lifecycle="inactive", mode="paused")
    assert scene.client.change("activate")
    scene.client.await_status("both continue", lifecycle="active", mode="running")


@pytest.mark.parametrize(("goes", "mode"), [("deactivate", "running"), ("activate", "paused")])
def test_a_transition_whose_order_is_dropped_leaves_the_node_and_its_mission_as_they_were(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, goes: str, mode: str
) -> None:
    scene.client.activate()
    scene.client.start()
    if goes == "activate":
        assert scene.client.change("deactivate")
    before = scene.client.state()
    monkeypatch.setattr("rai_missions.runtime.requests.GOOD_FOR_S", -1.0)  # as if the run had been busy for longer
    assert not scene.client.change(goes)
    assert scene.client.state() == before and "it was dropped" in scene.node.fault
    assert scene.node.session is not None and scene.node.session.mode == mode
    monkeypatch.undo()
    assert scene.client.change(goes)
    scene.client.await_status("it has", mode="running" if goes == "activate" else "paused")


@pytest.mark.usefixtures("busy_for_any_time")
def test_a_node_that_is_interrupted_while_it_deactivates_is_finalized(scene: Scene) -> None:
    is_free = kept_busy(scene)
    assert scene.client.change("deactivate")
    scene.node.shut_down()
    is_free.set()
    assert scene.node.wait(30)
    scene.client.await_status("it has ended", lifecycle="finalized", outcome="canceled")


def test_an_order_that_the_run_does_not_take_in_time_is_not_reported_as_done(scene: Scene) -> None:
    is_free = kept_busy(scene)
    reported = scene.node.ask(ClientOrder("pause"), within_s=0.0)
    is_free.set()
    assert not reported.success and "has not taken it yet" in reported.why
    scene.client.await_status("it is taken in the end", mode="paused")


def test_orders_that_a_busy_run_takes_too_late_are_dropped_but_those_that_end_it(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    is_free = kept_busy(scene)
    monkeypatch.setattr("rai_missions.runtime.requests.GOOD_FOR_S", -1.0)  # as if it had been busy for longer
    course, reported = scene.node.session, Inbox[OrderReply]()
    assert course is not None
    orders = (ClientOrder("pause", id="a"), ClientOrder("control", to="operator", id="b", role="operator"), ClientOrder("control", to="nobody", id="c", role="operator"),  # noqa: E501
              ClientOrder("post", event="ask", id="d"), ClientOrder("cancel", id="e"))  # fmt: skip
    for order in orders:
        course.submit(order, reported)
    is_free.set()
    receipts = {each.id: each for each in reported.wait(lambda all_: len(all_) == len(orders), "each has a reply")}
    assert {name: each.dropped for name, each in receipts.items()} == dict(zip("abcde", (1, 1, 0, 0, 0), strict=True))
    assert "did not get to it for" in receipts["a"].why and "give it again" in receipts["a"].why
    assert receipts["c"].success and receipts["e"].success
    scene.client.await_status("it is canceled", outcome="canceled")
    assert not any("paused" in step.get("notes", ()) for step in scene.client.steps.all)


def test_a_second_node_of_the_same_name_is_refused(scene: Scene) -> None:
    carrier = Carrier(scene.client.connector, True, False)
    with pytest.raises(
        UsageError, match="another node is called /errand already; give this one a name with --node NAME"
    ):
        MissionNode(RunConfig(mission(), robot({"kind": "local"})), carrier=carrier).run()
    assert scene.client.state() == "unconfigured", "the first is left as it was"


def test_a_stranger_under_the_same_name_is_warned_of_once(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    for text in ('{"instance": "stranger"}', '{"instance": "stranger"}'):
        scene.client.connector.publish("/errand/status", "std_msgs/msg/String", {"data": text})
    reported = [record.message for record in caplog.records if "another node" in record.message]
    assert reported == ["another node is called /errand too; give one of them another name with --node"]


def test_the_node_runs_and_stops_as_agents_do() -> None:
    def make() -> MissionNode:
        return MissionNode(
            RunConfig(mission(), robot({"kind": "local"})), carrier=Carrier(LocalConnector(), True, False)
        )

    check_agent(make)


def test_stopping_the_node_cancels_what_runs(scene: Scene) -> None:
    scene.client.activate()
    scene.client.start()
    scene.node.stop()
    assert scene.client.statuses.all[-1]["outcome"] == "canceled"
    assert scene.client.statuses.all[-1]["why"] == "canceled by stop"
