# SPDX-License-Identifier: Apache-2.0
"""What `check` finds: a place, a sentence, and whether the mission may run all the same."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple

from rai_missions.errors import Fault

__all__ = ("Finding", "Severity", "exit_status", "faults_of")

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
