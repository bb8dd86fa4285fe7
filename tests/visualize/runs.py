# SPDX-License-Identifier: Apache-2.0
"""Missions and runs that the tests of pictures draw."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.step import Move, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

__all__ = ("ROOT", "document", "hostile", "run", "tractor", "tractor_path")

ROOT = Path(__file__).parents[2]


def document() -> dict[str, Any]:
    """The design's example as JSON has it."""
    found: dict[str, Any] = json.loads((ROOT / "tests/data/tractor_design.json").read_text(encoding="utf-8"))
    return found


def tractor() -> Mission:
    return Mission.model_validate(document())


def hostile() -> Mission:
    """A mission whose texts do their best to be read as something else."""
    text = (ROOT / "tests/visualize/hostile.json").read_text(encoding="utf-8")
    return Mission.model_validate(json.loads(text))


def run(mission: Mission, events: Sequence[str]) -> list[Step]:
    """The steps of a chart that receives events three seconds apart, and is sent the time in between."""
    chart = Chart(mission, ticker=CompiledTrees())
    steps = [chart.start(at=0.0)]
    for number, name in enumerate(events, start=1):
        for event in (Event(name, 3.0 * number, {}), Tick(3.0 * number + 1)):
            if not steps[-1].outcome:
                steps.append(chart.send(event))
    return steps


def tractor_path() -> list[Step]:
    """A run of the tractor as its journal has it: two anomalies, one crossed and one given up."""
    moves = [
        Move((), (), ("working", "driving")),
        Move(("/states/working/states/driving/transitions/0",), ("driving", "working"), ("assessing",), "anomaly"),
        Move(("/states/assessing/transitions/0",), ("assessing",), ("crossing",), "drive_over"),
        Move(("/states/crossing/transitions/1",), ("crossing",), ("working", "driving"), "succeeded"),
        Move(("/states/working/states/driving/transitions/0",), ("driving", "working"), ("assessing",), "anomaly"),
        Move(("/states/assessing/transitions/3",), ("assessing",), ("aborted",), "abort"),
    ]
    steps = [
        Step(seq, float(seq), Event(move.trigger or "start", float(seq)), (move,)) for seq, move in enumerate(moves, 1)
    ]
    return [*steps[:-1], steps[-1]._replace(outcome="aborted", why="'aborted' was reached")]
