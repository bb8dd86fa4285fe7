# SPDX-License-Identifier: Apache-2.0
"""What a run of a drawn mission of few values shows, its proof has: two or three dimensions of the format at a time."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from typing import Any, NamedTuple

import pytest
from pydantic import TypeAdapter

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.state import RunState, copied
from rai_missions.engine.step import Ask, CallService, StartGoal, Step
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.guards import Guard
from rai_missions.mission.mission import Mission
from rai_missions.model import AnyOf
from rai_missions.prove import Proof, prove
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import RecordingSpace, seen
from tests.prove.paired import DIMENSIONS, Paired
from tests.prove.test_drawn_walks import Impossible, impossible
from tests.prove.test_drawn_walks import seen as shown
from tests.prove.walks import Walk
from tests.rigs.turns import sooner_ended

Json = dict[str, Any]
STATES, WORK = 400, 12_000
HANDS = ("autonomy", "agent", "operator", "nobody")
GUARD: TypeAdapter[Guard] = TypeAdapter(AnyOf[Guard])
ENDS = ("succeeded", "succeeded", "failed", "canceled", "rejected", "aborted")
REPLIES = ("succeeded", "succeeded", "failed", "timed_out", "unavailable")


def is_high(known: Mapping[str, Any], margin: int) -> bool | None:
    """A predicate of the user's program."""
    return None if "level" not in known else bool(known["level"] > margin)


def facts_of(drawn: Paired) -> RobotFacts | None:
    if not drawn.facts:
        return None
    ends = [
        {name: GUARD.validate_python(each) for name, each in drawn.facts.get(word, {}).items()}
        for word in ("succeeded", "failed")
    ]
    return RobotFacts(drawn.facts["uses"], drawn.facts["keep"], *ends)


class Known(NamedTuple):
    """What a proof has of a mission: none where it is too large, or where some values represent too many."""

    drawn: Paired
    mission: Mission
    proof: Proof
    space: RecordingSpace
    never: Impossible
    """What `prove` and `check` call impossible."""

    @property
    def proved(self) -> set[str]:
        return {each.name for each in self.proof.claims if each.verdict == "proved"}


class PairWalk(Walk):
    """A run in which anything happens, held against the proof step by step."""

    def __init__(self, known: Known, rng: random.Random, chart: Chart) -> None:
        super().__init__(known.mission, 0, chart)
        self.known, self.r = known, rng
        self.asked: dict[int, Ask] = {}
        self.bounded: set[int] = set()
        """Calls that have a time: no other is reported to have run out of it."""
        self.composed: set[int] = set()
        """Goals whose ends the robot's guards decide: a server only cancels them."""
        self.found: set[str] = set()
        """What the proof does not have."""
        self.script: tuple[Any, ...] = ()
        self.has_facts = False
        """Robot, servers or services have reported something."""
        self.is_void = False
        """What is assumed of the robot was broken."""

    def fork(self, rng: random.Random) -> PairWalk:
        other = PairWalk(self.known, rng, self.chart)
        other.goals, other.calls, other.questions = dict(self.goals), [*self.calls], [*self.questions]
        other.wanted, other.asked, other.script = [*self.wanted], dict(self.asked), self.script
        other.composed, other.bounded = {*self.composed}, {*self.bounded}
        other.has_facts = self.has_facts
        return other

    def take(self, step: Step) -> None:
        super().take(step)
        composed = self.known.drawn.facts.get("succeeded", ())
        self.composed |= {
            each.number for each in step.effects if isinstance(each, StartGoal) and each.action in composed
        }
        calls = [each for each in step.effects if isinstance(each, CallService)]
        self.bounded |= {each.number for each in calls if each.timeout_s is not None}
        self.asked |= {each.question.number: each for each in step.effects if isinstance(each, Ask)}
        self.script += (step.event,)
        chart, space = self.chart, self.known.space
        assumed = space.environment.world.assumed
        if any(each.test(chart.state) is False for each in assumed.values()) or chart.false_invariant in assumed:
            self.is_void = True
        if not (self.is_void or self.is_tired):
            self.found |= set(self.unproved(step))
            self.found |= self.refuted()

    def refuted(self) -> set[str]:
        """Claims that were proved, and that the run shows broken; a composed goal may have ended by itself."""
        refuted = self.known.proved - ({"stopped"} if self.composed else set())
        return {f"{name}: {how}" for name, how in self.broken.items() if name in refuted}

    def unproved(self, step: Step) -> Iterator[str]:
        """What a step shows that the proof has out of reach."""
        chart, space = self.chart, self.known.space
        is_killed = step.event.name == "kill" and step.event.kind == "command"
        is_idle = chart.mode == "paused" and not space.environment.pause_matters
        if seen(chart) not in space.seen and not (is_killed or is_idle):
            yield f"state {seen(chart)}"
        for move in step.moves:
            yield from (f"taken {place}" for place in move.taken if place not in space.findings.taken)
        yield from (f"checked {each}" for each in shown(self.known.never, iter([step])))
        for place, value in step.guards:
            values = space.environment.instruments.seen.get(place, {value})
            if (value is True) not in {each is True for each in values}:
                yield f"guard {place} {value}"
        if chart.outcome == "succeeded" and not self.has_facts and "answers" in self.known.proved:
            yield "answers: no one but those who answer has reported anything"

    # -- what happens -------------------------------------------------------------------------------------------------

    def begin(self) -> None:
        """What is known before, and the start."""
        r = self.r
        for key, values in self.known.drawn.values.items():
            written = self.mission.blackboard[key]
            must = not written.optional and (written.source == "robot" or written.initial is None)
            if must or r.random() < 0.5:
                self.has_facts |= written.source == "robot"
                value = r.choice(values)
                self.script += ((key, value),)
                self.chart.write(key, value, 0.0)
        self.take(self.chart.start(0.0))

    @property
    def is_over(self) -> bool:
        return self.chart.outcome is not None or self.is_tired or self.is_void

    def happen(self) -> None:
        """One thing happens, after every timer that is due before it."""
        chart, r = self.chart, self.r
        at = chart.at + r.choice([0.0, 0.0, 0.0, 0.25, 0.5, 1.0, 2.0])
        if r.random() < 0.3 and chart.wake_at is not None:
            at = max(chart.wake_at, chart.at)
        for _ in range(100):
            if self.is_over or chart.wake_at is None or chart.wake_at > at:
                break
            self.take(chart.send(Tick(max(chart.wake_at, chart.at))))
        if not self.is_over:
            self.take(chart.send(self.event(at)))

    def event(self, at: float) -> Event:
        r, drawn = self.r, self.known.drawn
        robot = [key for key in drawn.values if self.mission.blackboard[key].source == "robot"]
        kinds = ["event"] * 3 + ["tick", "command"] + ["write"] * 3 * bool(robot)
        kinds += (
            ["goal"] * 4 * bool(self.goals) + ["call"] * 3 * bool(self.calls) + ["answer"] * 4 * bool(self.questions)
        )
        kinds += ["control"] * ("handover" in drawn.dimensions) + ["control"] * 3 * bool(self.wanted)
        kind = r.choice(kinds + ["doubt"] * ("replies" in drawn.dimensions))
        brings = {field: r.choice(values) for field, values in drawn.fields.items() if r.random() < 0.8}
        self.has_facts |= kind in ("write", "goal", "call")
        if kind == "event":
            names = [*sorted(self.mission.events)] * 2 + [*"abcd"] * 2
            return Event(r.choice(names), at, {each: brings[each] for each in ("k", "w") if each in brings})
        if kind == "write":
            key = r.choice(robot)
            stamp = at + r.choice([0.0, 0.0, 0.0, -0.5, -1.0, -2.0])
            return Event(key, at, {"value": r.choice(drawn.values[key]), "stamp": stamp}, "write")
        if kind in ("goal", "call"):
            return self.report(kind, at, {"g": brings["g"]} if "g" in brings else {})
        if kind == "answer":
            return self.answer(at, {"given": brings["given"]} if "given" in brings else {})
        if kind == "control":
            who = self.wanted[-1] if self.wanted and r.random() < 0.7 else r.choice(HANDS)
            by_person = who in ("operator", "nobody") or r.random() < 0.2
            return Event(who, at, {"by": "operator", "role": "operator"} if by_person else {"by": "mission"}, "control")
        if kind == "command":
            return Event(
                r.choice(["pause", "resume", "pause", "resume", "stop", "cancel"]), at, {"by": "operator"}, kind
            )
        return Event("uncertain", at, {}, "doubt") if kind == "doubt" else Tick(at)

    def report(self, kind: str, at: float, data: Json) -> Event:
        """What a server or a service reports."""
        r = self.r
        if kind == "call":
            number = self.calls.pop(r.randrange(len(self.calls)))
            replies = [each for each in REPLIES if each != "timed_out" or number in self.bounded]
            return Event(r.choice(replies), at, data, "result", number)
        number = r.choice(sorted(self.goals))
        if r.random() < 0.3:
            self.goals[number] = False
            return Event("accepted", at, {}, "accepted", number)
        self.goals.pop(number)
        return Event(r.choice(ENDS if number not in self.composed else ENDS[3:4]), at, data, "result", number)

    def answer(self, at: float, brings: Json) -> Event:
        r = self.r
        number = self.questions[-1] if r.random() < 0.8 else r.choice(self.questions)
        question = self.asked[number].question
        option = r.choice([*(each.name for each in question.options)] * 3 + ["left", "right", "stay", "?"])
        given: Json = {"option": option, **({"parameters": brings} if brings else {})}
        who = question.asked if r.random() < 0.9 else "agent"
        return Event(who, at, given if r.random() < 0.9 else {"absent": "away"}, "proposal", number)


class Runs:
    """Runs of one mission: each continues one that was somewhere new.

    Source: coverage-guided fuzzing, as AFL does it (lcamtuf.coredump.cx/afl/technical_details.txt).
    """

    def __init__(self, known: Known, seed: int) -> None:
        named = {"is_high": is_high} if known.mission.predicates() else None
        self.known, self.rng = known, random.Random(seed)
        self.chart = Chart(known.mission, robot_facts=facts_of(known.drawn), named=named)
        self.before = copied(self.chart.state)
        self.pool: list[tuple[PairWalk, RunState]] = []
        self.places = set[str]()
        self.sends = self.runs = 0

    def note(self, walk: PairWalk) -> None:
        """Keep where a run has come to, if that is new."""
        chart, state = self.chart, self.chart.state
        fleeting = self.known.space.environment.world.fleeting
        own = {name: entry.value for name, entry in state.board.items() if name not in fleeting}
        timers = sorted((kind, which if isinstance(which, str) else "") for kind, which in state.timers)
        goals = sorted((goal.owner, goal.phase) for goal in state.goals.values())
        place = (*seen(chart), chart.holder, sorted(own.items()), timers, goals, sorted(state.running))
        if repr(place) not in self.places:
            self.places.add(repr(place))
            if not walk.is_over:
                self.pool.append((walk.fork(self.rng), copied(state)))

    def run(self, sends: int) -> dict[str, PairWalk]:
        """What was found within so many events → a run that shows it."""
        found: dict[str, PairWalk] = {}
        while self.sends < sends:
            self.runs += 1
            walk = self.begun()
            for _ in range(self.rng.randint(2, 8)):
                if not walk.is_over:
                    walk.happen()
                    self.note(walk)
                self.sends += 1
            if not walk.is_over:
                self.end(walk)
            for each in walk.found:
                found.setdefault(each, walk)
        return found

    def begun(self) -> PairWalk:
        """A run from the start, or from somewhere where one came."""
        rng = self.rng
        if self.pool and rng.random() < 0.75:
            parent, state = self.pool[max(rng.randrange(len(self.pool)), rng.randrange(len(self.pool)))]
            self.chart.state = copied(state)
            return parent.fork(rng)
        self.chart.state = copied(self.before)
        walk = PairWalk(self.known, rng, self.chart)
        walk.begin()
        self.note(walk)
        return walk

    def end(self, walk: PairWalk) -> None:
        """Mostly nothing; or silence, an e-stop or a cancel."""
        end = self.rng.random()
        if end < 0.05:
            walk.be_silent()
        elif end < 0.15:
            walk.order("kill", 5)
        elif end < 0.25:
            walk.order("cancel", 100)
        if not (walk.is_void or walk.is_tired):
            walk.found |= walk.refuted()


def known_of(seed: int, dimensions: tuple[str, ...] = ()) -> Known | str:
    """What is known of a drawn mission; why nothing is."""
    drawn = Paired(seed, dimensions)
    try:
        mission = Mission.model_validate(drawn.document())
    except DefinitionError:
        return "invalid"
    robot_facts = facts_of(drawn)
    proof = prove(mission, robot_facts=robot_facts, most=STATES, work=WORK)
    if proof.sampled or not proof.is_whole:
        return "sampled" if proof.sampled else "large"
    space = RecordingSpace(Environment(mission, robot_facts=robot_facts), STATES, WORK)
    space.explore()
    return Known(drawn, mission, proof, space, impossible(mission, proof)) if space.is_whole else "large"


@sooner_ended()
def hold(seeds: Iterable[int], sends: int) -> Counter[str]:
    """Prove drawn missions, and have each run until so many things have happened."""
    count, pairs = Counter[str](), set[tuple[str, str]]()
    for seed in seeds:
        known = known_of(seed)
        count["drawn"] += 1
        if isinstance(known, str):
            count[known] += 1
            continue
        runs = Runs(known, seed)
        found = runs.run(sends)
        assert not found, (seed, known.drawn.dimensions, {each: walk.script for each, walk in found.items()})
        pairs |= {*combinations(sorted(known.drawn.dimensions), 2)}
        count.update(exact=1, runs=runs.runs, never=bool(known.proof.never), proved=len(known.proved))
    count["pairs"] = len(pairs)
    return count


WRONG_ONCE: tuple[int, ...] = ()


def test_what_a_run_of_two_dimensions_shows_is_in_its_proof() -> None:
    count = hold([*range(14), *WRONG_ONCE], 300)
    assert count["exact"] > 0.7 * count["drawn"] and count["never"] and count["pairs"] > 10, count


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_what_runs_of_thousands_of_missions_show_is_in_their_proofs() -> None:
    count = hold(range(10_000, 13_000), 2_500)
    assert count["exact"] > 0.7 * count["drawn"] and count["pairs"] == len([*combinations(DIMENSIONS, 2)]), count
