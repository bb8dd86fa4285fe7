# SPDX-License-Identifier: Apache-2.0
"""One edit a case by which the tractor's mission loses its teeth: none of them may be reported as nothing."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rai_missions.mission.mission import Mission
from tests.visualize.diff.test_severity import Json, Mutation, asked_of_people, decision, drive_over, states, transition
from tests.visualize.runs import ROOT, document, tractor
from visualize import Difference, difference

FORGET = [{"set": "crossings", "value": 0}]


def shipped() -> Json:
    found: Json = json.loads((ROOT / "missions/tractor/mission.json").read_text(encoding="utf-8"))
    return found


def compared(change: Mutation) -> Difference:
    old, new = shipped(), shipped()
    change(new)
    return difference(*map(Mission.model_validate, (old, new)))


@pytest.mark.parametrize(("old", "new", "sort"), [("anomaly", "trouble", "event"), ("battery", "charge", "key")])
def test_a_new_name_for_what_others_know_by_the_old_is_for_review(old: str, new: str, sort: str) -> None:
    other = Mission.model_validate(json.loads(json.dumps(document()).replace(f'"{old}"', f'"{new}"')))
    (found,) = difference(tractor(), other).safety
    assert found.sentence.startswith(f"{sort} '{old}' renamed to '{new}'")
    assert found.before == f"'{old}'; profiles and other systems know it by this name"


def test_a_new_name_for_a_key_of_the_mission_alone_is_not() -> None:
    other = Mission.model_validate(json.loads(json.dumps(document()).replace('"signals"', '"horns"')))
    found = difference(tractor(), other)
    assert [change.topic for change in found.changes] == ["name"]
    assert found.safety == ()


def test_another_name_of_the_mission_is_a_difference() -> None:
    found = compared(lambda new: new.update(name="another"))
    assert [change.sentence for change in found.changes] == ["mission: 'name' changed"]
    assert found.lines()[0].endswith("nothing that diff weighs as safety-relevant, 1 other")


def succeeded(new: Json, state: str) -> Json:
    """The transition of a state that continues after its success."""
    found: Json = next(each for each in states(new)[state]["transitions"] if each.get("on") == "succeeded")
    return found


def horn(new: dict[str, Any]) -> list[Any]:
    found: list[Any] = states(new)["signalling"]["tree"]["sequence"]
    return found


DISARMS: list[tuple[str, Mutation, str, str]] = [
    ("question", lambda new: decision(new, question="All clear, go?"), "asked", "assessing: 'question' changed"),
    ("evidence", lambda new: decision(new, evidence=["signals"]), "asked", "assessing: 'evidence' changed"),
    ("option_means", lambda new: drive_over(new).update(about="the safe one"), "asked",
     "assessing: option 'drive_over': 'about' changed"),
    ("parameters", lambda new: drive_over(new).update(parameters={}), "asked",
     "assessing: option 'drive_over': 'parameters' changed"),
    ("action", lambda new: states(new)["working"]["states"]["driving"].update(action="cross"), "does",
     "driving: 'action' changed"),
    ("call", lambda new: states(new)["replanning"].update(call="carry_on"), "does", "replanning: 'call' changed"),
    ("goal", lambda new: states(new)["crossing"].update(goal={"speed": 9}), "does", "crossing: 'goal' changed"),
    ("request", lambda new: states(new)["replanning"].update(request={"over": True}), "does",
     "replanning: 'request' changed"),
    ("history", lambda new: states(new)["working"]["states"]["resume"].update(history="shallow"), "form",
     "resume: 'history' changed"),
    ("tree_wait", lambda new: horn(new)[1].update(wait_s=0), "tree",
     "signalling: tree node 'sequence/1': 'wait_s' changed"),
    ("tree_timeout", lambda new: horn(new)[0].update(timeout_s=0.001), "limit",
     "signalling: tree node 'sequence/0': 'timeout_s' shrank"),
    ("tree_call", lambda new: horn(new)[0].update(call="wink"), "does",
     "signalling: tree node 'sequence/0': 'call' changed"),
    ("tree_node_gone", lambda new: horn(new).pop(), "tree", "signalling: tree node 'sequence/1': removed"),
    ("tree_node_added", lambda new: horn(new).append({"action": "cross"}), "tree",
     "signalling: tree node 'sequence/2': added"),
    ("counts_no_more", lambda new: states(new)["crossing"].pop("entry"), "effect",
     "crossing: 'entry' changed: 'crossings' is read"),
    ("counts_backwards", lambda new: states(new)["crossing"]["entry"][0].update(add=-1), "effect",
     "crossing: 'entry' changed: 'crossings' is read"),
    ("forgets", lambda new: states(new)["assessing"].update(exit=FORGET), "effect",
     "assessing: 'exit' changed: 'crossings' is read"),
    ("transition_forgets", lambda new: transition(new, "assessing", 1).update(do=FORGET), "effect",
     "assessing: transition 'replan': 'do' changed: 'crossings' is read"),
    ("transition_that_only_forgets",
     lambda new: states(new)["crossing"]["transitions"].append({"after_s": 1, "do": FORGET}), "transition",
     "crossing: transition added"),
    ("halts_no_more", lambda new: states(new)["done"].pop("entry"), "effect",
     "done: 'entry' changed: it is sent to the robot"),
    ("halts_otherwise", lambda new: states(new)["done"]["entry"][0].update(call="carry_on"), "effect",
     "done: 'entry' changed: it is sent to the robot"),
    ("event_received_less_often",
     lambda new: states(new)["working"]["states"]["driving"]["transitions"][0].update(when={"key": "battery", ">": 2}),
     "transition", "driving: transition 'anomaly': guard added"),
    ("raises", lambda new: transition(new, "assessing", 1).update(do=[{"raise": "anomaly"}]), "effect",
     "assessing: transition 'replan': 'do' changed: transitions receive 'anomaly'"),
    ("swallows", lambda new: states(new)["assessing"]["transitions"].append({"on": "e_stop"}), "transition",
     "assessing: transition added, tried before one that it may keep from firing"),
    ("success_leads_elsewhere", lambda new: succeeded(new, "replanning").update(to="crossing"), "transition",
     "replanning: transition 'succeeded': 'to' changed"),
    ("success_unheard", lambda new: states(new)["crossing"]["transitions"].pop(1), "transition",
     "crossing: transition removed"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "topic", "reported"), [each[1:] for each in DISARMS], ids=[each[0] for each in DISARMS]
)
def test_what_disarms_is_for_review(change: Mutation, topic: str, reported: str) -> None:
    found = compared(change)
    assert (topic, reported) in [(each.topic, each.sentence) for each in found.safety], "\n".join(found.lines())


def test_the_list_of_a_loop_is_for_review() -> None:
    def over(key: str) -> Mission:
        given = document()
        given["blackboard"] |= {
            name: {"type": "list", "source": "argument", "initial": []} for name in ("near", "far")
        } | {"now": {"type": "string"}}
        given["states"]["round"] = {
            "each": key, "as": "now", "initial": "ended", "states": {"ended": {"final": "succeeded"}},
            "transitions": [{"on": "succeeded", "to": "done"}],
        }  # fmt: skip
        return Mission.model_validate(given)

    assert [each.sentence for each in difference(over("near"), over("far")).safety] == ["round: 'each' changed"]


def test_what_people_alone_are_asked_is_not() -> None:
    old = asked_of_people()
    new = json.loads(json.dumps(old))
    decision(new, question="What now?", evidence=["signals"])
    drive_over(new)["about"] = "over it"
    found = difference(*map(Mission.model_validate, (old, new)))
    assert len(found.changes) == 3
    assert found.safety == ()


def test_a_newly_offered_option_reports_where_it_leads() -> None:
    def push(new: Json) -> None:
        states(new)["assessing"]["decision"]["options"]["push"] = {"about": "push it away"}
        states(new)["assessing"]["transitions"].append({"on": "push", "to": "crossing"})

    (found,) = compared(push).safety
    assert found.sentence == "assessing: a model is newly offered 'push'"
    assert found.after == "always open, leads to crossing"


def test_a_newly_offered_option_of_a_tree_reports_what_is_done_then() -> None:
    def asked(*options: str) -> Mission:
        given = shipped()
        given["states"]["signalling"]["tree"] = {
            "decision": {"question": "How?", "options": {name: {} for name in options}, "fallback": options[0]},
            "then": {"loud": {"call": "horn"}} if "loud" in options else {},
        }
        return Mission.model_validate(given)

    report = {each.sentence: each.after for each in difference(asked("mute"), asked("mute", "loud")).safety}
    whose = "signalling: tree node 'the root'"
    assert report[f"{whose}: a model is newly offered 'loud'"] == "always open, then call"


def test_what_was_is_reported_in_the_old_files_own_words() -> None:
    """Also where a state, a key or an option goes by another name now."""
    text = json.dumps(shipped())
    for was, now in (("crossing", "over"), ("signals", "horns"), ("replan", "around")):
        text = text.replace(f'"{was}"', f'"{now}"')
    new = json.loads(text.replace('"call": "around"', '"call": "replan"'))
    new["invariants"]["nobody_is_driven_over"]["not"]["all"].pop()
    states(new)["assessing"]["decision"]["options"]["signal"]["when"]["<"] = 9
    states(new)["assessing"]["decision"]["fallback"] = "around"
    transition(new, "assessing", 0)["to"] = "resume"
    transition(new, "assessing", 1)["on"] = ["around", "e_stop"]
    states(new)["signalling"]["entry"] = []
    found = difference(Mission.model_validate(shipped()), Mission.model_validate(new))
    report = {each.sentence: each.before for each in found.changes}
    assert {"crossing", "signals"} <= {each.old for each in found.names}
    assert "in crossing" in report["invariant 'nobody_is_driven_over': guard strengthened"]
    assert "signals" in report["assessing: option 'signal': guard weakened"]
    assert report["assessing: transition 'drive_over': 'to' changed"] == "crossing"
    assert report["signalling: 'entry' changed: 'horns' is read"] == "“signals += 1”"
    for words in report.values():
        assert not {"over", "horns"}.intersection(words.split()), words
