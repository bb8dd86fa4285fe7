# SPDX-License-Identifier: Apache-2.0
"""The mission at the desk, killed while its arm lives on, with a thing in the hand too: it ends as it does without."""

from __future__ import annotations

import random
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.desk.episodes import DESK_MISSIONS
from tests.desk.outside import hard_case
from tests.desk.plain_judge import is_met
from tests.desk.test_desk import TWO
from tests.replay.mortal import Fate, live
from tests.replay.shipped import AfterRow, ShippedLand
from tests.rigs.journals import rows_of

pytestmark = pytest.mark.sim
RED, BLUE = "red_cube", "blue_cube"
DONE = "succeeded", "'done' was reached, and wanted is reached over objects"


TOWERS = (28, 26, 27)
"""Seeds of hard cases, modulo 72: a tower of what is built already, of what lies far, and near."""


class Ending(NamedTuple):
    """How a run ended that was killed, and what is so."""

    how: tuple[str | None, str]
    held_at_death: str
    is_built: bool
    """The red cube rests on the blue one, and the hand is empty, by the truth."""


def built(path: Path, row: int, dead_s: float) -> Ending:
    """Have a tower built by a run that dies after a row; the arm is alone for so long then."""
    arguments = {"request": "put the red cube on the blue cube"}
    with closing(ShippedLand(DESK_MISSIONS, {**TWO, "camera": False}, arguments, "arrange.json")) as there:
        is_over = live(path, there, there.mission, there.robot, there.answerers, AfterRow(row)) is not None
        held = there.world.truth().held  # type: ignore[attr-defined]
        for _ in range(0 if is_over else round(dead_s / there.period_s)):
            there.step()
        outing = there.drive(path, []) if not is_over else None
        truth = there.world.truth()  # type: ignore[attr-defined]
        is_built = truth.touch(RED, BLUE) and truth.things[RED].z > truth.things[BLUE].z and not truth.held
        return Ending((outing.outcome, outing.why) if outing else DONE, held, is_built)


@pytest.mark.parametrize(
    ("row", "dead_s"), [(16, 8.0), *(pytest.param(*each, marks=pytest.mark.long) for each in ((14, 0.0), (18, 60.0)))]
)
def test_killed_with_a_thing_in_the_hand_it_ends_as_it_does_without(tmp_path: Path, row: int, dead_s: float) -> None:
    assert built(tmp_path / "run.journal", row, dead_s) == (DONE, RED, True)


@pytest.mark.drill
@pytest.mark.parametrize("dead_s", [0.0, 2.0, 8.0, 60.0])
def test_killed_after_every_row(tmp_path: Path, dead_s: float) -> None:
    built(tmp_path / "whole.journal", 10**6, 0.0)
    ends = [
        built(tmp_path / f"{row}.journal", row, dead_s) for row in range(1, len(rows_of(tmp_path / "whole.journal")))
    ]
    assert {(one.how, one.is_built) for one in ends} == {(DONE, True)}
    assert RED in {one.held_at_death for one in ends}


def stacked(path: Path, seed: int) -> tuple[str | None, str, bool, bool]:
    """Have a tower of all cubes built on a desk with more things, by a run that is killed three times.

    Returns:
        How it ended; whether it is so by the judge that knows poses and contacts alone; whether the hand is empty.
    """
    rng = random.Random(f"killed {seed}")
    case = hard_case(72 * seed + TOWERS[seed % len(TOWERS)])
    fates: list[Fate] = [AfterRow(rng.randint(2, 14)) for _ in range(3)]
    world = {**case.world, "camera": False}
    with closing(ShippedLand(DESK_MISSIONS, world, {"request": case.request}, "arrange.json")) as there:
        outing = there.drive(path, fates, rng.choice((0.0, 1.0, 5.0, 30.0)))
        truth = there.world.truth()  # type: ignore[attr-defined]
        return outing.outcome, outing.why, is_met(case.goal, truth), not truth.held


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(12))
def test_killed_three_times_with_more_on_the_desk_it_claims_what_is_so(tmp_path: Path, seed: int) -> None:
    outcome, why, is_so, is_empty = stacked(tmp_path / "run.journal", seed)
    assert (outcome == "succeeded") == is_so, why
    assert is_empty or outcome != "succeeded"
