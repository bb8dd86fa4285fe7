# SPDX-License-Identifier: Apache-2.0
"""Readings of which a rule finds out its truth alone: a proof with sets of values, and with each value chosen."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.guards.view import Site
from rai_missions.prove.abstraction.asked_readings import OpenSite
from rai_missions.prove.verdicts.circles import circling
from tests.prove.explored import RecordingSpace, true_or_not
from tests.prove.test_alike_readings import drawn, explored
from tests.sampled import sampled


def asked_by_value(site: OpenSite, guard: Any, test: Any) -> Any:
    """A look at a reading chooses its value."""
    return Site.asked(site, guard, test)


def by_value(seed: int) -> RecordingSpace:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(OpenSite, "asked", asked_by_value)
        return explored(drawn(seed))


def hold_against_values(seed: int) -> tuple[int, int]:
    every, few = by_value(seed), explored(drawn(seed))
    if not every.is_whole:
        return 0, 0
    assert few.is_whole
    assert (few.seen, {*few.ends.values()}) == (every.seen, {*every.ends.values()})
    assert (few.findings.taken, few.findings.entered) == (every.findings.taken, every.findings.entered)
    assert few.findings.flaws.keys() == every.findings.flaws.keys()
    assert bool(circling(few)) == bool(circling(every))
    assert few.environment.instruments.answered == every.environment.instruments.answered
    assert true_or_not(few) == true_or_not(every)
    for name, flaw in few.findings.flaws.items():
        assert len(few.path(flaw.state)) == len(every.path(every.findings.flaws[name].state))
    return few.made, every.made


@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_a_reading_that_is_asked_leads_where_each_of_its_values_leads(seed: int) -> None:
    hold_against_values(seed)
