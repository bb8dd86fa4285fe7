# SPDX-License-Identifier: Apache-2.0
"""Loops of trees that go round many times, explored with a few rounds that represent all.

Rule: a few rounds represent many only where they are alike: nothing that is written in a round is read, and the states
of the last rounds that were explored are the same but for the count. Else more rounds are explored, at last all.

Why this is exact: what a loop does in a round depends on its count only in the last one. So the states in which a run
can be during a round follow from those of the round before in the same way for every round but the last. Once two
rounds have the same states, all later ones have them too, and so it is with what can be reached from them.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel

from rai_missions.engine.activities.tree_rounds import MOST_ROUNDS
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove.analysis.comparisons import Comparisons
from rai_missions.prove.analysis.parts import parts, writes_in
from rai_missions.prove.state_graph import StateGraph
from rai_missions.states.effects import references
from rai_missions.states.state import State
from rai_missions.states.tree import TreeNode
from rai_missions.states.tree.decorators import OneShot, Repeat, Retry, StatusToBlackboard
from rai_missions.states.tree.leaves import ActionLeaf, CallLeaf, DecisionLeaf, SetLeaf

__all__ = ("FEW", "Level", "Loop", "long_loops", "may_rest", "unlike", "with_rounds")

FEW = 8
"""Rounds that are explored at first."""
LONG = 16
"""A loop of no more rounds than this is explored as it is."""
COUNTED: Mapping[type, str] = {Retry: "num_failures", Repeat: "num_success"}
"""The field that has the number of rounds."""
ALIKE = 3
"""Rounds with the same states, before the last one, from which on they represent all later ones."""


class Loop(NamedTuple):
    """A `retry` or a `repeat` with a number."""

    state: str
    """The state whose tree it is in."""
    path: str
    """Its path in the tree."""
    word: str
    """Under this word the tree remembers how many rounds have ended."""
    rounds: int

    def __str__(self) -> str:
        return f"{self.state}#{self.path}" if self.path else self.state


class Level(NamedTuple):
    """How far a loop is in a state of the mission."""

    ended: int
    """Rounds that have ended."""
    rest: bytes
    """A key of the state, equal for two states that differ in `ended` alone."""


def long_loops(mission: Mission, robot_facts: RobotFacts) -> tuple[Loop, ...]:
    """The loops of which a few rounds may represent all."""
    read = _read(mission, robot_facts)
    return tuple(loop for _, name, state in mission.walk() for loop in _in(name, state, read))


def _in(name: str, state: State, read: Collection[str]) -> Iterator[Loop]:
    for path, node in state.nodes().items() if state.made() is None else ():
        if isinstance(node, Retry | Repeat) and _rounds(node) > LONG and _is_alike(node.child, read):
            yield Loop(name, path, "failures" if isinstance(node, Retry) else "success", _rounds(node))


def may_rest(mission: Mission, at_once: Collection[str], restarted: Collection[str]) -> frozenset[str]:
    """The states whose tree may come to the limit of rounds in a step; a few rounds do not represent all there.

    Args:
        mission: With all rounds.
        at_once: The states of whose tree a round ended as soon as it began.
        restarted: The states whose tree has begun twice in one step.
    """
    trees = {name: state for _, name, state in mission.walk() if name in at_once}
    return frozenset(name for name, state in trees.items() if name in restarted or _most_at_once(state) > MOST_ROUNDS)


def _most_at_once(state: State) -> float:
    """How many rounds may end in one step before the last one; a loop without a number has any number."""
    loops = {path: node for path, node in state.nodes().items() if isinstance(node, Retry | Repeat)}
    many = {path: _rounds(node) if _rounds(node) >= 0 else math.inf for path, node in loops.items()}
    ended = sum(
        math.prod(each for outer, each in many.items() if f"{path}/".startswith(f"{outer}/" if outer else ""))
        for path in many
    )
    return ended - 1 + len(many)


def _rounds(node: Retry | Repeat) -> int:
    return node.num_failures if isinstance(node, Retry) else node.num_success


def _read(mission: Mission, robot_facts: RobotFacts) -> frozenset[str]:
    """The keys at which anything looks: guards, goals, requests, what is copied or gone over."""
    learned = Comparisons(mission, robot_facts)
    sent = [*(part.goal for part in parts(mission, ActionLeaf)), *(part.request for part in parts(mission, CallLeaf))]
    copied = [effect.source for effect in writes_in(mission) if effect.source is not None]
    paths = [*(path for template in sent for path in references(template)), *copied]
    return learned.compared | learned.gone_over | {path.split(".")[0] for path in paths}


def _is_alike(child: TreeNode, read: Collection[str]) -> bool:
    """Whether a round leaves nothing behind that the next one finds."""
    for _, node in child.paths():
        if isinstance(node, OneShot):
            return False
        if isinstance(node, DecisionLeaf) and any(each.parameters for each in node.decision.options.values()):
            return False
        written = set(getattr(node, "result", ()))
        written |= {node.set} if isinstance(node, SetLeaf) else set()
        written |= {node.key} if isinstance(node, StatusToBlackboard) else set()
        if not written.isdisjoint(read):
            return False
    return True


def with_rounds(mission: Mission, rounds: Mapping[Loop, int]) -> Mission:
    """The mission with other numbers of rounds in some of its loops."""
    if all(loop.rounds == number for loop, number in rounds.items()):
        return mission
    numbers: dict[int, int] = {}
    for _, name, state in mission.walk():
        nodes = state.nodes()
        numbers |= {id(nodes[loop.path]): many for loop, many in rounds.items() if loop.state == name}
    changed: Mission = _rebuilt(mission, numbers)
    return changed


def _rebuilt(value: Any, numbers: Mapping[int, int]) -> Any:
    """A part of a mission with the numbers of some of its nodes changed; itself where nothing changes."""
    if isinstance(value, BaseModel):
        fields: dict[str, Any] = {name: _rebuilt(part, numbers) for name, part in vars(value).items()}
        if id(value) in numbers:
            fields[COUNTED[type(value)]] = numbers[id(value)]
        update = {name: part for name, part in fields.items() if part is not vars(value)[name]}
        return value.model_copy(update=update) if update else value
    if isinstance(value, dict):
        items = {name: _rebuilt(part, numbers) for name, part in value.items()}
        return items if any(items[name] is not value[name] for name in items) else value
    if isinstance(value, list | tuple):
        made = [_rebuilt(part, numbers) for part in value]
        return type(value)(made) if any(new is not old for new, old in zip(made, value, strict=True)) else value
    return value


def unlike(
    space: StateGraph,
    levels: Mapping[int, Mapping[Loop, Level]],
    rounds: Mapping[Loop, int],
    marks: Collection[Collection[int]],
) -> list[Loop]:
    """The loops whose last rounds before the last one are not the same: more of them must be explored.

    Args:
        space: What was explored, whole.
        levels: Number of a state → how far each loop is there that runs.
        rounds: How many rounds of each loop were explored.
        marks: Sets of states of which a claim speaks; the same states of two rounds must be in the same of them.
    """
    states: dict[Loop, dict[int, set[Any]]] = {loop: defaultdict(set) for loop in rounds}
    for number, found in levels.items():
        marked = tuple(number in each for each in marks)
        for loop, level in found.items():
            states[loop][level.ended].add((level.rest, marked))
    leaps = _leaps(space, levels)
    return [
        loop
        for loop, many in rounds.items()
        if many < loop.rounds
        and not _are_alike(
            [states[loop].get(ended, set()) for ended in range(1, many - 1)], max(ALIKE, leaps.get(loop, 0) + 1)
        )
    ]


def _are_alike(rounds: list[set[Any]], many: int) -> bool:
    return len(rounds) >= many and all(each == rounds[-1] for each in rounds[-many:])


def _leaps(space: StateGraph, levels: Mapping[int, Mapping[Loop, Level]]) -> dict[Loop, int]:
    """The most rounds of each loop that end in one step which does not end the loop."""
    most: dict[Loop, int] = {}
    for source, target in space.edges():
        before = levels.get(source, {})
        for loop, level in levels.get(target, {}).items():
            ended = level.ended - (before[loop].ended if loop in before else 0)
            most[loop] = max(most.get(loop, 0), ended)
    return most
