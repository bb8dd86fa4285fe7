# SPDX-License-Identifier: Apache-2.0
"""No claim that was proved is seen broken by a random walk in the chart that runs the mission."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from rai_missions.check import check, faults_of
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove
from tests.prove.walks import Walk, walkable

STATES, WORK = 100, 1_500
WALKS = 4


class Count(NamedTuple):
    drawn: int
    accepted: int
    whole: int
    seen_broken: int
    """Walks that saw some claim broken, which was not proved."""


def walk(mission: Mission, proof: Proof, seed: int) -> int:
    """Walk, and compare with what was proved; whether anything was seen broken."""
    reported = Walk(mission, seed)
    reported.go(10 + seed % 30)
    if seed % 3 == 0:
        reported.be_silent()
    elif seed % 3 == 1:
        reported.order("cancel", 200)
    reported.order("kill", 0)
    proved = {each.name for each in proof.claims if each.verdict == "proved"}
    for claim, how in reported.broken.items():
        if claim != "invariants" or reported.chart.false_invariant not in proof.assumed:
            assert claim not in proved, f"walk {seed}: {claim} was proved, but {how}"
    assert reported.entered.isdisjoint(proof.never), (
        f"walk {seed}: {reported.entered & set(proof.never)} was never to be entered"
    )
    return bool(reported.broken)


def walks(seeds: range) -> Count:
    accepted = whole = broken = 0
    for seed in seeds:
        mission = Mission.model_validate(walkable(seed))
        if faults_of(check(mission)):
            continue
        accepted += 1
        proof = prove(mission, most=STATES, work=WORK)
        whole += proof.is_whole
        try:
            broken += sum(walk(mission, proof, 1000 * seed + number) for number in range(WALKS))
        except AssertionError as error:
            raise AssertionError(f"mission {seed}: {error}") from error
    return Count(len(seeds), accepted, whole, broken)


def test_no_walk_sees_broken_what_was_proved() -> None:
    count = walks(range(12))
    assert count.accepted >= 0.8 * count.drawn and count.whole > 0.5 * count.accepted and count.seen_broken


@pytest.mark.parametrize("seed", [2473, 6193, 11458])
def test_no_walk_sees_broken_what_was_once_proved_wrongly(seed: int) -> None:
    assert walks(range(seed, seed + 1)).accepted


@pytest.mark.drill
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("part", range(10))
def test_no_walk_sees_broken_what_was_proved_however_often_it_is_tried(part: int) -> None:
    count = walks(range(1000 + 1250 * part, 1000 + 1250 * (part + 1)))
    assert count.accepted >= 1000
