# SPDX-License-Identifier: Apache-2.0
"""Clauses that report nothing, of one language: of the world, of a kind of things, of what can or shall be."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from rai_missions.conversation.claims.claim_words import ClaimWords, Subject

__all__ = ("CERTAIN_WITHIN", "LEAST_PREDICATE", "HarmlessClauses")

LONGEST_ASIDE = 4
"""Words up to which a clause without a verb is an aside, and of which the clause before it has at least as many."""
LEAST_PREDICATE = 2
"""Words that follow a kind of things in a whole sentence: `plants need water`, but not `engines off`."""
CERTAIN_WITHIN = 4
"""Words of a sentence about a kind of things among which a certain thing makes it a report."""
WORLD_WITHIN = 6
"""Words at the beginning of a clause about nature among which its verb is."""
ABILITY_WITHIN = 3
"""Words after `I can` among which the verb is."""
KIND_WITHIN = 3
"""Words at the beginning of a clause among which the kind of things is: `heavy clay soil holds water`."""


class HarmlessClauses:
    """Finds what is no report.

    Args:
        rules: The words of the language.
    """

    def __init__(self, rules: ClaimWords) -> None:
        self._rules = rules
        self._marks, self._marked_begin, self._wishes = map(rules.phrases, ("marks", "marked_begin", "wishes"))
        self._world, self._habits, self._hidden = map(rules.phrases, ("world", "habits", "hidden"))
        self._far, self._dates = rules.phrases("far"), rules.pattern("date_pattern")
        self._kind_verb, self._infinitive = rules.pattern("kind_verb"), rules.pattern("infinitive")
        self._certain = rules.definite - rules.relative
        self._not_of_habits = rules.owned | (rules.second - rules.present)
        self._small = rules.articles | rules.auxiliaries | rules.function
        self._linking = rules.auxiliaries | rules.stative
        self._reported = rules.acts | rules.states | rules.strong
        subjects = rules.self_words | rules.possessive | rules.person
        self._stating = subjects.union(rules.acts, rules.strong, rules.auxiliaries, rules.second)
        near = rules.definite.union(rules.work, rules.scene, rules.soft)
        self._near = near.union(rules.quantities, rules.negations, rules.states)

    def is_marked(self, words: Sequence[str], *, least: int = LEAST_PREDICATE) -> bool:
        """Whether a sentence has a mark of what is no report: a modal, a condition, a kind of things, a definition.

        Args:
            words: The words of a clause.
            least: Words that follow a kind of things.
        """
        rules = self._rules
        words = words[: min(rules.ends(words))]
        bare = rules.skip_lead(words)
        if not bare or self._marks.within(words) or self.is_gerund(bare) or self.is_of_world(words):
            return True
        if self._marked_begin.begin(words) or self._marked_begin.begin(bare):
            return True
        if self._habits.within(words) and not any(map(rules.is_past, words)):  # `in autumn the leaves fall`
            return True
        if rules.quantities & {*words[: len(words) - len(bare)], bare[0]}:  # `both doors are shut`
            return False
        if self.is_present(words):
            return False
        if bare[0] in rules.indefinite:  # `a truck blocks the road`
            is_long = len(bare) > 1 + LEAST_PREDICATE
            return is_long and not self._certain & set(bare[1 : CERTAIN_WITHIN + 1]) and not self._has_happened(bare)
        return self.is_kind(bare, least=least)

    def _has_happened(self, words: Sequence[str]) -> bool:
        """Whether a clause about any thing reports an event, or has to do with the robot: `a man has waved at me`."""
        rules = self._rules
        return bool(rules.objects & set(words)) or any(map(rules.is_past, words[LEAST_PREDICATE:]))

    def is_kind(self, words: Sequence[str], *, least: int = LEAST_PREDICATE) -> bool:
        """Whether a clause is about a kind of things, and about no certain one: `plants need water`."""
        near = list(pairwise([*words[1 : CERTAIN_WITHIN + 1], ""]))
        is_certain = any(word in self._certain and noun not in self._rules.natural for word, noun in near)
        return any(self._is_kind(words, at, is_certain=is_certain, least=least) for at in range(KIND_WITHIN))

    def _is_kind(self, words: Sequence[str], at: int, *, is_certain: bool, least: int) -> bool:
        """Whether a word names a kind of things, of which the rest is always so: `heavy clay soil holds water`."""
        rules = self._rules
        before, noun, rest = words[:at], words[at : at + 1], words[at + 1 :]
        if len(rest) < least or self._small & {*before, *noun}:
            return False
        if any(rules.is_past(word) or rules.kind_noun.fullmatch(word) for word in before):  # `Anna brings coffee cups`
            return False
        if noun[0] in rules.substances:
            is_one = rules.substance_verb.fullmatch(rest[0]) is not None
        else:
            is_clear = not before or rest[0] in self._linking
            is_one = bool(is_clear and rules.kind_noun.fullmatch(noun[0]) and self._kind_verb.fullmatch(rest[0]))
        is_verb = rest[0] not in rules.function | rules.soft or rest[0] in self._linking
        if rest[0] in rules.perfect | rules.auxiliaries:
            is_reported = bool(rules.states & set(rules.skip(rest[1:])[:1])) or rules.is_past(rest[0])
        else:
            is_reported = rest[0] in rules.relative | rules.states | rules.positions or any(
                map(rules.is_past, rest[:KIND_WITHIN])
            )
        return is_one and is_verb and not is_reported and (not is_certain or rest[0] in rules.stative)

    def is_duty(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a clause demands something of its subject: `the engine must be off`."""
        rules = self._rules
        near = words[subject.end : subject.end + 1] if not rules.verb_second else words[max(0, subject.start - 2) :][:4]
        is_reported = self.is_present(words) or any(map(rules.is_past, words[subject.end :]))
        return bool(rules.duties & set(near)) and not is_reported and not rules.foretold_not & set(words)

    def is_wish(self, words: Sequence[str]) -> bool:
        """Whether a clause only states a wish: `I hope your train is on time`, `so you want the cup in the tray`."""
        rules = self._rules
        bare = rules.skip_lead(words)
        begun = (words[at:] for at in range(len(words) - len(bare) + 1))
        if not any(map(self._wishes.begin, begun)) or rules.deictic & set(bare) or any(map(rules.is_past, bare)):
            return False
        return not (rules.self_words | rules.possessive) & set(bare[2:])

    def is_aside(self, words: Sequence[str], before: Sequence[str]) -> bool:
        """Whether a clause without a verb only adds to the one before: `soda and lime`, `for obvious reasons`."""
        rules = self._rules
        bare = rules.skip_lead(words)
        if len(before) < LONGEST_ASIDE or len(bare) > LONGEST_ASIDE or self.is_present(bare):
            return False
        if (self._stating | self._near | rules.particles | rules.positions) & set(bare):
            return False
        return not any(rules.is_past(each) or rules.is_progressive(each) or each.isdigit() for each in bare)

    def is_generic(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a noun is any of its kind: `a robot`, `most robots`."""
        rules = self._rules
        before, after = words[max(0, subject.start - 2) : subject.start], list(words[subject.end :])
        is_one = bool(rules.indefinite & set(before[:1])) and before[-1] not in rules.articles
        if (is_one or rules.generic & set(before[-1:])) and words[subject.start] in rules.work:
            return True
        is_kind = rules.kind_noun.fullmatch(words[subject.end - 1]) and not rules.owned & set(before)
        return bool(is_kind) and any(word in rules.stative for word in after[: 3 if after[1:2] == ["not"] else 1])

    def is_of_world(self, words: Sequence[str]) -> bool:
        """Whether a clause is about the world, which no mission changes.

        By its subject, `the moon orbits the earth`; by a date of history, `the first robot was built in 1954`; by what
        is far away, `coffee was banned in Sweden`; or by a habit, `apples are usually harvested in autumn`.
        """
        rules = self._rules
        given = set(words)
        if given & (rules.self_words | rules.possessive | rules.objects):
            return False
        if self.is_elsewhere(words):
            return True
        if self.is_present(words):
            return False
        if self._is_of_nature(words):
            return True
        return not self._not_of_habits & given and self._habits.within(words)

    def is_present(self, words: Sequence[str]) -> bool:
        """Whether a clause is about here and now, or about what has just been: `apples roll around here`."""
        rules = self._rules
        return bool(rules.deictic & set(words)) or rules.progress.within(words)

    def _is_dated(self, words: Sequence[str]) -> bool:
        """Whether a clause has a date of history: `in 1954`, `years ago`."""
        return self._dates.search(" ".join(words)) is not None

    def is_elsewhere(self, words: Sequence[str]) -> bool:
        """Whether a clause has a date of history, or what is far away and nothing near: `in Sweden`, `Mozart`."""
        rules = self._rules
        given = set(words)
        if self._is_dated(words):
            return True
        is_near = bool(rules.work & given) or bool(rules.scene & given and self._certain & given)
        return not is_near and not self.is_present(words) and self._far.within(words)

    def _is_of_nature(self, words: Sequence[str]) -> bool:
        """Whether the subject of a clause is of nature or language, and nothing has happened."""
        rules = self._rules
        begun = rules.skip_lead(words)[:WORLD_WITHIN]
        noun = [word for word in begun if word not in rules.articles]
        if not self._world.begin(noun) and not self._world.begin(noun[1:]):
            return False
        verbs = [word for word in (words if rules.verb_second else begun) if word not in rules.auxiliaries]
        return not any(word in rules.acts or rules.is_past(word) for word in verbs)

    def is_ability(self, after: Sequence[str], *, is_conditional: bool) -> bool:
        """Whether the robot only states what it can do, or would under a condition: `I can drive to the barn`.

        What it can see or report is no such thing, and `I can not reach it` reports an attempt.
        """
        rules = self._rules
        modals = rules.conditional if is_conditional else rules.abilities
        if not after or after[0] not in modals or self.is_present(after):
            return False
        return not self._hidden.within(after[1:] if rules.verb_second else after[1:ABILITY_WITHIN])

    def states_ability(self, words: Sequence[str]) -> bool:
        """Whether a clause begins with what the robot can do: `I can drive`."""
        rules = self._rules
        bare = rules.skip_lead(words)
        return bool(rules.speaker & set(bare[:1])) and self.is_ability(bare[1:], is_conditional=False)

    def is_listed(self, words: Sequence[str]) -> bool:
        """Whether a clause adds only infinitives to an ability: `I can follow a row, stop at its end and turn`."""
        rules = self._rules
        bare = [word for word in rules.skip_lead(words) if word not in rules.conjunctions]
        if not bare or bare[-1] in rules.states or self.is_present(words):
            return False
        if self._stating & set(bare) or any(map(rules.is_past, bare)):
            return False
        verb = bare[-1 if rules.verb_second else 0]
        return self._infinitive.fullmatch(verb) is not None and verb not in rules.work | rules.scene | rules.soft

    def is_foretold(self, words: Sequence[str]) -> bool:
        """Whether a clause behind a condition only foretells: `(if it rains,) the soil will be too wet`."""
        rules = self._rules
        given = set(words)
        return bool(rules.future & given) and not given & (rules.self_words | rules.deictic | rules.foretold_not)

    def is_asked(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether the robot is only whom the person may ask: `Sie könnten mich fragen`."""
        rules = self._rules
        before = set(words[: subject.start])
        return words[subject.start] in rules.objects and bool(before & rules.modals) and bool(before & rules.person)

    def is_referring(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether `it` is no subject: `bring it to me`, `tea is best when it is hot`, `explain how it works`."""
        rules = self._rules
        before, after = words[: subject.start], words[subject.end :]
        if after and after[0] in rules.objects_after:
            return True
        is_open = bool(before) and before[-1] in rules.asked and not rules.auxiliaries & set(before[-2:-1])
        if is_open and not any(map(rules.is_past, after[:1])):
            return True
        return bool(before) and self.is_kind(rules.skip_lead(words))

    def is_gerund(self, words: Sequence[str]) -> bool:
        """Whether an act is only spoken of: `waiting is the safest choice`."""
        rules, after = self._rules, words[1:]
        verbs = rules.stative | rules.gerund_verbs
        at = next((at for at, word in enumerate(after) if word in verbs), None)
        if at is None or not rules.is_progressive(words[0]) or rules.objects & set(words):
            return False
        return not self._reported & set(after[at:]) and not rules.progress.within(words)

    def is_habit(self, words: Sequence[str]) -> bool:
        """Whether it has what is usual, or the time of a year: `in autumn`, `usually`."""
        return self._habits.within(words)
