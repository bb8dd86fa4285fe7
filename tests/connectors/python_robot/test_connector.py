# SPDX-License-Identifier: Apache-2.0
"""The connector to a robot in Python keeps the contract, and what is promised of its functions."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rai_missions import PythonRobot, UsageError
from rai_missions.connectors.connector import ENDS, HostsActions, Message, Reply, Report
from rai_missions.connectors.python_robot import (
    ActionRun,
    AsyncActionRun,
    PythonRobotConnector,
    connector,
    fact_poll,
)
from rai_missions.connectors.python_robot.robot import EVENTS, FACTS, MESSAGES
from rai_missions.testing import Inbox, check_connector


@pytest.fixture
def robot() -> PythonRobot:
    return PythonRobot("turtle")


@pytest.fixture
def reached(robot: PythonRobot) -> Iterator[PythonRobotConnector]:
    """The robot behind its connector; started by the test, once the robot has its functions."""
    made = PythonRobotConnector(robot)
    yield made
    made.stop()


def pursued(reached: PythonRobotConnector, action: str, goal: dict[str, Any] | None = None) -> Inbox[Report]:
    reached.start()
    reports: Inbox[Report] = Inbox()
    reached.send_goal(action, "", goal or {}, goal_id="g", on_report=reports)
    return reports


def end_of(reports: Inbox[Report]) -> Report:
    return reports.wait(lambda all_: all_[-1].status in ENDS, "the goal ends")[-1]


def called(reached: PythonRobotConnector, service: str, timeout_s: float | None = None) -> Reply:
    reached.start()
    replies: Inbox[Reply] = Inbox()
    reached.call(service, "", {"loud": True}, on_reply=replies, timeout_s=timeout_s)
    return replies.wait(bool, "the service is called")[0]


def test_it_keeps_the_contract_of_connectors() -> None:
    check_connector(lambda: PythonRobotConnector(PythonRobot("turtle")))
    assert isinstance(PythonRobotConnector(PythonRobot("turtle")), HostsActions)


# -- actions -----------------------------------------------------------------------------------------------------------


def test_an_action_receives_its_goal_and_its_return_is_the_result(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    @robot.action("drive")
    def drive(goal: Any, run: ActionRun) -> dict[str, Any]:
        run.feedback({"left": goal["to"]})
        run.feedback(0.5)
        return {"at": goal["to"], "thread": threading.current_thread() is threading.main_thread()}

    reports = pursued(reached, "drive", {"to": 3})
    assert end_of(reports).data == {"at": 3, "thread": False}
    assert [(each.status, dict(each.data)) for each in reports.all[:3]] == [
        ("accepted", {}),
        ("feedback", {"left": 3}),
        ("feedback", {"value": 0.5}),
    ]


def test_an_async_action_waits_on_an_event_loop_and_shares_it_with_others(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    loops = []

    @robot.action("dock")
    async def dock(goal: Any, run: AsyncActionRun) -> dict[str, Any]:
        loops.append(asyncio.get_running_loop())
        await run.sleep(0.001)
        return {"docked": True}

    @robot.service("horn")
    async def horn(request: Any) -> None:
        loops.append(asyncio.get_running_loop())

    assert end_of(pursued(reached, "dock")).data == {"docked": True}
    assert called(reached, "horn").outcome == "succeeded"
    assert len(set(loops)) == 1


def test_an_async_action_that_awaits_no_wait_of_its_own_has_failed(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    @robot.action("hasty")
    async def hasty(goal: Any, run: AsyncActionRun) -> None:
        await run.sleep(0.001)
        run.sleep(0.001)

    @robot.action("patient")
    async def patient(goal: Any, run: AsyncActionRun) -> None:
        await asyncio.gather(run.sleep(0.001), run.sleep(0.002))

    why = "RuntimeError: run.sleep was called without await; write `await run.sleep(…)`"
    assert (end_of(pursued(reached, "hasty")).status, end_of(pursued(reached, "hasty")).why) == ("failed", why)
    assert end_of(pursued(reached, "patient")).status == "succeeded"


def fails(goal: Any, run: ActionRun) -> None:
    raise ValueError("no motor")


async def fails_async(goal: Any, run: AsyncActionRun) -> None:
    raise ValueError("no motor")


def misspells(goal: Any, run: ActionRun) -> None:
    run.cancelled  # type: ignore[attr-defined]  # noqa: B018


def test_a_wrong_attribute_of_the_run_suggests_the_right_one(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    robot.action("drive")(misspells)
    why = end_of(pursued(reached, "drive")).why
    assert why.startswith("AttributeError: 'ActionRun' object has no attribute 'cancelled'")
    assert "'canceled'?" in why


def fails_in_a_library(goal: Any, run: ActionRun) -> None:
    int(json.loads("[}"))


def leaves(goal: Any, run: ActionRun) -> None:
    raise SystemExit("no motor")


def test_the_place_of_a_fault_is_the_last_line_that_the_author_has_written(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    robot.action("drive")(fails_in_a_library)
    line = fails_in_a_library.__code__.co_firstlineno + 1
    assert f"(test_connector.py, line {line}, in fails_in_a_library)" in end_of(pursued(reached, "drive")).why


@pytest.mark.parametrize("function", [fails, fails_async, leaves])
def test_an_exception_is_the_failure_of_an_action_with_its_last_line_and_place(
    function: Callable[..., Any], robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    robot.action("drive")(function)
    end = end_of(pursued(reached, "drive"))
    line = function.__code__.co_firstlineno + 1
    name = "SystemExit" if function is leaves else "ValueError"
    assert (end.status, end.why) == (
        "failed",
        f"{name}: no motor (test_connector.py, line {line}, in {function.__name__})",
    )


def test_a_result_that_is_no_dict_is_a_failure_that_names_it(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    robot.action("drive")(lambda goal, run: 3)
    end = end_of(pursued(reached, "drive"))
    assert (end.status, end.why) == ("failed", "action 'drive' returned 3; its result is a dict or None")


@pytest.mark.parametrize("asynchronous", [False, True])
def test_a_cancel_ends_a_wait_at_once_and_the_action_reports_it(
    asynchronous: bool, robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    def drive(goal: Any, run: ActionRun) -> Any:
        while not run.canceled:
            run.sleep(3600)
        return run.cancel()

    async def drive_async(goal: Any, run: AsyncActionRun) -> Any:
        while not run.canceled:
            await run.sleep(3600)
        return run.cancel()

    robot.action("drive")(drive_async if asynchronous else drive)
    reports = pursued(reached, "drive")
    reports.wait(bool, "the goal is accepted")
    reached.cancel_goal("g")
    assert end_of(reports).status == "canceled"


def test_a_wait_after_the_cancel_lasts_as_long_as_it_should(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    begun, waits = threading.Event(), []

    @robot.action("drive")
    def drive(goal: Any, run: ActionRun) -> Any:
        begun.set()
        for seconds in (3600, 0.05):
            before = time.monotonic()
            run.sleep(seconds)
            waits.append(time.monotonic() - before)
        return run.cancel()

    reports = pursued(reached, "drive")
    assert begun.wait(30)
    reached.cancel_goal("g")
    end_of(reports)
    assert waits[0] < 30 and waits[1] >= 0.05


def test_a_cancel_that_comes_just_before_a_wait_ends_it(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    begun, go = threading.Event(), threading.Event()

    @robot.action("drive")
    def drive(goal: Any, run: ActionRun) -> Any:
        begun.set()
        assert go.wait(30) and run.canceled
        run.sleep(3600)
        return run.cancel()

    reports = pursued(reached, "drive")
    assert begun.wait(30)
    reached.cancel_goal("g")
    go.set()
    assert end_of(reports).status == "canceled"


def test_the_end_of_a_run_waits_for_an_action_that_ignores_its_cancel_no_longer_than_stated(
    robot: PythonRobot, reached: PythonRobotConnector, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connector, "EXIT_S", 0.1)
    left, ended = threading.Event(), Inbox[None]()

    @robot.action("drive")
    def drive(goal: Any, run: ActionRun) -> None:
        try:
            while True:
                run.sleep(0.01)
        finally:
            left.set()

    reports = pursued(reached, "drive")
    reports.wait(bool, "the goal is accepted")
    reached.cancel_goal("g")
    reached.conclude(lambda: ended(None))
    ended.wait(bool, "the wait is over")
    assert [each.status for each in reports.all] == ["accepted", "overdue"]
    assert not left.is_set()
    before = time.monotonic()
    reached.stop()
    assert time.monotonic() - before < 5
    assert left.wait(30), "a wait of what ignores its cancel ends once the run is over"


def test_the_end_of_a_run_without_actions_is_at_once(reached: PythonRobotConnector) -> None:
    reached.start()
    ended: list[bool] = []
    reached.conclude(lambda: ended.append(True))
    assert ended == [True]


def test_a_run_that_has_ended_gives_up_no_goal_of_the_one_that_follows(
    robot: PythonRobot, reached: PythonRobotConnector, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs follow one another over one connector, also within the time that the end of each would wait."""
    monkeypatch.setattr(connector, "EXIT_S", 0.1)
    robot.action("drive")(lambda goal, run: run.sleep(0.3))
    reached.start()
    reached.conclude(lambda: None)
    reports = pursued(reached, "drive")
    end_of(reports)
    assert [each.status for each in reports.all] == ["accepted", "succeeded"]


# -- services and messages ---------------------------------------------------------------------------------------------


def test_a_service_returns_its_response_or_fails_with_what_it_raises(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    robot.service("horn")(lambda request: {"loud": request["loud"]})
    robot.service("light")(lambda request: None)
    robot.service("wrong")(lambda request: 3)

    @robot.service("arm")
    def arm(request: Any) -> None:
        raise OSError("no bus")

    assert called(reached, "horn")[:2] == ("succeeded", {"loud": True})
    assert called(reached, "light")[:2] == ("succeeded", {})
    failed = called(reached, "arm")
    assert (failed.outcome, failed.why) == (
        "failed",
        f"OSError: no bus (test_connector.py, line {arm.__code__.co_firstlineno + 2}, in arm)",
    )
    assert "service 'wrong' returned 3; its response is a dict or None" in called(reached, "wrong").why
    assert called(reached, "lamp").outcome == "unavailable"


def test_a_service_that_hangs_times_out_and_holds_up_no_other(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    hangs, calls = threading.Event(), []

    @robot.service("arm")
    def arm(request: Any) -> None:
        calls.append(request)
        hangs.wait(30)

    robot.service("horn")(lambda request: None)
    assert called(reached, "arm", 0.05).outcome == "timed_out"
    assert called(reached, "arm", 0.05).outcome == "timed_out"
    assert called(reached, "horn").outcome == "succeeded"
    hangs.set()
    assert called(reached, "arm").outcome == "succeeded"
    assert len(calls) == 2, "a call that has timed out before its turn is not carried out"


def test_a_message_that_a_mission_publishes_comes_to_its_function(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    received: Inbox[Any] = Inbox()
    robot.topic("lights")(received)
    reached.start()
    reached.publish(f"{MESSAGES}lights", "", {"on": True})
    assert received.wait(bool, "a message was published") == [{"on": True}]


# -- facts and events --------------------------------------------------------------------------------------------------


def test_a_fact_is_polled_and_none_is_nothing_new(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    values = iter([0.9, None, 0.8])
    robot.fact("battery", every_s=0.001)(lambda: next(values, None))
    reached.start()
    inbox: Inbox[Message] = Inbox()
    reached.subscribe(f"{FACTS}battery", "", inbox)
    received = inbox.wait(lambda all_: len(all_) == 2, "two values were read")
    assert [each.data for each in received] == [{"value": 0.9}, {"value": 0.8}]


def test_a_fact_that_no_mission_wants_is_not_read(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    reads: list[int] = []
    robot.fact("battery")(lambda: reads.append(1))
    reached.start()
    reached.subscribe(f"{FACTS}pose", "", lambda message: None)
    assert reads == []


def test_a_fact_that_raises_is_logged_once_and_read_again(
    robot: PythonRobot, reached: PythonRobotConnector, caplog: pytest.LogCaptureFixture
) -> None:
    answers = iter([OSError("no bus"), OSError("no bus"), 0.5])

    @robot.fact("battery", every_s=0.001)
    def battery() -> Any:
        if isinstance(answer := next(answers, None), OSError):
            raise answer
        return answer

    reached.start()
    inbox: Inbox[Message] = Inbox()
    reached.subscribe(f"{FACTS}battery", "", inbox)
    inbox.wait(bool, "it is read again")
    line = battery.__code__.co_firstlineno + 3
    assert [record.getMessage() for record in caplog.records] == [
        "fact 'battery' failed and counts as not received: "
        f"OSError: no bus (test_connector.py, line {line}, in battery)"
    ]


def test_what_an_action_has_done_is_read_before_its_end_is_reported(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    place = {"x": 0}
    robot.fact("x", every_s=3600)(lambda: place["x"])

    @robot.action("drive")
    def drive(goal: Any, run: ActionRun) -> None:
        place["x"] = 7

    order: Inbox[Any] = Inbox()
    reached.start()
    reached.subscribe(f"{FACTS}x", "", lambda message: order(message.data["value"]))
    order.wait(bool, "it is read at the beginning")
    reached.send_goal("drive", "", {}, goal_id="g", on_report=lambda report: order(report.status))
    assert order.wait(lambda all_: "succeeded" in all_, "it ends") == [0, "accepted", 7, "succeeded"]


def test_a_fact_that_hangs_delays_an_end_no_longer_than_stated(
    robot: PythonRobot, reached: PythonRobotConnector, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fact_poll, "REFRESH_S", 0.05)
    hangs = threading.Event()
    robot.fact("x")(lambda: hangs.wait(30))
    robot.action("drive")(lambda goal, run: None)
    reached.start()
    reached.subscribe(f"{FACTS}x", "", lambda message: None)
    assert end_of(pursued(reached, "drive")).status == "succeeded"
    hangs.set()


def test_a_value_written_before_the_run_is_there_at_its_start_with_its_age(
    robot: PythonRobot, reached: PythonRobotConnector
) -> None:
    robot.write("battery", 0.7)
    robot.write("battery", 0.8)
    robot.write("battery", None)
    reached.start()
    inbox: Inbox[Message] = Inbox()
    reached.subscribe(f"{FACTS}battery", "", inbox)
    (message,) = inbox.all
    assert message.data == {"value": 0.8} and message.kept and message.age_s is not None and message.age_s >= 0
    thread = threading.Thread(target=lambda: robot.write("battery", 0.6))
    thread.start()
    thread.join()
    assert inbox.all[-1].data == {"value": 0.6}


def test_an_event_outside_a_run_or_that_no_mission_has_is_dropped_and_reported(
    robot: PythonRobot, caplog: pytest.LogCaptureFixture
) -> None:
    robot.raise_event("branch")
    reached = PythonRobotConnector(robot, events=["branch", "stone"])
    reached.start()
    robot.raise_event("stone")
    inbox: Inbox[Message] = Inbox()
    reached.subscribe(f"{EVENTS}branch", "", inbox)
    robot.raise_event("brunch")
    robot.raise_event("branch", {"height_m": 0.2})
    assert [each.data for each in inbox.all] == [{"height_m": 0.2}]
    assert [record.getMessage() for record in caplog.records] == [
        "event 'branch' was raised while the robot 'turtle' is in no run; it is dropped",
        "the event 'stone' is dropped: it came before the start",
        "the event 'brunch' is dropped: it is none of the mission; did you mean 'branch'?",
    ]
    reached.stop()


def test_a_value_that_the_mission_has_no_key_for_is_reported_once_with_the_key_that_was_meant(
    robot: PythonRobot, caplog: pytest.LogCaptureFixture
) -> None:
    robot.fact("of_another_mission")
    robot.write("batery", 0.5)
    reached = PythonRobotConnector(robot, keys=["battery", "pose"])
    reached.start()
    for _ in range(3):
        robot.write("speed", 1.0)
        for name in ("batery", "battery", "of_another_mission"):
            robot.write(name, 0.4)
    reached.stop()
    assert [record.getMessage() for record in caplog.records] == [
        "the value of 'batery' is dropped: the mission has no such key of the robot's; did you mean 'battery'?",
        "the value of 'speed' is dropped: the mission has no such key of the robot's; there is: battery, pose",
    ]


def test_a_fact_whose_first_reading_does_not_return_is_named(
    robot: PythonRobot, reached: PythonRobotConnector, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connector, "PATIENCE_S", 0.02)
    held, reported = threading.Event(), Inbox[str]()
    handler = logging.Handler()
    monkeypatch.setattr(handler, "emit", lambda record: reported(record.getMessage()))
    monkeypatch.setattr(logging.getLogger(fact_poll.__name__), "handlers", [handler])
    robot.fact("n", every_s=60)(held.wait)
    reached.start()
    reached.subscribe(f"{FACTS}n", "", Inbox())
    messages = reported.wait(bool, "the fact is named")
    held.set()
    assert messages == ["fact 'n': its function has not returned yet, so the key has no value"]


# -- what a robot is made of -------------------------------------------------------------------------------------------


def drive_home(goal):  # type: ignore[no-untyped-def]
    """Of an author who annotates nothing."""


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda r: r.fact("Battery"), "'Battery' is no name"),
        (lambda r: r.action(test_a_robot_is_in_one_run_at_a_time), "write @robot.action('test_a_robot"),
        (lambda r: (r.service("horn")(lambda q: None), r.service("horn")), "service 'horn' has a function already"),
        (
            lambda r: r.action("drive")(lambda goal: None),
            "action 'drive': '<lambda>' takes (goal), and is called with (goal, run)",
        ),
        (lambda r: r.fact("x")(drive_home), "'drive_home' takes (goal), and is called with (); write def drive_home()"),
        (lambda r: r.service("horn")(7), "service 'horn': 7 is no function"),
        (lambda r: r.fact("x", every_s=0), "every_s is a number of seconds above 0, not 0"),
        (lambda r: r.fact("x", every_s="0.5"), "every_s is a number of seconds above 0, not '0.5'"),
        (lambda r: r.action("drive", uses="base"), "write uses=['base']"),
        (lambda r: r.raise_event("branch", 7), "the payload of event 'branch' is a dict, not 7"),
    ],
)
def test_what_is_wrong_in_a_robot_is_named_where_it_is_written(
    make: Callable[[Any], Any], sentence: str, robot: PythonRobot
) -> None:
    with pytest.raises(UsageError) as caught:
        make(robot)
    assert sentence in str(caught.value)


def test_a_robot_is_in_one_run_at_a_time(robot: PythonRobot, reached: PythonRobotConnector) -> None:
    reached.start()
    with pytest.raises(UsageError, match="is in another run; offer `def robot"):
        PythonRobotConnector(robot).start()
    reached.stop()
    other = PythonRobotConnector(robot)
    other.start()
    other.stop()
