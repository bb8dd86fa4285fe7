# SPDX-License-Identifier: Apache-2.0
"""What a mission has against a start."""

from __future__ import annotations

from typing import Literal, NamedTuple

__all__ = ("StartFault", "StartFaultKind")

StartFaultKind = Literal["started", "foreign", "missing", "unfit"]
"""The mission was started already; an argument is none of its own, is missing, or has a value that does not fit."""


class StartFault(NamedTuple):
    """One reason why a mission does not start."""

    kind: StartFaultKind
    sentence: str
    """In words."""
    argument: str = ""
    """The argument that it is about; empty for `started`."""
