# SPDX-License-Identifier: Apache-2.0
"""A person orders, answers, asks and stops while control changes hands: only what was ordered happens, and it is so."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.agents.talk.orders import OnOrderEnd, RunOrders
from rai_missions.conversation import Order, Settings
from rai_missions.conversation.inputs import OrderResult
from rai_missions.conversation.language.language import language
from rai_missions.engine import Chart
from rai_missions.engine.step import Ask, Handover, Step
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.resume import resumption
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.agents.talk.scenes import HeldOpen, settle
from tests.laws.drawn import EVENTS, document
from tests.laws.test_cut_short import drawn, plain, private_as, remembered
from tests.laws.test_side_by_side import NAMED, Surroundings, Thinker, robot, without_request
from tests.rigs.journals import assert_whole, cut_after_each
from tests.rigs.turns import Turns, sooner_ended

Json = dict[str, Any]
OVER_S, CANCELED_S, KILLED_S = 60.0, 20.0, 30.0
INCLUDED = 0.5
"""Which share of the missions is a part of another."""
MOST_REPLAYED = 100_000
"""Steps that are done again in all cuts of one run: a mission that goes round in one instant makes ten thousand."""
SENTENCES = (
    *("answer left", "left", "right", "wait here", "1", "1", "1", "option 2", "option 1", "yes", "no"),
    *("pause", "pause", "resume", "resume", "continue", "continue", "stop", "cancel the mission", "start drawn"),
    *("what are you doing?", "who has control?", "why did you stop?", "what was asked?", "hello there"),
)
HANDS = ("operator", "operator", "agent", "agent", "autonomy", "nobody")


class Given(NamedTuple):
    """An order that the dialogue gave out, and what was reported of it."""

    place: int
    """In which of the sentences."""
    order: Order
    ends: list[OrderResult]
    steps: list[Step]
    """The step that took it."""


def asking(rng: random.Random, folder: Path) -> tuple[Mission, frozenset[str]]:
    """A drawn mission that needs control, lasts, and asks a person; and what is private in the one that it includes."""
    while True:
        text = json.dumps(document(rng))
        if '"decision"' not in text or '"control"' not in text:
            continue
        ask = rng.choice(['["operator", "rules"]', '["operator"]'])
        made = json.loads(text.replace('["agent", "rules"]', ask))
        with suppress(DefinitionError):  # it cannot be included
            mission, private = drawn(rng, folder, made, is_included=rng.random() < INCLUDED)
            if lasts(mission):
                return mission, private


def lasts(mission: Mission) -> bool:
    """Whether a mission asks a person something in its first seconds, and has not ended then."""
    chart = Chart(mission, named=NAMED)
    steps = [chart.start(0.0)]
    for at in (0.0, 0.0, 1.0, 1.0, 2.0, 3.0):
        wanted = [each.to for each in steps[-1].effects if isinstance(each, Handover)]
        steps.append(chart.send(Event(wanted[0], at, {"by": "mission"}, "control") if wanted else Tick(at)))
    return chart.outcome is None and any(isinstance(each, Ask) for step in steps for each in step.effects)


class Held:
    """A run in which control changes hands, with a conversation about it or with orders alone.

    Args:
        seed: The seed of the mission and of all that happens.
        path: Of its journal.
        orders: Those of a conversation, which are given directly instead; None: it is talked.
    """

    def __init__(self, seed: int, path: Path, orders: list[Given] | None = None) -> None:
        self.remembers = orders is None
        self.turns = turns = Turns()
        self._place, self._orders = 0, orders or []
        self.steps: list[Step] = []
        self.was: dict[int, Any] = {}
        """Step → all that the run remembered after it."""
        self.given: list[Given] = []
        self._taking: list[Step] = []
        self.lines: list[TalkLine] = []
        rng = random.Random(seed)
        self.mission, self._private = mission, _ = asking(rng, path.parent)
        self.robot = robot(rng, mission)
        land = Surroundings(turns, seed)
        journal = Journal.create(path, Header(dump(mission), dump_profile(self.robot), run="held"))

        def make(clock: Clock) -> Callable[[], object]:
            self.runner = Runner(
                mission,
                robot=self.robot,
                connector=land.connector,
                clock=clock,
                journal=journal,
                answerers={"operator": HeldOpen(), "rules": Thinker(turns, "rules"), "agent": Thinker(turns, "agent")},
                begin=NewRun(named=NAMED, run="held"),
                observer=RunObserver(self._step, self._changed),
            )
            return self.runner.run

        turns.begin(make)
        self._schedule(rng)
        with pytest.MonkeyPatch.context() as patch:
            self._perform = RunOrders.perform
            patch.setattr(RunOrders, "perform", lambda *given: self._note(*given))
            self.orders, self.agent = RunOrders(self.runner), self._talk() if orders is None else None
            if self.agent is not None:
                turns.settle = partial(settle, self.agent)
            turns.play(OVER_S)
            if self.agent is not None:
                self.agent.conclude(5.0)
                self.agent.stop()
            self.orders.close()
        journal.close()

    def _talk(self) -> ConversationalAgent:
        agent = ConversationalAgent(SETTINGS, doors=[TextDoor("terminal", self._show)], now=self.turns.now)
        agent.attach(self.runner)
        agent.run()
        return agent

    def _show(self, line: TalkLine) -> None:
        self.lines.append(line)

    def _step(self, step: Step) -> None:
        self.steps.append(step)
        if self.remembers:
            self.was[step.seq] = remembered(self.runner.view)
        self._taking = [step]
        (self.orders if self.agent is None else self.agent).step(step)
        self._taking = []

    def _changed(self, status: Any) -> None:
        if self.agent is not None:
            self.agent.changed(status)

    def _note(self, orders: RunOrders, order: Order, on_end: OnOrderEnd) -> None:
        """An order goes to the run, and what is reported of it is noted."""
        given = Given(self._place, order, [], [])
        self.given.append(given)

        def ended(result: OrderResult) -> None:
            given.ends.append(result)
            given.steps.extend(self._taking)
            on_end(result)

        self._perform(orders, order, ended)

    def _schedule(self, rng: random.Random) -> None:
        turns, at = self.turns, 0.0
        for number, do in enumerate(self._script(rng), start=1):
            # Each at instants of its own: either order of a timer and what comes in its instant is right.
            at += rng.choice([0.0, 0.25, 0.25, 0.5, 1.0]) + number / 1024
            turns.call_at(at, do)
        turns.call_at(CANCELED_S, lambda: self.runner.cancel())
        turns.call_at(KILLED_S, lambda: self.runner.kill())

    def _script(self, rng: random.Random) -> Iterator[Callable[[], object]]:
        """What people do and what happens, one thing after the other."""
        for _ in range(rng.randint(4, 16)):
            kind = rng.choice(["talk", "talk", "hands", "waits", "event"])
            if kind == "talk":
                yield partial(self._utter, rng.choice(SENTENCES))
            elif kind == "hands":
                yield partial(self._hand_to, rng.choice(HANDS))
            elif kind == "event":
                yield partial(self._post, rng.choice(EVENTS), rng.randint(0, 2))
            else:
                is_pause = rng.random() < 0.5
                yield partial(self._utter, "pause") if is_pause else partial(self._hand_to, "operator")
                for answer in rng.choices(("1", "1", "left", "2"), k=rng.randint(1, 2)):
                    yield partial(self._utter, answer)
                yield partial(self._utter, "resume") if is_pause else partial(self._hand_to, "agent")

    def _hand_to(self, who: str) -> None:
        self.runner.control(who, by="operator Eve")

    def _post(self, name: str, k: int) -> None:
        self.runner.post(private_as(Event(name, self.turns.at, {"k": k}), self._private))

    def _utter(self, text: str) -> None:
        self._place += 1
        if self.agent is not None:
            self.agent.receive(text, role="operator", channel="terminal", author="Anna")
            self.agent.wait_answered(20.0)
        for each in self._orders:
            if each.place == self._place:
                self.orders.perform(each.order, lambda result: None)


SETTINGS = Settings(requests="refuse")


def course(steps: list[Step]) -> dict[str, Any]:
    """What happened in a run, whether the time that an event brings passed in its step or in one before."""
    found: dict[str, Any] = {"events": [], "moves": [], "effects": [], "writes": [], "verdicts": []}
    for step in map(without_request, steps):
        if step.event.kind != "tick":
            found["events"].append((step.event, step.refusal, step.kept, step.outcome, step.mode, step.holder))
        for name in ("moves", "effects", "writes", "verdicts"):
            found[name] += [(step.at, each) for each in getattr(step, name)]
    return {name: [plain(each) for each in value] for name, value in found.items()}


ACCEPTED = {"pause": "paused", "stop": "paused", "cancel": "canceling", "resume": "running"}
"""What a run is once it has taken an order, if it has not ended with it."""


def is_true(given: Given) -> bool:
    """Whether what was reported of an order is what the run did in the step that took it, or judged it."""
    refused = given.ends[0].refused
    if not given.steps:
        return bool(refused)
    (step,) = given.steps
    order = given.order
    if order.name != "answer":
        is_done = step.outcome is not None or step.mode == ACCEPTED[order.name]
        return bool(refused) if step.refusal else not refused and is_done
    accepted = [each for each in step.verdicts if each.number == order.question and each.accepted]
    return bool(accepted) is not bool(refused) and all(each.option == order.option for each in accepted)


def resumes_anywhere(path: Path, talked: Held) -> None:
    """A process that was killed after any step is continued with all that it remembered; of many steps, some."""
    every = len(talked.steps) ** 2 // (2 * MOST_REPLAYED) + 1
    for step, cut in cut_after_each(path, lambda step: step.outcome is None and step.seq % every == 0):
        with read(cut) as record:
            found = resumption(record, talked.mission, named=NAMED)
        assert remembered(found.chart) == talked.was[step.seq], step


def is_spoken(given: Given, lines: list[TalkLine]) -> bool:
    """Whether the person was informed of an order's refusal; that of a stop is spoken with it."""
    end = given.ends[0]
    text: str = language("en").data["texts"][f"refused_{end.kind}"] if end.kind else end.refused
    why = text.partition("{")[0].rstrip(". ").lower()
    return not end.refused or given.order.name == "stop" or any(why[:100] in line.text.lower() for line in lines)


@sooner_ended()
def agree(seed: int, folder: Path) -> Counter[str]:
    """Talk about a run, and order the same without talk; gives what was ordered and how that ended."""
    talked = Held(seed, folder / "talked.journal")
    silent = Held(seed, folder / "silent.journal", talked.given)
    assert course(talked.steps) == course(silent.steps), seed
    assert_whole(folder / "talked.journal")
    resumes_anywhere(folder / "talked.journal", talked)
    found = Counter(facts=sum(step.event.kind == "write" for step in talked.steps))
    for each in talked.given:
        assert len(each.ends) == 1 and is_true(each), (seed, each)
        assert is_spoken(each, talked.lines), (seed, each)
        number = each.order.question if each.order.name == "answer" else None
        is_kept = any(step.kept and step.event.number == number for step in talked.steps)
        found[f"{each.order.name}{is_kept * ' kept'} {'refused' if each.ends[0].refused else 'done'}"] += 1
    return found


@pytest.mark.parametrize("seed", range(6))
def test_only_what_a_person_ordered_happens_and_is_reported_as_it_is(seed: int, tmp_path: Path) -> None:
    assert agree(seed, tmp_path)["facts"]


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_only_what_a_person_ordered_happens_in_a_thousand_runs(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(1_000):
        folder = tmp_path / str(seed)
        folder.mkdir()
        found += agree(seed, folder)
    assert min(found[f"answer kept {end}"] for end in ("done", "refused")) > 10, found
