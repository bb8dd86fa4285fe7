# SPDX-License-Identifier: Apache-2.0
"""Circles within a step, seen as they close, where the run itself takes ten thousand microsteps.

Rule: a step has gone round only where everything is as it was before, as far as anything can distinguish it. What
becomes of it then is what the limits of a step make of it, whichever comes first: that of microsteps ends the mission,
that of a tree's rounds has the tree rest, and the mission continues.

Rule: a list has an end. Where a step has come, in the same list, to a place that it passed, or that another way of the
same step has passed, no more items need to be tried: what they could bring follows from the earlier visit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.compiled.configuration import CompiledMove
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics.macrostep import MOST_MICROSTEPS
from rai_missions.engine.state import TABLE, FieldKind, RunState, StepDraft
from rai_missions.keys import type_error
from rai_missions.prove.abstraction.abstraction import INDIFFERENT, Abstraction
from rai_missions.prove.abstraction.activity_key import key_of, plain, timer_key
from rai_missions.prove.abstraction.instruments import Instruments
from rai_missions.prove.abstraction.open_rounds import MORE
from rai_missions.prove.abstraction.open_world import OpenWorld
from rai_missions.prove.abstraction.step_chains import StepChains, unpolled
from rai_missions.prove.abstraction.store import ALL_GOALS, MANY
from rai_missions.states.compound import Each

__all__ = ("StepCircles",)

PATIENCE = 8
"""Microsteps after which it looks whether the step goes round."""
MARGIN = 2
"""Where one limit comes by no more circles before another, the run goes there by itself."""


class Visit(NamedTuple):
    """How far the limits of a step were when it passed a place."""

    microsteps: int
    rooms: Mapping[str, int]
    """State → how many rounds of its tree can end yet."""


class StepCircles:
    """Leaves the circles of a step out when the first one closes.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        rest: What is forgotten between steps.
        instruments: Learns that every goal is looked at.
    """

    def __init__(self, chart: Chart, world: OpenWorld, rest: Abstraction, instruments: Instruments) -> None:
        self._world, self._rest, self._instruments = world, rest, instruments
        self._keys = chart.program.keys
        self._chains = StepChains(world, instruments)
        self._macrostep: tuple[Any, int] = (None, 0)
        self._moves = 0
        self._passed: dict[str, Visit] | None = None
        """Places that were passed; None where circles are gone to the end."""
        keys_by_kind: Mapping[FieldKind, Callable[[Any], Any]] = {
            "configuration": lambda config: config.key,
            "state": lambda node: node and node.name,
            "goals": lambda goals: _many((goal.owner, goal.action, goal.phase) for goal in goals.values()),
            "calls": lambda calls: _many(calls.values()),
            "board": self._reported,
            "timers": lambda timers: _many(timer_key(key, timer) for key, timer in timers.items()),
            "activities": lambda running: [(name, key_of(activity)) for name, activity in running.items()],
        }
        self._lists: dict[str, tuple[int, set[str]]] = {}
        """`each` → its current item, and the places in which the macrostep in hand has asked for more items."""
        self._fields = [(each.name, keys_by_kind.get(each.kind)) for each in TABLE if each.kind not in INDIFFERENT]

    def is_new_round(self, state: RunState, node: CompiledState) -> bool:
        """Whether more rounds of a list may lead to what no other way, and none before on this one, leads to."""
        self._follow(state)
        items, index = state.rounds[node.name]
        last, places = self._lists.get(node.name, (index, set()))
        if index <= last:
            places = set()
        self._lists[node.name] = index, places
        rounds = [(name, each[at + (name == node.name) :]) for name, (each, at) in sorted(state.rounds.items())]
        kept = self._rest.later.roots
        reported = [each for each in self._reported(state.board) if each[0] in kept]
        fields = [each for each in self._state(state) if each[0] not in ("rounds", "board")]
        assert isinstance(node.state, Each)
        key = node.state.item
        is_replaced = items[index] is MORE or not type_error(self._keys[key], items[index])
        own = [each for each in self._counted() if not (is_replaced and each[0] == key)]
        place = repr((node.name, fields, reported, rounds, items[index], self._draft(state), own))
        is_new = place not in places and self._world.choices.is_first_at(repr((place, self._past(state.draft))))
        places.add(place)
        if not is_new:
            self._look()
            self._instruments.asked.update({key for key, _ in state.draft.written} & self._world.own_keys)
        return is_new

    def _past(self, draft: StepDraft) -> tuple[Any, ...]:
        """What a step has done so far, as far as it makes a difference of where the step leads."""
        seen = self._instruments
        return (
            draft.macrosteps,
            sorted({name for move in draft.moves for name in (*move.taken, *move.exited, *move.entered)}),
            sorted({key for key, _ in draft.written}),
            sorted(seen.turned),
            sorted((name, sorted(paths)) for name, paths in seen.begun.items()),
            sorted(seen.lengthened),
            unpolled(draft),
        )

    def _follow(self, state: RunState) -> None:
        """Forget what was passed where another macrostep is in hand."""
        macrostep = (state.draft, state.draft.macrosteps)
        if self._macrostep != macrostep:
            self._macrostep, self._moves, self._passed, self._lists = macrostep, 0, {}, {}
            self._chains.begin()

    def _look(self) -> None:
        """Everything is looked at."""
        self._instruments.asked.add(ALL_GOALS)
        self._instruments.compare_values()

    def may_move(self, state: RunState, move: CompiledMove) -> bool:
        """Whether a microstep may be made: not where the step goes round until the limit of microsteps."""
        self._follow(state)
        self._moves += 1
        if self._moves <= PATIENCE or state.outcome is not None or self._passed is None:
            return True
        rounds = state.draft.tree_rounds
        self._look()
        visit = Visit(state.draft.microsteps, {name: each.room for name, each in rounds.items()})
        place = repr((self._place(state), move.value))
        before = self._passed.setdefault(f"{place} {self._counted()}", visit)
        if before is not visit:
            return not self._is_endless(state, before, visit)
        self._chains.take(state.draft, place)
        return True

    def _is_endless(self, state: RunState, before: Visit, now: Visit) -> bool:
        """Whether the circle that has closed is gone until the limit of microsteps; else it is gone almost to the end.

        Where a tree's loops go round in it, their limit may come first.
        """
        self._passed = None
        spent = {name: before.rooms.get(name, room) - room for name, room in now.rooms.items()}
        left = [now.rooms[name] // each for name, each in spent.items() if each]
        circles = (MOST_MICROSTEPS - now.microsteps) // (now.microsteps - before.microsteps)
        if not left or circles + MARGIN < min(left):
            return True
        if min(left) + MARGIN < circles:
            for name, each in spent.items():
                state.draft.tree_rounds[name].skip(max(0, min(left) - 1) * each)
        return False

    def _place(self, state: RunState) -> tuple[Any, ...]:
        """What the next microsteps depend on; of many alike, that there are many."""
        return self._state(state), len(self._world.choices.trail), self._draft(state)

    def _state(self, state: RunState) -> list[tuple[str, Any]]:
        return [
            (name, to_key(getattr(state, name)) if to_key is not None else _ordered(getattr(state, name)))
            for name, to_key in self._fields
        ]

    def _draft(self, state: RunState) -> tuple[Any, ...]:
        draft = state.draft
        return (
            [(name, rounds.spent) for name, rounds in sorted(draft.tree_rounds.items())],
            [
                (each.name, each.source.name if each.source else "", each.is_late, str(each.data))
                for each in draft.internal
            ],
            [node.name for node in draft.starting],
        )

    def _reported(self, board: Any) -> list[Any]:
        """What is known but of the mission's own keys."""
        own = self._world.own_keys
        return sorted(
            (key, None if entry is None else plain(entry[0])) for key, entry in board.entries() if key not in own
        )

    def _counted(self) -> list[Any]:
        """What the mission's own keys hold; of a counter no more than guards distinguish."""
        found, bounds, idle = [], self._rest.saturating, self._rest.idle
        for key, entry in self._world.own().items():
            value: Any = None if entry is None else plain(entry[0])
            if key in bounds and isinstance(value, int | float):
                low, high = bounds[key]
                value = min(max(value, low), high)
            found.append((key, None if key in idle else value))
        return sorted(found, key=lambda each: each[0])


def _ordered(value: Any) -> Any:
    return sorted(value.items(), key=lambda item: str(item[0])) if isinstance(value, dict) else value


def _many(things: Iterable[Any]) -> list[tuple[Any, int]]:
    """How many there are of each, as far as that makes a difference."""
    return sorted((each, min(many, MANY)) for each, many in Counter(things).items())
