# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: RUF009 - `slot` makes a field
"""All that one run remembers, in one object, and all that one step gathers, in another.

Rule: the fields of `RunState` are the only list of what a run remembers. Copies, snapshots, migrations, the time that
stops in a pause, and what a proof compares follow from `TABLE`, field by field, by the kind of each.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, fields
from operator import attrgetter, itemgetter
from typing import Any, Literal, NamedTuple, get_args

from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.states import CompiledState, CompiledTransition
from rai_missions.engine.decision import VerdictNote
from rai_missions.engine.modes import Mode, RunMode, mode_of
from rai_missions.engine.step import Cause, Move, Refusal
from rai_missions.event import Event
from rai_missions.guards.view import Truth
from rai_missions.keys import Blackboard
from rai_missions.states.control import Holder
from rai_missions.states.final import FinalOutcome

__all__ = (
    "FIELD_KINDS",
    "TABLE",
    "FieldKind",
    "RunState",
    "StateField",
    "StepDraft",
    "Timer",
    "TimerKey",
    "Trigger",
    "copied",
    "refuse",
)  # fmt: skip

TimerKey = tuple[str, Any]
"""`after` and a transition's place, `timeout` and a state, or `raise` and the timer's id."""

FieldKind = Literal[
    "value",
    "number",
    "past",
    "end",
    "passing",
    "payload",
    "controls",
    "configuration",
    "memory",
    "state",
    "states",
    "begins",
    "invariants",
    "events",
    "deadline",
    "deadlines",
    "settling",
    "timers",
    "activities",
    "rounds",
    "lists",
    "calls",
    "goals",
    "board",
    "ages",
    "since",
]
"""What a field holds, which decides how it is stored, moved in time, migrated and compared:

| kind            |                                                                          |
|-----------------|--------------------------------------------------------------------------|
| `value`         | a value that decides what can happen next, under no name of the mission  |
| `number`        | a count by which things of one run differ, and nothing else               |
| `past`          | an instant that is over                                                  |
| `end`           | how the run ended                                                        |
| `passing`       | what follows from the rest, or is of the process that runs the mission    |
| `payload`       | what an event or answer brought along                                    |
| `controls`      | holder of control → since when the time of the states that need it is stopped |
| `configuration` | the active states                                                        |
| `memory`        | history state → the states it leads back to                              |
| `state`         | one state, or None                                                       |
| `states`        | states whose activity is to start again                                  |
| `begins`        | states that a migration has brought, and whether they are new            |
| `invariants`    | names of invariants                                                      |
| `events`        | events that wait                                                         |
| `deadline`      | an instant to come; infinity for none                                    |
| `deadlines`     | state → the instant until which its activity waits for control           |
| `settling`      | final → until when its `requires` may become true; infinity: it has not   |
| `timers`        | what comes later                                                         |
| `activities`    | state → the state of its activity                                        |
| `rounds`        | state → items, and which of them is current                              |
| `lists`         | history state and `each` → the same of a list that it leads back into     |
| `calls`         | number → service, for effects whose reply no activity waits for          |
| `goals`         | number → goal                                                            |
| `board`         | the blackboard                                                           |
| `ages`          | state → when it was entered                                              |
| `since`         | guard inside `held` → since when it has been true                        |

A new one has an entry in each table by which it is not left as it is: `snapshot.FORMS`, `stopped_time.SHIFTS`,
`carries` in `replay.migrate.activities`, and in `prove` `rests` and one of `INDIFFERENT`, `AS_IT_IS` and
`keys_by_kind`.
"""
FIELD_KINDS: tuple[FieldKind, ...] = get_args(FieldKind)


def unanswered(state: RunState, name: str, arguments: Mapping[str, Any]) -> Truth:
    """What a predicate of the user's program is where none was given: unknown."""
    return None


class Trigger(NamedTuple):
    """What a microstep answers to: an event, or an outcome of a state."""

    name: str
    data: Mapping[str, Any]
    source: CompiledState | None = None
    """The state whose outcome it is; None for an event."""
    climbs: bool = True
    """Whether it is tried on the ancestors of its source."""
    why: str = ""
    transition: CompiledTransition | None = None
    """The one transition that it may fire: that of an `after_s`."""
    is_late: bool = False
    """Its source was left after it reported: only a transition that names the source has use for it."""


class Timer(NamedTuple):
    """Something that comes later."""

    due: float
    order: int
    name: str
    data: Mapping[str, Any] = {}
    control: str = ""
    """Who must have control for the state that set it; its time is stopped while that state is held."""


@dataclass(slots=True, eq=False)
class StepDraft:
    """What one step gathers; the next begins with an empty one."""

    # -- what its value has
    moves: list[Move] = field(default_factory=list)
    looked: list[tuple[str, Truth]] = field(default_factory=list)
    written: list[tuple[str, Any]] = field(default_factory=list)
    effects: list[Any] = field(default_factory=list)
    notes: list[str | VerdictNote] = field(default_factory=list)
    refusal: Refusal = ""
    refused: str = ""
    """The refusal in words."""
    is_kept: bool = False
    """Something waits since this step."""
    # -- what the activities have yet to look at
    polled: int = 0
    """How many of the keys that were written they have looked at."""
    presence_changes: set[str] = field(default_factory=set)
    """The states that have become active or inactive since, by their `presence`."""
    news: dict[str, str] = field(default_factory=dict)
    """Key that was given another value since → the state whose activity wrote it last, and has looked at it since;
    empty for a transition, or the robot."""
    goal_ended: bool = False
    """A goal has ended or was given up since."""
    due: frozenset[str] = frozenset()
    """The states whose activities asked to be woken at this instant."""
    unseen: frozenset[str] = frozenset()
    """The states in `due` that may have missed a change: while they were paused, or held, or not here."""
    watched_by_activities: AbstractSet[str] | None = None
    """What the activities watch, or more; None once one of them has had its turn."""
    # -- what has yet to happen
    internal: deque[Trigger] = field(default_factory=deque)
    starting: list[CompiledState] = field(default_factory=list)
    given_up: set[str | None] = field(default_factory=set)
    """Who was to be given control for something that was left before it came."""
    # -- how far it has come
    touched: bool = False
    """Something that the run remembers has changed, other than the blackboard."""
    ended: bool = False
    """The mission has ended in this step."""
    tree_rounds: dict[str, Rounds] = field(default_factory=dict)
    """State → what its tree has done since the event, or the instant, in hand."""
    macrosteps: int = 0
    """How many times transitions were taken until none was enabled."""
    microsteps: int = 0
    """How many microsteps the macrostep in hand has made."""
    in_rounds: int = 0
    """How many of them belong to rounds of lists that others followed: a list has an end, and is no cycle."""
    round_bounds: dict[str, float] = field(default_factory=dict)
    """`each` → the microsteps, but for `in_rounds`, at which its rounds began; infinite once it was left."""


def slot(default: Any, kind: FieldKind = "value", word: str = "") -> Any:
    """A field that a run remembers.

    Args:
        default: What it is before the start; for a type, a new value of it.
        kind: What it holds.
        word: What it is called in a snapshot, where that is not its name.
    """
    metadata = {"kind": kind, "word": word}
    if isinstance(default, type):
        return field(default_factory=default, metadata=metadata)
    return field(default=default, metadata=metadata)


@dataclass(slots=True, eq=False)
class RunState:
    """What one run remembers, and what guards see of it (`guards.view.View`)."""

    # -- what guards see
    at: float = slot(0.0, "past")
    """Now, in seconds on the run's clock."""
    board: Blackboard = slot(dict, "board")
    entered: dict[str, float] = slot(dict, "ages")
    true_since: dict[str, float] = slot(dict, "since", "held")
    event: Mapping[str, Any] = slot(dict, "payload")
    answer: Mapping[str, Any] = slot(dict, "payload")
    # -- the run
    seq: int = slot(0, "number")
    """Steps so far."""
    mode: RunMode = slot("ready")
    outcome: FinalOutcome | None = slot(None, "end")
    why: str = slot("", "end")
    cause: Cause = slot("", "end")
    """What has ended the mission, where no rule of it did."""
    false_invariant: str = slot("", "end")
    """The name of the invariant that has ended the mission; empty for any other end."""
    present: float = slot(0.0, "passing", "_present")
    """Until here the run catches up: a resumed process carries nothing out before."""
    # -- who has control
    holder: Holder | None = slot("autonomy")
    """None: left open until a rule looks (`Surroundings.holder`)."""
    taken: bool = slot(False)
    """The operator holds it and has taken it, rather than been given it by the mission."""
    asked: str = slot("", "value", "_asked")
    """For whom the mission has asked for control that has not come yet."""
    frozen: dict[str, float] = slot(dict, "controls", "_frozen")
    held_since: float = slot(0.0, "past", "_held_since")
    held_starts: tuple[str, ...] = slot((), "states", "_laid_by")
    """States whose activity starts when the operator has given control back."""
    held_events: tuple[Event, ...] = slot((), "events", "_kept")
    """What came meanwhile for held states, in order."""
    # -- what is active, and what runs
    config: Configuration = slot(None, "configuration", "atomic")
    final: CompiledState | None = slot(None, "state")
    """The top-level final that was reached and does not count yet."""
    running: dict[str, Any] = slot(dict, "activities", "_running")
    awaiting_control: dict[str, float] = slot(dict, "deadlines", "_pending")
    """State → until when it waits for control; infinity where it was lost."""
    settling: dict[str, float] = slot(dict, "settling", "_settling")
    unmet: dict[str, float] = slot(dict, "settling", "_unmet")
    """The finals inside other states that count as `unverified`: their `requires` did not become true in time."""
    rounds: dict[str, tuple[tuple[Any, ...], int]] = slot(dict, "rounds", "_rounds")
    timers: dict[TimerKey, Timer] = slot(dict, "timers", "_timers")
    goals: dict[int, Goal] = slot(dict, "goals")
    """All goals whose end is not confirmed."""
    calls: dict[int, str] = slot(dict, "calls", "_calls")
    memory: dict[int, tuple[CompiledState, ...]] = slot(dict, "memory")
    lists: dict[tuple[str, str], tuple[tuple[Any, ...], int]] = slot(dict, "lists")
    order: int = slot(0, "number", "_order")
    """Of the timer that was set last."""
    number: int = slot(0, "number", "_number")
    """Of the start or question that was last."""
    unknown: frozenset[str] = slot(frozenset(), "invariants", "_unknown")
    # -- pause, cancel, migration
    held_back: bool = slot(False, "value", "_held_back")
    """A pause was ordered before the start and has not been taken back: it does not begin by itself."""
    paused_at: float = slot(0.0, "past", "_paused_at")
    paused_events: tuple[Event, ...] = slot((), "events", "_queue")
    """What came meanwhile, in order."""
    paused_starts: tuple[str, ...] = slot((), "states", "_suspended")
    """States whose activity starts again when the run is resumed."""
    cancel_by: float = slot(math.inf, "deadline", "_cancel_by")
    migrated_starts: tuple[tuple[str, bool], ...] = slot((), "begins", "_unbegun")
    """States that a migration has brought, and whether they are new: they begin when the run is resumed."""
    # -- what follows from the rest
    wake: float = slot(math.inf, "passing", "_wake")
    """The earliest instant at which time alone can change something."""
    quick: bool = slot(False, "passing", "_quick")
    """The next event may take the short way."""
    watched: AbstractSet[str] = slot(frozenset(), "passing", "_listening")
    """What may change something now when it changes: keys, and states that an activity asks for."""
    # -- not remembered
    outdated: frozenset[str] = frozenset()
    """Before the start: the robot's keys of which nothing was fresh as it came."""
    quiet: bool = False
    """The last step did nothing but write the blackboard: it need not be written down by itself."""
    draft: StepDraft = field(default_factory=StepDraft)
    """What the step in hand has gathered."""
    ask: Callable[[RunState, str, Mapping[str, Any]], Truth] = unanswered
    """Who answers for the predicates of the user's program."""

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self.config.active

    @property
    def shown_mode(self) -> Mode:
        """The mode as every reader has it."""
        return mode_of(self.mode, self.outcome, held_back=self.held_back)

    @property
    def wake_at(self) -> float | None:
        """The earliest instant at which time alone can change something; None for none."""
        return None if self.wake == math.inf else self.wake

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate of the user's program."""
        return self.ask(self, name, arguments)

    def note(self, text: str) -> None:
        """Note something in the step in hand."""
        self.draft.notes.append(text)


class StateField(NamedTuple):
    """One field of what a run remembers."""

    name: str
    word: str
    """What it is called in a snapshot."""
    kind: FieldKind


TABLE = tuple(
    StateField(each.name, each.metadata["word"] or each.name, each.metadata["kind"])
    for each in fields(RunState)
    if "kind" in each.metadata
)
"""Every field that a run remembers, in the order of `RunState`: the first arguments of its constructor."""
_DICTS = tuple(
    each.name for each in fields(RunState) if each.default_factory is dict and each.metadata["kind"] != "payload"
)
"""The fields that change in place."""
_REST = tuple(each.name for each in TABLE if each.name not in _DICTS)
_dicts, _rest = attrgetter(*_DICTS), attrgetter(*_REST)
_in_order = itemgetter(*map((*_DICTS, *_REST).index, (each.name for each in TABLE)))


def refuse(state: RunState, refusal: Refusal, why: str) -> None:
    """The event in hand changes nothing, and why."""
    state.draft.refusal, state.draft.refused = refusal, why


def copied(state: RunState) -> RunState:
    """A copy of a run's state: a later step of either changes nothing in the other."""
    made = RunState(*_in_order((*map(dict.copy, _dicts(state)), *_rest(state))))
    made.ask, made.outdated = state.ask, state.outdated
    return made
