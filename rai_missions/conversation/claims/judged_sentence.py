# SPDX-License-Identifier: Apache-2.0
"""One sentence of a model, judged by the words of one language: why it is a claim, or may be one.

Rule: nothing is known here of the other languages, of scores, or of what was spoken before.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain, pairwise
from typing import Literal, NamedTuple

from rai_missions.conversation.claims.addresses import Addresses
from rai_missions.conversation.claims.claim_words import ClaimWords, Subject
from rai_missions.conversation.claims.harmless_clauses import HarmlessClauses
from rai_missions.conversation.claims.reporting_clauses import ReportingClauses
from rai_missions.conversation.language.language import language

__all__ = ("CERTAIN", "ClaimKind", "JudgedSentence", "claim_rules")

ClaimKind = Literal[
    "", "script", "language", "idiom", "subject", "passive", "progress", "result", "fragment", "place", "report"
]
"""Why a sentence is replaced; empty where it is not.

Those in `CERTAIN` are claims by their structure, or cannot be judged; the others are in doubt.
"""
CERTAIN: frozenset[ClaimKind] = frozenset(("script", "language", "result", "subject"))
"""The kinds that no score of a sentence's words takes back."""
NAMED = re.compile(r"(?<=[a-z,] )[A-Z][a-z]+")
"""What English writes as the name of a person or a place."""
CAPITALS = re.compile(r"(?<=\w )[A-ZÄÖÜ]\w+")
"""What German writes as a noun, but for the first word of a sentence."""
NOUN_WITHIN = 4
"""Words at the beginning of a German clause among which the noun of its article is: `das kleine rote Buch`."""


class ClaimRules(NamedTuple):
    """What is known of one language."""

    words: ClaimWords
    harmless: HarmlessClauses
    reports: ReportingClauses
    addresses: Addresses


@cache
def claim_rules(code: str) -> ClaimRules:
    """The rules of a language, compiled once for all conversations."""
    words = ClaimWords(language(code))
    harmless = HarmlessClauses(words)
    return ClaimRules(words, harmless, ReportingClauses(words, harmless), Addresses(words))


class JudgedSentence:
    """One sentence, judged by the words of one language."""

    def __init__(self, language_rules: ClaimRules, text: str, names: frozenset[str], *, is_conditional: bool) -> None:
        rules, self._harmless, self._reports, _ = language_rules
        self._rules, self._names, self._is_conditional = rules, names, is_conditional
        self._nouns = frozenset(each.lower() for each in CAPITALS.findall(text)) if rules.verb_second else frozenset()
        self._names_other = any(each.lower() not in names for each in NAMED.findall(text)) and not rules.verb_second
        clauses = rules.clauses(text)
        self._clauses = [each for each in clauses if not rules.harmless.fits(each) and not self._harmless.is_wish(each)]
        first = rules.skip_lead(clauses[0]) if clauses else []
        self._is_about_kind = self._harmless.is_kind(first) and not any(
            self._harmless.is_present(each) for each in clauses
        )
        is_whole = len(self._clauses) == len(clauses)
        self.kind = self._judge(rules.words(text) if is_whole else [*chain(*self._clauses)])

    def _judge(self, words: list[str]) -> ClaimKind:
        rules = self._rules
        if rules.whole_idioms.fits(words) or any(rules.whole_idioms.fits(each) for each in self._clauses):
            return "result"
        if rules.idioms.within(words) or any(rules.whole_idioms.fits(each) for each in self._bare_clauses()):
            return "idiom"
        if self._has_result(words):
            return "result"
        clauses = [words, *self._clauses]
        found = [(each, subject) for each in clauses for subject in self._reports.subjects(each, self._names)]
        claims = [(each, subject) for each, subject in found if self._is_claim(each, subject)]
        is_fact = self._states_facts(words)
        if any(self._reports.is_certain(each, subject, is_fact=is_fact) for each, subject in claims):
            return "subject"
        fragments = [each for each in self._clauses if self._is_fragment(each)]
        if fragments[:1] == self._clauses[:1] and fragments and not any(map(self._reports.has_finite, self._clauses)):
            return "fragment"
        passives = [each for each in clauses if self._has_passive(each)]
        if is_fact and any(self._begins_certain(each) for each in passives if not rules.self_words & set(each)):
            return "passive"
        progress = [each for each in self._clauses if rules.progress.within(each) and not set(each) & rules.person]
        if any(each in progress for each, _ in found):
            return "progress"
        if is_fact and any(self._is_scene(each) for each in self._clauses):
            return "subject"
        is_doubtful = claims or fragments or passives or progress or self._has_second_verb(words)
        return "report" if is_doubtful else ""

    def _is_scene(self, words: Sequence[str]) -> bool:
        """Whether a clause reports of a certain thing, or of any thing what it is doing: `a man is walking there`."""
        is_of_one = self._begins_certain(words) and self._reports.is_scene(words)
        return is_of_one or self._reports.is_doing(words)

    def _begins_certain(self, words: Sequence[str]) -> bool:
        """Whether a certain thing begins a clause; in German its article is that of a noun."""
        is_named = not self._nouns or not self._rules.relative & set(self._rules.skip_lead(words)[:1])
        return (is_named or bool(self._nouns & set(words[:NOUN_WITHIN]))) and self._reports.begins_certain(words)

    def _states_facts(self, words: Sequence[str]) -> bool:
        """Whether a sentence has no modal, condition or habit, and no name of a person or a place."""
        rules = self._rules
        is_possible = bool((rules.hypothetical | rules.modals - rules.negations) & set(words))
        return not (is_possible or self._is_conditional or self._names_other or self._harmless.is_habit(words))

    def _bare_clauses(self) -> Iterator[Sequence[str]]:
        """What is left of each clause without some of the harmless words around it: `of course done, for you`."""
        for words in self._clauses:
            for start in range(self._rules.leading(words) + 1):
                for end in self._rules.ends(words):
                    if start < end:
                        yield words[start:end]

    def _is_claim(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether what follows a subject is a claim."""
        rules, after = self._rules, words[subject.end :]
        predicate = rules.skip(after)
        if subject.kind == "let":
            return bool(after) and not rules.let.begin(after)
        allowed = rules.allowed.get(subject.kind)
        before = words[subject.start - 1] if subject.start else ""
        if self._is_spared(words, subject):
            return False
        if subject.kind in ("self", "it"):
            if before in rules.inverted or (allowed and (allowed.begin(after) or allowed.begin(predicate))):
                return False
            if self._harmless.is_ability(after, is_conditional=self._is_conditional):
                return False
            return not self._is_inverted_harmless(words, subject) and bool(after or rules.verb_second)
        if subject.kind == "soft":
            is_relative = words[subject.start] in rules.relative
            return before not in rules.modals and self._reports.reports(after, is_relative=is_relative)
        if self._reports.is_object(words, subject) and not self._has_predicate(predicate):
            return False
        if allowed and (allowed.begin(after) or allowed.begin(predicate)):
            return False
        if self._is_inverted_harmless(words, subject):
            return False
        if self._harmless.is_generic(words, subject):
            return self._reports.reports(after, is_relative=False)
        return bool(after)

    def _is_spared(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether the clause states nothing of its subject: of the world, of a kind, a duty, a consequence."""
        rules, word = self._rules, words[subject.start]
        if self._harmless.is_asked(words, subject) or self._harmless.is_of_world(words):
            return True
        if subject.kind == "it" and self._harmless.is_referring(words, subject):
            return True
        if word in rules.referring and subject.start and self._is_about_kind:
            return True
        if subject.kind == "work" and self._harmless.is_duty(words, subject):
            return True
        return self._is_conditional and word not in rules.work | rules.self_words and self._harmless.is_foretold(words)

    def _is_inverted_harmless(self, words: Sequence[str], subject: Subject) -> bool:
        """In a language whose verb may precede the subject: `das kann ich nicht sagen`."""
        rules = self._rules
        allowed = rules.allowed.get(subject.kind)
        if not rules.verb_second or not subject.start or allowed is None:
            return False
        if subject.start > 1 and words[subject.start - 2] in rules.self_words:
            return False
        turned = [words[subject.start - 1], *words[subject.end :]]
        if subject.kind == "self" and self._harmless.is_ability(turned, is_conditional=self._is_conditional):
            return True
        return allowed.begin(turned) or allowed.begin([turned[0], *rules.skip(turned[1:])])

    def _has_predicate(self, words: Sequence[str]) -> bool:
        rules = self._rules
        return bool(words) and (words[0] in rules.auxiliaries or words[0] in rules.acts or rules.is_past(words[0]))

    def _has_passive(self, words: Sequence[str]) -> bool:
        """`The cup has been placed`, `der Becher wurde gefunden`: an act, and no word of who did it."""
        rules = self._rules
        if self._harmless.is_of_world(words):
            return False
        for at, word in enumerate(words):
            if word not in rules.perfect:
                continue
            subject = next((each for each in reversed(words[:at]) if each not in rules.adverbs), "")
            if subject in rules.modals or subject in rules.person:
                continue
            if self._reports.has_act(words[at + 1 :]) or self._reports.has_been(words[at:]):
                return True
        return False

    def _has_result(self, words: Sequence[str]) -> bool:
        """`Success`, `completed`, anywhere, but for what can or shall be so."""
        rules = self._rules
        for before, (at, word) in zip(["", *words], enumerate(words), strict=False):
            is_possible = before in rules.modals or (
                before in rules.perfect and at > 1 and words[at - 2] in rules.modals
            )
            if word in rules.strong and not is_possible:
                return True
        return False

    def _is_fragment(self, words: Sequence[str]) -> bool:
        """A clause without a subject that begins with an act: `moving to the dock`, `arrived`."""
        rules = self._rules
        words = rules.skip_lead(words)
        if not words:
            return False
        if self._harmless.is_gerund(words) or (rules.is_progressive(words[0]) and self._harmless.is_of_world(words)):
            return False
        first, after = words[0], set(rules.skip(words[1:])[:1])
        if first in rules.second and not rules.verb_second and after & (rules.acts | rules.places):
            return True
        is_past = rules.is_past(first) and first not in rules.imperative
        return is_past or first in rules.acts or rules.is_progressive(first)

    def _has_second_verb(self, words: Sequence[str]) -> bool:
        """`I understand and have moved`: a second verb of the same subject."""
        rules = self._rules
        subjects = list(self._reports.subjects(words, self._names))
        for at, (word, following) in enumerate(pairwise(words)):
            rest = rules.skip(words[at + 1 :]) if word in rules.conjunctions else []
            if not rest or not any(each.end <= at for each in subjects):
                continue
            allowed = rules.allowed.get("self")
            is_verb = rest[0] in rules.second or rules.is_past(rest[0]) or rules.is_progressive(rest[0])
            if self._harmless.is_ability(rest, is_conditional=self._is_conditional):
                continue
            if is_verb and not (allowed and allowed.begin(rest)) and following not in rules.person:
                return True
        return False
