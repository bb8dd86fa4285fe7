# SPDX-License-Identifier: Apache-2.0
"""Whether a guard was weakened: is true wherever its old form was, and somewhere else too.

Rule: a yes is certain; where two guards cannot be compared the answer is that they differ, and a reader must look.
"""

from __future__ import annotations

from typing import Literal

from rai_missions.guards.guard import Guard
from rai_missions.guards.implication import form, implies

__all__ = ("Relation", "relation")

Relation = Literal["same", "weakened", "strengthened", "changed"]


def relation(old: Guard | None, new: Guard | None) -> Relation:
    """What became of a guard; none at all is always true."""
    before, after = form(old), form(new)
    down, up = implies(before, after), implies(after, before)
    if down and up:
        return "same"
    return "weakened" if down else "strengthened" if up else "changed"
