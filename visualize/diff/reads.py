# SPDX-License-Identifier: Apache-2.0
"""What a mission reads and receives, and so which of its effects matter to more than a reader.

Rule: an effect matters where it writes a key that is read anywhere, raises or takes back an event that a transition
receives, or has the robot do something. A sentence that is reported or logged does not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import chain
from typing import NamedTuple

from rai_missions.mission.mission import Mission
from rai_missions.model.references import INTERFACES
from rai_missions.states import Transition
from rai_missions.states.effects import Effect, Raise
from rai_missions.states.transition import ANY_EVENT
from visualize.parts import parts

__all__ = ("Uses", "otherwise", "uses")


class Uses(NamedTuple):
    """What is read and received in either of two missions."""

    keys: frozenset[str]
    received: frozenset[str]
    """Events and outcomes that transitions name."""
    timers: Mapping[str, frozenset[str]]
    """What `drop` calls a delayed event by → the events that it may be."""

    def matter(self, given: Iterable[Effect]) -> list[str]:
        """Why effects matter, in words; nothing where none does."""
        return [why for effect in given if (why := self._why(effect))]

    def _why(self, effect: Effect) -> str:
        names = [(refers.sort, name) for refers, name, _ in effect.references()]
        if any(sort in INTERFACES for sort, _ in names):
            return "it is sent to the robot"
        if key := next((write.key for write in effect.writes() if write.key in self.keys), ""):
            return f"'{key}' is read"
        events = {name for sort, name in names if sort == "event"}
        events = events or {event for sort, name in names if sort == "timer" for event in self.timers.get(name, ())}
        received = events if ANY_EVENT in self.received else self.received & events
        return f"transitions receive '{min(received)}'" if received else ""


def otherwise(old: Iterable[Effect], new: Iterable[Effect]) -> list[Effect]:
    """The effects that came or went; all of them where only their order is another."""
    before, after = tuple(old), tuple(new)
    left, right = (Counter(map(repr, each)) for each in (before, after))
    found = [effect for effect in before if right[repr(effect)] < left[repr(effect)]]
    found += [effect for effect in after if left[repr(effect)] < right[repr(effect)]]
    return found or (list(after) if before != after else [])


def uses(*missions: Mission) -> Uses:
    """What these missions read and receive."""
    keys, received = set[str](), set[str]()
    timers: dict[str, frozenset[str]] = {}
    things = (each for mission in missions for each in (mission, *(state for _, _, state in mission.walk())))
    for _, item in chain.from_iterable(map(parts, things)):
        paths = (name for refers, name, _ in item.references() if refers.sort == "path")
        keys.update(name.partition(".")[0] for name in paths)
        if isinstance(item, Transition):
            received.update(item.on)
        if isinstance(item, Raise) and item.id is not None:
            timers[item.id] = timers.get(item.id, frozenset()) | {item.event}
    return Uses(frozenset(keys), frozenset(received), timers)
