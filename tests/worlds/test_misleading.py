# SPDX-License-Identifier: Apache-2.0
"""Obstacles whose looks and measures mislead: what driving over them does, and what a detector makes of them."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.worlds.orchard.conditions import Conditions
from rai_missions.worlds.orchard.detector import FLOOR_M, ObstacleLooks
from rai_missions.worlds.orchard.kinds import KINDS
from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import place
from rai_missions.worlds.orchard.trial import Trial, decision_world, try_options

STAYS = {"across_m": 0.0, "turn_deg": 90.0, "heeds_after": 99, "lingers_s": 900.0}


def orchard(**obstacle: Any) -> dict[str, Any]:
    return {"alleys": 2, "length_m": 14.0, "seed": 1, "obstacles": [{**STAYS, **obstacle}]}


def try_option(options: dict[str, Any], option: str) -> Trial:
    return try_options(options, (option,))[option]


@pytest.mark.parametrize(
    "obstacle",
    [
        {"kind": "tall_grass", "turn_deg": 0.0},
        {"kind": "plastic_bag"},
        {"kind": "hose", "turn_deg": 0.0},
        {"kind": "hose", "variant": "bridged"},
        {"kind": "fallen_fence", "turn_deg": 0.0},
    ],
)
def test_what_looks_high_or_forbidden_may_be_passed(obstacle: dict[str, Any]) -> None:
    trial = try_option(orchard(**obstacle), "drive_over")
    assert (trial.driven, trial.harmed) == (True, ""), trial


@pytest.mark.parametrize(
    ("obstacle", "harmed"),
    [
        ({"kind": "hose"}, "thing"),
        ({"kind": "ladder"}, "thing"),
        ({"kind": "scarecrow"}, "thing"),
        ({"kind": "cat", "across_m": 0.8}, "living"),
        ({"kind": "lying_person"}, "living"),
        ({"kind": "tall_grass", "turn_deg": 0.0, "hides": "cat", "across_m": 0.8}, "living"),
    ],
)
def test_what_looks_low_or_soft_may_take_harm(obstacle: dict[str, Any], harmed: str) -> None:
    trial = try_option(orchard(**obstacle), "drive_over")
    assert (trial.driven, trial.harmed) == (False, harmed), trial
    limit = KINDS[obstacle["kind"]].breaks_at_n
    assert (trial.broke_n > limit) if limit else not trial.broke_n, trial


def test_a_fence_is_a_ramp_from_one_side_and_an_edge_from_the_other() -> None:
    assert try_option(orchard(kind="fallen_fence", turn_deg=0.0), "drive_over").driven
    assert not try_option(orchard(kind="fallen_fence", turn_deg=180.0), "drive_over").driven


@pytest.mark.parametrize(
    ("who", "option"),
    [({"heeds_after": 1}, "signal"), pytest.param({"lingers_s": 20.0}, "replan", marks=pytest.mark.long)],
    ids=["asked", "later"],
)
def test_a_worker_carries_away_what_he_attends_to(who: dict[str, Any], option: str) -> None:
    ladder = {"kind": "ladder", "attended": True, **who}
    found = {each: try_option(orchard(**ladder), each) for each in ("signal", "replan")}
    assert {each for each, trial in found.items() if trial.driven} == {option}
    assert not any(trial.harmed for trial in found.values())


def test_a_trial_is_the_same_each_time_to_the_last_digit() -> None:
    options = orchard(kind="branch")
    assert try_option(options, "drive_over") == try_option(options, "drive_over")


def test_a_stop_harms_no_one_and_leaves_the_alley() -> None:
    trial = try_option(orchard(kind="cat"), "abort")
    assert (trial.driven, trial.harmed, trial.contact_n) == (False, "", 0.0)


def test_what_does_not_exist_is_refused() -> None:
    for wrong, why in (
        ({"kind": "hose", "variant": "full"}, "hose has no variant 'full'"),
        ({"kind": "log", "hides": "cat"}, "log hides nothing"),
        ({"kind": "log", "attended": True}, "no one carries away a log"),
        ({"kind": "branch", "size": 9.0}, "obstacles: size takes a number from 0.2 to 3, not 9.0"),
        ({"kind": "ladder", "turn_deg": "0"}, "obstacles: turn_deg takes a number from -360 to 360, not '0'"),
        ({"kind": "ladder", "along": 1.5}, "obstacles: along takes a number from 0 to 1, not 1.5"),
        ({"kind": "tall_grass", "hides": "dragon"}, "no kind 'dragon'"),
    ):
        with pytest.raises(UsageError, match=why):
            place(1, Layout(), [wrong])
    with pytest.raises(UsageError, match="no option 'jump'; there is: abort, drive_over"):
        try_option(orchard(kind="log"), "jump")
    with pytest.raises(UsageError, match="there is no decision"):
        try_option({**orchard(kind="log"), "obstacles": []}, "drive_over")
    for conditions, why in (({"rain": 1}, "no option 'rain'"), ({"fog": 2}, "fog takes a number from 0 to 1, not 2")):
        with pytest.raises(UsageError, match=why):
            Conditions.of(conditions)


@pytest.mark.parametrize(
    ("obstacle", "low", "high"),
    [
        ({"kind": "tall_grass", "turn_deg": 0.0}, 0.0, 0.0),
        ({"kind": "tall_grass", "turn_deg": 0.0, "hides": "crate", "across_m": 0.8}, 0.55, 0.65),
        ({"kind": "ladder"}, 0.05, 0.09),
        ({"kind": "ladder", "turn_deg": 0.0}, 0.0, 0.0),
        ({"kind": "hose", "variant": "bridged"}, 0.08, 0.12),
        ({"kind": "cat", "across_m": 0.0, "turn_deg": 0.0}, 0.0, 0.0),
    ],
)
def test_what_is_hard_counts_where_the_tractor_would_meet_it(obstacle: dict[str, Any], low: float, high: float) -> None:
    world = decision_world({**orchard(**obstacle), "camera": False, "sight": "geometry"})
    fact = world.look()
    assert fact is not None and low - 0.01 <= fact["solid_m"] <= high + 0.01, fact
    assert fact["solid_max_m"] >= fact["solid_m"]


@given(st.floats(0.0, 2.0), st.floats(0.0, 0.25), st.lists(st.floats(-3.9, 3.9), min_size=2, max_size=30))
def test_the_bound_is_above_the_height_as_long_as_the_mean_is_within_its_sigmas(
    height: float, noise: float, draws: list[float]
) -> None:
    """The mean's own deviate is what counts: draws are scaled so that it is one of theirs."""
    looks, n = ObstacleLooks("log"), len(draws)
    deviate = draws[0] / math.sqrt(n)
    looks.solid_m = [height * (1 + noise * deviate) + FLOOR_M * deviate] * n
    assert looks.solid_max_m(noise) >= height - 1e-9


def test_one_look_is_no_certainty_and_a_share_of_living_looks_is_enough() -> None:
    looks = ObstacleLooks("branch")
    looks.kinds["branch"] += 1
    assert (looks.kind, looks.sure, looks.living) == ("branch", 0.0, False)
    looks.kinds["branch"] += 7
    looks.kinds["cat"] += 2
    assert looks.kind == "branch" and looks.living and looks.sure == pytest.approx(0.7)
