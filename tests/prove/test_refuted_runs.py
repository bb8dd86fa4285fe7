# SPDX-License-Identifier: Apache-2.0
"""A refutation whose journal shows the flaw happens to a run of the mission, and whichever ticks its trees.

Rule: no key of the robot must be there before the start, since a run would wait for it; no predicate is asked.
"""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from rai_missions.journal import Header, StepRow, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import TraceStep, prove, record
from rai_missions.replay.rebuild import JournalReplayer
from rai_missions.trees import PyTrees
from tests.laws.drawn import document
from tests.prove.rerun import Rerun, moved
from tests.prove.walks import walkable
from tests.rigs.turns import sooner_ended

OTHERS = ("control", "behaviour", "doubt", "lost", "refused", "orphaned")
"""Kinds of events that no message, report, answer or order brings about by itself."""


def made(seed: int) -> list[Mission]:
    """A mission with every kind of guard, state and effect, and two small ones that come round."""
    drawn: list[Any] = [document(random.Random(seed), trees=seed % 2 == 0), walkable(seed), walkable(seed + 10**5)]
    for each in drawn:
        keys = each["blackboard"] = {name: dict(key) for name, key in each["blackboard"].items()}
        for key in keys.values():
            key.update({"optional": True} if key.get("source") == "robot" else {})
    missions = [Mission.model_validate(each) for each in drawn]
    return [mission for mission in missions if not mission.predicates()]


def happens(mission: Mission, run: list[TraceStep], path: Path) -> str:
    """Have a refutation happen again; `same`, or why it was not compared."""
    with sooner_ended():
        if not record(path, Header(dump(mission)), mission, run):
            return "not shown"
        with read(path) as written:
            rows = [row for row in written.entries() if isinstance(row, StepRow)]
            replayer = JournalReplayer(written, mission, PyTrees())
            for row in rows:
                again = replayer.again(row)
                assert again == row.step or replayer.chart.cause == "cycle", (path.name, row.step)
        if any(row.step.event.kind in OTHERS for row in rows):
            return "by others"
        rerun = Rerun(mission, rows)
        rerun.play()
    expected = moved(row.step for row in rows)
    assert moved(rerun.steps)[: len(expected)] == expected, path.name
    return "same"


def found(seeds: range, folder: Path) -> Counter[str]:
    """Each refutation of these missions."""
    return Counter(
        happens(mission, run, folder / f"{number} {index} {claim}.journal")
        for number in seeds
        for index, mission in enumerate(made(number))
        for claim, run in prove(mission, most=80, work=1_200).ways.items()
    )


def test_a_refutation_happens_to_a_run_and_whichever_ticks_its_trees(tmp_path: Path) -> None:
    assert found(range(2), tmp_path)["same"] > 2


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_many_refutations_happen_to_a_run_and_whichever_ticks_its_trees(tmp_path: Path) -> None:
    assert found(range(2, 400), tmp_path)["same"] > 500
