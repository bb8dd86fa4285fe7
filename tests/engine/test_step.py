# SPDX-License-Identifier: Apache-2.0
"""A step has fields for what became of a proposal, the mode of the run, the holder of control, and refusals."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.compiled.configuration import CompiledMove
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.decision import Verdict
from rai_missions.engine.state import RunState
from rai_missions.engine.step import Step
from rai_missions.event import Event, Tick
from tests.engine.test_decisions import answers, asked, asking
from tests.rigs.charts import mission, transition


def command(name: str, at: float = 0.0) -> Event:
    return Event(name, at, {"by": "operator"}, "command")


class Once(Surroundings):
    """Let the mission begin, and allow no step after that."""

    steps = 0

    def before_move(self, state: RunState, move: CompiledMove) -> bool:
        self.steps += 1
        return self.steps == 1


def test_a_step_that_its_surroundings_do_not_allow_is_not_made_and_ends_the_mission_as_a_cycle() -> None:
    made = Chart(mission({"a": {"transitions": [transition("go", "b")]}, "b": {}}), surroundings=Once())
    made.start(0.0)
    step = made.send(Event("go", 1.0))
    assert (step.outcome, step.entered, step.why) == ("failed", (), "a cycle without end: internal events")


def test_a_proposal_that_counts_has_an_accepted_verdict() -> None:
    made, question = asked()
    step = made.propose(question.number, "around", at=1.0)
    assert step.verdict == Verdict(True, number=question.number, by="agent", option="around", note=0)
    assert step.entered == ("gone",)
    assert step.remarks == ()


def test_a_refused_proposal_has_the_reason_in_its_verdict() -> None:
    made, question = asked(height=2.0)
    verdict = made.propose(question.number, "over", by="operator").verdict
    assert verdict is not None
    assert (verdict.accepted, verdict.kind, verdict.by, verdict.option) == (False, "proposal", "operator", "over")
    assert verdict.why == "'over' was not offered; offered: around, grow, stop"


def test_parameters_travel_with_a_proposal() -> None:
    made, question = asked()
    assert made.propose(question.number, "grow", {"size": 4}).entered == ("grown",)
    made, question = asked()
    verdict = made.propose(question.number, "grow", {"size": "four"}).verdict
    assert verdict is not None
    assert not verdict.accepted
    assert "the parameters of 'grow' are not valid" in verdict.why


@pytest.mark.parametrize(
    ("data", "kind"), [({"absent": "no model"}, "absent"), ({"failed": "it crashed"}, "failed"), ({}, "failed")]
)
def test_an_answer_without_an_option_has_a_verdict_of_its_kind(data: dict[str, Any], kind: str) -> None:
    made, question = asked()
    verdict = answers(made, question.number, **data).verdict
    assert verdict is not None
    assert (verdict.accepted, verdict.kind, verdict.number, verdict.option) == (False, kind, question.number, "")


def test_time_that_is_over_and_the_fallback_are_verdicts_as_well() -> None:
    made, question = asked()
    step = made.send(Tick(10.0))
    assert step.verdict is not None
    assert (step.verdict.kind, step.verdict.by, step.verdict.number) == ("timed_out", "agent", question.number)
    step = made.send(Tick(20.0))
    assert step.verdict is not None
    assert (step.verdict.kind, step.verdict.option, step.verdict.accepted) == ("fallback", "stop", False)
    assert step.notes[step.verdict.note or 0] == "fallback 'stop': the deadline has passed"


def test_a_proposal_that_no_question_waits_for_is_stale() -> None:
    made = Chart(mission(asking()))
    early = made.propose(1, "stop")
    assert (early.refusal, early.mode) == ("not_started", "ready")
    question = made.start(0.0).question
    assert question is not None
    late = made.propose(question.number + 1, "stop")
    assert late.refusal == "stale"
    assert late.verdict is not None
    assert (late.verdict.kind, late.verdict.why) == ("stale", late.why)
    made.propose(question.number, "stop")
    over = made.propose(question.number, "stop")
    assert (over.refusal, over.mode) == ("ended", "aborted")
    assert over.verdict is not None
    assert not over.verdict.accepted


def test_a_proposal_that_is_kept_has_its_verdict_once_it_is_judged() -> None:
    made, question = asked()
    assert made.send(command("pause")).mode == "paused"
    kept = made.propose(question.number, "around")
    assert (kept.kept, kept.verdict) == (True, None)
    step = made.send(command("resume"))
    assert step.mode == "running"
    assert step.verdict is not None
    assert (step.verdict.accepted, step.verdict.number) == (True, question.number)
    assert step.remarks == ("resumed",)


def test_each_step_has_mode_and_holder() -> None:
    made = Chart(mission({"a": {"transitions": [transition("e", "b")]}, "b": {"final": "succeeded"}}))
    seen = [
        made.start(0.0), made.send(Event("e", 0.0, {"by": "x"}, "nonsense")),
        made.send(Event("operator", 1.0, {"by": "operator", "role": "operator"}, "control")),
        made.send(command("pause")),
        made.send(command("pause")), made.send(command("resume")), made.send(command("cancel")),
    ]  # fmt: skip
    assert [step.mode for step in seen] == ["running", "running", "running", "paused", "paused", "running", "canceled"]
    assert [step.holder for step in seen] == ["autonomy"] * 2 + ["operator"] * 5
    assert [step.refusal for step in seen] == ["", "unknown", "", "", "mode", "", ""]


def test_after_an_e_stop_no_one_has_control() -> None:
    made, _ = asked()
    step = made.send(command("kill"))
    assert (step.mode, step.holder, step.outcome) == ("aborted", "nobody", "aborted")


def test_short_steps_have_mode_and_holder_too() -> None:
    """The short way makes steps of its own, with acts and without."""
    transitions = [transition("e", "b", do=[{"set": "n", "add": 1}]), transition("f", "a")]
    states = {"a": {"transitions": transitions}, "b": {"transitions": [transition("e", "a")]}}
    board = {"n": {"type": "number", "source": "mission", "initial": 0}}
    made = Chart(mission(states, blackboard=board))
    made.start(0.0)
    made.send(Event("agent", 0.5, {}, "control"))
    steps = [made.send(Event(name, 1.0)) for name in ("e", "e", "f", "e")]
    assert {(step.mode, step.holder, step.refusal, step.kept) for step in steps} == {("running", "agent", "", False)}
    assert all(type(step) is Step and len(step) == len(Step._fields) for step in steps)
