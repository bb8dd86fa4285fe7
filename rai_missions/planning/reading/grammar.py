# SPDX-License-Identifier: Apache-2.0
"""Clauses from symbols: each rule reads one form of a wish, `NOUNS relation NOUN`, `stack NOUNS`, `swap NOUNS`.

Rule: the clauses must account for every symbol; what is left over makes the whole request unread.
"""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.noun_phrases import (
    LISTED,
    Cursor,
    noun_phrase,
    noun_phrases,
    ordered_phrases,
    with_limits,
)
from rai_missions.planning.reading.phrases import Clause, ClauseKind, Phrase, Unread
from rai_missions.planning.reading.places import gap, has_place, place, shift
from rai_missions.planning.reading.symbols import Symbol
from rai_missions.planning.reading.towers import is_tower, skip_several, tower
from rai_missions.planning.scene import CONTAINERS

__all__ = ("clauses",)

BETWEEN = (",", ".", "and", "then")
MUTUAL: dict[str, ClauseKind] = {
    "stack": "stack", "next_to": "side_by_side", "group": "group", "apart": "spread", "swap": "swap", "row": "row",
}  # fmt: skip
SIDES = frozenset({"left_of", "right_of", "behind", "in_front_of"})
"""Relations that may have a gap."""
NEAR_IT = SIDES | {"under", "next_to", "between"}
"""After a verb of grasping these may as well mean where the thing is now: `take the cube under the apple`."""
BEFORE_NOUN = ("the", "a", "any", "colour", "noun")
WHERE = NEAR_IT | {"on", "in"}
THOSE = (Phrase("those", ""),)


def clauses(symbols: Sequence[Symbol], lexicon: Vocabulary) -> tuple[Clause, ...]:
    """The wishes of a request, in their order.

    Raises:
        Unread: A symbol belongs to no rule.
    """
    rules = Rules(Cursor(symbols), lexicon)
    found = list[Clause]()
    rules.cursor.skip(*BETWEEN, "put", "too")
    while rules.cursor.kind():
        found += rules.clause(found)
        if rules.cursor.kind() and not rules.cursor.skip(*BETWEEN):
            raise rules.unread()
        rules.cursor.skip(*BETWEEN, "put")
    if not found:
        raise rules.unread()
    rules.check_towers(found)
    return tuple(found)


class Rules:
    """The rules of a clause.

    Args:
        cursor: At its first symbol.
        lexicon: For what is asked back.
    """

    def __init__(self, cursor: Cursor, lexicon: Vocabulary) -> None:
        self.cursor = cursor
        self.lexicon = lexicon
        self._gap: float | None = None
        self._is_grasped_there = False
        self._towers = 0

    def check_towers(self, found: Sequence[Clause]) -> None:
        """`Two towers:` has as many wishes after it at least.

        Raises:
            Unread: It has fewer.
        """
        if sum(each.kind in ("on", "stack", "under") for each in found) < self._towers:
            raise Unread("order", self.lexicon.text("order"))

    def unread(self) -> Unread:
        """What is raised where no rule fits."""
        return Unread("unread", self.lexicon.text("unread"))

    def clause(self, before: Sequence[Clause]) -> list[Clause]:
        """The clauses of the rule that fits here.

        Args:
            before: The clauses already read.

        Raises:
            Unread: None fits.
        """
        cursor = self.cursor
        begun = cursor.at
        cursor.skip("put", "then", "too")
        if cursor.kind() == "by" and cursor.kind(1) == ":":
            cursor.skip("by", ":")  # `tidy by kind: cubes in the tray, food in the bin`
        is_too = any(each.kind == "too" for each in cursor.symbols[begun : cursor.at])
        if cursor.kind() == "reverse":
            return [self._reversed(before)]
        if is_tower(cursor):
            self._towers += skip_several(cursor)
        if is_tower(cursor) or (cursor.kind() == "level" and cursor.kind(1) in BEFORE_NOUN):
            return self._after(tower(cursor, self.lexicon, self.unread))
        rule = {
            "swap": self._swap, "group": self._group, "apart": self._spread, "sort": self._sort, "gap": self._gap_first,
            "relation": self._relation_first, "left_to_right": self._in_order,
            "into": self._into, "each_other": self._each_other, "fill": self._fill,
            "empty": self._empty, "unstack": self._unstack,
        }.get("into" if self._is_verb_of_place() else cursor.kind())  # fmt: skip
        if rule is not None:
            return self._after(rule())
        is_held = cursor.skip("grasp")
        subjects = self._things()
        if is_too and before and cursor.kind() in ("", *BETWEEN):
            return [Clause("too", subjects)]  # `…, and so should the apple`
        found = self._about(subjects, is_held=is_held)
        self._check_grasped(found[0], is_held=is_held)
        return self._after(found)

    def _things(self) -> tuple[Phrase, ...]:
        """The phrases that must be here."""
        found = noun_phrases(self.cursor)
        if not found:
            raise self.unread()
        return found

    def _thing(self) -> Phrase:
        """The one phrase that must be here; `the tower` is one where something is put."""
        found = noun_phrase(self.cursor)
        if found is None and self.cursor.kind(1) == "stack" and self.cursor.skip("the"):
            return Phrase("tower", self.cursor.take().text)
        if found is None:
            raise self.unread()
        return found

    def _check_grasped(self, found: Clause, *, is_held: bool) -> None:
        """Where something is grasped is no wish: `take the cube on the apple and put it …`."""
        is_there = is_held and found.kind in WHERE
        is_it = any(each.kind == "pronoun" for each in found.subjects)
        if (is_held and found.kind in NEAR_IT) or (self._is_grasped_there and is_it):
            raise self.unread()
        self._is_grasped_there = is_there

    def _after(self, found: list[Clause]) -> list[Clause]:
        self.cursor.skip("put", "too", "grasp", "sort")
        return found

    def _reversed(self, before: Sequence[Clause]) -> Clause:
        """`put A where B is and vice versa`."""
        last = before[-1] if before else None
        if last is None or last.kind != "place_of" or last.target is None or len(last.subjects) != 1:
            raise self.unread()
        self.cursor.take()
        return Clause("place_of", (last.target,), last.subjects[0])

    # -- clauses that begin with the things ----------------------------------------------------------------------------

    def _about(self, subjects: tuple[Phrase, ...], *, is_held: bool) -> list[Clause]:
        cursor = self.cursor
        self._skip_all()
        cursor.skip("put")
        if subjects[-1].kind == "there" or any(each.kind == "desk" for each in subjects):
            raise self.unread()
        if cursor.kind() in ("there", "too", "each_other", "swap", "by"):
            return [self._by_word(subjects)]
        if cursor.kind() in ("stack", "level"):
            return self._tower_of(subjects)
        if cursor.kind() == "empty" and len(subjects) == 1:
            return self._emptied(cursor.take().text, subjects)  # `räum das Tablett leer`
        if cursor.kind() == "left_to_right":
            return self._in_order(subjects)
        if cursor.kind() == ":" and cursor.kind(1) in ("axis", "("):
            cursor.take()
        if has_place(cursor):
            if (metres := self._shift()) is not None:
                return [Clause("shift", subjects, x=metres[0], y=metres[1])]
            x, y = place(cursor, self.lexicon)
            return [Clause("at", subjects, x=x, y=y)]
        if cursor.kind() == "," and cursor.kind(1) == "relation" and cursor.symbols[cursor.at + 1].value == "place_of":
            cursor.take()  # `lass ihn, wo er ist`
        if cursor.kind() in ("relation", "number", "gap"):
            return self._related(subjects)
        if cursor.kind() in ("", *BETWEEN) and (is_held or self._is_after("line")):
            return [Clause("held" if is_held else "row", subjects)]  # `line up the cubes`
        raise self.unread()

    def _shift(self) -> tuple[float, float] | None:
        """How far from where it is a thing is moved; None where the words after it are a place.

        Raises:
            Unread: `Move it 30 cm ahead and 10 cm to the left` may be both; `to 30 cm ahead` is a place.
        """
        cursor = self.cursor
        if not (self._is_after("shift") and cursor.kind() == "number" and cursor.kind(1) == "side"):
            return None
        if (metres := shift(cursor, self.lexicon)) is None:
            raise Unread("coordinates", self.lexicon.text("coordinates"))
        return metres

    def _is_after(self, verb: str) -> bool:
        """Whether a verb of putting of some kind came before."""
        before = self.cursor.symbols[: self.cursor.at]
        return any(each.kind == "put" and each.value == verb for each in before)

    def _skip_all(self) -> None:
        """Past a word that repeats that all are meant: `the red and the blue cube, both on the tray`."""
        cursor = self.cursor
        comma = int(cursor.kind() == ",")
        if cursor.kind(comma) == "all" and cursor.kind(comma + 1) in ("put", "relation", "there", "each_other"):
            cursor.skip(",", "all")

    def _by_word(self, subjects: tuple[Phrase, ...]) -> Clause:
        """What one word after the things makes of them: `… together`, `… too`, `… by colour`."""
        if self.cursor.kind() == "too":
            return Clause("too", subjects)
        word = self.cursor.take()
        if word.kind == "there":
            return Clause("too", subjects, Phrase("there", word.text))
        while word.kind == "each_other" == self.cursor.kind() and self.cursor.value() == word.value:
            self.cursor.take()
        if word.kind == "by":
            return Clause("by", subjects, by=word.value)
        if word.value == "unstack":
            return Clause("unstack", subjects)
        if word.kind == "each_other":
            return Clause(MUTUAL[word.value], subjects, self._base(word.value))
        return Clause("swap" if word.kind == "swap" else "too", subjects)

    def _base(self, word: str) -> Phrase | None:
        """What a tower stands on: `… on top of each other in the tray`."""
        if word != "stack" or self.cursor.kind() != "relation" or self.cursor.value() not in ("on", "in"):
            return None
        self.cursor.take()
        return noun_phrase(self.cursor)

    def _tower_of(self, subjects: tuple[Phrase, ...]) -> list[Clause]:
        is_named = self.cursor.kind() == "stack"
        found = tower(self.cursor, self.lexicon, self.unread, subjects)
        if not is_named and len(found[0].levels) < 2:
            raise self.unread()  # on top of what?
        return found

    def _related(self, subjects: tuple[Phrase, ...]) -> list[Clause]:
        cursor = self.cursor
        gap_m, self._gap = (self._gap, None) if self._gap is not None else (gap(cursor, self.lexicon), None)
        cursor.skip("with")
        if cursor.kind() != "relation":
            raise self.unread()
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
            raise self.unread()
        if relation == "in" and cursor.kind() == "with":
            cursor.take()
            subjects += noun_phrases(cursor) or ()
        subjects = (*subjects[:-1], with_limits(cursor, subjects[-1]))
        first = Clause(relation, subjects, target, gap_m=gap_m)
        if relation == "on" and cursor.kind() == "relation" and cursor.value() == "on":
            if target.others:
                raise self.unread()  # `red on blue or green on yellow` is no chain
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
            raise Unread("coordinates", self.lexicon.text("coordinates"))
        return target

    def _ends(self) -> tuple[Phrase, ...]:
        """The two that a thing is to be between: `the red and the blue cube`, `both apples`."""
        found = noun_phrases(self.cursor, most=2)
        if not found or (len(found) == 1 and not (found[0].is_many or found[0].count == 2)):
            raise self.unread()
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

    # -- clauses that begin with a word of their own -------------------------------------------------------------------

    def _relation_first(self) -> list[Clause]:
        cursor = self.cursor
        relation: ClauseKind = cursor.take().value
        ends = self._ends() if relation == "between" else ()
        target = None if ends else self._thing()
        cursor.skip(",", ":", "put", "with", "then")
        return [Clause(relation, self._things(), target, ends=ends)]

    def _fill(self) -> list[Clause]:
        """`load the tray with the cubes`."""
        self.cursor.take()
        target = self._thing()
        if not self.cursor.skip("with"):
            raise self.unread()
        return [Clause("in", self._things(), target)]

    def _empty(self) -> list[Clause]:
        """`empty the bin`."""
        word = self.cursor.take()
        return self._emptied(word.text, self._things())

    def _emptied(self, word: str, targets: tuple[Phrase, ...]) -> list[Clause]:
        """All that lies in a container comes out of it; `… into the bin` names where it goes."""
        if not all(map(_is_container, targets)):
            raise self.unread()
        self.cursor.skip("empty")
        every = Phrase("everything", word, is_many=True, is_all=True)
        *others, found = (Clause("off", (every,), target) for target in targets)
        if others:
            return [*others, found]
        is_moved = self.cursor.kind() == "relation" and self.cursor.value() in ("in", "on", "to")
        return [found, *self._about(THOSE, is_held=False)] if is_moved else [found]

    def _unstack(self) -> list[Clause]:
        """`unstack the cubes`, `dismantle the tower`."""
        self.cursor.take()
        return [Clause("unstack", noun_phrases(self.cursor))]

    def _each_other(self) -> list[Clause]:
        kind = MUTUAL[self.cursor.take().value]
        self.cursor.skip(",", "put", ":")
        return [Clause(kind, self._things())]

    def _gap_first(self) -> list[Clause]:
        self._gap = gap(self.cursor, self.lexicon)
        self.cursor.skip(*LISTED, "put")
        subjects = self._things()
        if self._gap is None:
            raise self.unread()
        return self._related(subjects)

    def _pairs(self) -> tuple[tuple[Phrase, ...], tuple[Phrase, ...]]:
        """`A, B and C`, or `A from B`, after a word such as `swap`."""
        self.cursor.take()
        self.cursor.skip("put", "with", ":")
        subjects = self._things()
        others = noun_phrases(self.cursor) if self.cursor.skip("with") else ()
        self.cursor.skip("put")
        return subjects, others

    def _swap(self) -> list[Clause]:
        self.cursor.take()
        self.cursor.skip("with", ",", "put")
        subjects = self._things()
        if self.cursor.skip("with", "for"):
            subjects += noun_phrases(self.cursor)
        return [Clause("swap", subjects)]

    def _group(self) -> list[Clause]:
        subjects, _ = self._pairs()
        if self.cursor.kind() == "by":
            return [Clause("by", subjects, by=self.cursor.take().value)]
        if self.cursor.kind() == "relation":
            where = self._related(subjects)
            is_desk = where[-1].target is not None and where[-1].target.kind == "desk"
            return [*where, Clause("group", THOSE)] if is_desk else where
        self.cursor.skip("each_other")
        return [Clause("group", subjects)]

    def _spread(self) -> list[Clause]:
        subjects, others = self._pairs()
        if self.cursor.kind() == "each_other" and self.cursor.value() == "apart":
            self.cursor.take()
        if others:
            return [Clause("apart", subjects, target) for target in others]
        return [Clause("spread", subjects)]

    def _sort(self) -> list[Clause]:
        cursor = self.cursor
        cursor.take()
        if cursor.kind() in ("the", "pronoun") and cursor.kind(1) == ":":
            cursor.take()
        cursor.skip(":")
        subjects = self._things()
        if cursor.kind() not in ("by", "relation", "put"):
            raise self.unread()
        return self._about(subjects, is_held=False)

    def _into(self) -> list[Clause]:
        """`bin the tomato`: the verb names where."""
        verb = self.cursor.take()
        container = Phrase("things", verb.text, types=verb.value.types, has_noun=True)
        return [Clause("in", self._things(), container)]

    def _is_verb_of_place(self) -> bool:
        noun = self.cursor.value() if self.cursor.kind() == "noun" else None
        is_container = noun is not None and noun.types < CONTAINERS and not noun.is_many
        return is_container and self.cursor.kind(1) in ("the", "all", "noun", "colour")

    def _in_order(self, whole: tuple[Phrase, ...] = ()) -> list[Clause]:
        cursor = self.cursor
        is_from_left = cursor.take().value == "left"
        subjects = ordered_phrases(cursor)
        if not subjects and len(whole) > 1:
            subjects, whole = whole, ()
        if whole and whole[0].kind == "pronoun":
            whole = ()  # `line them up from left to right: …`
        if len(subjects) < 2 or len(whole) > 1:
            raise Unread("order", self.lexicon.text("order"))
        subjects = subjects if is_from_left else subjects[::-1]
        return [Clause("in_order", subjects, whole[0] if whole else None)]


def _is_container(phrase: Phrase) -> bool:
    return bool(phrase.types) and phrase.types <= CONTAINERS
