# SPDX-License-Identifier: Apache-2.0
"""One thing that is otherwise now, how much it matters to those who let the mission run, and under which heading."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

from visualize.model import Mark

__all__ = ("TOPICS", "Change", "Severity", "heading", "weight")

Severity = Literal["safety", "other"]

TOPICS: Mapping[str, str] = {
    "offered": "Newly offered to a model",
    "guard": "Guards that became weaker, or cannot be compared",
    "limit": "Times and numbers that bound something: grew, or went",
    "proof": "Invariants, requires and achieved: went, or became weaker",
    "fallback": "What is done when no one answers",
    "asked": "Who is asked, and with what",
    "success": "New ways to succeeded",
    "control": "Who has control",
    "trust": "What is believed, from whom and for how long",
    "transition": "Transitions that protected, or that continue by themselves",
    "does": "What the robot is asked to do",
    "effect": "What is done on the way: written, raised, called, published",
    "form": "What a state is, where it is, where it begins",
    "tree": "Behaviour trees",
    "name": "Other names for the same",
    "rest": "All else",
    "words": "Words for readers",
}
"""What a change is about → its heading, in the order in which a reviewer reads them."""
CALMER: Mapping[str, str] = {
    "guard": "Guards",
    "limit": "Times and numbers that bound something",
    "proof": "Invariants, requires and achieved",
    "transition": "Transitions",
}
"""The headings of changes that are not for a reviewer to judge, where those above would state too much."""
ORDER = {topic: number for number, topic in enumerate(TOPICS)}


class Change(NamedTuple):
    """One thing that is otherwise now."""

    mark: Mark
    topic: str
    """One of `TOPICS`."""
    sentence: str
    old_place: str | None = None
    """JSON pointer into the old mission; None for what is new."""
    new_place: str | None = None
    """JSON pointer into the new mission; None for what is gone."""
    before: str = ""
    """What it was, in words, where that is more than the sentence has."""
    after: str = ""
    severity: Severity = "other"
    """`safety`: it lets something happen that could not before, or drops something that protected, or may do so."""
    subject: str = ""
    """The state that it is about, as the new mission calls it; empty for the mission itself."""

    @property
    def place(self) -> str:
        """Where it is in the new mission; what is gone, in the old one."""
        return self.new_place if self.new_place is not None else self.old_place or ""

    @property
    def safety(self) -> bool:
        return self.severity == "safety"

    def __str__(self) -> str:
        was, now = (f"was {self.before}" if self.before else ""), (f"is now {self.after}" if self.after else "")
        more = ", ".join(filter(None, (was, now)))
        return f"{self.mark} {self.sentence}" + (f": {more}" if more else "")


def heading(change: Change) -> str:
    """What is above it."""
    return TOPICS[change.topic] if change.safety else CALMER.get(change.topic, TOPICS[change.topic])


def weight(change: Change) -> tuple[bool, int]:
    """To sort by: what a reviewer must not miss comes first."""
    return not change.safety, ORDER[change.topic]
