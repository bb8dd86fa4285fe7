# SPDX-License-Identifier: Apache-2.0
"""What was seen in systems where a model owns its mission, and must not happen here: each is tried end to end."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from langchain_core.messages import AIMessage
from langchain_core.tools import StructuredTool
from pydantic import SecretStr

from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.replay import replay
from rai_missions.runtime.result import Result
from rai_missions.testing import (
    BabblingModel,
    ChatteringAnswerer,
    HangingModel,
    LateAnswerer,
    LyingModel,
    RaisingModel,
    ScriptedModel,
    SilentAnswerer,
    SilentModel,
    ToolFloodModel,
    WordyModel,
    call,
)
from tests.answerers.messages import ANY_CALL, TEXTS
from tests.rigs.runs import KEYS, Rig, mission, robot

SECRET = "sk-proj-Zk3mQ9vT7wXyB2nC5dF8hJ1lP4rS6uA0"
CROSS = '{"option": "cross"}'
DEADLINE_S, SHORT_S = 30.0, 0.6
"""The deadline where an answer comes, so that a busy machine does not answer for it; and where none comes."""


def missions(**decision: Any) -> Mission:
    """Something is in the way; anyone who is asked may have it crossed, left, or ended."""
    keys = {**KEYS, "low": {"type": "boolean", "source": "robot", "max_age_s": 1}}
    asked = {
        "question": "Something is in the way. What now?",
        "evidence": ["low"],
        "options": {"cross": {"when": {"key": "low", "==": True}}, "leave": {}, "finish": {}},
        "ask": ["agent"],
        "attempts": 2,
        "deadline_s": DEADLINE_S,
        "fallback": "leave",
        **decision,
    }
    states = {
        "asking": {
            "decision": asked,
            "transitions": [
                {"on": "stop_now", "to": "elsewhere"},
                {"on": "cross", "to": "crossing"},
                {"on": "leave", "to": "left"},
                {"on": "finish", "to": "done"},
            ],
        },
        "crossing": {
            "action": "move",
            "timeout_s": 2,
            "achieved": {"key": "there", "==": True},
            "transitions": [
                {"on": "succeeded", "to": "done"},
                {"on": ["failed", "unverified", "timed_out"], "to": "left"},
            ],
        },
        "elsewhere": {
            "decision": {**asked, "question": "And now?", "ask": ["script"], "deadline_s": 0.3},
            "transitions": [
                {"on": "cross", "to": "crossing"},
                {"on": "leave", "to": "left"},
                {"on": "finish", "to": "done"},
            ],
        },
        "done": {"final": "succeeded", "requires": {"key": "there", "==": True}},
        "left": {"final": "aborted"},
    }
    return mission(states, blackboard=keys)


def rig(agent: Any, *, low: bool = True, **words: Any) -> Rig:
    """A run in which the robot reports whether what lies there is low, ten times a second."""
    profile = robot()
    source = {"topic": "/low", "type": "std_msgs/msg/Bool"}
    profile = robot(blackboard={**{name: one.written() for name, one in profile.blackboard.items()}, "low": source})
    decision = words.pop("decision", {})
    answerers = {"agent": agent, **words.pop("answerers", {})}
    made = Rig(missions(**decision), robot=profile, answerers=answerers, **words)
    made.stage.each = lambda: made.connector.publish("/low", "std_msgs/msg/Bool", {"data": low})
    return made


def notes(made: Rig) -> list[str]:
    return [note for step in made.book.steps for note in step.notes]


def asked(model: DoubleModel, **words: Any) -> tuple[Result, Rig]:
    agent = DecisionAgent(model, tools=words.pop("tools", ()))
    made = rig(agent, **words)
    try:
        return made.run(), made
    finally:
        agent.stop(0.0)


def test_a_model_that_reports_the_mission_is_complete_is_not_believed() -> None:
    result, made = asked(LyingModel())
    assert result.outcome == "aborted" and made.entered[-1] == "left"
    result, made = asked(ScriptedModel(['{"option": "finish", "why": "mission complete"}']))
    assert (result.outcome, made.entered[-1]) == ("failed", "done"), "it may go there, and there a fact decides"
    assert result.why == "'done' was reached, but 'there is true' is unknown (there was never heard)"


def test_a_success_takes_the_action_and_the_fact() -> None:
    model = ScriptedModel([CROSS])
    agent = DecisionAgent(model)
    made = rig(agent)
    made.move.at_once = ("accepted", "succeeded")
    made.stage.play({0.0: lambda: made.publish("/there", data=True)})
    assert made.run().outcome == "succeeded"


def test_an_option_that_was_not_offered_is_refused_and_the_model_is_reported() -> None:
    model = ScriptedModel([CROSS, '{"option": "leave"}'])
    _, made = asked(model, low=False)
    assert made.move.goals == []
    question = next(step.question for step in made.steps if step.question)
    assert [offer.name for offer in question.options] == ["leave", "finish"]
    assert any("'cross' was not offered; offered: leave, finish" in note for note in notes(made))


def test_a_guard_that_no_longer_holds_when_the_answer_arrives_refuses_it() -> None:
    late = LateAnswerer()
    made = rig(late, decision={"deadline_s": 5.0, "attempts": 1})
    made.stage.each = lambda: made.connector.publish("/low", "std_msgs/msg/Bool", {"data": made.stage.at < 0.2})
    made.stage.play({0.4: lambda: late.answer(1, {"option": "cross"})})
    made.run()
    assert made.move.goals == []
    assert any("the guard of 'cross' no longer holds" in note for note in notes(made))


def test_a_guard_that_rests_on_a_reading_gone_stale_refuses_too() -> None:
    late = LateAnswerer()
    made = rig(late, decision={"deadline_s": 5.0, "attempts": 1})
    made.stage.each = lambda: (
        made.stage.at < 0.15 and made.connector.publish("/low", "std_msgs/msg/Bool", {"data": True})
    )
    made.stage.play({1.3: lambda: late.answer(1, {"option": "cross"})})
    made.run()
    assert made.move.goals == []
    assert any("the guard of 'cross' is unknown now" in note for note in notes(made))


def test_of_two_answers_to_one_question_one_acts() -> None:
    made = rig(ChatteringAnswerer([{"option": "cross"}, {"option": "leave"}, {"option": "cross"}]))
    made.stage.play({1.0: lambda: made.move.report("failed")})
    made.run()
    assert len(made.move.goals) == 1 and made.entered == ["asking", "crossing", "left"]
    assert [step.event.data["option"] for step in made.stale()] == ["leave", "cross"]


def test_a_late_answer_does_nothing_in_another_state() -> None:
    late = LateAnswerer()
    made = rig(late, answerers={"script": SilentAnswerer()})
    made.stage.play({0.1: lambda: made.post("stop_now"), 0.2: lambda: late.answer(1, {"option": "cross"})})
    made.run()
    assert late.withdrawn == [1] and made.move.goals == []
    assert made.entered == ["asking", "elsewhere", "left"], "the fallback of the other question"
    assert [step.why for step in made.stale()] == ["stale: question 1 is no longer asked"]


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (RaisingModel(), "the model raised RuntimeError: the model is overloaded"),
        (RaisingModel(SystemExit(3)), "the model raised SystemExit"),
        (RaisingModel(KeyboardInterrupt()), "the model raised KeyboardInterrupt"),
        (SilentModel(), "answered nothing"),
        (WordyModel(), "answered with 1000019 characters"),
        (ToolFloodModel(), "calls of tools"),
        (LyingModel(), ""),
    ],
)
def test_a_model_that_fails_leads_to_the_fallback(model: DoubleModel, message: str) -> None:
    result, made = asked(model)
    assert result.outcome == "aborted" and made.entered[-1] == "left"
    assert any(message in note for note in notes(made)), notes(made)
    verdicts = [verdict for step in made.book.steps for verdict in step.verdicts]
    assert any((verdict.kind, verdict.option) == ("fallback", "leave") for verdict in verdicts)


@pytest.mark.parametrize("model", [HangingModel(), BabblingModel()])
def test_a_model_that_never_comes_to_an_end_is_left_at_the_deadline(model: Any) -> None:
    began = time.monotonic()
    result, made = asked(model, decision={"deadline_s": SHORT_S})
    assert made.entered[-1] == "left" and time.monotonic() - began < 5.0
    if isinstance(model, HangingModel):
        assert result.duration_s == pytest.approx(0.1 + SHORT_S, abs=0.11)
        model.release()
    else:
        assert model.ended.wait(5.0), "its stream is ended"


def test_while_a_model_hangs_the_mission_continues() -> None:
    model = HangingModel()
    agent = DecisionAgent(model)
    made = rig(agent, answerers={"script": SilentAnswerer()})
    made.stage.play({0.2: lambda: made.post("stop_now")})
    result = made.run()
    assert result.duration_s == pytest.approx(0.5, abs=0.21) and made.entered == ["asking", "elsewhere", "left"]
    model.release()
    agent.stop()


def test_a_model_that_asks_for_thousands_of_tools_has_none_of_them_run() -> None:
    ran: list[int] = []
    look = StructuredTool.from_function(
        lambda: str(ran.append(1)), name="look", description="Look.", metadata={"read_only": True}
    )
    _, made = asked(ToolFloodModel(), tools=[look], decision={"tools": ["look"]})
    assert ran == [] and made.entered[-1] == "left"


def test_a_model_cannot_have_a_robot_do_several_things_with_one_answer() -> None:
    flood = AIMessage("", tool_calls=[call("cross", "1"), call("finish", "2"), call("leave", "3")])
    _, made = asked(ScriptedModel([flood, flood], profile={"tool_calling": True, "structured_output": False}))
    assert made.move.goals == [] and made.entered[-1] == "left"


@pytest.mark.parametrize("end", ["failed", "canceled", "lost", "rejected"])
def test_an_action_that_does_not_succeed_never_looks_like_one_that_did(end: str) -> None:
    model = ScriptedModel([CROSS])
    agent = DecisionAgent(model)
    made = rig(agent)
    made.move.at_once = ("rejected",) if end == "rejected" else ("accepted", end)
    result = made.run()
    assert result.outcome != "succeeded" and "done" not in made.entered


def test_an_action_that_the_facts_contradict_is_unverified() -> None:
    made = rig(DecisionAgent(ScriptedModel([CROSS])))
    made.move.at_once = ("accepted", "succeeded")
    assert made.run().outcome == "aborted"
    assert any("the server said succeeded, but 'there is true' is unknown" in note for note in notes(made))


def test_a_timeout_leaves_no_action_running_and_a_cancel_before_acceptance_is_not_lost() -> None:
    made = rig(DecisionAgent(ScriptedModel([CROSS])))
    made.move.at_once = ()
    made.stage.play({3.5: lambda: made.move.goals and made.move.report("accepted")})
    result = made.run()
    assert made.entered[-1] == "left" and result.outcome == "aborted"
    assert made.move.canceled == made.move.goals != []


def test_an_event_that_nothing_handles_is_in_the_journal(tmp_path: Path) -> None:
    late = LateAnswerer()
    path = tmp_path / "run.journal"
    with Journal.create(path, Header(dump(missions()), "", {})) as journal:
        made = rig(late, journal=journal)
        made.stage.play(
            {0.2: lambda: made.post("again", reason="none"), 0.3: lambda: late.answer(1, {"option": "leave"})}
        )
        made.run()
    with read(path) as record:
        (step,) = [step for step in record.steps() if step.event.name == "again"]
    assert step.ignored and step.event.data == {"reason": "none"}


class AnyModel(DoubleModel):
    """Reports what hypothesis makes up: text, calls, exceptions, again and again."""

    api_key: SecretStr = SecretStr(SECRET)
    script: list[Any]

    def reply_to(self, messages: list[Any]) -> Any:
        reported = self.script.pop(0) if self.script else "no more"
        if isinstance(reported, Exception):
            raise reported
        if isinstance(reported, dict):
            return AIMessage(f"I think {SECRET}", tool_calls=[reported])
        return reported.replace("KEY", SECRET)


RAISED = st.sampled_from([RuntimeError(f"401: {SECRET}"), ValueError("no"), NotImplementedError(), RecursionError()])
OPTION = st.sampled_from([CROSS, '{"option": "finish"}', '{"option": "leave"}', '{"option": "done"}'])
TALK = TEXTS | TEXTS.map(lambda text: f"KEY {text}") | OPTION | ANY_CALL | RAISED
PROFILES = st.sampled_from(
    [
        {},
        {"tool_calling": False, "structured_output": False},
        {"tool_calling": True, "structured_output": False},
    ]
)


@given(
    st.lists(TALK, max_size=6),
    PROFILES,
    st.booleans(),
    st.booleans(),
    st.sampled_from(["succeeded", "failed", "lost"]),
)
def test_whatever_a_model_reports_facts_decide_the_run_ends_and_no_key_leaks(
    tmp_path_factory: pytest.TempPathFactory,
    script: list[Any],
    profile: dict[str, bool],
    low: bool,
    there: bool,
    server: str,
) -> None:
    path = tmp_path_factory.mktemp("hostile") / "run.journal"
    agent = DecisionAgent(AnyModel(script=script, profile=profile))
    with Journal.create(path, Header(dump(missions()), dump_profile(robot()), {})) as journal:
        made = rig(agent, low=low, journal=journal)
        made.move.at_once = ("accepted", server)
        made.stage.play({0.05: lambda: there and made.publish("/there", data=True)})
        result = made.run()
    agent.stop()
    assert (result.outcome == "succeeded") <= there, "only a fact makes a success"
    assert low or made.move.goals == [], "what was not offered was not done"
    assert result.duration_s <= DEADLINE_S + 2.0 + 5.0
    written = b"".join(file.read_bytes() for file in path.parent.iterdir())
    assert SECRET.encode() not in written
    assert threading.active_count() < 50
    assert replay(path).holds
