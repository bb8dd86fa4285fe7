# SPDX-License-Identifier: Apache-2.0
"""What continues in the other mission, and what begins there again: activities, goals, timers, memories.

Rule: what is written as it was continues unchanged; all else begins again, and the notes name it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree import TreeActivity, questions_in
from rai_missions.engine.state import TABLE, FieldKind, Timer
from rai_missions.engine.step import Ask, CancelGoal, Effect, PublishMessage, SayAloud
from rai_missions.errors import Fault
from rai_missions.event import Event
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import BUILT_IN_EVENTS
from rai_missions.replay.migrate.configuration import ReachedStates
from rai_missions.replay.migrate.names import Naming
from rai_missions.states.compound import Each

__all__ = ("CarriedState", "carry")

UNCHANGED: tuple[FieldKind, ...] = ("value", "number", "past", "end", "payload", "deadline")
"""What names nothing of the mission, and is what it was."""
LEFT: tuple[FieldKind, ...] = ("passing", "controls", "begins", "board")
"""What follows from the rest, begins again, or is carried elsewhere."""


class CarriedState(NamedTuple):
    """What a run remembers in the other mission, but for its blackboard."""

    snapshot: dict[str, Any]
    """As `Chart.snapshot` has it."""
    begins: tuple[tuple[str, bool], ...]
    """States whose activity begins, and whether they are new."""
    under_way: tuple[Effect, ...]
    notes: tuple[str, ...]
    faults: tuple[Fault, ...]


def carry(naming: Naming, was: Mapping[str, Any], found: ReachedStates, under: InFlight) -> CarriedState:
    """Take over what a run remembers.

    Args:
        naming: What everything is called.
        was: The snapshot of the run's chart.
        found: The states that are active now.
        under: What it had under way.
    """
    return _Transfer(naming, was, found).carried(under)


class _Transfer:
    def __init__(self, naming: Naming, was: Mapping[str, Any], found: ReachedStates) -> None:
        self.naming, self.was, self.found, self.at = naming, was, found, was["at"]
        self.order = was["_order"]
        self.notes: list[str] = []
        self.faults: list[Fault] = []
        self.running: dict[str, Any] = {}
        self.begins: list[tuple[str, bool]] = []
        self.unchanged = {new: old for new, old in found.origins.items() if naming.runs_the_same(old, new)}
        """State → what it was called, of those that run what they ran."""
        self.transitions_then = {
            now: then
            for new, old in (("", ""), *found.origins.items())
            for now, then in naming.transitions(old, new).items()
        }
        """Place now → place then."""

    def carried(self, under: InFlight) -> CarriedState:
        self._activities()
        goals, cancels = self._goals(under)
        carries: Mapping[FieldKind, Callable[[Any], Any]] = {
            "configuration": lambda names: self.found.atomic,
            "state": lambda name: self.naming.state(name or ""),
            "states": lambda names: tuple(new for new, old in self.unchanged.items() if old in names),
            "activities": lambda running: self.running,
            "deadlines": lambda was: _kept(was, self.unchanged),
            "settling": lambda was: _kept(was, self.found.origins),
            "rounds": self._rounds,
            "timers": self._timers,
            "lists": self._lists,
            "goals": lambda goals_then: goals,
            "calls": dict,
            "events": self._queue,
            "invariants": lambda names: frozenset(names).intersection(self.naming.now.invariants),
            "memory": self._memory,
            "ages": self._ages,
            "since": self._since,
            **dict.fromkeys(UNCHANGED, lambda value: value),
        }
        snapshot = {word: carries[kind](self.was[word]) for _, word, kind in TABLE if kind not in LEFT}
        snapshot["_order"] = self.order
        begins = tuple(each for each in self.begins if each[0] not in snapshot["_pending"])
        effects = (*self._under_way(under), *cancels)
        return CarriedState(snapshot, begins, effects, tuple(self.notes), tuple(self.faults))

    # -- what runs ------------------------------------------------------------------------------------------------

    def _activities(self) -> None:
        unbegun, running = dict(self.was["_unbegun"]), self.was["_running"]
        for name in self.found.active:
            old = self.found.origins.get(name)
            if old in unbegun:
                self.begins.append((name, unbegun[old]))
            elif name not in self.unchanged:
                self.begins.append((name, old is None))
                if old in running:
                    self.notes.append(f"what ran in '{old}' has changed; '{name}' begins again")
            elif old in running:
                self.running[name] = self._renamed(running[old], name)

    def _renamed(self, state: Any, owner: str) -> Any:
        """What a machine remembers; a question is its state's, and shows keys by their names."""
        if isinstance(state, DecisionActivity):
            question, path = state.question, self.naming.names.path
            evidence = tuple(each._replace(key=path(each.key)) for each in question.evidence)
            return state._replace(question=question._replace(owner=owner, evidence=evidence))
        if isinstance(state, TreeActivity):
            leaves = state.leaves.items()
            return state._replace(
                leaves={
                    path: leaf._replace(state=self._renamed(leaf.state, f"{owner}#{path}")) for path, leaf in leaves
                }
            )
        return state

    def _goals(self, under: InFlight) -> tuple[list[list[Any]], list[CancelGoal]]:
        """The ledger; a goal that belongs to nothing any more is to be ended."""
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
        """What the next process must see to, as if this run had begun it."""
        questions = {each.number: each for state in self.running.values() for each in questions_in(state)}
        found: list[Effect] = [
            Ask(questions[number]) if isinstance(effect, Ask) else effect
            for number, effect in under.open.items()
            if number in questions or not isinstance(effect, Ask)
        ]
        found += [each for each in under.unconfirmed if isinstance(each, PublishMessage | SayAloud)]
        return found + ([under.handover] if under.handover is not None else [])

    # -- time -----------------------------------------------------------------------------------------------------

    def _timers(self, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        timers = {}
        for key, timer in was.items():
            if key[0] == "raise" and (name := self._event(timer.name, "is to be raised later")) is not None:
                timers[key] = timer._replace(name=name)
        for new in ("", *self.found.active):
            timers |= self._timeout(new, was) | self._after(new, was)
        return timers

    def _timeout(self, name: str, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        limit = self.naming.states_now[name][1].timeout_s if name else None
        old = self.unchanged.get(name)
        if limit is None:
            return {}
        if old is not None and self.naming.states_then[old][1].timeout_s == limit:
            return _kept({name: was.get(("timeout", old))}, {("timeout", name): name})
        return {("timeout", name): self._restarted(f"the time limit of '{name}'", limit, f"{limit:g}")}

    def _after(self, name: str, was: Mapping[Any, Timer]) -> dict[Any, Timer]:
        """A transition's time continues where it is as it was; one that has fired does not fire again."""
        timers: dict[Any, Timer] = {}
        for place, transition in self.naming.transitions_now(name).items():
            if "after_s" not in transition:
                continue
            if place not in self.transitions_then:
                timers["after", place] = self._restarted(f"the time of {place}", transition["after_s"], "after_s")
            elif (left := was.get(("after", self.transitions_then[place]))) is not None:
                timers["after", place] = left
        return timers

    def _restarted(self, what: str, after_s: float, name: str) -> Timer:
        self.notes.append(f"{what} begins again")
        self.order += 1
        return Timer(self.at + after_s, self.order, name)

    # -- what is remembered ---------------------------------------------------------------------------------------

    def _event(self, old: str, why: str) -> str | None:
        """What an event is called now; None for one that is dropped, which the map must name."""
        new = self.naming.event(old)
        if new is None and old not in self.naming.map.events:
            sentence = f"'{old}' {why}, and the mission now has no such event"
            self.faults.append(Fault("/events", f'{sentence}; name it, or drop it: "{old}": null'))
        return new

    def _queue(self, events: Iterable[Event]) -> tuple[Event, ...]:
        """What came while the run was paused or held."""
        return tuple(each for event in events if (each := self._queued(event)) is not None)

    def _queued(self, event: Event) -> Event | None:
        if event.kind == "outcome":
            state = self.naming.state(event.data["state"])
            return event._replace(data={**event.data, "state": state}) if state is not None else None
        if event.kind != "event" or event.name in BUILT_IN_EVENTS:
            return event
        name = self._event(event.name, "came while the run was paused or held")
        return event._replace(name=name) if name is not None else None

    def _rounds(self, was: Mapping[str, Any]) -> dict[str, Any]:
        states = self.naming.states_now
        return {new: each for new, each in _kept(was, self.found.origins).items() if isinstance(states[new][1], Each)}

    def _lists(self, was: Mapping[tuple[str, str], Any]) -> dict[tuple[str, str], Any]:
        """The lists that histories lead back into."""
        found, states = {}, self.naming.states_now
        for (old, old_list), each in was.items():
            history, name = self.naming.state(old), self.naming.state(old_list)
            if history is not None and name is not None and isinstance(states[name][1], Each):
                found[history, name] = each
        return found

    def _memory(self, was: Mapping[str, Collection[str]]) -> dict[str, tuple[str, ...]]:
        """Where histories lead back to."""
        memory = {}
        for old, held in was.items():
            new, states = self.naming.state(old), [self.naming.state(name) for name in held]
            room = self._parents(new)[:-1]
            known = tuple(name for name in states if name is not None and self._parents(name)[: len(room)] == room)
            if new is not None and known and len(known) == len(states):
                memory[new] = known
            else:
                self.notes.append(f"what '{old}' led back to is forgotten")
        return memory

    def _parents(self, name: str | None) -> tuple[str, ...]:
        """A state now with those around it, outer first."""
        return tuple(self.naming.states_now[name][0].split("/"))[2::2] if name is not None else ()

    def _ages(self, was: Mapping[str, float]) -> dict[str, float]:
        """Since when states have been active; one that is new, from now on."""
        origins = self.found.origins
        return {"": was.get("", 0.0)} | {name: was.get(origins.get(name, ""), self.at) for name in self.found.active}

    def _since(self, was: Mapping[str, float]) -> dict[str, float]:
        """Since when guards have been true; of an invariant or a transition that is as it was, they continue."""
        places = {then: now for now, then in self.transitions_then.items()}
        places |= {each: each for each in self.naming.invariants()}
        held = {}
        for memory, since in was.items():
            place, sign, number = memory.rpartition("#")
            if place in places:
                held[f"{places[place]}{sign}{number}"] = since
        return held


def _kept(was: Mapping[str, Any], origins: Mapping[Any, str]) -> dict[Any, Any]:
    """What was known of a thing under its old name, under the new one."""
    return {new: was[old] for new, old in origins.items() if was.get(old) is not None}


def _numbers(state: Any) -> list[int]:
    """The numbers of the goals that a machine's state waits for."""
    if isinstance(state, TreeActivity):
        return [number for leaf in state.leaves.values() for number in _numbers(leaf.state)]
    return [getattr(state, "number", 0)]
