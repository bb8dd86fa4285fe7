# SPDX-License-Identifier: Apache-2.0
"""What came of a happening, to be told again wherever it can only go the same way.

Rule: a way is told again where those of the mission's own keys that it looked at are what they were, and nowhere else.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rai_missions.prove.explored import Own, State
from rai_missions.prove.happening import HappeningKind
from rai_missions.prove.reached import Way

__all__ = ("Arrival", "Course", "Courses", "Made", "Needs", "value_of")

Needs = tuple[tuple[str, Any], ...]
"""Those of the mission's own keys that were looked at, each with its value: with these, it happens again."""


class Arrival(NamedTuple):
    """What one step came to, but for those of the mission's own keys that it left alone."""

    way: Way
    kind: HappeningKind
    has_moved: bool
    ended: tuple[str, str] | None
    """Outcome and why; None where the mission goes on."""
    core: bytes = b""
    state: State = ()
    written: Own | None = None
    telling: tuple[str, ...] = ()
    mode: str = ""


class Made(NamedTuple):
    """One way in which a happening can go, as it was made."""

    arrival: Arrival | None
    """None where it goes against what is assumed of the robot."""
    needs: Needs
    after: tuple[int, ...] | None
    """What is to be chosen for the next way; None after the last."""


class Course(NamedTuple):
    """All that one happening can come to."""

    arrivals: list[Arrival]
    steps: int
    needs: Needs


class Courses:
    """What has come of one happening, of the mission's own keys whatever there was."""

    __slots__ = ("ways", "whole")

    def __init__(self) -> None:
        self.whole: list[Course] = []
        self.ways: dict[tuple[int, ...], list[Made]] = {}
        """What is chosen before the first alternative always is → the ways that went so."""

    def course(self, own: Own) -> Course | None:
        """All that it comes to where so much stands under the mission's own keys, if it is known whole."""
        for each in self.whole:
            if _fits(each.needs, own):
                return each
        return None

    def known(self, chosen: tuple[int, ...], own: Own) -> Made | None:
        """The way that it goes there, when so much is chosen, if it is known."""
        for each in self.ways.get(chosen, ()):
            if _fits(each.needs, own):
                return each
        return None


def _fits(needs: Needs, own: Own) -> bool:
    """Whether all this happens where so much stands under the mission's own keys."""
    for key, value in needs:
        entry = own.get(key)
        if (None if entry is None else entry.value) != value:
            return False
    return True


def value_of(own: Own, key: str) -> Any:
    entry = own.get(key)
    return None if entry is None else entry.value
