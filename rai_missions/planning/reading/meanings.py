# SPDX-License-Identifier: Apache-2.0
"""Which things the phrases of a request mean, clause after clause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.planning.reading.phrases import Clause, Phrase
from rai_missions.planning.reading.picks import Picks
from rai_missions.planning.reading.things import Names, Things

__all__ = ("Meanings",)

SIDE_BY_SIDE = frozenset({
    "left_of", "right_of", "behind", "in_front_of", "between", "next_to", "apart", "swap", "place_of",
})  # fmt: skip
"""Kinds of clauses after which `it` may be either thing."""


class Meanings:
    """What the phrases mean, for one choice among what they may mean; `it`, `those` and `there` lean on what was said.

    Args:
        things: The things of the scene.
        picks: The choices.

    Attributes:
        subjects: What the latest clause moves.
        target: What the latest clause relates that to; more than one thing where a clause has two ends.
    """

    def __init__(self, things: Things, picks: Picks) -> None:
        self._things = things
        self._picks = picks
        self._clause: Clause | None = None
        self._last: Clause | None = None
        self.subjects: Names = ()
        self.target: Names = ()
        self._before: tuple[Names, Names] = (), ()
        self._wanted: Sequence[Mapping[str, Any]] = ()
        self._taken = set[str]()
        """What the phrases so far are taken to mean."""

    def begin(self, clause: Clause, wanted: Sequence[Mapping[str, Any]]) -> None:
        """The next clause; it leans on the one before, or on the one that this repeats: `and the apple too`.

        Args:
            clause: This one.
            wanted: The predicates of those before.
        """
        if self._clause is not None and self._clause.kind != "too":
            self._last = self._clause
        self._clause = clause
        self._before, self._wanted = (self.subjects, self.target), wanted

    def note(self, *, subjects: Names | None = None, target: Names | None = None) -> None:
        """What the present clause is about, where that is not what its phrases mean."""
        self.subjects = self.subjects if subjects is None else subjects
        self.target = self.target if target is None else target

    @property
    def last_kind(self) -> str:
        """The kind of the clause that the present one leans on; empty in the first."""
        return "" if self._last is None else self._last.kind

    @property
    def container(self) -> str:
        """The container that the latest clause is about; empty if it is about none."""
        return self._container(self.target)

    @property
    def tower_top(self) -> Names:
        """What is wanted at the top of the tower of what the clause before moved; nothing where it moved nothing."""
        names = self._before[0][-1:]
        above = {each["on"][1]: each["on"][0] for each in self._wanted if "on" in each}
        while names and names[0] in above:
            names = (above.pop(names[0]),)
        return names

    def names(self, phrases: Sequence[Phrase], target: Phrase | None = None) -> Names:
        """The subjects of the present clause; `everything` is not what they are related to."""
        found = [name for phrase in phrases for name in self.take(phrase)]
        if any(phrase.kind == "everything" for phrase in phrases) and target is not None:
            found = [name for name in found if name not in self._things.alternatives(target)[0]]
        self.subjects = tuple(dict.fromkeys(found))
        return self.subjects

    def one(self, phrase: Phrase | None) -> str:
        """The target of the present clause.

        Raises:
            Unread: It is not one thing.
        """
        emptied = self._emptied if phrase is not None and phrase.kind == "pronoun" and not phrase.is_many else ""
        names = (emptied,) if emptied else (self.take(phrase) if phrase is not None else ())
        if len(names) != 1:
            raise self._things.ask("unread")
        self.target = names
        return names[0]

    def pair(self, clause: Clause) -> tuple[Names, str]:
        """The things of a clause, and the one that they are related to."""
        return self.names(clause.subjects, clause.target), self.one(clause.target)

    def take(self, phrase: Phrase) -> Names:
        """What a phrase means; `the rest` after it is none of it."""
        names = self.of(phrase)
        if phrase.kind == "things" and not phrase.is_other:
            self._taken |= set(names)
        return names

    def of(self, phrase: Phrase) -> Names:
        """What a phrase means, and may mean again."""
        return self._picks.one(self.alternatives(phrase))

    def alternatives(self, phrase: Phrase) -> Sequence[Names]:
        """All that a phrase may mean here.

        Raises:
            Unread: It leans on what was not said, or means nothing that is seen.
        """
        if phrase.kind not in ("pronoun", "those", "there", "top"):
            return self._things.alternatives(phrase, frozenset(self._taken))
        subjects, target = self._before
        if phrase.kind == "top":
            return (self.tower_top,)
        if phrase.kind == "those" or (phrase.kind == "pronoun" and self._is_taken(phrase)):
            return (subjects,)
        if phrase.kind == "there" and target:
            return (target,)
        if not subjects or phrase.kind == "there" or (len(subjects) > 1) != phrase.is_many:
            raise self._things.ask("pronoun", phrase.text)
        may_be_target = len(target) > 1 if phrase.is_many else len(target) == 1
        if self.last_kind in SIDE_BY_SIDE and may_be_target and target != subjects:
            return (subjects, target)
        return (subjects,)

    @property
    def _emptied(self) -> str:
        """The container that `it` is, as where something goes: `empty the tray and put the carrot in it`."""
        return self._container(self._before[1]) if self._is_everything_off else ""

    @property
    def _is_everything_off(self) -> bool:
        last = self._last
        return last is not None and last.kind == "off" and any(each.kind == "everything" for each in last.subjects)

    def _is_taken(self, pronoun: Phrase) -> bool:
        """Whether what was taken from somewhere is meant, as many as they were: `take everything out and put it …`."""
        return self._is_everything_off or (self.last_kind == "off" and pronoun.is_many)

    def _container(self, names: Names) -> str:
        return names[0] if len(names) == 1 and self._things.is_container(names[0]) else ""
