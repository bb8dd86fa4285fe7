# SPDX-License-Identifier: Apache-2.0
"""The contracts catch those who break them, and the shipped doubles break what they state."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

import pytest

import rai_missions.testing
from rai_missions.engine.decision import Answerer, Question
from rai_missions.testing import (
    QUESTION,
    ChatteringAnswerer,
    LateAnswerer,
    RaisingAnswerer,
    ReplyCollector,
    SilentAnswerer,
    answer_fault,
    check_agent,
    check_answerer,
)

GOOD: dict[str, Any] = {"option": "abort", "parameters": {}, "why": ""}
USAGE = {"calls": 1, "tokens_in": 0, "tokens_out": 0, "seconds": 0.1, "model": "m"}


@pytest.mark.parametrize("reply", [GOOD, {"absent": "x"}, {"failed": "x", "usage": USAGE}, GOOD | {"usage": USAGE}])
def test_an_answer_of_the_contract_has_no_fault(reply: Any) -> None:
    assert answer_fault(reply) == ""


@pytest.mark.parametrize(
    ("reply", "fault"),
    [
        (None, "an answer is a mapping, not None"),
        ({}, "an answer has one of option, absent, failed; this has none"),
        ({"option": "a", "failed": "b"}, "an answer has one of option, absent, failed; this has option, failed"),
        ({"option": 3}, "'option' is text, not 3"),
        ({"failed": "x", "why": "y"}, "an answer with 'failed' has no 'why'"),
        (GOOD | {"state": "done"}, "an answer with 'option' has no 'state'"),
        (GOOD | {"parameters": []}, "'parameters' is a mapping and 'why' is text"),
        (GOOD | {"parameters": {"x": float("nan")}}, "an answer can be written as JSON in UTF-8"),
        (GOOD | {"why": "\ud800"}, "an answer can be written as JSON in UTF-8"),
        (GOOD | {"looked": [{"tool": "look"}]}, "each of 'looked' has `tool`, `arguments` and `said`"),
        (GOOD | {"looked": "x"}, "each of 'looked' has `tool`, `arguments` and `said`"),
        (GOOD | {"usage": {"calls": 1}}, "'usage' has calls, tokens_in, tokens_out, seconds, model"),
        (GOOD | {"usage": USAGE | {"model": None}}, "usage of model is not None"),
    ],
)
def test_an_answer_of_another_shape_is_reported(reply: Any, fault: str) -> None:
    assert answer_fault(reply).startswith(fault)


class Waiting:
    """Waits inside `ask`, until released."""

    def __init__(self, released: threading.Event) -> None:
        self.released = released

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.released.wait()

    def withdraw(self, number: int) -> None:
        pass


def test_an_answerer_that_breaks_a_promise_does_not_pass() -> None:
    released = threading.Event()
    broken: list[tuple[Callable[[], Answerer], str]] = [
        (lambda: ChatteringAnswerer([GOOD, GOOD]), "a question is answered once, not 2 times"),
        (lambda: ChatteringAnswerer([{"state": "done"}]), "an answer has one of option, absent, failed"),
        (SilentAnswerer, "no answer within 0.01 s"),
        (LateAnswerer, "no answer within 0.01 s"),
        (RaisingAnswerer, "withdraw raises RuntimeError"),
        (lambda: Waiting(released), "ask returns at once"),
    ]
    for make, why in broken:
        with pytest.raises(AssertionError, match=why):
            check_answerer(make, within_s=0.01)
    released.set()


class Lingering:
    """Leaves a thread behind."""

    def __init__(self, released: threading.Event) -> None:
        self.released = released

    def run(self) -> None:
        threading.Thread(target=self.released.wait, name="lingering", daemon=True).start()

    def stop(self) -> None:
        pass


def test_an_agent_that_leaves_a_thread_behind_does_not_pass() -> None:
    released = threading.Event()
    with pytest.raises(AssertionError, match="stop leaves the thread 'lingering' behind"):
        check_agent(lambda: Lingering(released), within_s=0.05)
    released.set()


def test_a_late_answer_comes_when_the_test_states_it_withdrawn_or_not() -> None:
    late, reported = LateAnswerer(), ReplyCollector()
    late.ask(QUESTION, reported)
    late.withdraw(1)
    assert (reported.all, late.withdrawn) == ([], [1])
    late.answer(1, GOOD)
    assert reported.all == [GOOD]
    with pytest.raises(AssertionError, match="question 2 was not asked"):
        late.answer(2, GOOD, within_s=0.01)


def test_everything_shipped_for_tests_is_there_and_loaded_when_used() -> None:
    for name in rai_missions.testing.__all__:
        assert getattr(rai_missions.testing, name) is not None
    assert set(rai_missions.testing.__all__) <= set(dir(rai_missions.testing))
    with pytest.raises(AttributeError, match="no attribute 'check_everything'"):
        _ = rai_missions.testing.check_everything


def test_neither_answerers_nor_contracts_load_langchain() -> None:
    code = (
        "import sys, rai_missions.agents, rai_missions.testing\n"
        "from rai_missions.answerers import OperatorAgent, RulesAnswerer, ScriptAnswerer\n"
        "from rai_missions.testing import check_agent, check_answerer, check_connector\n"
        "assert not [name for name in sys.modules if name.startswith('langchain')]"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
