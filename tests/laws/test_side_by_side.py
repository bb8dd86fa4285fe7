# SPDX-License-Identifier: Apache-2.0
"""Several runs on one connector, in one process: each does what it does alone, whatever becomes of the others."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.agents.talk.orders import RunOrders
from rai_missions.connectors.chaos import ChaosConnector
from rai_missions.connectors.connector import Connector, Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.conversation import Order
from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, opened
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.replay.resume import Resumption, resumption
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.laws.drawn import EVENTS, KEYS, document, is_far
from tests.laws.test_cut_short import plain
from tests.laws.test_cut_short import profile as profile_of
from tests.replay.mortal import Fate, Mortal, MortalClock
from tests.rigs.journals import MemoryJournal, assert_whole
from tests.rigs.turns import Turns, sooner_ended
from tests.strategies import SIGHTS

Json = dict[str, Any]
NAMES = ("one", "two")
NAMED = {"is_far": is_far}
STRING, TRIGGER = "std_msgs/msg/String", "std_srvs/srv/Trigger"
CANCELED_S, KILLED_S, OVER_S = 30.0, 45.0, 90.0
"""When a run is canceled, and killed, that does not end by itself; and when all are over."""
SAME = 0.3
"""Of so many pairs both runs have the same mission."""
DISTURBED = 0.4
"""Of so many runs what is sent and received is lost, late, repeated or garbled on the way."""
COMMANDS = ("pause", "pause", "resume", "resume", "resume", "stop", "cancel")
DEATHS = ("", "", "", "", "kill", "disk", "raises", "hangs", "killed")
"""How a run dies: not at all, by an e-stop, since nothing can be written, by an error in its loop, by a loop that
never comes back, and by a kill of its process, after which another one continues."""


def robot(rng: random.Random, mission: Mission) -> Robot:
    """A profile for a drawn mission, each of whose facts has a topic of its own."""
    made = profile_of(rng, mission)
    topics = {name: {"topic": f"/{name}", "type": STRING, "json": True} for name in made.blackboard}
    return Robot.model_validate(made.model_dump(by_alias=True, exclude_unset=True) | {"blackboard": topics})


class Server:
    """An action's server; what it makes of a goal follows from the instant at which it comes."""

    def __init__(self, turns: Turns, seed: str) -> None:
        self._turns, self._seed = turns, seed
        self._reports: dict[str, Callable[[Report], None]] = {}
        self._over = set[str]()

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        chance = random.Random(f"{self._seed} {self._turns.at}")
        self._reports[goal_id] = report
        if chance.random() < 0.1:
            self._later(0.25, goal_id, "rejected")
            return
        self._later(0.25, goal_id, "accepted")
        if chance.random() < 0.8:
            self._later(chance.choice([0.5, 1.0, 3.0]), goal_id, chance.choice(["succeeded", "succeeded", "failed"]))

    def cancel(self, goal_id: str) -> None:
        if random.Random(f"{self._seed} cancel {self._turns.at}").random() < 0.8:
            self._later(0.5, goal_id, "canceled")

    def _later(self, seconds: float, goal_id: str, status: Any) -> None:
        self._turns.call_later(seconds, lambda: self._report(goal_id, status))

    def _report(self, goal_id: str, status: Any) -> None:
        if goal_id not in self._over:
            if status != "accepted":
                self._over.add(goal_id)
            self._reports[goal_id](Report(goal_id, status, {"n": 1}))


class Thinker:
    """Answers a question later, or never; what, follows from the question and its instant."""

    def __init__(self, turns: Turns, seed: str) -> None:
        self._turns, self._seed = turns, seed

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        chance = random.Random(f"{self._seed} {question.state} {question.number} {self._turns.at}")
        if chance.random() < 0.8:
            option = chance.choice([*question.options]).name if question.options else "left"
            self._turns.call_later(chance.choice([0.25, 0.5, 2.0]), lambda: answer({"option": option}))

    def withdraw(self, number: int) -> None:
        """It may answer nevertheless."""


class Died(BaseException):
    """What ends a run's loop."""


class Life(NamedTuple):
    """What one run came to."""

    steps: list[Any]
    results: list[Result]
    orders: list[Any]
    """What was reported of each."""
    error: str
    """What ended its loop."""


def lasting(rng: random.Random) -> Mission:
    """A drawn mission that acts, and does not end in the step in which it begins."""
    while True:
        made = document(rng)
        chart = Chart(mission := Mission.model_validate(made), named=NAMED)
        if '"action"' in json.dumps(made) and chart.start(0.0).outcome is None:
            return mission


class Lives:
    """One run in the land, from its start to its end.

    Args:
        name: Its identity.
        seed: Its mission, what is ordered in it, and how it dies.
        land: Where it lives.
        folder: For its journal.
    """

    def __init__(self, name: str, seed: int, land: Land, folder: Path) -> None:
        rng, is_same = random.Random(f"{seed} {name}"), random.Random(seed).random() < SAME
        self.name, self.land = name, land
        self.mission = lasting(random.Random(f"{seed} mission" if is_same else f"{seed} {name} mission"))
        self.robot = robot(rng, self.mission)
        self.death, self._dies_at = rng.choice(DEATHS), rng.choice([0.5, 1.0, 2.0, 5.0, 8.0])
        self.is_disturbed, self._processes = random.Random(f"{seed} {name} way").random() < DISTURBED, 0
        self.steps: list[Step] = []
        self.ends: list[Any] = []
        self.results: list[Result] = []
        self.path = folder / f"{name}.journal"
        journal: Any = MemoryJournal(rng.randint(1, 12) if self.death == "disk" else 10**9)
        if self.death == "killed":
            header = Header(dump(self.mission), dump_profile(self.robot), run=name)
            journal = Journal.create(self.path, header)
        self._schedule(rng)
        self._begin(NewRun(named=NAMED, run=name), journal)

    def _begin(self, begin: NewRun | Resumption, journal: Any) -> None:
        """Begin, or continue, in a process of its own."""
        self.fate = fate = Fate()
        self.journal = journal

        def make(clock: Clock) -> Callable[[], object]:
            connector: Any = Mortal(self._way(), fate)
            thinkers = {who: Thinker(self.land.turns, f"{self.name} {who}") for who in ("agent", "rules")}
            self.runner = runner = Runner(
                self.mission,
                robot=self.robot,
                connector=connector,
                clock=MortalClock(clock, fate),
                journal=Mortal(journal, fate),
                answerers={who: Mortal(each, fate) for who, each in thinkers.items()},
                begin=begin,
                observer=RunObserver(self._step),
            )
            return lambda: self.results.append(runner.run())

        self.seat = self.land.turns.begin(make)
        self.orders = RunOrders(self.runner)

    def _way(self) -> Connector:
        """How the robot is reached from this process."""
        self._processes += 1
        if not self.is_disturbed:
            return self.land.connector
        seed = f"{self.name} {self._processes}"
        return ChaosConnector(self.land.connector, seed, later=self.land.turns.call_later)

    def _step(self, step: Step) -> None:
        self.steps.append(step)
        self.orders.step(step)

    def _schedule(self, rng: random.Random) -> None:
        turns, at = self.land.turns, 0.0
        for number in range(rng.randint(2, 12)):
            at += rng.choice([0.0, 0.25, 0.5, 1.0, 2.0])
            if rng.random() < 0.6:
                name, k = rng.choice(EVENTS), rng.randint(0, 2)
                turns.call_at(at, lambda name=name, k=k: self._post(name, k))
            else:
                order = Order(number, rng.choice(COMMANDS), "operator", "terminal", "Anna")  # type: ignore[arg-type]
                turns.call_at(at, lambda order=order: self._order(order))
        turns.call_at(CANCELED_S, lambda: self.runner.cancel())
        turns.call_at(KILLED_S, lambda: self.runner.kill())
        turns.call_at(self._dies_at, self._die)

    def _post(self, name: str, k: int) -> None:
        self.runner.post(Event(name, self.land.turns.at, {"k": k}))

    def _order(self, order: Order) -> None:
        self.orders.perform(order, lambda result: self.ends.append((order.number, order.name, result.refused)))

    def _die(self) -> None:
        """It dies, where it is to."""
        if self.death == "kill":
            self.runner.kill("test")
        elif self.death == "raises":
            self.runner.call_soon(_raise)
        elif self.death == "hangs":
            self.seat.is_left = True
        elif self.death == "killed" and not self.seat.is_over:
            self.end()
            self.land.turns.call_later(1.0, self._continue)

    def end(self) -> None:
        """Kill its process."""
        self.fate.is_dead = True
        while not self.seat.is_over:
            self.seat.turn()
        if isinstance(self.journal, Journal):
            self.journal.close()

    def _continue(self) -> None:
        with opened(self.path) as record:
            resumed = resumption(record, self.mission, named=NAMED)
            self._begin(resumed, Journal.open(self.path, seal=record.seal))

    def life(self) -> Life:
        """What it came to."""
        self.orders.close()
        results = [result._replace(journal=None) for result in self.results]
        return Life([done(step) for step in self.steps], results, self.ends, repr(self.seat.error))


def _raise() -> None:
    raise Died


def done(step: Step) -> Any:
    """What a step did."""
    return plain(without_request(step))


def without_request(step: Step) -> Step:
    """A step, but for the name of its request, which differs between any two runs."""
    data = {name: value for name, value in step.event.data.items() if name != "request"}
    return step._replace(event=step.event._replace(data=data))


class Surroundings:
    """A robot in one process: its facts, and its servers.

    Args:
        turns: When things happen.
        seed: Of what it reports, and of how its goals end.
    """

    def __init__(self, turns: Turns, seed: int) -> None:
        self._turns = turns
        self.connector = LocalConnector(now=turns.now)
        self.connector.start()
        for action in ("drive", "turn", "composed"):
            self.connector.offer(f"/{action}", "x/action/X", Server(turns, f"{seed} {action}"))
        controls = (f"to_{who}" for who in ("agent", "autonomy", "operator", "nobody"))
        for service in ("horn", "drive", "drive_stop", "turn_stop", "composed", "composed_stop", *controls):
            self.connector.serve(f"/{service}", TRIGGER, lambda _: {"success": True, "message": ""})
        self._play(random.Random(seed))

    def _play(self, rng: random.Random) -> None:
        facts: Json = {name: key for name, key in KEYS.items() if key.get("source") == "robot"}
        at = 0.0
        for _ in range(rng.randint(4, 30)):
            at += rng.choice([0.0, 0.25, 0.5, 1.0])
            name = rng.choice(sorted(facts))
            values: Json = {"boolean": rng.random() < 0.6, "integer": rng.randint(0, 3), "pose": {"x": 0.1, "y": 0.0}}
            value = values.get(facts[name]["type"]) if facts[name]["type"] in values else rng.choice(SIGHTS)
            self._turns.call_at(at, lambda name=name, value=value: self._report(name, value))

    def _report(self, name: str, value: Any) -> None:
        self.connector.publish(f"/{name}", STRING, {"data": json.dumps(value)})


class Land:
    """Runs on one robot.

    Args:
        seed: The seed of the robot and of the runs.
        names: The runs.
        folder: For journals.
    """

    def __init__(self, seed: int, names: tuple[str, ...], folder: Path) -> None:
        self.turns = Turns()
        self.connector = Surroundings(self.turns, seed).connector
        self.lives = [Lives(name, seed, self, folder) for name in names]
        self.turns.play(OVER_S)
        for life in self.lives:
            life.end()


@sooner_ended()
def agree(seed: int, folder: Path) -> Counter[str]:
    """Let two runs live next to each other, and each alone; it must come to the same. Gives how they died."""
    for name in ("both", *NAMES):
        (folder / name).mkdir(parents=True)
    found = Counter[str]()
    for life in Land(seed, NAMES, folder / "both").lives:
        (alone,) = Land(seed, (life.name,), folder / life.name).lives
        assert life.life() == alone.life(), (seed, life.name)
        found[life.death or "lived"] += 1
        found["disturbed"] += life.is_disturbed
        found["facts"] += sum(step.event.kind == "write" for step in life.steps)
        if life.death == "killed":
            assert_whole(life.path)
    return found


@pytest.mark.parametrize("seed", [0, 1, 2, pytest.param(3, marks=pytest.mark.long), 4])
def test_each_of_two_runs_does_what_it_does_alone(seed: int, tmp_path: Path) -> None:
    assert agree(seed, tmp_path)["facts"]


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_each_of_many_runs_next_to_another_does_what_it_does_alone(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(2_000):
        found += agree(seed, tmp_path / str(seed))
    assert min(found[each] for each in (*DEATHS, "disturbed") if each) > 100, found
