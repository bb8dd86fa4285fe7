# SPDX-License-Identifier: Apache-2.0
"""What changed in what is asked: the options, who answers, with what, and what is done when nobody does."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.states import Decision, State, Tree
from rai_missions.states.decision import Asked, Option
from rai_missions.states.tree import DecisionLeaf, tree_paths
from visualize.diff.change import Change
from visualize.diff.fields import Spot, fields, grave, said
from visualize.words import child_pointer

__all__ = ("asked_changes", "new_questions")

MODEL = "agent"


def new_questions(state: State, place: str, name: str) -> Iterator[Change]:
    """What a state that was not there offers to a model."""
    for here, whose, asked in _questions(state, place, name):
        yield from offers(asked, here, whose, name)


def _questions(state: State, place: str, name: str) -> Iterator[tuple[str, str, Asked]]:
    if isinstance(state, Decision):
        yield child_pointer(place, "decision"), name, state.decision
    if isinstance(state, Tree):
        for path, node in tree_paths(state.tree):
            if isinstance(node, DecisionLeaf):
                here = f"{place}/tree/{path}".rstrip("/")
                yield child_pointer(here, "decision"), f"{name}: tree node '{path or 'the root'}'", node.decision


def offers(asked: Asked, place: str, whose: str, subject: str) -> Iterator[Change]:
    """Every option of a question that a model was not asked before."""
    if MODEL in asked.ask:
        for option, now in asked.options.items():
            spot = Spot("", child_pointer(place, "options", option), whose, subject)
            yield spot.came("offered", f"a model is newly offered '{option}'", "safety", after=_open(now))


def _open(option: Option) -> str:
    return f"offered when {option.when.words()}" if option.when is not None else "always open"


def asked_changes(old: Asked, new: Asked, spot: Spot) -> Iterator[Change]:
    """What changed between two questions of one decision."""
    yield from fields(old, new, spot, ("fallback", "ask", "tools"), asks_a_model=MODEL in new.ask)
    if old.fallback != new.fallback:
        before, after = (each.fallback or "none: it fails" for each in (old, new))
        yield spot.inside("fallback").changed("fallback", "fallback changed", "safety", before=before, after=after)
    if old.ask != new.ask:
        yield _ask(old, new, spot.inside("ask"))
    if old.tools != new.tools:
        more = bool(set(new.tools) - set(old.tools))
        yield spot.inside("tools").changed(
            "asked", "what a model may look with changed", grave(more), before=said(old.tools), after=said(new.tools)
        )
    yield from _options(old, new, spot)


def _ask(old: Asked, new: Asked, spot: Spot) -> Change:
    """To leave the model out loosens nothing; to let it in, or another out, does."""
    without = tuple(name for name in old.ask if name != MODEL)
    word = "a model is asked now" if MODEL in new.ask and MODEL not in old.ask else "who is asked changed"
    before, after = (", then ".join(each.ask) for each in (old, new))
    return spot.changed("asked", word, grave(new.ask != without), before=before, after=after)


def _options(old: Asked, new: Asked, spot: Spot) -> Iterator[Change]:
    newly = MODEL in new.ask and MODEL not in old.ask
    for option in old.options.keys() - new.options.keys():
        yield spot.inside("options", option).went("rest", f"option '{option}' removed", "other")
    for option, now in new.options.items():
        here = spot.inside("options", option)
        if option not in old.options or newly:
            verb = f"a model is newly offered '{option}'" if MODEL in new.ask else f"option '{option}' newly offered"
            yield here.came("offered", verb, "safety", after=_open(now))
        if option in old.options:
            named = here._replace(whose=f"{spot.whose}: option '{option}'")
            yield from fields(old.options[option], now, named, asks_a_model=MODEL in new.ask)
