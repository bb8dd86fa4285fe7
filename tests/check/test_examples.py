# SPDX-License-Identifier: Apache-2.0
"""What `check` lets pass, and where it draws the line, by examples next to the bad missions."""

from __future__ import annotations

import copy
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.bench_check import chart, faulty
from rai_missions.check import Finding, check
from rai_missions.mission.mission import Mission

DESIGN: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "data" / "tractor_design.json").read_text(encoding="utf-8")
)
Change = Callable[[dict[str, Any]], object]


def found(document: dict[str, Any], **words: Any) -> list[Finding]:
    """What is found in a mission, but for the failures that its author leaves to end it: the examples' do."""
    findings = check(Mission.model_validate(document), **words)
    return [each for each in findings if each.rule != "unhandled-failure"]


def rules(change: Change) -> list[str]:
    """The rules that the design's example breaks once it is changed."""
    document = copy.deepcopy(DESIGN)
    change(document)
    return [finding.rule for finding in found(document)]


def transitions(document: dict[str, Any], name: str) -> list[Any]:
    found: list[Any] = document["states"][name]["transitions"]
    return found


def test_the_example_of_the_design_has_no_finding() -> None:
    assert found(DESIGN) == []


def test_the_example_of_the_design_lets_failures_end_it_and_their_author_is_asked_about_it() -> None:
    left = [each.place for each in check(Mission.model_validate(DESIGN)) if each.rule == "unhandled-failure"]
    assert left == [
        "/states/working/states/driving",
        "/states/crossing",
        "/states/replanning",
        "/states/signalling",
        "/states/returning",
    ]


def test_a_failure_that_is_handled_anywhere_around_its_state_ends_nothing() -> None:
    every = ["failed", "timed_out", "rejected", "unverified"]
    for place in (lambda d: d["states"]["working"], lambda d: d, lambda d: d["states"]["working"]["states"]["driving"]):
        document = copy.deepcopy(DESIGN)
        holder = place(document)
        holder["transitions"] = [*holder.get("transitions", []), {"on": every, "to": "aborted"}]
        left = [each.place for each in check(Mission.model_validate(document)) if each.rule == "unhandled-failure"]
        assert "/states/working/states/driving" not in left
        assert (left == []) is (holder is document)


def test_what_an_author_forgets_in_the_example_is_reported_once() -> None:
    assert rules(lambda d: d["states"]["crossing"].pop("timeout_s")) == ["unbounded-action"]
    assert rules(lambda d: d["states"]["done"].pop("requires")) == ["missing-requires"]
    assert rules(lambda d: d["states"]["replanning"].update(transitions=[])) == ["unhandled-success"]
    assert rules(lambda d: transitions(d, "assessing").pop()) == ["unhandled-option"]
    assert rules(lambda d: d["states"]["assessing"]["decision"].pop("fallback")) == ["unbounded-decision"]


def test_a_misspelled_name_is_one_fault_and_hides_no_other() -> None:
    def misspell(document: dict[str, Any]) -> None:
        transitions(document, "replanning")[0]["to"] = "resumee"
        document["states"]["working"]["states"]["driving"]["transitions"][0]["to"] = "asessing"
        document["states"]["working"]["states"]["driving"]["transitions"][0]["on"] = "anomly"
        document["states"]["crossing"]["achieved"]["key"] = "pased"

    assert rules(misspell) == ["unknown-event", "unknown-state", "unknown-key", "unknown-state"]


def test_a_lost_group_of_states_is_reported_by_what_leads_into_it() -> None:
    lost = [
        finding.sentence
        for finding in check(
            Mission.model_validate(json.loads(json.dumps(DESIGN).replace('"to": "assessing"', '"to": "done"')))
        )
        if finding.rule == "unreachable-state"
    ]
    assert [sentence.partition(";")[0] for sentence in lost] == ["nothing leads to 'assessing'"]


FOUNDED: dict[str, Any] = {
    "robot key": {"key": "at_home", "==": True},
    "one of all": {"all": [{"key": "alleys", ">": 1}, {"key": "at_home", "==": True}]},
    "each of any": {"any": [{"key": "at_home", "==": True}, {"key": "passed", "==": True}]},
    "not false": {"not": {"key": "at_home", "==": False}},
    "held": {"held": {"key": "at_home", "==": True}, "for_s": 2},
    "against an argument": {"key": "alleys", "<=": {"key": "alleys_driven"}},
    "not possible": {"not": {"possible": {"key": "at_home", "==": False}}},
    "named with a robot key": {"named": "is_home", "with": {"home": {"from": "at_home"}}},
}
UNFOUNDED: dict[str, Any] = {
    "argument": {"key": "alleys", ">": 1},
    "mission key": {"key": "signals", ">": 1},
    "one branch of any": {"any": [{"key": "at_home", "==": True}, {"key": "signals", ">": 1}]},
    "negated all": {"not": {"all": [{"key": "at_home", "==": True}, {"key": "signals", ">": 1}]}},
    "fresh": {"fresh": "at_home"},
    "not fresh": {"not": {"fresh": "at_home"}},
    "possible": {"possible": {"key": "at_home", "==": True}},
    "against itself": {"key": "alleys_driven", "==": {"key": "alleys_driven"}},
    "always": {"all": []},
    "in": {"in": "returning"},
    "elapsed": {"elapsed_s": 5},
    "named": {"named": "is_home"},
}


@pytest.mark.parametrize("guard", FOUNDED.values(), ids=FOUNDED)
def test_success_may_rest_on_what_the_robot_reported(guard: Any) -> None:
    assert "unfounded-success" not in rules(lambda d: d["states"]["returning"].update(achieved=guard))


@pytest.mark.parametrize("guard", UNFOUNDED.values(), ids=UNFOUNDED)
def test_success_may_not_rest_on_anything_else(guard: Any) -> None:
    assert "unfounded-success" in rules(lambda d: d["states"]["returning"].update(achieved=guard))


@pytest.mark.parametrize(
    ("writes", "result", "founded"),
    [
        ([{"set": "home", "from": "at_home"}], {}, True),
        ([{"set": "home", "value": False}, {"set": "home", "from": "at_home"}], {}, True),
        ([{"set": "home", "value": True}, {"set": "home", "from": "at_home"}], {}, False),
        ([{"set": "home", "value": True}], {}, False),
        ([{"set": "home", "from": "wish"}], {}, False),
        ([{"set": "middle", "from": "at_home"}, {"set": "home", "from": "middle"}], {}, True),
        ([{"set": "middle", "from": "wish"}, {"set": "home", "from": "middle"}], {}, False),
        ([], {"home": "arrived"}, True),
    ],
)
def test_what_the_robot_reported_is_followed_through_copies(
    writes: list[Any], result: dict[str, str], founded: bool
) -> None:
    def copy_keys(document: dict[str, Any]) -> None:
        document["blackboard"]["home"] = document["blackboard"]["middle"] = {"type": "boolean"}
        document["blackboard"]["wish"] = {"type": "boolean", "source": "argument", "initial": True}
        document["states"]["returning"] |= {"entry": writes, "result": result, "achieved": {"key": "home", "==": True}}

    assert ("unfounded-success" in rules(copy_keys)) is not founded


def test_the_result_of_an_outcome_counts_as_reported_by_the_robot_and_an_event_does_not() -> None:
    def copy_payload(document: dict[str, Any], transition: dict[str, Any]) -> None:
        document["blackboard"]["home"] = {"type": "boolean"}
        transition["do"] = [{"set": "home", "from": "event.ok"}]
        document["states"]["returning"]["achieved"] = {"key": "home", "==": True}

    assert "unfounded-success" not in rules(lambda d: copy_payload(d, transitions(d, "crossing")[1]))
    assert "unfounded-success" in rules(
        lambda d: copy_payload(d, d["states"]["working"]["states"]["driving"]["transitions"][0])
    )


def test_a_protective_transition_may_leave_staleness_to_an_outer_transition() -> None:
    blind = {"when": {"key": "battery", "<": 0.1}, "to": "aborted"}
    assert rules(lambda d: transitions(d, "replanning").append(blind)) == []
    assert rules(lambda d: d["transitions"][0].update(when=blind["when"])) == ["endless-cycle", "blind-transition"]


def test_transitions_that_a_state_entered_puts_to_rest_are_no_cycle() -> None:
    low, back = {"key": "battery", "<": 0.5}, {"key": "battery", "<": 0.9}

    def there_and_back(first: Any, second: Any, do: list[Any]) -> Change:
        def change(document: dict[str, Any]) -> None:
            transitions(document, "replanning").append({"when": first, "to": "signalling", "do": do})
            transitions(document, "signalling").append({"when": second, "to": "replanning"})

        return change

    count = {"key": "signals", "<": 3}
    assert rules(there_and_back(low, back, [])) == ["endless-cycle"]
    assert rules(there_and_back(low, {"key": "passed", "==": True}, [])) == ["possible-cycle", "blind-transition"]
    assert rules(there_and_back(low, {"key": "battery", ">": 0.5}, [])) == []
    charged, spent = {"key": "battery", ">": 0.9}, {"any": [back, {"not": {"fresh": "battery"}}]}
    assert rules(there_and_back(charged, spent, [])) == []
    assert rules(there_and_back(low, {"all": [back, {"elapsed_s": 5}]}, [])) == []
    assert rules(there_and_back(low, {"held": back, "for_s": 1}, [])) == []
    assert rules(there_and_back(count, count, [{"set": "signals", "add": 1}])) == []


def test_parallel_regions_wait_for_all_and_their_transitions_are_on_their_own() -> None:
    def region(name: str) -> dict[str, Any]:
        notify = {"call": "notify", "timeout_s": 2, "transitions": [{"on": "succeeded", "to": f"{name}_end"}]}
        return {
            "initial": f"{name}_notify",
            "states": {f"{name}_notify": notify, f"{name}_end": {"final": "succeeded"}},
        }

    def both(document: dict[str, Any], last: list[Any]) -> None:
        document["states"]["both"] = {
            "parallel": {"left": region("left"), "right": region("right")},
            "transitions": last,
        }
        transitions(document, "replanning").append({"on": "failed", "to": ["left_notify", "right_notify"]})

    assert rules(lambda d: both(d, [{"on": "succeeded", "to": "resume"}])) == []
    assert rules(lambda d: both(d, [])) == ["unhandled-success"]


def test_only_registered_predicates_are_known_where_they_are_given() -> None:
    document = copy.deepcopy(DESIGN)
    transitions(document, "crossing").append({"on": "rejected", "when": {"named": "is_dry"}, "to": "assessing"})
    assert found(document) == found(document, named=["is_dry"]) == []
    assert [finding.sentence for finding in found(document, named=["is_wet", "is_dry_2"])] == [
        "no registered predicate 'is_dry'; did you mean 'is_dry_2'?"
    ]


WORDS = st.lists(st.sampled_from(["board", "margin_m", "height_m", "kind"]), unique=True, max_size=3)


@settings(max_examples=30)
@given(WORDS, st.integers(0, 3), st.booleans(), WORDS)
def test_a_predicate_that_cannot_be_called_as_its_guard_calls_it_is_refused(
    takes: list[str], required: int, more: bool, given_words: list[str]
) -> None:
    parameters = [word if at < required else f"{word}=0" for at, word in enumerate(takes)] + ["**more"] * more
    made: dict[str, Any] = {}
    exec(f"def is_dry({', '.join(parameters)}): return True", made)
    document, words = copy.deepcopy(DESIGN), dict.fromkeys(given_words, 1)
    guard = {"named": "is_dry", "with": words}
    transitions(document, "crossing").append({"on": "rejected", "when": guard, "to": "assessing"})
    try:
        made["is_dry"]({}, **words)
    except TypeError:
        called = ", ".join(["board", *(f"{word}=…" for word in given_words)])
        (finding,) = found(document, named={"is_dry": made["is_dry"]})
        assert finding.place.endswith("/when/named") and f"is called with ({called})" in finding.sentence
    else:
        assert found(document, named={"is_dry": made["is_dry"]}) == []


def test_names_that_inclusion_brought_have_their_places_escaped() -> None:
    document = copy.deepcopy(DESIGN)
    document["states"]["dock"] = {
        "initial": "dock/go",
        "states": {"dock/go": {"action": "go", "transitions": [{"on": "succeeded"}]}},
    }
    transitions(document, "replanning").append({"on": "failed", "to": "dock"})
    assert [finding.place for finding in found(document)] == ["/states/dock/states/dock~1go"]


def test_a_generated_chart_has_no_finding_and_its_faults_are_all_reported() -> None:
    assert found(chart(200)) == []
    faults = found(faulty(chart(200)))
    assert {finding.rule for finding in faults} == {"unknown-state", "unknown-key", "unknown-event", "unbounded-action"}


@pytest.mark.long
def test_ten_times_the_states_take_ten_times_as_long_and_not_a_hundred() -> None:
    def seconds(size: int) -> float:
        mission = Mission.model_validate(chart(size))
        begun = time.process_time()
        check(mission)
        return time.process_time() - begun

    assert min(seconds(4_000) for _ in range(2)) < 40 * max(min(seconds(400) for _ in range(3)), 0.002)
