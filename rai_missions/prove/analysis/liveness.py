# SPDX-License-Identifier: Apache-2.0
"""What a run may still look at: a key that is written before anything reads it again distinguishes no two states.

Rule: only what no way on reads first is left out; where that is not known, it is kept.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.graph import Graph
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove.analysis.live_table import RECALL, LiveTable, root_of
from rai_missions.prove.analysis.state_reads import ANSWER, KNOWN, NONE, START, StateReads
from rai_missions.states.history import History

__all__ = ("ALL", "Later", "LiveReads", "LooksAhead")

REMEMBERED = 4096
"""Configurations of which is remembered what makes a difference."""
PLAIN = (bool, int, float, str, list)
ALL = "*"
"""Represents all parameters of an answer."""


@lru_cache(maxsize=REMEMBERED)
def _roots(paths: frozenset[str]) -> frozenset[str]:
    return frozenset(path.partition(".")[0] for path in paths)


@lru_cache(maxsize=REMEMBERED)
def _looked_at(paths: frozenset[str], known: frozenset[str]) -> frozenset[str]:
    return _roots(paths) | known


@lru_cache(maxsize=REMEMBERED)
def _around(paths: frozenset[str]) -> frozenset[str]:
    """What these paths lead through."""
    return frozenset(path[:at] for path in paths for at, letter in enumerate(path) if letter == ".")


def _parameter(path: str) -> str:
    return path.split(".")[1] if "." in path else ALL


class Later(NamedTuple):
    """What makes a difference from a configuration on."""

    keys: frozenset[str]
    """The keys that may be read before they are written again; of an object that is read in part, the paths into it."""
    starts: frozenset[str]
    """The actions that may be started."""
    recalls: frozenset[int]
    """The history states whose memory may be looked up before it is written again."""
    answers: frozenset[str]
    """The parameters of the last answer that may be read before the next answer; `*` for all."""
    known: frozenset[str] = NONE
    """Keys of which it is only asked whether they are known."""

    @property
    def roots(self) -> frozenset[str]:
        """The keys that something may look at."""
        return _looked_at(self.keys, self.known)

    def part(self, path: str, value: Mapping[str, Any]) -> Mapping[str, Any]:
        """What may be read of an object."""
        if path in self.keys:
            return value
        found, around = {}, _around(self.keys)
        for field, each in value.items():
            inner = f"{path}.{field}"
            if inner in self.keys or inner in around:
                found[field] = self.part(inner, each) if isinstance(each, Mapping) else each
        return found

    def of(self, key: str, value: Any) -> Any:
        """What may be read of the value of a key; where only that it is known, one value represents all of its type."""
        if isinstance(value, Mapping):
            return self.part(key, value)
        if key in self.known and key not in _roots(self.keys):
            return next((kind() for kind in PLAIN if isinstance(value, kind)), value)
        return value


class LooksAhead(Protocol):
    """Whatever knows what makes a difference from a configuration on."""

    def after(self, config: Configuration) -> Later:
        """What makes a difference from there on."""

    def within(self, nodes: Iterable[CompiledState]) -> frozenset[str]:
        """What of it rests on these states: where all states together give the same, `after` does."""

    def with_outcome(self, node: CompiledState, outcome: str, others: Collection[str]) -> Later:
        """What makes a difference once a state ends with an outcome, and not with others that it could end with."""


class LiveReads:
    """What may be read, and which actions may be started, from a configuration on.

    Args:
        mission: The mission.
        graph: It compiled.
        robot_facts: The guards of a robot's composed actions are read at any time.
        reads_all: The user's predicates may read every key at any time.
    """

    def __init__(self, mission: Mission, graph: Graph, robot_facts: RobotFacts, *, reads_all: bool = False) -> None:
        self._reads, self._graph = StateReads(mission, graph), graph
        given = [mission.invariants, robot_facts.succeeded, robot_facts.failed]
        self._always = self._reads.keys if reads_all else frozenset(self._reads.mentions(given))
        self._rewritten = {node for node in graph.order if node.is_history and self._is_rewritten(node)}
        self._can_return = [node for node in self._rewritten if _remembers_all(node)]
        self._flee = graph.nodes[mission.on_cancel] if mission.on_cancel is not None else None
        self._tables: dict[frozenset[CompiledState], LiveTable] = {}
        self._every = self._table(frozenset())
        self._found: dict[tuple[int, ...], Later] = {}

    def _table(self, returning: frozenset[CompiledState]) -> LiveTable:
        """What each state needs where these histories return to what is active."""
        if returning not in self._tables:
            self._tables[returning] = LiveTable(
                self._reads, self._graph, rewritten=self._rewritten, flee=self._flee, returning=returning
            )
        return self._tables[returning]

    def after(self, config: Configuration) -> Later:
        """What makes a difference from a configuration on."""
        found = self._found.get(config.key)
        if found is None:
            if len(self._found) >= REMEMBERED:
                self._found.clear()
            found = self._found[config.key] = self._after(config)
        return found

    def within(self, nodes: Iterable[CompiledState]) -> frozenset[str]:
        """What of it rests on these states: where all states together give the same, `after` does.

        Histories apart: what they recall depends on which of their parents are active.
        """
        return self._every.of(nodes)

    def _after(self, config: Configuration) -> Later:
        table = self._table(frozenset(each for each in self._can_return if each.parent in config.nodes))
        words = self._always | table.of((*config.nodes, self._graph.root)) | table.entered_again(config.nodes)
        starts = frozenset(word[len(START) :] for word in words if word.startswith(START))
        looked_up = {self._graph.nodes[word[len(RECALL) :]] for word in words if word.startswith(RECALL)}
        if self._graph.uses_history:  # an entry by default looks them up
            looked_up = {node for node in self._graph.order if node.is_history}
        recalls = {node for node in looked_up if not (node in self._rewritten and node.parent in config.nodes)}
        answers = frozenset(_parameter(word) for word in words if word.partition(".")[0] == ANSWER)
        recalled = frozenset(node.index for node in recalls)
        return Later(self._paths(words), starts, recalled, answers, self._known(words))

    def _paths(self, words: Iterable[str]) -> frozenset[str]:
        return frozenset(word for word in words if word.partition(".")[0] in self._reads.keys)

    def _known(self, words: Iterable[str]) -> frozenset[str]:
        return frozenset(root_of(word) for word in words if word.startswith(KNOWN))

    def with_outcome(self, node: CompiledState, outcome: str, others: Collection[str]) -> Later:
        """What makes a difference once a state ends with an outcome, and not with others that it could end with.

        Transitions that only the others take are left out: until the state is entered again, they cannot be taken.
        """
        never = set(others) - {outcome}
        words = {*self._always, *self._reads.of_state(node)}
        for transition in node.transitions:
            named = transition.definition.on
            if not named or not never.issuperset(named):
                words |= self._every.of_transition(transition)
        others_active = {*node.ancestors, self._graph.root}
        others_active |= {each for each in self._graph.order if any(a.is_parallel for a in each.ancestors)} - {node}
        paths = words | self._every.of(others_active)
        return Later(self._paths(paths), NONE, frozenset(), NONE, self._known(paths))

    def _is_rewritten(self, history: CompiledState) -> bool:
        """Whether leaving its parent always comes before looking it up again."""
        parent = history.parent
        inside = [node for node in self._graph.order if node is parent or (parent is not None and node.inside(parent))]
        targets = (transition.targets for node in inside for transition in node.transitions)
        return not (self._graph.uses_history or any(history in each for each in targets))


def _remembers_all(history: CompiledState) -> bool:
    """Whether a history leads back to just what was active inside its parent."""
    is_deep = isinstance(history.state, History) and history.state.history == "deep"
    siblings = history.parent.children if history.parent is not None else ()
    return is_deep or not any(each.children for each in siblings)
