# SPDX-License-Identifier: Apache-2.0
"""What follows from what: guards in normal form, and whether one being true makes another true, or impossible.

Rule: an answer of yes is certain; where the forms are too long or too strange to decide, it is no.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

from rai_missions.guards.compare import OPPOSITES, ORDERED, holds
from rai_missions.guards.form import ALWAYS, NEVER, Atom, Form, Junction
from rai_missions.guards.guard import DEEP, Guard, form_of
from rai_missions.model import alike

__all__ = ("conjuncts", "form", "implies", "never", "roots")

LONG = 400
"""Two guards with more parts than this between them are compared for equality only."""


def form(guard: Guard | None) -> Form:
    """A guard with its negations pushed inwards; they mean the same in Kleene's logic, unknown included."""
    return ALWAYS if guard is None else form_of(guard, True, 0)


def size(this: Form) -> int:
    """How many parts it has, counted as far as it matters."""
    return 1 if isinstance(this, Atom) else 1 + sum(size(part) for part in this.parts)


def implies(one: Form, other: Form) -> bool:
    """Whether the other is certainly true whenever the one is."""
    if alike(one, other) or other == ALWAYS or one == NEVER:
        return True
    return size(one) + size(other) <= LONG and _implies(one, other, {})


def _implies(one: Form, other: Form, known: dict[tuple[int, int], bool]) -> bool:
    """Whether one short form implies another; `known` holds the pairs found so far, as nested ones recur."""
    pair = (id(one), id(other))
    if pair not in known:
        known[pair] = _worked_out(one, other, known)
    return known[pair]


def _worked_out(one: Form, other: Form, known: dict[tuple[int, int], bool]) -> bool:
    if isinstance(other, Junction) and other.word == "all":
        return all(_implies(one, part, known) for part in other.parts)
    if isinstance(one, Junction) and one.word == "any":
        return all(_implies(part, other, known) for part in one.parts)
    if isinstance(other, Junction) and any(_implies(one, part, known) for part in other.parts):
        return True
    if isinstance(one, Junction):
        return any(_implies(part, other, known) for part in one.parts)
    return isinstance(other, Atom) and _atom_implies(one, other)


def _atom_implies(one: Atom, other: Atom) -> bool:
    if alike(one, other):
        return True
    if one.kind == "compare" and other.kind == "fresh" and not other.op:
        return other.path in (one.path, one.other) or one.path.startswith(f"{other.path}.")
    if one.kind != "compare" or other.kind != "compare" or one.path != other.path:
        return False
    if one.other is not None or other.other is not None:
        return one.other == other.other and (one.op, other.op) in {
            ("<", "<="),
            (">", ">="),
            ("==", "<="),
            ("==", ">="),
            ("<", "!="),
            (">", "!="),
        }
    if one.op == "==":
        return holds(one.operand, other.op, other.operand)
    if one.op == "in" and isinstance(one.operand, tuple):
        return all(holds(item, other.op, other.operand) for item in one.operand)
    return _ranges(one.op, one.operand, other.op, other.operand)


def _ranges(op: str, bound: Any, other_op: str, other_bound: Any) -> bool:
    """Whether one side of a bound lies within what another comparison allows."""
    if op not in ORDERED:
        return False
    strict, down = len(op) == 1, op[0] == "<"
    try:
        if other_op == "!=":
            beyond = other_bound > bound if down else other_bound < bound
            return bool(beyond or (strict and other_bound == bound))
        if other_op not in ORDERED or (other_op[0] == "<") is not down:
            return False
        within = bound < other_bound if down else bound > other_bound
        return bool(within or (bound == other_bound and (strict or len(other_op) == 2)))
    except TypeError:
        return False


def conjuncts(this: Form) -> Iterator[Form]:
    """The parts that must all be true for it to be."""
    if isinstance(this, Junction) and this.word == "all":
        for part in this.parts:
            yield from conjuncts(part)
    else:
        yield this


def roots(this: Form) -> frozenset[str] | None:
    """The keys and states that its conditions are about; None where it has a part that is true, or false, in any case.

    One guard implies another only where they have one of these in common, or where either has None.
    """
    if isinstance(this, Atom):
        return frozenset({each.partition(".")[0] for each in (this.path, this.other) if each is not None})
    inner = [roots(part) for part in this.parts]
    known = [each for each in inner if each is not None]
    return frozenset().union(*known) if known and len(known) == len(inner) else None


def never(this: Form) -> bool:
    """Whether it is certainly never true: two of its conditions exclude each other, or there is none to be true."""
    if this == NEVER:
        return True
    if isinstance(this, Junction) and this.word == "any":
        return all(never(part) for part in this.parts)
    parts = list(conjuncts(this))[:DEEP]
    atoms = [part for part in parts if isinstance(part, Atom)]
    if any(atom.op == "in" and atom.operand == () for atom in atoms):
        return True
    if any(_exclude(one, other) for one, other in itertools.combinations(atoms, 2)):
        return True
    return any(isinstance(part, Junction) and _closed(part, atoms) for part in parts)


def _closed(choice: Junction, atoms: Sequence[Atom]) -> bool:
    """Whether none of its alternatives can be true while these conditions are."""
    return all(never(Junction("all", (*atoms, *conjuncts(each)))) for each in choice.parts)


def _exclude(one: Atom, other: Atom) -> bool:
    """Whether two conditions are never true together."""
    return _atom_implies(one, _opposite(other)) or _atom_implies(other, _opposite(one))


def _opposite(atom: Atom) -> Atom:
    """What is false exactly where the atom is true, for what is known."""
    if atom.kind != "compare":
        return atom._replace(op="" if atom.op else "not")
    return atom._replace(op=OPPOSITES[atom.op])
