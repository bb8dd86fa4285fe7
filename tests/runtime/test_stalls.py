# SPDX-License-Identifier: Apache-2.0
"""However late a run comes to look, the same happens at the same instants: who looks on, writes or thinks may stall."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine.decision import Question
from rai_missions.engine.semantics import macrostep as microsteps
from rai_missions.engine.semantics import timing as instants
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.laws.drawn import GRID_S, DrawnEvent, document, happenings, is_far
from tests.rigs.charts import ScriptedRobot
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import Rig

Json = dict[str, Any]
STALLS = (1, 2, 4, 10)
"""So many periods of the world a stall may last."""
FROM_OUTSIDE = ("event", "write", "command", "doubt")
"""What comes at instants that do not depend on what the run does."""


class World:
    """A clock by which things happen at their instants, anyone who may be stalled meanwhile."""

    def __init__(self, script: list[DrawnEvent]) -> None:
        self._script, self._periods = list(script), 0
        self.post: Callable[[Event], None]

    def now(self) -> float:
        return self._periods * GRID_S

    def step(self) -> None:
        self._periods += 1
        while self._script and self._script[0].at <= self.now():
            self.post(ScriptedRobot("agent").event(*self._script.pop(0)))

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        while mailbox.empty and self.now() < until:
            self.step()

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """Time moves while the run waits, and while it is stalled."""


class Trace(NamedTuple):
    """What a run was, without the ticks by which time was reported."""

    events: tuple[Any, ...]
    """Each event from outside that the run outlived, with the states that were active after it."""
    moves: tuple[Any, ...]
    end: tuple[str, str]
    board: Mapping[str, Any]
    """The values with their stamps: an entry that writes a key shows its instant."""


class Stalling:
    """Anyone who is called on the run's thread, and takes its time there now and then."""

    def __init__(self, world: World, rng: random.Random, share: float) -> None:
        self._world, self._rng, self._share = world, rng, share

    def stall(self, *_given: object) -> None:
        if self._rng.random() < self._share:
            for _period in range(self._rng.choice(STALLS)):
                self._world.step()

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self.stall()

    def withdraw(self, number: int) -> None:
        self.stall()


def traced(seed: int, share: float) -> Trace:
    """A run of what a number draws, of which a share of all calls stalls."""
    rng = random.Random(seed)
    mission = Mission.model_validate(document(rng, alone=True))
    script = [each for each in happenings(rng) if each.drawn[0] in FROM_OUTSIDE]
    script = [each._replace(at=each.at + GRID_S) for each in script]  # what is reported before the start has no instant
    end = (script[-1].at if script else 0.0) + 4.0
    world = World([*script, DrawnEvent(("command", "cancel"), end)])
    late, book = Stalling(world, random.Random(seed + 1), share), MemoryJournal()
    steps: list[tuple[Step, frozenset[str]]] = []
    book.on_write = late.stall

    def look(step: Step) -> None:
        steps.append((step, runner.view.active))
        if step.event.kind != "command" or step.event.name != "start":
            late.stall()

    runner = Runner(
        mission,
        clock=world,
        journal=book,
        begin=NewRun(named={"is_far": is_far}),
        observer=RunObserver(look),
        answerers={"agent": late, "rules": late},
    )
    world.post = runner.post
    result = runner.run()
    results = [(step.event, active) for step, active in steps if step.event.kind != "tick" and step.outcome is None]
    moves = tuple(move for step, _ in steps for move in step.moves)
    return Trace(tuple(results), moves, (result.outcome, result.why), dict(runner.view.board))


def agree(seed: int) -> None:
    with pytest.MonkeyPatch.context() as limits:  # what goes round for ever is found sooner
        for module in (microsteps, instants):
            limits.setattr(module, "MOST_MICROSTEPS", 100)
        at_once = traced(seed, 0.0)
        if "without end" not in at_once.end[1]:
            assert traced(seed, 0.4) == at_once


@given(st.integers(0, 2**32))
@settings(max_examples=15)
def test_stalls_change_nothing_of_what_comes_from_outside(seed: int) -> None:
    agree(seed)


@pytest.mark.drill
def test_five_thousand_runs_are_the_same_with_stalls() -> None:
    for seed in range(5_000):
        agree(seed)


def test_who_looks_on_for_long_does_not_make_a_run_miss_what_came_meanwhile() -> None:
    """The fact comes while the timer is overdue, and would be another one if it were looked at later."""
    states = {
        "s1": {"transitions": [{"after_s": 1, "to": "s2"}]},
        "s2": {
            "transitions": [{"when": {"key": "there", "==": True}, "to": "caught"}, {"after_s": 0.5, "to": "missed"}]
        },
        "caught": {"final": "aborted"},
        "missed": {"final": "failed"},
    }

    def look(step: Step) -> None:
        if step.event.name == "go":
            for _ in range(6):
                rig.stage.step()

    moments = {0.9: lambda: rig.post("go"), 1.3: lambda: rig.publish("/there", data=True)}
    rig = Rig(states, moments, on_step=look)
    result: Result = rig.run()
    assert result.outcome == "aborted"
