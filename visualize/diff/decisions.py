# SPDX-License-Identifier: Apache-2.0
"""What changed in what is asked: the options, who answers, with what, and what is done when no one does."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.states import Decision, State, Transition, Tree
from rai_missions.states.decision import DecisionSpec
from rai_missions.states.tree import DecisionLeaf, tree_paths
from visualize.diff.change import Change
from visualize.diff.fields import FieldRef, as_words, fields, severity_if
from visualize.text import child_pointer, effects

__all__ = ("asked_changes", "new_questions", "offers")

MODEL = "agent"
Asks = Decision | DecisionLeaf


def new_questions(state: State, place: str, name: str) -> Iterator[Change]:
    """What a state that was not there offers to a model."""
    if isinstance(state, Decision):
        yield from offers(state, child_pointer(place, "decision"), name, name)
    if isinstance(state, Tree):
        for path, node in tree_paths(state.tree):
            if isinstance(node, DecisionLeaf):
                here = f"{place}/tree/{path}".rstrip("/")
                yield from offers(
                    node, child_pointer(here, "decision"), f"{name}: tree node '{path or 'the root'}'", name
                )


def offers(asks: Asks, place: str, whose: str, subject: str) -> Iterator[Change]:
    """Every option of a question that a model was not asked before."""
    if MODEL in asks.decision.ask:
        for option in asks.decision.options:
            spot = FieldRef("", child_pointer(place, "options", option), whose, subject)
            yield spot.came("offered", f"a model is newly offered '{option}'", "safety", after=_open(asks, option))


def _open(asks: Asks, name: str) -> str:
    """When an option is offered and where it leads."""
    option = asks.decision.options[name]
    offered = f"offered when {option.when.words()}" if option.when is not None else "always open"
    if isinstance(asks, DecisionLeaf):
        then = asks.then.get(name)
        return f"{offered}, {f'then {then.word}' if then is not None else 'and then the node has succeeded'}"
    leads = [_leads(transition) for transition in asks.transitions if name in transition.on and transition.of is None]
    return f"{offered}, {', else '.join(leads) if leads else 'no transition of its own: it leads nowhere from here'}"


def _leads(transition: Transition) -> str:
    to = f"leads to {', '.join(transition.to)}" if transition.to else "stays"
    guard = f" when {transition.when.words()}" if transition.when is not None else ""
    do = f", does {'; '.join(effects(transition.do))}" if transition.do else ""
    return f"{to}{guard}{do}"


def asked_changes(before: Asks, after: Asks, spot: FieldRef) -> Iterator[Change]:
    """What changed between two questions of one decision."""
    old, new = before.decision, after.decision
    yield from fields(old, new, spot, ("fallback", "ask", "tools"), asks_a_model=MODEL in new.ask)
    if old.fallback != new.fallback:
        was, now = (each.fallback or "none: it fails" for each in (spot.own.of(old), new))
        yield spot.inside("fallback").changed("fallback", "fallback changed", "safety", before=was, after=now)
    if old.ask != new.ask:
        yield _ask(old, new, spot.inside("ask"))
    if old.tools != new.tools:
        more = bool(set(new.tools) - set(old.tools))
        yield spot.inside("tools").changed(
            "asked",
            "what a model may look with changed",
            severity_if(more),
            before=as_words(old.tools),
            after=as_words(new.tools),
        )
    yield from _options(old, after, spot)


def _ask(old: DecisionSpec, new: DecisionSpec, spot: FieldRef) -> Change:
    """To leave the model out loosens nothing; to let it in, or another out, does."""
    without = tuple(name for name in old.ask if name != MODEL)
    word = "a model is asked now" if MODEL in new.ask and MODEL not in old.ask else "who is asked changed"
    before, after = (", then ".join(each.ask) for each in (old, new))
    return spot.changed("asked", word, severity_if(new.ask != without), before=before, after=after)


def _options(old: DecisionSpec, asks: Asks, spot: FieldRef) -> Iterator[Change]:
    new = asks.decision
    newly = MODEL in new.ask and MODEL not in old.ask
    for option in old.options.keys() - new.options.keys():
        yield spot.inside("options", option).went("rest", f"option '{option}' removed", "other")
    for option, now in new.options.items():
        here = spot.inside("options", option)
        if option not in old.options or newly:
            verb = f"a model is newly offered '{option}'" if MODEL in new.ask else f"option '{option}' newly offered"
            yield here.came("offered", verb, "safety", after=_open(asks, option))
        if option in old.options:
            named = here._replace(whose=f"{spot.whose}: option '{option}'")
            yield from fields(old.options[option], now, named, asks_a_model=MODEL in new.ask)
