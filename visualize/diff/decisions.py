# SPDX-License-Identifier: Apache-2.0
"""What changed in what is asked: the options, who answers, with what, and what is done when no one does."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.states import State
from rai_missions.states.decision import DecisionSpec, Option
from rai_missions.states.tree import TreeNode
from visualize.diff.change import Change
from visualize.diff.fields import FieldRef, as_words, fields, reordered, severity_if
from visualize.text import child_pointer

__all__ = ("asked_changes", "new_questions", "offers")

MODEL = "agent"
Asks = State | TreeNode


def new_questions(state: State, place: str, name: str) -> Iterator[Change]:
    """What a state that was not there offers to a model."""
    nodes = state.nodes()
    for part in state.decisions():
        whose = f"{name}: tree node '{part[1:] or 'the root'}'" if part else name
        yield from offers(nodes[part[1:]] if part else state, place + state.within(part), whose, name)


def offers(asks: Asks, place: str, whose: str, subject: str) -> Iterator[Change]:
    """Every option of a question that a model was not asked before."""
    asked = asks.question()
    if asked is not None and MODEL in asked.ask:
        for name, option in asked.options.items():
            spot = FieldRef("", child_pointer(place, "decision", "options", name), whose, subject)
            after = _open(option, asks.leads(name))
            yield spot.came("offered", f"a model is newly offered '{name}'", "safety", after=after)


def _open(option: Option, leads: str) -> str:
    """When an option is offered and where it leads."""
    return f"{f'offered when {option.when.words()}' if option.when is not None else 'always open'}, {leads}"


def asked_changes(before: Asks, after: Asks, spot: FieldRef) -> Iterator[Change]:
    """What changed between two questions of one decision."""
    old, new = before.question(), after.question()
    if old is None or new is None:
        return
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
    yield from _options(old, new, after, spot)


def _ask(old: DecisionSpec, new: DecisionSpec, spot: FieldRef) -> Change:
    """To leave the model out loosens nothing; to let it in, or another out, does."""
    without = tuple(name for name in old.ask if name != MODEL)
    word = "a model is asked now" if MODEL in new.ask and MODEL not in old.ask else "who is asked changed"
    before, after = (", then ".join(each.ask) for each in (old, new))
    return spot.changed("asked", word, severity_if(new.ask != without), before=before, after=after)


def _options(old: DecisionSpec, new: DecisionSpec, asks: Asks, spot: FieldRef) -> Iterator[Change]:
    if reordered(old.options, new.options):
        yield spot.inside("options").changed(
            "asked", "options are shown in another order", severity_if(MODEL in new.ask)
        )
    newly = MODEL in new.ask and MODEL not in old.ask
    for option in (name for name in old.options if name not in new.options):
        yield spot.inside("options", option).went("rest", f"option '{option}' removed", "other")
    for option, now in new.options.items():
        here = spot.inside("options", option)
        if option not in old.options or newly:
            verb = f"a model is newly offered '{option}'" if MODEL in new.ask else f"option '{option}' newly offered"
            yield here.came("offered", verb, "safety", after=_open(now, asks.leads(option)))
        if option in old.options:
            named = here._replace(whose=f"{spot.whose}: option '{option}'")
            yield from fields(old.options[option], now, named, asks_a_model=MODEL in new.ask)
