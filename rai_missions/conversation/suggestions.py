# SPDX-License-Identifier: Apache-2.0
"""Suggestions: the order or question in one clause of a sentence that means nothing as a whole.

"I am hungry, go to the kitchen" has an order in it, and "my cup is gone, find it" one whose thing was named before.
Rule: an order that is suggested is read back, whatever it is; other talk never becomes an order by it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rai_missions.conversation.grammar import STOP, Grammar
from rai_missions.conversation.senses import Sense
from rai_missions.conversation.state_answers import ALWAYS
from rai_missions.conversation.view import StatusView

__all__ = ("Suggestions",)

MOST_CLAUSES = 8
"""Clauses of the longest sentence in which one is looked for."""
QUOTING = ":"
"""What is behind it may be the words of others."""
LONGEST_THING = 3
"""Words of the longest name of a thing in whose place a pronoun may be."""
REPLIES = frozenset({"yes", "no", "quiet", "withdraw", "again", "other"})
"""What a clause may mean with which the person reacts to the robot, so that the others do, too."""


class Suggestions:
    """Finds the order or question that other talk may have in it.

    Args:
        grammar: Reads the clauses.
    """

    def __init__(self, grammar: Grammar) -> None:
        self._grammar, self._language = grammar, grammar.language
        data = self._language.data
        self._conditions, self._pronouns = frozenset(data["conditions"]), frozenset(data["thing_pronouns"])
        self._articles, self._ends = frozenset(data["articles"]), frozenset(data["thing_ends"])
        self._openings = frozenset(data["lead"])
        self._joints, self._addressed = frozenset(data["clause_joints"]), frozenset(data["addressed"])

    def suggested(self, text: str, view: StatusView) -> Sense | None:
        """The one order in it, or else its first question, or what an order in it lacks; None with a condition.

        Args:
            text: The sentence, as it was received, which means nothing as a whole, or has values that do not fit.
            view: The run.
        """
        clauses = list(self._clauses(text)) if QUOTING not in text else []
        if len(clauses) > MOST_CLAUSES or any(words[0] in self._conditions for words in clauses):
            return None
        orders, others = dict[str, Sense](), list[Sense]()
        for at, words in enumerate(clauses):
            senses = self._grammar.sentence(words, view) or self._bidden(words, text, view)
            if any(sense.kind in REPLIES or sense == STOP for sense in senses):
                return None
            order = _order(senses) or _order(self._resolved(words, clauses[:at], senses, view))
            if order is not None:
                orders[order.identity] = order._replace(is_partial=True)
            elif senses and senses[0].kind in ("question", "fault") and senses[0].name not in ALWAYS:
                others.append(senses[0])
        if orders:
            return next(iter(orders.values())) if len(orders) == 1 else None
        return min(others, key=lambda sense: sense.kind == "fault", default=None)

    def _clauses(self, text: str) -> Iterator[list[str]]:
        """The words of each clause: what is between commas, and around the words that join clauses."""
        for clause in self._language.normaliser.clauses(text):
            part = list[str]()
            for word in self._language.normaliser.words(clause):
                if word not in self._joints:
                    part.append(word)
                elif part:
                    yield part
                    part = []
            if part and " ".join(part) not in self._openings:
                yield part

    def _bidden(self, words: list[str], text: str, view: StatusView) -> tuple[Sense, ...]:
        """What a clause orders that begins with whom it bids: `you go home`; nothing in a question."""
        first, *rest = self._language.normaliser.spoken(words) or [""]
        is_bidden = first in self._addressed and not text.rstrip().endswith("?")
        return self._grammar.sentence(rest, view) if is_bidden else ()

    def _resolved(
        self, words: list[str], before: Sequence[list[str]], senses: Sequence[Sense], view: StatusView
    ) -> tuple[Sense, ...]:
        """A clause that lacks a value and has a pronoun, with the thing that was named last in its place."""
        places = [at for at, word in enumerate(words) if word in self._pronouns]
        if len(places) != 1 or not any(sense.lacks for sense in senses):
            return ()
        (at,) = places
        things = (thing for clause in reversed(before) for thing in self._things(clause))
        read = (self._grammar.sentence([*words[:at], *thing, *words[at + 1 :]], view) for thing in things)
        return next((found for found in read if _order(found) is not None), ())

    def _things(self, words: list[str]) -> Iterator[list[str]]:
        """The names of things, the last first: each article with the words behind it, up to one that names nothing."""
        for at in range(len(words) - 1, -1, -1):
            if words[at] in self._articles:
                rest = words[at + 1 : at + 1 + LONGEST_THING]
                size = next((place for place, word in enumerate(rest) if word in self._ends), len(rest))
                if size:
                    yield words[at : at + 1 + size]


def _order(senses: Sequence[Sense]) -> Sense | None:
    """What a clause orders, where it can mean nothing else; an answer is none, for it needs its question."""
    is_order = len(senses) == 1 and senses[0].kind == "order" and senses[0].name != "answer"
    return senses[0] if is_order else None
