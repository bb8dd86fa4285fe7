# SPDX-License-Identifier: Apache-2.0
"""Time, and many runs: simulated hours in seconds, real time while someone thinks, nothing left behind."""

from __future__ import annotations

import gc
import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine.decision import Question
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.profile import dump_profile
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import SimulatedClock, WallClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner
from tests.rigs.journals import steps_of
from tests.rigs.runs import ManualServer, ReplyingAnswerer, Rig, ScriptedWorld, asking, mission, robot

CALLING: dict[str, Any] = {
    "calling": {"call": "horn", "timeout_s": 5, "transitions": [{"on": "succeeded", "to": "over"}]},
    "over": {"final": "aborted"},
}
ASKING = asking(deadline_s=20)


def test_two_hours_go_by_and_every_minute_is_kept() -> None:
    states = {
        "watching": {
            "transitions": [
                {"after_s": 60, "to": "watching", "do": [{"set": "count", "add": 1}, {"call": "horn"}]},
                {"on": "stop_now", "to": "over"},
            ]
        },
        "over": {"final": "aborted"},
    }
    rig = Rig(
        mission(states, transitions=[{"when": {"key": "count", ">=": 120}, "to": "over"}]), clock=SimulatedClock()
    )
    result = rig.run()
    assert result.duration_s == 7_200.0
    assert [at for at, _ in rig.called] == [60.0 * minute for minute in range(1, 120)] + [7_200.0]


def test_two_hours_of_a_stepped_world_go_by_too() -> None:
    rig = Rig({"waiting": {"transitions": [{"after_s": 7_200, "to": "over"}]}, "over": {"final": "aborted"}})
    assert rig.run().duration_s == 7_200.0 and rig.stage.steps == 72_000


class Thinker:
    """Answers from a thread of its own after so many seconds of the wall."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self.threads: list[threading.Timer] = []

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.threads.append(threading.Timer(self._seconds, lambda: answer({"option": "left"})))
        self.threads[-1].start()

    def withdraw(self, number: int) -> None:
        self.threads[-1].cancel()


@pytest.mark.parametrize("stepped", [True, False])
def test_while_someone_thinks_simulated_time_goes_no_faster_than_the_wall(stepped: bool) -> None:
    rig = Rig(ASKING, answerers={"agent": Thinker(0.3)}, clock=None if stepped else SimulatedClock())
    began = time.monotonic()
    result = rig.run()
    took = time.monotonic() - began
    assert result.outcome == "aborted", "the answer came in time"
    assert 0.2 <= result.duration_s <= took + 0.101


def test_a_world_that_falls_behind_does_not_catch_up_at_the_cost_of_who_thinks() -> None:
    rig = Rig(ASKING, answerers={"agent": Thinker(0.9)})
    rig.stage.play({0.1: lambda: threading.Event().wait(0.6)})
    result = rig.run()
    assert result.outcome == "aborted" and result.duration_s < 0.65, "0.6 of 0.9 s were the world's own"


def test_once_no_one_thinks_time_flies_again() -> None:
    states = {
        **ASKING,
        "over": {"states": {"w": {"transitions": [{"after_s": 3600, "to": "end"}]}}, "initial": "w"},
        "end": {"final": "aborted"},
    }
    rig = Rig(states, answerers={"agent": Thinker(0.05)})
    began = time.monotonic()
    assert rig.run().duration_s >= 3600 and time.monotonic() - began < 10.0


def test_simulated_time_has_a_speed_of_its_own_if_wanted() -> None:
    rig = Rig(
        {"waiting": {"transitions": [{"after_s": 2, "to": "over"}]}, "over": {"final": "aborted"}},
        clock=SimulatedClock(ScriptedWorld(), speed=10.0),
    )
    began = time.monotonic()
    rig.run()
    assert 0.15 <= time.monotonic() - began <= 1.5


def test_rules_answer_at_once() -> None:
    assert Rig(ASKING, answerers={"agent": ReplyingAnswerer("left")}).run().duration_s == 0.0


ROUND_AND_ROUND: dict[str, Any] = {
    "busy": {
        "initial": "asking",
        "states": {"asking": {**ASKING["asking"], "transitions": [{"on": "left", "to": "calling"}]},
                   "calling": {"call": "horn", "timeout_s": 5, "transitions": [{"on": "succeeded", "to": "asking"}]}},
        "transitions": [{"after_s": 3, "to": "over"}],
    },
    "over": {"final": "aborted"},
}  # fmt: skip


@pytest.mark.parametrize("clock", [None, SimulatedClock(), SimulatedClock(ScriptedWorld(), speed=20.0)])
def test_a_mission_whose_answers_lead_round_for_ever_in_an_instant_still_comes_to_its_timer(clock: Any) -> None:
    rig = Rig(ROUND_AND_ROUND, answerers={"agent": ReplyingAnswerer("left")}, clock=clock)
    result = rig.run()
    assert result.outcome == "aborted" and result.duration_s == pytest.approx(3.0, abs=0.21)
    assert len(rig.called) > 100


ROUND_IN_A_TREE: dict[str, Any] = {
    "busy": {"tree": {"repeat": -1, "child": {"call": "horn", "timeout_s": 5}}, "transitions": [
        {"on": "succeeded", "to": "over"}, {"after_s": 3, "to": "over"}]},
    "over": {"final": "aborted"},
}  # fmt: skip


def test_a_tree_whose_calls_are_answered_in_an_instant_comes_to_its_timer() -> None:
    rig = Rig(ROUND_IN_A_TREE)
    result = rig.run()
    assert result.outcome == "aborted" and result.duration_s == pytest.approx(3.0, abs=0.21)
    assert 1000 < len(rig.called) < 5000


def test_rounds_that_have_no_room_in_a_step_take_no_time() -> None:
    inner = {"repeat": 1000, "child": {"set": "count", "add": 1}}
    ends = [{"on": "succeeded", "to": "over"}, {"after_s": 3, "to": "late"}]
    states = {
        "busy": {"tree": {"repeat": 35, "child": inner}, "transitions": ends},
        "over": {"final": "aborted"},
        "late": {"final": "failed"},
    }
    rig = Rig(states)
    assert (rig.run().outcome, rig.runner.view.at) == ("aborted", 0.0)
    assert rig.runner.view.board["count"].value == 35_000
    assert [step.resting for step in rig.steps] == [*[("busy",)] * 3, ()]


def test_a_burst_that_came_in_one_instant_is_taken_in_one_instant() -> None:
    transitions = [{"on": "go", "do": [{"set": "count", "add": 1}]}, {"on": "stop_now", "to": "over"}]
    states = {"counting": {"transitions": transitions}, "over": {"final": "aborted"}}
    rig = Rig(states)
    rig.stage.play({1.0: lambda: [rig.post(name) for name in [*["go"] * 1000, "stop_now"]]})
    assert rig.run().duration_s == 1.0 and rig.runner.view.board["count"].value == 1000


def test_while_someone_thinks_what_leads_round_for_ever_does_not_make_time_fly() -> None:
    thinking = {"initial": "asking", "states": {**ASKING, "over": {}, "lost": {}}}
    rounds = {"initial": "calling", "states": {
        "calling": {**CALLING["calling"], "transitions": [{"on": "succeeded", "to": "again"}]},
        "again": {"transitions": [{"when": {"key": "count", "==": 0}, "to": "calling"}]}}}  # fmt: skip
    both = {"both": {"parallel": {"thinks": thinking, "turns": rounds}, "transitions": [
        {"when": {"in": "over"}, "to": "done"}, {"when": {"in": "lost"}, "to": "late"}]},
        "done": {"final": "aborted"}, "late": {"final": "failed"}}  # fmt: skip
    began = time.monotonic()
    result = Rig(both, answerers={"agent": Thinker(0.3)}).run()
    assert result.outcome == "aborted" and result.duration_s <= time.monotonic() - began + 0.101


def test_an_idle_run_on_the_wall_clock_uses_no_processor() -> None:
    rig = Rig(
        {"waiting": {"transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}}, clock=WallClock()
    )
    used: list[float] = []
    started = threading.Event()
    rig.on_step = lambda step: started.set()

    def wait_and_post() -> None:
        started.wait(5.0)
        before = time.process_time()
        threading.Event().wait(0.3)
        used.append(time.process_time() - before)
        rig.post("go")

    thread = threading.Thread(target=wait_and_post)
    thread.start()
    rig.run()
    thread.join()
    assert used[0] < 0.03, "a tenth of one processor would be a poll"


@pytest.mark.parametrize(
    "many", [8, pytest.param(20, marks=pytest.mark.long), pytest.param(100, marks=pytest.mark.drill)]
)
def test_many_missions_share_one_connector_that_was_started_before(many: int) -> None:
    rig = Rig(CALLING, clock=WallClock())
    rig.connector.start()
    threads, before = threading.active_count(), runners()
    for number in range(many):
        result = Runner(mission(CALLING), robot=robot(), connector=rig.connector).run()
        assert result.outcome == "aborted", number
    assert len(rig.called) == many and rig.connector.running
    assert threading.active_count() == threads
    assert runners() <= before + 1, "runs leave nothing behind"


def runners() -> int:
    """The runners that are alive, those that other tests have left included."""
    gc.collect()
    return sum(isinstance(each, Runner) for each in gc.get_objects())


def test_two_runs_at_once_do_not_receive_each_other() -> None:
    rigs = [
        Rig(mission(CALLING if n else ASKING), clock=WallClock(), answerers={"agent": Thinker(0.1)})
        for n in (0, 1, 0, 1)
    ]
    results: dict[int, Result] = {}
    threads = [
        threading.Thread(target=lambda n=n, rig=rig: results.__setitem__(n, rig.run())) for n, rig in enumerate(rigs)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert [results[n].outcome for n in range(4)] == ["aborted"] * 4
    assert [len(rig.called) for rig in rigs] == [0, 1, 0, 1]
    assert len({results[n].run for n in range(4)}) == 4


def test_two_runs_share_one_connector_at_once() -> None:
    first = Rig(ASKING, clock=WallClock(), answerers={"agent": Thinker(0.1)})
    first.connector.start()
    second = Runner(mission(CALLING), robot=robot(), connector=first.connector)
    results: list[Result] = []
    thread = threading.Thread(target=lambda: results.append(first.run()))
    thread.start()
    assert second.run().outcome == "aborted"
    thread.join(10.0)
    assert results[0].outcome == "aborted" and first.connector.running


SCRIPT = st.lists(
    st.tuples(
        st.integers(1, 60),
        st.sampled_from(
            [
                "go",
                "again",
                "stop_now",
                "pause",
                "resume",
                "there",
                "battery",
                "reported",
                "left",
                "lost",
                "operator",
                "autonomy",
            ]
        ),
    ),
    max_size=14,
)


@given(SCRIPT)
def test_a_replayed_run_is_the_run(tmp_path_factory: pytest.TempPathFactory, script: list[tuple[int, str]]) -> None:
    states = {
        "idle": {
            "transitions": [{"on": "go", "to": "moving"}, {"on": "again", "to": "asking"}, {"after_s": 7, "to": "over"}]
        },
        "moving": {
            "control": "autonomy",
            "action": "move",
            "timeout_s": 2,
            "achieved": {"key": "there", "==": True},
            "settle_s": 0.5,
            "transitions": [
                {"when": {"held": {"key": "battery", "<": 0.5}, "for_s": 1}, "to": "looking"},
                {"on": ["succeeded", "failed", "unverified", "timed_out", "rejected"], "to": "idle"},
            ],
        },
        "looking": {
            "tree": {"sequence": [{"call": "horn", "timeout_s": 1}, {"wait_s": 0.7}]},
            "timeout_s": 3,
            "transitions": [{"on": ["succeeded", "failed", "timed_out"], "to": "idle"}],
        },
        "asking": {**ASKING["asking"], "transitions": [{"on": "left", "to": "idle"}, {"on": "right", "to": "moving"}]},
        "over": {"final": "aborted"},
    }
    made = mission(states)
    path = tmp_path_factory.mktemp("run") / "run.journal"
    with Journal.create(path, Header(dump(made), dump_profile(robot()), {})) as journal:
        rig = Rig(made, journal=journal)
        does: dict[str, Callable[[], object]] = {
            "pause": rig.runner.pause,
            "resume": rig.runner.resume,
            "there": lambda: rig.publish("/there", data=True),
            "battery": lambda: rig.publish("/battery", percentage=0.3),
            "reported": lambda: rig.move.goals and rig.move.report("succeeded"),
            "lost": lambda: rig.move.goals and rig.move.report("lost"),
            "left": lambda: rig.runner.answer(2, "left"),
            "operator": lambda: rig.runner.control("operator"),
            "autonomy": lambda: rig.runner.control("autonomy"),
        }
        for tenth, name in script:
            rig.stage.play({tenth / 10: does.get(name, lambda name=name: rig.post(name))})
        rig.stage.play({20.0: rig.runner.kill})
        result = rig.run()
    again = replay(path)
    assert again.holds, again.difference
    assert (again.outcome, again.why) == (result.outcome, result.why)
    written = steps_of(path)
    assert [step for step in rig.steps if step.seq in {each.seq for each in written}] == written


def test_the_mailbox_gives_the_urgent_first_and_the_rest_in_order() -> None:
    mailbox = Mailbox()
    for number in range(3):
        mailbox.post(Event(str(number)))
    mailbox.wait(None)
    mailbox.post_urgent(Event("kill"))
    assert [event.name for event in iter(mailbox.take, None)] == ["kill", "0", "1", "2"] and mailbox.empty


def test_what_was_put_back_is_waited_for_by_no_one() -> None:
    mailbox, began = Mailbox(), time.monotonic()
    mailbox.put_back([Event("go")])
    mailbox.wait(20.0)
    assert time.monotonic() - began < 10 and mailbox.take() == Event("go")


def test_a_wait_for_centuries_is_no_fault() -> None:
    mailbox = Mailbox()
    threading.Timer(0.05, lambda: mailbox.post(Event("go"))).start()
    WallClock().wait(mailbox, 1e300, paced=False)
    assert mailbox.take() == Event("go")


def test_simulated_time_does_not_move_past_a_waiting_event() -> None:
    mailbox, clock = Mailbox(), SimulatedClock()
    mailbox.post(Event("go"))
    clock.wait(mailbox, 10.0, paced=False)
    assert clock.now() == 0.0
    mailbox.take()
    clock.wait(mailbox, 10.0, paced=False)
    assert clock.now() == 10.0
    threading.Timer(0.02, lambda: mailbox.post(Event("go"))).start()
    clock.wait(mailbox, math.inf, paced=False)
    assert clock.now() == 10.0


def test_a_server_double_is_a_server() -> None:
    server = ManualServer("accepted", "succeeded")
    lines: list[str] = []
    server.accept("a", {}, lambda report: lines.append(report.status))
    assert lines == ["accepted", "succeeded"]
