# SPDX-License-Identifier: Apache-2.0
"""What goes on in the other mission, and what begins there anew: activities, goals, timers, memories.

Rule: what is written as it was goes on as it stood; whatever else begins anew, and the notes say so.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree import RunningLeaf, TreeActivity, questions_in
from rai_missions.engine.decision import Question
from rai_missions.engine.hold import OUTCOME
from rai_missions.engine.state import TABLE, Holds, Timer
from rai_missions.engine.step import Ask, CancelGoal, Effect, PublishMessage, SayAloud
from rai_missions.errors import Fault
from rai_missions.event import Event
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import BUILT_IN_EVENTS
from rai_missions.replay.migrate.configuration import ReachedStates
from rai_missions.replay.migrate.names import Naming
from rai_missions.states.compound import Each

__all__ = ("Carried", "carry")

UNCHANGED: tuple[Holds, ...] = ("value", "number", "past", "end", "payload", "deadline")
"""What names nothing of the mission, and is what it was. What is not carried follows from the rest, or begins again."""


class Carried(NamedTuple):
    """Where a run stands in the other mission, but for what it knows."""

    stands: dict[str, Any]
    """As `Chart.snapshot` has it."""
    begins: tuple[tuple[str, bool], ...]
    """States whose activity begins, and whether they are new."""
    under_way: tuple[Effect, ...]
    notes: tuple[str, ...]
    faults: tuple[Fault, ...]


def carry(naming: Naming, was: Mapping[str, Any], found: ReachedStates, under: InFlight) -> Carried:
    """Take over what a run remembers.

    Args:
        naming: What everything is called.
        was: The snapshot of the run's chart.
        found: Where it stands now.
        under: What it had under way.
    """
    return _Carrying(naming, was, found).carried(under)


class _Carrying:
    def __init__(self, naming: Naming, was: Mapping[str, Any], found: ReachedStates) -> None:
        self.naming, self.was, self.found, self.at = naming, was, found, was["at"]
        self.order = was["_order"]
        self.notes: list[str] = []
        self.faults: list[Fault] = []
        self.running: dict[str, Any] = {}
        self.begins: list[tuple[str, bool]] = []
        self.transitions = {
            then: now
            for new, old in (("", ""), *found.origins.items())
            for then, now in naming.transitions(old, new)
        }  # fmt: skip

    def carried(self, under: InFlight) -> Carried:
        self._activities()
        goals, cancels = self._goals(under)
        carries: Mapping[Holds, Callable[[Any], Any]] = {
            "configuration": lambda names: self.found.atomic, "state": self._state, "states": self._waiting,
            "activities": lambda running: self.running, "deadlines": self._deadlines, "settling": self._settling,
            "rounds": self._rounds, "timers": self._timers, "goals": lambda goals_then: goals, "calls": dict,
            "events": self._queue, "invariants": self._invariants, "memory": self._memory, "ages": self._entered,
            "since": self._held, **dict.fromkeys(UNCHANGED, _unchanged),
        }  # fmt: skip
        stands = {word: carries[holds](self.was[word]) for _, word, holds in TABLE if holds in carries}
        stands["_order"] = self.order
        begins = tuple(each for each in self.begins if each[0] not in stands["_pending"])
        effects = (*self._under_way(under), *cancels)
        return Carried(stands, begins, effects, tuple(self.notes), tuple(self.faults))

    # -- what runs ------------------------------------------------------------------------------------------------

    def _goes_on(self, old: str, new: str) -> bool:
        return self.naming.runs_the_same(old, new)

    def _activities(self) -> None:
        unbegun = dict(self.was["_unbegun"])
        for name in self.found.active:
            old = self.found.origins.get(name)
            if old in unbegun:
                self.begins.append((name, unbegun[old]))
            elif old is None:
                self.begins.append((name, True))
            elif not self._goes_on(old, name):
                self.begins.append((name, False))
                if old in self.was["_running"]:
                    self.notes.append(f"what ran in '{old}' has changed; '{name}' begins anew")
            elif old in self.was["_running"]:
                self.running[name] = self._renamed(self.was["_running"][old], name)

    def _renamed(self, state: Any, owner: str) -> Any:
        """What a machine remembers; a question is its state's, and shows keys by their names."""
        if isinstance(state, DecisionActivity):
            return state._replace(question=self._question(state.question, owner))
        if isinstance(state, TreeActivity):
            leaves = {
                path: RunningLeaf(self._renamed(tended.state, f"{owner}#{path}"), tended.deadline)
                for path, tended in state.leaves.items()
            }
            return state._replace(leaves=leaves)
        return state

    def _question(self, question: Question, owner: str) -> Question:
        evidence = tuple(each._replace(key=self.naming.path(each.key)) for each in question.evidence)
        return question._replace(owner=owner, evidence=evidence)

    def _goals(self, under: InFlight) -> tuple[list[list[Any]], list[CancelGoal]]:
        """The ledger; a goal that nobody owns any more is to be ended."""
        kept = {number for state in self.running.values() for number in _numbers(state)}
        goals, cancels = [], []
        for goal in (Goal(*each) for each in self.was["goals"]):
            is_lost = goal.phase in ("sent", "running") and goal.number not in kept
            if is_lost:
                self.notes.append(f"goal {goal.number} of '{goal.action}' belongs to nothing any more and is canceled")
            if is_lost or goal.number in under.canceled:
                cancels.append(CancelGoal(goal.number, goal.action))
            ending = goal._replace(phase="canceling", until=self.at + goal.cancel_s)
            goals.append(list(ending if is_lost else goal))
        return goals, cancels

    def _under_way(self, under: InFlight) -> list[Effect]:
        """What the process that goes on must see to, as if this run had begun it."""
        questions = {
            question.number: question for state in self.running.values() for question in questions_in(state)
        }  # fmt: skip
        found: list[Effect] = []
        for number, effect in under.open.items():
            if not isinstance(effect, Ask):
                found.append(effect)
            elif number in questions:
                found.append(Ask(questions[number]))
        found += [each for each in under.unconfirmed if isinstance(each, PublishMessage | SayAloud)]
        return found + ([under.handover] if under.handover is not None else [])

    # -- time -----------------------------------------------------------------------------------------------------

    def _timers(self, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        timers = {key: timer for key, timer in ((self._raised(key, was[key])) for key in was) if key is not None}
        for name in ("", *self.found.active):
            old = "" if not name else self.found.origins.get(name)
            timers |= self._timeout(name, old, was) | self._after(name, old, was)
        return timers

    def _raised(self, key: Any, timer: Timer) -> tuple[Any, Timer]:
        """An event that is to be raised later."""
        if key[0] != "raise":
            return None, timer
        name = self.naming.event(timer.name)
        if name is None and timer.name not in self.naming.map.events:
            sentence = f"'{timer.name}' is to be raised later, and the mission now has no such event"
            self.faults.append(Fault("/events", f'{sentence}; name it, or drop it: "{timer.name}": null'))
        return (key if name is not None else None), timer._replace(name=name or timer.name)

    def _timeout(self, name: str, old: str | None, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        limit = self.naming.states_now[name][1].timeout_s if name else None
        if limit is None:
            return {}
        if old is not None and self._goes_on(old, name) and self.naming.states_then[old][1].timeout_s == limit:
            left = was.get(("timeout", old))
            return {("timeout", name): left} if left is not None else {}
        return {("timeout", name): self._anew(f"the time limit of '{name}'", limit, f"{limit:g}")}

    def _after(self, name: str, old: str | None, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        """A row's time goes on where the row is as it was; one that has fired does not fire again."""
        timers: dict[Any, Timer] = {}
        same = {now: then for then, now in self.naming.transitions(old, name)} if old is not None else {}
        for place, transition in self.naming.transitions_now(name):
            if "after_s" not in transition:
                continue
            if place not in same:
                timers["after", place] = self._anew(f"the time of {place}", transition["after_s"], "after_s")
            elif (left := was.get(("after", same[place]))) is not None:
                timers["after", place] = left
        return timers

    def _anew(self, what: str, after_s: float, name: str) -> Timer:
        self.notes.append(f"{what} begins anew")
        self.order += 1
        return Timer(self.at + after_s, self.order, name)

    # -- what is remembered ---------------------------------------------------------------------------------------

    def _state(self, name: str | None) -> str | None:
        return self.naming.state(name) if name else None

    def _invariants(self, names: Collection[str]) -> frozenset[str]:
        return frozenset(name for name in names if name in self.naming.now.invariants)

    def _deadlines(self, was: Mapping[str, float]) -> dict[str, float]:
        origins = self.found.origins.items()
        return {new: was[old] for new, old in origins if old in was and self._goes_on(old, new)}

    def _settling(self, was: Mapping[str, float]) -> dict[str, float]:
        return {new: was[old] for new, old in self.found.origins.items() if old in was}

    def _rounds(self, was: Mapping[str, Any]) -> dict[str, Any]:
        lists = {name for name in self.found.active if isinstance(self.naming.states_now[name][1], Each)}
        return {
            new: was[old] for new, old in self.found.origins.items() if new in lists and old in was
        }  # fmt: skip

    def _waiting(self, names: Collection[str]) -> tuple[str, ...]:
        """States whose activity is to start again."""
        origins = self.found.origins.items()
        return tuple(new for new, old in origins if old in names and self._goes_on(old, new))

    def _queue(self, events: Iterable[Event]) -> tuple[Event, ...]:
        """What came while the run was paused or held."""
        queue = []
        for event in events:
            if event.kind == OUTCOME:
                state = self.naming.state(event.data["state"])
                queue += [event._replace(data={**event.data, "state": state})] if state is not None else []
                continue
            if event.kind == "event" and event.name in BUILT_IN_EVENTS:
                queue.append(event)
                continue
            name = self.naming.event(event.name) if event.kind == "event" else event.name
            if name is not None:
                queue.append(event._replace(name=name))
            elif event.name not in self.naming.map.events:
                sentence = (
                    f"'{event.name}' came while the run was paused or held, and the mission now has no such event"
                )
                self.faults.append(Fault("/events", f'{sentence}; name it, or drop it: "{event.name}": null'))
        return tuple(queue)

    def _memory(self, was: Mapping[str, Collection[str]]) -> dict[str, tuple[str, ...]]:
        """Where histories lead back to."""
        memory = {}
        inside = {name: _parents(place) for name, (place, _) in self.naming.states_now.items()}
        for old, held in was.items():
            new, states = self.naming.state(old), [self.naming.state(name) for name in held]
            room = inside[new][:-1] if new is not None else ()
            known = [name for name in states if name is not None]
            if (
                new is not None
                and known
                and len(known) == len(states)
                and all(inside[name][: len(room)] == room for name in known)
            ):
                memory[new] = tuple(known)
            else:
                self.notes.append(f"what '{old}' led back to is forgotten")
        return memory

    def _entered(self, was: Mapping[str, float]) -> dict[str, float]:
        found = {name: was.get(self.found.origins.get(name, ""), self.at) for name in self.found.active}
        return found | {"": was.get("", 0.0)}

    def _held(self, was: Mapping[str, float]) -> dict[str, float]:
        """Since when guards have been true; that of an invariant and of a row that is as it was goes on."""
        held = {}
        for memory, since in was.items():
            place, sign, number = memory.rpartition("#")
            now = self.transitions.get(place)
            if now is not None:
                held[f"{now}{sign}{number}"] = since
            elif place.startswith("/invariants/"):
                held[memory] = since
        return held


def _unchanged(value: Any) -> Any:
    return value


def _numbers(state: Any) -> list[int]:
    """The numbers of the goals that a machine's state waits for."""
    if isinstance(state, TreeActivity):
        return [number for tended in state.leaves.values() for number in _numbers(tended.state)]
    return [getattr(state, "number", 0)]


def _parents(place: str) -> tuple[str, ...]:
    return tuple(place.split("/"))[2::2]
