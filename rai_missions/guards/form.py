# SPDX-License-Identifier: Apache-2.0
"""Guards in normal form: conditions that are not taken apart, joined by `all` and `any`, negations pushed inwards."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

__all__ = ("ALWAYS", "NEVER", "Atom", "Form", "Junction")


class Atom(NamedTuple):
    """A condition that is not taken apart further."""

    kind: Literal["compare", "in", "fresh", "other"]
    """`other` has the whole as text."""
    path: str
    op: str
    """For comparisons the operator; else empty, or `not`."""
    operand: Any
    """What it is compared with; lists as tuples."""
    other: str | None = None
    """The other key of a comparison."""


class Junction(NamedTuple):
    """`all` or `any` of forms."""

    word: Literal["all", "any"]
    parts: tuple[Form, ...]


Form = Atom | Junction
ALWAYS, NEVER = Junction("all", ()), Junction("any", ())
