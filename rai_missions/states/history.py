# SPDX-License-Identifier: Apache-2.0
"""A way back: to where its parent was when it was last left."""

from __future__ import annotations

from typing import ClassVar, Literal

from rai_missions.states.state import State

__all__ = ("History",)


class History(State, word="history"):
    """Never active itself; without memory it leads to the parent's `initial`."""

    positional: ClassVar = ("history",)

    history: Literal["shallow", "deep"]
    """`shallow` remembers the parent's active child, `deep` all that was active inside."""
