# SPDX-License-Identifier: Apache-2.0
"""What `prove` and `check` call impossible is never seen in a run of a drawn mission, whatever ticks its trees.

With lists, trees, regions, decisions, goals and inclusions; pauses, holds, and charts that are restored on the way.
"""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove
from rai_missions.trees import PyTrees
from tests.laws.drawn import KEYS, document, happenings, robot_facts
from tests.laws.test_cut_short import NAMED, drawn, private_as, through_json
from tests.rigs.charts import ScriptedRobot
from tests.rigs.turns import sooner_ended

STATES, WORK, WALKS = 150, 2_000, 5
SENSED = frozenset(name for name, key in KEYS.items() if key.get("source") == "robot")
NEVER = ("impossible-guard", "overlapping-transition")
"""Rules of `check` by which a transition is never taken."""


class Impossible(NamedTuple):
    """What no run may show."""

    entered: frozenset[str]
    taken: frozenset[str]
    """Places of transitions."""
    fired: frozenset[tuple[str, str]]
    """Places of transitions, each with a word of its `on`."""
    claims: frozenset[str]
    """Claims that were proved, so that none of them is seen broken."""
    assumed: frozenset[str]


def impossible(mission: Mission, proof: Proof) -> Impossible:
    """What is called impossible; where both speak of a state, they agree."""
    states = {place: name for place, name, state in mission.walk() if state.word != "history"}
    found, taken, fired = set[str](), set[str](), set[tuple[str, str]]()
    for finding in check(mission):
        transition = re.match(r".*/transitions/\d+", finding.place)
        if finding.rule == "unreachable-state" and finding.place in states:
            found.add(states[finding.place])
        elif finding.rule in NEVER and transition:
            taken.add(transition[0])
        elif finding.rule == "deaf-transition" and transition and " reports " in finding.sentence:
            words = finding.sentence.partition(" reports ")[2].partition(";")[0]
            fired |= {(transition[0], word) for word in re.findall(r"'(\w+)'", words)}
    assert not proof.is_whole or proof.sampled or found <= set(proof.never)
    proved = frozenset(each.name for each in proof.claims if each.verdict == "proved")
    return Impossible(
        frozenset(found.union(proof.never)), frozenset(taken), frozenset(fired), proved, frozenset(proof.assumed)
    )


def walked(mission: Mission, private: frozenset[str], facts: RobotFacts, rng: random.Random) -> Iterator[Step | Chart]:
    """The steps of a run, then its chart after an e-stop; only the robot writes what it senses."""
    kinds, robot = (CompiledTrees, PyTrees), ScriptedRobot("agent")
    script = [each for each in happenings(rng) if each.drawn[0] != "write" or each.drawn[1] in SENSED]
    chart = Chart(mission, rng.choice(kinds)(), robot_facts=facts, named=NAMED)
    yield robot.follow(chart.start(0.0))
    for happening in script:
        if rng.random() < 0.3:
            saved = through_json(chart)
            chart = Chart.restore(mission, saved, rng.choice(kinds)(), robot_facts=facts, named=NAMED)
        if chart.outcome is None:
            yield robot.follow(chart.send(private_as(robot.event(*happening), private)))
    for _ in range(5):
        if chart.outcome is None and chart.wake_at is not None:
            yield robot.follow(chart.send(Tick(chart.wake_at)))
    if chart.outcome is None:
        yield chart.send(Event("kill", chart.at, {"by": "operator"}, "command"))
    yield chart


def seen(never: Impossible, run: Iterator[Step | Chart]) -> Iterator[str]:
    """What a run shows that was called impossible."""
    for each in run:
        if isinstance(each, Chart):
            rests = "comes to rest" if each.cause == "cycle" else ""
            broken = "invariants" if each.cause == "invariant" and each.false_invariant not in never.assumed else ""
            yield from never.claims & {rests, broken, "stop" if each.outcome is None else ""}
            continue
        yield from never.entered.intersection(each.entered)
        for move in each.moves:
            yield from never.taken.intersection(move.taken)
            yield from (
                f"{place} by {word}" for place, word in never.fired & {(one, move.trigger) for one in move.taken}
            )


@sooner_ended()
def hold(folder: Path, seeds: Iterable[int]) -> Counter[str]:
    count = Counter[str]()
    for seed in seeds:
        rng = random.Random(seed)
        made, facts = document(rng, trees=seed % 3 == 0, alone=seed % 5 == 0, wishes=seed % 7 == 0), robot_facts(rng)
        try:
            mission, private = drawn(rng, folder, made, is_included=bool(seed % 2))
        except DefinitionError:
            continue
        proof = prove(mission, CompiledTrees(), robot_facts=facts, most=STATES, work=WORK)
        never = impossible(mission, proof)
        for number in range(WALKS):
            found = set(seen(never, walked(mission, private, facts, random.Random(1000 * seed + number))))
            assert not found, (seed, number, found)
        count.update(missions=1, whole=proof.is_whole, proved=len(never.claims), never=len(never.entered))
        count.update(taken=len(never.taken), fired=len(never.fired))
    return count


def test_no_run_shows_what_was_called_impossible(tmp_path: Path) -> None:
    count = hold(tmp_path, [*range(30, 35), *range(44, 49)])
    assert min(count.values()) > 0 and len(count) == 6, count


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_no_run_of_two_thousand_missions_shows_what_was_called_impossible(tmp_path: Path) -> None:
    count = hold(tmp_path, range(10_000, 12_000))
    assert count["whole"] > 0.2 * count["missions"], count
