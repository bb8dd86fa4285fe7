# SPDX-License-Identifier: Apache-2.0
"""What a campaign may use, and how fast providers are asked."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.campaign.budget import CallPace, Spending
from rai_missions.campaign.file import BudgetEntry, RateEntry
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.store import ResultStore

CELL = CellRecord("k", "m", "s", 1, "openai:gpt", "none", "written", "answered")
used = st.tuples(st.integers(0, 3), st.integers(0, 500), st.integers(0, 500), st.floats(0, 2))


@given(st.lists(used, max_size=8), st.integers(1, 6), st.integers(1, 2000), st.floats(0.1, 5))
def test_a_budget_is_spent_as_soon_as_one_part_of_it_is(
    cells: list[tuple[int, int, int, float]], calls: int, tokens: int, money: float
) -> None:
    spending = Spending(BudgetEntry(calls=calls, tokens=tokens, money=money))
    for count, (calls_of, prompt, completion, cost) in enumerate(cells, start=1):
        spending.add(CELL._replace(calls=calls_of, prompt_tokens=prompt, completion_tokens=completion, cost=cost))
        so_far = cells[:count]
        is_spent = (
            sum(each[0] for each in so_far) >= calls
            or sum(each[1] + each[2] for each in so_far) >= tokens
            or sum(each[3] for each in so_far) >= money
        )
        assert bool(spending.spent(0.0)) == is_spent


def test_what_a_store_holds_already_counts_and_time_does_not() -> None:
    spending = Spending(BudgetEntry(calls=5, seconds=10.0), [CELL._replace(calls=3)])
    assert spending.spent(9.9) == "" and spending.spent(10.0) == "the budget of 10 seconds is spent"
    spending.add(CELL._replace(calls=2))
    assert spending.spent(0.0) == "the budget of 5 calls is spent"
    assert Spending(BudgetEntry()).spent(1e9) == ""


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(used, st.integers(0, 3)), max_size=6))
def test_what_is_taken_out_of_a_store_stays_spent(cells: list[tuple[tuple[int, int, int, float], int]]) -> None:
    """Whenever cells are dropped, and however often: as if the store had kept them."""
    kept = [
        CELL._replace(cell=f"k{at}", calls=calls, prompt_tokens=prompt, completion_tokens=completion, cost=cost)
        for at, ((calls, prompt, completion, cost), _) in enumerate(cells)
    ]
    with TemporaryDirectory() as folder, ResultStore(Path(folder) / "results.db", writes=True) as store:
        store.add(kept)
        for turn in range(1, 4):
            store.drop([each.cell for each, (_, when) in zip(kept, cells, strict=True) if when == turn])
        found, whole = Spending(BudgetEntry(), store.cells(), store.dropped), Spending(BudgetEntry(), kept)
    assert (found.calls, found.tokens) == (whole.calls, whole.tokens)
    assert found.money == pytest.approx(whole.money)


def asked_at(rate: RateEntry, workers: int, tokens: list[int]) -> list[float]:
    """When calls of so many tokens are begun by one worker that never tires, on a clock of its own."""
    pace, now, begun = CallPace(rate, workers), 0.0, []
    for each in tokens:
        now += pace.delay_s(now)
        begun.append(now)
        pace.spend(now, 1, each)
    return begun


@given(st.integers(1, 600), st.integers(1, 8), st.integers(2, 30))
def test_all_workers_together_begin_no_more_calls_in_a_minute_than_they_may(
    per_minute: int, workers: int, calls: int
) -> None:
    begun = asked_at(RateEntry(calls_per_minute=per_minute), workers, [0] * calls)
    spacing = [later - earlier for earlier, later in pairwise(begun)]
    assert spacing == pytest.approx([60 * workers / per_minute] * (calls - 1))


@given(st.lists(st.integers(0, 5000), min_size=2, max_size=20), st.integers(100, 100_000))
def test_tokens_are_paid_for_before_the_next_call(tokens: list[int], per_minute: int) -> None:
    begun = asked_at(RateEntry(tokens_per_minute=per_minute), 1, tokens)
    assert begun[-1] == pytest.approx(sum(tokens[:-1]) * 60 / per_minute)


def test_a_provider_without_a_rate_is_asked_at_once() -> None:
    assert asked_at(RateEntry(), 3, [10, 10, 10]) == [0.0, 0.0, 0.0]
