# SPDX-License-Identifier: Apache-2.0
"""A generated chart does what SCXML's own algorithm does: the same states, and everything in the same order."""

from __future__ import annotations

from typing import Any

from hypothesis import HealthCheck, assume, given, settings

from tests.oracles.appendix_d import Endless
from tests.oracles.documents import Taste, charts, scripts
from tests.oracles.ours import of_appendix_d, of_ours
from tests.rigs.laws import drill

Json = dict[str, Any]
lenient = settings(
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow, HealthCheck.data_too_large]
)


def agree(document: Json, script: list[tuple[Any, ...]]) -> None:
    try:
        expected = of_appendix_d(document, script)
    except Endless:
        assume(False)
    assert of_ours(document, script) == expected


@lenient
@given(charts(), scripts())
def test_a_chart_does_what_the_recommendation_reports(document: Json, script: list[tuple[Any, ...]]) -> None:
    agree(document, script)


@lenient
@given(charts(Taste(delayed=True, raising=False)), scripts(timed=True, writes=True))
def test_delayed_events_come_and_are_canceled_as_sends_are(document: Json, script: list[tuple[Any, ...]]) -> None:
    agree(document, script)


@lenient
@given(charts(Taste(outcomes=True, root_transitions=True, wildcard=True)), scripts(writes=True))
def test_outcomes_go_where_they_are_addressed(document: Json, script: list[tuple[Any, ...]]) -> None:
    agree(document, script)


@lenient
@given(charts(Taste(defaults=True, outcomes=True)), scripts(writes=True))
def test_a_history_leads_by_its_default_where_there_is_no_memory(document: Json, script: list[tuple[Any, ...]]) -> None:
    agree(document, script)


test_thousands_of_histories_lead_by_their_defaults = drill(
    agree,
    charts(Taste(defaults=True, outcomes=True)),
    scripts(writes=True),
    tried=settings(lenient, max_examples=5_000),
)
