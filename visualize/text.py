# SPDX-License-Identifier: Apache-2.0
"""What a reviewer must know of a state, an option or a tree node, in words.

Rule: nothing that changes what the robot does is left out; how the words are laid out is the writers' affair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from rai_missions.states import Action, Call, Decision, Default, Each, Final, History, Include, State, Tree
from rai_missions.states.decision import DecisionSpec
from rai_missions.states.effects import Effect
from rai_missions.states.state import Transition
from rai_missions.states.tree import (
    ActionLeaf,
    BehaviourLeaf,
    CallLeaf,
    CheckLeaf,
    DecisionLeaf,
    EternalGuard,
    ParallelTree,
    PublishLeaf,
    Selector,
    Sequence,
    SetLeaf,
    TreeNode,
    WaitLeaf,
    tree_paths,
)
from rai_missions.states.tree.behaviour import factory_name
from visualize.model import Choice, Twig

__all__ = ("child_pointer", "choices", "doing", "effects", "state_lines", "state_title", "template", "trigger", "twigs")


def child_pointer(place: str, *steps: str) -> str:
    """A JSON pointer (RFC 6901) some steps further."""
    return "".join((place, *(f"/{step.replace('~', '~0').replace('/', '~1')}" for step in steps)))


def template(value: Any) -> str:
    """A goal, request or message: `pose ← target, speed 1.2`."""
    if isinstance(value, Mapping):
        if set(value) == {"from"}:
            return f"← {value['from']}"
        return ", ".join(f"{name} {template(item)}" for name, item in value.items())
    if isinstance(value, list | tuple):
        return "[" + ", ".join(template(item) for item in value) + "]"
    return ("true" if value else "false") if isinstance(value, bool) else str(value)


def effects(given: Iterable[Effect]) -> tuple[str, ...]:
    """Effects as a person would state them, with what they send."""
    return tuple(effect.words() + _sent(effect) for effect in given)


def _sent(effect: Effect) -> str:
    sent = getattr(effect, "request", None) or getattr(effect, "message", None) or getattr(effect, "data", None)
    return f" ({template(sent)})" if sent else ""


def trigger(transition: Transition) -> str:
    """What fires a transition; empty where its guard alone does; a history's default leads `without memory`."""
    if isinstance(transition, Default):
        return transition.words()
    if transition.after_s is not None:
        return f"after {transition.after_s:g} s"
    words = " or ".join("any event" if name == "*" else name for name in transition.on)
    return f"{words} of {transition.of}" if transition.of else words


def state_title(state: State) -> str:
    """What a state runs, in a line; empty for one that only waits or holds others."""
    if isinstance(state, Each):
        return f"for each {state.item} in {state.each}"
    if isinstance(state, Final):
        return state.final
    if isinstance(state, History):
        return f"{state.history} history"
    return "" if isinstance(state, Decision | Tree) else state.activity()


def state_lines(state: State) -> tuple[str, ...]:
    """What else holds for a state, a line each."""
    return tuple(line for line in _lines(state) if line)


def _lines(state: State) -> Iterator[str]:
    if isinstance(state, Decision):
        yield from _asked_lines(state.decision)
    if isinstance(state, Action | Call):
        yield from doing(state)
    if isinstance(state, Include):
        yield f"with {template(state.with_)}" if state.with_ else ""
    if isinstance(state, Final) and state.requires is not None:
        yield f"requires {state.requires.words()}"
    if state.timeout_s is not None and not isinstance(state, Action | Call):
        yield f"at most {state.timeout_s:g} s"
    yield _phrase("entry", state.entry)
    yield _phrase("exit", state.exit)


def _phrase(word: str, given: Iterable[Effect]) -> str:
    words = "; ".join(effects(given))
    return f"{word}: {words}" if words else ""


def doing(work: Action | Call | ActionLeaf | CallLeaf) -> Iterator[str]:
    """What is sent, how long it may take and when its success counts; states and leaves alike."""
    sent = work.goal if isinstance(work, Action | ActionLeaf) else work.request
    if sent:
        yield f"{'goal' if isinstance(work, Action | ActionLeaf) else 'request'}: {template(sent)}"
    if work.result:
        yield "result: " + ", ".join(f"{key} := {field}" for key, field in work.result.items())
    if work.timeout_s is not None:
        yield f"at most {work.timeout_s:g} s"
    if isinstance(work, Action | ActionLeaf):
        if work.achieved is not None:
            settle = f" (within {work.settle_s:g} s)" if work.settle_s else ""
            yield f"achieved when {work.achieved.words()}{settle}"
        if work.over_orphan:
            yield "starts over an orphan"


def _asked_lines(asked: DecisionSpec) -> Iterator[str]:
    yield f"“{asked.question}”"
    if asked.evidence:
        yield "shows " + ", ".join(asked.evidence)
    often = f", {asked.attempts} attempts each" if asked.attempts > 1 else ""
    within = f", {asked.within_s:g} s each" if asked.within_s is not None else ""
    yield f"asks {', then '.join(asked.ask)}{often}{within}"
    yield f"at most {asked.deadline_s:g} s" if asked.deadline_s is not None else "no deadline"
    if asked.tools:
        yield "may use " + ", ".join(asked.tools)


def _names(schema: Mapping[str, Any] | None) -> tuple[str, ...]:
    """The parameters that a schema names; a mission at fault may state anything there."""
    named = (schema or {}).get("properties")
    return tuple(named) if isinstance(named, Mapping) else ()


def choices(asked: DecisionSpec, place: str) -> tuple[Choice, ...]:
    """The options of a decision that is at a JSON pointer."""
    return tuple(
        Choice(
            name=name,
            place=child_pointer(place, "options", name),
            about=option.about,
            guard=option.when.words() if option.when is not None else "",
            parameters=_names(option.parameters),
            fallback=name == asked.fallback,
        )
        for name, option in asked.options.items()
    )


def twigs(tree: Tree, place: str) -> tuple[Twig, ...]:
    """The nodes of a state's tree, outer before inner."""
    above: dict[str, tuple[str, str, int]] = {}
    found = []
    for path, node in tree_paths(tree.tree):
        branches = tuple(node.branches())
        for number, (pointer, _) in enumerate(branches, 1):
            branch = pointer.partition("/")[2] if pointer.startswith("then/") else ""
            ordered = number if len(branches) > 1 and not branch else 0
            above[f"{path}/{pointer}" if path else pointer] = (path, branch, ordered)
        parent, branch, number = above.get(path, (None, "", 0))
        asked = node.decision if isinstance(node, DecisionLeaf) else None
        here = f"{place}/tree/{path}".rstrip("/")
        offered = choices(asked, f"{here}/decision") if asked else ()
        found.append(Twig(path, parent, node.word, _twig_text(node), branch, offered, number))
    return tuple(found)


def _twig_text(node: TreeNode) -> str:
    words = _twig_words(node)
    return f"{node.name}: {words}" if node.name else words


def _twig_words(node: TreeNode) -> str:
    if isinstance(node, ActionLeaf | CallLeaf):
        name = node.action if isinstance(node, ActionLeaf) else node.call
        return "; ".join((f"{node.word} {name}", *doing(node)))
    if isinstance(node, CheckLeaf):
        return f"check {node.check.words()}"
    if isinstance(node, BehaviourLeaf):
        return f"behaviour {factory_name(node.factory)}; ticked every {node.tick_s:g} s"
    if isinstance(node, WaitLeaf):
        return f"wait {node.wait_s:g} s"
    if isinstance(node, SetLeaf):
        return node.effect().words()
    if isinstance(node, PublishLeaf):
        return f"publish {node.publish} ({template(node.message)})" if node.message else f"publish {node.publish}"
    if isinstance(node, DecisionLeaf):
        return "decision: " + "; ".join(_asked_lines(node.decision))
    return _arranging(node)


def _arranging(node: TreeNode) -> str:
    if isinstance(node, Sequence):
        return "sequence" if node.memory else "sequence without memory"
    if isinstance(node, Selector):
        return "selector with memory" if node.memory else "selector"
    if isinstance(node, ParallelTree):
        policy = node.policy if isinstance(node.policy, str) else f"success on {', '.join(map(str, node.policy))}"
        return f"parallel, {policy.replace('_', ' ')}" + ("" if node.synchronise else ", not synchronised")
    if isinstance(node, EternalGuard):
        return f"while {node.guard.words()}"
    word = node.word.replace("_", " ")
    value = node.written().get(node.word)
    if isinstance(value, int | float):
        unit = {"timeout": " s", "retry": "×", "repeat": "×"}.get(node.word, "")
        return f"{word} {value:g}{unit}" if value != -1 else f"{word} for ever"
    words = f"{word} {value}" if isinstance(value, str) else word
    return f"{words}, {policy.replace('_', ' ')}" if (policy := getattr(node, "policy", "")) else words
