# SPDX-License-Identifier: Apache-2.0
"""What each part of a mission looks at by itself: the keys, the paths into them, and the parameters of answers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from rai_missions.engine.compiled.graph import Graph
from rai_missions.engine.compiled.states import CompiledState, CompiledTransition
from rai_missions.mission.mission import Mission
from rai_missions.prove.analysis.parts import parts, texts_in, writes_in
from rai_missions.states.compound import Each
from rai_missions.states.decision import Option
from rai_missions.states.effects import Effect, Set
from rai_missions.states.state import State
from rai_missions.states.tree.leaves import ActionLeaf, SetLeaf

__all__ = ("ANSWER", "KNOWN", "NONE", "START", "StateReads")

KINDS: Mapping[str, type] = {"string": str, "object": Mapping, "boolean": bool}
"""Types of keys that any value of the same type of JSON fits."""
NONE: frozenset[str] = frozenset()
ANSWER = "answer"
"""The name of the answer in hand."""
START, KNOWN = "start ", "known "
"""Prefixes of the name of an action that may be started, and of a key of which it is only asked whether it is known."""


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


class StateReads:
    """What states, effects and guards look at.

    Args:
        mission: The mission.
        graph: It compiled.
    """

    def __init__(self, mission: Mission, graph: Graph) -> None:
        self._blackboard, self.keys, self._graph = mission.blackboard, frozenset(mission.blackboard), graph
        self._set = {effect.set for effect in writes_in(mission)}

    def of_state(self, node: CompiledState) -> frozenset[str]:
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
        looked = self._worked_with(node.state, fields) if node.state.computed() else self.mentions(own)
        return frozenset({*looked, *self.of_effects(node.state.exit), *(START + action for action in actions)})

    def on_entry(self, node: CompiledState) -> frozenset[str]:
        """What a state looks at as it is entered, and not again before it is entered again."""
        if node.state is None:
            return NONE
        listed = [node.state.each] if isinstance(node.state, Each) else []
        return frozenset((*self.of_effects(node.state.entry), *self.mentions(listed)))

    def _worked_with(self, state: State, fields: Collection[str]) -> Iterator[str]:
        """What a state looks at that works a value out of others.

        Why the others need only be known: it may come to any of its outcomes, with any value that can come with it
        (`OpenWorld.anything_of`), whatever they are; if one is unknown, it is rejected. What it wrote before is
        written again.
        """
        for field in sorted({*fields} - {"into"}):
            value = getattr(state, field)
            is_key = isinstance(value, str) and value in self.keys
            yield from (KNOWN + value,) if is_key else self.mentions(value)

    def of_effects(self, effects: Iterable[Effect]) -> Iterator[str]:
        for effect in effects:
            if isinstance(effect, Set) and effect.add is None:
                yield from self.mentions(effect.source)
            else:
                yield from self.mentions(effect)

    def mentions(self, value: Any) -> Iterator[str]:
        """Every key, and every path into one, that anything in a part of a mission looks at."""
        for text in texts_in(value, without=_is_no_look):
            root = text.partition(".")[0]
            if root in self.keys or root == ANSWER:
                yield text

    def is_known(self, source: str, key: str, transition: CompiledTransition) -> bool:
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
        if root == ANSWER and root not in self.keys:
            return all(_must_bring(state.options.get(each), path, written.type) for each in named)
        is_its_own = root == getattr(state, "into", "") and state.computed().issuperset(named)
        if not is_its_own or root in self._set:
            return False
        examples = [each for name in named for each in state.computed_examples(name) or ({},)]
        return all(isinstance(each.get(path), KINDS[written.type]) for each in examples)
