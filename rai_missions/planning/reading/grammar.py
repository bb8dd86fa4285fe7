# SPDX-License-Identifier: Apache-2.0
"""Clauses from symbols: each rule reads one form of a wish, `NOUNS relation NOUN`, `stack NOUNS`, `swap NOUNS`.

Rule: the clauses must account for every symbol; what is left over makes the whole request unread.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.noun_phrases import (
    LISTED,
    Cursor,
    noun_phrases,
)
from rai_missions.planning.reading.phrases import Clause, ClauseKind, Phrase
from rai_missions.planning.reading.places import gap
from rai_missions.planning.reading.row_words import ordered_row
from rai_missions.planning.reading.symbols import BETWEEN, SUBJECTS, Symbol
from rai_missions.planning.reading.thing_clauses import MUTUAL, NEAR_IT, THOSE, ThingClauses, swaps
from rai_missions.planning.reading.towers import is_tower, skip_several, tower
from rai_missions.planning.scene import CONTAINERS

__all__ = ("clauses",)

HEADING = SUBJECTS | {"put", "sort", "empty", "by", "the", "desk", "away"}
"""Kinds of symbols ahead of a list of wishes."""
BEFORE_NOUN = ("the", "a", "any", "colour", "noun")
WHERE = NEAR_IT | {"on", "in"}


def clauses(symbols: Sequence[Symbol], lexicon: Vocabulary) -> tuple[Clause, ...]:
    """The wishes of a request, in their order.

    Raises:
        Unread: A symbol belongs to no rule.
    """
    rules = Rules(Cursor(symbols), lexicon)
    found = list[Clause]()
    rules.skip_heading()
    rules.cursor.skip(*BETWEEN, ":", "put", "too")
    while rules.cursor.kind():
        found += rules.clause(found)
        if rules.cursor.kind() and not rules.cursor.skip(*BETWEEN):
            raise lexicon.unread()
        rules.cursor.skip(*BETWEEN, "put")
    if not found:
        raise lexicon.unread()
    if all(each.kind == "stay" for each in found):
        found = [replace(each, is_open=True) for each in found]  # an order that moves nothing
    rules.check_towers(found)
    return tuple(found)


class Rules(ThingClauses):
    """The rules of a clause of any kind.

    Args:
        cursor: At its first symbol.
        lexicon: For what is asked back.
    """

    def __init__(self, cursor: Cursor, lexicon: Vocabulary) -> None:
        super().__init__(cursor, lexicon)
        self._is_grasped_there = False
        self._towers = 0

    def skip_heading(self) -> None:
        """Past `tidy up:`, `sort the cubes by colour:`, `clear the desk,`: what is to be where follows."""
        cursor = self.cursor
        ahead = 0
        while cursor.kind(ahead) in HEADING:
            ahead += 1
        named = {symbol.kind for symbol in cursor.symbols[cursor.at : cursor.at + ahead]} & SUBJECTS
        is_headed = any(
            symbol.kind in ("sort", "empty") or symbol.value in ("arrange", "clear")
            for symbol in cursor.symbols[cursor.at : cursor.at + ahead]
        )
        is_end = cursor.kind(ahead) == ":" or (cursor.kind(ahead) in (",", ".") and not named)
        if is_headed and is_end and cursor.kind(ahead + 1):
            cursor.back_to(cursor.at + ahead + 1)

    def check_towers(self, found: Sequence[Clause]) -> None:
        """`Two towers:` has as many wishes after it at least.

        Raises:
            Unread: It has fewer.
        """
        if sum(each.kind in ("on", "stack", "under") for each in found) < self._towers:
            raise self.lexicon.unread("order")

    def clause(self, before: Sequence[Clause]) -> list[Clause]:
        """The clauses of the rule that fits here.

        Args:
            before: The clauses already read.

        Raises:
            Unread: None fits.
        """
        cursor = self.cursor
        begun = cursor.at
        self._before = before[-1].kind if before else None
        cursor.skip("put", "then", "too", "with")
        is_too = any(each.kind == "too" for each in cursor.symbols[begun : cursor.at])
        if cursor.kind() == "reverse":
            return [self._reversed(before)]
        if is_tower(cursor):
            self._towers += skip_several(cursor)
        if is_tower(cursor) or (cursor.kind() == "level" and cursor.kind(1) in (*BEFORE_NOUN, ":")):
            found = tower(cursor, self.lexicon)
            if before and before[-1].kind == "held" and not (found[0].subjects or found[0].levels):
                found = [replace(found[0], subjects=THOSE)]  # `take red and blue, and make a tower`
            return self._after(found)
        rule = {
            "swap": self._swap,
            "group": self._group,
            "apart": self._spread,
            "sort": self._sort,
            "gap": self._gap_first,
            "relation": self._relation_first,
            "left_to_right": self._in_order,
            "into": self._into,
            "each_other": self._each_other,
            "fill": self._fill,
            "empty": self._empty,
            "unstack": self._unstack,
            "keep": self._keep,
        }.get("into" if self._is_verb_of_place() else cursor.kind())
        if rule is not None:
            return self._after(rule())
        is_held = cursor.skip("grasp")
        if ordered := ordered_row(cursor, (), is_named=False):
            return [ordered]
        subjects = self._things()
        if is_too and before and cursor.kind() in ("", *BETWEEN):
            return [Clause("too", subjects)]  # `…, and so should the apple`
        found = self._about(subjects, is_held=is_held)
        self._check_grasped(found[0], is_held=is_held)
        return self._after(found)

    def _check_grasped(self, found: Clause, *, is_held: bool) -> None:
        """Where something is grasped is no wish: `take the cube on the apple and put it …`."""
        is_there = is_held and found.kind in WHERE
        is_it = any(each.kind == "pronoun" for each in found.subjects)
        if (is_held and found.kind in NEAR_IT) or (self._is_grasped_there and is_it):
            raise self.lexicon.unread()
        self._is_grasped_there = is_there

    def _after(self, found: list[Clause]) -> list[Clause]:
        is_stacked = found[-1].kind == "on" and self.cursor.kind(1) in ("", *BETWEEN)
        self.cursor.skip("put", "too", "grasp", "sort", *(["stack"] if is_stacked else []))
        return found

    def _reversed(self, before: Sequence[Clause]) -> Clause:
        """`put A where B is and vice versa`."""
        last = before[-1] if before else None
        if last is None or last.kind != "place_of" or last.target is None or len(last.subjects) != 1:
            raise self.lexicon.unread()
        self.cursor.take()
        return Clause("place_of", (last.target,), last.subjects[0])

    # -- clauses that begin with a word of their own -------------------------------------------------------------------

    def _keep(self) -> list[Clause]:
        """`Do not touch the cubes`, `leave them alone`; `leave them on the tray` is where they are to be."""
        cursor = self.cursor
        cursor.take()
        subjects = self._members()
        if cursor.kind() in ("", "there", "stays", *BETWEEN) and cursor.kind(1) != "relation":
            cursor.skip("there", "stays")
            return [Clause("stay", subjects)]
        return self._about(subjects, is_held=False)

    def _relation_first(self) -> list[Clause]:
        cursor = self.cursor
        relation: ClauseKind = cursor.take().value
        ends = self._ends() if relation == "between" else ()
        target = None if ends else self._thing()
        begun = cursor.at
        cursor.skip(",", ":", "put", "with", "then")
        if found := noun_phrases(cursor):
            return [Clause(relation, found, target, ends=ends)]
        if self._before is None:
            raise self.lexicon.unread()
        cursor.back_to(begun)  # `take it off the tower, and put it next to the apple`
        return [Clause(relation, THOSE, target, ends=ends, is_open=self._before != "off")]

    def _fill(self) -> list[Clause]:
        """`load the tray with the cubes`."""
        self.cursor.take()
        target = self._thing()
        if not self.cursor.skip("with"):
            raise self.lexicon.unread()
        return [Clause("in", self._members(), target)]

    def _empty(self) -> list[Clause]:
        """`empty the bin`."""
        word = self.cursor.take()
        return self._emptied(word.text, self._things())

    def _unstack(self) -> list[Clause]:
        """`unstack the cubes`, `dismantle the tower`."""
        self.cursor.take()
        return [Clause("unstack", noun_phrases(self.cursor))]

    def _each_other(self) -> list[Clause]:
        kind = MUTUAL[self.cursor.take().value]
        ordered = ordered_row(self.cursor, ()) if kind == "row" else None
        is_alone = self.cursor.kind() in ("", ".", "then") and self._before is not None
        self.cursor.skip(*([] if is_alone else [",", "put", ":"]))
        return [ordered or Clause(kind, THOSE if is_alone else self._things(), is_open=is_alone)]

    def _gap_first(self) -> list[Clause]:
        self._gap = gap(self.cursor, self.lexicon)
        self.cursor.skip(*LISTED, "put")
        subjects = self._things()
        if self._gap is None:
            raise self.lexicon.unread()
        return self._related(subjects)

    def _pairs(self) -> tuple[tuple[Phrase, ...], tuple[Phrase, ...]]:
        """`A, B and C`, or `A from B`, after a word such as `swap`."""
        self.cursor.take()
        self.cursor.skip("put", "with", ":")
        subjects = self._things()
        is_from = self.cursor.skip("with") or (self.cursor.value() == "off" and self.cursor.skip("relation"))
        others = noun_phrases(self.cursor) if is_from else ()
        self.cursor.skip("put")
        return subjects, others

    def _swap(self) -> list[Clause]:
        self.cursor.take()
        self.cursor.skip("with", ",", "put")
        return swaps(self.cursor, self._members())

    def _group(self) -> list[Clause]:
        if self.cursor.kind(1) == "by":
            return self._everything_by()
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

    def _everything_by(self) -> list[Clause]:
        """`sort by colour`: of what is left open."""
        every = Phrase("everything", self.cursor.take().text, is_many=True, is_all=True)
        return [Clause("by", (every,), by=self.cursor.take().value, is_open=True)]

    def _sort(self) -> list[Clause]:
        cursor = self.cursor
        if cursor.kind(1) == "by":
            return self._everything_by()
        cursor.take()
        if cursor.kind() in ("the", "pronoun") and cursor.kind(1) == ":":
            cursor.take()
        cursor.skip(":")
        subjects = self._things()
        if cursor.kind() not in ("by", "relation", "put"):
            raise self.lexicon.unread()
        return self._about(subjects, is_held=False)

    def _into(self) -> list[Clause]:
        """`bin the tomato`: the verb names where."""
        verb = self.cursor.take()
        container = Phrase("things", verb.text, types=verb.value.types, has_noun=True)
        return [Clause("in", self._members(), container)]

    def _is_verb_of_place(self) -> bool:
        noun = self.cursor.value() if self.cursor.kind() == "noun" else None
        is_container = noun is not None and noun.types < CONTAINERS and not noun.is_many
        return is_container and self.cursor.kind(1) in ("the", "all", "noun", "colour")
