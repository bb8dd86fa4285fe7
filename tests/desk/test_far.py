# SPDX-License-Identifier: Apache-2.0
"""The mission's process killed with SIGKILL, the desk in another one: the resumed run claims what is so.

Nothing is dropped unreported, no goal is asked for twice, and none is lost.
"""

from __future__ import annotations

import os
import random
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import pytest

from tests.desk.far_desk import Death, FarDesk, drawn_deaths
from tests.desk.onlooker import DeskVerdict
from tests.desk.outside import combined_faults, hard_case

pytestmark = pytest.mark.sim
SIZES = {"SEED": "0", "KILLED_RUNS": "60"}
ON = 50
"""A hard case: one cube is put on another, at the far side of the desk."""


def killed(
    folder: Path, seed: int, deaths: Sequence[Death], *, with_faults: bool = False
) -> tuple[DeskVerdict, FarDesk]:
    """One case, killed so; and the desk as it is left, closed."""
    case = hard_case(seed, **(combined_faults(seed) if with_faults else {}))
    with closing(FarDesk(case.request, case.world, folder)) as desk:
        verdict = desk.run(deaths, case.goal)
    if "lie" in case.world.get("faults", {}):
        verdict = verdict._replace(falls=())  # what a server that lies reports of a fall is no report
    return verdict, desk


def test_a_process_killed_with_a_thing_in_the_hand_is_followed_by_one_that_ends_the_work(tmp_path: Path) -> None:
    """The arm finishes its grasp alone, and waits with the thing in its hand."""
    verdict, desk = killed(tmp_path, ON, [Death("hand", 3, "later", 0.002, 8.0)])
    assert desk.held_at_death[0]
    assert (verdict.outcome, verdict.unmet, verdict.faults) == ("succeeded", (), [])
    assert [each.action for each in desk.onlooker.goals.values()] == ["/pick_at", "/place_at"], "the grasp is found"


@pytest.mark.drill
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("with_faults", [False, True], ids=["whole", "faults"])
def test_whenever_it_is_killed_the_run_claims_what_is_so(tmp_path: Path, *, with_faults: bool) -> None:
    """`RAI_MISSIONS_KILLED_RUNS` runs from `RAI_MISSIONS_SEED` on, each killed up to three times."""
    first, count = (int(os.environ.get(f"RAI_MISSIONS_{name}", usual)) for name, usual in SIZES.items())
    wrong, kills, held, ends = [], 0, 0, dict[str | None, int]()
    for seed in range(first, first + count):
        folder = tmp_path / str(seed)
        folder.mkdir()
        deaths = drawn_deaths(random.Random(f"far {seed}"))
        verdict, desk = killed(folder, seed, deaths, with_faults=with_faults)
        kills, held = kills + len(desk.held_at_death), held + sum(map(bool, desk.held_at_death))
        ends[verdict.outcome] = ends.get(verdict.outcome, 0) + 1
        missed = verdict.outcome == "failed" and not verdict.unmet
        wrong += [f"{seed}: {each}" for each in (*verdict.faults, *(["it is so, and failed"] if missed else []))]
        print(f"{seed}: {verdict.outcome}, {verdict.why}; {kills} kills, {held} with a thing held", flush=True)  # noqa: T201 - the figures
    print(ends, f"{kills} kills, {held} with a thing held")  # noqa: T201
    assert not wrong, "\n".join(wrong)
