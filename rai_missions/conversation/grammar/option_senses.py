# SPDX-License-Identifier: Apache-2.0
"""Options by sense: which of those that are offered a person asks for in words of their own.

A language lists what people write for the usual options: to wait, to go around, to use the horn, to call a person, to
give something up. An option has the senses that its name has, or else its `about`.
Rule: an option that is found by sense is read back. Nothing is found in a question, behind a condition, or of what is
only excepted: the horn of `anything but the horn`. Of `wait or honk` both are found, so that the person is asked which.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import groupby, takewhile

from rai_missions.conversation.grammar.option_words import OptionWords
from rai_missions.conversation.language.language import Language, language, languages, spoken
from rai_missions.engine.decision import Offer
from rai_missions.planning.text.normalise import nearest
from rai_missions.planning.text.numbers import number

__all__ = ("OptionSenses",)

MOST_OFFERS = 100
"""Options whose senses are remembered."""
POLITE = 3
"""Words of a request with a negation that is none: `can not you`."""
LONGEST_ADVISING = 5
"""Words of the longest phrase ahead of what is advised: `you would do better to`."""


class OptionSenses:
    """Finds options of one language.

    Args:
        language: Its data.
    """

    def __init__(self, language: Language) -> None:
        self._language, data = language, language.data
        self._own_words = OptionWords(language)
        self._senses, self._advising = language.option_senses, language.advising
        self._joints, self._senses_of = frozenset(data["clause_joints"]), lru_cache(MOST_OFFERS)(_senses_of)
        self._or = language.text("or")
        self._requesting, self._addressed = frozenset(data["requesting"]), frozenset(data["addressed"])
        self._asking = frozenset(data["asking"]) - self._requesting
        self._known = frozenset().union(*(each.words for each in self._senses.values()))
        self._spelled = self._known | language.vocabulary | data["verb_forms"].keys() | data["numbers"].keys()

    def asked_for(self, text: str, options: Sequence[Offer]) -> list[tuple[Offer, list[str]]]:
        """The options that a sentence asks for, as they are offered, each with the words of the clauses that do so.

        Args:
            text: The sentence, as it was received.
            options: What is offered.
        """
        clauses = [words for each in self._language.normaliser.remarks(text) if (words := self._words(each))]
        refused = [at for at, words in enumerate(clauses) if self._refuses(words, options)]
        clauses = clauses[refused[-1] + 1 if refused else 0 :]  # `honk... no, wait`
        is_request = any(self._requesting & set(words) and words[0] not in self._asking for words in clauses)
        is_open = any(map(self._language.conditions.begin, clauses))
        if is_open or (text.rstrip().endswith("?") and not is_request) or self._language.may_quote(text):
            return []
        asked, is_choice = list(self._meant(clauses, options)), any(map(self._has_choice, clauses))
        sensed = [words for words in clauses if asked and not is_choice and any(self._advised(words))]
        own = dict(self._by_words(sensed or clauses, options))
        both = [] if is_choice else [each for each in asked if each.name in own]
        whole = [each for each in options if each.name in own and self._own_words.has_all(own[each.name], each)]
        both = both or (whole if len(whole) == 1 and not is_choice else [])  # `take the one in the east wing`
        asked = both or [each for each in options if each in asked or each.name in own]
        if is_choice and len(asked) == 1:
            return []  # the other one is not known
        return [(each, own.get(each.name) or [word for words in clauses for word in words]) for each in asked]

    def _refuses(self, words: Sequence[str], options: Sequence[Offer]) -> bool:
        """Whether a clause is a no; `skip it` is none, where this is offered."""
        return self._language.no.fits(words) and not any(self._names(words, each) for each in options)

    def _has_choice(self, words: Sequence[str]) -> bool:
        """Whether a clause leaves open what is to be done; `a minute or two` is one."""
        behind = (words[at + 1 : at + 2] for at, word in enumerate(words) if word == self._or)
        return any(number(each, self._language.data) is None for each in behind)

    def are_in(self, text: str, options: Sequence[Offer]) -> bool:
        """Whether a sentence has own words of an option: `wait a bit`, but not `hang on`, of `wait`."""
        remarks = self._language.normaliser.remarks(text)
        return bool(list(self._by_words(filter(None, map(self._words, remarks)), options)))

    def _by_words(self, clauses: Iterable[Sequence[str]], options: Sequence[Offer]) -> Iterator[tuple[str, list[str]]]:
        """The options whose own words are in a clause, or a part of it around an `or`, with that; none of a refusal."""
        free = (words for words in clauses if self._language.negations.isdisjoint(words))
        for is_or, part in (part for words in free for part in groupby(words, key=self._or.__eq__)):
            given = list(part)
            given = given[next((at for at in range(len(given)) if self._is_advised(given[:at])), 0) :]
            if not is_or and not self._language.reason_joints.begin(given):
                yield from ((each.name, given) for each in self._own_words.meant(given, options))

    def _meant(self, clauses: Sequence[Sequence[str]], options: Sequence[Offer]) -> Iterator[Offer]:
        """The options that clauses name or have a sense of; one with all its senses comes before a part of it.

        Where none has all its senses in the clauses, one that is no more than others comes before these: `drive on`
        before `sound the horn and drive on`.
        """
        meant = frozenset(name for words in clauses for name in self._advised(words))
        senses = {each.name: self._senses_of(each.name, each.about) for each in options}
        named = {each.name for each in options if any(self._names(words, each) for words in clauses)}
        found = [each for each in options if each.name in named or meant & senses[each.name]]
        whole = [each for each in found if each.name in named or senses[each.name] <= meant]
        if any(self._or in words for words in clauses):
            yield from found
            return
        kept, is_worse = (whole, operator.lt) if whole else (found, operator.gt)
        for each in kept:
            if not any(is_worse(senses[each.name], senses[other.name]) for other in kept):
                yield each

    def examples(self, offer: Offer) -> list[str]:
        """Plain sentences that ask for an option, by each of its senses."""
        data = self._language.data["option_senses"]
        senses = sorted(self._senses_of(offer.name, offer.about))
        return [each for sense in senses for phrase in data.get(sense, ()) for each in self._language.examples(phrase)]

    def _words(self, clause: str) -> list[str]:
        """The words of a clause, as they are meant, ahead of what it excepts."""
        words = self._language.normaliser.words(clause)
        bare = next(self._language.normaliser.openings(words), [])
        bare = [word for at, word in enumerate(bare) if not self._is_polite(bare[max(0, at - 1) : at + 2])]
        excepted = (at for at in range(len(bare)) if self._language.excepting.begin(bare[at:]))
        return [self._mended(word) for word in bare[: next(excepted, len(bare))]]

    def _is_polite(self, words: Sequence[str]) -> bool:
        """Whether the negation in the middle is none: `can't you take another way`."""
        return len(words) == POLITE and all(
            word in each
            for word, each in zip(words, (self._requesting, self._language.negations, self._addressed), strict=True)
        )

    def _mended(self, word: str) -> str:
        """A misspelled word of the senses as it is meant; one with another first letter is another word."""
        meant = word if word in self._spelled else nearest(word, self._known)
        return meant if meant[0] == word[0] else word

    def _advised(self, words: Sequence[str]) -> Iterator[str]:
        """The senses of what a clause orders or advises."""
        for at in range(len(words)):
            if self._may_begin(words, at):
                yield from (name for name, each in self._senses.items() if each.begin(words[at:]))

    def _names(self, words: Sequence[str], offer: Offer) -> bool:
        """Whether a clause orders or advises an option by its name; with values it is read elsewhere."""
        name, is_plain = spoken(offer.name).split(), not (offer.parameters or {}).get("required")
        begins = (at for at in range(len(words)) if words[at : at + len(name)] == name)
        return is_plain and any(self._may_begin(words, at) for at in begins)

    def _may_begin(self, words: Sequence[str], at: int) -> bool:
        """Whether what is advised may begin at a word: ahead of others, behind a statement, or behind what advises."""
        before, clause = words[:at], takewhile(lambda word: word not in self._joints, words[at:])
        if not self._language.negations.isdisjoint((*before, *clause)):  # `hup nicht`: it may be behind the verb
            return False
        if (
            not before
            or before[-1] == self._or
            or before[-1] in self._joints
            or list(before) in self._language.normaliser.lead
        ):
            return True
        if self._language.yes.fits(before) or self._language.may_order_behind(before):
            return True
        return self._is_advised(before)

    def _is_advised(self, before: Sequence[str]) -> bool:
        """Whether words end with a phrase ahead of what is advised."""
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
    """The senses of a text whose verb may be in the third person: `ruft` is `ruf`."""
    verb, rest = (words := language.normaliser.words(text))[:1], words[1:]
    forms = [[*form, *rest] for form in language.verb_stems(verb)] if verb else []
    return (name for name, each in language.option_senses.items() if any(map(each.within, forms)))
