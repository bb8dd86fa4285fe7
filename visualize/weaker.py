# SPDX-License-Identifier: Apache-2.0
"""Whether a guard was weakened: is true wherever its old form was, and somewhere else too.

Rule: a yes is certain; where two guards cannot be compared the answer is that they differ, and a reader must look.
"""

from __future__ import annotations

import json
from typing import Any, Literal

from rai_missions.guards import All, Any_, Compare, Guard, Not

__all__ = ("Relation", "relation")

Relation = Literal["same", "weakened", "strengthened", "changed"]
Form = tuple[Any, ...]
"""(`all` | `any`, parts) or (`compare`, path, operator, operand as JSON text) or (`other`, JSON text, sign)."""

NEGATED = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
TRUE: Form = ("all", frozenset())


def relation(old: Guard | None, new: Guard | None) -> Relation:
    """What became of a guard; none at all is always true."""
    before, after = _form(old), _form(new)
    known: dict[tuple[Form, Form], bool] = {}
    down, up = _implies(before, after, known), _implies(after, before, known)
    if down and up:
        return "same"
    return "weakened" if down else "strengthened" if up else "changed"


def _form(guard: Guard | None, wanted: bool = True) -> Form:
    """A guard with its negations pushed inwards; in Kleene's logic both forms mean the same, unknown included."""
    if guard is None:
        return TRUE
    if isinstance(guard, Not):
        return _form(guard.guard, not wanted)
    if isinstance(guard, All | Any_):
        parts = frozenset(_form(part, wanted) for part in guard.inner())
        word = guard.word if wanted else "any" if guard.word == "all" else "all"
        return next(iter(parts)) if len(parts) == 1 else (word, parts)
    if isinstance(guard, Compare) and (wanted or guard.op in NEGATED):
        op, operand = guard.op if wanted else NEGATED[guard.op], guard.operand
        if op == "!=" and isinstance(operand, bool):
            op, operand = "==", not operand
        return ("compare", guard.key, op, json.dumps(operand, sort_keys=True))
    return ("other", json.dumps(guard.written(), sort_keys=True), wanted)


def _implies(one: Form, other: Form, known: dict[tuple[Form, Form], bool]) -> bool:
    pair = (one, other)
    if pair not in known:
        known[pair] = one == other or _worked_out(one, other, known)
    return known[pair]


def _worked_out(one: Form, other: Form, known: dict[tuple[Form, Form], bool]) -> bool:
    if other[0] == "all":
        return all(_implies(one, part, known) for part in other[1])
    if one[0] == "any":
        return all(_implies(part, other, known) for part in one[1])
    if other[0] == "any" and any(_implies(one, part, known) for part in other[1]):
        return True
    if one[0] == "all":
        return any(_implies(part, other, known) for part in one[1])
    return one[0] == other[0] == "compare" and one[1] == other[1] and _wider(one[2], one[3], other[2], other[3])


def _wider(op: str, bound: str, other_op: str, other_bound: str) -> bool:
    """Whether every value that the one comparison allows the other does too, both with constant numbers."""
    here, there = json.loads(bound), json.loads(other_bound)
    numbers = all(isinstance(each, int | float) and not isinstance(each, bool) for each in (here, there))
    if not numbers:
        return bool(
            op == "in" == other_op
            and isinstance(here, list)
            and isinstance(there, list)
            and all(i in there for i in here)
        )
    if op == "==":
        allowed = {"<": here < there, "<=": here <= there, ">": here > there, ">=": here >= there, "!=": here != there}
        return bool(allowed.get(other_op, False))
    if op[0] not in "<>" or other_op[0] != op[0]:
        return False
    inside = here < there if op[0] == "<" else here > there
    return bool(inside or (here == there and (other_op.endswith("=") or op == other_op)))
