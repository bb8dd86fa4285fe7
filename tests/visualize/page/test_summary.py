# SPDX-License-Identifier: Apache-2.0
"""The summary of a mission: as text for those that are shipped, and its laws for any."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.states import Final
from tests.strategies import missions
from tests.visualize.runs import ROOT, document, tractor
from tests.visualize.test_stored import compare, shipped
from visualize.page.decision_sites import questions
from visualize.page.summary import MissionSummary, summary

STORED = Path(__file__).parent / "stored"


def as_text(given: MissionSummary) -> Iterator[str]:
    """The summary line by line, as a reader meets it."""
    yield given.purpose
    yield from (f"never false: {each.name}: {each.guard}" for each in given.invariants)
    yield given.asked
    for each in given.decisions:
        yield f"  {each.state}{'' if each.by_model else ' (no model)'}: “{each.question}”; {each.asked}; {each.silence}"
        yield from (f"    {option.name} → {option.leads}, {option.bound}" for option in each.options)
    yield from given.outcomes
    for end in given.ends:
        yield f"{end.outcome} {end.state} – {end.about}" + ("; a model's answer alone" if end.by_answer else "")
        yield from (f"    when {cause.text}" for cause in end.causes)
        yield from (f"      before: {cause.text}" for cause in end.before)
        yield from (f"    done there: {each}" for each in end.does)
        yield from (f"    proved by: {each}" for each in end.proof)
    yield from (f"from any state: {each}" for each in given.interruptions)
    yield from (fact.text for fact in given.controllers)


def _name(path: Path) -> str:
    return path.parent.name if path.stem == "mission" else f"{path.parent.name}_{path.stem}"


@pytest.mark.parametrize("path", shipped(), ids=_name)
def test_the_summary_of_a_shipped_mission_reads_as_it_was_looked_at(path: Path) -> None:
    text = "\n".join((*as_text(summary(load(path))), ""))
    compare(STORED / f"{_name(path)}_summary.txt", text.encode())


@given(missions())
def test_every_decision_end_and_invariant_is_in_the_summary_and_every_place_is_in_the_mission(mission: Mission) -> None:
    found = summary(mission)
    transitions = dict(mission.every_transition())
    assert [each.state for each in found.decisions] == [site.state for site in questions(mission)]
    assert [each.by_model for each in found.decisions] == ["agent" in site.asked.ask for site in questions(mission)]
    assert {each.state for each in found.ends} == {n for n, s in mission.states.items() if isinstance(s, Final)}
    assert [each.name for each in found.invariants] == list(mission.invariants)
    for end in found.ends:
        into = {place for place, transition in transitions.items() if end.state in transition.to}
        assert {cause.transition for cause in end.causes} - {""} == into
        assert len(end.causes) >= len(into)
        assert {cause.transition for cause in end.before} - {""} <= set(transitions)
    for each, site in zip(found.decisions, questions(mission), strict=True):
        assert [option.name for option in each.options] == list(site.asked.options)
        assert f": {site.asked.fallback or 'failed'} → " in each.silence


def changed(**asked: Any) -> MissionSummary:
    """The tractor's mission with another decision."""
    given = document()
    decision = {**given["states"]["assessing"]["decision"], **asked}
    given["states"]["assessing"]["decision"] = {word: value for word, value in decision.items() if value is not None}
    return summary(Mission.model_validate(given))


def test_the_sentence_of_a_decision_names_its_time_its_fallback_and_where_that_leads() -> None:
    assert changed().decisions[0].silence == "no valid answer within 20 s: abort → aborted (aborted)"
    assert changed(deadline_s=None).decisions[0].silence == "no valid answer: abort → aborted (aborted)"
    unanswered = changed(fallback=None).decisions[0].silence
    assert unanswered == "no valid answer within 20 s: failed → what the states around do"


def test_whom_a_decision_asks_is_reported_in_words_that_are_no_words_of_control() -> None:
    found = changed(ask=["agent", "rules", "night_shift"])
    assert (
        found.decisions[0].asked
        == "asks the model, then the fixed rules, then the answerer 'night_shift'; 2 attempts each"
    )
    assert found.asked.startswith("A model is asked in 1 of ")
    assert changed(ask=["operator"]).asked == "No model is asked anything in this mission."
    assert any(fact.text.startswith("controlled by the mission itself: ") for fact in found.controllers)
    assert not any("agent" in fact.text for fact in found.controllers)


def test_the_success_of_an_action_proves_an_end_only_where_nothing_else_leads_there() -> None:
    given = document()
    proof = {end.state: end.proof for end in summary(Mission.model_validate(given)).ends}["done"]
    assert "drive_alleys has succeeded only when alleys_driven ≥ alleys" in proof
    for transition in given["states"]["working"]["states"]["driving"]["transitions"]:
        if transition["on"] == "succeeded":
            transition["on"] = ["succeeded", "failed"]
    proof = {end.state: end.proof for end in summary(Mission.model_validate(given)).ends}["done"]
    assert not any("drive_alleys" in each for each in proof)


def test_an_end_that_nothing_leads_to_has_no_cause_and_a_cancel_is_one() -> None:
    given = document()
    given["states"]["lost"] = {"final": "failed"}
    assert {end.state: end.causes for end in summary(Mission.model_validate(given)).ends}["lost"] == ()
    given["on_cancel"] = "lost"
    found = summary(Mission.model_validate(given))
    assert [cause.text for cause in {end.state: end for end in found.ends}["lost"].causes] == ["a cancel leads here"]
    assert "cancel: leads to lost" in found.interruptions[-1]
    assert tractor().on_cancel is None


def test_the_answers_in_the_documents_are_those_of_the_page() -> None:
    document_ = (ROOT / "docs/testing/review-page.md").read_text(encoding="utf-8")
    parts = dict(zip(("tractor", "rosbot"), document_.split("\n## ")[1:3], strict=True))
    for name, part in parts.items():
        text = "\n".join(as_text(summary(load(ROOT / f"missions/{name}/mission.json"))))
        answers = [
            line.strip() for block in re.findall(r"```text\n(.*?)```", part, re.DOTALL) for line in block.split("\n")
        ]
        assert len(answers) > 8
        assert [line for line in answers if line not in text] == []


def test_only_the_words_that_a_mission_needs_are_explained() -> None:
    assert summary(tractor()).words == ("model", "rules", "mission")
    plain = {"format": 1, "name": "m", "initial": "a", "states": {"a": {"transitions": [{"after_s": 1, "to": "b"}]},
             "b": {"final": "aborted"}}}  # fmt: skip
    assert summary(Mission.model_validate(plain)).words == ()
    asked = {"decision": {"question": "?", "options": {"x": {}}, "ask": ["operator", "rules"], "fallback": "x"},
             "transitions": [{"on": "x", "to": "b"}]}  # fmt: skip
    assert summary(Mission.model_validate(plain | {"states": {**plain["states"], "a": asked}})).words == ("rules",)
