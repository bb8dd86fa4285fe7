# SPDX-License-Identifier: Apache-2.0
"""A mission's JSON as a Python author would write it: every word by its constructor, references, operators.

Rule: it reads the document alone, never a model, so that it is another way to the same mission.
"""

from __future__ import annotations

import keyword
import random
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

__all__ = ("PythonAuthor",)

Json = Mapping[str, Any]
HEAD = """\
from rai_missions import *
from rai_missions import CallEffect, GoalIs, Held, answer, event
from rai_missions.guards import All, Any_, Compare, Fresh, Near, Not, Possible
from rai_missions.states import *
from rai_missions.states import tree

"""
TYPES = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "object": "dict", "list": "list"}
COMPARISONS = {
    "==": "equal", "!=": "unequal", "<": "less", "<=": "at_most", ">": "greater", ">=": "at_least", "in": "within",
}  # fmt: skip
MAIN_WORDS = {
    "Action": ["action"], "Call": ["call"], "Parallel": ["parallel"], "Include": ["mission"], "History": ["history"],
    "Final": ["final"], "Compound": [], "State": [],
}  # fmt: skip
"""Constructor → the words that it has by position."""
DECORATORS = {
    "retry": "Retry", "repeat": "Repeat", "timeout": "Timeout", "condition": "Condition",
    "status_to_blackboard": "StatusToBlackboard", "eternal_guard": "EternalGuard",
}  # fmt: skip
LEAVES = {"action": "Action", "call": "Call", "check": "Check", "wait_s": "Wait", "set": "Set", "publish": "Publish"}
KINDS = {
    "action": "Action", "call": "Call", "parallel": "Parallel", "mission": "Include", "history": "History",
    "final": "Final", "states": "Compound",
}  # fmt: skip
EFFECTS = {"call": "CallEffect", "publish": "Publish", "say": "Say", "log": "Log", "drop": "Drop"}


class PythonAuthor:
    """Writes missions in Python, in one of many styles.

    Args:
        rng: What each choice of style follows from.
    """

    RESERVED: ClassVar = {"from": "from_", "with": "with_", "is": "is_", "in": "in_"}

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._keys: Json = {}

    def source(self, document: Json) -> str:
        """The text of a file that offers the mission of a document."""
        self._keys = document.get("blackboard", {})
        keys = f"k = Keys({self._keywords({name: self._key(each) for name, each in self._keys.items()})})\n\n"
        return f"{HEAD}{keys}def mission():\n    return {self._mission(document)}\n"

    def _mission(self, document: Json) -> str:
        readers: dict[str, Callable[[Any], str]] = {
            "states": self._states, "transitions": self._transitions, "invariants": self._guards,
            "events": self._events,
        }  # fmt: skip
        words = [repr(document["name"]), *(["keys=k"] if self._keys else [])]
        for word, given in document.items():
            if word not in ("name", "blackboard", "$schema"):
                words.append(f"{word}={readers.get(word, repr)(given)}")
        return f"Mission({', '.join(words)})"

    # -- values -------------------------------------------------------------------------------------------------------

    def _some(self) -> bool:
        return self._rng.random() < 0.5

    def _keywords(self, items: Mapping[str, str]) -> str:
        """Arguments by name; where one is no name of Python, as an object."""
        if all(name.isidentifier() and not keyword.iskeyword(name) for name in items):
            return ", ".join(f"{name}={each}" for name, each in items.items())
        return f"**{self._object(items)}"

    @staticmethod
    def _object(items: Mapping[str, str]) -> str:
        return "{" + ", ".join(f"{name!r}: {each}" for name, each in items.items()) + "}"

    def _key(self, key: Json) -> str:
        kind = TYPES[key["type"]] if key["type"] in TYPES and self._some() else repr(key["type"])
        rest = {word: repr(given) for word, given in key.items() if word != "type"}
        if "fields" in key and self._some():
            rest["fields"] = self._object({name: TYPES.get(each, repr(each)) for name, each in key["fields"].items()})
        return f"Key({', '.join([kind, *(f'{word}={each}' for word, each in rest.items())])})"

    def _events(self, given: Any) -> str:
        if not isinstance(given, Mapping):
            return repr(given)
        if not any(given.values()) and self._some():
            return repr(list(given))
        return self._object({name: f"EventSpec({self._arguments(spec)})" for name, spec in given.items()})

    @staticmethod
    def _arguments(words: Json) -> str:
        return ", ".join(f"{word}={given!r}" for word, given in words.items())

    def _path(self, path: str) -> str:
        """A reference, or the path as text."""
        head, *fields = path.split(".")
        if head in ("event", "answer") and head not in self._keys:
            found = head
        elif head in self._keys:
            found = (
                f"k.{head}" if head.isidentifier() and not keyword.iskeyword(head) and self._some() else f"k[{head!r}]"
            )
        else:
            return repr(path)
        known = self._keys.get(head, {})
        if fields and (known.get("type", "object") != "object" or fields[0] not in known.get("fields", fields)):
            return repr(path)
        if self._rng.random() < 0.2:
            return repr(path)
        taken = ("fresh", "near", "is_in", "is_true", "is_false", *keyword.kwlist)
        return found + "".join(f".{each}" if each not in taken and self._some() else f"[{each!r}]" for each in fields)

    def _template(self, given: Any) -> str:
        """A value; a reference inside it as one of Python."""
        if isinstance(given, Mapping):
            if set(given) == {"from"} and isinstance(given["from"], str):
                path = self._path(given["from"])
                return repr(dict(given)) if path.startswith("'") else path
            return self._object({name: self._template(each) for name, each in given.items()})
        if isinstance(given, list):
            inside = ", ".join(map(self._template, given))
            return f"[{inside}]" if self._some() else f"({inside}{',' if inside else ''})"
        return repr(given)

    def _several(self, given: Any) -> str:
        """One word or several."""
        if isinstance(given, str):
            return repr(given) if self._some() else repr([given])
        return repr(given) if self._some() else repr(tuple(given))

    # -- guards -------------------------------------------------------------------------------------------------------

    def _guards(self, given: Json) -> str:
        return self._object({name: self._guard(each) for name, each in given.items()})

    def _guard(self, guard: Json, *, bare: bool = True) -> str:
        """A guard.

        Args:
            guard: As JSON has it.
            bare: A reference to a boolean may be one here.
        """
        if "key" in guard:
            return self._comparison(guard, bare=bare)
        word = next(iter(guard)) if "goal" not in guard else "goal"
        made: Callable[[Json], str] | None = getattr(self, f"_{word}", None)
        if made is not None:
            return made(guard)
        return f"{ {'in': 'In', 'elapsed_s': 'Elapsed', 'named': 'Named'}[word] }({self._given(guard, word)})"

    def _given(self, words: Json, *first: str) -> str:
        """The words of a constructor, some by position."""
        listed = [self._template(words[word]) for word in first]
        rest = [
            f"{self.RESERVED.get(word, word)}={self._template(given)}"
            for word, given in words.items()
            if word not in first
        ]
        return ", ".join([*listed, *rest])

    def _comparison(self, guard: Json, *, bare: bool) -> str:
        path, ((word, given),) = self._path(guard["key"]), [each for each in guard.items() if each[0] != "key"]
        value = given
        is_key = isinstance(given, Mapping) and set(given) == {"key"}
        other = self._path(given["key"]) if is_key else ""
        if is_key:
            value = repr(dict(given)) if other.startswith("'") else other
        else:
            value = repr(given)
        if path.startswith("'") or (is_key and other.startswith("'")) or self._rng.random() < 0.2:
            operand = repr(dict(given)) if is_key else value
            return f"Compare({path}, {COMPARISONS[word]}={operand})"
        if word == "in":
            return f"{path}.is_in({value})"
        if word == "==" and given is True and self._some():
            return path if bare and self._some() else f"{path}.is_true"
        if word == "==" and given is False and self._some():
            return self._rng.choice([f"~{path}", f"{path}.is_false"])
        return f"({path} {word} {value})"

    def _all(self, guard: Json) -> str:
        return self._joined(guard["all"], "&", "All")

    def _any(self, guard: Json) -> str:
        return self._joined(guard["any"], "|", "Any_")

    def _joined(self, parts: Sequence[Json], sign: str, name: str) -> str:
        if len(parts) < 2 or self._rng.random() < 0.2:
            return f"{name}([{', '.join(self._guard(each) for each in parts)}])"
        return "(" + f" {sign} ".join(self._guard(each) for each in parts) + ")"

    def _not(self, guard: Json) -> str:
        inner = self._guard(guard["not"], bare=False)
        if inner.startswith("~"):  # the negation of a reference is a comparison
            inner = f"({inner})"
        return f"~{inner}" if self._some() else f"Not({inner})"

    def _possible(self, guard: Json) -> str:
        inner = self._guard(guard["possible"], bare=False)
        return f"({inner}).or_unknown" if self._some() else f"Possible({inner})"

    def _held(self, guard: Json) -> str:
        inner = self._guard(guard["held"], bare=False)
        return f"({inner}).held_for({guard['for_s']})" if self._some() else f"Held({inner}, {guard['for_s']})"

    def _fresh(self, guard: Json) -> str:
        path = self._path(guard["fresh"])
        return f"Fresh({path})" if path.startswith("'") or self._some() else f"{path}.fresh"

    def _near(self, guard: Json) -> str:
        here, there = map(self._path, guard["near"])
        if here.startswith("'") or there.startswith("'"):
            return f"Near(({here}, {there}), within_m={guard['within_m']})"
        return f"{here}.near({there}, within_m={guard['within_m']})"

    def _goal(self, guard: Json) -> str:
        rest = [
            f"{self.RESERVED.get(word, word)}={self._path(guard[word])}" for word in ("over", "in") if word in guard
        ]
        aspect = [f"is_={guard['is']!r}"] if "is" in guard else []
        return f"GoalIs({', '.join([self._path(guard['goal']), *rest, *aspect])})"

    # -- effects and transitions --------------------------------------------------------------------------------------

    def _effects(self, given: Sequence[Json]) -> str:
        made = [self._effect(each) for each in given]
        return made[0] if len(made) == 1 and self._some() else f"[{', '.join(made)}]"

    def _effect(self, effect: Json) -> str:
        if "set" in effect:
            return f"Set({self._set(effect)})"
        if "raise" in effect:
            return f"Raise({self._given(effect, 'raise')})"
        word = next(iter(effect))
        sent = next((each for each in ("request", "message") if each in effect), "")
        return f"{EFFECTS[word]}({self._given(effect, word, *([sent] if sent and self._some() else []))})"

    def _set(self, effect: Json) -> str:
        words = [self._path(effect["set"])]
        if "value" in effect:
            words.append(("" if self._some() else "value=") + self._template(effect["value"]))
        if "from" in effect:
            words.append(f"from_={self._path(effect['from'])}")
        words += [f"{word}={effect[word]!r}" for word in ("add", "name") if word in effect]
        return ", ".join(words)

    def _transitions(self, given: Sequence[Json]) -> str:
        return f"[{', '.join(map(self._transition, given))}]"

    def _transition(self, transition: Json) -> str:
        readers: dict[str, Callable[[Any], str]] = {
            "when": self._guard, "do": self._effects, "to": self._several, "on": self._several,
        }  # fmt: skip
        words = {word: readers.get(word, repr)(given) for word, given in transition.items()}
        name, first = "Transition", ""
        if self._rng.random() < 0.8:
            name, first = next((n, w) for w, n in (("on", "On"), ("after_s", "After"), ("when", "When")) if w in words)
        leading = []
        if first:
            leading = [words.pop(first)]
            if first == "on" and isinstance(transition["on"], list) and self._some():
                leading = [f"*{leading[0]}"]
        return f"{name}({', '.join([*leading, *(f'{word}={given}' for word, given in words.items())])})"

    # -- states -------------------------------------------------------------------------------------------------------

    def _states(self, given: Json) -> str:
        return self._object({name: self._state(each) for name, each in given.items()})

    def _state(self, state: Json) -> str:
        for word in ("read", "plan"):
            if word in state:
                return self._looking(state, word)
        if "each" in state:
            first = [self._path(state["each"]), f"item={self._path(state['as'])}"]
            return f"Each({', '.join([*first, *self._words(state, 'each', 'as')])})"
        if "tree" in state:
            return f"Tree({', '.join([self._node(state['tree']), *self._words(state, 'tree')])})"
        if "decision" in state:
            return f"Decision({', '.join([*self._asked(state['decision']), *self._words(state, 'decision')])})"
        name = next((name for word, name in KINDS.items() if word in state), "State")
        first = MAIN_WORDS[name] if self._some() else []
        listed = [self._word(word, state[word]) for word in first]
        if name == "History":
            return f"History({', '.join([*listed, *self._words(state, *first, history=True)])})"
        return f"{name}({', '.join([*listed, *self._words(state, *first)])})"

    def _looking(self, state: Json, word: str) -> str:
        paths = [f"{each}={self._path(state[each])}" for each in ("over", "into", "asked", "refused") if each in state]
        rest = self._words(state, word, "over", "into", "asked", "refused")
        name = {"read": "Read", "plan": "Plan"}[word]
        return f"{name}({', '.join([self._path(state[word]), *paths, *rest])})"

    def _words(self, state: Json, *without: str, history: bool = False) -> Iterator[str]:
        for word, given in state.items():
            if word in without:
                continue
            if history and word == "transitions":
                made = [f"Default({self._several(each['to'])})" for each in given]
                yield f"transitions=[{', '.join(made)}]"
            else:
                yield f"{self.RESERVED.get(word, word)}={self._word(word, given)}"

    def _word(self, word: str, given: Any) -> str:
        readers: dict[str, Callable[[Any], str]] = {
            "states": self._states, "parallel": self._states, "transitions": self._transitions,
            "entry": self._effects, "exit": self._effects, "achieved": self._guard, "requires": self._guard,
            "initial": self._several, "goal": self._template, "request": self._template, "with": self._template,
            "message": self._template, "result": self._result,
        }  # fmt: skip
        return readers.get(word, repr)(given)

    def _result(self, given: Json) -> str:
        return repr(dict(given))

    def _asked(self, spec: Json) -> Iterator[str]:
        yield repr(spec["question"]) if self._some() else f"question={spec['question']!r}"
        for word, given in spec.items():
            if word == "evidence":
                yield f"evidence=[{', '.join(map(self._path, given))}]"
            elif word == "options":
                yield f"options={self._object({name: self._option(each) for name, each in given.items()})}"
            elif word == "budget":
                yield f"budget=Budget({self._arguments(given)})"
            elif word != "question":
                yield f"{word}={given!r}"

    def _option(self, option: Json) -> str:
        rest = dict(option)
        words = [repr(rest.pop("about"))] if "about" in rest and self._some() else []
        words += [f"{word}={self._guard(each) if word == 'when' else repr(each)}" for word, each in rest.items()]
        return f"Option({', '.join(words)})"

    # -- trees --------------------------------------------------------------------------------------------------------

    def _node(self, node: Json) -> str:
        named = [f"name={node['name']!r}"] if "name" in node else []
        for word in ("sequence", "selector", "parallel"):
            if word in node:
                children = f"[{', '.join(map(self._node, node[word]))}]"
                rest = [f"{each}={given!r}" for each, given in node.items() if each not in (word, "name")]
                return f"tree.{word.title()}({', '.join([children, *rest, *named])})"
        if "decision" in node:
            then = {name: self._node(each) for name, each in node.get("then", {}).items()}
            rest = [f"then={self._object(then)}"] if "then" in node else []
            return f"tree.Decision({', '.join([*self._asked(node['decision']), *rest, *named])})"
        if leaf := next((word for word in LEAVES if word in node), ""):
            return self._leaf(leaf, node)
        if "child" in node:
            word = next(each for each in DECORATORS if each in node)
            value = repr(node[word])
            if word == "eternal_guard":
                value = self._guard(node[word])
            elif word == "status_to_blackboard":
                value = self._path(node[word])
            return f"tree.{DECORATORS[word]}({', '.join([self._node(node['child']), value, *named])})"
        word = next(each for each in node if each not in ("name", "policy"))
        name = re.sub(r"(?:^|_)([a-z])", lambda found: found[1].upper(), word)
        policy = [f"policy={node['policy']!r}"] if "policy" in node else []
        return f"tree.{name}({', '.join([self._node(node[word]), *policy, *named])})"

    def _leaf(self, word: str, node: Json) -> str:
        if word == "set":
            return f"tree.Set({self._set(node)})"
        if word == "check":
            rest = [f"name={node['name']!r}"] if "name" in node else []
            return f"tree.Check({', '.join([self._guard(node['check']), *rest])})"
        words = [repr(node[word]), *self._words(node, word)]
        return f"tree.{LEAVES[word]}({', '.join(words)})"
