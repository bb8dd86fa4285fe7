# SPDX-License-Identifier: Apache-2.0
"""The verdict of every claim for a table of small missions, found by hand."""

from __future__ import annotations

import pytest

from rai_missions.check import check, faults_of
from rai_missions.mission.mission import Mission
from rai_missions.prove import CLAIMS, prove
from tests.prove.table import TABLE, Row


@pytest.mark.parametrize("row", TABLE, ids=[row.name for row in TABLE])
def test_the_verdicts_are_those_of_the_table(row: Row) -> None:
    mission = Mission.model_validate(row.mission)
    assert list(faults_of(check(mission))) == []
    proof = prove(mission, most=20_000)
    found = {each.name: each.verdict for each in proof.claims}
    assert found == {claim: "refuted" if claim in row.refuted else "proved" for claim in CLAIMS}, row.why


def test_the_table_has_each_claim_that_an_author_can_break() -> None:
    assert len(TABLE) >= 60 and len({row.name for row in TABLE}) == len(TABLE)
    assert {claim for row in TABLE for claim in row.refuted} >= {
        "ends",
        "comes to rest",
        "invariants",
        "options",
        "rules",
    }
