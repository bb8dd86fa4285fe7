# SPDX-License-Identifier: Apache-2.0
"""Corrections: `no, the plant` and `the other one`, for the order that was read back, dropped or refused last.

Rule: a correction is an order of its own, which is read back whole; nothing is taken from it silently.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.conversation.grammar.arguments import BadValue
from rai_missions.conversation.grammar.senses import Sense, joined
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import Language
from rai_missions.conversation.language.question_words import question_text
from rai_missions.conversation.view import KeyView, StatusView
from rai_missions.planning.text.numbers import number

__all__ = ("Corrections", "Draft")

HALF = ("half_words", "prepositions", "correcting", "substitutes", "fillers")
"""The lists of a language whose words are around the values of a half sentence."""
JOINING = ("half_words", "correcting")
"""The lists of words by which a half sentence is joined to the order before it."""
LONGEST = 4
"""Words of the longest text that replaces another one."""


class Draft(NamedTuple):
    """The order that a sentence may correct."""

    sense: Sense
    is_asked_for: bool = False
    """Nothing is read back, and the order lacks what the person wants: a value alone completes it."""
    is_read_back: bool = False
    """It waits for a yes: a value alone is a correction where it is one of a list."""
    is_of_another: bool = False
    """Another person gave it: what this one wants as well may be like it, and nothing corrects it."""


class NamedPart(NamedTuple):
    """A value of an argument that a half sentence names."""

    name: str
    value: Any
    is_refused: bool = False


class Corrections:
    """Reads corrections of one language.

    Args:
        language: Its data.
        phrases: The robot's own sentences, and the words for its values.
    """

    def __init__(self, language: Language, phrases: StartPhrases) -> None:
        self._language, self._phrases = language, phrases
        data = language.data
        whole = [word for name in HALF for each in data[name] for word in each.split()]
        self._around = language.articles.union(whole)
        self._halves = frozenset(data["halves"])
        """Of what was before, where they are alone: `half of that`."""
        self._joining = frozenset(word for name in JOINING for word in data[name]) - language.articles
        self._repeating = frozenset(data["repeating"])
        self._refusing = language.negations.difference(data["correcting"])
        named = frozenset(word for name in phrases.names for word in name)
        measured = (word for units in data["unit_words"].values() for unit in units for word in unit.split())
        numbers = (*data["numbers"], *data["hundred"], data["point"], data["number_joint"])
        self._half_words = self._around | self._refusing | named | phrases.own_words | {*measured, *numbers}

    def half(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        """The draft with the values that a half sentence names: `the hot tub as well, but to 37`; None for other talk.

        A half sentence has values of the draft's mission, and nothing else but words without a meaning of their own.
        A value behind a negation is none of them, where another one of its argument is: `not the student, the guest`.
        Where nothing is open, a word must join it to the order that was taken: `now the hot tub`.
        """
        is_half = all(word in self._half_words or number([word], self._language.data) is not None for word in words)
        joints = self._repeating if draft.is_of_another else self._joining
        is_open = draft.is_read_back or draft.is_asked_for or not joints.isdisjoint(words)
        orders = (draft.sense.orders or (draft.sense,)) if is_half and is_open else ()
        return _with_one(orders, [self._half(words, draft._replace(sense=order), view) for order in orders], draft)

    def names(self, words: Sequence[str], sense: Sense, view: StatusView) -> bool:
        """Whether words are a half sentence whose values are all of a start: `the lobby` of `patrol the lobby`."""
        found = list(self._values_in(words, sense, view))
        return bool(found) and all(each is not None and sense.arguments.get(each.name) == each.value for each in found)

    def is_around(self, word: str) -> bool:
        """Whether a word has no meaning of its own in a half sentence."""
        return word in self._around

    def _half(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        found = list(self._values_in(words, draft.sense, view))
        if not found or None in found:
            return None
        named = [each for each in found if each is not None]
        values = {each.name: each.value for each in named if not each.is_refused}
        refused = {each.name for each in named if each.is_refused}
        before = draft.sense.arguments
        is_other = any(before.get(name) != value for name, value in values.items())
        if len(values) + sum(each.is_refused for each in named) < len(named) or not refused <= values.keys():
            return None
        return self._with(draft, values) if is_other else None

    def _values_in(self, words: Sequence[str], sense: Sense, view: StatusView) -> Iterator[NamedPart | None]:
        """Each value that words name for a start, in its turn, and None for each word that a half sentence has not."""
        if sense.name != "start":
            return
        keys, plain = self._keys(sense, view), self._phrases.of_kind(sense.arguments)
        names = dict.fromkeys((*sense.lacks, *sense.named, *sense.arguments, *sorted(plain.slots)))
        given = [keys[name] for name in names if name in keys]
        at, is_refused = 0, False
        while at < len(words):
            part, size = self._value_at(words[at:], given, sense)
            if part is not None:
                yield part._replace(is_refused=is_refused)
                is_refused = False
            elif words[at] in self._refusing:
                is_refused = True
            elif words[at] not in self._around and words[at] not in plain.words:
                yield None
            at += size or 1

    def _value_at(self, words: Sequence[str], keys: Sequence[KeyView], sense: Sense) -> tuple[NamedPart | None, int]:
        """The value that words begin with, and how many they are: of the first argument that has it."""
        for size in range(min(len(words), LONGEST + 1), 0, -1):
            span = list(words[:size])
            if span[0] in self._language.articles or self._around.issuperset(span) or " ".join(span) in self._halves:
                continue
            for key in keys:
                listed = self._phrases.named_values(key.name)
                before = sense.arguments.get(key.name)
                if (listed or key.type in ("integer", "number")) and self._fits(span, key, before):
                    return NamedPart(key.name, self._value(span, key, before)), size
        return None, 0

    def instead(self, words: Sequence[str]) -> Iterator[list[str]]:
        """What is to be in place of what was meant, the shortest first: `the plant` of `no, the plant, I mean`."""
        found = (slots["instead"].split() for slots in self._language.correction.match(words))
        yield from sorted(found, key=len)

    def corrected(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        """The draft with these words in place of one of its values, or what is wrong with them; None for other talk.

        Of a list, the one order that they fit is corrected.
        """
        if not draft.sense.then:
            return self._corrected(words, draft, view)
        orders = draft.sense.orders
        found = [self._corrected(words, draft._replace(sense=order), view) for order in orders]
        made = [each if each is not None and each.kind == "order" else None for each in found]
        fault = Sense("fault", "start", fault=self._language.text("correct_whole")) if any(found) else None
        return _with_one(orders, made, draft) or fault

    def _corrected(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        sense = draft.sense
        if sense.name != "start" or len(words) > LONGEST + 1:
            return None
        quoted = None if sense.named or sense.lacks else self._phrases.quoted_with(sense.arguments, words)
        if quoted is not None and not draft.is_asked_for:
            return sense._replace(arguments=quoted, kind="order", rest="", is_correction=draft.is_read_back)
        bare = self._without_preposition(words)
        keys = self._keys(sense, view)
        named = [keys[name] for name in dict.fromkeys((*sense.lacks, *sense.named)) if name in keys]
        closed = [keys[name] for name in sense.arguments if name in keys and self._phrases.choices(name)]
        for key in sorted((*named, *closed), key=lambda each: each.type == "string"):  # `seven` is a number first
            is_listed = self._phrases.choices(key.name) or key.type != "string"
            if is_listed and self._fits(bare, key, sense.arguments.get(key.name)):
                return self._with(draft, {key.name: self._value(bare, key, sense.arguments.get(key.name))})
        for key in (*named, *closed):
            if (found := self._choice_in(bare, key)) is not None:
                return self._with(draft, {key.name: found.value})
        texts = [key for key in named if key.type == "string" and not self._phrases.choices(key.name)]
        if len(texts) == 1 and bare == list(words) and len(bare) <= LONGEST and self._is_text(bare, texts[0], draft):
            return self._with(draft, {texts[0].name: self._value(bare, texts[0], sense.arguments.get(texts[0].name))})
        return self._fault(sense, bare, named)

    def _choice_in(self, words: Sequence[str], key: KeyView) -> NamedPart | None:
        """The one listed value whose name has each of the words: `east wing` of `the one in the east`."""
        bare = {word for word in words if word not in self._around}
        ways = self._phrases.named_values(key.name).items()
        having = {str(value): NamedPart(key.name, value) for way, value in ways if bare and bare.issubset(way)}
        return next(iter(having.values())) if len(having) == 1 else None

    def _is_text(self, words: Sequence[str], key: KeyView, draft: Draft) -> bool:
        """Whether words may be the text: they name a thing, and it is asked for, or marked as a correction."""
        if not self._phrases.may_be_thing(words):
            return False
        return not draft.is_asked_for or key.name in draft.sense.lacks or words[0] in self._language.articles

    def completed(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        """The draft with these words alone, where a value may be meant; None where they are none."""
        bare, keys = self._without_preposition(words), self._keys(draft.sense, view)
        is_marked = len(bare) < len(words)
        given = [keys[name] for name in draft.sense.arguments if name in keys]
        listed = (key for key in given if self._phrases.choices(key.name) or (is_marked and key.type != "string"))
        is_value = draft.is_asked_for or (draft.is_read_back and any(self._fits(bare, key) for key in listed))
        found = self.corrected(words, draft, view) if is_value else None
        return found if found is not None and found.kind == "order" else None

    def other(self, draft: Draft, view: StatusView) -> Sense:
        """The only other choice that there is, or the question for another one."""
        sense, language = draft.sense, self._language
        if sense.then:
            return Sense("other", fault=language.text("correct_whole"))
        if sense.name == "answer":
            question = view.question(sense.question)
            offers = question.options if question is not None else ()
            others = [offer for offer in offers if offer.name != sense.option]
            if len(others) == 1 and len(offers) == 2 and not (others[0].parameters or {}).get("required"):
                return sense._replace(option=others[0].name, parameters={}, is_partial=True, is_correction=True)
            return sense._replace(kind="other", fault="" if question is None else question_text(question, language))
        keys = self._keys(sense, view)
        named = [keys[name] for name in (sense.lacks or sense.named) if name in keys]
        if len(named) != 1:
            return sense._replace(kind="other", fault=language.text("correct_whole"))
        name, choices = language.name_of(named[0].name), self._phrases.choices(named[0].name)
        values = {word: value for word, value in choices.items() if value != sense.arguments.get(named[0].name)}
        if len(values) == 1 and len(choices) == 2:
            return self._with(draft, {named[0].name: next(iter(values.values()))})
        known = language.listed(list(values), "or")
        fault = language.text("correct_from" if known else "correct", name=name, values=known)
        return sense._replace(kind="other", fault=fault, lacks=(named[0].name,))

    def _without_preposition(self, words: Sequence[str]) -> list[str]:
        has_one = len(words) > 1 and words[0] in self._language.data["prepositions"]
        return list(words[1:] if has_one else words)

    def _keys(self, sense: Sense, view: StatusView) -> Mapping[str, KeyView]:
        mission = view.mission_named(sense.mission)
        return mission.keys if mission is not None else {}

    def _value(self, words: Sequence[str], key: KeyView, before: Any = None) -> Any:
        """The value of the words; a part of them may be as it was: `the blue one`, and `five` for `ward three`.

        A number may be an ordinal: `the third one`.
        """
        ordinals, substitutes = self._language.data["ordinals"], self._language.data["substitutes"]
        first, *rest = self._language.without_articles(words) or [""]
        if key.type == "integer" and len(first) > 1 and first in ordinals and set(rest) <= set(substitutes):
            return self._phrases.value([str(ordinals[first])], key)
        is_substitute = len(words) > 1 and words[-1] in substitutes
        listed = self._phrases.named_values(key.name)
        if is_substitute and isinstance(before, str) and before and not listed:
            words = [*words[:-1], before.split()[-1]]
        nouns = dict.fromkeys(way[:-1] for way, value in listed.items() if value == before)
        ways = ([*noun, *self._language.without_articles(words)] for noun in nouns)
        return self._phrases.value(next((way for way in ways if tuple(way) in listed), words), key)

    def _fits(self, words: Sequence[str], key: KeyView, before: Any = None) -> bool:
        try:
            self._value(words, key, before)
        except BadValue:
            return False
        return True

    def _with(self, draft: Draft, values: Mapping[str, Any]) -> Sense:
        sense = draft.sense
        lacks = tuple(name for name in sense.lacks if name not in values)
        named = tuple(dict.fromkeys((*sense.named, *values)))
        arguments = {**sense.arguments, **values}
        made = sense._replace(arguments=arguments, named=named, lacks=lacks, rest="", is_correction=draft.is_read_back)
        return made._replace(kind="fault") if lacks else made._replace(kind="order", fault="")

    def _fault(self, sense: Sense, words: Sequence[str], named: Sequence[KeyView]) -> Sense:
        fault = self._language.text("correct_unclear", given=" ".join(words))
        if len(named) == 1:
            try:
                self._value(words, named[0])
            except BadValue as error:
                fault = str(error)
        return sense._replace(kind="fault", fault=fault)


def _with_one(orders: Sequence[Sense], made: Sequence[Sense | None], draft: Draft) -> Sense | None:
    """The orders of a draft with the one that was made in the place of its own; None unless it is one."""
    if sum(each is not None for each in made) != 1:
        return None
    both = zip(made, orders, strict=True)
    return joined([each or order for each, order in both])._replace(is_correction=draft.is_read_back)
