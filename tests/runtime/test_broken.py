# SPDX-License-Identifier: Apache-2.0
"""What breaks around a run: journals, connectors, servers, observers, answerers; the robot is never left alone."""

from __future__ import annotations

import copy
import enum
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Reply, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.engine.step import StartGoal
from rai_missions.errors import ConnectorError, DefinitionError
from rai_missions.journal import Header, Journal, read
from rai_missions.replay.rebuild import mission_of
from rai_missions.testing import ChatteringAnswerer, RaisingAnswerer
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import KEYS, Rig, asking, mission, robot

MOVING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "to": "moving"}]},
    "moving": {
        "action": "move",
        "timeout_s": 5,
        "transitions": [{"on": "succeeded", "to": "over"}, {"on": "again", "to": "idle"}],
    },
    "over": {"final": "aborted"},
}
CALLING: dict[str, Any] = {
    "calling": {
        "call": "horn",
        "timeout_s": 2,
        "transitions": [
            {"on": "succeeded", "to": "over"},
            {"on": "failed", "to": "lost"},
            {"on": "rejected", "to": "nobody"},
            {"on": "timed_out", "to": "late"},
        ],
    },
    "over": {"final": "aborted"},
    "lost": {"final": "failed"},
    "nobody": {"final": "failed"},
    "late": {"final": "failed"},
}
ASKING = asking(attempts=3, deadline_s=30)


@pytest.fixture(autouse=True)
def _quiet_logs(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)


@pytest.mark.parametrize("rows", range(6))
def test_a_journal_that_is_full_stops_the_robot(rows: int) -> None:
    rig = Rig(MOVING, journal=MemoryJournal(rows))
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            2.0: lambda: rig.move.goals and rig.move.report("feedback"),
            3.0: lambda: rig.post("stop_now"),
            4.0: lambda: rig.post("stop_now"),
        }
    )
    result = rig.run()
    assert result.outcome == "aborted" and result.why == "e-stop by the journal: the disk is full"
    assert rig.move.canceled == rig.move.goals
    started = [step for step in rig.book.steps if any(isinstance(effect, StartGoal) for effect in step.effects)]
    assert len(rig.move.goals) == len(started), "what is not written down is not done"


def test_a_journal_that_raises_anything_else_stops_the_robot_too() -> None:
    rig = Rig(MOVING)

    def fail(step: Any) -> None:
        raise RuntimeError("no such type")

    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            2.0: lambda: setattr(rig.book, "on_write", fail),
            2.5: lambda: rig.post("stop_now"),
        }
    )
    assert rig.run().why == "e-stop by the journal: no such type" and rig.move.canceled == rig.move.goals


def test_a_journal_that_fails_in_a_kill_does_not_undo_it() -> None:
    rig = Rig(MOVING, journal=MemoryJournal(4))
    rig.stage.play({1.0: lambda: rig.post("go"), 2.0: rig.runner.kill})
    result = rig.run()
    assert result.why.startswith("e-stop by") and rig.move.canceled == rig.move.goals != []


class Connector(LocalConnector):
    """A connector of which one method is another's; the rest is as ever."""

    def __init__(self, **methods: Callable[..., Any]) -> None:
        super().__init__(now=lambda: 0.0)
        for name, method in methods.items():
            setattr(self, name, method)


def fails(*_: Any, **__: Any) -> None:
    raise RuntimeError("the wire is cut")


def test_a_connector_that_raises_is_a_rejected_start() -> None:
    rig = Rig(MOVING, connector=Connector(send_goal=fails))
    rig.stage.play({1.0: lambda: rig.post("go")})
    assert rig.run().why == "moving: rejected (RuntimeError: the wire is cut)"


class Unspeakable(Exception):
    """One that cannot state what it is."""

    def __str__(self) -> str:
        raise RuntimeError("not even that")


class Unspoken(RaisingAnswerer):
    """Raises that when it is asked."""

    def ask(self, question: Any, answer: Any) -> None:
        raise Unspeakable


def unspeakable(*_: Any, **__: Any) -> None:
    raise Unspeakable


def test_an_exception_that_cannot_be_reported_in_words_is_one_like_any_other() -> None:
    asking = Rig(ASKING, answerers={"agent": Unspoken()})
    assert asking.run().outcome == "failed" and asking.entered[-1] == "lost"
    calling = Rig(CALLING, connector=Connector(call=unspeakable))
    calling.run()
    assert calling.entered == ["calling", "nobody"]
    source = {"service": "/state", "type": "t", "every_s": 0.5}
    profile = robot(events={"go": source, "again": {"posted": True}, "stop_now": {"posted": True}})
    polling = Rig(MOVING, connector=Connector(call=unspeakable), robot=profile)
    polling.stage.play({2.0: polling.runner.kill})
    assert polling.run().duration_s == 2.0


def exits(*_: Any, **__: Any) -> None:
    raise SystemExit(0)


def test_a_connector_that_exits_ends_no_run() -> None:
    source = {"service": "/state", "type": "t", "every_s": 0.5}
    profile = robot(
        events={"go": source, "again": {"posted": True}, "stop_now": {"posted": True}}, alive={"topic": "/alive"}
    )
    polling = Rig(MOVING, connector=Connector(call=exits, publish=exits, stop=exits), robot=profile)
    polling.stage.play({2.0: polling.runner.kill})
    assert polling.run().duration_s == 2.0
    calling = Rig(CALLING, connector=Connector(call=exits))
    calling.run()
    assert calling.entered == ["calling", "nobody"]
    sending = Rig(MOVING, connector=Connector(send_goal=exits))
    sending.stage.play({1.0: lambda: sending.post("go")})
    assert sending.run().why == "moving: rejected (SystemExit: 0)"
    canceling = Rig(MOVING, connector=Connector(cancel_goal=exits))
    canceling.stage.play({1.0: lambda: canceling.post("go"), 2.0: lambda: canceling.runner.cancel()})
    assert canceling.run().outcome == "canceled"


@pytest.mark.parametrize("name", ["start", "subscribe"])
def test_a_connector_that_exits_as_the_run_begins_is_named(name: str) -> None:
    rig = Rig(MOVING, connector=Connector(**{name: exits}))
    with pytest.raises(ConnectorError, match="the robot cannot be reached: Connector raised SystemExit: 0"):
        rig.run()


def test_a_connector_that_raises_is_a_rejected_call() -> None:
    rig = Rig(CALLING, connector=Connector(call=fails))
    rig.run()
    assert rig.entered[-1] == "nobody"


def test_a_connector_that_raises_at_a_cancel_leaves_an_orphan_that_is_written_down() -> None:
    rig = Rig(MOVING, connector=Connector(cancel_goal=fails))
    rig.stage.play({1.0: lambda: rig.post("go"), 2.0: lambda: rig.runner.cancel()})
    assert rig.run().outcome == "canceled"
    assert any("orphaned" in note for step in rig.book.steps for note in step.notes)


def test_a_connector_that_raises_at_a_poll_is_a_robot_not_received(caplog: pytest.LogCaptureFixture) -> None:
    source = {"service": "/state", "type": "t", "every_s": 0.5, "when": {"key": "message", "==": "WAITING"}}
    profile = robot(events={"go": source, "again": {"posted": True}, "stop_now": {"posted": True}})
    rig = Rig(MOVING, connector=Connector(call=fails), robot=profile)
    rig.stage.play({5.0: rig.runner.kill})
    assert rig.run().duration_s == 5.0
    assert len([record for record in caplog.records if "/state" in record.message]) == 1, "logged once, not ten times"


@pytest.mark.parametrize(
    ("answers", "end"),
    [
        ([("succeeded", {"success": True})] * 3, "over"),
        ([("succeeded", {"success": False, "message": "no"}), ("succeeded", {"success": True})], "lost"),
        ([("timed_out", {})], "late"),
        ([("unavailable", {})], "nobody"),
        ([("no_such_word", {})], "lost"),
        ([("succeeded", {"data": b"\xff", "nan": float("nan")})], "over"),
        ([([], {})], "lost"),
        ([(None, None)], "lost"),
        ([("succeeded", None)], "lost"),
        ([("failed", {"message": "no"}, 10**5000)], "lost"),
        ([("failed", {"message": object()}, [])], "lost"),
        ([("succeeded", {"success": True}, object())], "over"),
        ([], "late"),
    ],
)
def test_a_call_that_is_answered_twice_wrongly_or_never(answers: list[tuple[Any, ...]], end: str) -> None:
    def call(
        service: str, kind: str, request: Any, *, on_reply: Callable[[Reply], None], timeout_s: Any = None
    ) -> None:
        for reported in answers:
            on_reply(Reply(*reported))

    rig = Rig(
        {
            **CALLING,
            "over": {"states": {"waits": {"transitions": [{"after_s": 1, "to": "really_over"}]}}, "initial": "waits"},
            "really_over": {"final": "aborted"},
        },
        connector=Connector(call=call),
    )
    rig.run()
    assert rig.entered[1] == end
    assert len(rig.stale()) == (len(answers) - 1 if end == "over" else 0)


REPORTS = [
    "accepted", "rejected", "feedback", "succeeded", "failed", "canceled", "cancel_rejected", "lost", "exploded",
    "contested", "stray", "over",
]  # fmt: skip


@given(st.lists(st.tuples(st.integers(1, 60), st.integers(0, 3), st.sampled_from(REPORTS)), max_size=15), st.booleans())
def test_whatever_servers_state_a_goal_is_never_another_goals_and_the_run_ends(
    lines: list[tuple[int, int, str]], raw: bool
) -> None:
    """With `raw` the connector passes on what real ones may: late, twice, after the end."""
    goals: list[Callable[..., None]] = []

    def send_goal(action: str, kind: str, goal: Any, *, goal_id: str, on_report: Callable[..., None]) -> None:
        goals.append(lambda word: on_report(Report(goal_id, word, {})))

    rig = Rig(MOVING, connector=Connector(send_goal=send_goal) if raw else None)
    publish = (lambda which, word: goals[which](word)) if raw else (lambda which, word: rig.move.report(word, which))
    for tenth, which, word in lines:
        rig.stage.play(
            {
                tenth / 10: lambda which=which, word=word: (
                    which < (len(goals) if raw else len(rig.move.goals)) and publish(which, word)
                )
            }
        )
    rig.stage.play(
        {0.5: lambda: rig.post("go"), 2.0: lambda: rig.post("again"), 2.5: lambda: rig.post("go"), 9.0: rig.runner.kill}
    )
    result = rig.run()
    assert result.outcome in ("aborted", "failed") and rig.runner.view.awaited_goals == 0
    ends = [step for step in rig.book.steps if step.event.kind == "result" and not step.why.startswith("stale")]
    assert len({step.event.number for step in ends}) == len(ends), "a goal ends once"


def test_what_is_reported_about_another_goal_ends_none() -> None:
    on_report: list[Callable[[Report], None]] = []

    def send_goal(action: str, kind: str, goal: Any, *, goal_id: str, report: Callable[[Report], None]) -> None:
        on_report.append(report)
        report(Report(goal_id, "accepted", {}))

    rig = Rig(MOVING, connector=Connector(send_goal=send_goal, cancel_goal=lambda goal_id: canceled.append(goal_id)))
    canceled: list[str] = []
    rig.stage.play(
        {
            1.0: lambda: rig.post("go"),
            2.0: lambda: on_report[0](Report("0" * 32, "succeeded", {})),
            3.0: rig.runner.kill,
        }
    )
    rig.run()
    assert "over" not in rig.entered
    assert canceled, "it still ran"


@pytest.mark.parametrize(
    "message", [None, 42, "text", [], {"data": object()}, {"data": "true"}, {"data": {"a": 1}}, {"data": float("nan")}]
)
def test_a_message_that_is_not_what_the_profile_reports_is_not_received(message: Any) -> None:
    rig = Rig(MOVING)
    subscribers: list[Any] = []
    on_message = rig.connector.subscribe
    rig.connector.subscribe = lambda topic, kind, callback: (
        subscribers.append((topic, callback)),
        on_message(topic, kind, callback),
    )[1]
    received = type("Heard", (), {"data": message, "at": 0.0, "topic": "/there"})()
    rig.stage.play({1.0: lambda: dict(subscribers)["/there"](received), 2.0: rig.runner.kill})
    assert rig.run().duration_s == 2.0
    assert "there" not in rig.runner.view.board


def test_an_integer_beyond_all_floating_point_numbers_ends_no_run_anyone_who_reports_it() -> None:
    report: Any = {"option": "left", "parameters": {"limit": 10**400}}
    states = {**copy.deepcopy(ASKING), "waiting": {"transitions": [{"after_s": 2, "to": "asking"}]}}
    states["asking"]["decision"]["options"]["left"] = {"parameters": {"properties": {"limit": {"type": "number"}}}}
    keys = {**KEYS, "limit": {"type": "number", "source": "answer", "initial": 1}}
    given = mission(states, initial="waiting", blackboard=keys)
    rig = Rig(given, answerers={"agent": ChatteringAnswerer([report])})
    rig.stage.play({1.0: lambda: rig.publish("/battery", percentage=10**400)})
    assert rig.run().outcome == "failed" and rig.entered[-1] == "lost", "the fallback"
    assert "battery" not in rig.runner.view.board


@pytest.mark.parametrize("observer", ["on_step", "on_status"])
def test_an_observer_that_raises_does_not_end_the_run_and_is_notified_of(
    observer: str, caplog: pytest.LogCaptureFixture
) -> None:
    rig = Rig(MOVING, **{observer: fails})
    rig.stage.play({1.0: lambda: rig.post("go"), 2.0: lambda: rig.move.report("succeeded")})
    assert rig.run().outcome == "aborted"
    assert len([record for record in caplog.records if observer in record.message]) == 1


def test_a_fault_of_the_engine_itself_stops_the_robot_and_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig(
        {
            "moving": {"action": "drive", "timeout_s": 50, "transitions": [{"on": "succeeded", "to": "over"}]},
            "over": {"final": "aborted"},
        }
    )

    def breaks() -> None:
        monkeypatch.setattr(Chart, "send", fails)
        rig.post("go")

    rig.stage.play({3.0: breaks})
    with pytest.raises(RuntimeError, match="the wire is cut"):
        rig.run()
    assert [name for _, name in rig.called] == ["/drive", "/halt"], "the action made of services was ended"
    assert rig.book.notes == ["the run breaks off: RuntimeError: the wire is cut"]
    assert not rig.connector.running


def test_a_connector_that_cannot_start_states_it_and_is_stopped() -> None:
    rig = Rig(MOVING, connector=Connector(start=fails))
    with pytest.raises(RuntimeError, match="the wire is cut"):
        rig.run()


def test_an_answerer_that_raises_has_failed_and_the_next_attempt_is_made() -> None:
    rig = Rig(ASKING, answerers={"agent": RaisingAnswerer()})
    rig.run()
    notes = [note for step in rig.book.steps for note in step.notes]
    assert len([note for note in notes if "RuntimeError: no answerer here" in note]) == 3
    assert rig.entered[-1] == "lost"


@pytest.mark.parametrize(
    "message",
    [
        None,
        42,
        "left",
        [],
        {},
        {"option": None},
        {"option": 3},
        {"option": "up"},
        {"option": "left", "parameters": {"a": 1}},
        {"option": "LEFT"},
        {"option": " left"},
        {"option": "left\x00"},
        {"options": "left"},
        {"option": {"left": 1}},
        {"option": "left", "parameters": {"x": object()}},
        {"option": "left", "why": "x" * 2_000_000},
        {3: 4},
        {"option": "over"},
        {"option": "succeeded"},
        {"option": b"left"},
    ],
)
def test_what_is_no_answer_does_not_count(message: Any) -> None:
    rig = Rig(ASKING, answerers={"agent": ChatteringAnswerer([message])})
    result = rig.run()
    assert rig.entered[-1] == "lost" and result.outcome == "failed", "the fallback"
    assert len([step for step in rig.book.steps if step.question]) == 3, "each attempt was asked"


def test_a_word_of_an_enumeration_is_an_answer_like_any_other(tmp_path: Path) -> None:
    way = enum.Enum("Way", {"LEFT": "left"}, type=str)
    with Journal.create(tmp_path / "run.journal", Header("")) as journal:
        rig = Rig(ASKING, answerers={"agent": ChatteringAnswerer([{"option": way.LEFT}])}, journal=journal)
        assert rig.run().outcome == "aborted"
    assert rig.entered[-1] == "over"


def test_of_two_answers_to_one_question_the_first_counts_and_the_second_is_stale() -> None:
    rig = Rig(
        {
            **ASKING,
            "over": {"states": {"w": {"transitions": [{"after_s": 1, "to": "end"}]}}, "initial": "w"},
            "end": {"final": "aborted"},
        },
        answerers={"agent": ChatteringAnswerer([{"option": "left"}, {"option": "right"}, {"option": "left"}])},
    )
    rig.run()
    assert rig.entered == ["asking", "over", "w", "end"]
    assert [step.event.data["option"] for step in rig.stale()] == ["right", "left"]


def test_a_robot_that_vanishes_during_the_run_is_noticed_by_its_silence() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
    states = {**MOVING, "blind": {"final": "aborted"}}
    rig = Rig(mission(states, blackboard=keys, transitions=[{"when": {"not": {"fresh": "battery"}}, "to": "blind"}]))
    rig.stage.each = lambda: rig.stage.at < 3.05 and rig.publish("/battery", percentage=0.9)
    rig.stage.play({1.0: lambda: rig.post("go")})
    result = rig.run()
    assert result.why == "'blind' was reached" and result.duration_s == pytest.approx(5.0, abs=0.11)
    assert rig.move.canceled == rig.move.goals


@pytest.mark.parametrize(("more", "outcome"), [(0, "canceled"), (1, "failed")])
def test_an_answer_has_a_million_characters_at_most(more: int, outcome: str) -> None:
    empty = {"option": "left", "why": ""}
    why = "x" * (1_000_000 - len(str(empty)) + more)
    states = copy.deepcopy(ASKING)
    states["over"]["final"] = "canceled"
    assert Rig(states, answerers={"agent": ChatteringAnswerer([{**empty, "why": why}])}).run().outcome == outcome


def test_a_journal_of_a_mission_that_is_none_names_its_faults(tmp_path: Path) -> None:
    path = tmp_path / "odd.journal"
    with Journal.create(path, Header('{"name": "odd", "initial": "here", "states": {"here": {"finally": "aborted"}}}')):
        pass
    with read(path) as record, pytest.raises(DefinitionError, match="finally"):
        mission_of(record)
