# SPDX-License-Identifier: Apache-2.0
"""Guards in normal form: conditions that are not taken apart, joined by `all` and `any`, negations pushed inwards."""

from __future__ import annotations

import itertools
import json
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from rai_missions.guards.guard import Guard

__all__ = ("ALWAYS", "DEEP", "NEVER", "Atom", "Form", "Junction", "form_of", "opaque", "text_of")

DEEP = 60
"""Guards nested deeper than this are compared for equality only."""


class Atom(NamedTuple):
    """A condition that is not taken apart further."""

    kind: str
    """`compare`, `in`, `fresh`, or `other` with the whole as text."""
    path: str
    op: str
    """For comparisons the operator; else empty, or `not`."""
    operand: Any
    """What it is compared with; lists as tuples."""
    other: str | None = None
    """The other key of a comparison."""


class Junction(NamedTuple):
    """`all` or `any` of forms."""

    word: str
    parts: tuple[Form, ...]


Form = Atom | Junction
ALWAYS, NEVER = Junction("all", ()), Junction("any", ())


def form_of(guard: Guard, wanted: bool, depth: int) -> Form:
    """When a guard is true or, not `wanted`, when it is false; `depth` is that of the guards around it."""
    if depth > DEEP:
        return Atom("other", f"#{id(guard)}", "" if wanted else "not", None)
    return guard.form(wanted, depth + 1)


def opaque(guard: Guard, wanted: bool) -> Atom:
    """The form of a guard that follows from nothing but itself."""
    return Atom("other", text_of(guard), "" if wanted else "not", None)


def text_of(guard: Guard) -> str:
    """The same for guards that are written the same; one that is too deep to be written is only itself."""
    if sum(1 for _ in itertools.islice(guard.walk(), DEEP)) == DEEP:
        return f"{id(guard)}"
    return json.dumps(guard.written(), sort_keys=True, default=str)
