# SPDX-License-Identifier: Apache-2.0
"""Proofs of missions with goals: the planner is free, and goals are reached and feasible in every combination."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.guards.goal import judged
from rai_missions.mission.mission import Mission
from rai_missions.planning.examples import GOALS
from rai_missions.prove import prove
from rai_missions.prove.analysis.goals import requests, sights
from rai_missions.prove.analysis.representatives import Values
from tests.engine.test_goals import ASKED_FOR, FEASIBLE, KEYS, REACHED, TOWER, mission

Json = dict[str, Any]


def verdicts(given: Mission) -> dict[str, str]:
    return {each.name: each.verdict for each in prove(given).claims}


def moving(**change: Any) -> Json:
    """A mission that plans and moves in turn."""
    document = mission().written()
    planning, states = document["states"]["planning"], document["states"]
    planning["transitions"][1]["when"] = {"fresh": "plan.next"}
    planning["transitions"].insert(2, {"on": "succeeded", "to": "refused"})
    states["moving"] = {
        "action": "move", "goal": {"object": {"from": "plan.next.object"}}, "timeout_s": 60,
        "transitions": [{"on": ["succeeded", "failed", "timed_out", "rejected"], "to": "looking"}],
    }  # fmt: skip
    states["looking"] = {"transitions": [{"after_s": 1, "to": "planning"}]}
    states["waiting"]["transitions"].append({"after_s": 60, "to": "refused"})
    return document | change


def test_a_mission_that_plans_and_moves_is_proved() -> None:
    proof = prove(Mission.model_validate(moving()))
    assert {each.verdict for each in proof.claims} == {"proved"} and not proof.sampled


def test_each_outcome_of_a_plan_is_taken_with_and_without_a_move() -> None:
    held = {"in": "moving"}
    for guard in (held, {"in": "looking"}, {"in": "refused"}, {"in": "waiting"}):
        never = moving(invariants={"never": {"not": guard}})
        assert verdicts(Mission.model_validate(never))["invariants"] == "refuted", guard


def test_the_planner_may_answer_what_ours_never_does() -> None:
    given = moving()
    given["states"]["planning"]["transitions"].insert(0, {"on": "failed", "when": FEASIBLE, "to": "odd"})
    given["states"]["odd"] = {"final": "failed"}
    given["invariants"] = {"never": {"not": {"in": "odd"}}}
    assert verdicts(Mission.model_validate(given))["invariants"] == "refuted"


def test_an_action_is_started_with_the_field_it_is_sent_with_and_rejected_without() -> None:
    given = moving()
    given["states"]["moving"]["transitions"] = [
        {"on": ["succeeded", "failed", "timed_out"], "to": "looking"}, {"on": "rejected", "to": "lost"},
    ]  # fmt: skip
    given["states"]["lost"] = {"final": "failed"}
    for state in ("lost", "looking"):
        given["invariants"] = {"never": {"not": {"in": state}}}
        assert verdicts(Mission.model_validate(given))["invariants"] == "refuted", state


@pytest.mark.parametrize(("field", "verdict"), [("object", "proved"), ("pick", "proved"), ("spare", "refuted")])
def test_a_move_of_a_plan_is_known_with_all_that_every_move_has(field: str, verdict: str) -> None:
    given = moving()
    unknown = {"all": [{"fresh": "plan.next"}, {"not": {"fresh": f"plan.next.{field}"}}]}
    given["states"]["planning"]["transitions"].insert(0, {"on": "succeeded", "when": unknown, "to": "odd"})
    given["states"]["odd"] = {"final": "failed"}
    given["invariants"] = {"never": {"not": {"in": "odd"}}}
    assert verdicts(Mission.model_validate(given))["invariants"] == verdict


def test_a_success_that_does_not_ask_whether_it_is_reached_ends_failed_in_some_run() -> None:
    hasty = moving()
    del hasty["states"]["planning"]["transitions"][0]["when"]
    assert verdicts(Mission.model_validate(hasty))["rules"] == "proved"
    forbidden = {"not": {"all": [{"in": "done"}, {"not": REACHED}]}}
    assert verdicts(Mission.model_validate(hasty | {"invariants": {"earned": forbidden}}))["invariants"] == "refuted"
    assert verdicts(Mission.model_validate(moving(invariants={"earned": forbidden})))["invariants"] == "proved"


def test_a_goal_that_is_not_in_the_request_is_never_acted_on_whatever_is_read() -> None:
    """With the guard it is proved for every reading; without it refuted."""
    for guards, verdict in (([ASKED_FOR], "proved"), ([], "refuted")):
        given = moving()
        given["blackboard"] |= {"wanted": {"type": "object"}, "reading": {"type": "object"}}
        given["states"] |= {
            "reading_it": {
                "read": "request",
                "over": "objects",
                "into": "reading",
                "transitions": [
                    {"on": "succeeded", "to": "judging", "do": [{"set": "wanted", "from": "reading.goal"}]},
                    {"on": ["unclear", "refused", "rejected"], "to": "refused"},
                ],
            },
            "judging": {
                "transitions": [
                    {"when": {"all": [{"fresh": "wanted"}, *guards]}, "to": "planning"},
                    {"after_s": 1, "to": "refused"},
                ]
            },
        }
        given["initial"] = "reading_it"
        given["invariants"] = {"said": {"not": {"all": [{"in": "moving"}, {"not": ASKED_FOR}]}}}
        assert verdicts(Mission.model_validate(given))["invariants"] == verdict


def test_what_is_seen_leaves_every_goal_free() -> None:
    found = {tuple(judged("reached", goal, each) for goal in GOALS) for each in sights(GOALS, ["reached"])}
    assert found == set(product((True, False, None), repeat=2))
    assert {tuple(judged("said", goal, None, each) for goal in GOALS) for each in requests(GOALS)} == set(
        product((True, False), repeat=2)
    )
    both = {
        tuple(judged(aspect, GOALS[0], each) for aspect in ("reached", "feasible"))
        for each in sights(GOALS[:1], ["reached", "feasible"])
    }
    assert both == {(True, True), (False, True), (False, False), (None, False)}


@pytest.mark.parametrize(
    ("keys", "sampled"),
    [
        ({}, ()),
        ({"wanted": {"type": "object", "initial": TOWER}}, ("wanted",)),
        ({"wanted": {"type": "object"}, "given": {"type": "object", "source": "argument", "initial": TOWER}}, ()),
    ],
)  # fmt: skip
def test_a_goal_that_the_author_wrote_is_tried_and_not_proved(keys: Json, sampled: tuple[str, ...]) -> None:
    document = mission().written() | {"blackboard": KEYS | keys}
    if "given" in keys:
        document["states"]["waiting"]["transitions"][0]["do"] = [{"set": "wanted", "from": "given"}]
    assert Values(Mission.model_validate(document), RobotFacts()).learned.sampled == sampled


def test_a_goal_that_was_read_is_known_also_where_no_guard_looks_into_goals() -> None:
    keys: Json = {
        "request": {"type": "string", "source": "argument"}, "objects": {"type": "object", "source": "robot"},
        "reading": {"type": "object"}, "wanted": {"type": "object"}, "plan": {"type": "object"},
    }  # fmt: skip
    copied = {"set": "wanted", "from": "reading.goal"}
    states: Json = {
        "reading_it": {
            "read": "request",
            "over": "objects",
            "into": "reading",
            "transitions": [
                {"on": "succeeded", "to": "planning", "do": [copied]},
                {"on": ["unclear", "refused"], "to": "unread", "do": [copied]},
                {"on": "rejected", "to": "none"},
            ],
        },
        "planning": {
            "plan": "wanted",
            "over": "objects",
            "into": "plan",
            "transitions": [
                {"on": ["succeeded", "failed"], "to": "planned"},
                {"on": "rejected", "to": "unplanned"},
            ],
        },
        "unread": {"transitions": [{"when": {"fresh": "wanted"}, "to": "odd"}, {"after_s": 1, "to": "none"}]},
        **{name: {"final": "aborted"} for name in ("planned", "unplanned", "odd", "none")},
    }
    given = {"format": 1, "name": "m", "initial": "reading_it", "blackboard": keys, "states": states}
    assert set(prove(Mission.model_validate(given)).never) == {"unplanned", "odd"}
