# SPDX-License-Identifier: Apache-2.0
"""What clauses mean over a scene: which predicates are wanted of which things.

Rule: whatever the words leave open is asked back; the one exception is the order of a tower, of which any will do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, pairwise, product

from rai_missions.planning.reading.meanings import Meanings
from rai_missions.planning.reading.phrases import Clause, Phrase, Unread
from rai_missions.planning.reading.picks import Picks
from rai_missions.planning.reading.predicates import Plain, each_of, moved_by
from rai_missions.planning.reading.rows import row
from rai_missions.planning.reading.things import Names, Things
from rai_missions.planning.scene import DESK
from rai_missions.planning.text.language_file import spoken

__all__ = ("GoalWriter",)

STACKED = Phrase("things", "", types=frozenset({"cube"}), has_noun=True, is_many=True)
"""What a tower is made of where nothing is said about it."""
WHOLE = frozenset({0, None, -1})
"""The levels of a tower of three: bottom, middle and top."""
LEAST_TOWER = 2
BUILT = frozenset({"on", "stack", "under"})
"""Kinds of clauses that build a tower."""
PUT = frozenset({"in", "on", "to"})
"""Kinds of clauses that put something onto or into another thing."""
PLACED = frozenset({"on", "in", "at", "swapped", "shifted"})
"""Predicates of a thing that lies where it is put; next to another it may lie on the desk as well."""
SIDES: Mapping[str, tuple[str, bool]] = {
    "left_of": ("left_of", False), "right_of": ("left_of", True), "behind": ("behind", False),
    "in_front_of": ("behind", True),
}  # fmt: skip
"""Kinds of clauses → their predicate, and whether the things change their places in it."""


class GoalWriter:
    """The predicates of a request, for one choice among what its phrases may mean.

    Args:
        things: The things of the scene.
        picks: The choices.
    """

    def __init__(self, things: Things, picks: Picks) -> None:
        self._things = things
        self._picks = picks
        self._meant = Meanings(things, picks)
        self._moved_to = list[tuple[str, str]]()
        self._is_held = False
        self._empty = list[str]()
        """Containers that are to be emptied, and are empty."""
        self._until_put = list[Plain]()
        """What holds of things until they are put elsewhere: what was taken from somewhere lies on the desk."""
        self._latest = list[Plain]()

    def predicates(self, clauses: Sequence[Clause]) -> list[Plain]:
        """The predicates as plain data, each once.

        Raises:
            Unread: A clause is not sure over this scene, or about things that are not there.
        """
        found = list[Plain]()
        for clause in clauses:
            self._meant.begin(clause, found)
            self._check_held(clause)
            wanted = list(self._of(clause))
            put = {name for each in wanted if each.keys() & PLACED for name in moved_by(each)}
            found = [each for each in found if each not in self._until_put or put.isdisjoint(moved_by(each))] + wanted
            self._until_put += wanted if clause.kind == "off" else []
            self._latest = wanted
        if self._is_held:
            raise self._things.ask("where", self._things.listed(self._meant.subjects))
        found += self._exchanges()
        if self._empty and not found:
            where = self._things.listed(tuple(self._empty[:1]))
            raise self._things.lexicon.unread("nothing_there", where, reason="absent", refused=True)
        self._check_swapped(found)
        return [each for at, each in enumerate(found) if each not in found[:at]]

    def _check_swapped(self, found: Sequence[Plain]) -> None:
        """A thing that is swapped or shifted, and moved otherwise, too: where it comes to depends on which is first."""
        for at, each in [one for one in enumerate(found) if one[1].keys() & {"swapped", "shifted"}]:
            others = [*found[:at], *found[at + 1 :]]
            elsewhere = {name for other in others for name in moved_by(other)}
            if moved := [name for name in each.get("swapped", ()) if name in elsewhere]:
                raise self._ask_order("swapped_and_moved", moved[0])
            placed = (other for other in others if other.keys() & PLACED)
            if "shifted" in each and any(each["shifted"] in moved_by(other) for other in placed):
                raise self._ask_order("shifted_and_moved", each["shifted"])

    def _ask_order(self, text: str, name: str) -> Unread:
        return self._things.lexicon.unread(text, self._things.listed((name,)), reason="order")

    def _of(self, clause: Clause) -> Iterable[Plain]:
        rules: Mapping[str, Callable[[Clause], Iterable[Plain]]] = {
            "on": self._on,
            "in": self._in,
            "to": self._to,
            "off": self._off,
            **dict.fromkeys(SIDES, self._beyond),
            "between": self._between,
            "shift": self._shift,
            "stay": self._shift,
            "next_to": self._next_to,
            "apart": self._apart,
            "place_of": self._place_of,
            "at": self._at,
            "stack": self._stack,
            "swap": self._swap,
            "group": self._group,
            "spread": self._spread,
            "side_by_side": self._side_by_side,
            "in_order": self._in_order,
            "by": self._by,
            "held": self._held,
            "too": self._too,
            "under": self._under,
            "unstack": self._unstack,
            "towers": self._tower_each,
            "row": self._row,
        }
        return list(rules[clause.kind](clause))

    def _check_alone(self, names: Names, text: str) -> None:
        """Ask how several things are meant; a single one is clear."""
        if len(names) > 1:
            raise self._things.ask(text, self._things.listed(names))

    # -- relations to another thing ------------------------------------------------------------------------------------

    def _on(self, clause: Clause) -> Iterable[Plain]:
        if clause.target is not None and clause.target.is_other and any(each.is_any for each in clause.subjects):
            return self._one_on_the_other(clause)
        names, target = self._meant.pair(clause)
        if self._things.scene.get(target) is not None and self._things.scene.thing(target).type == "tray":
            return each_of("in", names, target)
        if target != DESK:
            self._check_alone(names, "order")
        return each_of("on", names, target)

    def _under(self, clause: Clause) -> Iterator[Plain]:
        names, target = self._meant.pair(clause)
        if len(names) > 1 or target == DESK or self._things.is_container(names[0]):
            raise self._things.ask("where", self._things.listed(names))
        yield {"on": [target, names[0]]}

    def _one_on_the_other(self, clause: Clause) -> Iterable[Plain]:
        """`one cube on the other`: whichever, where there are two."""
        (phrase,) = clause.subjects
        both = [names[0] for names in self._things.alternatives(phrase)]
        if len(both) != 2:
            raise self._things.ask("order")
        self._meant.note(subjects=tuple(both))
        return [{"on": both[::-1]}]

    def _in(self, clause: Clause) -> Iterable[Plain]:
        return each_of("in", *self._meant.pair(clause))

    def _to(self, clause: Clause) -> Iterable[Plain]:
        return self._put(*self._meant.pair(clause))

    def _put(self, names: Names, target: str) -> Iterable[Plain]:
        """Onto the desk, or into a container."""
        if target != DESK and not self._things.is_container(target):
            raise self._things.ask("where", self._things.listed(names))
        return each_of("on" if target == DESK else "in", names, target)

    def _off(self, clause: Clause) -> Iterable[Plain]:
        """`everything out of the bin`: of several things those that lie there are meant; they come onto the desk."""
        place = self._meant.one(clause.target)
        if any(each.kind == "everything" for each in clause.subjects) and self._is_empty(place):
            self._meant.note(subjects=())
            self._empty.append(place)
            return ()  # `empty the tray, and put …`: that is so
        names = [
            name
            for phrase in clause.subjects
            for name in self._picks.one(self._there(phrase, self._meant.alternatives(phrase), place))
        ]
        self._meant.note(subjects=tuple(dict.fromkeys(names)))
        return each_of("on", self._meant.subjects, DESK)

    def _is_empty(self, place: str) -> bool:
        """Whether it is a container in which nothing is seen."""
        others = (each.name for each in self._things.scene.things)
        return self._things.is_container(place) and not any(self._things.lies_at(name, place) for name in others)

    def _there(self, phrase: Phrase, alternatives: Sequence[Names], place: str) -> Sequence[Names]:
        """The things that a phrase may mean and that lie in or on another thing; a single thing may lie elsewhere.

        Raises:
            Unread: It means several things, and none of them lies there.
        """
        found = [tuple(name for name in names if self._things.lies_at(name, place)) for names in alternatives]
        if there := tuple(dict.fromkeys(filter(None, found))):
            return there
        if len(alternatives) == 1 and len(alternatives[0]) == 1 and phrase.kind not in ("everything", "rest"):
            return alternatives
        lexicon, where = self._things.lexicon, f"'{spoken(place)}'"
        if phrase.kind in ("everything", "rest"):
            raise lexicon.unread("nothing_there", where, reason="absent", refused=True)
        raise lexicon.unread("none_there", f"'{phrase.text}'", where, reason="absent", refused=True)

    def _unstack(self, clause: Clause) -> Iterable[Plain]:
        """`the cubes off each other`: those that lie on another of them come onto the desk."""
        names = self._meant.names(clause.subjects or (STACKED,))
        among = names if clause.subjects else [each.name for each in self._things.scene.things]
        lying = [name for name in names if any(self._lies_on(name, other) for other in among)]
        if not lying:
            raise self._things.lexicon.unread("none_stacked", self._things.listed(names), reason="absent", refused=True)
        self._meant.note(subjects=tuple(lying))
        return each_of("on", self._meant.subjects, DESK)

    def _lies_on(self, name: str, other: str) -> bool:
        return not self._things.is_container(other) and self._things.lies_at(name, other)

    def _beyond(self, clause: Clause) -> Iterator[Plain]:
        if clause.ends:
            left, right = self._meant.names(clause.subjects), self._meant.names(clause.ends)
            yield from (
                {"left_of": list(pair)} for pair in product([each for each in left if each not in right], right)
            )
            return
        names, target = self._meant.pair(clause)
        if clause.gap_m is not None:
            self._check_alone(names, "order")
        gap = {} if clause.gap_m is None else {"gap_m": clause.gap_m}
        word, is_reversed = SIDES[clause.kind]
        for name in names:
            yield {word: [target, name] if is_reversed else [name, target], **gap}

    def _between(self, clause: Clause) -> Iterator[Plain]:
        names = self._meant.names(clause.subjects)
        self._meant.note(target=tuple(name for phrase in clause.ends for name in self._meant.take(phrase)))
        if len(self._meant.target) != 2:
            raise self._things.ask("too_many", self._things.listed(self._meant.target))
        self._check_alone(names, "order")
        yield {"between": [*names, *self._meant.target]}

    def _shift(self, clause: Clause) -> Iterator[Plain]:
        """From where it is seen; what stays is shifted by nothing."""
        yield from ({"shifted": name, "dx": clause.x, "dy": clause.y} for name in self._meant.names(clause.subjects))

    def _next_to(self, clause: Clause) -> Iterator[Plain]:
        names, target = self._meant.pair(clause)
        yield from ({"next_to": [name, target]} for name in names)

    def _apart(self, clause: Clause) -> Iterator[Plain]:
        names = self._meant.names(clause.subjects)
        targets = self._meant.of(clause.target) if clause.target is not None else ()
        self._meant.note(target=targets if len(targets) == 1 else ())
        yield from ({"apart": list(pair)} for pair in product(names, targets))

    def _place_of(self, clause: Clause) -> Iterable[Plain]:
        names, target = self._meant.pair(clause)
        self._check_alone(names, "where")
        self._moved_to.append((names[0], target))
        return ()

    def _exchanges(self) -> Iterator[Plain]:
        pending = list(self._moved_to)
        while pending:
            one, other = pending.pop(0)
            if (other, one) not in pending:
                raise self._things.ask("where", self._things.listed((other,)))
            pending.remove((other, one))
            yield {"swapped": [one, other]}

    def _at(self, clause: Clause) -> Iterator[Plain]:
        names = self._meant.names(clause.subjects)
        self._check_alone(names, "where")
        yield {"at": names[0], "x": clause.x, "y": clause.y}

    # -- things among themselves ---------------------------------------------------------------------------------------

    def _several(self, phrases: Sequence[Phrase]) -> Names:
        return self._at_least_two(self._meant.names(phrases))

    def _in_turn(self, phrases: Sequence[Phrase]) -> Names:
        """The things of a tower or a row, each named once: in `the cubes, red first` the second phrase is an order."""
        each = [self._meant.names([phrase]) for phrase in phrases]
        names = tuple(name for names in each for name in names)
        self._meant.note(subjects=tuple(dict.fromkeys(names)))
        if len(names) > len(self._meant.subjects):
            raise self._things.ask("order")
        return self._at_least_two(names)

    def _at_least_two(self, names: Names) -> Names:
        if len(names) < 2:
            raise self._things.ask("too_few", self._things.listed(names))
        return names

    def _stack(self, clause: Clause) -> Iterator[Plain]:
        base = self._base(clause)
        if not clause.levels:
            names = self._in_turn(_stackable(clause.subjects) or (STACKED,))
        else:
            members = self._meant.names(_stackable(clause.subjects)) if clause.subjects else ()
            placed = [(self._meant.one(_stackable([phrase])[0]), level) for phrase, level in clause.levels]
            names = self._by_level(members or self._members(placed), placed)
        names = self._at_least_two((base, *(name for name in names if name != base)))[1:]
        yield {"in" if self._things.is_container(base) else "on": [names[0], base]}
        yield from ({"on": [above, below]} for below, above in pairwise(names))

    def _tower_each(self, clause: Clause) -> Iterator[Plain]:
        """Several towers of as many things each; which are in which is for the person to choose."""
        names = self._in_turn(_stackable(clause.subjects) or (STACKED,))
        height, left = divmod(len(names), clause.count)
        if left or height < LEAST_TOWER or clause.height not in (0, height):
            raise self._things.ask("order")
        for at in range(0, len(names), height):
            yield {"on": [names[at], DESK]}
            yield from ({"on": [above, below]} for below, above in pairwise(names[at : at + height]))

    def _base(self, clause: Clause) -> str:
        """What a tower stands on: what is given, the container that its things were just put into, or the desk."""
        if clause.target is not None:
            return self._meant.one(clause.target)
        is_of_those = any(each.kind == "pronoun" for each in clause.subjects)
        if self._meant.last_kind in PUT and is_of_those and self._meant.container:
            self._until_put += self._latest
            return self._meant.container
        return DESK

    def _members(self, placed: Sequence[tuple[str, int | None]]) -> Names:
        """All that can be stacked, where not each level is given from below."""
        named = tuple(name for name, _ in placed)
        (every,) = self._things.alternatives(STACKED)
        from_below = [level for _, level in placed]
        if len(placed) == len(WHOLE) and set(from_below) == WHOLE:
            return named
        if len(placed) > 1 and from_below == [*range(len(placed) - 1), -1]:
            return named
        if len(placed) > 1 and from_below != list(range(len(placed))) and set(named) != set(every):
            raise self._things.ask("order")
        return every if len(placed) == 1 else named

    def _by_level(self, members: Names, placed: Sequence[tuple[str, int | None]]) -> Names:
        named = [name for name, _ in placed]
        names = list(dict.fromkeys([*members, *named]))
        free = [name for name in names if name not in named]
        slots: list[str | None] = [None] * len(names)
        middle = [name for name, level in placed if level is None]
        for name, level in placed:
            if level is not None:
                if not -1 <= level < len(slots) or slots[level] is not None:
                    raise self._things.ask("order")
                slots[level] = name
        left = [at for at, name in enumerate(slots) if name is None]
        if len(set(named)) < len(named) or (middle and left != [1]):
            raise self._things.ask("order")
        for at, name in zip(left, middle + free, strict=True):
            slots[at] = name
        return tuple(name for name in slots if name is not None)

    def _swap(self, clause: Clause) -> Iterator[Plain]:
        names = self._several(clause.subjects)
        if len(names) > 2:
            raise self._things.ask("too_many", self._things.listed(names))
        self._meant.note(target=())
        yield {"swapped": list(names)}

    def _group(self, clause: Clause) -> Iterator[Plain]:
        yield {"grouped": list(self._several(clause.subjects))}

    def _spread(self, clause: Clause) -> Iterator[Plain]:
        """Each thing from every other; of several groups those of one from those of another: `fruit and vegetables`."""
        groups = [self._meant.names([phrase]) for phrase in clause.subjects]
        names = self._at_least_two(tuple(dict.fromkeys(name for group in groups for name in group)))
        self._meant.note(subjects=names)
        if len(groups) < 2 or all(len(group) == 1 for group in groups):
            yield {"apart": list(names)}
            return
        for one, other in combinations(groups, 2):
            yield from ({"apart": list(pair)} for pair in product(one, other) if pair[0] != pair[1])

    def _side_by_side(self, clause: Clause) -> Iterator[Plain]:
        names = self._several(clause.subjects)
        yield {"next_to": list(names)} if len(names) == 2 else {"grouped": list(names)}

    def _row(self, clause: Clause) -> Iterator[Plain]:
        placed = [(self._meant.one(phrase), level) for phrase, level in clause.levels]
        names = self._in_turn(clause.subjects)
        ends = {level: name for name, level in placed if name in names}
        if len({*ends.values()}) < len(clause.levels):
            raise self._things.ask("order")
        yield from row([self._things.scene.thing(name) for name in names], first=ends.get(0), last=ends.get(-1))

    def _in_order(self, clause: Clause) -> Iterator[Plain]:
        each = [self._meant.names([phrase]) for phrase in clause.subjects]
        whole = set(self._meant.of(clause.target)) if clause.target is not None else None
        names = [one for names in each for one in names]
        if any(len(names) != 1 for names in each) or (whole is not None and whole != set(names)):
            raise self._things.ask("order")
        yield from ({"left_of": list(pair)} for pair in pairwise(names))

    def _by(self, clause: Clause) -> Iterator[Plain]:
        groups = dict[str, list[str]]()
        for name in self._several(clause.subjects):
            groups.setdefault(getattr(self._things.scene.thing(name), clause.by), []).append(name)
        if max(map(len, groups.values())) < 2:
            raise self._things.ask("order")
        yield from ({"grouped": names} for names in groups.values() if len(names) > 1)
        for one, other in combinations(groups.values(), 2):
            yield from ({"apart": list(pair)} for pair in product(one, other))

    # -- clauses that lean on another ----------------------------------------------------------------------------------

    def _held(self, clause: Clause) -> Iterable[Plain]:
        self._meant.names(clause.subjects)
        self._is_held = True
        return ()

    def _check_held(self, clause: Clause) -> None:
        """What is picked up must be what is put: `take the red cube and put it …`."""
        if self._is_held and not any(each.kind in ("pronoun", "those") for each in clause.subjects):
            raise self._things.ask("where", self._things.listed(self._meant.subjects))
        self._is_held = False

    def _too(self, clause: Clause) -> Iterable[Plain]:
        kind, is_there = self._meant.last_kind, clause.target is not None
        is_emptied = is_there and kind == "off" and bool(self._meant.container)
        names, target = self._meant.names(clause.subjects), self._meant.target
        if is_there and kind in BUILT and not any(map(self._things.is_container, target)):
            self._check_alone(names, "order")
            if len(top := self._meant.tower_top) != 1:
                raise self._things.ask("where", self._things.listed(names))
            return each_of("on", names, top[0])  # `red on blue, and green on it`
        if not (kind in PUT or is_emptied) or len(target) != 1:
            raise self._things.ask("where", self._things.listed(names))
        return self._put(names, target[0])


def _stackable(phrases: Sequence[Phrase]) -> tuple[Phrase, ...]:
    """A colour alone in a tower is that of something that can be stacked, and so is the rest."""
    return tuple(
        replace(each, types=STACKED.types, has_noun=True)
        if each.kind == "rest" or (each.kind == "things" and (each.colour or each.rank) and not each.has_noun)
        else each
        for each in phrases
    )
