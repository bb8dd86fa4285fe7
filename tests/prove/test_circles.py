# SPDX-License-Identifier: Apache-2.0
"""Circles within one step: the explorer comes to where the real chart comes, at whichever limit that is."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.environment.environment import Environment
from tests.sampled import sampled

Json = dict[str, Any]
NEVER: Json = {"check": {"key": "n", "<": 0}}


def failing(tree: Json, failed: str, *, between: bool = False) -> Mission:
    """A tree that fails at once, and what is done then; `between`, another state is on the way back."""
    transitions: list[Json] = [{"on": ["succeeded", "timed_out"], "to": "over"}, {"on": "go", "to": "there"}]
    transitions.append({"on": "failed", "to": "between" if between else failed})
    return Mission.model_validate({
        "format": 1, "name": "failing", "initial": "going", "events": {"go": {}},
        "blackboard": {"n": {"type": "integer", "initial": 0}},
        "states": {"going": {"tree": tree, "transitions": transitions}, "over": {"final": "aborted"}, "there": {},
                   "between": {"transitions": [{"when": {"key": "n", ">=": 0}, "to": failed}]}},
    })  # fmt: skip


BETWEEN = [pytest.param(rounds, marks=pytest.mark.drill) for rounds in (6, 7, 9, 20)]


@pytest.mark.parametrize("between", [False, True])
@pytest.mark.parametrize("rounds", [*sampled([2, 3, 4, 5, 13, 333], 2), *BETWEEN])
@pytest.mark.parametrize("inner", [1, 3])
def test_a_circle_comes_to_the_limit_of_the_real_chart(rounds: int, inner: int, *, between: bool) -> None:
    tree: Json = {"retry": rounds, "child": NEVER if inner == 1 else {"retry": inner, "child": NEVER}}
    mission = failing(tree, "going", between=between)
    chart, free = Chart(mission), Environment(mission)
    step = chart.start()
    free.make(free.begin)
    found = free.chart
    assert (found.outcome, found.cause, found.active) == (step.outcome, chart.cause, chart.active)
    assert [each.tree.nodes for each in found.state.running.values()] == [
        {path: {**memory, **({"began": 1e6} if "began" in memory else {})} for path, memory in each.tree.nodes.items()}
        for each in chart.state.running.values()
    ]


@pytest.mark.long
def test_many_rounds_at_once_are_not_left_out_where_the_tree_rests_among_them() -> None:
    mission = failing({"retry": 20_005, "child": NEVER}, "over")
    proof = prove(mission)
    chart = Chart(mission)
    chart.start()
    assert "there" in chart.send(Event("go", 0.0)).entered
    assert "there" not in proof.never and proof.alike == {}
