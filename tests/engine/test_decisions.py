# SPDX-License-Identifier: Apache-2.0
"""Whatever answers a question, the mission goes only where its graph allows, now."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step, Withdraw
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from tests.rigs.charts import mission, sent, ticked, transition

BOARD = {
    "height": {"type": "number", "source": "robot", "max_age_s": 2},
    "size": {"type": "integer", "source": "answer"},
}


def asking(**words: Any) -> dict[str, Any]:
    decision = {
        "question": "What now?",
        "evidence": ["height"],
        "options": {
            "over": {"when": {"key": "height", "<": 1}}, "around": {}, "grow": {"parameters": SIZED}, "stop": {},
        },
        "ask": ["agent", "rules"], "attempts": 2, "deadline_s": 20, "fallback": "stop", **words,
    }  # fmt: skip
    transitions = [
        transition("over", "crossed"),
        transition("around", "gone"),
        transition("stop", "halt"),
        transition("e", "left"),
    ]
    transitions.append(transition("grow", "grown", when={"key": "answer.size", "<": 5}))
    return {
        "ask": {"decision": decision, "transitions": transitions},
        "crossed": {}, "gone": {}, "grown": {}, "left": {"transitions": [transition("e", "ask")]},
        "halt": {"final": "aborted"},
    }  # fmt: skip


SIZED = {
    "type": "object",
    "properties": {"size": {"type": "integer"}},
    "required": ["size"],
    "additionalProperties": False,
}


def asked(height: float | None = 0.5, **words: Any) -> tuple[Chart, Question]:
    made = Chart(mission(asking(**words), blackboard=BOARD))
    if height is not None:
        made.write("height", height, 0.0)
    question = made.start(0.0).question
    assert question is not None
    return made, question


def answers(made: Chart, number: int, option: Any = None, at: float | None = None, **data: Any) -> Step:
    reported = {"option": option, **data} if option is not None else data
    return made.send(Event("agent", made.at if at is None else at, reported, "proposal", number))


def offered(question: Question) -> list[str]:
    return [offer.name for offer in question.options]


def test_an_option_is_offered_only_while_its_guard_is_true() -> None:
    assert offered(asked(0.5)[1]) == ["over", "around", "grow", "stop"]
    assert offered(asked(2.0)[1]) == ["around", "grow", "stop"]
    assert offered(asked(None)[1]) == ["around", "grow", "stop"]


def test_an_accepted_option_is_the_decision_s_outcome() -> None:
    made, question = asked()
    step = answers(made, question.number, "over")
    assert step.entered == ("crossed",)
    assert step.notes == (f"question {question.number}: agent proposed 'over': accepted",)


def test_an_option_that_was_not_offered_is_not_carried_out() -> None:
    made, question = asked()
    step = answers(made, question.number, "fly")
    assert made.active == {"ask"}
    assert step.question is not None and step.question.attempt == 2
    assert step.question.refused == ("'fly' was not offered; offered: over, around, grow, stop",)


def test_an_option_whose_guard_no_longer_holds_when_it_arrives_is_not_carried_out() -> None:
    made, question = asked()
    made.write("height", 3.0, 1.0)
    step = answers(made, question.number, "over")
    assert made.active == {"ask"}
    assert step.question is not None and "over" not in offered(step.question)


def test_an_option_whose_fact_went_stale_meanwhile_is_not_carried_out() -> None:
    made, question = asked()
    step = answers(made, question.number, "over", at=2.0)
    assert made.active == {"ask"} and "is unknown now" in step.notes[0]


def test_only_one_of_two_answers_to_a_question_acts() -> None:
    made, question = asked()
    answers(made, question.number, "around")
    step = answers(made, question.number, "over")
    assert step.ignored and step.why == f"stale: question {question.number} is no longer asked"
    assert made.active == {"gone"}


def test_a_late_answer_does_not_act_in_another_state_nor_in_the_same_one_entered_again() -> None:
    made, question = asked()
    assert Withdraw(question.number) in sent(made, "e", at=1.0).effects
    assert answers(made, question.number, "around").ignored
    again = sent(made, "e").question
    assert again is not None and again.number != question.number
    assert answers(made, question.number, "around").ignored and made.active == {"ask"}


def test_an_absent_answerer_is_skipped_at_once_and_the_next_is_asked() -> None:
    made, question = asked()
    step = answers(made, question.number, absent="no model")
    assert step.question is not None and step.question.asked == "rules" and step.at == 0.0


def test_a_failing_answerer_is_asked_as_often_as_attempts_reports_then_the_next() -> None:
    made, question = asked()
    second = answers(made, question.number, failed="boom").question
    assert second is not None and (second.asked, second.attempt) == ("agent", 2)
    third = answers(made, second.number, failed="boom").question
    assert third is not None and (third.asked, third.attempt) == ("rules", 1)


@given(
    listed=st.sets(st.sampled_from("abc")),
    given_=st.dictionaries(st.sampled_from("abc"), st.integers(0, 9)),
    in_tree=st.booleans(),
)
def test_an_answer_writes_the_keys_that_its_option_lists_and_no_other(
    listed: set[str], given_: dict[str, int], in_tree: bool
) -> None:
    lists: dict[str, Any] = {"properties": {name: {"type": "integer"} for name in listed}}
    decision = {"question": "?", "options": {"give": {"parameters": lists}, "stop": {}},
                "ask": ["agent"], "deadline_s": 5, "fallback": "stop"}  # fmt: skip
    does: dict[str, Any] = {"decision": decision}
    ways = [transition("give", "given"), transition("stop", "halt")]
    if in_tree:
        does = {"tree": {"decision": decision, "then": {"give": {"wait_s": 1}, "stop": {"wait_s": 1}}}}
        ways = [transition("succeeded", "given"), transition("failed", "halt")]
    keys = {name: {"type": "integer", "source": "answer"} for name in "abc"}
    halt = {"final": "aborted"}
    states = {"ask": does | {"transitions": ways}, "given": {}, "halt": halt}
    made = Chart(mission(states, blackboard=keys))
    question = made.start(0.0).question
    assert question is not None
    step = answers(made, question.number, "give", parameters=given_)
    assert step.verdict is not None and step.verdict.accepted
    assert dict(step.writes) == {name: value for name, value in given_.items() if name in listed}


def test_when_no_one_gives_an_answer_that_counts_the_fallback_is_taken() -> None:
    made, question = asked(attempts=1)
    second = answers(made, question.number, "fly").question
    assert second is not None
    step = answers(made, second.number, absent="none")
    assert (step.outcome, step.entered) == ("aborted", ("halt",))


def test_an_answerer_that_hangs_has_its_share_of_the_time_and_no_more() -> None:
    made, question = asked()
    assert question.until == 10.0 and made.wake_at == 10.0
    step = ticked(made, 10.0)
    assert step.question is not None and step.question.asked == "rules"
    assert Withdraw(question.number) in step.effects
    assert ticked(made, 20.0).outcome == "aborted"


def test_an_answer_in_the_instant_of_the_deadline_is_too_late() -> None:
    made, question = asked(ask=["agent"])
    assert answers(made, question.number, "around", at=20.0).outcome == "aborted"


def test_parameters_must_fit_their_schema_and_reach_the_transition_and_the_blackboard() -> None:
    made, question = asked()
    again = answers(made, question.number, "grow", parameters={"size": "big"}).question
    assert again is not None and "not valid" in again.refused[0]
    step = answers(made, again.number, "grow", parameters={"size": 3})
    assert step.entered == ("grown",) and ("size", 3) in step.writes


def test_the_evidence_reports_how_old_it_is_and_what_is_unknown() -> None:
    made, question = asked()
    assert question.evidence[0].words() == "height: 0.5, 0.0 s old"
    again = answers(made, question.number, failed="x", at=3.2).question
    assert again is not None and again.evidence[0].words() == "height: unknown, 3.2 s old"


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=30),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=12), inner, max_size=3),
    max_leaves=8,
)
words = st.sampled_from(["over", "around", "grow", "stop", "succeeded", "failed", "crossed", "e"]) | st.text(
    max_size=20
)


@given(
    st.lists(
        st.dictionaries(
            st.sampled_from(["option", "parameters", "why", "absent", "failed"]), anything | words, max_size=4
        ),
        max_size=12,
    )
)
def test_no_proposal_moves_the_mission_off_its_options(proposals: list[dict[str, Any]]) -> None:
    made, question = asked()
    allowed = {"ask", "crossed", "gone", "grown", "halt"}
    for data in proposals:
        step = made.send(Event("agent", made.at, data, "proposal", question.number))
        if step.question is not None:
            question = step.question
        assert made.active <= allowed and len(made.active) == 1
        assert made.outcome in (None, "aborted") or made.why == "ask: grow"
        if step.entered == ("crossed",):
            assert data.get("option") == "over"
    ticked(made, 100.0)
    assert made.active != {"ask"}


UNHANDLED = asking()
IN_A_TREE = {
    "ask": {
        "tree": {
            "decision": {
                "question": "What now?", "options": {"grow": {"parameters": SIZED}, "stop": {}}, "ask": ["agent"],
                "fallback": "stop",
            },
            "then": {"grow": {"call": "horn"}, "stop": {"call": "horn"}},
        },
        "timeout_s": 20,
    },
    "gone": {},
}  # fmt: skip


@pytest.mark.parametrize("states", [UNHANDLED, IN_A_TREE])
def test_the_reason_of_an_answer_is_in_its_event_alone(states: dict[str, Any]) -> None:
    """Else a model's claim would be why the mission ended, or a remark of the engine."""
    results = []
    for reason in ("", "I have arrived at the dock."):
        made = Chart(mission(states, blackboard=BOARD), CompiledTrees())
        question = made.start(0.0).question
        assert question is not None
        step = made.propose(question.number, "grow", {"size": 7}, why=reason)
        assert step.verdict is not None and step.verdict.accepted and step.event.data.get("why", "") == reason
        results.append((step._replace(event=Tick(0.0)), made.snapshot()))
    assert results[0] == results[1]


@pytest.mark.parametrize("other", [{}, {"entry": [{"raise": "e", "after_s": 2}]}])
def test_at_one_instant_timers_come_before_the_deadline_of_a_question_whatever_else_is_due(
    other: dict[str, Any],
) -> None:
    asked = {"question": "Well?", "options": {"x": {"about": "x"}}, "fallback": "x", "ask": ["rules"], "deadline_s": 2}
    inside = {
        "a": {"decision": asked, "transitions": [transition("x", "b"), transition(to="c", after_s=2)]},
        "b": {},
        "c": {},
    }
    regions = {"r1": {"initial": "s", "states": {"s": other}}, "r2": {"initial": "a", "states": inside}}
    made = Chart(mission({"p": {"parallel": regions}}))
    made.start(0.0)
    assert "c" in made.send(Tick(2.0)).entered
