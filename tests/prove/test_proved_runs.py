# SPDX-License-Identifier: Apache-2.0
"""What `prove` and `check` call impossible is never seen in a run on a robot, whatever is answered to its questions.

Messages are lost, late, repeated or garbled, people order, and the run may be killed and continued; who is asked
answers what was not offered, what was asked before, twice, late, or with what is no answer.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine.decision import Question
from rai_missions.engine.trees import CompiledTrees
from rai_missions.profile import robot_facts
from rai_missions.prove import prove
from tests.laws import test_side_by_side
from tests.laws.test_side_by_side import Land, Thinker
from tests.prove.test_drawn_walks import STATES, WORK, impossible, seen
from tests.rigs.turns import Turns, sooner_ended

QUICK = (14, 20, 24, 25, 33, 47, 50)
"""Missions of which much is proved, and one whose questions are answered often."""
ANSWERS: tuple[Mapping[str, Any], ...] = (
    {"option": "left"}, {"option": "right"}, {"option": "stay"}, {"option": "succeeded"}, {"option": ""}, {},
    {"option": ["left"]}, {"option": "left", "parameters": {"given": "all"}}, {"option": "left", "parameters": 3},
    {"set_state": "done", "option": "done"}, {"failed": "it is hostile"},
)  # fmt: skip


class HostileThinker(Thinker):
    """Answers anything, as often as it likes, and later than it was asked for."""

    def __init__(self, turns: Turns, seed: str) -> None:
        super().__init__(turns, seed)
        self._time, self._name = turns, seed
        self._earlier: list[Callable[[Mapping[str, Any]], None]] = []

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        chance = random.Random(f"{self._name} {question.state} {question.number} {self._time.at}")
        self._earlier.append(answer)
        offered = [{"option": each.name} for each in question.options]
        for _ in range(chance.choice([0, 1, 1, 2, 5])):
            whose = chance.choice([answer, answer, *self._earlier])
            what = chance.choice([*offered, *ANSWERS])
            self._time.call_later(chance.choice([0.0, 0.25, 0.5, 3.0]), lambda whose=whose, what=what: whose(what))


@sooner_ended()
def hold(folder: Path, seeds: Iterable[int]) -> Counter[str]:
    """Prove drawn missions, and run each; gives what was shown to be impossible, and what happened."""
    count = Counter[str]()
    for seed in seeds:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(test_side_by_side, "Thinker", HostileThinker)
            (life,) = Land(seed, ("one",), folder).lives
        proof = prove(life.mission, CompiledTrees(), robot_facts=robot_facts(life.robot), most=STATES, work=WORK)
        never = impossible(life.mission, proof)
        found = set(seen(never, iter(life.steps)))
        view = life.runner.view
        if view.cause == "invariant" and view.false_invariant not in never.assumed:
            found |= never.claims & {"invariants"}
        if view.cause == "cycle":
            found |= never.claims & {"comes to rest"}
        assert not found, (seed, found)
        count.update(missions=1, whole=proof.is_whole, proved=len(never.claims), never=len(never.entered))
        count.update(steps=len(life.steps), verdicts=sum(len(step.verdicts) for step in life.steps))
        (folder / "one.journal").unlink(missing_ok=True)
    return count


def test_no_run_on_a_robot_shows_what_was_called_impossible(tmp_path: Path) -> None:
    count = hold(tmp_path, QUICK)
    assert min(count.values()) > 0 and len(count) == 6, count


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_no_run_of_a_thousand_missions_on_a_robot_shows_what_was_called_impossible(tmp_path: Path) -> None:
    count = hold(tmp_path, range(1_000, 2_000))
    assert count["whole"] > 100 and count["verdicts"] > 1_000, count
