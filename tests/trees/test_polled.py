# SPDX-License-Identifier: Apache-2.0
"""A tree in a chart, which no one polls, is where py_trees is that is polled until nothing changes."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, event, given, settings

from tests.rigs.laws import drill
from tests.trees.polling import Pair, lives, polled_trees


def as_polled(drawn: Any, life: Any) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        for ran in Pair(drawn, monkeypatch).live(life):
            if not ran.has_settled:  # what never comes to rest by polling rests here, and states it
                event("never comes to rest")
                assert ran.resting == ("work",)
                return
            assert ran.end[0] == ran.end[1]
            assert ran.ours == ran.polled


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(polled_trees, lives)
def test_a_chart_is_where_py_trees_is_that_is_polled_until_nothing_changes(drawn: Any, life: Any) -> None:
    as_polled(drawn, life)


test_so_it_is_for_many_trees = drill(
    as_polled, polled_trees, lives, tried=settings(max_examples=12_000, suppress_health_check=list(HealthCheck))
)
