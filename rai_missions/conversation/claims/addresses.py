# SPDX-License-Identifier: Apache-2.0
"""Addresses: sentences that only ask or bid the person, and what a sentence leaves unknown.

Rule: an address states nothing. With a second verb, a past, a negated question or a verb of knowing ("do you know that
…") it may state something, and is judged as any other sentence.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import islice

from rai_missions.conversation.claims.claim_words import ClaimWords
from rai_missions.conversation.language.phrases import Phrases

__all__ = ("Addresses",)

LONGEST_SETTING = 7
"""Words up to which what precedes a main clause is a setting of it: `in that case, …`."""

LONGEST_ASKED = 3
"""Words at the beginning of a question among which its verb is: `how heavy is`."""

SHORT = 2
"""Words up to which a clause behind a question is an aside: `, roughly?`."""


class Addresses:
    """Finds the addresses of one language.

    Args:
        rules: The language's words.
    """

    def __init__(self, rules: ClaimWords) -> None:
        self._rules, data = rules, rules.addresses
        self._asking, self._bidding = Phrases(data["asking"], {}), Phrases(data["bidding"], {})
        self._asking_past = Phrases(data["asking_past"], {})
        self._settings, self._knowing = Phrases(data["settings"], {}), frozenset(data["knowing"])
        knowing = "|".join(map(re.escape, self._knowing))
        self._presupposed = re.compile(rf"\b(?:{knowing})\s+(?:that |dass )?(\S+ \S+ \S.*)", re.IGNORECASE)
        self._stating = rules.states | rules.acts | rules.strong | rules.work | rules.scene
        self._unknown = re.compile(data["unknown_pattern"], re.IGNORECASE)
        self._condition = re.compile(data["condition_pattern"], re.IGNORECASE)
        self._attached = (rules.relative - rules.definite).union(rules.asked, rules.hypothetical, data["attached"])
        self._condition_of_talk = re.compile(rf"\b(?:{data['condition_of_talk_pattern']})\s*(?:[,:]|(?=[.!?]|$))", re.I)

    def unconditioned(self, text: str) -> str:
        """A text without conditions of talk, which leave nothing unknown: `if you want to know`, `if you ask me`."""
        main = self._condition_of_talk.sub(" ", text).strip()
        return main if self._rules.words(main) else text

    def known(self, text: str) -> str:
        """A text without what it leaves open: a condition, and what follows `I do not know where`, or `retry means`."""
        known: str = self._unknown.sub(lambda found: found[found.lastindex or 0], text)
        main = self._condition.sub(" ", known)
        return main if self._rules.words(main) else known

    def uncovered(self, text: str, *, is_question: bool) -> list[str]:
        """The clauses of a sentence that its question, bid or condition does not cover, each as a statement.

        A condition covers what can, would or will be, a question what it asks, but not what it has as known: `would
        you believe the door is open?`. A statement covers no other one.

        Args:
            text: A plain sentence.
            is_question: Whether it ends with a question mark.
        """
        known = self.known(text)
        parts = self._rules.parts(known)
        if self.is_statement(text, is_question=is_question):
            covered = -1 if parts[1:] else 0
        elif is_question:
            covered = next((at for at, each in enumerate(parts) if self._is_asking(each)), len(parts) - 1)
        elif known != text:
            covered = next((at for at, each in enumerate(parts) if self._is_open(each)), -1)
        else:
            covered = 0
        asked = " ".join(parts[covered : covered + 1]) if is_question else ""
        presupposed = self._presupposed.findall(asked)
        return self._statements([*parts[:covered], *parts[covered + 1 :], *presupposed] if covered >= 0 else parts)

    def is_statement(self, text: str, *, is_question: bool) -> bool:
        """Whether a sentence neither asks, nor bids, nor leaves anything open."""
        known = self.known(text)
        first = next(iter(self._rules.parts(known)), "")
        return not is_question and known == text and not (first and self._bidding.begin(self._bare(first)))

    def _is_open(self, clause: str) -> bool:
        """Whether the main clause of a condition depends on it: what can, would or will be."""
        rules = self._rules
        return bool((rules.abilities | rules.conditional | rules.future) & set(rules.words(clause)))

    def _statements(self, parts: Sequence[str]) -> list[str]:
        return [f"{each.rstrip('.!? ')}." for each in parts if not self._is_attached(self._rules.words(each))]

    def _bare(self, clause: str) -> list[str]:
        words = self._rules.words(clause)
        return self._rules.skip_lead(words) or words

    def _is_attached(self, words: Sequence[str]) -> bool:
        """Whether a clause is part of another one, and states nothing by itself."""
        bare = self._rules.skip_lead(words) or words
        return words[0] in self._attached or self._is_setting(bare)

    def _is_asking(self, clause: str) -> bool:
        words, bare = self._rules.words(clause), self._bare(clause)
        return self._asking.begin(bare) or bool(self._rules.asking_words & {words[0], bare[0]})

    def main(self, clauses: Sequence[Sequence[str]]) -> list[Sequence[str]]:
        """The clauses from the main one on: without `in that case`, `to start a mission`."""
        at = 0
        while at + 1 < len(clauses) and self._is_setting(clauses[at]):
            at += 1
        return list(clauses[at:])

    def is_address(self, clauses: Sequence[Sequence[str]], *, is_question: bool) -> bool:
        """Whether a sentence only asks, or only bids.

        Args:
            clauses: The words of each clause.
            is_question: Whether it ends with a question mark.
        """
        words, *others = [self._rules.skip_lead(each) or each for each in self.main(clauses)] or [[]]
        rest = words[self._asked(words) if is_question else 1 :]
        if not all(self._is_aside(each) for each in others):
            return False
        if self._states(rest, is_past_asked=is_question and self._asking_past.begin(words)):
            return False
        if self._rules.has_place(words):
            return False
        if is_question:
            return self._asking.begin(words) and not self._rules.negations & set(words)
        return self._bidding.begin(words) and not self._rules.speaker & set(words)

    def _asked(self, words: Sequence[str]) -> int:
        """How many words a question begins with, its verb among them: `how heavy is`."""
        begun = enumerate(islice(words, LONGEST_ASKED))
        verbs = (at for at, word in begun if word in self._rules.second)
        return max(2, next(verbs, 0) + 1)

    def _is_aside(self, words: Sequence[str]) -> bool:
        return len(words) <= SHORT and not self._stating & set(words)

    def _is_setting(self, words: Sequence[str]) -> bool:
        if self._rules.harmless.fits(words):
            return True
        is_short = len(words) <= LONGEST_SETTING and self._settings.begin(words)
        return is_short and not (self._rules.second | self._rules.self_words) & set(words)

    def _states(self, words: Sequence[str], *, is_past_asked: bool) -> bool:
        """Whether another verb may state something; the past of the person does not: `did you sleep well?`."""
        rules = self._rules
        if rules.relative & set(words[:-1]):
            return True
        is_stated = any(word in rules.second or word in self._knowing for word in words)
        return is_stated or (not is_past_asked and any(map(rules.is_past, words)))
