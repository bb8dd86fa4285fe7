# SPDX-License-Identifier: Apache-2.0
"""Proof: every run of a mission, explored; what is promised of all of them is proved, or refuted by a shortest run.

Its parts, each above the next: `verdicts` on each claim; `exploration` of all states; `environment`, whatever can
happen in one; `abstraction`, what makes two states one; `analysis` of the mission as it is written.

Imports `check`, `engine`, `guards`, `journal`, `mission`, `model`, `planning` and `states`, and the modules of the
root.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.robot_facts import RobotFacts, check_facts
from rai_missions.errors import UsageError
from rai_missions.mission.garbage import few_collections
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.prove.analysis.loops import FEW, Loop, long_loops, may_rest, unlike, with_rounds
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.explorer import Space
from rai_missions.prove.limits import MOST_STATES, Limits, Stopped
from rai_missions.prove.verdicts.circles import circling
from rai_missions.prove.verdicts.counterexample import TraceReplayer, TraceStep, trace, ways_to
from rai_missions.prove.verdicts.properties import CLAIMS, Property, claims, lost, stuck
from rai_missions.prove.verdicts.unrolled import repeated, unrolled
from rai_missions.redaction import shown

if TYPE_CHECKING:
    from rai_missions.journal import Header

__all__ = ("CLAIMS", "MOST_STATES", "Proof", "Property", "TraceStep", "prove", "record")


class Proof(NamedTuple):
    """What was found out about a mission."""

    claims: tuple[Property, ...]
    ways: dict[str, list[TraceStep]]
    """Claim that was refuted → the shortest run to where it is broken, if there is one in which the operator leaves
    the mission alone, then of these; none for what no single run shows."""
    states: int
    steps: int
    depth: int
    """Steps of the longest of the shortest runs to the states."""
    farthest: int
    """The most steps between a state and the nearest end, with as many rounds as were explored."""
    is_whole: bool
    """Every state was explored."""
    stopped: Stopped
    """The limit that left states out; empty where none did."""
    varieties: dict[str, int]
    """Key → how many things are known of it in the states that were found, most first; empty where all were."""
    done: int
    """States out of which all that can happen was explored."""
    assumed: tuple[str, ...]
    """Invariants that speak of the robot alone: they are watched in a run, and were assumed to hold here."""
    in_pause: tuple[str, ...]
    """Invariants that what the robot reports can break while the mission is paused, when no rule of it can act."""
    predicates: tuple[str, ...]
    """The user's predicates: each was free to have any value whenever it was asked."""
    sampled: tuple[str, ...]
    """The paths of which some values were tried, though guards can distinguish more: nothing is called proved then."""
    alike: dict[str, int]
    """Loop of a tree → its rounds, of which a few were explored that represent all: later ones are the same."""
    never: tuple[str, ...]
    """States that no run enters; known only where everything was explored, and with all values."""
    seconds: float

    @property
    def verdict(self) -> str:
        """`refuted` if any claim is, else `proved`, or `explored` where a bound was hit."""
        verdicts = {claim.verdict for claim in self.claims}
        return "refuted" if "refuted" in verdicts else "explored" if "explored" in verdicts else "proved"


def prove(
    mission: Mission,
    ticker: Trees | None = None,
    *,
    robot_facts: RobotFacts | None = None,
    most: int = MOST_STATES,
    seconds: float = math.inf,
    memory_mb: float = math.inf,
    work: float = math.inf,
    continues: bool = False,
    progress: Callable[[int, int], None] = lambda found, done: None,
) -> Proof:
    """Explore every run of a mission.

    Values are distinguished as far as the mission's guards do; timers run out in any order; named guards are free. The
    operator pauses, resumes, takes control and gives it to anybody. A cancel and an e-stop are tried in every
    state, those of a pause included.

    Args:
        mission: One that `check` finds no fault in.
        ticker: Who ticks trees, if not as compiled by the chart.
        robot_facts: What is known of the robot: without a profile all actions exclude each other, and have servers.
        most: States at the most; a kilobyte or two each.
        seconds: Wall time at the most.
        memory_mb: Resident memory of the process at the most, in MiB.
        work: Steps, microsteps and ticks of trees at the most, together.
        continues: Where a claim is refuted, the others are explored to these limits all the same; else for some time.
        progress: Receives the number of states found and of states done, every hundred states.

    Raises:
        UsageError: It is no mission, or a limit is not above 0.
    """
    given_mission(mission, "prove")
    check_facts(robot_facts)
    limits: dict[str, object] = {"most": most, "seconds": seconds, "memory_mb": memory_mb, "work": work}
    for word, limit in limits.items():
        if not (isinstance(limit, int | float) and limit > 0):
            raise UsageError(f"{word}={shown(limit)} leaves nothing to explore; give a number above 0")
    with few_collections():  # what is explored is kept, and in no circles
        return _ProofRun(
            mission, ticker, robot_facts, Limits(most, seconds, memory_mb, work, continues), progress
        ).proof()


class _ProofRun:
    """One proof in the making: of all runs, then of those in which the operator leaves the mission alone."""

    def __init__(
        self,
        mission: Mission,
        ticker: Trees | None,
        robot_facts: RobotFacts | None,
        limits: Limits,
        progress: Callable[[int, int], None],
    ) -> None:
        self._mission, self._ticker, self._progress = mission, ticker, progress
        self._robot_facts = robot_facts if robot_facts is not None else RobotFacts()
        self._limits, self._began = limits, time.perf_counter()
        self._rounds = {loop: min(FEW, loop.rounds) for loop in long_loops(mission, self._robot_facts)}
        """How many rounds of each long loop are explored."""
        self._few = with_rounds(mission, self._rounds)
        """The mission with so many."""

    def proof(self) -> Proof:
        while True:
            space = self._explored(progress=self._progress)
            if space.is_whole and self._has_more(space.environment):
                continue
            found = claims(self._few, space, is_sampled=bool(space.environment.world.values.learned.sampled))
            short = self._short(space) if space.levels and space.is_whole else []
            ways = {} if short else {each.name: self._run_of(space, each) for each in found if each.has_run}
            if None in ways.values() and space.is_whole:
                short = [loop for loop, many in self._rounds.items() if many < loop.rounds]
            if not short:
                return self._proof(space, found, ways)
            self._rounds |= {loop: min(2 * self._rounds[loop], loop.rounds) for loop in short}
            self._few = with_rounds(self._mission, self._rounds)

    def _has_more(self, environment: Environment) -> bool:
        """Have all the rounds of trees explored that may rest at the limit of a step; whether some were left out."""
        seen = environment.instruments
        resting = may_rest(self._mission, seen.at_once, seen.restarted)
        more = {
            loop: loop.rounds for loop, many in self._rounds.items() if loop.state in resting and many < loop.rounds
        }
        self._rounds |= more
        self._few = with_rounds(self._mission, self._rounds)
        return bool(more)

    def _short(self, space: Space) -> list[Loop]:
        """The loops of which more rounds must be explored."""
        marks = [set(each(space)) for each in (stuck, lost, circling)]
        return unlike(space, space.levels, self._rounds, marks)

    def _proof(self, space: Space, found: list[Property], runs: dict[str, list[TraceStep] | None]) -> Proof:
        """What was found out, once the rounds that were explored represent all."""
        world, ways = space.environment.world, {name: run for name, run in runs.items() if run is not None}
        found = [
            each if each.name not in runs or each.name in ways else Property(each.name, "explored") for each in found
        ]
        if ways:
            found, ways = self._calmly(found, ways)
        names = [name for _, name, state in self._mission.walk() if state.word != "history"]
        states, steps, depth = space.covered
        sampled = world.values.learned.sampled
        is_all = space.is_whole and not sampled
        return Proof(
            claims=tuple(found),
            ways=ways,
            states=states,
            steps=steps,
            depth=depth,
            farthest=max(space.distances(space.ends), default=0),
            is_whole=space.is_whole,
            stopped=space.meter.stopped,
            varieties={} if space.is_whole else space.varieties,
            done=space.done,
            assumed=tuple(sorted(world.assumed)),
            in_pause=tuple(sorted(space.findings.in_pause)),
            predicates=tuple(sorted(world.predicates)),
            sampled=sampled,
            alike={str(loop): loop.rounds for loop, many in self._rounds.items() if many < loop.rounds},
            never=tuple(name for name in names if name not in space.findings.entered) if is_all else (),
            seconds=time.perf_counter() - self._began,
        )

    def _explored(
        self,
        *,
        wanted: Collection[str] = (),
        is_calm: bool = False,
        progress: Callable[[int, int], None] = lambda found, done: None,
    ) -> Space:
        for one_by_one in (True, False):
            left = self._limits.seconds - (time.perf_counter() - self._began)
            environment, limits = self._environment(self._few, is_calm=is_calm), self._limits._replace(seconds=left)
            space = Space(environment, limits, progress, wanted=wanted, one_by_one=one_by_one)
            space.explore()
            if not space.is_entangled:
                break
        return space

    def _environment(self, mission: Mission, *, is_calm: bool = False) -> Environment:
        environment = Environment(mission, self._ticker, robot_facts=self._robot_facts, is_calm=is_calm)
        environment.codec.loops = tuple(self._rounds)
        return environment

    def _run_of(self, space: Space, claim: Property) -> list[TraceStep] | None:
        """The shortest run to where a claim is refuted, with all the rounds of its loops; None where it has no such."""
        run = trace(space, claim)
        if not self._rounds:
            return run
        few, every = (
            self._environment(each, is_calm=space.environment.control.is_calm) for each in (self._few, self._mission)
        )
        missing = unrolled(few, every, ways_to(space, claim), self._rounds)
        return repeated(run, missing) if missing is not None else None

    def _calmly(
        self, found: list[Property], ways: dict[str, list[TraceStep]]
    ) -> tuple[list[Property], dict[str, list[TraceStep]]]:
        """Refutations for which the operator is not needed, where there are such: the author's first affair."""
        calm = self._explored(wanted=ways, is_calm=True)
        better = {each.name: each for each in claims(self._few, calm) if each.has_run and each.name in ways}
        runs = {name: run for name, each in better.items() if (run := self._run_of(calm, each)) is not None}
        return [better[each.name] if each.name in runs else each for each in found], {**ways, **runs}


def record(
    path: Path, header: Header, mission: Mission, run: list[TraceStep], *, robot_facts: RobotFacts | None = None
) -> bool:
    """Have a chart that keeps time do the run of a refutation, into a new journal.

    Returns:
        Whether it comes to the same states, and the same outcome, as the run: an order of timers that their durations
        do not allow shows here.

    Raises:
        UsageError: The file is there already, or none can be written there.
    """
    from rai_missions.journal import Journal  # slow to import, and a proof alone does without

    with Journal.create(path, header) as journal:
        return TraceReplayer(mission, robot_facts, journal).play(run)
