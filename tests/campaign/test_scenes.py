# SPDX-License-Identifier: Apache-2.0
"""Scenes are functions of their seeds, no two are alike, and each half holds every case."""

from __future__ import annotations

import json
from collections import Counter

import pytest

from rai_missions.campaign.scenes import scene, scenes, split_of
from rai_missions.errors import UsageError
from rai_missions.worlds.orchard.kinds import KINDS


def test_a_scene_is_a_function_of_its_seed_and_plain_data() -> None:
    for seed in range(200):
        one = scene("orchard", seed)
        assert one == scene("orchard", seed)
        assert json.loads(json.dumps(one.spec)) == one.spec
        assert one.spec["options"]["seed"] == seed and one.kind in KINDS


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


def test_what_cannot_be_generated_is_refused() -> None:
    with pytest.raises(UsageError, match="no scenes are generated for the world 'moon'; there are: orchard, house"):
        scene("moon", 1)
    with pytest.raises(UsageError, match="count and first_seed are 0 or more, not -1 and 0"):
        scenes("orchard", -1)
