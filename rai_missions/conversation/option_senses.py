# SPDX-License-Identifier: Apache-2.0
"""Options by sense: which of those that are offered a person asks for in words of their own.

A language lists what people write for the usual options: to wait, to go around, to use the horn, to call a person, to
give something up. An option has the senses that its name has, or else its `about`.
Rule: an option that is found by sense is read back, and nothing is found in a question or behind a condition.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import takewhile

from rai_missions.conversation.language import Language, language, languages, spoken
from rai_missions.engine.decision import Offer
from rai_missions.planning.text.normalise import nearest

__all__ = ("OptionSenses",)

MOST_OFFERS = 100
"""Options whose senses are remembered."""
LONGEST_ADVISING = 5
"""Words of the longest phrase ahead of what is advised: `you would do better to`."""


class OptionSenses:
    """Finds options of one language.

    Args:
        language: Its data.
    """

    def __init__(self, language: Language) -> None:
        self._language, data = language, language.data
        self._senses, self._advising = language.option_senses, language.advising
        self._joints, self._senses_of = frozenset(data["clause_joints"]), lru_cache(MOST_OFFERS)(_senses_of)
        self._negations = frozenset(data["claims"]["negations"])
        self._requesting = frozenset(data["requesting"])
        self._known = frozenset().union(*(each.words for each in self._senses.values()))
        self._spelled = self._known | language.vocabulary() | data["verb_forms"].keys()

    def asked_for(self, text: str, options: Sequence[Offer]) -> list[Offer]:
        """The options that a sentence asks for, as they are offered.

        Args:
            text: The sentence, as it was received.
            options: What is offered.
        """
        clauses = [words for each in self._language.normaliser.remarks(text) if (words := self._words(each))]
        is_asked = text.rstrip().endswith("?") and not any(self._requesting & set(words) for words in clauses)
        is_open = any(self._language.conditions.begin(words) or self._language.no.fits(words) for words in clauses)
        if is_asked or is_open or self._language.may_quote(text):
            return []
        meant = {name for words in clauses for name in self._advised(words)}
        return [offer for offer in options if meant & self._senses_of(offer.name, offer.about)]

    def examples(self, offer: Offer) -> list[str]:
        """Plain sentences that ask for an option, by each of its senses."""
        data = self._language.data["option_senses"]
        senses = sorted(self._senses_of(offer.name, offer.about))
        return [each for sense in senses for phrase in data.get(sense, ()) for each in self._language.examples(phrase)]

    def _words(self, clause: str) -> list[str]:
        words = self._language.normaliser.words(clause)
        bare = next(self._language.normaliser.openings(words), [])
        return [self._mended(word) for word in bare]

    def _mended(self, word: str) -> str:
        """A misspelled word of the senses as it is meant; one with another first letter is another word."""
        meant = word if word in self._spelled else nearest(word, self._known)
        return meant if meant[0] == word[0] else word

    def _advised(self, words: Sequence[str]) -> Iterator[str]:
        """The senses of what a clause orders or advises."""
        for at in range(len(words)):
            if self._may_begin(words, at):
                yield from (name for name, each in self._senses.items() if each.begin(words[at:]))

    def _may_begin(self, words: Sequence[str], at: int) -> bool:
        """Whether what is advised may begin at a word: ahead of others, behind a statement, or behind what advises."""
        before, clause = words[:at], takewhile(lambda word: word not in self._joints, words[at:])
        if not self._negations.isdisjoint((*before, *clause)):  # `hup nicht`: a language may have it behind the verb
            return False
        if not before or before[-1] in self._joints or list(before) in self._language.normaliser.lead:
            return True
        if self._language.yes.fits(before) or self._language.may_order_behind(before):
            return True
        return any(self._advising.fits(before[-size:]) for size in range(1, min(len(before), LONGEST_ADVISING) + 1))


def _senses_of(name: str, about: str) -> frozenset[str]:
    """The senses of an option's name and of the first part of its `about`, or else of all of it.

    A mission's texts are in its author's language, which need not be that of the person.
    """
    known = [language(code) for code in languages()]
    texts = (f"{spoken(name)}, {about.partition(',')[0]}", about)
    found = (
        frozenset(sense for text in given.split(", ") for each in known for sense in _within(text, each))
        for given in texts
    )
    return next(filter(None, found), frozenset())


def _within(text: str, language: Language) -> Iterator[str]:
    words = language.normaliser.words(text)
    return (name for name, each in language.option_senses.items() if each.within(words))
