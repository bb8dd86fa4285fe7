# SPDX-License-Identifier: Apache-2.0
"""What a run may still look at: a key that is written before anything reads it again distinguishes no two states.

Rule: only what no way on reads first is left out; where that is not known, it is kept.
Source: live variables, A. V. Aho et al., Compilers (2nd ed.), section 9.2.5, on the transitions of a chart.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import dropwhile
from typing import Any, NamedTuple, Protocol

from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.graph import Graph
from rai_missions.engine.compiled.states import CompiledState, CompiledTransition
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove.analysis.parts import parts, texts_in, writes_in
from rai_missions.states.compound import Each
from rai_missions.states.decision import Option
from rai_missions.states.effects import Effect, Set
from rai_missions.states.state import State
from rai_missions.states.tree.leaves import ActionLeaf, SetLeaf

__all__ = ("ALL", "Later", "LiveReads", "LooksAhead")

REMEMBERED = 4096
"""Configurations of which is remembered what makes a difference."""
PLAIN = (bool, int, float, str, list)
KINDS: Mapping[str, type] = {"string": str, "object": Mapping, "boolean": bool}
"""Types of keys that any value of the same type of JSON fits."""
NONE: frozenset[str] = frozenset()
ANSWER, ALL = "answer", "*"
"""The name of the answer in hand, and what represents all of its parameters."""
START, RECALL, KNOWN = "start ", "recall ", "known "
"""Prefixes of the name of an action that may be started, of a history state that may be looked up, and of a key of
which it is only asked whether it is known."""


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


def _root(word: str) -> str:
    """The key that a word is about."""
    return word.removeprefix(KNOWN).partition(".")[0]


def _staying(transition: CompiledTransition) -> tuple[CompiledState, ...]:
    """The states around a transition that stay active: the domain of its targets, and what is around that.

    A parallel state is no domain: a transition from one of its regions to another leaves it, and enters it again.
    """
    targets = transition.targets
    return tuple(
        dropwhile(
            lambda node: not node.is_compound or not all(target.inside(node) for target in targets),
            transition.source.ancestors,
        )
    )


def _is_no_look(part: object, field: str) -> bool:
    """Whether a field names keys by chance, or to no effect.

    So do what a question shows, the schema of an answer, and what a leaf of a tree writes over.
    """
    return (
        field == "evidence"
        or (field == "parameters" and isinstance(part, Option))
        or (field == "set" and isinstance(part, SetLeaf) and part.add is None)
    )


def _must_bring(option: Option | None, name: str, kind: str) -> bool:
    """Whether answers that choose an option always have a parameter, and it is of a type."""
    schema = (option.parameters if option is not None else None) or {}
    return name in schema.get("required", ()) and _kinds((schema.get("properties") or {}).get(name)) == {kind}


def _kinds(schema: Any) -> set[str]:
    """The types that a part of a schema allows, as far as it names them; `any` where it does not."""
    if not isinstance(schema, Mapping):
        return {"any"}
    found = schema.get("type", [])
    either = schema.get("anyOf") or schema.get("oneOf") or ()
    return {found} if isinstance(found, str) else {*found} or set[str]().union(*map(_kinds, either)) or {"any"}


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
        self._blackboard, self._keys = mission.blackboard, frozenset(mission.blackboard)
        self._set = {effect.set for effect in writes_in(mission)}
        given = [mission.invariants, robot_facts.succeeded, robot_facts.failed]
        self._always = self._keys if reads_all else frozenset(self._mentions(given))
        self._graph = graph
        self._entered: dict[CompiledState, frozenset[CompiledState]] = {}
        self._on_entry = {node: self._read_on_entry(node) for node in graph.order}
        self._live = {node: self._of_state(node) for node in graph.order}
        self._rewritten = {node for node in graph.order if node.is_history and self._is_rewritten(node)}
        self._flee = graph.nodes[mission.on_cancel] if mission.on_cancel is not None else None
        while self._spread():
            pass
        self._found: dict[tuple[int, ...], Later] = {}

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
        return frozenset[str]().union(*(self._live[node] for node in nodes))

    def _after(self, config: Configuration) -> Later:
        words = self._always.union(*(self._live[node] for node in config.nodes), self._live[self._graph.root])
        starts = frozenset(word[len(START) :] for word in words if word.startswith(START))
        looked_up = {self._graph.nodes[word[len(RECALL) :]] for word in words if word.startswith(RECALL)}
        if self._graph.uses_history:  # an entry by default looks them up
            looked_up = {node for node in self._graph.order if node.is_history}
        recalls = {node for node in looked_up if not (node in self._rewritten and node.parent in config.nodes)}
        answers = frozenset(_parameter(word) for word in words if word.partition(".")[0] == ANSWER)
        recalled = frozenset(node.index for node in recalls)
        return Later(self._paths(words), starts, recalled, answers, self._known(words))

    def _paths(self, words: Iterable[str]) -> frozenset[str]:
        return frozenset(word for word in words if word.partition(".")[0] in self._keys)

    def _known(self, words: Iterable[str]) -> frozenset[str]:
        return frozenset(_root(word) for word in words if word.startswith(KNOWN))

    def with_outcome(self, node: CompiledState, outcome: str, others: Collection[str]) -> Later:
        """What makes a difference once a state ends with an outcome, and not with others that it could end with.

        Transitions that only the others take are left out: until the state is entered again, they cannot be taken.
        """
        never = set(others) - {outcome}
        words = {*self._always, *self._of_state(node)}
        for transition in node.transitions:
            named = transition.definition.on
            if not named or not never.issuperset(named):
                words |= self._of_transition(transition)
        others_active = {*node.ancestors, self._graph.root}
        others_active |= {each for each in self._graph.order if any(a.is_parallel for a in each.ancestors)} - {node}
        paths = words.union(*(self._live[each] for each in others_active))
        return Later(self._paths(paths), NONE, frozenset(), NONE, self._known(paths))

    def _is_rewritten(self, history: CompiledState) -> bool:
        """Whether leaving its parent always comes before looking it up again."""
        parent = history.parent
        inside = [node for node in self._graph.order if node is parent or (parent is not None and node.inside(parent))]
        targets = (transition.targets for node in inside for transition in node.transitions)
        return not (self._graph.uses_history or any(history in each for each in targets))

    # -- what each state reads ------------------------------------------------------------------------------------

    def _of_state(self, node: CompiledState) -> frozenset[str]:
        """What a state itself looks at while it is active and on exit; not its transitions."""
        if node.state is None:
            return frozenset()
        fields = {*type(node.state).model_fields} - {
            "states",
            "parallel",
            "transitions",
            "entry",
            "exit",
            "each",
            "item",
        }
        own = [getattr(node.state, field) for field in sorted(fields)]
        actions = {getattr(node.state, "action", ""), *(leaf.action for leaf in parts(own, ActionLeaf))} - {""}
        looked = self._worked_with(node.state, fields) if node.state.computed() else self._mentions(own)
        return frozenset({*looked, *self._reads_of(node.state.exit), *(START + action for action in actions)})

    def _read_on_entry(self, node: CompiledState) -> frozenset[str]:
        """What a state looks at as it is entered, and not again before it is entered again."""
        if node.state is None:
            return NONE
        listed = [node.state.each] if isinstance(node.state, Each) else []
        return frozenset((*self._reads_of(node.state.entry), *self._mentions(listed)))

    def _worked_with(self, state: State, fields: Collection[str]) -> Iterator[str]:
        """What a state looks at that works a value out of others.

        Why the others need only be known: it may come to any of its outcomes, with any value that can come with it
        (`OpenWorld.anything_of`), whatever they are; if one is unknown, it is rejected. What it wrote before is
        written again.
        """
        for field in sorted({*fields} - {"into"}):
            value = getattr(state, field)
            is_key = isinstance(value, str) and value in self._keys
            yield from (KNOWN + value,) if is_key else self._mentions(value)

    def _reads_of(self, effects: Iterable[Effect]) -> Iterator[str]:
        for effect in effects:
            if isinstance(effect, Set) and effect.add is None:
                yield from self._mentions(effect.source)
            else:
                yield from self._mentions(effect)

    def _mentions(self, value: Any) -> Iterator[str]:
        """Every key, and every path into one, that anything in a part of a mission looks at."""
        for text in texts_in(value, without=_is_no_look):
            root = text.partition(".")[0]
            if root in self._keys or root == ANSWER:
                yield text

    # -- where it leads -------------------------------------------------------------------------------------------

    def _spread(self) -> bool:
        """One round; whether anything was learned."""
        before = sum(len(words) for words in self._live.values())
        for node in reversed(self._graph.order):  # most transitions lead to later states, whose needs are known then
            found = self._live[node].union(*(self._once_entered(node, transition) for transition in node.transitions))
            if node.is_each:
                found |= self._once_in(node.initial, (node, *node.ancestors))
            if node.state is None and self._flee is not None:
                found |= self._once_in((self._flee,))
            self._live[node] = found - {
                RECALL + each.name for each in self._rewritten if each.parent is node or each.parent in node.ancestors
            }
        return sum(len(words) for words in self._live.values()) > before

    def _once_entered(self, node: CompiledState, transition: CompiledTransition) -> frozenset[str]:
        """What a transition needs from the entry of its state on: an outcome comes with what was written just before.

        That is what the state has worked out, or the answer that was given.
        """
        words, state = self._of_transition(transition), node.state
        named, of = transition.definition.on, transition.definition.of
        written = set[str]()
        if state is not None and named and state.computed().issuperset(named):
            written.add(getattr(state, "into", ""))
        asking = node if of is None else self._graph.nodes[of]
        if named and (asking.options & transition.outcomes).issuperset(named) and ANSWER not in self._keys:
            written.add(ANSWER)
        return frozenset(word for word in words if _root(word) not in written) if written else words

    def _of_transition(self, transition: CompiledTransition) -> frozenset[str]:
        definition = transition.definition
        reads = {*self._mentions(definition.when), *self._reads_of(definition.do)}
        written = {
            effect.set
            for effect in definition.do
            if isinstance(effect, Set)
            and effect.add is None
            and (effect.source is None or self._is_known(effect.source, effect.set, transition))
        }
        later = self._once_in(transition.targets, _staying(transition))
        recalled = {RECALL + target.name for target in transition.targets if target.is_history}
        return frozenset(reads | recalled) | {word for word in later if _root(word) not in written}

    def _is_known(self, source: str, key: str, transition: CompiledTransition) -> bool:
        """Whether what a transition copies to a key is there in every run, and fits: then the key is written.

        So it is with what an answer must bring, and with what is known in all that a state can work out. Not so where
        an effect writes that too: its transition may come ahead of the outcome.
        """
        root, _, path = source.partition(".")
        definition, written = transition.definition, self._blackboard[key]
        node = transition.source if definition.of is None else self._graph.nodes[definition.of]
        state, named = node.state, definition.on or ()
        is_plain = written.type in KINDS and not (written.frame or written.fields)
        if state is None or not (is_plain and named):
            return False
        if root == ANSWER and root not in self._keys:
            return all(_must_bring(state.options.get(each), path, written.type) for each in named)
        is_its_own = root == getattr(state, "into", "") and state.computed().issuperset(named)
        if not is_its_own or root in self._set:
            return False
        examples = [each for name in named for each in state.computed_examples(name) or ({},)]
        return all(isinstance(each.get(path), KINDS[written.type]) for each in examples)

    def _once_in(self, targets: Iterable[CompiledState], kept: Collection[CompiledState] = ()) -> frozenset[str]:
        """What makes a difference once these are entered, where some states around them stay active."""
        into = self._into(targets)
        return frozenset[str]().union(
            *(self._live[node] for node in into), *(self._on_entry[node] for node in into if node not in kept)
        )

    def _into(self, targets: Iterable[CompiledState]) -> set[CompiledState]:
        """All that may be active once these are entered, with what was active before."""
        return {node for target in targets for node in self._around(target)}

    def _around(self, target: CompiledState) -> frozenset[CompiledState]:
        """A target, what is entered inside it, its ancestors, and the other regions."""
        if target not in self._entered:
            found = {target, *target.ancestors}
            found |= set(self._inside(target))
            for ancestor in target.ancestors:
                if ancestor.is_parallel:
                    found |= {node for node in self._graph.order if node.inside(ancestor)}
            self._entered[target] = frozenset(found)
        return self._entered[target]

    def _inside(self, node: CompiledState) -> Iterator[CompiledState]:
        """What may be entered with a state by default; of a history, all that it can lead back to."""
        if node.is_history or node.is_parallel or node.is_each:
            top = node.parent if node.is_history else node
            yield from (each for each in self._graph.order if top is not None and each.inside(top))
            return
        for initial in node.initial:
            yield from (initial, *(each for each in initial.ancestors if each.inside(node)))
            yield from self._inside(initial)
            for between in initial.ancestors:
                if between.is_parallel and between.inside(node):
                    yield from (each for each in self._graph.order if each.inside(between))
