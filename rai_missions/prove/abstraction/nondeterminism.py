# SPDX-License-Identifier: Apache-2.0
"""What is not decided by rules, chosen when it is first looked at, and chosen otherwise the next time.

Rule: a step that is made again with the same choices is the same step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from rai_missions.keys import Stamped
from rai_missions.prove.analysis.counts import Count

__all__ = ("MISSING", "AnyOf", "Choices", "OpenBoard", "OpenFields", "Payload")

MISSING: Any = object()
_get = dict.get


class Choices:
    """Goes through every way in which a step can be chosen, the first alternatives first."""

    def __init__(self) -> None:
        self._trail: list[int] = []
        self._sizes: list[int] = []
        self._at = 0
        self._first: dict[str, tuple[int, ...]] = {}
        """Place within a step → what the first way that came to it had chosen by then."""
        self.rests_on_others = False
        """The way in hand has left out what another way tries."""

    def forget_ways(self) -> None:
        """Forget the ways that were gone: something else happens, or in another state."""
        self._first.clear()

    def is_first_at(self, place: str) -> bool:
        """Whether no other way has come to a place: what can follow is tried on the first way to it."""
        trail = self.trail
        first = self._first.setdefault(place, trail)
        is_first = trail[: len(first)] == first
        self.rests_on_others |= not is_first
        return is_first

    def begin(self, trail: Sequence[int] = ()) -> None:
        """Start with the first way, or along a given one."""
        self._trail, self._sizes, self._at = list(trail), [0] * len(trail), 0
        self.rests_on_others = False

    def choose(self, many: int) -> int:
        """One of so many alternatives."""
        if self._at == len(self._trail):
            self._trail.append(0)
            self._sizes.append(many)
        self._sizes[self._at] = many
        self._at += 1
        return self._trail[self._at - 1]

    def pick(self, alternatives: Sequence[Any]) -> Any:
        """One of these."""
        return alternatives[0] if len(alternatives) == 1 else alternatives[self.choose(len(alternatives))]

    @property
    def trail(self) -> tuple[int, ...]:
        """What was chosen since `begin`."""
        return tuple(self._trail[: self._at])

    def next(self) -> tuple[int, ...] | None:
        """What to `begin` with to go the next way; None where each was gone."""
        for at in range(self._at - 1, -1, -1):
            if self._trail[at] + 1 < self._sizes[at]:
                return (*self._trail[:at], self._trail[at] + 1)
        return None


class OpenFields(dict[str, Any]):
    """An object whose fields have any of their values until someone looks; None is unknown.

    Args:
        fields: The fields that anybody looks at.
        values: The values of a field; None for unknown.
        pick: Chooses one of several.
    """

    def __init__(
        self, fields: Sequence[str], values: Callable[[str], Sequence[Any]], pick: Callable[[Sequence[Any]], Any]
    ) -> None:
        super().__init__()
        self.fields, self._values, self._pick = fields, values, pick
        self.looked: set[str] = set()
        """The fields that were looked at since this was last emptied."""

    def get(self, field: str, default: Any = None) -> Any:
        self.looked.add(field)
        if not dict.__contains__(self, field) and field in self.fields:
            self[field] = self._pick(self._values(field))
        found = dict.get(self, field)
        return default if found is None else found

    def fresh(self, known: Mapping[str, Any] | None = None) -> OpenFields:
        """A new one of this kind, of which this much is known."""
        made = OpenFields(self.fields, self._values, self._pick)
        made.update(self if known is None else known)
        return made

    def mixtures(self) -> Iterator[OpenFields]:
        """What it can be besides, as far as anybody has looked; in one order, whatever was looked at first."""
        known = sorted(self)
        for mixture in product(*map(self._values, known)):
            yield self.fresh(dict(zip(known, mixture, strict=True)))

    def example(self) -> dict[str, Any]:
        """One value that it can be, as plain data."""
        return {field: value for field, value in self.items() if value is not None}

    def words(self) -> str:
        """What is known of it."""
        return str(dict(self))

    def whole(self) -> dict[str, Any]:
        """All that anybody can find out of it, as it is from now on."""
        found = ((field, self.get(field)) for field in self.fields)
        return {field: value for field, value in found if value is not None}


class Payload(dict[str, Any]):
    """What an event or an answer brings, chosen field by field when someone looks; a copy is a look at all.

    Args:
        fields: Those that anybody looks at.
        choose: A field's value; None where it is left out.
    """

    def __init__(self, fields: Sequence[str], choose: Callable[[str], Any]) -> None:
        super().__init__()
        self.fields, self._choose = fields, choose

    def get(self, field: str, default: Any = None) -> Any:
        if field not in self and field in self.fields:
            self[field] = self._choose(field)
        return dict.get(self, field, default)

    def __missing__(self, field: str) -> Any:
        if self.get(field) is None:
            raise KeyError(field)
        return self.get(field)

    def keys(self) -> Any:
        return self.whole().keys()

    def __iter__(self) -> Iterator[str]:  # `dict(payload)` asks for the keys only where this is not dict's own
        return iter(self.whole())

    def known(self) -> dict[str, Any]:
        """What is chosen of it."""
        return {field: value for field, value in self.items() if value is not None}

    def whole(self) -> dict[str, Any]:
        """All of it, as it is from now on."""
        for field in self.fields:
            self.get(field)
        return self.known()


class AnyOf(tuple[Any, ...]):
    """The values of which a key has one, in a saved state."""

    __slots__ = ()


class AskedBoard(dict[str, Any]):
    """A blackboard whose `get` answers for every way to look up one key."""

    def __getitem__(self, key: str) -> Any:
        found = self.get(key)
        if found is None:
            raise KeyError(key)
        return found

    def __contains__(self, key: object) -> bool:
        return self.get(str(key)) is not None


class OpenBoard(AskedBoard):
    """A blackboard on which a key has any of its values until someone looks; None is unknown.

    Args:
        open_keys: The keys that are to be chosen where they have no entry here.
        choose: A key's value; None for unknown.
        at: The stamp of what is chosen.
    """

    def __init__(self, open_keys: Iterable[str], choose: Callable[[str], Any], at: float) -> None:
        super().__init__()
        self.open_keys, self._choose, self._at = frozenset(open_keys), choose, at
        self.looked: set[str] = set()
        """The keys that were looked at since this was last emptied."""
        self.replaced: set[str] = set()
        """The keys that were written since this was last emptied, and had not been looked at before."""
        self.counters = frozenset[str]()
        """Of numbers that are counted it is noted what had been added to them at each look."""
        self.counted: set[tuple[str, int]] = set()
        self._shared = frozenset[str]()
        """Keys that keep the open objects that are written there."""
        self.among: dict[str, AnyOf] = {}
        """Key → the values of which it has one, until someone looks or it is written; None is unknown."""

    def get(self, key: str, default: Any = None) -> Any:
        found = _get(self, key, MISSING)
        self.looked.add(key)
        if key in self.counters:
            self._count_look(key, found)
        if found is MISSING:
            if key not in self.open_keys and key not in self.among:
                return default
            value = self._choose(key)
            found = None if value is None else Stamped(value, self._at)
            dict.__setitem__(self, key, found)
        return default if found is None else found

    def copy(self) -> dict[str, Any]:
        """A board to write on; what is looked at there and not written is chosen here, as long as this one is open."""
        return WrittenBoard(self)

    def count(self, keys: Iterable[str]) -> None:
        """Note the keys that hold numbers which are counted."""
        self.counters = frozenset(keys)

    def share(self, keys: Iterable[str]) -> None:
        """Have keys keep the open objects that are written there: what is found out of one is known of both."""
        self._shared = frozenset(keys)

    def note(self, key: str, found: Any) -> None:
        """A key was looked at, and this is its entry; `MISSING` where it was not looked at before."""
        self.looked.add(key)
        if key in self.counters:
            self._count_look(key, found)

    def _count_look(self, key: str, found: Any) -> None:
        if found is MISSING or found is None:
            self.counted.add((key, 0))
        elif found[0].__class__ is Count:
            self.counted.add((key, found[0].added))

    def known(self, key: str) -> Any:
        """The entry of a key as far as it was looked at; None before that, and for unknown."""
        return self._any_of(key) if key in self.among else dict.get(self, key)

    def is_known(self, key: str) -> bool:
        """Whether someone has looked, or the mission wrote it."""
        return key in self.among or dict.__contains__(self, key)

    def entries(self) -> Iterable[tuple[str, Any]]:
        """What is known; None is unknown."""
        if not self.among:
            return dict.items(self)
        return [*dict.items(self), *((key, self._any_of(key)) for key in self.among)]

    def _any_of(self, key: str) -> Stamped:
        return Stamped(self.among[key], self._at)

    def items(self) -> Any:
        """What is known and not unknown; nothing is chosen."""
        return [(key, entry) for key, entry in dict.items(self) if entry is not None]

    def put(self, key: str, entry: Stamped | None) -> None:
        """Have it so, None for unknown."""
        self.among.pop(key, None)
        dict.__setitem__(self, key, entry)

    def leave(self, key: str, values: Iterable[Any]) -> None:
        """Have a key be one of several values, whichever is found when someone looks."""
        values = AnyOf(values)
        self.put(key, None if values[0] is None else Stamped(values[0], self._at))
        if len(values) > 1:
            dict.pop(self, key)
            self.among[key] = values

    def forget(self, key: str) -> None:
        """Have a key be anything, until someone looks."""
        self.among.pop(key, None)
        dict.pop(self, key, None)

    def refill(self, entries: Mapping[str, Any], others: Mapping[str, Any] = {}) -> None:
        """Have these and no others; objects become its own."""
        dict.clear(self)
        self.among.clear()
        dict.update(self, others)
        dict.update(self, entries)
        for key, entry in entries.items():
            if entry is not None and entry.__class__ is Stamped:
                value = entry[0]
                if value.__class__ is AnyOf:
                    self.leave(key, value)
                elif isinstance(value, OpenFields):
                    dict.__setitem__(self, key, Stamped(value.fresh(), self._at))

    def __setitem__(self, key: str, entry: Any) -> None:
        if key in self._shared:  # a history may bring the very item back that is there: what is known of it stays
            self.looked.add(key)
        if key not in self.looked:
            self.replaced.add(key)
        self.among.pop(key, None)
        value = entry[0]
        is_shared = key in self.open_keys or key in self._shared
        if isinstance(value, OpenFields) and not is_shared:  # a copy keeps what the original changes
            entry = Stamped(value.whole(), self._at)
        dict.__setitem__(self, key, entry)


class WrittenBoard(AskedBoard):
    """What was written over an open board; everything else is looked up there.

    Args:
        board: The board below; it takes note of what is looked at, also of what is written here.
    """

    def __init__(self, board: OpenBoard) -> None:
        super().__init__()
        self._board = board

    def get(self, key: str, default: Any = None) -> Any:
        found = _get(self, key, MISSING)
        if found is MISSING:
            return self._board.get(key, default)
        self._board.note(key, found)
        return found
