# SPDX-License-Identifier: Apache-2.0
"""What is active is found from what a step changes, and is what the innermost states and all around them come to."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.compiled import graph
from rai_missions.mission.mission import Mission
from tests.laws.drawn import document, happenings, is_far, robot_facts
from tests.rigs.charts import ScriptedRobot


def whole(chart: Chart) -> None:
    config, graph = chart.state.config, chart.program.graph
    around = {outer for node in config.atomic for outer in (node, *node.ancestors)}
    order = [node for node in graph.order if node in around] or [graph.root]
    assert [*config.order] == order
    assert [*config.atomic] == [node for node in order if node.state and not any(each.inside(node) for each in order)]
    assert chart.active == {node.name for node in around if node.state is not None}
    assert all(config.is_active(node) == (node in {graph.root, *around}) for node in graph.order)


@given(st.integers(0, 2**32), st.sampled_from([graph.FEW, 0.001]))
@settings(max_examples=20)
def test_each_configuration_is_that_of_its_innermost_states(seed: int, few: float) -> None:
    """Whichever way it is found: in a small mission each change is one of many states, unless that is never so."""
    rng = random.Random(seed)
    mission, facts = Mission.model_validate(document(rng)), robot_facts(rng)
    chart = Chart(mission, robot_facts=facts, named={"is_far": is_far} if "is_far" in mission.model_dump_json() else {})
    robot = ScriptedRobot("agent")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(graph, "FEW", few)
        robot.follow(chart.start(0.0))
        for happening in happenings(rng):
            robot.follow(chart.send(robot.event(*happening)))
            whole(chart)
