# SPDX-License-Identifier: Apache-2.0
"""W3C SCXML's algorithm (REC-scxml-20150901, appendix D), statement by statement, over a mission written as JSON.

Rule: this shares nothing with the engine: no code, no types, no optimisation. Names are those of the pseudo-code.

What a mission writes and SCXML does not is put in SCXML's words: an outcome of a state with states is `done.state.id`
with the outcome as its data, `after_s` is an event that is sent on entry and canceled on exit, `raise … after_s` is a
`<send>` that takes the place of an earlier one of the same id, transitions of the mission are transitions of `<scxml>`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

__all__ = ("Endless", "Interpreter")

MOST_MICROSTEPS = 300
WORST_FIRST = ("failed", "aborted", "canceled", "succeeded")
ORDER: dict[str, Callable[[Any, Any], bool]] = {
    "==": lambda one, other: one == other,
    "!=": lambda one, other: one != other,
    "<": lambda one, other: one < other,
    "<=": lambda one, other: one <= other,
    ">": lambda one, other: one > other,
    ">=": lambda one, other: one >= other,
}


class Endless(Exception):
    """The chart runs in circles."""


@dataclass(eq=False)
class Element:
    id: str
    kind: str
    parent: Element | None
    order: int
    data: dict[str, Any]
    states: list[Element] = field(default_factory=list)
    histories: list[Element] = field(default_factory=list)
    transitions: list[Transition] = field(default_factory=list)


@dataclass(eq=False)
class Transition:
    source: Element
    events: tuple[str, ...]
    cond: dict[str, Any] | None
    target: tuple[str, ...]
    internal: bool
    content: list[dict[str, Any]]
    after_s: float | None
    place: str


@dataclass(frozen=True)
class Event:
    name: str
    done: str = ""
    """The state whose end it reports of."""
    transition: Transition | None = None
    """The one transition that may answer: that of an `after_s`."""


@dataclass(frozen=True)
class Delayed:
    due: float
    order: int
    id: Any
    event: Event


def many(given: Any) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given or ())


def is_compound_state(s: Element) -> bool:
    return s.kind == "state" and bool(s.states)


def is_atomic_state(s: Element) -> bool:
    return s.kind == "final" or (s.kind == "state" and not s.states)


def get_proper_ancestors(state1: Element, state2: Element | None) -> Iterator[Element]:
    anc = state1.parent
    while anc is not None and anc is not state2:
        yield anc
        anc = anc.parent


def is_descendant(state1: Element, state2: Element) -> bool:
    return state2 in get_proper_ancestors(state1, None)


class Interpreter:
    """One run of one chart. `log` holds what was logged since it was last emptied."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.declared = set(document.get("events", ()))
        self.elements: dict[str, Element] = {}
        self.count = 0
        self.doc = Element("", "scxml", None, 0, document)
        self._children(self.doc, document["states"])
        for element in (self.doc, *self.elements.values()):
            place = "/states/" + element.id if element.id else ""
            transitions = element.data.get("transitions", ()) if element.kind != "history" else ()
            element.transitions = [self._transition(element, t, f"{place}/{i}") for i, t in enumerate(transitions)]
        self.datamodel = {name: key.get("initial") for name, key in document.get("blackboard", {}).items()}
        self.configuration: set[Element] = set()
        self.history_value: dict[str, list[Element]] = {}
        self.internal_queue: deque[Event] = deque()
        self.external_queue: deque[Event] = deque()
        self.delayed: list[Delayed] = []
        self.sent, self.now, self.microsteps = 0, 0.0, 0
        self.running, self.outcome = True, ""
        self.log: list[str] = []

    def _children(self, parent: Element, states: dict[str, Any]) -> None:
        for name, data in states.items():
            kind = next((word for word in ("parallel", "history", "final") if word in data), "state")
            self.count += 1
            element = self.elements[name] = Element(name, kind, parent, self.count, data)
            (parent.histories if kind == "history" else parent.states).append(element)
            self._children(element, data.get("states") or data.get("parallel") or {})

    def _transition(self, source: Element, written: dict[str, Any], place: str) -> Transition:
        return Transition(
            source,
            many(written.get("on")),
            written.get("when"),
            many(written.get("to")),
            bool(written.get("internal")),
            written.get("do", []),
            written.get("after_s"),
            place,
        )

    # -- what drives it -------------------------------------------------------------------------------------------

    def interpret(self, at: float = 0.0) -> None:
        self.now = at
        self._schedule_after(self.doc)
        self.enter_states([Transition(self.doc, (), None, many(self.doc.data["initial"]), False, [], None, "")])
        self.main_event_loop()

    def send(self, name: str, at: float) -> None:
        """An external event at a time, after everything that was due until then."""
        self.advance(at)
        if self.running and name in self.declared:
            self.external_queue.append(Event(name))
            self.main_event_loop()

    def assign(self, key: str, value: Any, at: float) -> None:
        """Someone outside writes the datamodel; transitions without an event look at it."""
        self.advance(at)
        if self.running:
            self.datamodel[key] = value
            self.main_event_loop()

    def advance(self, at: float) -> None:
        while self.running and any(each.due <= at for each in self.delayed):
            self.microsteps = 0
            first = min(self.delayed, key=lambda each: (each.due, each.order))
            self.delayed.remove(first)
            self.now = max(self.now, first.due)
            self.external_queue.append(first.event)
            self.main_event_loop()
        self.now, self.microsteps = max(self.now, at), 0

    # -- procedures of appendix D ---------------------------------------------------------------------------------

    def main_event_loop(self) -> None:
        while self.running:
            macrostep_done = False
            while self.running and not macrostep_done:
                enabled_transitions = self.select_eventless_transitions()
                if not enabled_transitions:
                    if not self.internal_queue:
                        macrostep_done = True
                    else:
                        enabled_transitions = self.react(self.internal_queue.popleft())
                if enabled_transitions:
                    self.microstep(enabled_transitions)
            if not self.running or not self.external_queue:
                break
            enabled_transitions = self.react(self.external_queue.popleft())
            if enabled_transitions:
                self.microstep(enabled_transitions)
        if not self.running:
            self.exit_interpreter()

    def exit_interpreter(self) -> None:
        for s in sorted(self.configuration, key=lambda s: -s.order):
            self.execute_content(s.data.get("exit", []))
        self.delayed.clear()
        self.external_queue.clear()
        self.internal_queue.clear()

    def react(self, event: Event) -> list[Transition]:
        """selectTransitions; a failure that no one takes breaks the mission off (which is not SCXML)."""
        if event.done and self.elements[event.done] not in self.configuration:
            return []
        enabled = self.select_transitions(event)
        if event.done and not enabled and event.name != "succeeded" and not self._in_region(event.done):
            self.running, self.outcome = False, "failed"
        return enabled

    def select_eventless_transitions(self) -> list[Transition]:
        return self._select(lambda t: not t.events and t.after_s is None)

    def select_transitions(self, event: Event) -> list[Transition]:
        return self._select(lambda t: self.name_match(t, event))

    def _select(self, matches: Callable[[Transition], bool]) -> list[Transition]:
        enabled_transitions: list[Transition] = []
        atomic_states = sorted((s for s in self.configuration if is_atomic_state(s)), key=lambda s: s.order)
        for state in atomic_states:
            found = self._first_enabled(state, matches)
            if found is not None and found not in enabled_transitions:
                enabled_transitions.append(found)
        return self.remove_conflicting_transitions(enabled_transitions)

    def _first_enabled(self, state: Element, matches: Callable[[Transition], bool]) -> Transition | None:
        for s in (state, *get_proper_ancestors(state, None)):
            for t in s.transitions:
                if matches(t) and self.condition_match(t.cond):
                    return t
        return None

    def remove_conflicting_transitions(self, enabled_transitions: list[Transition]) -> list[Transition]:
        filtered_transitions: list[Transition] = []
        for t1 in enabled_transitions:
            t1_preempted = False
            transitions_to_remove: list[Transition] = []
            for t2 in filtered_transitions:
                if self.compute_exit_set([t1]) & self.compute_exit_set([t2]):
                    if is_descendant(t1.source, t2.source):
                        transitions_to_remove.append(t2)
                    else:
                        t1_preempted = True
                        break
            if not t1_preempted:
                for t3 in transitions_to_remove:
                    filtered_transitions.remove(t3)
                filtered_transitions.append(t1)
        return filtered_transitions

    def microstep(self, enabled_transitions: list[Transition]) -> None:
        self.microsteps += 1
        if self.microsteps > MOST_MICROSTEPS:
            raise Endless
        self.exit_states(enabled_transitions)
        for t in enabled_transitions:
            self.execute_content(t.content)
        self.enter_states(enabled_transitions)

    def exit_states(self, enabled_transitions: list[Transition]) -> None:
        states_to_exit = sorted(self.compute_exit_set(enabled_transitions), key=lambda s: -s.order)
        for s in states_to_exit:
            for h in s.histories:
                if h.data["history"] == "deep":
                    value = [s0 for s0 in self.configuration if is_atomic_state(s0) and is_descendant(s0, s)]
                else:
                    value = [s0 for s0 in self.configuration if s0.parent is s]
                self.history_value[h.id] = sorted(value, key=lambda s0: s0.order)
        for s in states_to_exit:
            self.execute_content(s.data.get("exit", []))
            self.delayed = [
                each for each in self.delayed if each.event.transition is None or each.event.transition.source is not s
            ]
            self.configuration.remove(s)

    def compute_exit_set(self, transitions: Iterable[Transition]) -> set[Element]:
        states_to_exit: set[Element] = set()
        for t in transitions:
            if t.target:
                domain = self.get_transition_domain(t)
                assert domain is not None
                states_to_exit |= {s for s in self.configuration if is_descendant(s, domain)}
        return states_to_exit

    def enter_states(self, enabled_transitions: list[Transition]) -> None:
        states_to_enter: set[Element] = set()
        for t in enabled_transitions:
            for name in t.target:
                self.add_descendant_states_to_enter(self.elements[name], states_to_enter)
            ancestor = self.get_transition_domain(t)
            for s in self.get_effective_target_states(t.target):
                self.add_ancestor_states_to_enter(s, ancestor, states_to_enter)
        for s in sorted(states_to_enter, key=lambda s: s.order):
            self.configuration.add(s)
            self.execute_content(s.data.get("entry", []))
            if s.kind == "final":
                self._reach_final(s)
        for s in sorted(states_to_enter, key=lambda s: s.order):
            self._schedule_after(s)

    def _reach_final(self, s: Element) -> None:
        parent = s.parent
        assert parent is not None
        if parent is self.doc:
            self.running, self.outcome = False, s.data["final"]
            return
        grandparent = parent.parent
        self.internal_queue.append(Event(s.data["final"], parent.id))
        if (
            grandparent is not None
            and grandparent.kind == "parallel"
            and all(map(self.is_in_final_state, grandparent.states))
        ):
            ends = [
                each.data["final"]
                for each in self.configuration
                if each.kind == "final" and each.parent in grandparent.states
            ]
            self.internal_queue.append(Event(min(ends, key=WORST_FIRST.index), grandparent.id))

    def add_descendant_states_to_enter(self, state: Element, states_to_enter: set[Element]) -> None:
        if state.kind == "history":
            assert state.parent is not None
            targets = self._recalled(state)
            for s in targets:
                self.add_descendant_states_to_enter(s, states_to_enter)
            for s in targets:
                self.add_ancestor_states_to_enter(s, state.parent, states_to_enter)
            return
        states_to_enter.add(state)
        if is_compound_state(state):
            targets = [self.elements[name] for name in many(state.data["initial"])]
            for s in targets:
                self.add_descendant_states_to_enter(s, states_to_enter)
            for s in targets:
                self.add_ancestor_states_to_enter(s, state, states_to_enter)
        elif state.kind == "parallel":
            self._enter_regions(state, states_to_enter)

    def add_ancestor_states_to_enter(
        self, state: Element, ancestor: Element | None, states_to_enter: set[Element]
    ) -> None:
        for anc in get_proper_ancestors(state, ancestor):
            if anc is self.doc:
                return
            states_to_enter.add(anc)
            if anc.kind == "parallel":
                self._enter_regions(anc, states_to_enter)

    def _enter_regions(self, parallel: Element, states_to_enter: set[Element]) -> None:
        for child in parallel.states:
            if not any(is_descendant(s, child) for s in states_to_enter):
                self.add_descendant_states_to_enter(child, states_to_enter)

    def _recalled(self, history: Element) -> list[Element]:
        """What a history state holds, or else the targets of its default transition, or of its parent's `initial`."""
        assert history.parent is not None
        default = history.data.get("transitions") or [{"to": history.parent.data["initial"]}]
        return self.history_value.get(history.id) or [self.elements[name] for name in many(default[0]["to"])]

    def is_in_final_state(self, s: Element) -> bool:
        if is_compound_state(s):
            return any(each.kind == "final" and each in self.configuration for each in s.states)
        return s.kind == "parallel" and all(map(self.is_in_final_state, s.states))

    def get_transition_domain(self, t: Transition) -> Element | None:
        tstates = self.get_effective_target_states(t.target)
        if not tstates:
            return None
        if t.source is self.doc:
            return self.doc
        if t.internal and is_compound_state(t.source) and all(is_descendant(s, t.source) for s in tstates):
            return t.source
        for anc in get_proper_ancestors(t.source, None):
            if (is_compound_state(anc) or anc is self.doc) and all(is_descendant(s, anc) for s in tstates):
                return anc
        raise AssertionError("every state is inside the document")

    def get_effective_target_states(self, target: Iterable[str | Element]) -> list[Element]:
        targets: list[Element] = []
        for each in target:
            s = self.elements[each] if isinstance(each, str) else each
            targets += self.get_effective_target_states(self._recalled(s)) if s.kind == "history" else [s]
        return targets

    # -- names, conditions and content ----------------------------------------------------------------------------

    def name_match(self, t: Transition, event: Event) -> bool:
        if event.transition is not None or t.after_s is not None:
            return t is event.transition
        if event.done:
            done = self.elements[event.done]
            climbs = event.name != "succeeded" and not self._in_region(event.done)
            return event.name in t.events and (t.source is done or (climbs and is_descendant(done, t.source)))
        return event.name in t.events or "*" in t.events

    def _in_region(self, name: str) -> bool:
        parent = self.elements[name].parent
        return parent is not None and parent.kind == "parallel"

    def condition_match(self, cond: dict[str, Any] | None) -> bool:
        if cond is None:
            return True
        if "in" in cond and "key" not in cond:
            return self.elements[cond["in"]] in self.configuration
        if "not" in cond:
            return not self.condition_match(cond["not"])
        if "all" in cond:
            return all(map(self.condition_match, cond["all"]))
        if "any" in cond:
            return any(map(self.condition_match, cond["any"]))
        op = next(word for word in cond if word != "key")
        return ORDER[op](self.datamodel[cond["key"]], cond[op])

    def execute_content(self, content: list[dict[str, Any]]) -> None:
        for each in content:
            if "log" in each:
                self.log.append(each["log"])
            elif "set" in each:
                self.datamodel[each["set"]] = (
                    self.datamodel[each["set"]] + each["add"] if "add" in each else each["value"]
                )
            elif "drop" in each:
                self._cancel(each["drop"])
            elif "after_s" in each:
                self._cancel(each.get("id"))
                self._send_later(each["after_s"], each.get("id"), Event(each["raise"]))
            else:
                self.internal_queue.append(Event(each["raise"]))

    def _cancel(self, sendid: Any) -> None:
        self.delayed = [each for each in self.delayed if sendid is None or each.id != sendid]

    def _send_later(self, delay_s: float, sendid: Any, event: Event) -> None:
        self.sent += 1
        self.delayed.append(Delayed(self.now + delay_s, self.sent, sendid, event))

    def _schedule_after(self, s: Element) -> None:
        for t in s.transitions:
            if t.after_s is not None:
                self._send_later(t.after_s, None, Event("after_s", transition=t))
