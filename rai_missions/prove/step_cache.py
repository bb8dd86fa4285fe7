# SPDX-License-Identifier: Apache-2.0
"""What came of a happening, to be told again wherever it can only go the same way.

Rule: a way is told again where those of the mission's own keys that it looked at are what they were, and nowhere else.
"""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, TypeVar

from rai_missions.prove.loops import Loop
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.state_key import Own, Saved
from rai_missions.prove.stimulus import HappeningKind

__all__ = ("Arrival", "CachedStep", "Known", "Made", "Needs", "StepCache", "value_of")

Needs = tuple[tuple[str, Any], ...]
"""Those of the mission's own keys that were looked at, each with its value: with these, it happens again."""


class Arrival(NamedTuple):
    """What one step came to, but for those of the mission's own keys that it left alone."""

    way: Edge
    kind: HappeningKind
    has_moved: bool
    """A transition was taken, or a round of a tree's loop has ended that took time."""
    ended: tuple[str, str] | None
    """Outcome and why; None where the mission continues."""
    core: bytes = b""
    state: Saved | None = None
    written: Own | None = None
    telling: tuple[str, ...] = ()
    mode: str = ""
    levels: tuple[tuple[Loop, int, bytes], ...] = ()
    """Loops that run, how many of their rounds have ended, and the core but for this."""
    kept: frozenset[str] | None = None
    """Where time passes and the robot is silent: what waits for time on, and not from the beginning."""


class Made(NamedTuple):
    """One way in which a happening can go, as it was made."""

    arrival: Arrival | None
    """None where it goes against what is assumed of the robot."""
    needs: Needs
    after: tuple[int, ...] | None
    """What is to be chosen for the next way; None after the last."""


class CachedStep(NamedTuple):
    """All that one happening can come to."""

    arrivals: list[Arrival]
    steps: int
    needs: Needs


Kind = TypeVar("Kind")

MOST_KNOWN = 1_000
"""What is remembered of one happening, or of one way of it; a counter without end would fill the memory."""


class Known(Generic[Kind]):
    """What happens where certain keys have certain values: found by them, however many there are."""

    __slots__ = ("_by_keys", "_many")

    def __init__(self) -> None:
        self._by_keys: dict[tuple[str, ...], dict[tuple[Any, ...], Kind]] = {}
        self._many = 0

    def add(self, needs: Needs, what: Kind) -> None:
        """Remember it, unless a value is a list or an object, or much is known already."""
        if self._many >= MOST_KNOWN:
            return
        try:
            self._by_keys.setdefault(tuple([key for key, _ in needs]), {})[tuple([each for _, each in needs])] = what
        except TypeError:
            return
        self._many += 1

    def find(self, own: Own) -> Kind | None:
        """What happens where so much stands under the mission's own keys, if it is known."""
        for keys, found in self._by_keys.items():
            try:
                what = found.get(tuple([value_of(own, key) for key in keys]))
            except TypeError:
                continue
            if what is not None:
                return what
        return None


class StepCache:
    """What has come of one happening, of the mission's own keys whatever there was."""

    __slots__ = ("_ways", "_whole")

    def __init__(self) -> None:
        self._whole = Known[CachedStep]()
        self._ways: dict[tuple[int, ...], Known[Made]] = {}
        """What is chosen before the first alternative always is → the ways that went so."""

    def remember(self, course: CachedStep) -> None:
        """All that it came to."""
        self._whole.add(course.needs, course)

    def course(self, own: Own) -> CachedStep | None:
        """All that it comes to where so much stands under the mission's own keys, if it is known whole."""
        return self._whole.find(own)

    def remember_way(self, chosen: tuple[int, ...], made: Made) -> None:
        """The way that it went when so much was chosen."""
        self._ways.setdefault(chosen, Known()).add(made.needs, made)

    def known(self, chosen: tuple[int, ...], own: Own) -> Made | None:
        """The way that it goes there, when so much is chosen, if it is known."""
        ways = self._ways.get(chosen)
        return ways.find(own) if ways is not None else None


def value_of(own: Own, key: str) -> Any:
    entry = own.get(key)
    return None if entry is None else entry.value
