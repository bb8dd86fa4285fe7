# SPDX-License-Identifier: Apache-2.0
"""SPIN, a model checker of another make, finds the same configurations within reach."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.mission.mission import Mission
from tests.prove.explored import explored
from tests.prove.promela import END, Drawing, has_spin, reached_by_spin

pytestmark = pytest.mark.skipif(not has_spin(), reason="needs spin and gcc: apt-get install spin gcc")


def agree(seed: int, folder: Path) -> int:
    document = Drawing(seed).mission()
    space = explored(Mission.model_validate(document), 100_000)
    assert space.is_whole
    inner = {name for name, leaf in leaves(document)} | {END}
    ours = {frozenset(active & inner) for active, outcome, _ in space.seen if outcome is None}
    ours |= {frozenset({END}) for _, outcome, _ in space.seen if outcome == "aborted"}
    theirs = reached_by_spin(document, folder)
    assert ours == theirs, f"seed {seed}"
    return len(ours)


def leaves(document: dict) -> list[tuple[str, dict]]:  # type: ignore[type-arg]
    found, waiting = [], list(document["states"]["all"]["parallel"].values())
    while waiting:
        for name, state in waiting.pop()["states"].items():
            if "states" in state:
                waiting.append(state)
            else:
                found.append((name, state))
    return found


@pytest.mark.parametrize(
    "seed", [4, *(pytest.param(seed, marks=pytest.mark.long) for seed in (0, 9))]
)  # hundreds more in drills
def test_spin_reaches_the_same_configurations(seed: int, tmp_path: Path) -> None:
    assert agree(seed, tmp_path) >= 2


@pytest.mark.drill
@pytest.mark.timeout(1800)
def test_spin_reaches_the_same_configurations_of_many_charts(tmp_path: Path) -> None:
    sizes = []
    for seed in range(100, 300):
        folder = tmp_path / str(seed)
        folder.mkdir()
        sizes.append(agree(seed, folder))
    assert max(sizes) > 10
