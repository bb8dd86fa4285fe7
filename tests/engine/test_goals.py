# SPDX-License-Identifier: Apache-2.0
"""Goals in a mission: the guard, and the plan that is worked out in a step."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.errors import DefinitionError
from rai_missions.guards import GoalIs, Guard
from rai_missions.keys import Key
from rai_missions.mission.builder import Keys, On
from rai_missions.mission.mission import Mission
from rai_missions.states import Final, Plan, Read
from rai_missions.testing import check_activity, check_guard
from tests.strategies import SIGHTS

Json = dict[str, Any]
APART, STACKED, ALONE, ROLLING = SIGHTS
TOWER: Json = {"all": [{"on": ["red_cube", "blue_cube"]}]}
KEYS: Json = {
    "request": {"type": "string", "source": "argument", "initial": "put the red cube on the blue cube"},
    "objects": {"type": "object", "source": "robot", "max_age_s": 2, "optional": True},
    "wanted": {"type": "object", "source": "argument", "initial": TOWER},
    "plan": {"type": "object"},
}
ASKED_FOR: Json = {"goal": "wanted", "is": "said", "in": "request"}
REACHED: Json = {"goal": "wanted", "over": "objects"}
FEASIBLE: Json = REACHED | {"is": "feasible"}


def mission(*, guard: Json = REACHED, **keys: Json) -> Mission:
    """Plans, and succeeds where that is not needed."""
    return Mission.model_validate({
        "name": "stack", "blackboard": KEYS | keys, "initial": "planning",
        "states": {
            "planning": {"plan": "wanted", "over": "objects", "into": "plan", "transitions": [
                {"on": "succeeded", "when": guard, "to": "done"}, {"on": "succeeded", "to": "moving"},
                {"on": "failed", "to": "refused"}, {"on": "rejected", "to": "waiting"},
            ]},
            "waiting": {"transitions": [{"when": {"fresh": "objects"}, "to": "planning"}]},
            "moving": {"transitions": [{"when": guard, "to": "done"}, {"after_s": 60, "to": "refused"}]},
            "refused": {"final": "aborted"},
            "done": {"final": "succeeded", "requires": REACHED},
        },
    })  # fmt: skip


def truth(guard: Json, seen: Any, **known: Any) -> bool | None:
    """What a guard is while this is known: whether it, its opposite, or neither opens the way."""
    chart = Chart(Mission.model_validate({
        "name": "asking", "blackboard": KEYS, "initial": "waiting",
        "states": {
            "waiting": {"transitions": [{"when": guard, "to": "is_true"}, {"when": {"not": guard}, "to": "is_false"}]},
            "is_true": {"transitions": [{"after_s": 1, "to": "over"}]},
            "is_false": {"transitions": [{"after_s": 1, "to": "over"}]}, "over": {"final": "aborted"},
        },
    }))  # fmt: skip
    for key, value in known.items():
        chart.write(key, value, 0.0)
    if seen is not None:
        chart.write("objects", seen, 0.0)
    chart.start(0.0)
    return {"is_true": True, "is_false": False}.get(*chart.active)  # type: ignore[call-overload,no-any-return]


@pytest.mark.parametrize(
    ("seen", "reached", "feasible"),
    [
        (APART, False, True), (STACKED, True, True), (ALONE, None, False), (ROLLING, False, False), (None, None, None),
        ({"things": "many"}, None, None), ({}, None, None), (STACKED | {"gripper": "holding"}, False, True),
        (STACKED | {"gripper": "unknown"}, None, True),
    ],
)  # fmt: skip
def test_a_goal_is_reached_or_feasible_by_what_is_seen(seen: Any, reached: Any, feasible: Any) -> None:
    assert (truth(REACHED, seen), truth(FEASIBLE, seen)) == (reached, feasible)


@pytest.mark.parametrize("wanted", [{}, {"all": []}, {"refused": "absent"}, {"all": [{"over": ["a", "b"]}]}, {"x": 1}])
def test_what_is_no_goal_is_unknown(wanted: Json) -> None:
    assert truth(REACHED, STACKED, wanted=wanted) is None and truth(FEASIBLE, STACKED, wanted=wanted) is None


def test_a_sight_that_grew_stale_is_unknown() -> None:
    chart = Chart(mission())
    chart.write("objects", APART, 0.0)
    assert chart.start(0.0).entered == ("planning", "moving")
    assert chart.write("objects", STACKED, 5.0, stamp=2.5).outcome is None
    assert chart.write("objects", STACKED, 5.0, stamp=3.5).outcome == "succeeded"


def test_a_guard_keeps_its_contract() -> None:
    keys = {name: Key.model_validate(key) for name, key in KEYS.items()}
    facts = [{"wanted": TOWER, "objects": seen} for seen in SIGHTS]
    check_guard(GoalIs("wanted", over="objects"), keys, facts)
    check_guard(GoalIs("wanted", over="objects", is_="feasible"), keys, facts)
    check_guard(GoalIs("wanted", is_="said", in_="request"), keys, [{"wanted": TOWER, "request": "red on blue"}])


def test_a_plan_keeps_the_contract_of_activities() -> None:
    keys = {name: Key.model_validate(key) for name, key in KEYS.items()}
    check_activity(Plan("wanted", over="objects", into="plan"), keys, [{"objects": seen} for seen in SIGHTS])


def test_a_guard_in_python_is_that_of_json_and_one_that_lacks_its_measure_is_refused() -> None:
    k = Keys(**{name: Key.model_validate(key) for name, key in KEYS.items()})
    assert GoalIs(k.wanted, over=k.objects).written() == REACHED
    assert GoalIs(k.wanted, over=k.objects, is_="feasible") == Guard.read(FEASIBLE)
    for words in ({}, {"is_": "feasible"}, {"over": "objects", "in_": "request"}):
        with pytest.raises(DefinitionError, match="has 'over', what is seen, and no 'in'; write"):
            GoalIs("wanted", **words)  # type: ignore[arg-type]
    with pytest.raises(DefinitionError, match="'in' is missing"):
        GoalIs("wanted", is_="said", over="objects")


def test_a_plan_is_made_in_the_step_in_which_it_begins() -> None:
    chart = Chart(mission())
    assert chart.start(0.0).entered == ("planning", "waiting")
    step = chart.write("objects", APART, 1.0)
    assert step.entered == ("planning", "moving") and not step.effects
    (written,) = (value for key, value in step.writes if key == "plan")
    assert [move["object"] for move in written["moves"]] == ["red_cube"] and written["next"] == written["moves"][0]
    assert chart.write("objects", STACKED, 2.0).outcome == "succeeded"


@pytest.mark.parametrize(("seen", "reason"), [(ALONE, "absent"), (ROLLING, "round"), ({"things": 3}, "unreadable")])
def test_no_plan_is_a_failure_with_a_reason(seen: Json, reason: str) -> None:
    chart = Chart(mission())
    chart.write("objects", seen, 0.0)
    step = chart.start(0.0)
    (written,) = (value for key, value in step.writes if key == "plan")
    assert (step.outcome, written["reason"], written["moves"], written["next"]) == ("aborted", reason, [], None)
    assert any(written["about"] in note for note in map(str, step.notes))


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({"objects": {"things": 3}}, "what is seen cannot be read: /things: 3 is not a list; write […]"),
        ({"objects": APART, "wanted": {"all": [{"inside": ["red_cube", "tray"]}]}},
         "the goal cannot be read: /all/0: no predicate is written ['inside']; there is: "),
    ],
)  # fmt: skip
def test_a_goal_or_a_sight_that_cannot_be_read_is_named_with_its_first_fault(keys: Json, why: str) -> None:
    chart = Chart(mission())
    for name, value in keys.items():
        chart.write(name, value, 0.0)
    (written,) = (value for key, value in chart.start(0.0).writes if key == "plan")
    assert written["reason"] == "unreadable" and written["about"].startswith(why)


def test_a_request_over_a_sight_that_cannot_be_read_is_refused_with_its_first_fault() -> None:
    plain = mission().written()
    plain["blackboard"]["reading"] = {"type": "object"}
    planning = plain["states"]["planning"]
    ends = [{"on": ["succeeded", "unclear", "refused", "rejected"], "to": "refused"}]
    plain["states"]["planning"] = {"read": "request", "over": "objects", "into": "reading", "transitions": ends}
    plain["states"]["moving"] = planning
    chart = Chart(Mission.model_validate(plain))
    chart.write("objects", {"things": 3}, 0.0)
    (written,) = (value for key, value in chart.start(0.0).writes if key == "reading")
    assert written["about"] == "what is seen cannot be read: /things: 3 is not a list; write […]"


def test_an_empty_goal_of_the_mission_is_none_yet() -> None:
    assert "unreadable-goal" not in rules(mission(wanted={"type": "object", "initial": {}}))


@pytest.mark.parametrize(
    ("request_", "is_asked"),
    [
        ("put the red cube on the blue cube", True), ("red on blue, please", True), ("stack the cubes", True),
        ("put the red cube on the green cube", False), ("", False), ("what are you doing?", False),
    ],
)  # fmt: skip
def test_a_goal_is_asked_for_where_the_request_names_its_things(request_: str, is_asked: bool) -> None:
    assert truth(ASKED_FOR, APART, request=request_) is is_asked
    assert truth(ASKED_FOR | {"over": "objects"}, APART, request=request_) is is_asked
    assert truth(ASKED_FOR, None, request=request_) is is_asked
    assert truth(ASKED_FOR | {"over": "objects"}, None, request=request_) is None


def asking(request: str) -> Mission:
    """Reads, and ends where the reading leads."""
    ends = {"succeeded": "read", "unclear": "asked", "refused": "refused", "rejected": "blind"}
    return Mission.model_validate(
        {
            "name": "asking",
            "initial": "reading_it",
            "blackboard": KEYS | {"request": KEYS["request"] | {"initial": request}, "reading": {"type": "object"}},
            "states": {
                "reading_it": {
                    "read": "request",
                    "over": "objects",
                    "into": "reading",
                    "transitions": [{"on": end, "to": to} for end, to in ends.items()],
                },
                **{to: {"final": "aborted"} for to in ends.values()},
            },
        }
    )


@pytest.mark.parametrize(
    ("words", "end", "part"),
    [
        ("put the red cube on the blue cube", "read", "goal"), ("put it somewhere", "asked", "question"),
        ("put the lemon on the blue cube", "asked", "question"), ("put the apple on the red cube", "refused", "reason"),
    ],
)  # fmt: skip
def test_a_request_is_read_in_the_step_in_which_it_begins(words: str, end: str, part: str) -> None:
    chart = Chart(asking(words))
    chart.write("objects", APART, 0.0)
    step = chart.start(0.0)
    (reading,) = (value for key, value in step.writes if key == "reading")
    assert step.entered[-1] == end and reading[part], reading
    assert {"goal", "question", "candidates", "reason", "about", "covers_all"} == reading.keys()
    if end == "read":
        assert reading["goal"] == TOWER


def test_a_request_over_an_unknown_sight_is_rejected_and_over_nonsense_refused() -> None:
    assert Chart(asking("stack the cubes")).start(0.0).entered[-1] == "blind"
    chart = Chart(asking("stack the cubes"))
    chart.write("objects", {"things": 3}, 0.0)
    assert chart.start(0.0).entered[-1] == "refused"


def test_a_reading_keeps_the_contract_of_activities() -> None:
    keys = {name: Key.model_validate(key) for name, key in (KEYS | {"reading": {"type": "object"}}).items()}
    check_activity(Read("request", over="objects", into="reading"), keys, [{"objects": seen} for seen in SIGHTS])


def rules(given: Mission) -> set[str]:
    return {each.rule for each in check(given) if each.severity == "error"}


def test_success_rests_on_a_goal_only_over_what_the_robot_alone_reports() -> None:
    assert rules(mission()) == set()
    assert "unfounded-success" in rules(mission(objects={"type": "object", "source": "argument", "initial": STACKED}))
    asked = copy.deepcopy(mission().written())
    asked["states"]["done"]["requires"] = {"goal": "wanted", "is": "said", "in": "request"}
    assert "unfounded-success" in rules(Mission.model_validate(asked))


def test_types_that_do_not_fit_are_found_with_their_place() -> None:
    wrong = mission(wanted={"type": "string", "source": "argument", "initial": "a tower"}, plan={"type": "list"})
    found = {each.place: each.rule for each in check(wrong) if each.severity == "error"}
    assert found["/states/planning/plan"] == found["/states/planning/into"] == "mismatched-activity"
    assert found["/states/done/requires/goal"] == "mismatched-comparison"


def test_a_plan_without_its_transitions_is_found() -> None:
    bare = mission().written()
    bare["states"]["planning"]["transitions"] = [{"on": "succeeded", "to": "moving"}]
    found = {each.rule: each.sentence for each in check(Mission.model_validate(bare))}
    assert "'failed' and 'rejected' of 'planning'" in found["unhandled-failure"]


@pytest.mark.long
def test_planning_in_a_circle_is_a_fault() -> None:
    round_ = mission().written()
    round_["states"]["planning"]["transitions"] = [{"on": ["succeeded", "failed", "rejected"], "to": "planning"}]
    chart = Chart(Mission.model_validate(round_))
    chart.write("objects", APART, 0.0)
    assert "a cycle without end" in chart.start(0.0).why


def test_a_mission_in_python_is_that_of_json() -> None:
    k = Keys(**{name: Key.model_validate(KEYS[name]) for name in ("objects", "wanted", "plan")})
    built = Mission(
        "stack",
        keys=k,
        initial="planning",
        states={
            "planning": Plan(
                k.wanted,
                over=k.objects,
                into=k.plan,
                transitions=[
                    On("succeeded", when=GoalIs(k.wanted, over=k.objects), to="done"),
                    On("failed", "rejected", to="refused"),
                ],
            ),
            "refused": Final("aborted"),
            "done": Final("succeeded", requires=GoalIs(k.wanted, over=k.objects)),
        },
    )
    assert Mission.model_validate(built.written()) == built
    assert built.written()["states"]["planning"]["plan"] == "wanted"
