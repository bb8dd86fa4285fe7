# SPDX-License-Identifier: Apache-2.0
"""The orders that are nearest to a sentence that no rule reads, to be offered.

The values that a sentence names (a place, a thing, a time) decide which orders it may be, and the likeness of its other
words to the phrases of each order which comes first. Each offer is a plain sentence, and means what the grammar reads.
Rule: an offer is none of a statement, of another time, behind a condition, with a negation or the words of others; it
is read back.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache
from itertools import takewhile
from typing import Any, NamedTuple

from rai_missions.conversation.grammar.arguments import BadValue, amounts_in
from rai_missions.conversation.grammar.likeness import Likeness
from rai_missions.conversation.grammar.option_senses import OptionSenses
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.grammar.sentence_grammar import SentenceGrammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.grammar.suggestions import Suggestions
from rai_missions.conversation.grammar.unread_sentence import is_question
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.phrases import SLOT
from rai_missions.conversation.view import KeyView, MissionView, StatusView

__all__ = ("NearestOrders",)

MOST_EXAMPLES = 24
"""Phrases with which a sentence is compared, of each order."""
MOST_WORDS = 30
"""Words of the longest sentence to which orders are offered."""
MOST_OFFERS = 3
LEAST = 0.5
"""The likeness from which on an order without values is offered."""
LONGEST_SUBJECT = 3
"""Words of the longest subject of a statement."""
LEAST_WORDS = 2
"""Words of the shortest sentence to which orders are offered."""
OFFERED = ("pause", "resume", "cancel")
"""The orders without values that are offered: a stop counts by its own words, and waits for no yes."""


class NamedValue(NamedTuple):
    """A value of an argument that a sentence names."""

    words: tuple[str, ...]
    value: Any


class OrderForm(NamedTuple):
    """A kind of order, and plain sentences for it."""

    sense: Sense
    examples: tuple[str, ...]
    slots: frozenset[str] = frozenset()
    """The arguments whose values a sentence has to name."""


class NearestOrders:
    """Finds what may be offered.

    Args:
        grammar: The grammar of the language.
        phrases: Which start missions.
        suggestions: Finds the names of things.
        likeness: Compares sentences.
    """

    def __init__(
        self, grammar: SentenceGrammar, phrases: StartPhrases, suggestions: Suggestions, likeness: Likeness
    ) -> None:
        self._grammar, self._language, self._phrases = grammar, grammar.language, phrases
        self._suggestions, self._likeness = suggestions, likeness
        data = self._language.data
        self._unordered = self._language.negations.union(data["quoting"])
        self._asking, self._indefinite = frozenset(data["asking"]), frozenset(data["no_certain"])
        stating = frozenset([*self._language.articles, *data["owners"], *data["pronouns"], *data["subjects"]])
        self._stating = stating - frozenset(data["addressed"])
        self._past = frozenset(data["past"])
        self._orders = _orders_of(self._language)
        self._missions, self._starts = tuple[MissionView, ...](), list[OrderForm]()
        self._senses = OptionSenses(self._language)

    def nearest(self, text: str, view: StatusView) -> list[Sense]:
        """What may be offered for a sentence, the likeliest first; empty where nothing may be.

        Args:
            text: The sentence, as it was received.
            view: The run.
        """
        normaliser = self._language.normaliser
        words, clauses = normaliser.words(text), [normaliser.words(each) for each in normaliser.remarks(text)]
        asking = self._asking_in(words, clauses) if not self._language.may_quote(text) else []
        if not asking:
            return []
        if view.missions is not self._missions:
            self._missions, self._starts = view.missions, list(self._starts_of(view.missions))
        named = self._named(words, asking, view)
        texts = [" ".join(self._masked(each, named)) for each in (words, *asking) if each]
        forms = [*_fitting(self._starts, named), *self._orders, *self._answers(view)]
        forms = [each for each in forms if each.slots or not is_question(text, self._language)]
        near = sorted(self._near(list(dict.fromkeys(texts)), named, forms), key=lambda each: each[0], reverse=True)
        found = {sense.identity: sense._replace(is_partial=True) for _, sense in near}
        return list(found.values())[:MOST_OFFERS]

    def _asking_in(self, words: Sequence[str], clauses: Sequence[list[str]]) -> list[list[str]]:
        """The clauses that may ask for something; none behind a condition, and with a negation or words of others."""
        is_short = LEAST_WORDS <= len(words) <= MOST_WORDS
        bare = [self._language.normaliser.bare(each) for each in clauses]
        free = {word for each in bare if not self._wanted(each) for word in each}  # `I can not find my keys`
        is_refused = self._unordered & free or any(map(self._language.excepting.within, bare))
        is_of_then = self._language.other_times.within(words)
        if not is_short or is_refused or is_of_then or any(map(self._language.conditions.within, bare)):
            return []
        both = zip(clauses, bare, strict=True)
        return [each for whole, each in both if each and (self._language.wish.fits(whole) or self._may_ask(each))]

    def _may_ask(self, words: list[str]) -> bool:
        """Whether a clause may ask for something: it is a wish or a question, or no statement."""
        if self._language.wish.fits(words) or words[0] in self._asking or self._wanted(words):
            return True
        stated = (slots.get("thing", "").split() for slots in self._language.statement.match(words))
        return (
            self._past.isdisjoint(words[1:])
            and words[0] not in self._stating
            and all(len(thing) > LONGEST_SUBJECT for thing in stated)
        )

    # -- the values that are named ------------------------------------------------------------------------------------

    def _wanted(self, words: Sequence[str]) -> list[str]:
        """The thing that a clause wants or misses, whatever it is: `keys` of `I need my keys`; nothing of any kind."""
        wanted = (slots["thing"].split() for slots in self._language.wanted.match(words))
        certain = (each for each in wanted if each[0] in self._language.articles - self._indefinite)
        return next((thing for each in certain for thing, _ in list(self._suggestions.things(each))[-1:]), [])

    def _named(self, words: Sequence[str], asking: Sequence[Sequence[str]], view: StatusView) -> dict[str, NamedValue]:
        """The values of arguments that the words name: of a list, numbers, and then a thing among the other words.

        Args:
            words: The words of the sentence.
            asking: Its clauses that ask for something.
            view: The run.
        """
        slots = frozenset().union(*(each.slots for each in self._starts))
        asked = [word for clause in asking for word in clause]
        keys = {key.name: key for mission in view.missions for key in mission.arguments if key.name in slots}
        found = dict[str, NamedValue]()
        for name, key in keys.items():
            given = self._number(asked, key) if key.type in ("integer", "number") else self._listed(asked, name)
            found |= {} if given is None else {name: given}
        free = [name for name, key in keys.items() if key.type == "string" and not self._phrases.choices(name)]
        taken = frozenset(word for each in found.values() for word in each.words)
        wanted = next(filter(None, map(self._wanted, asking)), [])
        is_free = bool(wanted) and taken.isdisjoint(wanted)
        thing = NamedValue(tuple(wanted), " ".join(wanted)) if is_free else self._thing(words, taken, view)
        return found | ({} if thing is None else dict.fromkeys(free, thing))

    def _listed(self, words: Sequence[str], name: str) -> NamedValue | None:
        called = self._phrases.named_values(name)
        within = (each for each in called if any(tuple(words[at : at + len(each)]) == each for at in range(len(words))))
        return next((NamedValue(each, called[each]) for each in within), None)

    def _number(self, words: Sequence[str], key: KeyView) -> NamedValue | None:
        for span in amounts_in(words, key, self._language):
            with contextlib.suppress(BadValue):
                return NamedValue(tuple(span), self._phrases.value(span, key))
        return None

    def _thing(self, words: Sequence[str], taken: Collection[str], view: StatusView) -> NamedValue | None:
        """The thing that the words name of which a fact of the run has a word."""
        known = self._suggestions.words_of_facts(view) - frozenset(taken)
        named = (self._alone(thing) for thing, _ in self._suggestions.things(list(words)))
        things = [each for each in named if not known.isdisjoint(each)]
        alone = [[word] for word in words if word in known and not self._grammar.knows(word)]
        return next((NamedValue(tuple(each), " ".join(each)) for each in things or alone), None)

    def _alone(self, thing: Sequence[str]) -> list[str]:
        """A thing without what relates it to a place: `book` of `book within the`."""
        return list(takewhile(lambda word: word not in self._language.spatial | self._language.articles, thing))

    @staticmethod
    def _masked(words: Sequence[str], named: Mapping[str, NamedValue]) -> Iterator[str]:
        """The words, each value as its argument is called."""
        at = 0
        while at < len(words):
            fits = (
                (name, len(each.words))
                for name, each in named.items()
                if tuple(words[at : at + len(each.words)]) == each.words
            )
            name, size = next(fits, (words[at], 1))
            yield name
            at += size

    # -- the orders ---------------------------------------------------------------------------------------------------

    def _near(
        self, texts: Sequence[str], named: Mapping[str, NamedValue], forms: Sequence[OrderForm]
    ) -> Iterator[tuple[tuple[int, float], Sense]]:
        """Each order that a sentence may be, with how many of its values it has, and how like its other words are."""
        examples = [SLOT.sub(r"\1", each) for form in forms for each in form.examples]
        scores = [self._likeness.scores(text, examples) for text in texts]
        each = iter(map(max, zip(*scores, strict=True)))
        for form in forms:
            likeness = max(next(each) for _ in form.examples)
            used = len(form.slots)
            if used or likeness >= LEAST:
                values = {name: named[name].value for name in sorted(form.slots)}
                yield (
                    (used, likeness),
                    form.sense._replace(arguments={**form.sense.arguments, **values}, named=tuple(values)),
                )

    def _starts_of(self, missions: Sequence[MissionView]) -> Iterator[OrderForm]:
        """The starts: each kind that the robot has phrases for, and each mission without such."""
        for mission in missions:
            forms = dict[str, tuple[Mapping[str, Any], frozenset[str], list[str]]]()
            for plains, given in self._phrases.plain_phrases(mission):
                slots = frozenset(SLOT.findall(plains[0]))
                kind = json.dumps([given, sorted(slots)], sort_keys=True, default=str)
                forms.setdefault(kind, (given, slots, []))[2].extend(plains)
            for given, slots, plains in forms.values():
                yield OrderForm(Sense("order", "start", mission=mission.name, arguments=given), _spread(plains), slots)
            yield from () if forms else self._own_starts(mission)

    def _own_starts(self, mission: MissionView) -> Iterator[OrderForm]:
        """The starts of a mission for which there are no phrases: by its name, and with each of its numbers."""
        sense = Sense("order", "start", mission=mission.name)
        starting = _examples(self._language, [each for each in self._language.data["start"] if not SLOT.search(each)])
        yield OrderForm(sense, (*starting, spoken(mission.name)))
        for key in mission.arguments:
            if key.type in ("integer", "number"):
                yield OrderForm(sense, tuple(f"{each} {key.name}" for each in starting), frozenset({key.name}))

    def _answers(self, view: StatusView) -> Iterator[OrderForm]:
        for question in view.questions:
            for offer in question.options:
                if not (offer.parameters or {}).get("required"):
                    sense = Sense("order", "answer", question=question.number, option=offer.name)
                    texts = (spoken(offer.name), offer.about.partition(",")[0], offer.about)
                    like = _spread(self._senses.examples(offer))
                    yield OrderForm(sense, tuple(filter(None, dict.fromkeys((*texts, *like)))))


def _fitting(starts: Sequence[OrderForm], named: Mapping[str, NamedValue]) -> list[OrderForm]:
    """The starts whose values are named; where some take all that are, these alone."""
    fitting = [each for each in starts if each.slots <= named.keys()]
    return [each for each in fitting if named.keys() <= each.slots] or fitting


@cache
def _orders_of(language: Language) -> tuple[OrderForm, ...]:
    """The orders without values."""
    orders = language.data["orders"]
    return tuple(OrderForm(Sense("order", name), _examples(language, orders[name])) for name in OFFERED)


def _examples(language: Language, phrases: Sequence[str]) -> tuple[str, ...]:
    return _spread([each for phrase in phrases for each in language.examples(phrase)])


def _spread(examples: Sequence[str]) -> tuple[str, ...]:
    """As many of them as are compared, from the first to the last."""
    each = list(dict.fromkeys(examples))
    step = max(1.0, len(each) / MOST_EXAMPLES)
    return tuple(each[int(at * step)] for at in range(min(len(each), MOST_EXAMPLES)))
