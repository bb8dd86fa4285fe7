# SPDX-License-Identifier: Apache-2.0
"""A tree's question leaves nothing behind: once it has ended, or is asked again, no answer to it is remembered."""

from __future__ import annotations

from tests.trees.growing import is_true
from tests.trees.test_leaves import Run

ASK = {"decision": {"question": "Which?", "options": {"left": {}, "right": {}}, "ask": ["agent"], "deadline_s": 30,
                    "fallback": "right"}}  # fmt: skip


def test_what_was_answered_is_forgotten_when_its_question_has_ended() -> None:
    runs = [Run({"sequence": [ASK, {"action": "drive"}]}) for _ in range(2)]
    for run, option in zip(runs, ("left", "right"), strict=True):
        assert run.tick().started == ("sequence/0",)
        assert run.tick(1.0, {"sequence/0": option}).started == ("sequence/1",)
    assert runs[0].state == runs[1].state


def test_what_an_answer_had_run_is_forgotten_when_its_question_is_asked_again() -> None:
    run = Run({"repeat": 2, "child": {**ASK, "then": {"left": {"check": is_true("a")}}}})
    run.tick(a=True)
    run.tick(1.0, {"child": "left"}, a=True)
    assert run.tick(2.0, a=True).started == ("child",)
    assert all(memory["status"] != "success" for memory in run.state.nodes.values())
