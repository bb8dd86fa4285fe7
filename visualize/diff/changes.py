# SPDX-License-Identifier: Apache-2.0
"""What changed between two missions that use the same names, in sentences, and which of it loosens what protects.

Rule: every difference of meaning gives a sentence. Where it is unclear whether a change loosens, it counts as one that
does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.guards.guard import Guard
from rai_missions.mission import Mission
from rai_missions.states import Decision, State, Transition, Tree
from rai_missions.states.decision import Asked
from rai_missions.states.tree import DecisionLeaf, tree_paths
from rai_missions.written import Written
from visualize.diff.aligned import paired, parents
from visualize.diff.weaker import relation
from visualize.shapes import Mark
from visualize.words import child_pointer, effects, template, trigger

__all__ = ("Change", "changes")

LIMITS = (
    "timeout_s",
    "deadline_s",
    "max_age_s",
    "settle_s",
    "handover_s",
    "cancel_s",
    "ready_s",
    "within_s",
    "attempts",
)
"""What bounds something: to raise or to drop it loosens."""
APART = (
    "transitions",
    "states",
    "parallel",
    "decision",
    "tree",
    "options",
    "blackboard",
    "events",
    "invariants",
    "format",
)
"""Fields that are compared by hand."""


class Change(NamedTuple):
    """One thing that is otherwise now."""

    mark: Mark
    place: str
    """JSON pointer: into the new mission, for what is gone into the old one."""
    sentence: str
    loosens: bool = False
    """It lets something happen that could not before, or drops something that protected."""

    def __str__(self) -> str:
        return f"{self.mark} {self.sentence}"


def changes(old: Mission, new: Mission) -> Iterator[Change]:
    """Every change, in the order of the new mission."""
    yield from _fields(old, new, "", "mission", ("name", "version"))
    yield from _keys(old, new)
    yield from _named("event", old.events, new.events, "/events")
    yield from _invariants(old, new)
    yield from _rows("mission", "", "", old.transitions, new.transitions, protective=True)
    before, after = parents(old), parents(new)
    left = {name: (place, state) for place, name, state in old.walk()}
    for place, name, state in new.walk():
        if name not in left:
            yield Change("+", place, f"state '{name}' added ({state.activity() or state.word or 'wait'})")
            yield from _new_questions(state, place, name)
            continue
        if before[name] != after[name]:
            yield Change(
                "~", place, f"{name}: moved from '{before[name] or 'the top'}' to '{after[name] or 'the top'}'", True
            )
        yield from _states(left[name][0], place, name, left[name][1], state)
    for name in before.keys() - after.keys():
        place, state = left[name]
        yield Change("-", place, f"state '{name}' removed ({state.activity() or state.word or 'wait'})")


def _new_questions(state: State, place: str, name: str) -> Iterator[Change]:
    if isinstance(state, Decision) and "agent" in state.decision.ask:
        said = ", ".join(f"'{option}'" for option in state.options)
        yield Change("+", child_pointer(place, "decision"), f"{name}: a model is newly offered {said}", True)


def _states(was: str, place: str, name: str, old: State, new: State) -> Iterator[Change]:
    if type(old) is not type(new):
        yield Change(
            "~", place, f"{name}: was {old.word or 'a state that waits'}, is now {new.word or 'one that waits'}", True
        )
    else:
        yield from _fields(old, new, place, name)
    if isinstance(old, Decision) and isinstance(new, Decision):
        yield from _asked(old.decision, new.decision, child_pointer(place, "decision"), name)
    elif isinstance(new, Decision):
        yield from _new_questions(new, place, name)
    if isinstance(old, Tree) and isinstance(new, Tree):
        yield from _trees(old, new, place, name)
    yield from _rows(name, was, place, old.transitions, new.transitions, answers=isinstance(new, Decision))


def _fields(old: Written, new: Written, place: str, whose: str, also_apart: Sequence[str] = ()) -> Iterator[Change]:
    """The fields of two models of a kind that have no children or rows in them."""
    for name, field in type(new).model_fields.items():
        before, after = getattr(old, name), getattr(new, name)
        if name in APART or name in also_apart or before == after:
            continue
        word = field.alias or name
        here = child_pointer(place, word)
        if isinstance(before, Guard) or isinstance(after, Guard):
            yield from _guards(before, after, here, f"{whose}: {'guard' if word == 'when' else word}")
        elif name in LIMITS:
            loosens = after is None or (before is not None and after > before)
            yield Change("~", here, f"{whose}: '{word}' {_moved(before, after)}", loosens)
        else:
            loosens = name in ("over_orphan", "optional") and bool(after)
            yield Change(
                "~", here, f"{whose}: '{word}' was {_said(before)}, is now {_said(after)}", loosens or name == "control"
            )


def _moved(before: Any, after: Any) -> str:
    if after is None:
        return f"removed, was {before:g}"
    if before is None:
        return f"added: {after:g}"
    return f"{'grew' if after > before else 'shrank'} from {before:g} to {after:g}"


def _said(value: Any) -> str:
    if isinstance(value, Written):
        return template(value.written())
    if isinstance(value, tuple) and value and all(hasattr(item, "words") for item in value):
        return f"“{'; '.join(effects(value))}”"
    if value in (None, "", (), {}):
        return "nothing"
    if isinstance(value, tuple):
        return ", ".join(template(item) for item in value)
    return f"“{value}”" if isinstance(value, str) else template(value)


def _guards(
    before: Guard | None, after: Guard | None, place: str, whose: str, *, protective: bool = False
) -> Iterator[Change]:
    """A guard that lets something pass: to weaken it loosens; of a row that protects, to strengthen it does."""
    how = relation(before, after)
    loosens = how in (("strengthened", "changed") if protective else ("weakened", "changed"))
    if before is None:
        yield Change("+", place, f"{whose} added: {'' if after is None else after.words()}", loosens)
    elif after is None:
        yield Change("-", place, f"{whose} removed: {before.words()}", loosens)
    elif how != "same":
        said = "narrowed" if protective and how == "strengthened" else how
        yield Change("~", place, f"{whose} {said}: was {before.words()}, is now {after.words()}", loosens)
    elif before != after:
        yield Change("~", place, f"{whose} written otherwise, means the same: {after.words()}")


def _asked(old: Asked, new: Asked, place: str, name: str) -> Iterator[Change]:
    yield from _fields(old, new, place, name, ("fallback", "ask", "tools"))
    if old.fallback != new.fallback:
        yield Change("~", f"{place}/fallback", f"{name}: fallback was '{old.fallback}', is now '{new.fallback}'", True)
    if old.ask != new.ask:
        said = f"{name}: asked {', then '.join(old.ask)}; asks {', then '.join(new.ask)} now"
        yield Change("~", f"{place}/ask", said, "agent" in new.ask)
    if old.tools != new.tools:
        more = set(new.tools) - set(old.tools)
        yield Change(
            "~", f"{place}/tools", f"{name}: tools were {_said(old.tools)}, are now {_said(new.tools)}", bool(more)
        )
    for option in old.options.keys() - new.options.keys():
        yield Change("-", child_pointer(place, "options", option), f"{name}: option '{option}' removed")
    for option, now in new.options.items():
        here = child_pointer(place, "options", option)
        if option not in old.options:
            when = f", when {now.when.words()}" if now.when is not None else ", always open"
            whom = " to a model" if "agent" in new.ask else ""
            yield Change("+", here, f"{name}: option '{option}' newly offered{whom}{when}", True)
        else:
            yield from _fields(old.options[option], now, here, f"{name}: option '{option}'")


def _trees(old: Tree, new: Tree, place: str, name: str) -> Iterator[Change]:
    before, after = dict(tree_paths(old.tree)), dict(tree_paths(new.tree))
    for path in [*after, *(path for path in before if path not in after)]:
        here = f"{place}/tree/{path}".rstrip("/")
        whose = f"{name}: tree node '{path or 'the root'}'"
        if path not in before:
            yield Change("+", here, f"{whose} added ({after[path].word})")
        elif path not in after:
            yield Change(
                "-",
                here,
                f"{whose} removed ({before[path].word})",
                before[path].word in ("check", "eternal_guard", "timeout"),
            )
        elif type(before[path]) is not type(after[path]):
            yield Change("~", here, f"{whose} was {before[path].word}, is now {after[path].word}", True)
        else:
            one, other = before[path], after[path]
            inner = [pointer.partition("/")[0] for pointer, _ in other.branches()]
            yield from _fields(one, other, here, whose, (*inner, "child"))
            if isinstance(one, DecisionLeaf) and isinstance(other, DecisionLeaf):
                yield from _asked(one.decision, other.decision, child_pointer(here, "decision"), whose)


def _rows(
    name: str, was: str, place: str, old: Sequence[Transition], new: Sequence[Transition], *, protective: bool = False,
    answers: bool = False
) -> Iterator[Change]:  # fmt: skip
    """Rows of a state; `protective` where they are tried from everywhere, `answers` where answers fire them."""
    pairs = paired(old, new)
    for before, after in pairs:
        if before is None and after is not None:
            yield Change("+", f"{place}/transitions/{after}", f"{name}: row added: {_row(new[after])}")
        elif after is None and before is not None:
            row = old[before]
            yield Change(
                "-", f"{was}/transitions/{before}", f"{name}: row removed: {_row(row)}", protective or row.eventless
            )
        elif before is not None and after is not None and old[before] != new[after]:
            yield from _row_changes(name, f"{place}/transitions/{after}", old[before], new[after], protective, answers)
    order = [before for before, after in pairs if before is not None and after is not None]
    if order != sorted(order):
        yield Change("~", f"{place}/transitions", f"{name}: rows are tried in another order", True)


def _row_changes(
    name: str, place: str, old: Transition, new: Transition, protective: bool, answers: bool
) -> Iterator[Change]:  # fmt: skip
    whose = f"{name}: row '{trigger(new) or 'as soon as'}'"
    shields = protective or new.eventless
    for field in ("on", "of", "after_s", "to", "do", "internal", "about"):
        before, after = getattr(old, field), getattr(new, field)
        if before != after:
            loosens = (shields and field in ("to", "after_s")) or (answers and field == "to")
            yield Change(
                "~", f"{place}/{field}", f"{whose}: '{field}' was {_said(before)}, is now {_said(after)}", loosens
            )
    if old.when != new.when:
        yield from _guards(old.when, new.when, f"{place}/when", f"{whose}: guard", protective=shields)


def _row(row: Transition) -> str:
    to = f" to {', '.join(row.to)}" if row.to else ", stays"
    do = f", does {'; '.join(effects(row.do))}" if row.do else ""
    return f"{row.words() or 'as soon as'}{to}{do}"


def _keys(old: Mission, new: Mission) -> Iterator[Change]:
    before, after = old.blackboard, new.blackboard
    yield from _named("key", before, after, "/blackboard", same=False)
    for name in before.keys() & after.keys():
        if before[name].source == "robot" and after[name].source != "robot":
            said = f"key '{name}': no longer the robot's to say, but '{after[name].source}'"
            yield Change("~", child_pointer("/blackboard", name, "source"), said, True)
            yield from _fields(
                before[name], after[name], child_pointer("/blackboard", name), f"key '{name}'", ("source",)
            )
        else:
            yield from _fields(before[name], after[name], child_pointer("/blackboard", name), f"key '{name}'")


def _named(
    sort: str, before: Mapping[str, Written], after: Mapping[str, Written], place: str, *, same: bool = True
) -> Iterator[Change]:  # fmt: skip
    for name in [*after, *(name for name in before if name not in after)]:
        here = child_pointer(place, name)
        if name not in before:
            yield Change("+", here, f"{sort} '{name}' added")
        elif name not in after:
            yield Change("-", here, f"{sort} '{name}' removed")
        elif same:
            yield from _fields(before[name], after[name], here, f"{sort} '{name}'")


def _invariants(old: Mission, new: Mission) -> Iterator[Change]:
    for name in [*new.invariants, *(name for name in old.invariants if name not in new.invariants)]:
        here = child_pointer("/invariants", name)
        if name not in old.invariants:
            yield Change("+", here, f"invariant '{name}' added: {new.invariants[name].words()}")
        elif name not in new.invariants:
            yield Change("-", here, f"invariant '{name}' removed: {old.invariants[name].words()}", True)
        else:
            yield from _guards(old.invariants[name], new.invariants[name], here, f"invariant '{name}'")
