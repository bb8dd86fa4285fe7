# SPDX-License-Identifier: Apache-2.0
"""Which things of a scene a phrase may be.

Rule: a phrase for one thing that fits several has several meanings; one that fits none is refused: it is absent.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.phrases import Phrase, Rank, Unread
from rai_missions.planning.reading.ranks import choices
from rai_missions.planning.relations import covers
from rai_missions.planning.scene import CONTAINERS, DESK, Scene, Thing, has_colour
from rai_missions.planning.text.language_file import spoken

__all__ = ("Names", "Things")

Names = tuple[str, ...]
COLOURED = frozenset({"cube"})
"""Types that are called by their colour alone: `red on blue`."""


class Things:
    """The things of a scene, as phrases of one request are about them.

    Args:
        scene: What is seen.
        lexicon: For what is asked back.
        phrases: All phrases of the request.
    """

    def __init__(self, scene: Scene, lexicon: Vocabulary, phrases: Sequence[Phrase]) -> None:
        self.scene = scene
        self.lexicon = lexicon
        self._heads = {each: self._heads_before(phrases[:at]) for at, each in reversed([*enumerate(phrases)])}
        self._named = self._mentioned(phrases)

    def alternatives(self, phrase: Phrase, taken: frozenset[str] = frozenset()) -> tuple[Names, ...]:
        """What the phrase may mean: each an alternative, each all of its things.

        Args:
            phrase: The phrase of the request.
            taken: What phrases before it are taken to mean; `the rest` and `the other one` are none of these.

        Raises:
            Unread: It means nothing that is seen, or its number does not fit.
        """
        if phrase.kind == "desk":
            return ((DESK,),)
        found = [names for each in (phrase, *phrase.others) for names in self._of_one(each, taken)]
        if phrase.is_any:  # `a cube in the tray and a cube in the bin` are two, where there are two
            found = [names for names in found if taken.isdisjoint(names)] or found
        return tuple(dict.fromkeys(found))

    def lies_at(self, name: str, place: str) -> bool:
        """Whether a thing lies in or on another one, or on what lies there: its centre is over that one's outline."""
        thing, other = self.scene.get(name), self.scene.get(place)
        if thing is None or other is None or thing is other or (other.type not in CONTAINERS and thing.z <= other.z):
            return False
        return covers(other, thing)

    def is_container(self, name: str) -> bool:
        """Whether it is a thing of the scene that others are put into."""
        thing = self.scene.get(name)
        return thing is not None and thing.type in CONTAINERS

    def listed(self, names: Iterable[str]) -> str:
        """Things in a sentence, as they are spoken of."""
        return self.lexicon.listed([f"'{spoken(name)}'" for name in names])

    def ask(self, text: str, *values: object) -> Unread:
        """What asks back, in the words of the request's language."""
        reason = text if text in ("pronoun", "order") else "unread"
        return self.lexicon.unread(text, *values, reason=reason)

    def _of_one(self, phrase: Phrase, taken: frozenset[str]) -> tuple[Names, ...]:
        if phrase.kind == "tower":
            if not (tops := self._tops()):
                raise self._absent(phrase)
            return tuple((each,) for each in tops)
        if phrase.kind in ("everything", "rest"):
            left_out = self._named | taken if phrase.kind == "rest" else frozenset[str]()
            found = self._set(phrase, [each for each in self._seen(phrase) if each.name not in left_out])
            if phrase.count not in (None, len(found)):
                raise self._ambiguous(phrase, found)
            return (found,)
        matching, perhaps = self._matching(phrase)
        if phrase.epithet and len(matching) + len(perhaps) > 1:
            raise self.lexicon.unread("unknown_word", phrase.epithet)
        if phrase.is_other:
            matching = [each for each in matching if each.name not in self._named | taken]
        if not matching:
            raise self._absent(phrase)
        if phrase.rank is not None:
            return self._ranked(phrase, phrase.rank, matching, perhaps)
        if phrase.is_free and (phrase.count is not None or not phrase.is_many):
            return (self._chosen(phrase, matching, taken),)
        if self._means_all(phrase, matching):
            sets = [matching, [*matching, *perhaps]] if perhaps else [matching]
            return tuple(self._set(phrase, each) for each in sets)
        matching = [*matching, *perhaps]
        if len(matching) > 1 and (phrase.is_many or (phrase.count or 1) > 1 or phrase.is_all):
            raise self._ambiguous(phrase, (each.name for each in matching))
        return tuple((each.name,) for each in matching)

    def _ranked(
        self, phrase: Phrase, rank: Rank, matching: Sequence[Thing], perhaps: Sequence[Thing]
    ) -> tuple[Names, ...]:
        """What comes first of what a phrase may mean, in each sense of it.

        `The leftmost` may be of the kind that was named before, or of all.

        Raises:
            Unread: There are fewer than it counts, or it does not count several.
        """
        heads = self._heads.get(phrase, frozenset()) if not phrase.has_noun else frozenset[str]()
        senses = [matching, [*matching, *perhaps], [each for each in matching if each.type in heads] or matching]
        others = self._references(rank.of) if rank.of is not None else [None]
        found = dict.fromkeys(
            names
            for sense in senses
            for other in others
            for names in choices(self._among(phrase, sense, other), rank, phrase.count or 1, other)
        )
        if not found or (phrase.is_many and phrase.count is None):
            raise self._ambiguous(phrase, (each.name for each in matching))
        return tuple(found)

    def _among(self, phrase: Phrase, things: Sequence[Thing], other: Thing | None) -> list[Thing]:
        return [self.scene.thing(name) for name in self._set(phrase, [each for each in things if each != other])]

    def _references(self, phrase: Phrase) -> list[Thing]:
        """What a distance may be measured from.

        Raises:
            Unread: It is measured from several things.
        """
        meant = self.alternatives(phrase)
        if any(len(names) > 1 for names in meant):
            raise self._ambiguous(phrase, meant[0])
        return [self.scene.thing(name) for (name,) in meant]

    def _chosen(self, phrase: Phrase, matching: Sequence[Thing], taken: frozenset[str]) -> Names:
        """What the arm chooses where it may: of what is meant by no other words, first what nothing lies on.

        Raises:
            Unread: There are fewer.
        """
        left = [name for name in self._set(phrase, matching) if name not in self._named | taken]
        count = phrase.count or 1
        if len(left) < count:
            raise self._ambiguous(phrase, (each.name for each in matching))
        return tuple(sorted(left, key=self._is_covered)[:count])

    def _is_covered(self, name: str) -> bool:
        return any(self.lies_at(other.name, name) for other in self.scene.things)

    def _tops(self) -> Names:
        """The topmost thing of each tower that is seen."""
        movable = self._movable()
        on = {each.name: [other.name for other in movable if self.lies_at(each.name, other.name)] for each in movable}
        carrying = frozenset(name for names in on.values() for name in names)
        return tuple(name for name, below in on.items() if below and name not in carrying)

    def _means_all(self, phrase: Phrase, matching: Sequence[Thing]) -> bool:
        if phrase.count is not None:
            if phrase.count > len(matching):
                raise self._ambiguous(phrase, (each.name for each in matching))
            return phrase.count == len(matching)
        return phrase.is_all or (phrase.is_many and not phrase.is_any)

    def _set(self, phrase: Phrase, things: Iterable[Thing]) -> Names:
        without = set[str]()
        for each in phrase.without:
            meant = self.alternatives(each)
            if len(meant) > 1:
                several = dict.fromkeys(name for names in meant for name in names)
                raise self._ambiguous(each, several)
            without.update(meant[0])
        names = tuple(each.name for each in things if each.name not in without and each.type not in phrase.not_types)
        if not names:
            raise self._absent(phrase)
        return names

    def _matching(self, phrase: Phrase) -> tuple[list[Thing], list[Thing]]:
        """The things that a phrase fits, and further ones of a colour that is not known: it may be meant."""
        found = [each for each in self._seen(phrase) if has_colour(each, phrase.colour) is not False]
        if phrase.is_other and not phrase.has_noun and not phrase.colour:
            found = self._of_heads(self._heads.get(phrase, frozenset())) or found
        if phrase.has_noun or not phrase.colour:
            if len({each.type for each in found}) < 2:
                return found, []
        else:
            found = self._of_colour_alone(phrase, found)
        sure = [each for each in found if has_colour(each, phrase.colour)]
        return (sure, [each for each in found if each not in sure]) if sure else (found, [])

    def _of_colour_alone(self, phrase: Phrase, found: list[Thing]) -> list[Thing]:
        """`the red one` after `the yellow cube` is a cube, and so is `red` alone, where a cube is red.

        `Red` alone after `the apple`, whose colour is open, is no apple.
        """
        heads = self._heads.get(phrase, frozenset[str]())
        alike = [each for each in found if each.type in heads and (phrase.is_one or has_colour(each, phrase.colour))]
        if len({each.type for each in alike}) == 1:
            return alike
        if phrase.is_one or phrase.is_all:
            return found
        return [each for each in found if each.type in COLOURED] or found

    def _of_heads(self, heads: frozenset[str]) -> list[Thing]:
        """What `the other one` may be after these types: of the same type, and after a tray or a bin any of these."""
        types = heads | CONTAINERS if heads & CONTAINERS else heads
        return [each for each in self.scene.things if each.type in types]

    def _seen(self, phrase: Phrase) -> list[Thing]:
        return [each for each in self.scene.things if each.type in phrase.types] if phrase.types else self._movable()

    def _movable(self) -> list[Thing]:
        return [each for each in self.scene.things if each.type not in CONTAINERS]

    def _heads_before(self, phrases: Iterable[Phrase]) -> frozenset[str]:
        """The types that `one` may stand for: of nouns before it, and of things that a colour before it means alone."""
        found = set[str]()
        for phrase in phrases:
            alike = [each for each in self._movable() if phrase.colour and has_colour(each, phrase.colour)]
            if phrase.has_noun:
                found |= phrase.types
            elif len(alike) == 1:
                found.add(alike[0].type)
        return frozenset(found)

    def _mentioned(self, phrases: Iterable[Phrase]) -> frozenset[str]:
        self._named = frozenset[str]()
        names = set[str]()
        phrases = tuple(phrases)
        to_choose = {each for phrase in phrases for each in phrase.others}
        for phrase in phrases:
            is_fixed = not (phrase.is_other or phrase.is_free)
            is_named = phrase.kind == "things" and is_fixed and (phrase.has_noun or phrase.colour)
            if is_named and phrase not in to_choose:
                with suppress(Unread):
                    found = self.alternatives(phrase)
                    names |= set(found[0]) if len(found) == 1 else set()
        return frozenset(names)

    def _absent(self, phrase: Phrase) -> Unread:
        seen = [each.name for each in self.scene.things]
        text = "absent" if seen else "nothing_seen"
        return self.lexicon.unread(text, f"'{phrase.text}'", self.listed(seen), reason="absent", refused=True)

    def _ambiguous(self, phrase: Phrase, names: Iterable[str]) -> Unread:
        return self.lexicon.unread("many", f"'{phrase.text}'", self.listed(names), reason="ambiguous")
