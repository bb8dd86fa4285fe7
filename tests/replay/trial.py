# SPDX-License-Identifier: Apache-2.0
"""One mission, run without a death and again with many: what must be so of the second, next to the first."""

from __future__ import annotations

import random
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as fixed

from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import CallService, PublishMessage, StartGoal, Step
from rai_missions.event import Event
from rai_missions.journal import read
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import Mission
from tests.replay.coroner import Inquest, SlowAnswerer, Steady, steps_of
from tests.replay.farm import ACTIONS, FARMER, Farm
from tests.replay.mortal import ONLOOKER, Fate, Wish, live
from tests.replay.test_kills import Ended, has_ended, holds
from tests.replay.test_kinds import is_mode
from tests.strategies import EVENTS, mission_documents

__all__ = ("ENDS_AT_S", "ReceivedEvent", "TrialResult", "part_within_an_instant", "tried", "worth_a_trial")

ENDS_AT_S = 20.0
MOST_AT_ONCE = 60
"""Steps without that any time passes, after which anyone who looks on ends the run."""


UNHEARD = frozenset({"hauls", "tows"})
ROBOT = FARMER.model_copy(
    update={
        "blackboard": {name: each for name, each in FARMER.blackboard.items() if name not in UNHEARD},
        "actions": {name: each for name, each in FARMER.actions.items() if each.action is not None},
    }
)
"""Without what generated missions have no keys for: each message of it would be a row."""


class TrialResult(NamedTuple):
    """What a trial came to."""

    deaths: int
    kills: Counter[str]
    """Instant → deaths at one; a death may come at several."""
    compared: str
    """`same`, or why the end was not compared with that of the run without a death."""


class Yard(Steady):
    """A land in which what was wanted is granted once it is in the journal.

    Args:
        seed: Of what is wanted, and how long goals take and how they end.
    """

    def __init__(
        self, mission: Mission, seed: int, *, keeps_time: bool, connector_type: type[LocalConnector] | None = None
    ) -> None:
        chance = random.Random(seed)
        self.keeps_time = keeps_time
        self.connector_type = connector_type or (Steady if keeps_time else Farm).connector_type
        self.accepts_s = chance.choice([0.0, 1.0])
        self.reported: set[int] = set()
        self.suffix = ""
        """Of the names of events, in a mission that was renamed."""
        self.inquest = Inquest(mission, self, {})
        self._crowd: tuple[float, int] = (-1.0, 0)
        lasts_s = {action: chance.choice([0.5, 2.0, 6.0, 40.0]) for action in ACTIONS}
        ends = {action: chance.choice(["succeeded", "succeeded", "failed"]) for action in ACTIONS}
        super().__init__(self._wanted(chance), lasts_s, ends)

    def _wanted(self, chance: random.Random) -> list[Wish]:
        """Events, a pause or not, and at last a cancel: every run ends."""
        wanted = [self._once(number, chance) for number in range(chance.randint(0, 4))]
        if chance.random() < 0.4:
            at = chance.uniform(1, ENDS_AT_S - 5)
            wanted += [
                Wish(at, lambda runner: runner.pause(), is_mode("paused")),
                Wish(at + 3, lambda runner: runner.resume(), is_mode("running")),
            ]
        wanted.sort(key=lambda wish: wish.at)
        return [*wanted, Wish(ENDS_AT_S, lambda runner: runner.cancel(), lambda r: r.view.outcome is not None)]

    def _once(self, number: int, chance: random.Random) -> Wish:
        name = chance.choice(EVENTS)

        def on_result(runner: Any) -> None:
            runner.post(Event(name + self.suffix, runner.view.now(), {"id": number}))

        return Wish(
            chance.uniform(1, ENDS_AT_S),
            on_result,
            lambda _: number in self.reported or number in self.inquest.received,
        )

    def look(self, step: Step) -> None:
        runner = self.runner
        if runner is None:
            return
        self.reported.add(step.event.data.get("id", -1))
        at, count = self._crowd
        self._crowd = (step.at, count + 1 if step.at == at else 0)
        if self._crowd[1] > MOST_AT_ONCE and step.outcome is None:
            runner.kill(ONLOOKER)
        self.inquest.look(runner, step)


def thinkers(seed: int, yard: Yard) -> dict[str, SlowAnswerer]:
    chance = random.Random(seed)
    names = ("drive_over", "replan", "wait", "give_up", "nonsense")
    return {
        who: SlowAnswerer(chance.choice(names), yard, 0.0 if who == "rules" else chance.choice([0.0, 1.0, 3.0]))
        for who in ("agent", "operator", "rules")
        if chance.random() < 0.8
    }


class WatchedFate(Fate):
    """Never dies, and knows at which instants it could have."""

    def __init__(self, yard: Yard) -> None:
        super().__init__()
        self._yard = yard
        self.chances: defaultdict[str, list[tuple[int, bool]]] = defaultdict(list)
        """Instant → the things that it did at one, by their number, and whether it is right after."""

    def around(self, what: str, given: tuple[Any, ...], do: Callable[[], Any]) -> Any:
        number = self.count
        self._look(number, what, given, is_done=False)
        made = super().around(what, given, do)
        self._look(number, what, given, is_done=True)
        return made

    def _look(self, number: int, what: str, given: tuple[Any, ...], *, is_done: bool) -> None:
        if (runner := self._yard.runner) is not None:
            for name in self._yard.inquest.instants(runner, what, given, is_done=is_done):
                self.chances[name].append((number, is_done))


FIRST_THINGS = 5
"""So many of the first things that a process does belong to its taking a run up, about."""


def fates(chance: random.Random, chances: Mapping[str, list[tuple[int, bool]]], lives: int) -> Iterator[Fate]:
    """How each process dies: at each kind of instant alike, one after the other, or while it takes the run up."""
    began = 0
    for life in range(lives):
        later = {name: found for name, each in chances.items() if (found := [at for at in each if at[0] >= began])}
        if not later or (life and chance.random() < 0.25):
            yield Fate(chance.randint(0, FIRST_THINGS), is_done=chance.random() < 0.5)
            continue
        at, is_done = chance.choice(later[chance.choice(sorted(later))])
        yield Fate(at - began + (FIRST_THINGS if life else 0), is_done=is_done)
        began = at


def tried(folder: Path, mission: Mission, seed: int) -> TrialResult:
    """Run a mission to its end, and again with deaths; raises AssertionError where the second is not as it must be."""
    chance = random.Random(seed)
    keeps_time = chance.random() < 0.6
    whole, path = Yard(mission, seed, keeps_time=keeps_time), folder / "whole.journal"
    who = thinkers(seed, whole)
    watched = WatchedFate(whole)
    result = live(path, whole, mission, ROBOT, who, watched)
    assert result is not None
    holds(path, whole, mission)
    undisturbed = Ended(result.outcome, result.why)

    yard, path = Yard(mission, seed, keeps_time=keeps_time), folder / "run.journal"
    who = thinkers(seed, yard)
    inquest = yard.inquest = Inquest(mission, yard, who)
    dead_s = 0.0 if keeps_time else chance.choice([0.0, 0.0, 3.0, 12.0])
    for fate in (*fates(chance, watched.chances, chance.randint(3, 8)), Fate()):
        if path.exists() and has_ended(path, mission):
            break
        if live(path, yard, mission, ROBOT, who, fate, coroner=inquest) is not None:
            break
        for _ in range(int(dead_s / yard.period_s)):
            yard.step()
    holds(path, yard, mission)
    ended, doubted = looked_at(path, yard, inquest)
    if not keeps_time:
        compared = "time was lost"
    elif doubted:
        compared = "an effect was in doubt"
    elif ended != undisturbed and part_within_an_instant(received(folder / "whole.journal"), received(path)):
        compared = "two things at one instant"
    else:
        assert ended == undisturbed, "the run ends as it would have without a death"
        compared = "same"
    return TrialResult(inquest.deaths, inquest.kills, compared)


class ReceivedEvent(NamedTuple):
    """One thing that a run received."""

    at: float
    kind: str
    name: str
    number: int
    data: str


def received(path: Path) -> list[ReceivedEvent]:
    """What a run received, in order: neither what its own process added nor that time passed."""
    with read(path) as record:
        events = [step.event for step in steps_of(list(record.rows()))]
    return [
        ReceivedEvent(each.at, each.kind, each.name, each.number, repr(sorted(each.data.items())))
        for each in events
        if each.kind not in ("tick", "control") and each.name != "take_up"
    ]


def part_within_an_instant(whole: list[ReceivedEvent], run: list[ReceivedEvent]) -> bool:
    """Whether two runs first differ in which of two things of one instant came first: neither order is wrong.

    What the mission's end left unread in one of them counts as received after what ended it.
    """
    shared = next((place for place, (one, other) in enumerate(zip(whole, run, strict=False)) if one != other), None)
    if shared is None:
        longer, place = (whole, len(run)) if len(whole) > len(run) else (run, len(whole))
        return 0 < place < len(longer) and longer[place].at == longer[place - 1].at
    one, other = whole[shared], run[shared]
    return one.at == other.at and (one in run or other in whole or run[-1].at == one.at or whole[-1].at == other.at)


def looked_at(path: Path, yard: Yard, inquest: Inquest) -> tuple[Ended, bool]:
    """What the journal of a run with deaths must state; gives how it ended, and whether an effect was in doubt."""
    with read(path) as record:
        rows = list(record.rows())
        confirmed = record.confirmations()
    steps = steps_of(rows)
    effects = [(step.seq, each) for step in steps for each in step.effects]
    starts = {inquest.goal_id(each): each for _, each in effects if isinstance(each, StartGoal)}
    assert {goal_id for _, goal_id in yard.started} <= starts.keys(), "no goal was started that no row reports"
    under = InFlight()
    for row in rows:
        under.follow(row)
    assert not [each for each in under.open.values() if isinstance(each, StartGoal)], "each goal's end is known"
    calls = Counter(each.service for _, each in effects if isinstance(each, CallService))
    sure = Counter(
        each.service for seq, each in effects if isinstance(each, CallService) and confirmed.get(seq) == "performed"
    )
    for service, is_repeatable in (("replan", False), ("horn", True)):
        most = calls[service] + (inquest.repeatable[service] if is_repeatable else 0)
        assert sure[service] <= yard.called[f"/{service}"] <= most, "what was confirmed was done, and done once"
    lamps = sum(isinstance(each, PublishMessage) for _, each in effects)
    assert yard.received["/once_topic"] <= lamps
    doubted = any(step.event.kind == "doubt" and step.event.data.get("what") != "publish" for step in steps)
    last = next(step for step in steps if step.outcome is not None)
    return Ended(last.outcome, last.why), doubted


SOMETHING_RUNS = frozenset({"action", "call", "tree", "decision", "parallel", "each"})


def worth_a_trial(seed: int, most: int) -> list[Mission]:
    """Generated missions with enough in them to die in, of so many those that are not much alike."""
    found: dict[str, Mission] = {}
    chance = random.Random(seed)

    @fixed(seed)
    @settings(
        max_examples=most,
        database=None,
        phases=[Phase.generate],
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(mission_documents())
    def draw(document: dict[str, Any]) -> None:
        begins = [name for name, state in document["states"].items() if not state.keys() & {"final", "history"}]
        asks = [name for name in begins if "decision" in document["states"][name]]
        document = {**document, "initial": chance.choice(asks if asks and chance.random() < 0.5 else begins)}
        if chance.random() < 0.8:
            document.pop("invariants", None)
        mission = Mission.model_validate(document)
        words = Counter(state.word for _, _, state in mission.walk())
        busy = sum(words[word] for word in SOMETHING_RUNS)
        if busy >= 3 and (words["decision"] or words["parallel"] or words["tree"]):
            found.setdefault(str(sorted(words.items())), mission)

    draw()
    return list(found.values())
