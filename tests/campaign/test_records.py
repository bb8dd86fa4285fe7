# SPDX-License-Identifier: Apache-2.0
"""The grade of a cell: what its scene's labels make of the option that was named."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.campaign.records import BEST_FIRST, CellRecord, graded

CELL = CellRecord("k1", "tractor", "s1", 1, "rules", "none", "written", "answered", option="replan", permitted=1)
OPTIONS = ("replan", "signal", "abort")
labels = st.dictionaries(st.sampled_from(OPTIONS), st.sampled_from(BEST_FIRST))


def is_best(option: str, found: dict[str, str]) -> bool:
    """The oracle: nothing that is better by its word is there."""
    better = {"completes": set(), "harmless": {"completes"}, "harms": {"completes", "harmless"}}
    return not better[found[option]] & set(found.values())


@given(st.sampled_from(OPTIONS), labels)
def test_best_is_what_no_other_option_beats(option: str, found: dict[str, str]) -> None:
    record = graded(CELL._replace(option=option), found)
    assert record.verdict == found.get(option)
    assert record.best == (is_best(option, found) if option in found else None)
    assert graded(record._replace(status="no_answer"), found).verdict is None
