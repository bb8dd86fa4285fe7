# SPDX-License-Identifier: Apache-2.0
"""Sentences of a robot's own that start a mission: `find the cup` for `start with task find and object cup`.

A text that is given may quote the sentence: `stack {rest}` gives the request `stack {rest}`, with the same words.
Rule: a sentence of this kind is a start like any other: read back, confirmed, and judged.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.conversation.grammar.arguments import BadValue, key_value
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.phrases import SLOT, AnyPhrase, Phrases, example_of, without_slots
from rai_missions.conversation.view import KeyView, MissionView
from rai_missions.planning.text.normalise import NEAREST as LEAST_MENDED
from rai_missions.planning.text.normalise import nearest
from rai_missions.planning.text.numbers import number
from rai_missions.profile.conversation import SentenceArguments

__all__ = ("Names", "StartPhrases", "arguments_of")

VALUE = "…"
"""The plainest sentence of a phrase that needs no word but a value."""
NOUN = re.compile(r"\b(\w+) \{\1\}")
"""A slot with its name ahead of it, which a pronoun lacks: `aisle {aisle}`."""
WORD = re.compile(r"[^\W\d_]+")
DIGITS = re.compile(r"\d+")
MOST_DESCRIBING = 4
"""Words ahead of a listed value that may describe it."""

Names = Mapping[str, Mapping[str, Any]]
"""Argument → the words for each of its values, where it has no other values."""


class CompiledPhrase(NamedTuple):
    """A phrase that can be matched."""

    phrases: Phrases
    listed: Phrases
    """The phrases with listed values alone, where there are such, and with two objects: `bring Anna the letter`."""
    phrase: str
    """As in a language's file; `{key}` is the value of an argument."""
    arguments: Mapping[str, Any]
    """The arguments that it gives without words for them; in a text `{name}` is what the sentence has there."""
    own: Phrases
    """The phrases with the verb of its author alone, and no other of its sense."""
    words: frozenset[str]
    """Its own words around the values."""
    lacking: Mapping[str, Phrases]
    """Argument → the phrases without its value."""
    keys: frozenset[str]
    """Every argument that it gives."""
    is_value: bool
    """Whether a value alone fits it: it is read last, and only with values that there are."""


class OrderKind(NamedTuple):
    """What the phrases of one kind of order have."""

    slots: frozenset[str]
    """The arguments that they give."""
    words: frozenset[str]
    """Their words around these."""


def arguments_of(slots: frozenset[str], given: Mapping[str, Any]) -> frozenset[str]:
    """Every argument that a sentence gives: its own, and its slots but for those that a text quotes.

    Args:
        slots: The slots of the sentence.
        given: Argument → value.
    """
    quoted = {name for value in given.values() if isinstance(value, str) for name in SLOT.findall(value)}
    return (slots - quoted) | given.keys()


def _filled(value: Any, slots: Mapping[str, str]) -> Any:
    return SLOT.sub(lambda found: slots.get(found[1], ""), value).strip() if isinstance(value, str) else value


class StartPhrases:
    """The sentences of a profile.

    Args:
        given: Each of them → the arguments that it gives without words for them.
        names: Argument → the words for each of its values, where it has no other values.
        language: Its articles, numbers and parts.

    Raises:
        UsageError: A phrase is not closed, or names a part that does not exist.
    """

    def __init__(self, given: SentenceArguments, names: Names, language: Language) -> None:
        self._names, self._language = names, language
        data = language.data
        spatial = language.spatial - frozenset(data["prepositions"])
        joints = frozenset([*data["order_joints"], language.text("or")])
        self._undecided = spatial | joints | frozenset(data["no_thing"]["any"])
        no_value = "|".join(map(re.escape, sorted(language.articles.difference(data["numbers"]))))
        self._free = rf"(?:(?:{no_value}) )*(?!(?:{no_value}) )\S+ (?:\S+ )*?"
        """The regular expression of a value that is of no list: an article alone is none, unless it is a number."""
        self._joining = language.spatial.union(language.articles, data["prepositions"], data["half_words"])
        self._joints = frozenset([*data["clause_joints"], *data["lead"]])
        self._ways = {
            argument: {way: value for name, value in choices.items() for way in self._ways_of(name)}
            for argument, choices in names.items()
        }
        self.names = frozenset(way for ways in self._ways.values() for way in ways)
        """The words of each listed value, in each way in which it is called."""
        self._each = [self._compiled(phrase, arguments) for phrase, arguments in given.items()]
        own = [each for each in self._each if not each.is_value]
        self.own_words = frozenset().union(*(each.words for each in own))
        """The words around the values, as the author of the profile has them."""
        self._openings = AnyPhrase(pattern for each in own for pattern in (each.phrases.pattern, each.listed.pattern))
        self.words = frozenset().union(*self.names, *(each.phrases.words for each in self._each))

    def _ways_of(self, name: str) -> Iterator[tuple[str, ...]]:
        """The ways in which a value is called, each without its article as well: `the family` is `family`."""
        for way in self._language.ways_of(name):
            yield way
            yield from [way[1:]] if len(way) > 1 and way[0] in self._language.articles else []

    def _compiled(self, phrase: str, arguments: Mapping[str, Any]) -> CompiledPhrase:
        phrases = self._language.order_phrases([phrase])
        two = self._language.with_two_objects(phrase, self._names)
        receiver = SLOT.search(two[0]) if two else None
        slots = {**dict.fromkeys(phrases.slots, self._free), **self._listed(() if receiver is None else (receiver[1],))}
        each = [NOUN.sub(r"[\1] {\1}", one) for one in (phrase, *two)]
        listed = self._language.order_phrases(each, slots)
        keys, is_value = arguments_of(phrases.slots, arguments), example_of(phrase) == VALUE
        own, words = self._language.own_phrases([phrase]), frozenset(WORD.findall(SLOT.sub(" ", phrase)))
        parts = without_slots(phrase, self._joining) if not is_value else {}
        lacking = {name: self._language.order_phrases(each, slots) for name, each in parts.items()}
        return CompiledPhrase(phrases, listed, phrase, arguments, own, words, lacking, keys, is_value)

    def _listed(self, receivers: Collection[str]) -> Mapping[str, str]:
        """The regular expressions of the values that an argument lists, and of one who receives what has an article.

        Args:
            receivers: Arguments of such.
        """
        data = self._language.data
        articles = f"(?:(?:{'|'.join(map(re.escape, sorted(self._language.articles)))}) )?"
        persons = "|".join(map(re.escape, data["receivers"]))
        pronouns, substitutes = ("|".join(map(re.escape, data[each])) for each in ("thing_pronouns", "substitutes"))
        counted = "|".join(map(re.escape, [*sorted(self._language.articles), *data["numbers"], *data["owners"]]))
        slots = dict.fromkeys(receivers, rf"(?:(?:{persons}) |(?:[^\W\d]+ ){{1,2}}?)(?=(?:{counted}|\d+) )")
        for name in self._names:
            ways = sorted((" ".join(way) for way in self.named_values(name)), key=len, reverse=True)
            others = f"|{pronouns}" + (f"|{persons}" if name in receivers else "")
            slots[name] = f"{articles}(?:{'|'.join(map(re.escape, ways))}{others}) (?:(?:{substitutes}) )?"
        return slots

    def examples(self, missions: Sequence[MissionView]) -> tuple[str, ...]:
        """A plain sentence for each phrase that starts one of the missions: `go to …`."""
        keys = [mission.keys.keys() for mission in missions]
        own = [each for each in self._each if not each.is_value]
        starting = (each.phrase for each in own if any(each.keys <= names for names in keys))
        return tuple(dict.fromkeys(example_of(phrase) for phrase in starting))

    def plain_phrases(self, mission: MissionView) -> Iterator[tuple[Sequence[str], Mapping[str, Any]]]:
        """The plain sentences of each phrase that starts a mission, `find {object}`, with what it gives."""
        names = mission.keys.keys()
        for each in self._each:
            if not each.is_value and each.keys <= names:
                yield self._language.order_examples(each.phrase), each.arguments

    def of_kind(self, given: Mapping[str, Any]) -> OrderKind:
        """What the phrases with the same arguments of their own have, `watch {zone} for {watch_min} minutes`.

        Args:
            given: The arguments of a start.
        """
        each = [one for one in self._each if not one.is_value and one.arguments.items() <= given.items()]
        words = frozenset().union(*(one.words for one in each))
        return OrderKind(frozenset().union(*(one.keys for one in each)), words)

    def begin(self, words: Sequence[str]) -> bool:
        """Whether the words begin with one of the phrases, but for those that a value alone fits."""
        return self._openings.begin(words)

    def senses(
        self, words: Sequence[str], missions: Sequence[MissionView], before: Sequence[Sequence[str]] = ()
    ) -> Iterator[Sense]:
        """The starts that the words are; of several phrases that fit, one without values, else the one with most.

        Args:
            words: The words of a sentence.
            missions: Those that can be started.
            before: What was uttered before, the last at the end: a pronoun is the value that was named last.
        """
        is_one = self._openings.fits(words)
        return self._fitting(words, missions, [each for each in self._each if is_one and not each.is_value], before)

    def incomplete(self, words: Sequence[str], missions: Sequence[MissionView]) -> Iterator[Sense]:
        """The start whose one value the words lack, `escort the guest` of `escort {person} to {door}`, as a fault."""
        for mission in missions:
            keys, texts = mission.keys, self._texts(mission.keys)
            each = (one for one in self._each if one.keys <= keys.keys())
            lacking = ((one, name, part) for one in each for name, part in one.lacking.items() if name in keys)
            for one, name, part in lacking:
                for slots in part.match(words):
                    sense = self._start(mission, slots, one, ())
                    if sense.kind == "order" and texts.isdisjoint(slots):
                        yield sense._replace(kind="fault", fault=self._asked_for(name), lacks=(name,))
                        return

    def _asked_for(self, argument: str) -> str:
        """The question which value an argument is to have."""
        name, known = self._language.name_of(argument), [spoken(each) for each in self.choices(argument)]
        values = self._language.listed(known, "or")
        return self._language.text("correct_from" if known else "correct", name=name, values=values)

    def valued(self, words: Sequence[str], missions: Sequence[MissionView]) -> Iterator[Sense]:
        """The starts that a value alone is: `the kitchen`."""
        found = self._fitting(words, missions, [each for each in self._each if each.is_value])
        return (sense for sense in found if sense.kind == "order")

    def _fitting(
        self,
        words: Sequence[str],
        missions: Sequence[MissionView],
        phrases: Sequence[CompiledPhrase],
        before: Sequence[Sequence[str]] = (),
    ) -> Iterator[Sense]:
        for mission in missions:
            keys = mission.keys
            texts = self._texts(keys)
            fitting = [
                (slots, each)
                for each in phrases
                if each.keys <= keys.keys()
                for slots in (*each.listed.match(words), *each.phrases.match(words))
                if all(self.may_be_thing(slots[name].split()) for name in slots.keys() & texts)
            ]
            starts = [(self._start(mission, slots, each, before), slots, each) for slots, each in fitting]
            closed = [one for one in starts if one[0].kind == "order" and texts.isdisjoint(one[1])]
            if starts:  # those that have a value for every word come first
                yield self._closest(closed or starts, words, texts)

    def _closest(
        self,
        starts: Sequence[tuple[Sense, Mapping[str, str], CompiledPhrase]],
        words: Sequence[str],
        texts: Collection[str],
    ) -> Sense:
        """The best of several starts: one without values, else of those with most values the one that fits best.

        Its values fit, in their own slots; it has most of a list or a number, and the verb of its own phrase.
        """
        most = max(len(slots) or math.inf for _, slots, _ in starts)
        return max(
            (one for one in starts if (len(one[1]) or math.inf) == most),
            key=lambda one: (
                one[0].kind == "order",
                len((one[1].keys() - texts).intersection(one[0].named)),
                one[2].own.fits(words),
            ),
        )[0]

    def _texts(self, keys: Mapping[str, KeyView]) -> frozenset[str]:
        """The arguments that take any words."""
        return frozenset(name for name, key in keys.items() if key.type == "string" and name not in self._names)

    def may_be_thing(self, words: Sequence[str]) -> bool:
        """Whether words may name something: not `out what it is`, of `find out what it is`; nor `cup and go to bed`."""
        excluded = self._language.data["no_thing"]
        is_article = len(words) > 1 and words[0] in self._language.articles
        is_speaker = len(words) == 1 and words[0] in self._language.data["speakers"]
        is_named = (is_speaker or words[is_article] not in excluded["first"]) and not set(words) & set(excluded["any"])
        return is_named and not any(
            self.begin(words[at + 1 :]) for at, each in enumerate(words) if each in self._joints
        )

    def _start(
        self,
        mission: MissionView,
        slots: Mapping[str, str],
        phrase: CompiledPhrase,
        before: Sequence[Sequence[str]],
    ) -> Sense:
        keys = mission.keys
        values: dict[str, Any] = {name: _filled(value, slots) for name, value in phrase.arguments.items()}
        named, faults = list[str](), dict[str, str]()
        for name, words in ((name, words.split()) for name, words in slots.items() if name in keys):
            place = name
            try:
                values[name] = self.value(words, keys[name])
            except BadValue as error:
                meant = [] if phrase.is_value else self._ending(words, keys[name]) or self._purposed(words, keys[name])
                meant = meant or self._named_last(words, keys[name], before)
                others = self._of_others(words, mission, slots.keys() | values.keys()) if len(slots) > 1 else {}
                if meant:
                    values[name] = meant[0]
                elif len(others) == 1:
                    ((place, values[place]),) = others.items()
                else:
                    faults[name] = str(error)
            named.append(place)
        sense = Sense("order", "start", mission=mission.name, arguments=values, named=tuple(named))
        if faults:
            sense = sense._replace(kind="fault", fault=next(iter(faults.values())), lacks=tuple(faults))
        return sense

    def _named_last(self, words: Sequence[str], key: KeyView, before: Sequence[Sequence[str]]) -> list[Any]:
        """The listed value for a pronoun: the one of its argument that was named last, with no other next to it."""
        if not self._is_pronoun(words) and " ".join(words) not in self._language.data["pronouns"]:
            return []
        return next((list(found) for each in reversed(before) if len(found := self.named_in(each, key.name)) == 1), [])

    def named_in(self, words: Sequence[str], argument: str) -> tuple[Any, ...]:
        """The listed values of an argument that words name, each once."""
        ways = self.named_values(argument).items()
        found = (value for way, value in ways for at in range(len(words)) if tuple(words[at : at + len(way)]) == way)
        return tuple(dict.fromkeys(found))

    def is_certain(self, words: Sequence[str]) -> bool:
        """Whether words name one listed value of each argument at the most: no choice, of which none is meant."""
        return all(len(self.named_in(words, argument)) < 2 for argument in self._names)

    def _of_others(self, words: Sequence[str], mission: MissionView, given: Collection[str]) -> Mapping[str, Any]:
        """The other arguments that list these words as a value: the place of `take the cup to the kitchen`."""
        bare = self._language.without_articles(words)
        found = {key.name: self._meant(bare, key) for key in mission.arguments if key.name not in given}
        return {name: values[0] for name, values in found.items() if values}

    def quoted_with(self, given: Mapping[str, Any], words: Sequence[str]) -> Mapping[str, Any] | None:
        """Arguments in which a text quotes a sentence, with these words in it; None where that leaves it open.

        Words that begin with a preposition replace what follows the last one; others the whole, if that has none.

        Args:
            given: The arguments of a start.
            words: What is to be in the sentence instead.
        """
        prepositions = self._language.data["prepositions"]
        for each in self._each:
            for name, text in each.arguments.items():
                slots = self._slots_of(each, given.get(name)) if isinstance(text, str) and SLOT.search(text) else None
                if slots is None or len(slots) != 1:
                    continue
                ((slot, before),) = slots.items()
                at = [place for place, word in enumerate(before.split()) if word in prepositions]
                if bool(at) != (words[0] in prepositions):
                    return None
                rest = [*before.split()[: at[-1] if at else 0], *words]
                return {**given, name: _filled(text, {slot: " ".join(rest)})}
        return None

    def _slots_of(self, each: CompiledPhrase, value: Any) -> Mapping[str, str] | None:
        return next(each.phrases.match(value.split()), None) if isinstance(value, str) else None

    def choices(self, argument: str) -> Mapping[str, Any]:
        """The words for each value of an argument that has no other values; empty where it has any."""
        return self._names.get(argument, {})

    def named_values(self, argument: str) -> Mapping[tuple[str, ...], Any]:
        """The words for each value of an argument that has no other values, in each way in which it is called."""
        return self._ways.get(argument, {})

    def _meant(self, words: Sequence[str], key: KeyView) -> list[Any]:
        """The values of an argument that are called so, or but for a letter; `livingroom` is one of two words.

        The argument's name may be next to it, `old mast`, and a word in its place: `old one`.
        """
        called = {"".join(way): value for way, value in self.named_values(key.name).items()}
        called |= {name.lower().replace(" ", ""): value for name, value in self.choices(key.name).items()}
        ways = [words] if called else []
        if len(words) > 1 and called:
            ways += [words[:-1]] * (words[-1] in (*self._language.data["substitutes"], key.name))
            ways += [words[1:]] * (words[0] == key.name)
        return next(filter(None, (self._called(way, called) for way in ways)), [])

    @staticmethod
    def _called(words: Sequence[str], called: Mapping[str, Any]) -> list[Any]:
        given = "".join(words)
        meant = nearest(given, called) if len(given) >= LEAST_MENDED else given
        is_same = DIGITS.findall(meant) == DIGITS.findall(given)  # `bed 4` is no slip for `bed 3`
        return [called[meant]] if meant in called and is_same else []

    def _given(self, words: Sequence[str], bare: Sequence[str], key: KeyView) -> Any:
        """The value of words with their article, where that is a number: `eine Minute`; else of those without it.

        Raises:
            BadValue: They are none.
        """
        with contextlib.suppress(BadValue):
            if key.type != "string":
                return key_value(words, key, self._language)
        return key_value(bare, key, self._language)

    def _ending(self, words: Sequence[str], key: KeyView) -> list[Any]:
        """The values of an argument that words end with, after a few that describe it: `mum in the kitchen`.

        None where they may be another place: `the office next to the kitchen`, `the kitchen or the study`.
        """
        if set(words) & self._undecided:
            return []
        starts = range(1, min(len(words), MOST_DESCRIBING + 1))
        at, meant = next(((at, meant) for at in starts if (meant := self._meant(words[at:], key))), (0, []))
        is_behind_another = any(self._meant(words[begin:end], key) for end in range(at + 1) for begin in range(end))
        return [] if is_behind_another else meant

    def _purposed(self, words: Sequence[str], key: KeyView) -> list[Any]:
        """The values of an argument that words begin with, ahead of what it is for: `old mast for damage`.

        None where that has a number, or names a value.
        """
        bare = self._language.without_articles(words)
        at = next((at for at, word in enumerate(bare) if word in self._language.data["purposes"]), len(bare))
        rest = bare[at + 1 :]
        is_named = any(self.named_in(rest, name) for name in self._names)
        is_plain = 0 < len(rest) <= MOST_DESCRIBING and not is_named
        return (
            self._meant(bare[:at], key)
            if is_plain and not any(number([each], self._language.data) for each in rest)
            else []
        )

    def argument(self, words: Sequence[str], key: KeyView, language: Language) -> Any:
        """The value of an argument that is named: by its words, or as the mission has it.

        Raises:
            BadValue: They are none of its type.
        """
        meant = self._meant(words, key)
        return meant[0] if meant else key_value(words, key, language)

    def _is_pronoun(self, words: Sequence[str]) -> bool:
        """Whether words are in place of a thing that is named elsewhere: `it`, `it first`."""
        data = self._language.data
        first = next(iter(words), "")
        return " ".join(words) in data["pronouns"] or (
            first in data["thing_pronouns"] and first not in self._language.articles
        )

    def value(self, words: Sequence[str], key: KeyView) -> Any:
        """The value that words are for a key, without the article before them.

        Raises:
            BadValue: They are none.
        """
        articles = self._language.articles
        given = " ".join(words)
        is_article = bool(words) and all(word in articles for word in words)
        if key.type == "string" and (is_article or self._is_pronoun(words)):
            given = given if is_article or given in self._language.data["pronouns"] else words[0]
            raise BadValue(self._language.text("pronoun", given=given, name=self._language.name_of(key.name)), key.name)
        bare = list(words[1:] if len(words) > 1 and words[0] in articles else words)
        if key.name not in self._names:
            return self._given(words, bare, key)
        if meant := self._meant(bare, key):
            return meant[0]
        known = self._language.listed([spoken(name) for name in self._names[key.name]], "or")
        raise BadValue(
            self._language.text("bad_value", given=" ".join(bare), name=self._language.name_of(key.name), type=known)
        )
