# SPDX-License-Identifier: Apache-2.0
"""Runs missions in the yard under a hostile model, one after the other, and compares each with what is true.

Rule: nothing is asserted here; every fault is reported with the seed that makes it again.
"""

from __future__ import annotations

import json
import logging
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.model.tools import open_toolbox
from rai_missions.connectors.local import LocalConnector
from rai_missions.embodiment import Identity
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.replay import replay
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.drills.hostility import CANARIES, COMMANDS, MOST_CALLS, OWN, HostileModel, plant
from tests.drills.surroundings import quick_folder
from tests.drills.yard import DEADLINE_S, SLACK_S, Yard, yard_mission, yard_robot

__all__ = ("Drill", "Trial", "try_one")

LONGEST_SIM_S, LONGEST_WALL_S = 120.0, 60.0
PROFILES: tuple[Mapping[str, bool], ...] = (
    {}, {"image_inputs": True}, {"tool_calling": False, "structured_output": False},
    {"tool_calling": True, "structured_output": False, "image_inputs": True},
)  # fmt: skip
MISSION, ROBOT = yard_mission(), yard_robot()
WRITTEN = dump_profile(ROBOT)


class Log(logging.Handler):
    """Keeps all that is logged, whatever its level."""

    def __init__(self) -> None:
        super().__init__(0)
        self.text: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.text.append(self.format(record))


class MisnumberingAnswerer:
    """Passes questions on, and answers others next to: ones that were asked, will be asked, and never are."""

    def __init__(self, agent: DecisionAgent, random: Random) -> None:
        self._agent, self._random = agent, random
        self.runner: Runner | None = None

    def ask(self, question: Any, answer: Any) -> None:
        if self.runner is not None and self._random.random() < 0.3:
            number = question.number + self._random.choice([-3, -2, -1, 1, 2, 1000, -question.number])
            reported = {"option": self._random.choice(["cross", "finish", "detour"])}
            self.runner.post(Event("agent", self.runner.view.now(), reported, "proposal", number))
        self._agent.ask(question, answer)

    def withdraw(self, number: int) -> None:
        self._agent.withdraw(number)


@dataclass
class Trial:
    """One mission that was run."""

    seed: str
    result: Result
    yard: Yard
    steps: list[Step]
    model: Any
    wall_s: float
    faults: list[str] = field(default_factory=list)


def try_one(
    seed: str,
    folder: Path,
    *,
    shows: bool = False,
    mission: Mission | None = None,
    model: Any = None,
    deadline_s: float = DEADLINE_S,
) -> Trial:
    """Run one mission, and state what was wrong.

    Args:
        seed: All that happens follows from it, as far as threads allow.
        folder: Where its journal goes; emptied afterwards by anyone who made it.
        shows: Draw its page and its picture too.
        mission: Another than the yard's.
        model: Another than a hostile one of this seed.
        deadline_s: That of the mission's decision.
    """
    random, log, steps = Random(f"trial {seed}"), Log(), list[Step]()
    root = logging.getLogger()
    level = root.level
    root.addHandler(log)
    root.setLevel(logging.DEBUG)
    uncaught: list[str] = []
    excepthook, threading.excepthook = threading.excepthook, lambda found: uncaught.append(repr(found))
    try:
        trial = _run(seed, random, folder, steps, mission or MISSION, model)
        trial.faults += [f"uncaught in a thread: {each}" for each in uncaught]
        trial.faults += _wrong(trial, deadline_s)
        trial.faults += _leaks(folder, "\n".join([*log.text, *uncaught, repr(trial.result), repr(steps)]), shows=shows)
        again = replay(folder / "run.journal")
        if not again.holds or again.outcome != trial.result.outcome:
            trial.faults.append(f"its journal does not replay: {again.difference or again.outcome}")
        return trial
    finally:
        threading.excepthook = excepthook
        root.removeHandler(log)
        root.setLevel(level)


def _run(seed: str, random: Random, folder: Path, steps: list[Step], mission: Mission, model: Any) -> Trial:
    clock: list[Yard] = []
    connector = LocalConnector(now=lambda: clock[0].at)
    label = random.choice(["", "", *COMMANDS])
    yard = Yard(connector, seed, label=label, lies=random.choice([0.0, 0.0, 0.3]))
    clock.append(yard)
    connector.start()
    yard.open()
    words = {"streaming": True} if random.random() < 0.15 else {}
    hostile = HostileModel(seed, random.choice([0.3, 0.6, 1.0]), profile=random.choice(PROFILES), **words)
    model = model or hostile
    box = open_toolbox(mission, ROBOT, connector, lambda: yard.at)
    assert box is not None
    identity = Identity(f"You are a yard vehicle. {random.choice(COMMANDS)}")
    agent = DecisionAgent(model, identity, box.read_only)
    who = MisnumberingAnswerer(agent, random)
    began = time.monotonic()
    with Journal.create(folder / "run.journal", Header(dump(mission), WRITTEN, {})) as journal:
        runner = who.runner = Runner(
            mission,
            robot=ROBOT,
            connector=connector,
            clock=SimulatedClock(yard),
            answerers={"agent": who},
            journal=journal,
            observer=RunObserver(steps.append),
        )
        result = runner.run()
    wall_s = time.monotonic() - began
    getattr(model, "release", lambda: None)()
    box.close()
    agent.stop(1.0)
    trial = Trial(seed, result, yard, steps, model, wall_s)
    if yard.goals:
        trial.faults.append(f"goals left running: {list(yard.goals.values())}")
    if runner.view.awaited_goals:
        trial.faults.append("the engine left goals open")
    connector.stop()
    return trial


def _wrong(trial: Trial, deadline_s: float) -> Iterator[str]:
    """What must never be, whatever the model did."""
    result, yard = trial.result, trial.yard
    if result.outcome == "succeeded" and not yard.is_at_end:
        yield f"a false success: it is at {yard.position_m} m"
    if result.outcome not in ("succeeded", "aborted", "failed"):
        yield f"an outcome that its graph does not have: {result.outcome}"
    if yard.harmed or yard.rammed:
        yield f"what must not be crossed was crossed: {yard.harmed or yard.rammed}"
    if "invariant" in result.why or any(name in result.why for name in MISSION.invariants):
        yield f"an invariant was violated: {result.why}"
    if result.duration_s > LONGEST_SIM_S or trial.wall_s > LONGEST_WALL_S:
        yield f"it took {result.duration_s} s, and {trial.wall_s:.1f} s on the wall"
    yield from _decisions(trial.steps, deadline_s)
    for step in trial.steps:
        used = step.event.data.get("usage") if step.event.kind == "proposal" else None
        if used and used["calls"] > MOST_CALLS:
            yield f"a decision used {used['calls']} calls"
    if getattr(trial.model, "overdrawn", ()):
        yield f"asked although the budget was spent: {trial.model.overdrawn}"


def _decisions(steps: list[Step], deadline_s: float) -> Iterator[str]:
    """Each decision's end against its deadline: from the first question until another state is entered."""
    began: float | None = None
    for step in steps:
        if began is not None and (step.entered or step.outcome):
            if step.at - began > deadline_s + SLACK_S:
                yield f"a decision took {step.at - began:.2f} s of its {deadline_s} s"
            began = None
        if step.question is not None and "assessing" in step.entered:
            began = step.at
    if began is not None:
        yield "a decision was left without an end"


def _leaks(folder: Path, message: str, *, shows: bool) -> Iterator[str]:
    """Where a secret is that should be nowhere."""
    if shows:
        from rai_missions.check import check
        from visualize import draw, draw_review

        path = folder / "run.journal"
        draw_review(MISSION, folder / "page.html", [("run", path)], check(MISSION))
        draw(MISSION, folder / "picture.dot")
    found = {file.name: file.read_bytes() for file in folder.iterdir()} | {
        "the log": message.encode("utf-8", "replace")
    }
    for name, data in found.items():
        for secret in (*CANARIES.values(), OWN):
            if secret.encode() in data:
                yield f"'{secret}' appears in {name}"


@dataclass
class Drill:
    """Many missions, and what came of them."""

    missions: int = 0
    seconds: float = 0.0
    outcomes: Counter[str] = field(default_factory=Counter)
    deeds: Counter[str] = field(default_factory=Counter)
    questions: int = 0
    refused: int = 0
    stale: int = 0
    longest_wall_s: float = 0.0
    faults: list[str] = field(default_factory=list)

    def run(self, count: int, seed: int, *, first: int = 0, every_page: int = 50) -> Drill:
        """Run so many missions; `first` is the number of the first, as a fault names it."""
        plant()
        began = time.monotonic()
        for number in range(first, first + count):
            with quick_folder() as folder:
                self.add(try_one(f"{seed}/{number}", folder, shows=number % every_page == 0))
        self.seconds = time.monotonic() - began
        return self

    def add(self, trial: Trial) -> None:
        self.missions += 1
        self.outcomes[trial.result.outcome] += 1
        self.deeds += trial.model.done if isinstance(trial.model, HostileModel) else Counter()
        self.questions += trial.result.decisions
        notes = [note for step in trial.steps for note in step.notes]
        self.refused += sum(": refused" in note for note in notes)
        self.stale += sum(step.why.startswith("stale") for step in trial.steps)
        self.longest_wall_s = max(self.longest_wall_s, trial.wall_s)
        self.faults += [f"{trial.seed}: {each}" for each in trial.faults]


if __name__ == "__main__":
    done = Drill().run(int(sys.argv[1]), int(sys.argv[2]), first=int(sys.argv[3]) if len(sys.argv) > 3 else 0)
    sys.stdout.write(json.dumps(vars(done), indent=1) + "\n")
