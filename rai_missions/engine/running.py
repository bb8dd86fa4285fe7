# SPDX-License-Identifier: Apache-2.0
"""What states run while they are active: started when control allows, heard, and ended when they are left."""

from __future__ import annotations

from rai_missions.engine.activities.activity import GOALS, NO_KEYS, Machine, Turn, concerns
from rai_missions.engine.activities.factory import Bench, machine_of
from rai_missions.engine.activities.tree import limit_of, questions_in
from rai_missions.engine.decision import Question
from rai_missions.engine.hold import Hold
from rai_missions.engine.nodes import Node
from rai_missions.engine.state import Trigger
from rai_missions.engine.step import Handover
from rai_missions.event import Event

__all__ = ("Activities",)

WATCHED = {
    "refused": "its server refuses to cancel it",
    "lost": "its server is gone",
    "contested": "more than one server has it",
    "stray": "it is executing although its end was reported; it is canceled",
    "over": "it is executing nowhere any more",
}
"""What is noted of a goal where its server gives no words."""


class Activities(Hold):
    """A chart that runs the machines of its states."""

    @property
    def questions(self) -> tuple[Question, ...]:
        """Those that are open, the oldest first, each with the time that it has by now."""
        found = (each for _, _, state in self._live() for each in questions_in(state))
        return tuple(sorted(found, key=lambda question: question.number))

    @property
    def paused_at(self) -> float | None:
        """Since when no question loses time; None while the run is not paused."""
        return self._paused_at if self.mode == "paused" else None

    def _machine(self, node: Node) -> Machine | None:
        if node.name not in self._machines:
            assert node.state is not None
            bench = Bench(node.name, node.name, node.place, self.mission.blackboard, self.terms, self._ticker)
            self._machines[node.name] = machine_of(node.state, bench)
        return self._machines[node.name]

    def _begin_starting(self) -> None:
        """Start the activities of the states that are still active; first those whose control is where it belongs."""
        nodes, self._starting = sorted(self._starting, key=lambda node: node.index), []
        for node in nodes:
            if node not in self._config.atomic:  # left meanwhile, or an `each` in whose round another stands
                continue
            if self._frozen and self._is_held(node):
                self._laid_by = (*self._laid_by, node.name)
            elif node.control is not None and node.control != self.holder:
                self._request_control(node)
            else:
                self._begin(node)

    def _request_control(self, node: Node, until: float | None = None) -> None:
        assert node.state is not None and node.control is not None
        self._ask_for(node.control)
        self._pending[node.name] = self.begins_at + node.state.handover_s if until is None else until

    def _ask_for(self, holder: str) -> None:
        self._asked, request = holder, Handover(holder)
        if request not in self.effects:
            self.effects.append(request)

    def _take_back(self) -> None:
        """Ask for control where it is: what asked for it elsewhere was left before it came, and nobody else waits."""
        if self.outcome is None and self.holder not in ("operator", "nobody"):
            wanted = {self._graph.nodes[name].control for name in self._pending}
            if self._given_up - wanted - {self.holder}:
                self._asked = self.holder
                self.effects.append(Handover(self.holder))

    def _begin(self, node: Node) -> None:
        machine = self._machine(node) if node.activity else None
        if machine is not None:
            turn = machine.begin(self)
            self._running[node.name] = turn.state
            self._turn(node.name, turn)

    def _turn(self, name: str, turn: Turn) -> None:
        """Take over what a machine has made of something."""
        self._touched = True
        for key, value in turn.writes:
            self.write_key(key, value)
        self._emit(turn.effects)
        self.notes += turn.notes
        if turn.outcome is None:
            self._running[name] = turn.state
            return
        self._running.pop(name, None)
        self._pending.pop(name, None)
        node = self._graph.nodes[name]
        self._timers.pop(("timeout", name), None)
        if turn.outcome.why and node.family != "decision":
            self.notes.append(f"{name} {turn.outcome.name}: {turn.outcome.why}")
        self._internal.append(self._outcome_of(node, turn.outcome))

    def _leave_activity(self, node: Node) -> None:
        state = self._running.pop(node.name, None)
        machine = self._machines.get(node.name)
        if state is not None and machine is not None:
            if self._kept or self._queue:
                self._hear_kept(machine.awaits(state))
            turn = machine.leave(state, self)
            self._emit(turn.effects)
            self.notes += turn.notes

    def _poll(self) -> bool:
        """Let those machines look whom a key, a state, a goal's end or the time concerns; whether one spoke."""
        if self.outcome is not None or self.mode == "paused":
            return False
        if not (self._due or self._ledger.changed or self._shifted or self._news or self._polled < len(self.written)):
            return False
        changed = self._shifted.union({GOALS} if self._ledger.changed else NO_KEYS)
        keys = frozenset(key for key, _ in self.written[self._polled :]).union(changed, self._news)
        due, self._due, self._polled, self._ledger.changed = self._due, NO_KEYS, len(self.written), False
        news, self._news, self._shifted, spoke = self._news, {}, set(), False
        for name, machine, state in self._awake() if keys or due else ():
            if not (name in due or concerns(machine.reads(state), keys)):
                continue
            of_others = changed | {key for key, by in news.items() if by != name}
            tick = Event("tick", self.view.at, {"keys": keys, "news": frozenset(of_others)}, "tick")
            turn = machine.hear(state, tick, self)
            if turn is not None:
                self._turn(name, turn)
                spoke = True
        return spoke

    @property
    def _resting(self) -> tuple[str, ...]:
        """The states whose trees rest at a limit."""
        return tuple(name for name, state in self._running.items() if limit_of(state)) if self._has_trees else ()

    def _unfinished(self) -> frozenset[str]:
        """The states whose trees have rounds left that follow at this instant."""
        found = (name for name, state in self._running.items() if limit_of(state) == "rounds")
        return frozenset(found) if self._has_trees else NO_KEYS

    def _dispatch(self, event: Event) -> bool:
        """Tell the machine that waits for it; whether one did."""
        for name, machine, state in self._live():
            turn = machine.hear(state, event, self)
            if turn is not None:
                self._turn(name, turn)
                self._poll()
                self._complete(None)
                return True
        return False

    def _report(self, event: Event) -> None:
        """An action's server or a service has said something."""
        number = event.number
        known = number in self._ledger.goals
        if self.mode == "paused" and any(getattr(state, "number", 0) == number for state in self._running.values()):
            return self._wait_out_pause(event)
        if self._is_for_held(number):
            return self._keep(event)
        self.effects += self._ledger.hear(event)
        if number in self._calls and event.kind == "result":
            service = self._calls.pop(number)
            if event.name != "succeeded":
                why = str(event.data.get("why", event.name))
                self.notes.append(f"call of '{service}' failed: {why}")
                self._heard(Trigger("call_failed", {"call": service, "why": why}))
            return
        if self.outcome is not None or not self._dispatch(event):
            if not known:
                self._refused = f"stale: nothing that was started as {number} is running"
                return
            if event.kind == "result":
                self.notes.append(f"goal {number} has ended: {event.name}")
            if (self._poll() or self._internal) and self.outcome is None:
                self._complete(None)

    def _watch_goal(self, event: Event) -> None:
        """What a goal's servers do outside its course: refuse a cancel, be two, execute it after its end, stop it."""
        why = str(event.data.get("why", "")) or WATCHED[event.kind]
        known = event.number in self._ledger.goals
        if not known and event.kind != "stray":
            self._refused = f"stale: nothing that was started as {event.number} is running"
            return
        self.notes.append(f"goal {event.number} of '{event.name}': {why}")
        self.effects += self._ledger.hear(event)
        self._poll()
        if self._internal and self.outcome is None:
            self._complete(None)

    def _reads(self) -> frozenset[str]:
        """What may change something now when it changes: keys, and states that a machine asks for."""
        reads = self._config.reads | self._graph.invariant_reads
        for _, machine, state in self._live():
            reads |= machine.reads(state)
        if self._settling or self._final is not None:
            reads |= frozenset({"*"})
        return reads
