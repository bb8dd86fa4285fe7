# SPDX-License-Identifier: Apache-2.0
"""Pause, resume, cancel, kill, handing over and answering, from any thread and at any time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.modes import MODES
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.lifecycle import Lifecycle, Status
from rai_missions.runtime.result import Result
from rai_missions.testing import LateAnswerer
from tests.rigs.runs import Rig, asking, mission

MOVING: dict[str, Any] = {
    "moving": {
        "action": "move",
        "timeout_s": 5,
        "transitions": [
            {"on": "go", "to": "over"},
            {"on": "succeeded", "to": "over"},
            {"on": "timed_out", "to": "late"},
        ],
    },
    "over": {"final": "aborted"},
    "late": {"final": "failed"},
}
DRIVING: dict[str, Any] = {
    "driving": {
        "control": "autonomy",
        "action": "move",
        "timeout_s": 60,
        "transitions": [{"on": "go", "to": "turning"}],
    },
    "turning": {
        "control": "autonomy",
        "action": "turn",
        "timeout_s": 60,
        "transitions": [{"on": "succeeded", "to": "over"}],
    },
    "over": {"final": "aborted"},
}
ASKING = asking(deadline_s=30)


def test_a_pause_cancels_the_goal_keeps_the_time_left_and_resume_starts_it_again() -> None:
    rig = Rig(MOVING)
    rig.stage.play({2.0: rig.runner.pause, 10.0: rig.runner.resume})
    result = rig.run()
    assert len(rig.move.goals) == 2 and len(rig.move.canceled) == 2
    assert (result.outcome, result.duration_s) == ("failed", 13.0), "3 s were left of 5 when it was paused"


def test_an_event_during_a_pause_is_received_after_it() -> None:
    rig = Rig(MOVING)
    rig.stage.play({2.0: rig.runner.pause, 3.0: lambda: rig.post("go"), 10.0: rig.runner.resume})
    result = rig.run()
    assert (result.outcome, result.duration_s) == ("aborted", 10.0)


def test_a_pause_too_many_and_a_resume_too_many_change_nothing() -> None:
    rig = Rig(MOVING)
    rig.stage.play(
        {
            0.5: rig.runner.resume,
            1.0: rig.runner.pause,
            1.5: rig.runner.pause,
            2.0: rig.runner.resume,
            3.0: lambda: rig.post("go"),
        }
    )
    assert rig.run().outcome == "aborted"
    refused = [step.why for step in rig.book.steps if step.event.kind == "command" and step.why and not step.outcome]
    assert [why.split(";")[0] for why in refused] == [
        "only a paused mission can be resumed",
        "only a running mission can be paused",
    ]


def test_a_cancel_ends_the_run_and_names_who_wanted_it() -> None:
    rig = Rig(MOVING)
    rig.stage.play({1.0: lambda: rig.runner.cancel("Ada")})
    result = rig.run()
    assert (result.outcome, result.why) == ("canceled", "canceled by Ada") and len(rig.move.canceled) == 1


def test_a_cancel_goes_by_the_missions_own_way_and_a_second_changes_nothing() -> None:
    states = {
        **MOVING,
        "parking": {"action": "turn", "timeout_s": 20, "transitions": [{"on": "succeeded", "to": "over"}]},
    }
    rig = Rig(mission(states, on_cancel="parking", cancel_s=30))
    rig.stage.play({1.0: rig.runner.cancel, 2.0: rig.runner.cancel, 3.0: lambda: rig.turn.report("succeeded")})
    result = rig.run()
    assert (result.outcome, result.duration_s) == ("canceled", 3.0) and len(rig.turn.goals) == 1
    assert [step.why for step in rig.book.steps if step.event.name == "cancel"] == ["", "it is being canceled already"]


def test_a_cancel_that_takes_too_long_is_cut_short() -> None:
    states = {
        **MOVING,
        "parking": {"action": "turn", "timeout_s": 99, "transitions": [{"on": "succeeded", "to": "over"}]},
    }
    rig = Rig(mission(states, on_cancel="parking", cancel_s=4))
    rig.stage.play({1.0: rig.runner.cancel})
    result = rig.run()
    assert (
        result.outcome == "canceled"
        and len(rig.turn.canceled) == 1
        and result.duration_s == pytest.approx(5.0, abs=0.11)
    )


@pytest.mark.parametrize("command", ["cancel", "kill"])
def test_a_mission_that_is_stopped_before_it_starts_never_starts(command: str) -> None:
    keys = {"battery": {"type": "number", "source": "robot"}}
    states = {"moving": MOVING["moving"], "over": MOVING["over"], "late": MOVING["late"]}
    rig = Rig(mission(states, blackboard={**keys, "there": {"type": "boolean", "source": "robot", "optional": True}}))
    rig.stage.play({0.5: getattr(rig.runner, command), 1.0: lambda: rig.publish("/battery", percentage=0.5)})
    result = rig.run()
    assert result.outcome == {"cancel": "canceled", "kill": "aborted"}[command]
    assert rig.move.goals == [] and result.duration_s == 0.5


def test_a_kill_overtakes_a_full_mailbox() -> None:
    rig = Rig(
        {"counting": {"transitions": [{"on": "go", "do": [{"set": "count", "add": 1}]}]}, "over": {"final": "aborted"}}
    )

    def flood() -> None:
        for _ in range(10_000):
            rig.post("go")
        rig.runner.kill("the e-stop")

    rig.stage.play({1.0: flood})
    result = rig.run()
    assert (result.outcome, result.why) == ("aborted", "e-stop by the e-stop")
    assert rig.runner.view.board["count"].value == 0


def test_a_kill_acts_before_it_is_written_down() -> None:
    rig = Rig(MOVING)
    rig.book.on_write = lambda step: order.append("written") if step.event.name == "kill" else None
    order: list[str] = []
    reported = rig.move.cancel
    rig.move.cancel = lambda goal_id: (order.append("stopped"), reported(goal_id))[1]  # type: ignore[method-assign]
    rig.stage.play({1.0: rig.runner.kill})
    rig.run()
    assert order == ["stopped", "written"]


def test_a_kill_leaves_control_with_no_one() -> None:
    rig = Rig(MOVING)
    rig.stage.play({1.0: rig.runner.kill})
    rig.run()
    assert rig.runner.view.holder == "nobody"
    assert (
        rig.runner.control("agent", by="agent", role="software")
        == "control is with 'nobody' since the stop; only the operator can lift it"
    )
    assert rig.runner.control("operator") == ""


def test_a_kill_from_another_thread_ends_a_run_that_waits_for_nothing() -> None:
    rig = Rig(
        {"waiting": {"transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}}, clock=WallClock()
    )
    waits = threading.Event()
    results: list[Result] = []
    rig.on_step = lambda step: waits.set()
    thread = threading.Thread(target=lambda: results.append(rig.run()))
    thread.start()
    assert waits.wait(5.0)
    rig.runner.kill("another thread")
    thread.join(5.0)
    assert results[0].why == "e-stop by another thread"


@pytest.mark.parametrize("by", [None, 5, ["x"], object(), "\ud800", "\0"])
@pytest.mark.parametrize("command", ["pause", "stop", "cancel", "kill"])
def test_no_order_is_refused_for_what_it_names_as_its_giver(command: str, by: Any, tmp_path: Path) -> None:
    """An e-stop least of all; what is no text is written as one, so that the journal holds it."""
    with Journal.create(tmp_path / "run.journal", Header("")) as journal:
        rig = Rig(MOVING, journal=journal)
        rig.stage.play({1.0: lambda: getattr(rig.runner, command)(by), 2.0: lambda: rig.runner.cancel(by)})
        result = rig.run()
    assert len(rig.move.canceled) == 1 and result.why == f"{'e-stop' if command == 'kill' else 'canceled'} by {by}"


def test_a_run_is_run_once_from_wherever_it_is_called_again() -> None:
    """From another thread, from what follows it, and after it: a second call is refused, and the run is as it was."""
    rig, refused = Rig(MOVING), list[str]()

    def again(*_: object) -> None:
        with pytest.raises(UsageError) as error:
            rig.run()
        refused.append(str(error.value))

    thread = threading.Thread(target=again)
    rig.on_step = again
    rig.stage.play({1.0: lambda: (thread.start(), thread.join()), 2.0: lambda: rig.post("go")})
    assert rig.run().duration_s == 2.0
    again()
    assert set(refused) == {"a Runner runs its mission once; make another one for another run"} and len(refused) > 3


def test_a_goal_that_outlives_a_kill_does_not_hang_the_run_on_the_wall_clock() -> None:
    states = {"moving": {**MOVING["moving"], "cancel_s": 0.05}, "over": MOVING["over"], "late": MOVING["late"]}
    rig = Rig(states, clock=WallClock())
    rig.move.on_cancel = ()
    rig.on_step = lambda step: rig.runner.kill() if step.event.kind == "accepted" else None
    thread = threading.Thread(target=rig.run, daemon=True)
    thread.start()
    thread.join(5.0)
    assert not thread.is_alive(), "the server never confirmed; cancel_s bounds the wait"


def test_an_operator_takes_control_the_action_stops_and_starts_again_when_it_is_given_back() -> None:
    rig = Rig(DRIVING)
    rig.stage.play(
        {
            1.0: lambda: rig.runner.control("operator"),
            8.0: lambda: rig.runner.control("autonomy"),
            9.0: lambda: rig.runner.kill(),
        }
    )
    rig.run()
    controls = [
        (step.at, step.event.name, step.event.data["by"]) for step in rig.book.steps if step.event.kind == "control"
    ]
    assert controls == [(1.0, "operator", "operator"), (8.0, "autonomy", "operator")]
    assert len(rig.move.goals) == 2 and len(rig.move.canceled) == 2


def test_what_needs_control_waits_for_as_long_as_an_operator_keeps_it() -> None:
    rig, goals = Rig(DRIVING), list[int]()
    rig.stage.play(
        {
            1.0: lambda: rig.runner.control("operator"),
            2.0: lambda: rig.post("go"),
            3000.0: lambda: goals.append(len(rig.turn.goals)),
            3001.0: lambda: rig.runner.control("autonomy"),
            3002.0: lambda: goals.append(len(rig.turn.goals)),
            3003.0: lambda: rig.runner.cancel("the test"),
        }
    )
    result = rig.run()
    assert goals == [0, 1] and result.why == "canceled by the test"


def test_who_does_not_hold_control_cannot_take_it_from_an_operator() -> None:
    rig = Rig(DRIVING)
    answers: list[str] = []
    rig.stage.play(
        {
            1.0: lambda: rig.runner.control("operator"),
            2.0: lambda: answers.append(rig.runner.control("agent", by="agent", role="software")),
            3.0: rig.runner.kill,
        }
    )
    rig.run()
    assert answers == ["the operator has control and has not given it back"]
    with pytest.raises(UsageError, match="nobody called 'bob' can hold control"):
        rig.runner.control("bob")


def test_a_message_that_gives_control_to_a_stranger_is_refused() -> None:
    rig = Rig(DRIVING)
    rig.stage.play({1.0: lambda: rig.runner.post(Event("bob", kind="control")), 2.0: rig.runner.kill})
    rig.run()
    (step,) = [step for step in rig.book.steps if step.event.name == "bob"]
    assert step.why.startswith("nobody called 'bob' can hold control")


def test_a_handover_that_is_never_acknowledged_is_a_rejected_start() -> None:
    from tests.rigs.runs import robot

    states = {**DRIVING, "driving": {**DRIVING["driving"], "control": "agent", "handover_s": 3}}
    rig = Rig(states, robot=robot(control={"agent": "/give"}))
    rig.connector.serve("/give", "std_srvs/srv/Trigger", lambda _: {"success": False, "message": "not now"})
    result = rig.run()
    assert result.why == "driving: rejected (agent was not given control in time)" and rig.move.goals == []


def test_an_operator_from_whom_the_robot_does_not_take_control_keeps_it_and_the_start_waits() -> None:
    from tests.rigs.runs import robot

    states = {
        "by_hand": {"control": "operator", "transitions": [{"on": "go", "to": "driving"}]},
        **DRIVING,
        "driving": {**DRIVING["driving"], "control": "autonomy", "handover_s": 3},
    }
    holder = {"topic": "/holder", "type": "std_msgs/msg/String"}
    rig = Rig(states, robot=robot(control={"operator": "/give", "autonomy": "/take"}, holder=holder))

    def hand(to: str) -> dict[str, Any]:
        rig.connector.publish(*holder.values(), {"data": to})
        return {"success": to == "operator", "message": "not now"}

    rig.connector.serve("/give", "std_srvs/srv/Trigger", lambda _: hand("operator"))
    rig.connector.serve("/take", "std_srvs/srv/Trigger", lambda _: {"success": False, "message": "not now"})
    rig.stage.play(
        {0.1: lambda: hand("autonomy"), 1.0: lambda: rig.post("go"), 9.0: lambda: rig.runner.cancel("the test")}
    )
    result = rig.run()
    assert (result.why, result.state) == ("canceled by the test", ("driving",)) and rig.move.goals == []


def test_an_answer_from_outside_counts_like_any_other_and_ends_the_thinking() -> None:
    model = LateAnswerer()
    rig = Rig(ASKING, answerers={"agent": model}, clock=WallClock())
    rig.on_step = lambda step: rig.runner.answer(step.question.number, "left") if step.question else None
    result = rig.run()
    assert result.outcome == "aborted" and model.withdrawn == [1] and not rig.runner.view.thinking


def test_once_it_is_answered_from_outside_no_one_thinks_any_more() -> None:
    waits = {"states": {"w": {"transitions": [{"after_s": 2, "to": "end"}]}}, "initial": "w"}
    rig = Rig({**ASKING, "over": waits, "end": {"final": "aborted"}}, answerers={"agent": LateAnswerer()})
    thinks: list[bool] = []
    rig.stage.play(
        {
            0.1: lambda: thinks.append(rig.runner.view.thinking),
            0.2: lambda: rig.runner.answer(1, "left"),
            1.0: lambda: thinks.append(rig.runner.view.thinking),
        }
    )
    assert rig.run().outcome == "aborted" and thinks == [True, False]


def test_an_answer_to_a_question_that_no_one_asks_is_stale() -> None:
    rig = Rig(ASKING, answerers={"agent": LateAnswerer()}, clock=WallClock())

    def act(step: Any) -> None:
        if step.question:
            rig.runner.answer(step.question.number + 7, "left")
            rig.runner.answer(step.question.number, "left")
            rig.runner.answer(step.question.number, "right")

    rig.on_step = act
    assert rig.run().outcome == "aborted"
    assert [step.event.number for step in rig.stale()] == [8]


def test_what_comes_after_the_end_does_not_change_what_the_status_reports_about_it() -> None:
    chart, life = Chart(mission(ASKING)), Lifecycle()

    def seen(step: Step) -> Status | None:
        return life.observe(step, chart)

    seen(chart.start(0.0))
    ended = seen(chart.send(Event("cancel", 1.0, {"by": "Ann"}, "command")))
    assert ended is not None and (ended.outcome, ended.why) == ("canceled", "canceled by Ann")
    late = chart.send(Event("go", 2.0))
    assert late.why == "the mission has ended"
    assert seen(late) is None


def test_the_status_has_a_revision_that_grows_with_each_change() -> None:
    seen: list[Status] = []
    rig = Rig(DRIVING, on_status=seen.append)
    rig.stage.play(
        {
            1.0: rig.runner.pause,
            2.0: rig.runner.resume,
            3.0: lambda: rig.runner.control("operator"),
            4.0: lambda: rig.runner.control("autonomy"),
            5.0: lambda: rig.runner.cancel(),
        }
    )
    rig.run()
    assert [status.revision for status in seen] == list(range(1, len(seen) + 1))
    assert [status.mode for status in seen] == ["running", "paused", "running", "running", "running", "canceled"]
    assert [status.control for status in seen][2:5] == ["autonomy", "operator", "autonomy"]


COMMANDS: dict[str, Callable[[Rig], object]] = {
    "pause": lambda rig: rig.runner.pause(),
    "resume": lambda rig: rig.runner.resume(),
    "cancel": lambda rig: rig.runner.cancel(),
    "kill": lambda rig: rig.runner.kill(),
    "take": lambda rig: rig.runner.control("operator"),
    "give": lambda rig: rig.runner.control("autonomy"),
    "event": lambda rig: rig.post("go"),
    "end": lambda rig: rig.turn.goals and rig.turn.report("succeeded"),
    "die": lambda rig: rig.move.goals and rig.move.report("failed"),
}


@given(st.lists(st.tuples(st.integers(0, 80), st.sampled_from(sorted(COMMANDS))), max_size=12))
def test_whatever_is_commanded_the_run_ends_and_no_goal_outlives_it(script: list[tuple[int, str]]) -> None:
    seen: list[Status] = []
    rig = Rig(
        mission({**DRIVING, "driving": {**DRIVING["driving"], "timeout_s": 4}}, on_cancel="turning", cancel_s=3),
        on_status=seen.append,
    )
    for tenth, name in script:
        rig.stage.play({tenth / 10: lambda name=name: COMMANDS[name](rig)})
    rig.stage.play({20.0: rig.runner.kill})
    result = rig.run()
    ended = [goal for server in (rig.move, rig.turn) for goal in server.goals]
    canceled = {*rig.move.canceled, *rig.turn.canceled}
    reported = {"end", "die"} & {name for _, name in script}
    assert reported or set(ended) == canceled, "every goal was canceled"
    assert rig.runner.view.awaited_goals == 0
    assert result.outcome in MODES and seen[-1].mode == result.outcome
    assert [step.seq for step in rig.book.steps] == sorted({step.seq for step in rig.book.steps})


def test_an_operator_who_takes_control_of_a_paused_run_leaves_what_was_kept_going() -> None:
    from tests.rigs.runs import ROBOT, robot

    keeps = robot(actions={**ROBOT["actions"], "move": {**ROBOT["actions"]["move"], "keep": True}})
    rig = Rig(DRIVING, robot=keeps)
    rig.stage.play(
        {
            1.0: rig.runner.pause,
            2.0: lambda: rig.runner.control("operator"),
            3.0: lambda: rig.move.canceled and rig.runner.kill("it was canceled"),
            4.0: lambda: rig.runner.control("autonomy"),
            5.0: rig.runner.resume,
            6.0: lambda: rig.runner.cancel("the test"),
        }
    )
    result = rig.run()
    assert result.why == "canceled by the test" and len(rig.move.goals) == 1


def test_the_status_has_the_active_states_in_the_order_of_the_hierarchy() -> None:
    states = {
        "zoo": {"initial": "yard", "states": {"yard": {"parallel": {
            "west": {"initial": "z1", "states": {"z1": {}}}, "east": {"initial": "a1", "states": {"a1": {}}}}}}},
    }  # fmt: skip
    seen: list[tuple[str, ...]] = []
    rig = Rig(mission(states), on_status=lambda status: seen.append(status.active))
    rig.stage.play({1.0: rig.runner.kill})
    rig.run()
    assert ("zoo", "yard", "west", "z1", "east", "a1") in seen
