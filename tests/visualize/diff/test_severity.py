# SPDX-License-Identifier: Apache-2.0
"""What a reviewer must not miss is found, weighed and reported first; what tightens raises no alarm."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given

from rai_missions.mission.mission import Mission
from tests.strategies import missions
from tests.visualize.changed import changed
from tests.visualize.runs import document, tractor
from visualize import Difference, difference
from visualize.diff.reachability import Ways, way

Json = dict[str, Any]
Mutation = Callable[[Json], Any]


def compared(change: Mutation) -> Difference:
    new = document()
    change(new)
    return difference(tractor(), Mission.model_validate(new))


def states(new: Json) -> Json:
    found: Json = new["states"]
    return found


def decision(new: Json, **words: Any) -> None:
    states(new)["assessing"]["decision"].update(words)


def drive_over(new: Json) -> Json:
    found: Json = states(new)["assessing"]["decision"]["options"]["drive_over"]
    return found


def transition(new: Json, state: str, index: int) -> Json:
    found: Json = states(new)[state]["transitions"][index]
    return found


def reverse(new: Json) -> None:
    """A new option that leads where another leads."""
    states(new)["assessing"]["decision"]["options"]["reverse"] = {"about": "drive back"}
    states(new)["assessing"]["transitions"].append({"on": "reverse", "to": "replanning"})


def by_hand(new: Json) -> None:
    """Another way to the end, past the drive along the alleys."""
    states(new)["by_hand"] = {"action": "drive", "timeout_s": 9, "transitions": [{"on": "succeeded", "to": "done"}]}
    transition(new, "assessing", 1)["to"] = "by_hand"


MUST_NOT_BE_MISSED: list[tuple[str, Mutation, str, str]] = [
    ("option_added", reverse, "offered", "assessing: a model is newly offered 'reverse'"),
    ("option_guard_gone", lambda new: drive_over(new).pop("when"), "guard",
     "assessing: option 'drive_over': guard removed"),
    ("option_guard_weaker", lambda new: drive_over(new)["when"]["all"].pop(), "guard",
     "assessing: option 'drive_over': guard weakened"),
    ("option_guard_incomparable", lambda new: drive_over(new).update(when={"fresh": "camera"}), "guard",
     "assessing: option 'drive_over': guard changed"),
    ("parameters", lambda new: drive_over(new).update(parameters={"type": "object"}), "asked",
     "assessing: option 'drive_over': 'parameters' changed"),
    ("deadline_grew", lambda new: decision(new, deadline_s=60), "limit", "assessing: 'deadline_s' grew"),
    ("deadline_gone", lambda new: states(new)["assessing"]["decision"].pop("deadline_s"), "limit",
     "assessing: 'deadline_s' removed"),
    ("attempts", lambda new: decision(new, attempts=5), "limit", "assessing: 'attempts' grew"),
    ("budget", lambda new: decision(new, budget={"calls": 99}), "limit", "assessing: 'calls' grew"),
    ("timeout_grew", lambda new: states(new)["crossing"].update(timeout_s=99), "limit", "crossing: 'timeout_s' grew"),
    ("timeout_gone", lambda new: states(new)["crossing"].pop("timeout_s"), "limit", "crossing: 'timeout_s' removed"),
    ("settle", lambda new: new.update(settle_s=9), "limit", "mission: 'settle_s' grew"),
    ("cancel", lambda new: new.update(cancel_s=300), "limit", "mission: 'cancel_s' grew"),
    ("tree_timeout", lambda new: states(new)["signalling"]["tree"]["sequence"][0].update(timeout_s=20), "limit",
     "signalling: tree node 'sequence/0': 'timeout_s' grew"),
    ("invariant_gone", lambda new: new["invariants"].clear(), "proof", "invariant 'nobody_is_driven_over': removed"),
    ("invariant_weaker",
     lambda new: new["invariants"]["nobody_is_driven_over"]["not"]["all"].append({"fresh": "camera"}), "proof",
     "invariant 'nobody_is_driven_over': guard weakened"),
    ("requires", lambda new: states(new)["done"].pop("requires"), "proof", "done: requires removed"),
    ("achieved", lambda new: states(new)["crossing"].pop("achieved"), "proof", "crossing: achieved removed"),
    ("fallback", lambda new: decision(new, fallback="replan"), "fallback", "assessing: fallback changed"),
    ("operator_left_out", lambda new: decision(new, ask=["agent", "rules"]), "asked",
     "assessing: who is asked changed"),
    ("tools", lambda new: decision(new, tools=["look"]), "asked", "assessing: what a model may look with changed"),
    ("way_to_succeeded", by_hand, "success", "by_hand: a new state that leads to 'done'"),
    ("leads_to_succeeded", lambda new: states(new)["crossing"]["transitions"].append({"on": "rejected", "to": "done"}),
     "success", "crossing: a new transition to 'done'"),
    ("final_succeeds", lambda new: states(new)["aborted"].update(final="succeeded"), "success",
     "aborted: the mission can succeed here now"),
    ("control", lambda new: states(new)["crossing"].update(control="autonomy"), "control",
     "crossing: 'control' changed"),
    ("over_orphan", lambda new: states(new)["crossing"].update(over_orphan=True), "control",
     "crossing: 'over_orphan' changed"),
    ("max_age_grew", lambda new: new["blackboard"]["obstacle"].update(max_age_s=5), "trust",
     "key 'obstacle': 'max_age_s' grew"),
    ("max_age_gone", lambda new: new["blackboard"]["battery"].pop("max_age_s"), "trust",
     "key 'battery': 'max_age_s' removed"),
    ("optional", lambda new: new["blackboard"]["battery"].update(optional=True), "trust",
     "key 'battery': 'optional' changed"),
    ("source", lambda new: new["blackboard"]["obstacle"].update(source="mission"), "trust",
     "key 'obstacle': 'source' changed"),
    ("on_cancel", lambda new: new.update(on_cancel="driving"), "transition", "mission: 'on_cancel' changed"),
    ("protective_transition_gone", lambda new: new["transitions"].clear(), "transition", "mission: transition removed"),
    ("protective_transition_narrower", lambda new: new["transitions"][0]["when"]["all"][1]["any"].pop(), "transition",
     "mission: transition 'as soon as': guard narrowed, it fires less often"),
    ("protective_transition_elsewhere", lambda new: new["transitions"][0].update(to="driving"), "transition",
     "mission: transition 'as soon as': 'to' changed"),
    ("self_transition_gone", lambda new: states(new)["crossing"]["transitions"].pop(0), "transition",
     "crossing: transition removed"),
    ("self_transition_weaker", lambda new: transition(new, "crossing", 0).update(when={"fresh": "obstacle"}), "guard",
     "crossing: transition 'as soon as': guard weakened"),
    ("answer_leads_elsewhere", lambda new: transition(new, "assessing", 1).update(to="crossing"), "transition",
     "assessing: transition 'replan': 'to' changed"),
    ("failure_leads_elsewhere", lambda new: transition(new, "crossing", 2).update(to="resume"), "transition",
     "crossing: transition 'failed or unverified or timed_out': 'to' changed"),
    ("failure_continues", lambda new: states(new)["replanning"]["transitions"].append({"on": "failed", "to": "resume"}),
     "transition", "replanning: transition added"),
    ("event_unheard", lambda new: states(new)["working"]["states"]["driving"]["transitions"].pop(0), "transition",
     "driving: transition removed"),
    ("transitions_in_another_order", lambda new: states(new)["crossing"]["transitions"].reverse(), "transition",
     "crossing: transitions are tried in another order"),
    ("something_else", lambda new: states(new)["replanning"].update(action=states(new)["replanning"].pop("call")),
     "form", "replanning: is something else"),
    ("begins_elsewhere", lambda new: new.update(initial="crossing"), "form", "mission: 'initial' changed"),
    ("tree_is_another", lambda new: states(new)["signalling"].update(tree={"wait_s": 9}), "tree",
     "signalling: tree node 'the root': is something else"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "topic", "reported"), [each[1:] for each in MUST_NOT_BE_MISSED],
                         ids=[each[0] for each in MUST_NOT_BE_MISSED])  # fmt: skip
def test_what_a_reviewer_must_not_miss_is_reported_first(change: Mutation, topic: str, reported: str) -> None:
    found = compared(change)
    assert (topic, reported) in [(each.topic, each.sentence) for each in found.safety], "\n".join(found.lines())
    severities = [each.severity for each in found.changes]
    assert severities == sorted(severities, key=("safety", "other").index)
    assert found.lines()[2] == "SAFETY-RELEVANT"
    assert found.picture.notes[0].startswith("for review: ")


def asked_of_people() -> Json:
    old = document()
    decision(old, ask=["operator", "rules"])
    return old


def test_a_model_that_is_newly_asked_is_newly_offered_every_option() -> None:
    found = difference(Mission.model_validate(asked_of_people()), tractor())
    results = [each.sentence for each in found.safety]
    options = document()["states"]["assessing"]["decision"]["options"]
    assert results[:4] == [f"assessing: a model is newly offered '{name}'" for name in options]
    assert "assessing: a model is asked now" in results


TIGHTENS: dict[str, Mutation] = {
    "guard_stronger": lambda new: drive_over(new)["when"]["all"].append({"fresh": "camera"}),
    "deadline_shrank": lambda new: decision(new, deadline_s=10),
    "timeout_shrank": lambda new: states(new)["crossing"].update(timeout_s=3),
    "words": lambda new: new.update(about="otherwise"),
    "invariant_added": lambda new: new["invariants"].update(more={"fresh": "battery"}),
    "transition_that_gives_up": lambda new: new["transitions"].append({"on": "anomaly", "to": "aborted"}),
    "protective_transition_wider": lambda new: new["transitions"][0]["when"]["all"][1]["any"].append(
        {"fresh": "camera"}
    ),
    "model_left_out": lambda new: decision(new, ask=["operator", "rules"]),
    "max_age_shrank": lambda new: new["blackboard"]["battery"].update(max_age_s=1),
    "answer_gives_up": lambda new: transition(new, "assessing", 1).update(to="aborted"),
    "effect": lambda new: transition(new, "assessing", 1).update(do=[{"log": "so be it"}]),
    "event_added": lambda new: new["events"].update(rain={}),
    "key_added": lambda new: new["blackboard"].update(rain={"type": "boolean", "initial": False}),
    "same_guard_in_other_words": lambda new: drive_over(new).update(
        when={"not": {"any": [{"key": "obstacle.living", "==": True}, {"key": "obstacle.height_m", ">=": 0.25}]}}
    ),
}


@pytest.mark.parametrize("change", TIGHTENS.values(), ids=TIGHTENS)
def test_what_tightens_is_reported_but_does_not_alarm(change: Mutation) -> None:
    found = compared(change)
    assert found.changes
    assert found.safety == (), "\n".join(found.lines())


def line(*transitions: tuple[str, str]) -> Mission:
    """A mission of states that continue when they receive `go`."""
    names = dict.fromkeys([*(name for transition in transitions for name in transition)])
    found: Json = {
        name: {"transitions": [{"on": "go", "to": to} for at, to in transitions if at == name]} for name in names
    }
    found |= {"done": {"final": "succeeded"}, "lost": {"final": "failed"}}
    return Mission.model_validate({"name": "line", "events": ["go"], "initial": transitions[0][0], "states": found})


def test_a_way_around_what_every_way_went_through_is_reported() -> None:
    old = line(("ready", "looking"), ("looking", "driving"), ("driving", "done"))
    new = line(("ready", "looking"), ("ready", "driving"), ("looking", "driving"), ("driving", "done"))
    (found,) = (each for each in difference(old, new).safety if each.topic == "success")
    assert found.sentence == "done: can be reached without passing 'looking' now"
    assert found.after == "ready → driving → done"
    assert not [each for each in difference(new, old).changes if each.topic == "success"]


def test_a_way_around_inside_a_state_is_reported_too() -> None:
    """What holds the states succeeds by its own end alone."""

    def inside(*transitions: tuple[str, str]) -> Mission:
        given = line(*transitions).written()
        given["states"] = {
            "whole": {
                "initial": transitions[0][0], "states": given["states"],
                "transitions": [{"on": "succeeded", "to": "end"}],
            },
            "end": {"final": "succeeded"},
        }  # fmt: skip
        return Mission.model_validate({**given, "initial": "whole"})

    old = inside(("ready", "looking"), ("looking", "driving"), ("driving", "done"))
    new = inside(("ready", "looking"), ("ready", "driving"), ("looking", "driving"), ("driving", "done"))
    results = [each.sentence for each in difference(old, new).safety if each.topic == "success"]
    assert results == ["end: can be reached without passing 'looking' now"]


@given(missions())
def test_what_every_way_passes_is_what_no_way_avoids(mission: Mission) -> None:
    ways = Ways(mission)
    for end in sorted(ways.ways()):
        alone = {name for name in way(ways.ways(), end)[:-1] if not ways.roads.states[name].children()}
        assert ways.passed(end) & alone == {name for name in alone if end not in ways.ways(without=name)}


def test_a_state_from_which_it_may_succeed_again_is_reported() -> None:
    old = line(("ready", "driving"), ("driving", "done"), ("ready", "stuck"), ("stuck", "lost"))
    new = line(("ready", "driving"), ("driving", "done"), ("ready", "stuck"), ("stuck", "driving"), ("stuck", "lost"))
    results = [each.sentence for each in difference(old, new).safety if each.topic == "success"]
    assert results == ["stuck: the mission can still succeed from here now"]


def test_nothing_leads_out_of_a_final_at_the_top() -> None:
    """Transitions of the mission are received wherever it is, but for where it has ended."""
    old = line(("ready", "driving"), ("driving", "lost")).written()
    old["events"] = ["go", "again"]
    new = json.loads(json.dumps(old))
    new["transitions"] = [{"on": "again", "to": "done"}]
    ways = Ways(Mission.model_validate(new))
    assert ways.onward["lost"] == ways.onward["done"] == frozenset()
    assert ways.gives_up(("lost",))
    results = [each.sentence for each in difference(*map(Mission.model_validate, (old, new))).safety]
    assert "driving: the mission can still succeed from here now" in results
    assert "lost: the mission can still succeed from here now" not in results


def test_an_option_that_is_gone_is_reported() -> None:
    new = document()
    del states(new)["assessing"]["decision"]["options"]["signal"]
    del states(new)["assessing"]["transitions"][2]
    results = [each.sentence for each in difference(tractor(), Mission.model_validate(new)).changes]
    assert "assessing: option 'signal' removed" in results


def test_an_option_with_another_name_is_a_rename() -> None:
    new = json.loads(json.dumps(document()).replace('"replan"', '"next_alley"').replace(
        '"call": "next_alley"', '"call": "replan"'))  # fmt: skip
    found = difference(tractor(), Mission.model_validate(new))
    renamed = "~ assessing: option 'replan' renamed to 'next_alley': was 'replan'; agent, rules choose by this name"
    assert [str(each) for each in found.safety] == [str(each) for each in found.changes] == [renamed]
    assert found.changes[0].old_place == "/states/assessing/decision/options/replan"
    assert found.changes[0].new_place == "/states/assessing/decision/options/next_alley"


def test_an_option_that_people_alone_are_offered_may_be_called_otherwise() -> None:
    missions = []
    for name in ("replan", "next_alley"):
        new = json.loads(json.dumps(document()).replace('"replan"', f'"{name}"').replace(
            f'"call": "{name}"', '"call": "replan"'))  # fmt: skip
        decision(new, ask=["operator"])
        missions.append(Mission.model_validate(new))
    found = difference(*missions)
    assert [str(each) for each in found.changes] == ["~ assessing: option 'replan' renamed to 'next_alley'"]
    assert found.safety == ()


def test_a_state_that_was_renamed_and_changed_is_both() -> None:
    new = json.loads(json.dumps(document()).replace('"crossing"', '"over"'))
    new["states"]["over"]["timeout_s"] = 90
    found = difference(tractor(), Mission.model_validate(new))
    assert found.renamed == (("crossing", "over"),)
    assert [str(each) for each in found.safety] == ["~ over: 'timeout_s' grew: was 30 s, is now 90 s"]
    assert found.safety[0].old_place == "/states/crossing/timeout_s"
    assert found.safety[0].new_place == "/states/over/timeout_s"
    assert [each.score < 1 for each in found.names] == [True]


def test_something_else_under_another_name_is_no_rename() -> None:
    new = document()
    new["states"]["waiting"] = {"about": "waits", "transitions": [{"on": "anomaly", "to": "aborted"}]}
    del new["states"]["signalling"]
    states(new)["assessing"]["transitions"][2]["to"] = "waiting"
    assert difference(tractor(), Mission.model_validate(new)).renamed == ()


def test_all_of_a_hasty_change_is_found() -> None:
    found = difference(tractor(), changed())
    assert found.renamed == (("replanning", "next_alley"),)
    assert [change.mark for change in found.changes].count("+") == 3
    assert [change.topic for change in found.safety] == ["offered", "guard", "limit", "proof", "trust", "transition"]


def test_a_difference_is_a_value() -> None:
    assert difference(tractor(), changed()) == difference(tractor(), changed())
