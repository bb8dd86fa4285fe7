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
    PREDICATES,
    Cursor,
    noun_phrase,
    noun_phrases,
    ordered_phrases,
    with_limits,
)
from rai_missions.planning.reading.phrases import Clause, ClauseKind, Phrase, Unread
from rai_missions.planning.reading.places import gap, has_place, place, shift
from rai_missions.planning.reading.row_words import ordered_row, row_of, sides_of
from rai_missions.planning.reading.swaps import swaps
from rai_missions.planning.reading.symbols import SUBJECTS, Symbol
from rai_missions.planning.reading.towers import is_tower, levels_of, skip_several, tower
from rai_missions.planning.scene import CONTAINERS

__all__ = ("clauses",)

BETWEEN = (",", ".", "and", "then")
NAMED = (":", "=")
"""Signs between a container and what is to be in it."""
HEADING = SUBJECTS | {"put", "sort", "empty", "by", "the", "desk", "away"}
"""Kinds of symbols ahead of a list of wishes."""
MUTUAL: dict[str, ClauseKind] = {
    "stack": "stack", "next_to": "side_by_side", "group": "group", "apart": "spread", "swap": "swap", "row": "row",
}  # fmt: skip
SIDES = frozenset({"left_of", "right_of", "behind", "in_front_of"})
"""Relations that may have a gap."""
NEAR_IT = SIDES | {"under", "next_to", "between"}
"""After a verb of grasping these may as well mean where the thing is now: `take the cube under the apple`."""
BEFORE_NOUN = ("the", "a", "any", "colour", "noun")
CHAINED = SIDES | {"on", "next_to"}
"""Relations of which one follows another: `red on blue on green`."""
WHERE = NEAR_IT | {"on", "in"}
THOSE = (Phrase("those", ""),)


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
            raise rules.unread()
        rules.cursor.skip(*BETWEEN, "put")
    if not found:
        raise rules.unread()
    if all(each.kind == "stay" for each in found):
        found = [replace(each, is_open=True) for each in found]  # an order that moves nothing
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
        self._before: ClauseKind | None = None
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
        self._before = before[-1].kind if before else None
        cursor.skip("put", "then", "too", "with")
        is_too = any(each.kind == "too" for each in cursor.symbols[begun : cursor.at])
        if cursor.kind() == "reverse":
            return [self._reversed(before)]
        if is_tower(cursor):
            self._towers += skip_several(cursor)
        if is_tower(cursor) or (cursor.kind() == "level" and cursor.kind(1) in (*BEFORE_NOUN, ":")):
            found = tower(cursor, self.lexicon, self.unread)
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

    def _things(self) -> tuple[Phrase, ...]:
        """The phrases that must be here."""
        found = noun_phrases(self.cursor)
        if not found:
            raise self.unread()
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
        is_stacked = found[-1].kind == "on" and self.cursor.kind(1) in ("", *BETWEEN)
        self.cursor.skip("put", "too", "grasp", "sort", *(["stack"] if is_stacked else []))
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
        raise self.unread()

    def _shift(self) -> tuple[float, float] | None:
        """How far from where it is a thing is moved; None where the words after it are a place.

        Raises:
            Unread: `Move it 30 cm ahead and 10 cm to the left` may be both; `to 30 cm ahead` is a place.
        """
        cursor = self.cursor
        if cursor.kind() != "number" or cursor.kind(1) != "side":
            return None
        if (metres := shift(cursor, self.lexicon)) is None and self._is_after("shift"):
            raise Unread("coordinates", self.lexicon.text("coordinates"))
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

    def _keep(self) -> list[Clause]:
        """`Do not touch the cubes`, `leave them alone`; `leave them on the tray` is where they are to be."""
        cursor = self.cursor
        cursor.take()
        subjects = self._members()
        if cursor.kind() in ("", "there", "stays", *BETWEEN) and cursor.kind(1) != "relation":
            cursor.skip("there", "stays")
            return [Clause("stay", subjects)]
        return self._about(subjects, is_held=False)

    def _is_after(self, verb: str) -> bool:
        """Whether a verb of putting of some kind came before."""
        before = self.cursor.symbols[: self.cursor.at]
        return any(each.kind == "put" and each.value == verb for each in before)

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
        if relation in CHAINED and cursor.kind() == "relation" and cursor.value() == relation:
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
        if self.cursor.kind() == "there" and self.cursor.kind(1) in ("", "put", *BETWEEN):
            self.cursor.take()  # `auf den blauen drauf`
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
        begun = cursor.at
        cursor.skip(",", ":", "put", "with", "then")
        if found := noun_phrases(cursor):
            return [Clause(relation, found, target, ends=ends)]
        if self._before is None:
            raise self.unread()
        cursor.back_to(begun)  # `take it off the tower, and put it next to the apple`
        return [Clause(relation, THOSE, target, ends=ends, is_open=self._before != "off")]

    def _fill(self) -> list[Clause]:
        """`load the tray with the cubes`."""
        self.cursor.take()
        target = self._thing()
        if not self.cursor.skip("with"):
            raise self.unread()
        return [Clause("in", self._members(), target)]

    def _empty(self) -> list[Clause]:
        """`empty the bin`."""
        word = self.cursor.take()
        return self._emptied(word.text, self._things())

    def _emptied(self, word: str, targets: tuple[Phrase, ...]) -> list[Clause]:
        """All that lies in a container comes out of it; `… into the bin` names where it goes."""
        if not all(each.is_container for each in targets):
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
        ordered = ordered_row(self.cursor, ()) if kind == "row" else None
        is_alone = self.cursor.kind() in ("", ".", "then") and self._before is not None
        self.cursor.skip(*([] if is_alone else [",", "put", ":"]))
        return [ordered or Clause(kind, THOSE if is_alone else self._things(), is_open=is_alone)]

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
            raise self.unread()
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
