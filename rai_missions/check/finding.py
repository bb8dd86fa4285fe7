# SPDX-License-Identifier: Apache-2.0
"""What `check` finds: a place, a sentence, whether the mission may run all the same, and the order of places."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Literal, NamedTuple, Self

from rai_missions.errors import Fault, steps_of
from rai_missions.model import MissionModel

__all__ = ("Finding", "Found", "Severity", "document_order", "exit_status", "faults_of")

Found = Iterator[tuple[str, str]]
"""What a rule finds: the place of each, a JSON pointer into the mission, and the sentence."""
Severity = Literal["error", "warning"]
"""A mission with an error is not run; a warning is for the reader."""


class Finding(NamedTuple):
    """One thing that a rule found."""

    place: str
    """JSON pointer into the mission."""
    sentence: str
    """What is wrong, what was given, and what would be right."""
    severity: Severity = "error"
    rule: str = ""
    """The name of the rule, as in `RULES` and in the guide."""

    @classmethod
    def of(cls, fault: Fault) -> Self:
        """A fault as an error."""
        return cls(fault.place, fault.sentence)

    @property
    def fault(self) -> Fault:
        """As `DefinitionError` carries it."""
        return Fault(self.place, self.sentence)

    def __str__(self) -> str:
        mark = "warning: " if self.severity == "warning" else ""
        return f"{self.place or '/'}: {mark}{self.sentence}"


def exit_status(findings: Iterable[Finding], *, strict: bool = False) -> int:
    """How a command that checks ends: 2 with an error, 1 with a warning where warnings count (`strict`), else 0."""
    severities = {finding.severity for finding in findings}
    if "error" in severities:
        return 2
    return 1 if strict and severities else 0


def faults_of(findings: Iterable[Finding]) -> list[Fault]:
    """The errors among them, as `DefinitionError` carries them: with one a mission is not run."""
    return [each.fault for each in findings if each.severity == "error"]


def document_order(mission: Any) -> Callable[[str], tuple[int, ...]]:
    """A key to sort places by: the positions of a pointer's words, each among its neighbours.

    Args:
        mission: A mission, or its JSON document.
    """
    positions: dict[int, tuple[Any, dict[str, tuple[int, Any]]]] = {}

    def inside(value: Any) -> dict[str, tuple[int, Any]]:
        if id(value) not in positions:
            # The value is kept with its positions, or another could come to have its id.
            positions[id(value)] = (value, {word: (index, item) for index, (word, item) in enumerate(_items(value))})
        return positions[id(value)][1]

    def order(place: str) -> tuple[int, ...]:
        here: Any = mission
        found: list[int] = []
        for step in steps_of(place):
            index, here = inside(here).get(step, (-1, None))
            found.append(index)
        return tuple(found)

    return order


def _items(value: Any) -> list[tuple[str, Any]]:
    if isinstance(value, MissionModel):
        fields = type(value).model_fields
        return [(field.alias or name, getattr(value, name)) for name, field in fields.items()]
    if isinstance(value, Mapping):
        return [(str(word), item) for word, item in value.items()]
    if isinstance(value, list | tuple):
        return [(str(index), item) for index, item in enumerate(value)]
    return []
