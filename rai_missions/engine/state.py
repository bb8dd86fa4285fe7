# SPDX-License-Identifier: Apache-2.0
"""What a chart remembers, and the small things that every part of it does.

Rule: nothing here decides; the layers above do, each on top of the one below.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.actions import Act, act_of
from rai_missions.engine.activities.activity import Machine, Outcome
from rai_missions.engine.activities.goal_ledger import Ledger
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.configuration import CompiledStep, Configuration
from rai_missions.engine.nodes import CompiledTransition, Node
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import CancelGoal, Cause, Move
from rai_missions.engine.transitions import Graph
from rai_missions.errors import UsageError, in_words
from rai_missions.event import Event
from rai_missions.guards.guard import Truth
from rai_missions.keys import Blackboard, Stamped, fits, stale_at
from rai_missions.mission.mission import Mission
from rai_missions.states.effects import Set

__all__ = ("Core", "GuardView", "Named", "Timer", "TimerKey", "Trigger")

Named = Mapping[str, Callable[..., Truth]]
"""Predicates of the user's program by name; each gets the blackboard's fresh values and the guard's `with`."""


TimerKey = tuple[str, Any]
"""`after` and a row's place, `timeout` and a state, or `raise` and the timer's id."""
NOTHING: Mapping[str, Any] = {}


class Trigger(NamedTuple):
    """What a microstep answers to: an event, or an outcome of a state."""

    name: str
    data: Mapping[str, Any]
    source: Node | None = None
    """The state whose outcome it is; None for an event."""
    climbs: bool = True
    why: str = ""
    row: CompiledTransition | None = None
    """The one row that it may fire: that of an `after_s`."""


class Timer(NamedTuple):
    """Something that comes later."""

    due: float
    order: int
    name: str
    data: Mapping[str, Any] = {}
    control: str = ""
    """Who must have control for the state that set it; its time stands still while that state is held."""


class GuardView:
    """What guards see of a chart."""

    __slots__ = ("_chart", "active", "answer", "at", "board", "entered", "event", "held")

    def __init__(self, chart: Core) -> None:
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


class Core:
    """The state of one run of a mission.

    Args and errors: as `Chart` says.
    """

    def __init__(
        self,
        mission: Mission,
        ticker: Trees | None = None,
        *,
        terms: RobotFacts | None = None,
        named: Named | None = None,
    ) -> None:
        self.mission = mission
        self.terms = terms if terms is not None else RobotFacts()
        self.view = GuardView(self)
        self._named = dict(named or {})
        self._ticker = ticker
        self._has_trees = any(state.word == "tree" for _, _, state in mission.walk())
        self._graph = Graph(mission, self._act)
        if absent := sorted(self._graph.named - self._named.keys()):
            raise UsageError(f"the mission names predicates that were not given: {', '.join(absent)}; give named={{…}}")
        self._declared = frozenset(mission.events)
        self._machines: dict[str, Machine | None] = {}
        self._invariants = tuple(self._graph.invariants.items())
        self._always_held = {memory: test for _, each in self._invariants for memory, test in each.holds.items()}
        self._reset()
        for name, key in mission.blackboard.items():
            if key.initial is not None:
                self.view.board[name] = Stamped(key.initial, 0.0)
        if ticker is None and self._has_trees:
            raise UsageError("the mission runs a tree; give the chart a ticker: Chart(mission, ticker=PyTrees())")

    def _reset(self) -> None:
        self.seq = 0
        """Steps so far."""
        self.mode = "ready"
        """`ready`, `running`, `paused`, `canceling` or `ended`."""
        self.holder = "autonomy"
        """Who holds control: `autonomy`, `agent`, `operator` or `nobody`."""
        self.taken = False
        """The operator holds it and has taken it, rather than been given it by the mission."""
        self._asked = ""
        """For whom the mission has asked for control that has not come yet."""
        self._frozen: dict[str, float] = {}
        """Whose control held states need → since when their time stands still."""
        self._held_since = 0.0
        self._laid_by: tuple[str, ...] = ()
        """States whose activity starts when the operator has given control back."""
        self._kept: tuple[Event, ...] = ()
        """What came meanwhile for held states, in order."""
        self.outcome: str | None = None
        self.why = ""
        self.cause: Cause = ""
        """What has ended the mission, where no rule of it did."""
        self.false_invariant = ""
        """The name of the invariant that has ended the mission; empty for any other end."""
        self.quiet = False
        """The last step did nothing but write the blackboard: it need not be written down by itself."""
        self._config: Configuration = self._graph.empty
        self._memory: dict[int, tuple[Node, ...]] = {}
        self._timers: dict[TimerKey, Timer] = {}
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
        self._unbegun: tuple[tuple[str, bool], ...] = ()
        """States that a migration has brought, and whether they are new: they begin when the run is taken up."""
        self._unknown: frozenset[str] = frozenset()
        self._cancel_by = math.inf
        self._final: Node | None = None
        self._present = 0.0
        """Until here the run catches up: a resumed process carries nothing out before."""
        self._wake = math.inf
        self._due: frozenset[str] = frozenset()
        """The states whose machines asked to be woken at this instant."""
        self._quick = False
        self._listening: frozenset[str] = frozenset()
        self._outdated: set[str] = set()
        """Before the start: the robot's keys of which nothing was fresh as it came."""
        self._clear()

    def _clear(self) -> None:
        """What one step gathers."""
        self.moves: list[Move] = []
        self.looked: list[tuple[str, Truth]] = []
        self.written: list[tuple[str, Any]] = []
        self._polled = 0
        """How many of these the machines have been told of."""
        self._shifted: set[str] = set()
        """The states that have become active or inactive since the machines were told, by their `presence`."""
        self._news: dict[str, str] = {}
        """Key that was given another value since the machines last looked → the state whose machine wrote it last, and
        has looked at it since; empty for a transition, or the robot."""
        self._tree_rounds: dict[str, Rounds] = {}
        """State → what its tree has done since the event, or the instant, in hand."""
        self.effects: list[Any] = []
        self.notes: list[str] = []
        self._internal: deque[Trigger] = deque()
        self._starting: list[Node] = []
        self._given_up: set[str | None] = set()
        """Who was to be given control for something that was left before it came."""
        self._refused = ""
        self._ended = False
        """The mission has ended in this step."""
        self._touched = False
        """Something that the run remembers has changed, beside the blackboard."""

    def _act(self, effect: Any, place: str, state: str) -> Act:
        act = act_of(effect, place, state, self.mission.blackboard)
        if not self._has_trees or not isinstance(effect, Set):
            return act
        key = effect.set

        def noted(chart: Core) -> None:
            before = chart.known(key)
            act(chart)
            chart.note_news(key, before)

        return noted

    def _enabled(
        self, plan: tuple[tuple[CompiledTransition, ...], ...], looked: list[tuple[str, Truth]]
    ) -> list[CompiledTransition]:
        """The first row of each chain whose guard is true (SCXML: selectTransitions)."""
        view = self.view
        rows: list[CompiledTransition] = []
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
        return rows

    # -- what acts do (acts.Stage) --------------------------------------------------------------------------------

    def raise_event(self, name: str, data: Mapping[str, Any]) -> None:
        self._internal.append(Trigger(name, data))

    def raise_later(
        self, name: str, data: Mapping[str, Any], after_s: float, timer: str | None, state: str = ""
    ) -> None:
        key = ("raise", timer if timer is not None else self._order + 1)
        self._set_timer(key, after_s, name, data, self._graph.nodes[state].control if state else None)

    def drop(self, timer: str) -> None:
        self._timers.pop(("raise", timer), None)

    def next_call(self, service: str) -> int:
        self._number += 1
        self._calls[self._number] = service
        return self._number

    @property
    def begins_at(self) -> float:
        """When what is asked for now is carried out, and all that the robot reports is received.

        Now, or once a resumed run has caught up.
        """
        return self.view.at + self.late_s

    @property
    def late_s(self) -> float:
        """How far a resumed run has yet to catch up, in seconds."""
        return max(0.0, self._present - self.view.at)

    def _set_timer(
        self, key: tuple[str, Any], after_s: float, name: str, data: Mapping[str, Any] | None, control: str | None
    ) -> None:
        self._order += 1
        now = self.view.at if not self._frozen else self._now_of(control)
        self._timers[key] = Timer(now + after_s, self._order, name, data or {}, control or "")

    # -- the desk of the machines (states/activity.py) ------------------------------------------------------------

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

    def known(self, key: str) -> Any:
        """The value of a key; None where it is missing or stale."""
        entry = self.view.board.get(key)
        if entry is None or self.view.at >= stale_at(self.mission.blackboard.get(key), entry):
            return None
        return entry.value

    def note_news(self, key: str, before: Any, by: str = "") -> bool:
        """Whether a key that was written has another value than before; if so, trees that look at it are ticked."""
        value = self.known(key)
        if value is before or (before is not None and value == before):
            return False
        self._news[key] = by
        return True

    def rounds(self, owner: str, loops: int) -> Rounds:
        """What the tree of a state has done in the step in hand."""
        if owner not in self._tree_rounds:
            self._tree_rounds[owner] = Rounds(loops)
        return self._tree_rounds[owner]

    def write_key(self, key: str, value: Any, by: str = "") -> bool:
        """Write a key of the mission; a value of another type is refused, and a note says so.

        Rule: whatever comes from outside the mission's own text is written here or by `Chart._write`.
        """
        why = (
            fits(self.mission.blackboard[key], value)
            if key in self.mission.blackboard
            else "the mission has no such key"
        )
        if why:
            self.notes.append(f"'{key}' was not written: {why}")
            return False
        before = self.known(key) if self._has_trees else None
        self.view.board[key] = Stamped(value, self.view.at)
        self.written.append((key, value))
        return self._has_trees and self.note_news(key, before, by)

    def ask_named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate, noted so that a replay can repeat it."""
        predicate = self._named.get(name)
        if predicate is None:
            return None
        keys, now = self.mission.blackboard, self.view.at
        known = {key: entry.value for key, entry in self.view.board.items() if now < stale_at(keys.get(key), entry)}
        try:
            value = predicate(known, **arguments)
        except Exception as error:  # noqa: BLE001 - the user's code; what it raises makes the guard unknown
            self.notes.append(f"guard '{name}' raised {type(error).__name__}: {in_words(error)}")
            value = None
        value = value if isinstance(value, bool) else None
        self.looked.append((f"named:{name}", value))
        return value

    def _emit(self, effects: tuple[Any, ...]) -> None:
        for effect in effects:
            if isinstance(effect, CancelGoal):
                self.effects += self._ledger.cancel(effect.number, self.begins_at)
            else:
                self.effects.append(effect)

    @staticmethod
    def _outcome_of(node: Node, outcome: Outcome) -> Trigger:
        return Trigger(outcome.name, outcome.data, node, why=outcome.why)

    # -- what the layers above do ---------------------------------------------------------------------------------

    def _now_of(self, control: str | None) -> float:
        """Now, as the states that need this control count time."""
        raise NotImplementedError

    def _complete(self, trigger: Trigger | None) -> None:
        """Take what is enabled until nothing is."""
        raise NotImplementedError

    def _heard(self, trigger: Trigger) -> None:
        """A macrostep of its own."""
        raise NotImplementedError

    def _jump(self, leap: CompiledStep) -> None:
        """Make one microstep."""
        raise NotImplementedError

    def _end(self, outcome: str, why: str, *, killed: bool = False, cause: Cause = "") -> None:
        """The mission is over."""
        raise NotImplementedError
