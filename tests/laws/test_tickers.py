# SPDX-License-Identifier: Apache-2.0
"""A mission does the same whichever ticks its trees, the chart or py_trees, and whichever of them continues with one.

Amid regions, timeouts, holds, histories and inclusions, and with what was written down after any step.
"""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.activities.tree import TreeActivity
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import DefinitionError
from rai_missions.trees import PyTrees
from tests.laws.drawn import DrawnEvent, document, happenings, robot_facts
from tests.laws.test_cut_short import NAMED, done, drawn, private_as, remembered, through_json
from tests.laws.test_instants import AFTER_S
from tests.rigs.charts import ScriptedRobot
from tests.rigs.turns import sooner_ended

KINDS = (CompiledTrees, PyTrees)


@sooner_ended()
def agree(folder: Path, seed: int) -> str:
    """Run a mission on both, and on one whose trees change hands after each step; gives whether a tree ran."""
    rng = random.Random(seed)
    made, script, facts = document(rng, trees=True), happenings(rng), robot_facts(rng)
    try:
        mission, private = drawn(rng, folder, made, is_included=bool(seed % 2))
    except DefinitionError:
        return "it cannot be included"
    ours, theirs, turned = (Chart(mission, kind(), robot_facts=facts, named=NAMED) for kind in (*KINDS, CompiledTrees))
    robot, found = ScriptedRobot("agent"), "no tree ran"
    assert robot.follow(ours.start(0.0)) == theirs.start(0.0) == turned.start(0.0)
    for number, happening in enumerate([*script, DrawnEvent(("tick",), script[-1].at + AFTER_S)]):
        found = "same" if any(isinstance(each, TreeActivity) for each in ours.state.running.values()) else found
        turned = Chart.restore(mission, through_json(turned), KINDS[number % 2](), robot_facts=facts, named=NAMED)
        event = private_as(robot.event(*happening), private)
        steps = ours.send(event), theirs.send(event), turned.send(event)
        robot.follow(steps[0])
        if ours.cause == "cycle":  # the states of one are named in the order of the alphabet
            return "it went round for ever"
        assert steps[0] == steps[1], (seed, number)
        assert done(steps[2]) == done(steps[0]), (seed, number)
        assert ours.snapshot() == theirs.snapshot(), (seed, number)
        assert remembered(turned) == remembered(ours), (seed, number)
    return found


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_a_mission_does_the_same_whichever_ticks_its_trees(first: int, tmp_path: Path) -> None:
    found = Counter(agree(tmp_path, seed) for seed in range(first, first + 10))
    assert found["same"] > 2, found


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_three_thousand_missions_do_the_same_whichever_ticks_their_trees(tmp_path: Path) -> None:
    found = Counter(agree(tmp_path, seed) for seed in range(1_000, 4_000))
    assert found["same"] > 1_000, found
