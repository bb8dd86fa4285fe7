# SPDX-License-Identifier: Apache-2.0
"""The pure semantics: what a mission makes of an event, as a Step.

Rule: everything that decides is in here or below. The same mission, events and times give the same Steps, wherever they come from.
Source: W3C SCXML (REC-scxml-20150901), appendix D, for selection, order and run to completion; the rest is `docs/guide/semantics.md`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.acts import Act, act_of
from rai_missions.blackboard import Blackboard, Stamped, fits
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.graph import Condition, Configuration, Graph, Leap, Node, Row
from rai_missions.guards.guard import Truth
from rai_missions.mission import BUILT_IN_EVENTS, Mission
from rai_missions.states.activity import Machine, Outcome, Turn
from rai_missions.states.compound import Each
from rai_missions.states.final import Final, worst
from rai_missions.states.goals import Ledger
from rai_missions.states.machines import machine_of
from rai_missions.states.terms import Terms
from rai_missions.states.ticker import Trees
from rai_missions.step import CancelGoal, Handover, Move, Step
from rai_missions.written import suggestion

__all__ = ("Chart", "Named", "Snapshot")

Named = Mapping[str, Callable[..., Truth]]
"""Predicates of the user's program by name; each gets the blackboard's values and the guard's `with`."""

MOST_MICROSTEPS = 10_000
"""Microsteps at one instant; a mission that wants more runs in circles."""

_new = tuple.__new__


class Trigger(NamedTuple):
    """What a microstep answers to: an event, or an outcome of a state."""

    name: str
    data: Mapping[str, Any]
    source: Node | None = None
    """The state whose outcome it is; None for an event."""
    climbs: bool = True
    why: str = ""
    row: Row | None = None
    """The one row that it may fire: that of an `after_s`."""


class Timer(NamedTuple):
    """Something that comes later."""

    due: float
    order: int
    name: str
    data: Mapping[str, Any] = {}


Snapshot = Mapping[str, Any]
"""All that a chart remembers, as values; `Chart.restore` goes on from there."""


class _View:
    """What guards see of a chart."""

    __slots__ = ("_chart", "active", "answer", "at", "board", "entered", "event", "held")

    def __init__(self, chart: Chart) -> None:
        self._chart = chart
        self.at = 0.0
        self.board: Blackboard = {}
        self.active: frozenset[str] = frozenset()
        self.entered: dict[str, float] = {}
        self.held: dict[str, float] = {}
        self.event: Mapping[str, Any] = {}
        self.answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        return self._chart.ask_named(name, arguments)


class Chart:
    """One run of a mission, as far as rules decide it.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees (`rai_missions.trees.PyTrees()`); needed only where the mission has one.
        terms: What is known of the robot: which actions exclude each other, when a composed one has succeeded.
        named: The predicates that `{"named": …}` guards name.

    Raises:
        UsageError: The mission has a tree and no ticker was given, or names a predicate that was not.
    """

    def __init__(
        self, mission: Mission, ticker: Trees | None = None, *, terms: Terms | None = None, named: Named | None = None
    ) -> None:
        self.mission = mission
        self.terms = terms if terms is not None else Terms()
        self.view = _View(self)
        self._named = dict(named or {})
        self._ticker = ticker
        self._graph = Graph(mission, self._act)
        self._declared = frozenset(mission.events)
        self._machines: dict[str, Machine | None] = {}
        self._invariants = tuple(self._graph.invariants.items())
        self._always_held = {memory: test for _, each in self._invariants for memory, test in each.holds.items()}
        self._reset()
        for name, key in mission.blackboard.items():
            if key.initial is not None:
                self.view.board[name] = Stamped(key.initial, 0.0)
        if any(isinstance(state.word, str) and state.word == "tree" for _, _, state in mission.walk()) and ticker is None:
            raise UsageError("the mission runs a tree; give the chart a ticker: Chart(mission, ticker=PyTrees())")

    def _reset(self) -> None:
        self.seq = 0
        """Steps so far."""
        self.mode = "ready"
        """`ready`, `running`, `paused`, `canceling` or `ended`."""
        self.holder = "autonomy"
        """Who holds control: `autonomy`, `agent`, `operator` or `nobody`."""
        self.outcome: str | None = None
        self.why = ""
        self.quiet = False
        """The last step did nothing but write the blackboard: it need not be written down by itself."""
        self._config: Configuration = self._graph.empty
        self._memory: dict[int, tuple[Node, ...]] = {}
        self._timers: dict[tuple[str, Any], Timer] = {}
        self._order = 0
        self._number = 0
        self._running: dict[str, Any] = {}
        self._pending: dict[str, float] = {}
        self._rounds: dict[str, tuple[tuple[Any, ...], int]] = {}
        self._settling: dict[str, float] = {}
        self._calls: dict[int, str] = {}
        self._ledger = Ledger(self.terms)
        self._paused_at = 0.0
        self._queue: tuple[Event, ...] = ()
        self._suspended: tuple[str, ...] = ()
        self._unknown: frozenset[str] = frozenset()
        self._cancel_by = math.inf
        self._final: Node | None = None
        self._wake = math.inf
        self._quick = False
        self._listening: frozenset[str] = frozenset()
        self._clear()

    def _clear(self) -> None:
        """What one step gathers."""
        self.moves: list[Move] = []
        self.looked: list[tuple[str, Truth]] = []
        self.written: list[tuple[str, Any]] = []
        self.effects: list[Any] = []
        self.notes: list[str] = []
        self._internal: deque[Trigger] = deque()
        self._starting: list[Node] = []
        self._refused = ""
        self._touched = False
        """Something that the run remembers has changed, beside the blackboard."""

    def _act(self, effect: Any, place: str, state: str) -> Act:
        return act_of(effect, place, state, self.mission.blackboard)

    # -- the public face ------------------------------------------------------------------------------------------

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self.view.active

    @property
    def at(self) -> float:
        """Now, in seconds on the run's clock."""
        return self.view.at

    @property
    def wake_at(self) -> float | None:
        """The earliest instant at which time alone can change something."""
        return None if self._wake == math.inf else self._wake

    @property
    def unheard(self) -> tuple[str, ...]:
        """The robot keys that the start waits for and that were never heard."""
        keys = self.mission.blackboard.items()
        return tuple(n for n, key in keys if key.source == "robot" and not key.optional and n not in self.view.board)

    @property
    def open_goals(self) -> int:
        """Goals whose end has not been confirmed and that are not given up as orphaned."""
        return sum(goal.phase != "orphaned" for goal in self._ledger.goals.values())

    def start(self, at: float = 0.0) -> Step:
        """Enter the mission.

        Raises:
            UsageError: It was started before.
        """
        if self.mode != "ready":
            raise UsageError(f"the mission was started before; it is {self.mode}")
        self._clear()
        view = self.view
        view.at = max(at, view.at)
        for name, key in self.mission.blackboard.items():
            if key.initial is not None and key.source != "robot" and view.board[name].at < view.at:
                view.board[name] = Stamped(view.board[name].value, view.at)
        self.mode = "running"
        if self._graph.root.clocked:
            view.entered[""] = view.at
        self._after_rows(self._graph.root)
        self._jump(self._graph.start(self._memory))
        self._complete(None)
        return self._close(Event("start", at, kind="command"))

    def write(self, key: str, value: Any, at: float = 0.0) -> Step:
        """Tell the blackboard what a key is, as of `at`.

        Raises:
            UsageError: The mission has no such key.
        """
        if key not in self.mission.blackboard:
            raise UsageError(f"the mission has no key '{key}'{suggestion(key, self.mission.blackboard)}")
        return self.send(Event(key, at, {"value": value}, "write"))

    def send(self, event: Event) -> Step:
        """Let an event happen: everything due before it first, then it, to completion."""
        name, at, data, kind, _ = event
        if kind != "event" or not self._quick or at >= self._wake:
            return self._send(event)
        view = self.view
        if at > view.at:
            view.at = at
        else:
            at = view.at
        config = self._config
        plan = config.plans.get(name)
        if plan is None:
            plan = config.plan(name, declared=name in self._declared)
        if not plan:
            return self._send(event) if name not in self._declared else self._quiet(event, at)
        view.event = data
        looked: list[tuple[str, Truth]] = []
        rows: list[Row] = []
        for chain in plan:
            for row in chain:
                test = row.test
                if test is not None:
                    value = test(view)
                    looked.append((row.place, value))
                    if value is not True:
                        continue
                if row not in rows:
                    rows.append(row)
                break
        if not rows:
            return self._quiet(event, at, tuple(looked))
        leap = config.leaps.get((tuple(rows), name))
        if leap is None or not leap.plain:
            return self._send(event)
        self._config = leap.config
        view.active = leap.config.active
        self.seq += 1
        wake = None if self._wake == math.inf else self._wake
        if not leap.acts:
            return _new(Step, (self.seq, at, event, leap.moves, tuple(looked), (), None, wake, (), "", ()))  # type: ignore[type-var]
        return self._acted(event, leap, looked)

    def _acted(self, event: Event, leap: Leap, looked: list[tuple[str, Truth]]) -> Step:
        """The end of a quick step that does something on the way."""
        for act in leap.acts:
            act(self)
        written = self.written
        if self._internal or (written and self._listening):
            self.seq -= 1
            self.moves.append(leap.move)
            self.looked += looked
            self._complete(None)
            return self._close(event)
        step: Step = _new(Step, (
            self.seq, self.view.at, event, leap.moves, tuple(looked), tuple(written), None,
            None if self._wake == math.inf else self._wake, tuple(self.effects), "", tuple(self.notes),
        ))  # type: ignore[type-var]  # fmt: skip
        written.clear()
        if self.effects or self.notes:
            self._clear()
        return step

    def _quiet(self, event: Event, at: float, looked: tuple[tuple[str, Truth], ...] = ()) -> Step:
        """A step in which no row fired."""
        self.seq += 1
        wake = None if self._wake == math.inf else self._wake
        return _new(Step, (self.seq, at, event, (), looked, (), None, wake, (), "", ()))  # type: ignore[type-var]

    def snapshot(self) -> Snapshot:
        """All that the run remembers, as values that later steps do not change."""
        names = (
            "seq", "mode", "holder", "outcome", "why", "_order", "_number", "_paused_at", "_queue", "_suspended", "_unknown",
            "_cancel_by", "_wake", "_quick", "_listening",
        )  # fmt: skip
        copies = ("_timers", "_running", "_pending", "_rounds", "_settling", "_calls")
        memory = {self._graph.order[at].name: tuple(each.name for each in nodes) for at, nodes in self._memory.items()}
        return {
            **{name: getattr(self, name) for name in names},
            **{name: dict(getattr(self, name)) for name in copies},
            "atomic": tuple(node.name for node in self._config.atomic),
            "memory": memory,
            "goals": self._ledger.saved(),
            "final": self._final.name if self._final else None,
            "at": self.view.at, "board": dict(self.view.board), "entered": dict(self.view.entered),
            "held": dict(self.view.held), "event": self.view.event, "answer": self.view.answer,
        }  # fmt: skip

    @classmethod
    def restore(
        cls, mission: Mission, saved: Snapshot, ticker: Trees | None = None, *, terms: Terms | None = None,
        named: Named | None = None,
    ) -> Chart:  # fmt: skip
        """A chart that goes on where a snapshot was taken."""
        chart = cls(mission, ticker, terms=terms, named=named)
        nodes, view = chart._graph.nodes, chart.view
        for name, value in saved.items():
            if name in ("atomic", "memory", "goals", "final"):
                continue
            if name in ("at", "board", "entered", "held", "event", "answer"):
                setattr(view, name, dict(value) if name in ("board", "entered", "held") else value)
            else:
                setattr(chart, name, dict(value) if isinstance(value, dict) else value)
        chart._config = chart._graph.configuration(nodes[name] for name in saved["atomic"])
        if not saved["atomic"]:
            chart._config = chart._graph.empty
        view.active = chart._config.active
        chart._memory = {nodes[name].index: tuple(nodes[each] for each in held) for name, held in saved["memory"].items()}
        chart._ledger.restore(saved["goals"])
        chart._final = nodes[saved["final"]] if saved["final"] else None
        return chart

    def absorb(self, writes: Iterable[tuple[str, Any, float]], *, at: float, seq: int) -> None:
        """Take over what quiet steps wrote, without stepping: a replay stands where the run stood then.

        Args:
            writes: Key, value and stamp.
            at: The time until which nothing else happened.
            seq: The number of the last step until then.
        """
        for key, value, stamp in writes:
            self.view.board[key] = Stamped(value, stamp)
        self.view.at, self.seq = max(self.view.at, at), seq
        self._quick = False

    # -- one step -------------------------------------------------------------------------------------------------

    def _send(self, event: Event) -> Step:
        self._clear()
        at = max(event.at, self.view.at)
        if self.mode == "ready":
            self.view.at = at
            if event.kind == "write":
                self._write(event)
            elif event.kind == "control":
                self.holder = event.name
            else:
                self._refused = "the mission has not been started"
            return self._close(event)
        self._catch_up(at)
        self.view.at = at
        self._handle(event)
        return self._close(event)

    def _close(self, event: Event) -> Step:
        self.seq += 1
        self._quick = self.mode == "running" and self._final is None and self.outcome is None
        self._listening = self._reads() if self.mode != "ended" else frozenset()
        self._wake = self._next_instant()
        why = self.why if self.outcome is not None and self.mode == "ended" and not self._refused else self._refused
        step = Step(
            self.seq, self.view.at, event, tuple(self.moves), tuple(self.looked), tuple(self.written), self.outcome,
            None if self._wake == math.inf else self._wake, tuple(self.effects), why, tuple(self.notes),
        )  # fmt: skip
        asked = any(place.startswith("named:") for place, _ in self.looked)
        said = self.moves or self.effects or self.notes or self._touched or self._refused or asked
        self.quiet = not said and event.kind in ("write", "tick")
        self._clear()
        return step

    def _catch_up(self, at: float) -> None:
        """Let everything that was due until `at` happen, each at its own instant."""
        same = 0
        while (due := self._next_instant()) <= at and same < MOST_MICROSTEPS:
            same = same + 1 if due <= self.view.at else 0
            self.view.at = max(self.view.at, due)
            self._instant()
        if same >= MOST_MICROSTEPS:
            self._end("failed", f"timers without end in {', '.join(sorted(self.view.active))}")

    def _instant(self) -> None:
        """What time alone does now."""
        now = self.view.at
        for goal in self._ledger.overdue(now):
            self.notes.append(f"goal {goal.number} of '{goal.action}' never confirmed its end: orphaned")
            self._heard(Trigger("orphaned", {"action": goal.action, "number": goal.number}))
        if self.mode == "paused":
            self._check_invariants()
            return
        if self.mode == "canceling" and now >= self._cancel_by:
            self._end("canceled", "the cancel took longer than cancel_s")
        while self.outcome is None:
            due = [(timer.due, timer.order, key) for key, timer in self._timers.items() if timer.due <= now]
            if not due:
                break
            key = min(due)[2]
            self._fire(key, self._timers.pop(key))
        for name in [name for name, until in self._pending.items() if until <= now]:
            del self._pending[name]
            node = self._graph.nodes[name]
            self._heard(self._outcome_of(node, Outcome("rejected", why=f"{node.control} was not given control in time")))
        self._poll()
        self._complete(None)

    def _fire(self, key: tuple[str, Any], timer: Timer) -> None:
        kind, which = key
        if kind == "after":
            self._heard(Trigger("after_s", {}, row=self._graph.rows[which]))
        elif kind == "timeout":
            node = self._graph.nodes[which]
            self._leave_activity(node)
            self._heard(self._outcome_of(node, Outcome("timed_out", why=f"{timer.name} s have passed")))
        else:
            self._heard(Trigger(timer.name, timer.data))

    def _heard(self, trigger: Trigger) -> None:
        """A macrostep of its own; while paused or after the end, nothing."""
        if self.mode in ("running", "canceling") and self.outcome is None:
            self._complete(trigger)

    def _handle(self, event: Event) -> None:
        kind = event.kind
        if kind in ("tick", "feedback"):
            return
        if kind == "command":
            self._command(event)
        elif kind in ("accepted", "result"):
            self._report(event)
        elif self.outcome is not None:
            self._refused = "the mission has ended"
        elif kind == "write":
            self._write(event)
        elif kind == "control":
            self._control(event)
        elif self.mode == "paused":
            self._queue = (*self._queue, event)
            self._touched = True
        elif self._final is not None:
            self._refused = f"the mission is ending in '{self._final.name}'"
        else:
            self._happen(event)

    def _happen(self, event: Event) -> None:
        if event.kind == "event":
            if event.name not in self._declared:
                known = suggestion(event.name, self._declared)
                self._refused = f"the mission declares no event '{event.name}'{known}"
            else:
                self._heard(Trigger(event.name, event.data))
        elif event.kind in ("proposal", "behaviour"):
            if not self._dispatch(event) and event.kind == "proposal":
                self._refused = f"stale: question {event.number} is no longer asked"
        elif event.kind == "result":
            self._report(event)

    def _report(self, event: Event) -> None:
        """An action's server or a service has said something."""
        number = event.number
        known = number in self._ledger.goals
        if self.mode == "paused" and any(getattr(state, "number", 0) == number for state in self._running.values()):
            self._queue = (*self._queue, event)
            self._touched = True
            return
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
            elif event.kind == "result":
                self.notes.append(f"goal {number} has ended: {event.name}")
            self._poll()
            if self._internal and self.outcome is None:
                self._complete(None)

    def _dispatch(self, event: Event) -> bool:
        """Tell the machine that waits for it; whether one did."""
        for name in list(self._running):
            machine = self._machines[name]
            assert machine is not None
            turn = machine.hear(self._running[name], event, self)
            if turn is not None:
                self._turn(name, turn)
                self._poll()
                self._complete(None)
                return True
        return False

    # -- the blackboard -------------------------------------------------------------------------------------------

    def _write(self, event: Event) -> None:
        key = self.mission.blackboard.get(event.name)
        value = event.data.get("value")
        stamp = min(float(event.data.get("stamp", event.at)), self.view.at)
        if key is None:
            self._refused = f"the mission has no key '{event.name}'{suggestion(event.name, self.mission.blackboard)}"
            return
        if why := fits(key, value):
            self._refused = f"'{event.name}' was not written: {why}"
            return
        entry = self.view.board.get(event.name)
        if entry is not None and entry.at > stamp:
            self._refused = f"'{event.name}' was not written: {entry.at - stamp:.3g} s older than what is known"
            return
        self.view.board[event.name] = Stamped(value, stamp)
        self.written.append((event.name, value))
        if event.name not in self._listening and "*" not in self._listening:
            return
        if self.mode == "paused":
            self._check_invariants()
        elif self.mode != "ready":
            self._poll()
            self._complete(None)

    def _reads(self) -> frozenset[str]:
        """The keys whose change may change something now."""
        reads = self._config.reads | self._graph.invariant_reads
        for name, state in self._running.items():
            machine = self._machines[name]
            assert machine is not None
            reads |= machine.reads(state)
        if self._settling or self._final is not None:
            reads |= frozenset({"*"})
        return reads

    # -- run to completion ----------------------------------------------------------------------------------------

    def _complete(self, trigger: Trigger | None) -> None:
        """Take what is enabled until nothing is (SCXML: mainEventLoop)."""
        seen: set[Any] = set()
        for _ in range(MOST_MICROSTEPS):
            if self.outcome is not None or self.mode not in ("running", "canceling"):
                return
            if self._final is not None:
                self._settle_final()
                self._check_invariants()
                return
            if trigger is not None:
                self._answer(trigger)
                trigger = None
                continue
            if self._config.holds or self._always_held:
                self._hold()
            if self._config.eventless and (rows := self._select(self._config.eventless)):
                circle = (self._config.key, tuple(row.place for row in rows), len(self.written), len(self._internal))
                if circle in seen:
                    return self._circle()
                seen.add(circle)
                self._take(rows, "")
            elif self._internal:
                trigger = self._internal.popleft()
            elif self._starting:
                self._begin_starting()
            elif not (self.written and self._poll()):
                break
        else:
            return self._circle()
        self._settle_nested()
        if self._internal:
            return self._complete(None)
        self._check_invariants()

    def _circle(self) -> None:
        states = " → ".join(dict.fromkeys(name for move in self.moves[-50:] for name in move.entered))
        self._end("failed", f"a cycle without end: {states or 'internal events'}")

    def _answer(self, trigger: Trigger) -> None:
        """Find the rows that a trigger fires, and take them."""
        view, source = self.view, trigger.source
        if trigger.name == "round" and source is not None:
            return self._next_round(source)
        view.event, option = trigger.data, False
        if trigger.row is not None:
            plan: tuple[tuple[Row, ...], ...] = ((trigger.row,),)
        elif source is None:
            declared = trigger.name in self._declared
            found = self._config.plans.get(trigger.name)
            plan = found if found is not None else self._config.plan(trigger.name, declared=declared)
        else:
            option = trigger.name in (source.state.options if source.family == "decision" else ())  # type: ignore[union-attr]
            view.answer = trigger.data if option else view.answer
            plan = self._config.outcome_plan(source, trigger.name, option=option, climbs=trigger.climbs and trigger.name != "succeeded")
        rows = self._select(plan)
        if rows:
            self._take(rows, trigger.name)
        elif source is not None:
            self._unanswered(trigger, source)
        elif trigger.name in BUILT_IN_EVENTS or self.moves:
            self.notes.append(f"no row took '{trigger.name}'") if trigger.row is None else None

    def _unanswered(self, trigger: Trigger, source: Node) -> None:
        """An outcome that no row handles: unless it is a success, it is the mission's failure."""
        if trigger.name == "succeeded":
            if source.activity:
                self.notes.append(f"no row took 'succeeded' of '{source.name}'")
        elif trigger.climbs:
            why = f"{source.name}: {trigger.name}" + (f" ({trigger.why})" if trigger.why else "")
            self._end("failed", why)

    def _select(self, plan: tuple[tuple[Row, ...], ...]) -> list[Row]:
        """The first row of each chain whose guard is true (SCXML: selectTransitions)."""
        view, rows = self.view, list[Row]()
        for chain in plan:
            for row in chain:
                if row.test is not None:
                    value = row.test(view)
                    self.looked.append((row.place, value))
                    if value is not True:
                        continue
                if row not in rows:
                    rows.append(row)
                break
        return rows

    def _take(self, rows: list[Row], trigger: str) -> None:
        self._jump(self._graph.leap(self._config, tuple(rows), self._memory, trigger))

    def _jump(self, leap: Leap) -> None:
        """Make one microstep."""
        for node in leap.exited:
            self._exit(node)
        self._memory.update(leap.remember)
        self._config = leap.config
        self.view.active = leap.config.active
        self.moves.append(leap.move)
        for act in leap.acts:
            act(self)
        for node in leap.entered:
            self._enter(node)

    def _exit(self, node: Node) -> None:
        if node.timed:
            self._timers.pop(("timeout", node.name), None)
            for row in node.rows:
                self._timers.pop(("after", row.place), None)
        if node.name in self._running:
            self._leave_activity(node)
        self._pending.pop(node.name, None)
        self._settling.pop(node.name, None)
        self._rounds.pop(node.name, None)
        if node.clocked:
            self.view.entered.pop(node.name, None)
        if self.view.held:
            for row in node.rows:
                for memory in row.condition.holds if row.condition else ():
                    self.view.held.pop(memory, None)
        if node in self._starting:
            self._starting.remove(node)

    def _enter(self, node: Node) -> None:
        if node.clocked:
            self.view.entered[node.name] = self.view.at
        if node.timed:
            self._after_rows(node)
        if (node.activity or node.control) and node in self._config.atomic:
            self._starting.append(node)
        if node.is_each and node in self._config.atomic:
            self._next_round(node)

    def _after_rows(self, node: Node) -> None:
        if node.state is not None and node.state.timeout_s is not None:
            self._set_timer(("timeout", node.name), node.state.timeout_s, f"{node.state.timeout_s:g}")
        for row in node.rows:
            if row.transition.after_s is not None:
                self._set_timer(("after", row.place), row.transition.after_s, "after_s")

    def _set_timer(self, key: tuple[str, Any], after_s: float, name: str, data: Mapping[str, Any] | None = None) -> None:
        self._order += 1
        self._timers[key] = Timer(self.view.at + after_s, self._order, name, data or {})

    def _hold(self) -> None:
        """Remember since when the guards inside `held` have been true."""
        for memory, test in (*self._config.holds.items(), *self._always_held.items()):
            true = test(self.view) is True
            if true is not (memory in self.view.held):
                self._touched = True
                if true:
                    self.view.held[memory] = self.view.at
                else:
                    del self.view.held[memory]

    # -- what acts do (Stage) -------------------------------------------------------------------------------------

    def raise_event(self, name: str, data: Mapping[str, Any]) -> None:
        self._internal.append(Trigger(name, data))

    def raise_later(self, name: str, data: Mapping[str, Any], after_s: float, timer: str | None) -> None:
        self._set_timer(("raise", timer if timer is not None else self._order + 1), after_s, name, data)

    def drop(self, timer: str) -> None:
        self._timers.pop(("raise", timer), None)

    def next_call(self, service: str) -> int:
        self._number += 1
        self._calls[self._number] = service
        return self._number

    def enter_each(self, node: Node) -> None:
        """Copy the list of an `each`; its first item is current from here on."""
        assert isinstance(node.state, Each)
        entry = self.view.board.get(node.state.each.split(".")[0])
        value: Any = entry.value if entry is not None else None
        for field in node.state.each.split(".")[1:]:
            value = value.get(field) if isinstance(value, Mapping) else None
        self._rounds[node.name] = (tuple(value) if isinstance(value, list | tuple) else (), 0)
        if not isinstance(value, list | tuple):
            self._internal.append(self._outcome_of(node, Outcome("failed", why=f"the list {node.state.each} is unknown")))
        elif value:
            self.write_key(node.state.item, value[0])

    def _next_round(self, node: Node) -> None:
        items, index = self._rounds[node.name]
        if index < len(items):
            assert isinstance(node.state, Each)
            self.write_key(node.state.item, items[index])
            self._jump(self._graph.reenter(self._config, node, self._memory))
        elif not any(trigger.source is node for trigger in self._internal):
            self._internal.append(self._outcome_of(node, Outcome("succeeded")))

    def reach_final(self, node: Node, complete: tuple[Node, ...]) -> None:
        """A final was entered: at the top it ends the mission, else its parent, and parallel states with it."""
        parent = node.parent
        assert parent is not None and isinstance(node.state, Final)
        if parent.state is None:
            self._final = node
            return
        if parent.is_parallel:
            self._complete_parallels(complete)
            return
        if node.requires is not None and node.requires.test(self.view) is not True:
            self._settling[node.name] = self.view.at + self.mission.settle_s
            if self.mission.settle_s > 0:
                return
            del self._settling[node.name]
            self._finish(parent, "unverified", complete, why=self._falls_short(node.requires))
            return
        self._finish(parent, node.state.final, complete)

    def _finish(self, parent: Node, outcome: str, complete: tuple[Node, ...], why: str = "") -> None:
        if parent.is_each and outcome == "succeeded" and parent.name in self._rounds:
            items, index = self._rounds[parent.name]
            self._rounds[parent.name] = (items, index + 1)
            if index + 1 < len(items):
                self._internal.append(Trigger("round", {}, parent))
                return
        in_region = parent.parent is not None and parent.parent.is_parallel
        trigger = self._outcome_of(parent, Outcome(outcome, why=why))
        self._internal.append(trigger._replace(climbs=not in_region))
        self._complete_parallels(complete)

    def _complete_parallels(self, complete: tuple[Node, ...]) -> None:
        """Parallel states whose regions have all ended report the worst of their outcomes, the inner first."""
        for parallel in complete:
            outer = parallel.parent is not None and parallel.parent.is_parallel
            done = self._outcome_of(parallel, Outcome(self._worst(parallel)))
            self._internal.append(done._replace(climbs=not outer))

    def _worst(self, parallel: Node) -> str:
        """The outcome of a parallel state whose regions have all ended."""
        found = []
        for region in parallel.children:
            if region.is_parallel:
                found.append(self._worst(region))
            if isinstance(region.state, Final):
                found.append(region.state.final)
            for child in region.children:
                if child.is_final and child in self._config.nodes and isinstance(child.state, Final):
                    found.append(child.state.final)
        return worst(found)

    @staticmethod
    def _outcome_of(node: Node, outcome: Outcome) -> Trigger:
        return Trigger(outcome.name, outcome.data, node, why=outcome.why)

    # -- activities -----------------------------------------------------------------------------------------------

    def _machine(self, node: Node) -> Machine | None:
        if node.name not in self._machines:
            assert node.state is not None
            self._machines[node.name] = machine_of(
                node.state, node.name, node.place, keys=self.mission.blackboard, terms=self.terms, trees=self._ticker
            )
        return self._machines[node.name]

    def _begin_starting(self) -> None:
        """Start the activities of the states that are still active; first those whose control is where it belongs."""
        nodes, self._starting = sorted(self._starting, key=lambda node: node.index), []
        for node in nodes:
            if node not in self._config.nodes:
                continue
            if node.control is not None and node.control != self.holder:
                self._request_control(node)
            else:
                self._begin(node)

    def _request_control(self, node: Node, until: float | None = None) -> None:
        assert node.state is not None and node.control is not None
        request = Handover(node.control)
        if request not in self.effects:
            self.effects.append(request)
        self._pending[node.name] = self.view.at + node.state.handover_s if until is None else until

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
        node = self._graph.nodes[name]
        self._timers.pop(("timeout", name), None)
        if turn.outcome.why and node.family != "decision":
            self.notes.append(f"{name} {turn.outcome.name}: {turn.outcome.why}")
        self._internal.append(self._outcome_of(node, turn.outcome))

    def _emit(self, effects: tuple[Any, ...]) -> None:
        for effect in effects:
            if isinstance(effect, CancelGoal):
                self.effects += self._ledger.cancel(effect.number, self.view.at)
            else:
                self.effects.append(effect)

    def _leave_activity(self, node: Node) -> None:
        state = self._running.pop(node.name, None)
        machine = self._machines.get(node.name)
        if state is not None and machine is not None:
            turn = machine.leave(state, self)
            self._emit(turn.effects)
            self.notes += turn.notes

    def _poll(self) -> bool:
        """Let the machines look at the time and the keys; whether one had something to say."""
        if self.outcome is not None or self.mode == "paused":
            return False
        said, tick = False, Event("tick", self.view.at, kind="tick")
        for name in list(self._running):
            machine = self._machines[name]
            assert machine is not None
            if name in self._running and (turn := machine.hear(self._running[name], tick, self)) is not None:
                self._turn(name, turn)
                said = True
        return said

    # -- the desk (states/activity.py) ----------------------------------------------------------------------------

    def next_number(self) -> int:
        self._number += 1
        return self._number

    def open_goal(self, owner: str, action: str, cancel_s: float) -> int:
        self._number += 1
        self._ledger.open(self._number, owner, action, cancel_s)
        return self._number

    def close_goal(self, number: int) -> None:
        self._ledger.finish(number)

    def obstruction(self, action: str) -> str:
        return self._ledger.obstruction(action)

    def write_key(self, key: str, value: Any) -> None:
        self.view.board[key] = Stamped(value, self.view.at)
        self.written.append((key, value))

    def ask_named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate, noted so that a replay can repeat it."""
        predicate = self._named.get(name)
        if predicate is None:
            return None
        try:
            value = predicate({key: entry.value for key, entry in self.view.board.items()}, **arguments)
        except Exception as error:
            self.notes.append(f"guard '{name}' raised {type(error).__name__}: {error}")
            value = None
        value = value if isinstance(value, bool) else None
        self.looked.append((f"named:{name}", value))
        return value

    # -- control, pause, cancel, kill -----------------------------------------------------------------------------

    def _control(self, event: Event) -> None:
        """Control is with somebody else now: what waited for it starts, what needs another stops."""
        self.holder = event.name
        self.notes.append(f"control: {event.name}")
        if self.mode == "paused":
            return
        for name in list(self._running):
            node = self._graph.nodes[name]
            if node.control is not None and node.control != self.holder:
                self._leave_activity(node)
                self._pending[name] = math.inf
        for name in sorted(self._pending, key=lambda each: self._graph.nodes[each].index):
            if self._graph.nodes[name].control == self.holder:
                del self._pending[name]
                self._begin(self._graph.nodes[name])
        self._complete(None)

    def _command(self, event: Event) -> None:
        by = str(event.data.get("by", "")) or "command"
        if self.outcome is not None:
            self._refused = "the mission has ended"
        elif event.name == "kill":
            self._kill(f"killed by {by}")
        elif event.name == "cancel":
            self._cancel(by)
        elif event.name == "pause":
            self._pause()
        elif event.name == "resume":
            self._resume()
        else:
            self._refused = f"no command '{event.name}'{suggestion(event.name, ('pause', 'resume', 'cancel', 'kill'))}"

    def _kill(self, why: str) -> None:
        self.effects += self._ledger.stop_all()
        self.holder = "nobody"
        self._end("aborted", why)

    def _cancel(self, by: str) -> None:
        if self.mode == "canceling":
            self._refused = "it is being canceled already"
            return
        if self.mode == "paused":
            self._shift(self.view.at - self._paused_at)
            self._queue = self._suspended = ()
        self.mode, self.why = "canceling", f"canceled by {by}"
        self._cancel_by = self.view.at + self.mission.cancel_s
        if self.mission.on_cancel is None:
            self._end("canceled", self.why)
            return
        entered: set[Node] = set()
        target = self._graph.nodes[self.mission.on_cancel]
        self._graph._descend(target, entered, self._memory)
        self._graph._climb(target, self._graph.root, entered, self._memory)
        exited = {node for node in self._config.nodes if node.state is not None}
        self._final = None
        self._jump(self._graph.move(self._config, exited, entered, taken=(), acts=(), trigger="cancel"))
        self._complete(None)

    def _pause(self) -> None:
        if self.mode != "running":
            self._refused = f"only a running mission can be paused; it is {self.mode}"
            return
        self.mode, self._paused_at = "paused", self.view.at
        suspended = []
        for name in list(self._running):
            node = self._graph.nodes[name]
            action = getattr(node.state, "action", None)
            if node.family in ("action", "tree") and action not in self.terms.keep:
                self._leave_activity(node)
                suspended.append(name)
        self._suspended = tuple(suspended)
        self.notes.append("paused")

    def _resume(self) -> None:
        if self.mode != "paused":
            self._refused = f"only a paused mission can be resumed; it is {self.mode}"
            return
        self._shift(self.view.at - self._paused_at)
        self.mode = "running"
        self.notes.append("resumed")
        self._starting += [self._graph.nodes[name] for name in self._suspended]
        for name in [name for name in self._pending if self._graph.nodes[name].control == self.holder]:
            del self._pending[name]
            self._starting.append(self._graph.nodes[name])
        queue, self._queue, self._suspended = self._queue, (), ()
        self._complete(None)
        for event in queue:
            if self.outcome is None:
                self._happen(event)

    def _shift(self, by_s: float) -> None:
        """Give every timer the time it had left when the mission was paused."""
        self._timers = {key: timer._replace(due=timer.due + by_s) for key, timer in self._timers.items()}
        self.view.entered = {name: at + by_s for name, at in self.view.entered.items()}
        self.view.held = {memory: at + by_s for memory, at in self.view.held.items()}
        self._pending = {name: until + by_s for name, until in self._pending.items()}
        self._settling = {name: until + by_s for name, until in self._settling.items()}
        for name, state in self._running.items():
            machine = self._machines[name]
            assert machine is not None
            self._running[name] = machine.shifted(state, by_s)

    # -- the end --------------------------------------------------------------------------------------------------

    def _settle_final(self) -> None:
        """A top-level final is reached: it counts once its `requires` is true, and not at all if that takes too long."""
        node = self._final
        assert node is not None and isinstance(node.state, Final)
        requires = node.requires
        if requires is None:
            return self._end(node.state.final, f"'{node.name}' was reached")
        value = requires.test(self.view)
        self.looked.append((requires.place, value))
        until = self._settling.setdefault(node.name, self.view.at + self.mission.settle_s)
        if value is True:
            self._end(node.state.final, f"'{node.name}' was reached, and {requires.guard.words()}")
        elif self.view.at >= until:
            self._end("failed", f"'{node.name}' was reached, but {self._falls_short(requires)}")

    def _settle_nested(self) -> None:
        """Finals inside other states whose `requires` was not true when they were entered."""
        for name, until in list(self._settling.items()):
            node = self._graph.nodes[name]
            assert node.parent is not None and node.requires is not None and isinstance(node.state, Final)
            complete = tuple(self._graph._complete(node.parent.parent, self._config.nodes))
            if node.requires.test(self.view) is True:
                del self._settling[name]
                self._finish(node.parent, node.state.final, complete)
            elif self.view.at >= until:
                del self._settling[name]
                self._finish(node.parent, "unverified", complete, why=self._falls_short(node.requires))

    def _falls_short(self, condition: Condition) -> str:
        value = condition.test(self.view)
        unknown = [self._age(key) for key in sorted(condition.reads) if self._age(key)]
        said = "false" if value is False else "unknown"
        return f"'{condition.guard.words()}' is {said}" + (f" ({', '.join(unknown)})" if unknown and value is None else "")

    def _age(self, key: str) -> str:
        entry, written = self.view.board.get(key), self.mission.blackboard.get(key)
        if entry is None:
            return f"{key} was never heard"
        stale = written is not None and written.max_age_s is not None and self.view.at >= entry.at + written.max_age_s
        return f"{key} is {self.view.at - entry.at:.1f} s old" if stale else ""

    def _check_invariants(self) -> None:
        if self.outcome is not None or not self._invariants:
            return
        unknown = set()
        for name, condition in self._invariants:
            value = condition.test(self.view)
            if value is False:
                self.looked.append((condition.place, value))
                return self._kill(f"invariant '{name}' is false: {condition.guard.words()}")
            if value is None:
                unknown.add(name)
        for name in sorted(unknown - self._unknown):
            self.notes.append(f"invariant '{name}' is unknown")
        self._touched = self._touched or self._unknown != unknown
        self._unknown = frozenset(unknown)

    def _end(self, outcome: str, why: str) -> None:
        """The mission is over: everything that runs is ended."""
        if self.outcome is not None:
            return
        if self.mode == "canceling":
            outcome, why = ("canceled", self.why if outcome != "aborted" else f"{self.why}; {why}")
        self.outcome, self.why = outcome, why
        for name in list(self._running):
            self._leave_activity(self._graph.nodes[name])
        if self._final is not None:
            for act in self._final.exit:
                act(self)
        for goal in list(self._ledger.goals.values()):
            self.effects += self._ledger.cancel(goal.number, self.view.at)
        self._timers.clear()
        self._pending.clear()
        self._settling.clear()
        self._internal.clear()
        self._starting = []
        self.mode = "ended"

    # -- time -----------------------------------------------------------------------------------------------------

    def _next_instant(self) -> float:
        """The earliest instant at which time alone can change something."""
        now, soonest = self.view.at, self._ledger.wake_at()
        if self.mode == "ended" or self.mode == "ready":
            return soonest if self.mode == "ended" else math.inf
        for _, condition in self._invariants:
            for instant in condition.instants:
                soonest = min(soonest, _later(instant(self.view), now))
        if self.mode == "paused":
            return soonest
        soonest = min(soonest, self._cancel_by)
        for timer in self._timers.values():
            soonest = min(soonest, timer.due)
        for until in (*self._pending.values(), *self._settling.values()):
            soonest = min(soonest, until)
        for instant in self._config.instants:
            soonest = min(soonest, _later(instant(self.view), now))
        if self._final is not None and self._final.requires is not None:
            for instant in self._final.requires.instants:
                soonest = min(soonest, _later(instant(self.view), now))
        for name, state in self._running.items():
            machine = self._machines[name]
            assert machine is not None
            soonest = min(soonest, machine.wake_at(state, self.view))
        return soonest


def _later(instant: float, now: float) -> float:
    return instant if instant > now else math.inf
