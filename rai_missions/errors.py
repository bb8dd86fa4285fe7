# SPDX-License-Identifier: Apache-2.0
"""The errors a caller can meet, by who mends them.

Rule: a refused proposal, an ignored event and a failed action are values, never one of these.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

__all__ = ("ConnectorError", "DefinitionError", "Fault", "MissionError", "UsageError")


class Fault(NamedTuple):
    """One thing wrong in a mission, profile or journal, and where."""

    place: str
    """JSON pointer (RFC 6901) into the document; empty for the document itself."""
    sentence: str
    """What is wrong, what was given, and what would be right."""

    def __str__(self) -> str:
        return f"{self.place or '/'}: {self.sentence}"


class MissionError(Exception):
    """Whatever `rai_missions` raises on purpose."""


class DefinitionError(MissionError):
    """The author of a mission, profile or journal mends it: every fault at once.

    Args:
        faults: At least one fault, in document order.
        source: The file the faults are in, if it came from one.
    """

    def __init__(self, faults: Iterable[Fault], source: str = "") -> None:
        self.faults = tuple(faults)
        self.source = source
        super().__init__("\n".join(f"{source}{fault}" if not source else f"{source}: {fault}" for fault in self.faults))


class UsageError(MissionError):
    """The caller mends it: a name that does not exist, a call at the wrong time."""


class ConnectorError(MissionError):
    """The world outside is at fault: no such server, a message of the wrong shape."""
