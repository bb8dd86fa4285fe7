# SPDX-License-Identifier: Apache-2.0
"""Rules answer by the first row that holds now and is offered; scripts by what is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.answerers.rules import RulesAnswerer
from rai_missions.answerers.script import ScriptAnswerer
from rai_missions.engine.decision import Question
from rai_missions.guards import Compare, Fresh, Guard, Named, Not
from rai_missions.guards.view import Truth
from rai_missions.keys import Blackboard, Key, Stamped
from rai_missions.testing import QUESTION, ReplyCollector, answer_fault, check_answerer

KEYS = {"height": Key(float, source="robot", max_age_s=1)}
LOW = Compare(key="height", less=0.2)


@dataclass
class Seen:
    """What is known in a test."""

    at: float = 0.0
    board: Blackboard = field(default_factory=dict)
    active: frozenset[str] = frozenset()
    entered: Mapping[str, float] = field(default_factory=dict)
    true_since: Mapping[str, float] = field(default_factory=dict)
    event: Mapping[str, Any] = field(default_factory=dict)
    answer: Mapping[str, Any] = field(default_factory=dict)

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        raise RuntimeError("no such predicate")

    def note(self, text: str) -> None:
        return None


def answered(rows: list[tuple[Guard | None, str]], seen: Seen, question: Question = QUESTION) -> Mapping[str, Any]:
    reported = ReplyCollector()
    RulesAnswerer({"assessing": rows}, keys=KEYS, view=seen).ask(question, reported)
    (reply,) = reported.all
    assert not answer_fault(reply)
    return reply


guards = st.sampled_from([None, LOW, Not(LOW), Fresh("height"), Not(Fresh("height"))])
options = st.sampled_from(["replan", "signal", "abort", "fly"])


@given(st.lists(st.tuples(guards, options), max_size=5), st.none() | st.sampled_from([0.1, 0.2, 0.9]), st.floats(0, 2))
def test_the_first_row_that_is_true_and_offered_answers(rows: list[Any], height: float | None, age: float) -> None:
    board = {} if height is None else {"height": Stamped(height, 0.0)}
    fresh = height is not None and age < 1
    low = height < 0.2 if fresh and height is not None else None
    holds = {
        None: True,
        LOW: low,
        Not(LOW): None if low is None else not low,
        Fresh("height"): fresh,
        Not(Fresh("height")): not fresh,
    }
    expected = next((option for guard, option in rows if holds[guard] is True and option != "fly"), None)
    assert answered(rows, Seen(at=age, board=board)).get("option") == expected


def test_a_rule_reports_which_it_was() -> None:
    seen = Seen(board={"height": Stamped(0.1, 0.0)})
    assert answered([(LOW, "fly"), (LOW, "signal"), (None, "abort")], seen) == {
        "option": "signal",
        "parameters": {},
        "why": "rule 2 of 'assessing': height < 0.2",
    }
    assert answered([(None, "abort")], seen)["why"] == "rule 1 of 'assessing': always"


def test_a_stale_reading_takes_no_row() -> None:
    seen = Seen(at=1.0, board={"height": Stamped(0.1, 0.0)})
    assert answered([(LOW, "signal")], seen) == {"absent": "no rule for this in 'assessing'"}


def test_a_leaf_of_a_tree_is_answered_by_the_rules_of_its_state() -> None:
    assert answered([(None, "abort")], Seen(), QUESTION._replace(owner="assessing#0.1"))["option"] == "abort"


def test_a_state_without_rules_finds_them_absent() -> None:
    assert answered([], Seen()) == {"absent": "no rules for 'assessing'"}


def test_a_predicate_that_raises_fails_the_answer_alone() -> None:
    assert answered([(Named("is_low"), "abort")], Seen()) == {
        "failed": "a rule for 'assessing' raised RuntimeError: no such predicate"
    }


@pytest.mark.parametrize("rows", [[], [(None, "abort")]])
def test_rules_keep_the_contract(rows: list[tuple[Guard | None, str]]) -> None:
    check_answerer(lambda: RulesAnswerer({"assessing": rows}, view=Seen()))


def test_a_script_is_followed_and_then_absent() -> None:
    script, reported = ScriptAnswerer({"assessing": ["replan", {"failed": "a cold"}, None]}), ReplyCollector()
    for number in range(4):
        script.ask(QUESTION._replace(number=number), reported)
    script.withdraw(2)
    assert reported.all == [
        {"option": "replan", "parameters": {}, "why": "scripted"},
        {"failed": "a cold"},
        {"absent": "the script has nothing more for 'assessing'"},
    ]
    assert [question.number for question in script.asked] == [0, 1, 2, 3]
    assert script.withdrawn == (2,)


def test_a_script_keeps_the_contract() -> None:
    check_answerer(lambda: ScriptAnswerer({"assessing": ["abort"]}))
