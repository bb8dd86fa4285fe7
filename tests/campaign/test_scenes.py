# SPDX-License-Identifier: Apache-2.0
"""Scenes are functions of their seeds, no two are alike, and each half holds every case."""

from __future__ import annotations

import json
from collections import Counter

import pytest

from rai_missions.campaign.scenes import scene, scenes, split_of
from rai_missions.errors import UsageError
from rai_missions.worlds.house.people import place_people
from rai_missions.worlds.house.scene_cases import CASES, PERSON_S
from rai_missions.worlds.orchard.kinds import KINDS


def test_a_scene_is_a_function_of_its_seed_and_plain_data() -> None:
    for seed in range(200):
        one = scene("orchard", seed)
        assert one == scene("orchard", seed)
        assert json.loads(one.spec)["options"]["seed"] == seed and one.kind in KINDS


def test_no_two_scenes_are_alike_and_any_first_seed_gives_as_many_as_are_asked() -> None:
    found = scenes("orchard", 600, first_seed=17)
    assert len({one.scene for one in found}) == 600 == len(found)
    assert found[0].seed == 17


def test_the_split_is_by_seed_and_each_half_holds_each_kind_in_about_its_share() -> None:
    found = scenes("orchard", 1000)
    assert {(one.seed % 2, one.split) for one in found} == {(0, "tune"), (1, "report")}
    counts = {split: Counter(one.kind for one in found if one.split == split) for split in ("tune", "report")}
    for kind in KINDS:
        assert abs(counts["tune"][kind] - counts["report"][kind]) <= 8, kind
        assert counts["report"][kind] >= 4, kind
    assert split_of(4) == "tune" and split_of(5) == "report"


def test_scenes_of_the_house_are_functions_of_their_seeds_and_each_half_holds_each_case() -> None:
    found = scenes("house", 400)
    weight = sum(weight for weight, _, _ in CASES)
    for one in found:
        assert one == scene("house", one.seed)
    for split in ("tune", "report"):
        kinds = Counter(one.kind for one in found if one.split == split)
        for share, kind, _ in CASES:
            assert abs(kinds[kind] - 200 * share / weight) <= 3, (split, kind)


def test_a_later_question_is_answered_in_a_scene_of_the_house_where_a_person_helps_and_in_no_other() -> None:
    for one in scenes("house", 200):
        spec = json.loads(one.spec)
        people = place_people(one.seed, spec["options"].get("people", 0))
        assert bool(spec.get("later")) is any(person.helps for person in people), one.kind
        assert all(person.lies == (one.kind == "lies") for person in people[1:])
        if one.kind == "closes_again":
            begins, ends = spec["options"]["blocked"]["study_pantry"]
            assert people[0].from_s < PERSON_S + 1 < begins < ends


def test_what_cannot_be_generated_is_refused() -> None:
    with pytest.raises(UsageError, match="no scenes are generated for the world 'moon'; there are: orchard, house"):
        scene("moon", 1)
    with pytest.raises(UsageError, match="count and first_seed are 0 or more, not -1 and 0"):
        scenes("orchard", -1)
