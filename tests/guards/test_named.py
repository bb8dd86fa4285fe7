# SPDX-License-Identifier: Apache-2.0
"""A predicate of the user's program, as a reader sees it."""

from __future__ import annotations

from rai_missions.guards.named import Named


def test_its_words_have_values_and_references_as_a_goal_has_them() -> None:
    guard = Named("is_crossable", {"margin_m": 0.1, "sure": True, "height_m": {"from": "obstacle.height_m"}})
    assert guard.words() == "is_crossable(margin_m 0.1, sure true, height_m ← obstacle.height_m)"
