# SPDX-License-Identifier: Apache-2.0
"""Whether a goal is grounded in a request: words of it mean each thing and each relation, and it has each number.

Rule: it holds for a goal of any author, a model included, and over any text; what cannot be matched is not said.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from rai_missions.planning.goal import AtPlace, Beyond, Goal, Shifted
from rai_missions.planning.reading.lexicon import Vocabulary, lexicon, lexicons
from rai_missions.planning.reading.relation_words import relations_in
from rai_missions.planning.reading.rewrites import rewritten
from rai_missions.planning.reading.symbols import RANKING, Quantity, Symbol, kind_at, past
from rai_missions.planning.scene import CONTAINERS, Scene, Thing, has_colour

__all__ = ("IN_ORDER", "is_said", "unsaid")

NEAR = 1e-6
"""Metres within which two numbers are the same."""
SAME_PLACE = 1e-3
"""Metres within which a place is that of a thing."""
ARTICLES = ("the", "a", "any", "number", "generic")
IN_ORDER = (*RANKING, "counted_from")
"""Kinds of symbols by which a thing is meant by its place in an order."""
MEANING_MORE = frozenset({"all", "any", "other", *IN_ORDER})
"""Kinds of symbols before a noun without whose colour it may mean any thing of its type."""
EVERY = frozenset({"everything", "rest", "empty"})


def is_said(goal: Goal, request: str, scene: Scene | None = None) -> bool:
    """Whether each thing, each number and each relation of the goal is in the request.

    Args:
        goal: Of any author.
        request: In free words; only its first 2,000 characters count.
        scene: What is seen, where it is known: types and colours are then those of the things, else those that their
            names have in them (`red_cube_2`).
    """
    return not unsaid(goal, request, scene)


def unsaid(goal: Goal, request: str, scene: Scene | None = None) -> tuple[str, ...]:
    """The names of things, the numbers, and the words of relations of a goal that no word of the request means.

    Args:
        goal: Of any author.
        request: In free words.
        scene: What is seen, where it is known.
    """
    evidence = [_Evidence.of(request, lexicon(code)) for code in lexicons()]
    names = [name for name in goal.things() if not any(_is_meant(name, each, scene) for each in evidence)]
    numbers = [
        number
        for name, number in _numbers(goal)
        if not any(each.has_number(number) or _is_of_first_pose(name, number, goal, each, scene) for each in evidence)
    ]
    words = dict.fromkeys(each.word for each in goal.all)
    relations = [word for word in words if not any(word in each.relations for each in evidence)]
    return (*names, *(f"{number:g}" for number in numbers), *relations)


@dataclass(slots=True)
class _Evidence:
    """What a text mentions, in one language."""

    coloured: set[tuple[str, frozenset[str] | None]] = field(default_factory=set)
    """Colours, each with the types of its noun; None where a colour is alone."""
    one: set[str] = field(default_factory=set)
    """Types of nouns that no colour is before."""
    every: set[str] = field(default_factory=set)
    """Types of which all are meant, or another one: `cubes`, `each cube`, `the other cube`."""
    is_every: bool = False
    """Whether everything that can be moved is meant, or another thing."""
    numbers: list[Quantity] = field(default_factory=list)
    relations: frozenset[str] = frozenset()
    """The words of the predicates that may be meant."""
    is_right: bool = False
    is_back: bool = False
    is_shift: bool = False
    """Whether it may be said how far something is shifted."""
    is_stay: bool = False
    """Whether something may be said to stay where it is."""
    is_swap: bool = False

    @classmethod
    def of(cls, request: str, words: Vocabulary) -> _Evidence:
        """What the text mentions."""
        found = rewritten(request, words)
        made = cls()
        for at, symbol in enumerate(found):
            made._add(symbol, at, found)
        made._add_towers(found)
        made._add_ranked(found)
        made.relations = relations_in(found)
        if any(symbol.kind == "with" and symbol.text in words.data["out_of"] for symbol in found):
            made.relations |= {"on"}
        return made

    def _add(self, symbol: Symbol, at: int, found: Sequence[Symbol]) -> None:
        if symbol.kind == "colour":
            self.coloured |= {(symbol.value, types) for types in _heads(found, at)}
        elif symbol.kind == "noun":
            before = _before(found, at)
            is_coloured = kind_at(found, at - 1) == "colour"
            if not is_coloured:
                self.one |= symbol.value.types
            if (symbol.value.is_many is not False and not is_coloured) or before & MEANING_MORE:
                self.every |= symbol.value.types
        elif symbol.kind in EVERY or symbol.kind == "other":
            self.is_every = self.is_every or symbol.kind in EVERY or not _has_noun(found, at)
            if symbol.kind == "other" and not _has_noun(found, at) and _is_place(found, at):
                self.every |= CONTAINERS  # `in the other one`
        elif symbol.kind == "number":
            self.numbers.append(symbol.value)
        elif symbol.kind == "away":
            self.one.add("bin")
        self.is_right = self.is_right or symbol.value in ("right", "right_of")
        self.is_back = self.is_back or symbol.value == "back"
        self.is_shift = self.is_shift or symbol.kind == "side"
        self.is_stay = self.is_stay or symbol.kind in ("stays", "keep") or symbol.value == "place_of"
        self.is_swap = self.is_swap or symbol.kind == "swap" or symbol.value in ("swap", "place_of")

    def _add_towers(self, found: Sequence[Symbol]) -> None:
        """A tower is of cubes, where nothing else is said of what it consists."""
        stacks = any(symbol.kind in ("stack", "tower", "upward", "unstack") for symbol in found)
        colours = sum(symbol.kind == "colour" for symbol in found)
        if stacks and colours < 2 and not self.one - CONTAINERS:
            self.every.add("cube")

    def _add_ranked(self, found: Sequence[Symbol]) -> None:
        """Let any thing of the named kind be the leftmost; without a kind, anything."""
        if any(symbol.kind in IN_ORDER for symbol in found):
            self.every |= self.one
            self.is_every = self.is_every or any(
                symbol.kind in IN_ORDER and not _has_noun(found, at) for at, symbol in enumerate(found)
            )

    def has_number(self, number: float) -> bool:
        """Whether the text has the number, in metres, whatever the unit."""
        units = {each.unit for each in self.numbers if each.unit is not None}
        for each in self.numbers:
            for unit in {each.unit} if each.unit is not None else {1.0, *units}:
                value = each.value * unit
                if math.isclose(value, number, abs_tol=NEAR) or (
                    (self.is_right or self.is_back) and value > 0 and math.isclose(-value, number, abs_tol=NEAR)
                ):
                    return True
        return False


def _heads(found: Sequence[Symbol], at: int) -> Iterator[frozenset[str] | None]:
    """The types of the noun that a colour is before, also over a list: `the red and the blue cube`."""
    ahead = past(found, at + 1, (",", "and", "or", "colour", *ARTICLES))
    if ahead > at + 1 or kind_at(found, ahead) != "noun":
        yield None
    if kind_at(found, ahead) == "noun":
        yield found[ahead].value.types


def _before(found: Sequence[Symbol], at: int) -> set[str]:
    kinds, back = set[str](), at - 1
    while back >= 0 and found[back].kind in ("all", "other", "colour", *IN_ORDER, *ARTICLES):
        kinds.add(found[back].kind)
        back -= 1
    return kinds


def _has_noun(found: Sequence[Symbol], at: int) -> bool:
    return kind_at(found, at + 1) == "noun"


def _is_place(found: Sequence[Symbol], at: int) -> bool:
    """Whether a word of where comes before the articles here."""
    while kind_at(found, at - 1) in ARTICLES:
        at -= 1
    return kind_at(found, at - 1) == "relation"


def _is_meant(name: str, evidence: _Evidence, scene: Scene | None) -> bool:
    thing = scene.get(name) if scene is not None else None
    kind, colour, needs_colour = _looks(name)
    if thing is not None and scene is not None:
        alike = [each for each in scene.things if each.type == thing.type]
        kind, colour = thing.type, thing.colour
        needs_colour = len({each.colour for each in alike}) > 1
    if kind in evidence.every or (evidence.is_every and kind not in CONTAINERS):
        return True
    by_colour = any(
        _may_be(thing, colour, one) and (types is None or kind in types) for one, types in evidence.coloured
    )
    return by_colour or (not needs_colour and kind in evidence.one)


def _may_be(thing: Thing | None, colour: str, said: str) -> bool:
    return colour == said if thing is None else has_colour(thing, said) is not False


def _looks(name: str) -> tuple[str, str, bool]:
    """The type and the colour in a name, and whether it has a colour."""
    parts = name.split("_")
    words = lexicon(lexicons()[0]).data
    kind = next((part for part in parts if part in words["types"]), name)
    colour = next((part for part in parts if part in words["colours"]), "")
    return kind, colour, bool(colour)


def _numbers(goal: Goal) -> Iterator[tuple[str, float]]:
    for each in goal.all:
        if isinstance(each, AtPlace):
            yield from ((each.at, each.x), (each.at, each.y))
        elif isinstance(each, Beyond) and each.gap_m is not None:
            yield each.pair[0], each.gap_m
        elif isinstance(each, Shifted):
            yield from ((each.shifted, metres) for metres in (each.dx, each.dy) if metres)


def _is_of_first_pose(name: str, number: float, goal: Goal, evidence: _Evidence, scene: Scene | None) -> bool:
    """Whether a coordinate is one where another thing of a swap is, where the thing itself is, or so far from there."""
    if _is_exchanged(name, goal, evidence, scene):
        return True
    thing = scene.get(name) if scene is not None else None
    if thing is None or not (evidence.is_shift or evidence.is_stay):
        return False
    offs = [number - coordinate for coordinate in (thing.x, thing.y)]
    return any(abs(off) <= SAME_PLACE or (evidence.is_shift and evidence.has_number(off)) for off in offs)


def _is_exchanged(name: str, goal: Goal, evidence: _Evidence, scene: Scene | None) -> bool:
    """Whether a thing is wanted where another one of the goal is now, and the request is about a swap."""
    if scene is None or not evidence.is_swap:
        return False
    others = [thing for thing in scene.things if thing.name in goal.things() and thing.name != name]
    return any(
        math.hypot(each.x - thing.x, each.y - thing.y) <= SAME_PLACE
        for each in goal.of_kind(AtPlace)
        if each.at == name
        for thing in others
    )
