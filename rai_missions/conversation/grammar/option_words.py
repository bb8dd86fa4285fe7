# SPDX-License-Identifier: Apache-2.0
"""Options by their own words: `ab in die Kammer` for one that returns to the `Wäschekammer`.

Of an option's name, its `about` and its parameters those words count that no other option of the question has: a
clause with such a word means it. Words that several options share, verbs of many senses (`go`, `take`) and numbers
count neither for it nor against it; at least half of the others must be the option's.
Rule: what is found is read back. A statement names no option: `the map in the hall is wrong`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rai_missions.conversation.grammar.arguments import amounts_in, parameter_keys
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.engine.decision import Offer
from rai_missions.planning.text.numbers import number

__all__ = ("OptionWords",)

SHORTEST_STEM = 4
"""Letters that two forms of a word share at least."""
LONGEST_ENDING = 3
"""Letters in which two forms of a word differ at most."""
SHORTEST_PART = 5
"""Letters of the shortest part of a compound: `kammer` of `wäschekammer`."""


class OptionWords:
    """Finds options of one language.

    Args:
        language: Its data.
    """

    def __init__(self, language: Language) -> None:
        self._language = language
        data = language.data
        self._light = language.light_verbs | language.spatial | frozenset(data["half_words"])
        self._past = frozenset(data["past"])
        pronouns = frozenset([*data["pronouns"], *data["subjects"]]) - language.articles
        self._stating = pronouns - frozenset(data["addressed"])

    def meant(self, clause: Sequence[str], options: Sequence[Offer]) -> Iterator[Offer]:
        """The options whose own words a clause has; none of a statement.

        Args:
            clause: Its words.
            options: What is offered.
        """
        content = [word for word in clause if self._has_meaning(word)]
        if not content or self._states(clause):
            return
        shared = {each.name: self._shared(content, clause, each) for each in options}
        for offer in options:
            others = {word for name, words in shared.items() if name != offer.name for word in words}
            own = [word for word in shared[offer.name] if word not in others]
            foreign = [word for word in content if word not in others and word not in own]
            if own and len(own) >= len(foreign):
                yield offer

    def has_all(self, clause: Sequence[str], offer: Offer) -> bool:
        """Whether an option has each of the words with a meaning in a clause, and these are several."""
        content = [word for word in clause if self._has_meaning(word)]
        return len(content) > 1 and self._shared(content, clause, offer) == content

    def _shared(self, content: Sequence[str], clause: Sequence[str], offer: Offer) -> list[str]:
        """The words of a clause that an option has as well, or that are an amount of what it takes."""
        spans = (span for key in parameter_keys(offer) for span in amounts_in(clause, key, self._language))
        own, taken = self._words(offer), {word for span in spans for word in span}
        return [word for word in content if word in taken or _shares(word, own)]

    def _states(self, clause: Sequence[str]) -> bool:
        """Whether a clause is a statement."""
        is_subject = clause[0] in self._stating or not self._past.isdisjoint(clause)
        return is_subject or next(self._language.statement.match(list(clause)), None) is not None

    def _has_meaning(self, word: str) -> bool:
        is_number = number([word], self._language.data) is not None
        return word not in self._light and not is_number and bool(self._language.meanings(word))

    def _words(self, offer: Offer) -> frozenset[str]:
        """The words of an option that have a meaning of their own."""
        properties = (offer.parameters or {}).get("properties") or {}
        about = (str(each.get("description", "")) for each in properties.values())
        values = (str(value) for each in properties.values() for value in each.get("enum", ()))
        texts = " ".join([offer.name, offer.about, *properties, *about, *values])
        return frozenset(filter(self._has_meaning, self._language.normaliser.words(spoken(texts))))


def _shares(word: str, words: Iterable[str]) -> bool:
    """Whether one of these is a form of a word, or a compound with it."""
    return any(_is_form(word, each) for each in words)


def _is_form(one: str, other: str) -> bool:
    """Whether two words are forms of one, `leave` and `leaving`, or one is a part of the other."""
    if one == other:
        return True
    short, long = sorted((one, other), key=len)
    alike = next((at for at, (a, b) in enumerate(zip(short, long, strict=False)) if a != b), len(short))
    is_part = len(short) >= SHORTEST_PART and (long.startswith(short) or long.endswith(short))
    return is_part or (alike >= SHORTEST_STEM and len(long) - alike <= LONGEST_ENDING)
