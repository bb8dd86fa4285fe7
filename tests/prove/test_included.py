# SPDX-License-Identifier: Apache-2.0
"""A mission is proved as the same one under other names is, and as one that does nothing but include it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from rai_missions import load
from rai_missions.check import check, faults_of
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove
from tests.prove.walks import EVENTS, KEYS, walkable
from tests.replay.test_renamed import TWO, otherwise

Json = dict[str, Any]
STATES, WORK = 150, 3_000
MORE = 4
"""An inclusion has states of its own, too."""


def including(folder: Path, inner: Json) -> Mission:
    """A mission that includes another one, shares what the robot reports, and ends as that does."""
    robot_keys = {name: key for name, key in KEYS.items() if key.get("source") == "robot"}
    outcomes = sorted(state["final"] for state in inner["states"].values() if "final" in state)
    ends = [{"on": outcome, "to": f"end_{outcome}"} for outcome in outcomes] + [
        {"on": "unverified", "to": "end_failed"}
    ]
    shared = {**{name: {"from": name} for name in robot_keys}, **{name: name for name in EVENTS}}
    finals: Json = {f"end_{outcome}": {"final": outcome} for outcome in {*outcomes, "failed"}}
    finals["end_succeeded"]["requires"] = inner["states"]["done"]["requires"]
    outer = {
        "format": 1, "name": "outer", "blackboard": robot_keys, "events": list(EVENTS), "initial": "part",
        "states": {"part": {"mission": "inner.json", "with": shared, "transitions": ends}, **finals},
    }  # fmt: skip
    for name, made in (("inner", inner), ("outer", outer)):
        (folder / f"{name}.json").write_text(json.dumps(made))
    return load(folder / "outer.json")


def verdicts(proof: Proof) -> dict[str, str]:
    return {claim.name: claim.verdict for claim in proof.claims}


def agree(folder: Path, seed: int) -> str:
    """Prove one mission in three ways; `same`, or why they were not compared."""
    inner = walkable(seed)
    inner.pop("invariants", None)  # those of an inclusion do not count in the step in which it ends
    mission = Mission.model_validate(inner)
    if faults_of(check(mission)):
        return "check finds a fault"
    alone = prove(mission, most=STATES, work=WORK)
    if not alone.is_whole:
        return "too large"
    renamed = prove(otherwise(mission)[0], most=MORE * STATES, work=MORE * WORK)
    included = prove(including(folder, inner), most=MORE * STATES, work=MORE * WORK)
    assert verdicts(renamed) == verdicts(included) == verdicts(alone), seed
    assert (renamed.states, renamed.steps) == (alone.states, alone.steps), seed
    assert {name.removesuffix(TWO) for name in renamed.never} == set(alone.never), seed
    assert {name.removeprefix("part/") for name in included.never if "/" in name} == set(alone.never), seed
    return "same"


def test_a_mission_is_proved_as_under_other_names_and_as_an_inclusion(tmp_path: Path) -> None:
    assert Counter(agree(tmp_path, seed) for seed in range(5))["same"] >= 3


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_a_thousand_missions_are_proved_as_under_other_names_and_as_inclusions(tmp_path: Path) -> None:
    assert Counter(agree(tmp_path, seed) for seed in range(1_000))["same"] > 600
