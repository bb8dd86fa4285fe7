# SPDX-License-Identifier: Apache-2.0
"""Clauses that report something, of one language: of whom they are, and what they report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rai_missions.conversation.claims.claim_words import ClaimWords, Subject
from rai_missions.conversation.claims.harmless_clauses import CERTAIN_WITHIN, HarmlessClauses

__all__ = ("ReportingClauses",)

DEFINED_WITHIN = 3
"""Words, without articles, up to which what precedes a noun defines one by it: `an alley is the way between trees`."""


class ReportingClauses:
    """Finds reports, and their subjects.

    Args:
        rules: The words of the language.
        harmless: What reports nothing.
    """

    def __init__(self, rules: ClaimWords, harmless: HarmlessClauses) -> None:
        self._rules, self._harmless = rules, harmless
        self._advice = rules.phrases("advice")

    def subjects(self, words: Sequence[str], names: frozenset[str]) -> Iterator[Subject]:
        """The subjects of a clause, in its order.

        Args:
            words: The words of the clause.
            names: What this robot, its mission and its keys are called.
        """
        rules = self._rules
        at = 0
        while at < len(words):
            word, end = words[at], at + 1
            if word in rules.self_words:
                yield Subject("self", at, end)
            elif word in rules.let_objects and at and words[at - 1] in rules.let_verbs:
                yield Subject("let", at, end)
            elif word in rules.it:
                yield Subject("it", at, end)
            elif word in rules.possessive and words[end : end + 1] and words[end] not in rules.harmless_nouns:
                end = self._last_noun(words, end, names)
                yield Subject("work", at, end)
            elif (word in rules.work and not self._is_verb(words, at)) or word in names or self._is_of_scene(words, at):
                end = self._last_noun(words, at, names)
                yield Subject("work", at, end)
            elif word in rules.soft:
                yield Subject("soft", at, end)
            at = end

    def _is_verb(self, words: Sequence[str], at: int) -> bool:
        """Whether a noun of the work is the verb of a kind of things here: `tractors run on diesel`."""
        rules = self._rules
        if words[at] not in rules.also_verbs:
            return False
        if at and words[at - 1] in rules.inverted | rules.conditional:  # `can drive`
            return True
        if at not in (1, 2) or words[at - 1] in rules.work:
            return False
        return rules.kind_noun.fullmatch(words[at - 1]) is not None and not set(words[:at]) & rules.definite

    def _last_noun(self, words: Sequence[str], at: int, names: frozenset[str]) -> int:
        """Behind a compound: `mission plan`, `battery status`."""
        at += 1
        while at < len(words) and (words[at] in self._rules.work or words[at] in names):
            at += 1
        return at

    def is_placed(self, words: Sequence[str]) -> bool:
        """Whether a clause puts something at a certain place: `in front of the gate`, `in row three`.

        A condition or a wish does not: `if the cup is on the table`.
        """
        rules = self._rules
        if rules.hypothetical & set(words) or self._harmless.is_elsewhere(words) or self._harmless.is_wish(words):
            return False
        place = rules.place_in(words)
        return bool(place) and not (place[-1] in rules.natural and self._harmless.is_kind(words))

    def _is_of_scene(self, words: Sequence[str], at: int) -> bool:
        """Whether a noun is a certain thing around the robot: `the red cube`, `your cup`, but not `a cup`."""
        rules = self._rules
        before = words[max(0, at - 2) : at]
        if words[at] not in rules.scene or not before:
            return False
        return before[-1] in rules.definite or (before[0] in rules.definite and before[-1] not in rules.articles)

    def is_object(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a noun is no subject: `ask the robot`, `about your mission`, `you could clear the desk`."""
        rules = self._rules
        before = [word for word in words[: subject.start] if word not in rules.articles]
        if not before:
            return False
        is_advice = words[subject.start] not in rules.possessive and self._advice.begin(before)
        is_defined = (
            words[0] in rules.indefinite
            and len(before) <= DEFINED_WITHIN
            and before[-1] in rules.present
            and not rules.has_place(words)
        )
        return before[-1] in rules.objects_after or is_advice or is_defined

    def reports(self, after: Sequence[str], *, is_relative: bool) -> bool:
        """Whether what follows a word reports an act or a state: `has arrived`, `is done`, `went well`."""
        rules = self._rules
        predicate = rules.skip(after)
        if not predicate:
            return False
        if predicate[0] in rules.perfect or predicate[0] in rules.auxiliaries:
            rest = predicate[1:2] if set(predicate[1:2]) & rules.states else rules.skip(predicate[1:])
            is_bare = predicate[0] in rules.auxiliaries and predicate[0] not in rules.perfect
            if rest and (rest[0] in rules.acts or rest[0] in rules.states or rest[0] in rules.strong):
                return True
            return self.has_act(predicate[1:]) or (is_bare and rules.is_past(predicate[0]) and not is_relative)
        return predicate[0] in rules.acts or (not is_relative and rules.is_past(predicate[0]))

    def is_certain(self, words: Sequence[str], subject: Subject, *, is_fact: bool) -> bool:
        """Whether a clause is a claim by its structure alone: of whom it is, and what its verb reports.

        The robot itself with a past, a perfect or what it is doing, and a certain thing of the mission that begins the
        clause with any verb but a modal: `I have mowed`, `the tank holds ten litres`, but not `tanks hold water`.

        Args:
            words: The words of the clause.
            subject: One of its subjects.
            is_fact: Whether its sentence has no modal, condition or habit.
        """
        rules = self._rules
        before, after = words[: subject.start], words[subject.end :]
        turned = [*before[-1:], *after] if rules.verb_second else []
        if subject.kind == "soft" or words[subject.start] in rules.objects or self._is_of_kind(words, subject):
            return False
        if subject.kind == "work" and not is_fact:
            return False
        if self.reports(after, is_relative=False) or self.reports(turned, is_relative=False):
            return True
        predicate = rules.skip(after)
        if subject.kind == "self":
            return self._is_done_by(predicate) or self._is_done_by(rules.skip(turned))
        return subject.kind == "work" and bool(predicate) and self._is_begun_by(words, subject)

    def _is_of_kind(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a subject is any of its kind, or an `it` of no thing: `the door of a fridge`, `it is wise to ask`."""
        rules = self._rules
        after = words[subject.end : subject.end + CERTAIN_WITHIN + 1]
        if subject.kind == "it":
            return "to" in after[2:] and not any(map(rules.is_past, after))
        is_part = bool(set(after[:1]) & rules.objects_after and set(after[1:2]) & rules.indefinite)
        return subject.kind == "work" and (is_part or self._harmless.is_generic(words, subject))

    def _is_begun_by(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a subject begins its clause as a certain thing: `the red cube`, `my left wheel`, `row three`."""
        rules = self._rules
        bare, named = rules.skip_lead(words[: subject.end]), words[subject.start : subject.end]
        before = bare[: len(bare) - len(named)]
        if not before:
            return bool(rules.possessive & set(named) or rules.quantities & set(words[subject.end : subject.end + 1]))
        return len(before) <= CERTAIN_WITHIN and before[0] in rules.owned | rules.quantities

    def _is_done_by(self, predicate: Sequence[str]) -> bool:
        """Whether a verb group reports an act of its subject: `went`, `have mowed`, `am turning`."""
        rules = self._rules
        if not predicate or predicate[0] in rules.relative:
            return False
        if predicate[0] in rules.perfect or predicate[0] in rules.auxiliaries or predicate[0] in rules.second:
            rest = rules.skip(predicate[1:])
            near = rest if rules.verb_second else rest[:1]
            return any(rules.is_past(each) or rules.is_progressive(each) for each in near)
        return rules.is_past(predicate[0])

    def begins_certain(self, words: Sequence[str]) -> bool:
        """Whether a certain thing, or a number of things, begins a clause: `the red cube`, `both arms`, `no apple`."""
        rules = self._rules
        bare = rules.skip_lead(words)
        begun = rules.quantities | rules.definite | rules.possessive | rules.negations
        if bare and rules.verb_second and bare[0] not in begun:  # `bei Baum 18 hat die Pumpe ausgesetzt`
            bare = next((bare[at + 1 :] for at, word in enumerate(bare) if word in rules.perfect), [])
        is_numbered = any(each.isdigit() for each in bare[:2])  # `number 14 has calved`
        return is_numbered or (bool(bare) and bare[0] in begun - rules.objective)

    def is_scene(self, words: Sequence[str]) -> bool:
        """Whether a clause that a certain thing begins reports its place, its past, or what is here and now.

        `The scarf lies on the chair`, `the cable came loose`, `your desk is tidy again`.
        """
        rules = self._rules
        if self._harmless.is_of_world(words):
            return False
        is_past = not rules.verb_second and any(map(rules.is_past, words))
        return is_past or bool(rules.deictic & set(words)) or rules.has_place(words)

    def is_doing(self, words: Sequence[str]) -> bool:
        """Whether a thing, but no person who is spoken to, is doing something: `a truck is blocking the road`."""
        rules = self._rules
        if rules.verb_second or rules.person & set(words) or self._harmless.is_of_world(words):
            return False
        verbs = (rules.skip(words[at + 1 :]) for at, word in enumerate(words) if at and word in rules.auxiliaries)
        return any(map(rules.is_progressive, (verb for rest in verbs for verb in rest[:1])))

    def has_finite(self, words: Sequence[str]) -> bool:
        """Whether a clause has a verb of its own: `waiting is safe`, `well matters more`, `you know`."""
        rules = self._rules
        own = rules.auxiliaries | rules.perfect | rules.modals | rules.person | rules.stative | rules.gerund_verbs
        after = rules.skip_lead(words)[1:]
        return bool(own & set(after)) or (not rules.verb_second and any(map(rules.substance_verb.fullmatch, after[:2])))

    def has_act(self, words: Sequence[str]) -> bool:
        """Whether an act of a robot follows an auxiliary; in German anywhere up to the clause's end."""
        rules = self._rules
        if rules.verb_second:
            return any(
                word in rules.acts or rules.past_pattern.fullmatch(word) for word in words if word not in rules.not_past
            )
        rest = rules.skip(words)
        while rest and rest[0] in rules.perfect:
            rest = rules.skip(rest[1:])
        return bool(rest) and rest[0] in rules.acts

    def has_been(self, words: Sequence[str]) -> bool:
        """`has been looked at`: a perfect of the passive, whatever the act."""
        rules = self._rules
        if rules.verb_second or len(words) < 3 or words[1] not in rules.been:
            return False
        rest = rules.skip(words[2:])
        return bool(rest) and rules.is_past(rest[0])
