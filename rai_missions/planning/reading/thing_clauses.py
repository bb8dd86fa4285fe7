# SPDX-License-Identifier: Apache-2.0
"""Clauses that begin with the things: `NOUNS relation NOUN`, `NOUNS: NOUN`, `NOUNS stay`."""

from __future__ import annotations

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.noun_phrases import (
    PREDICATES,
    Cursor,
    noun_phrase,
    noun_phrases,
    ordered_phrases,
    with_limits,
)
from rai_missions.planning.reading.phrases import Clause, ClauseKind, Phrase
from rai_missions.planning.reading.places import gap, has_place, place, shift
from rai_missions.planning.reading.row_words import row_of, sides_of
from rai_missions.planning.reading.symbols import BETWEEN
from rai_missions.planning.reading.towers import is_tower, levels_of, tower

__all__ = ("MUTUAL", "NEAR_IT", "THOSE", "ThingClauses", "swaps")

NAMED = (":", "=")
"""Signs between a container and what is to be in it."""
MUTUAL: dict[str, ClauseKind] = {
    "stack": "stack", "next_to": "side_by_side", "group": "group", "apart": "spread", "swap": "swap", "row": "row",
}  # fmt: skip
SIDES = frozenset({"left_of", "right_of", "behind", "in_front_of"})
"""Relations that may have a gap."""
NEAR_IT = SIDES | {"under", "next_to", "between"}
"""After a verb of grasping these may as well mean where the thing is now: `take the cube under the apple`."""
CHAINED = SIDES | {"on", "next_to"}
"""Relations of which one follows another: `red on blue on green`."""
THOSE = (Phrase("those", ""),)


class ThingClauses:
    """The rules of a clause that begins with the things.

    Args:
        cursor: At the first symbol of a clause.
        lexicon: For what is asked back.
    """

    def __init__(self, cursor: Cursor, lexicon: Vocabulary) -> None:
        self.cursor = cursor
        self.lexicon = lexicon
        self._gap: float | None = None
        self._before: ClauseKind | None = None

    def _things(self) -> tuple[Phrase, ...]:
        """The phrases that must be here."""
        found = noun_phrases(self.cursor)
        if not found:
            raise self.lexicon.unread()
        return found

    def _members(self) -> tuple[Phrase, ...]:
        """The phrases that must be here, without the one of which the next wish is: `bin A and B, C stays`."""
        begun, found = self.cursor.at, self._things()
        if len(found) > 1 and self.cursor.kind() in PREDICATES:
            self.cursor.back_to(begun)
            return noun_phrases(self.cursor, most=len(found) - 1)
        return found

    def _thing(self) -> Phrase:
        """The one phrase that must be here; `the tower` is one where something is put."""
        found = noun_phrase(self.cursor)
        is_named = self.cursor.kind(1) in ("stack", "tower") and self.cursor.skip("the")
        if found is None and (is_named or self.cursor.kind() == "tower"):
            return Phrase("tower", self.cursor.take().text)
        if found is None:
            raise self.lexicon.unread()
        return found

    def _is_after(self, verb: str) -> bool:
        """Whether a verb of putting of some kind came before."""
        before = self.cursor.symbols[: self.cursor.at]
        return any(each.kind == "put" and each.value == verb for each in before)

    def _about(self, subjects: tuple[Phrase, ...], *, is_held: bool) -> list[Clause]:
        cursor = self.cursor
        self._skip_all()
        cursor.skip("put")
        if subjects[-1].kind == "there" or any(each.kind == "desk" for each in subjects):
            raise self.lexicon.unread()
        short = (sides_of, self._contents, self._listed_in, self._stays, self._by_word)
        if cursor.kind() == ":" and cursor.kind(1) in ("axis", "(", "each_other", "swap", "relation"):
            cursor.take()
        if found := next(filter(None, (rule(subjects) for rule in short)), None):
            return [found]
        if cursor.kind() == "level" or is_tower(cursor):
            return self._tower_of(subjects)
        if cursor.kind() == "empty" and len(subjects) == 1:
            return self._emptied(cursor.take().text, subjects)  # `räum das Tablett leer`
        if cursor.kind() == "left_to_right":
            return self._in_order(subjects)
        if has_place(cursor):
            if (metres := self._shift()) is not None:
                is_open = not self._is_after("shift") and cursor.value() != "shift"
                return [Clause("shift", subjects, x=metres[0], y=metres[1], is_open=is_open)]
            x, y = place(cursor, self.lexicon)
            return [Clause("at", subjects, x=x, y=y)]
        if cursor.kind() == "," and cursor.kind(1) == "relation":
            cursor.take()  # `lass ihn, wo er ist`
        if cursor.kind() in ("relation", "number", "gap"):
            return self._related(subjects)
        if cursor.kind() in ("", ":", *BETWEEN) and (is_held or self._is_after("line")):
            return [Clause("held", subjects) if is_held else row_of(cursor, subjects)]  # `line up the cubes`
        raise self.lexicon.unread()

    def _shift(self) -> tuple[float, float] | None:
        """How far from where it is a thing is moved; None where the words after it are a place.

        Raises:
            Unread: `Move it 30 cm ahead and 10 cm to the left` may be both; `to 30 cm ahead` is a place.
        """
        cursor = self.cursor
        if cursor.kind() != "number" or cursor.kind(1) != "side":
            return None
        if (metres := shift(cursor, self.lexicon)) is None and self._is_after("shift"):
            raise self.lexicon.unread("coordinates")
        return metres

    def _is_on_top(self) -> bool:
        """Whether `on top` alone ends a wish after one of stacking: `red on blue, and green on top`."""
        is_top = self.cursor.kind() == "level" and self.cursor.value() == "top"
        return is_top and self.cursor.kind(1) in ("", *BETWEEN) and self._before in ("on", "stack", "under")

    def _contents(self, subjects: tuple[Phrase, ...]) -> Clause | None:
        """`The tray should hold the cubes`, `tray: the cubes`; None where nothing of that is here."""
        cursor, begun = self.cursor, self.cursor.at
        if len(subjects) == 1 and subjects[0].is_container:
            is_listed = cursor.skip("holds") or cursor.skip(*NAMED)
            found = self._members() if is_listed else noun_phrases(cursor)
            if found and (is_listed or cursor.skip("holds")):  # `das Tablett soll die Würfel enthalten`
                cursor.skip("there")
                return Clause("in", found, subjects[0])
        cursor.back_to(begun)
        return None

    def _listed_in(self, subjects: tuple[Phrase, ...]) -> Clause | None:
        """`Cubes: tray`; `cubes, tray` is offered. None where nothing of that is here."""
        cursor, begun = self.cursor, self.cursor.at
        target = noun_phrase(cursor) if cursor.skip(*NAMED) else None
        is_open = target is None and len(subjects) > 1 and self._is_comma_before(subjects[-1])
        if is_open:
            *subjects_before, target = subjects
            subjects = tuple(subjects_before)
        is_whole = target is not None and target.is_container and cursor.kind() in ("", *BETWEEN)
        if is_whole and not any(each.is_container for each in subjects):
            return Clause("in", subjects, target, is_open=is_open)
        cursor.back_to(begun)
        return None

    def _is_comma_before(self, last: Phrase) -> bool:
        """Whether the last phrase, which ends here, comes after a comma."""
        return self.cursor.kind(-len(last.text.split()) - 1) == ","

    def _stays(self, subjects: tuple[Phrase, ...]) -> Clause | None:
        """`The cubes stay`, `… stay where they are`; None where they do not."""
        if not self.cursor.skip("stays"):
            return None
        is_where = self.cursor.kind() == "relation" and self.cursor.value() == "place_of"
        return self._related(subjects)[0] if is_where else Clause("stay", subjects)

    def _skip_all(self) -> None:
        """Past a word that repeats that all are meant: `the red and the blue cube, both on the tray`."""
        cursor = self.cursor
        comma = int(cursor.kind() == ",")
        if cursor.kind() == "too" and (cursor.kind(1) in PREDICATES or cursor.kind(2) == "relation"):
            cursor.skip("too", ",")  # `the carrot too, into the tray`
        if cursor.kind(comma) == "all" and cursor.kind(comma + 1) in ("put", "relation", "there", "each_other"):
            cursor.skip(",", "all")

    def _by_word(self, subjects: tuple[Phrase, ...]) -> Clause | None:
        """What one word after the things makes of them: `… together`, `… too`, `… by colour`; None where none is."""
        if self._is_on_top():
            return Clause("on", subjects, Phrase("top", self.cursor.take().text))
        if self.cursor.kind() == "too":
            return Clause("too", subjects)
        if self.cursor.kind() not in ("there", "each_other", "swap", "by"):
            return None
        word = self.cursor.take()
        if word.kind == "there":
            return Clause("too", subjects, Phrase("there", word.text))
        while word.kind == "each_other" == self.cursor.kind() and self.cursor.value() == word.value:
            self.cursor.take()
        if word.kind == "each_other":
            self.cursor.skip(word.value)  # `aufeinander stapeln`
        base = self._base(word.value)
        if (word.kind, word.value) == ("each_other", "stack") and base is None:
            members, levels = levels_of(subjects, self.cursor, self.lexicon)
            return Clause("stack", members, levels=levels)
        if word.kind == "by":
            return Clause("by", subjects, by=word.value)
        if "swap" in (word.kind, word.value):
            return swaps(self.cursor, subjects)[0]  # `red should trade places with blue`
        if word.value == "unstack":
            return Clause("unstack", subjects)
        if word.kind == "each_other":
            is_row = word.value == "row" or (word.value == "next_to" and self._is_after("line"))
            return row_of(self.cursor, subjects) if is_row else Clause(MUTUAL[word.value], subjects, base)
        return Clause("too", subjects)

    def _base(self, word: str) -> Phrase | None:
        """What a tower stands on: `… on top of each other in the tray`."""
        if word != "stack" or self.cursor.kind() != "relation" or self.cursor.value() not in ("on", "in"):
            return None
        self.cursor.take()
        return noun_phrase(self.cursor)

    def _tower_of(self, subjects: tuple[Phrase, ...]) -> list[Clause]:
        is_named = self.cursor.kind() != "level"
        found = tower(self.cursor, self.lexicon, subjects)
        if not is_named and len(found[0].levels) < 2:
            raise self.lexicon.unread()  # on top of what?
        return found

    def _related(self, subjects: tuple[Phrase, ...]) -> list[Clause]:
        cursor = self.cursor
        gap_m, self._gap = (self._gap, None) if self._gap is not None else (gap(cursor, self.lexicon), None)
        cursor.skip("with")
        if cursor.kind() != "relation":
            raise self.lexicon.unread()
        relation: ClauseKind = cursor.take().value
        if relation == "to" and has_place(cursor):
            x, y = place(cursor, self.lexicon)
            return [Clause("at", subjects, x=x, y=y)]
        if gap_m is None and (placed := self._placed(relation, subjects)) is not None:
            return [placed]
        target = self._reference(relation)
        if relation == "place_of":
            cursor.skip("is")
        cursor.skip("put")
        if cursor.kind() == "," and cursor.kind(1) == "number" and cursor.kind(2) == "gap":
            cursor.take()
        if gap_m is None and cursor.kind() in ("gap", "with", "number"):
            gap_m = gap(cursor, self.lexicon)
        if gap_m is not None and relation not in SIDES:
            raise self.lexicon.unread()
        if relation == "in" and cursor.kind() == "with":
            cursor.take()
            subjects += noun_phrases(cursor) or ()
        subjects = (*subjects[:-1], with_limits(cursor, subjects[-1]))
        first = Clause(relation, subjects, target, gap_m=gap_m)
        if relation in CHAINED and cursor.kind() == "relation" and cursor.value() == relation:
            if target.others:
                raise self.lexicon.unread()  # `red on blue or green on yellow` is no chain
            return [first, *self._related((target,))]
        if relation == "off" and (cursor.kind() == "relation" or has_place(cursor)):
            return [first, *self._about(THOSE, is_held=False)]  # `the apple from the tray to the bin`
        return [first]

    def _reference(self, relation: ClauseKind) -> Phrase:
        """What a relation is to, which must be here.

        Raises:
            Unread: It is a side of the desk.
        """
        target = self._thing()
        if target.kind == "desk" and relation in NEAR_IT:
            raise self.lexicon.unread("coordinates")
        if self.cursor.kind() == "there" and self.cursor.kind(1) in ("", "put", *BETWEEN):
            self.cursor.take()  # `auf den blauen drauf`
        return target

    def _ends(self) -> tuple[Phrase, ...]:
        """The two that a thing is to be between: `the red and the blue cube`, `both apples`."""
        found = noun_phrases(self.cursor, most=2)
        if not found or (len(found) == 1 and not (found[0].is_many or found[0].count == 2)):
            raise self.lexicon.unread()
        return found

    def _placed(self, relation: ClauseKind, subjects: tuple[Phrase, ...]) -> Clause | None:
        """`Between A and B`, `where it is`; None where the relation is to one thing, which is here."""
        cursor = self.cursor
        if relation == "between":
            return Clause(relation, subjects, ends=self._ends())
        is_it = relation == "place_of" and cursor.kind() == "pronoun" and cursor.kind(1) == "is"
        if not is_it or cursor.symbols[cursor.at + 1].value != "now":
            return None
        cursor.skip("pronoun", "is")
        return Clause("stay", subjects)

    def _emptied(self, word: str, targets: tuple[Phrase, ...]) -> list[Clause]:
        """All that lies in a container comes out of it; `… into the bin` names where it goes."""
        if not all(each.is_container for each in targets):
            raise self.lexicon.unread()
        self.cursor.skip("empty")
        every = Phrase("everything", word, is_many=True, is_all=True)
        *others, found = (Clause("off", (every,), target) for target in targets)
        if others:
            return [*others, found]
        is_moved = self.cursor.kind() == "relation" and self.cursor.value() in ("in", "on", "to")
        return [found, *self._about(THOSE, is_held=False)] if is_moved else [found]

    def _in_order(self, whole: tuple[Phrase, ...] = ()) -> list[Clause]:
        cursor = self.cursor
        is_from_left = cursor.take().value == "left"
        subjects = ordered_phrases(cursor)
        if not subjects and len(whole) > 1:
            subjects, whole = whole, ()
        if whole and whole[0].kind == "pronoun":
            whole = ()  # `line them up from left to right: …`
        if len(subjects) < 2 or len(whole) > 1:
            raise self.lexicon.unread("order")
        subjects = subjects if is_from_left else subjects[::-1]
        return [Clause("in_order", subjects, whole[0] if whole else None)]


def swaps(cursor: Cursor, subjects: tuple[Phrase, ...]) -> list[Clause]:
    """The exchanges that begin with these things: `swap red with blue, and green with yellow`.

    Args:
        cursor: Past the things.
        subjects: Both, or the first of them.
    """
    if not cursor.skip("with", "for"):
        return [Clause("swap", subjects)]
    found = [Clause("swap", subjects + noun_phrases(cursor, most=1))]
    begun = cursor.at
    while cursor.skip(",", "and", "then"):
        one = noun_phrases(cursor, most=1)
        other = noun_phrases(cursor, most=1) if one and cursor.skip("with", "for") else ()
        if not other:
            break
        found.append(Clause("swap", one + other))
        begun = cursor.at
    cursor.back_to(begun)
    return found
