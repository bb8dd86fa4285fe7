# SPDX-License-Identifier: Apache-2.0
"""Results that come again, or of what was never started, change nothing, whatever was canceled, left or paused.

Amid regions, trees, timeouts and holds; the chart that receives them goes through JSON on the way, and its trees change
hands. The oracle is the chart that receives each result once.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.trees import PyTrees
from tests.laws.drawn import RESULTS, DrawnEvent, document, happenings, robot_facts
from tests.laws.test_cut_short import NAMED, done, drawn, private_as, remembered, through_json
from tests.laws.test_instants import AFTER_S
from tests.rigs.charts import UNKNOWN, ScriptedRobot
from tests.rigs.turns import sooner_ended

KINDS = (CompiledTrees, PyTrees)
ENDS = ("result", "result", "result", "accepted")


def again(rng: random.Random, at: float, over: list[Event]) -> Iterator[Event]:
    """What comes a second time, or of no start: the same end, or another one."""
    for each in rng.sample(over, min(len(over), rng.randint(0, 2))):
        kind = rng.choice(ENDS)
        yield each._replace(at=at, kind=kind, name=rng.choice([each.name, *RESULTS]) if kind == "result" else each.name)
    if rng.random() < 0.3:
        yield Event(rng.choice(RESULTS), at, {"n": 1}, "result", UNKNOWN)


@sooner_ended()
def agree(folder: Path, seed: int) -> Counter[str]:
    """Run a mission with and without them."""
    rng, found = random.Random(seed), Counter[str]()
    made, script, facts = document(rng, trees=seed % 2 == 0), happenings(rng), robot_facts(rng)
    results = [DrawnEvent(("result", rng.randint(0, 1), rng.choice(RESULTS), 1), each.at) for each in script]
    script = sorted([*script, *results[::2]], key=lambda each: each.at)
    try:
        mission, private = drawn(rng, folder, made, is_included=bool(seed % 3 == 0))
    except DefinitionError:
        return found
    plain, noisy = (Chart(mission, KINDS[0](), robot_facts=facts, named=NAMED) for _ in range(2))
    robot, over = ScriptedRobot("agent"), list[Event]()
    robot.follow(plain.start(0.0))
    noisy.start(0.0)
    for number, happening in enumerate([*script, DrawnEvent(("tick",), script[-1].at + AFTER_S)]):
        if rng.random() < 0.5:
            noisy = Chart.restore(mission, through_json(noisy), KINDS[number % 2](), robot_facts=facts, named=NAMED)
        for chart in (plain, noisy):
            step = chart.send(Tick(happening.at))
            robot.follow(step) if chart is plain else None
        for each in again(rng, happening.at, over):
            step = noisy.send(each)
            assert not (step.moves or step.effects or step.writes or step.verdicts), (seed, number, each)
            found[f"again {noisy.mode}"] += 1
        event = private_as(robot.event(*happening), private)
        steps = plain.send(event), noisy.send(event)
        robot.follow(steps[0])
        if plain.cause == "cycle":
            return found
        assert done(steps[0]) == done(steps[1]), (seed, number)
        if event.kind == "result" and event.number != UNKNOWN and not any(each.number == event.number for each in over):
            over.append(event)
            found["results"] += 1
    waiting = "'_queue'"  # what comes in a pause waits there, and changes nothing when its time has come
    assert remembered(plain) | {waiting: ()} == remembered(noisy) | {waiting: ()}, seed
    return found


@pytest.mark.parametrize("first", range(0, 40, 10))
def test_a_result_that_comes_again_changes_nothing(first: int, tmp_path: Path) -> None:
    found = sum((agree(tmp_path, seed) for seed in range(first, first + 10)), Counter[str]())
    assert found["again running"], found


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_results_that_come_again_change_nothing_in_five_thousand_missions(tmp_path: Path) -> None:
    found = sum((agree(tmp_path, seed) for seed in range(1_000, 6_000)), Counter[str]())
    assert min(found[f"again {mode}"] for mode in ("running", "paused", "canceling")) > 50, found
