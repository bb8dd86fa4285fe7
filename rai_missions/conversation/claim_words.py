# SPDX-License-Identifier: Apache-2.0
"""The words by which claims are found, of one language: subjects, what they may do, acts, results, idioms."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, Literal, NamedTuple

from rai_missions.conversation.language import Language
from rai_missions.conversation.phrases import Phrases

__all__ = ("ClaimWords", "Subject", "SubjectKind")

POSSESSIVE = re.compile(r"(?<=\w{3})'s\b")
DEFINED_WITHIN = 3
"""Words, without articles, up to which what precedes a noun defines one by it: `an alley is the way between trees`."""
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
SubjectKind = Literal["self", "it", "work", "soft", "let"]


class Subject(NamedTuple):
    """A subject in a clause: the robot itself, `it`, its work or a part of it, or a word that may mean them."""

    kind: SubjectKind
    start: int
    end: int


class ClaimWords:
    """The section `claims` of a language.

    Args:
        language: Whose.
    """

    def __init__(self, language: Language) -> None:
        data: Mapping[str, Any] = language.data["claims"]
        self._data, self._words = data, language.normaliser.words_in
        self.verb_second: bool = data["verb_second"]
        self.harmless, self.let = Phrases(data["harmless"], {}), Phrases(data["let"], {})
        self.progress = Phrases(data["progress"], {})
        self.addresses: Mapping[str, Any] = data["addresses"]
        """What `Addresses` reads."""
        self._place = re.compile(data["place_pattern"])
        self._kind_noun, self._kind_verb = re.compile(data["kind_noun"]), re.compile(data["kind_verb"])
        self._substance_verb = re.compile(data["substance_verb"])
        self._marks, self._marked_begin = Phrases(data["marks"], {}), Phrases(data["marked_begin"], {})
        self.idioms, self.whole_idioms = Phrases(data["idioms"], {}), Phrases(data["whole_idioms"], {})
        self._tails = [tuple(each.split()) for each in data["tails"]]
        self.allowed = {kind: Phrases(each, {}) for kind, each in data["allowed"].items()}
        self._past, self._past_pattern = frozenset(data["past"]), re.compile(data["past_pattern"])
        self._progressive = re.compile(data["progressive_pattern"])
        self._counted = re.compile(rf"\b(?:{data['counted_pattern']})", re.IGNORECASE)
        self.self_words = frozenset(data["self"])
        """The words for the robot itself."""
        self._owned = self.definite | self.possessive
        self._certain = self.definite - self.relative
        self._not_of_habits = self._owned | (self.second - self.present)
        self._world, self._dates = Phrases(data["world"], {}), re.compile(data["date_pattern"])
        self._habits, self._hidden = Phrases(data["habits"], {}), Phrases(data["hidden"], {})
        self._wishes = Phrases(data["wishes"], {})
        self._far, self._advice = Phrases(data["far"], {}), Phrases(data["advice"], {})
        small = (
            self.function,
            self.adverbs,
            self.articles,
            self.auxiliaries,
            self.modals,
            self.person,
            self.quantities,
        )
        self._small = self.substances.union(*small)
        self._reported = self.acts | self.states | self.strong
        subjects = self.self_words | self.possessive | self.person
        self._stating = subjects.union(self.acts, self.strong, self.auxiliaries, self.second)
        self._near = self.definite.union(self.work, self.scene, self.soft, self.quantities, self.negations, self.states)
        self._infinitive = re.compile(data["infinitive"])

    def __getattr__(self, name: str) -> frozenset[str]:
        """A word list of the file, by its name there.

        Raises:
            AttributeError: The file has none of that name.
        """
        words = self.__dict__["_data"].get(name) if "_data" in self.__dict__ else None
        if not isinstance(words, list):
            raise AttributeError(f"the claims of a language have no list '{name}'")
        found = self.__dict__[name] = frozenset(words)
        return found

    def words(self, text: str) -> list[str]:
        """The words of a text that is `readable`; what may be a short `is` is one."""
        return self._words(POSSESSIVE.sub(" is", text) if not self.verb_second else text)

    def is_counted(self, text: str) -> bool:
        """Whether a text has a share, such as `3 of 4`, `four of four` or `75 %`: how far something is."""
        return self._counted.search(text) is not None

    def share(self, words: Sequence[str]) -> float:
        """How many of the words are the language's small words; 0 to 1."""
        return sum(word in self._small for word in words) / max(len(words), 1)

    def subjects(self, words: Sequence[str], names: frozenset[str]) -> Iterator[Subject]:
        """The subjects of a clause, in its order.

        Args:
            words: Of the clause.
            names: What this robot, its mission and its keys are called.
        """
        data, at = self._data, 0
        while at < len(words):
            word, end = words[at], at + 1
            if word in self.self_words:
                yield Subject("self", at, end)
            elif word in data["let_objects"] and at and words[at - 1] in data["let_verbs"]:
                yield Subject("let", at, end)
            elif word in data["it"]:
                yield Subject("it", at, end)
            elif word in data["possessive"] and words[end : end + 1] and words[end] not in data["harmless_nouns"]:
                end = self._last_noun(words, end, names)
                yield Subject("work", at, end)
            elif (word in self.work and not self._is_verb(words, at)) or word in names or self._is_of_scene(words, at):
                end = self._last_noun(words, at, names)
                yield Subject("work", at, end)
            elif word in self.soft:
                yield Subject("soft", at, end)
            at = end

    def _is_verb(self, words: Sequence[str], at: int) -> bool:
        """Whether a noun of the work is the verb of a kind of things here: `tractors run on diesel`."""
        if words[at] not in self.also_verbs:
            return False
        if at and words[at - 1] in self.inverted | self.conditional:  # `can drive`
            return True
        if at not in (1, 2) or words[at - 1] in self.work:
            return False
        return self._kind_noun.fullmatch(words[at - 1]) is not None and not set(words[:at]) & self.definite

    def _last_noun(self, words: Sequence[str], at: int, names: frozenset[str]) -> int:
        """Behind a compound: `mission plan`, `battery status`."""
        at += 1
        while at < len(words) and (words[at] in self.work or words[at] in names):
            at += 1
        return at

    def is_marked(self, words: Sequence[str], *, least: int = LEAST_PREDICATE) -> bool:
        """Whether a sentence has a mark of what is no report: a modal, a condition, a kind of things, a definition.

        Args:
            words: Of a clause.
            least: Words that follow a kind of things.
        """
        words = words[: min(self.ends(words))]
        bare = self.skip_lead(words)
        if not bare or self._marks.within(words) or self.is_gerund(bare) or self.is_of_world(words):
            return True
        if self._marked_begin.begin(words) or self._marked_begin.begin(bare):
            return True
        if self._habits.within(words) and not any(map(self.is_past, words)):  # `in autumn the leaves fall`
            return True
        if self.quantities & {*words[: len(words) - len(bare)], bare[0]}:  # `both doors are shut`
            return False
        if self.is_present(words):
            return False
        if bare[0] in self.indefinite:  # `a truck blocks the road`
            return len(bare) > 1 + LEAST_PREDICATE and not self._certain & set(bare[1 : CERTAIN_WITHIN + 1])
        return self.is_kind(bare, least=least)

    def is_kind(self, words: Sequence[str], *, least: int = LEAST_PREDICATE) -> bool:
        """Whether a clause is about a kind of things, and about no certain one: `plants need water`."""
        near = list(pairwise([*words[1 : CERTAIN_WITHIN + 1], ""]))
        is_certain = any(word in self._certain and noun not in self.natural for word, noun in near)
        return any(self._is_kind(words, at, is_certain=is_certain, least=least) for at in range(KIND_WITHIN))

    def _is_kind(self, words: Sequence[str], at: int, *, is_certain: bool, least: int) -> bool:
        """Whether a word names a kind of things, of which the rest is always so: `heavy clay soil holds water`."""
        before, noun, rest = words[:at], words[at : at + 1], words[at + 1 :]
        if len(rest) < least or (self.articles | self.auxiliaries | self.function) & {*before, *noun}:
            return False
        if any(self.is_past(word) or self._kind_noun.fullmatch(word) for word in before):  # `Anna brings coffee cups`
            return False
        if noun[0] in self.substances:
            is_one = self._substance_verb.fullmatch(rest[0]) is not None
        else:
            is_clear = not before or rest[0] in self.auxiliaries | self.stative
            is_one = bool(is_clear and self._kind_noun.fullmatch(noun[0]) and self._kind_verb.fullmatch(rest[0]))
        is_verb = rest[0] not in self.function | self.soft or rest[0] in self.auxiliaries | self.stative
        if rest[0] in self.perfect | self.auxiliaries:
            is_reported = bool(self.states & set(self.skip(rest[1:])[:1])) or self.is_past(rest[0])
        else:
            is_reported = rest[0] in self.relative | self.states | self.positions or any(
                map(self.is_past, rest[:KIND_WITHIN])
            )
        return is_one and is_verb and not is_reported and (not is_certain or rest[0] in self.stative)

    def is_placed(self, words: Sequence[str]) -> bool:
        """Whether a clause puts something at a certain place: `in front of the gate`, `in row three`.

        A condition or a wish does not: `if the cup is on the table`.
        """
        if self.hypothetical & set(words) or self._is_elsewhere(words):
            return False
        place = self._place.search(" ".join(words))
        return place is not None and not (place.group().split()[-1] in self.natural and self.is_kind(words))

    def has_place(self, words: Sequence[str]) -> bool:
        """Whether a clause has a certain place."""
        return self._place.search(" ".join(words)) is not None

    def _is_of_scene(self, words: Sequence[str], at: int) -> bool:
        """Whether a noun is a certain thing around the robot: `the red cube`, `your cup`, but not `a cup`."""
        before = words[max(0, at - 2) : at]
        if words[at] not in self.scene or not before:
            return False
        return before[-1] in self.definite or (before[0] in self.definite and before[-1] not in self.articles)

    def is_object(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a noun is no subject: `ask the robot`, `about your mission`, `you could clear the desk`."""
        before = [word for word in words[: subject.start] if word not in self.articles]
        if not before:
            return False
        is_advice = words[subject.start] not in self.possessive and self._advice.begin(before)
        is_defined = (
            words[0] in self.indefinite
            and len(before) <= DEFINED_WITHIN
            and before[-1] in self.present
            and not self.has_place(words)
        )
        return before[-1] in self.objects_after or is_advice or is_defined

    def is_duty(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a clause demands something of its subject: `the engine must be off`."""
        near = words[subject.end : subject.end + 1] if not self.verb_second else words[max(0, subject.start - 2) :][:4]
        is_reported = self.is_present(words) or any(map(self.is_past, words[subject.end :]))
        return bool(self.duties & set(near)) and not is_reported and not self.foretold_not & set(words)

    def is_wish(self, words: Sequence[str]) -> bool:
        """Whether a clause only wishes: `I hope your train is on time`."""
        bare = self.skip_lead(words)
        if not self._wishes.begin(bare) or self.deictic & set(bare) or any(map(self.is_past, bare)):
            return False
        return not (self.self_words | self.possessive) & set(bare[2:])

    def is_aside(self, words: Sequence[str], before: Sequence[str]) -> bool:
        """Whether a clause without a verb only adds to the one before: `soda and lime`, `for obvious reasons`."""
        bare = self.skip_lead(words)
        if len(before) < LONGEST_ASIDE or len(bare) > LONGEST_ASIDE or self.is_present(bare):
            return False
        if (self._stating | self._near | self.particles | self.positions) & set(bare):
            return False
        return not any(self.is_past(each) or self.is_progressive(each) or each.isdigit() for each in bare)

    def is_generic(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a noun is any of its kind: `a robot`, `most robots`."""
        before, after = words[max(0, subject.start - 2) : subject.start], list(words[subject.end :])
        is_one = bool(self.indefinite & set(before[:1])) and before[-1] not in self.articles
        if (is_one or self.generic & set(before[-1:])) and words[subject.start] in self.work:
            return True
        is_kind = self._kind_noun.fullmatch(words[subject.end - 1]) and not self._owned & set(before)
        return bool(is_kind) and any(word in self.stative for word in after[: 3 if after[1:2] == ["not"] else 1])

    def is_of_world(self, words: Sequence[str]) -> bool:
        """Whether a clause is about the world, which no mission changes.

        By its subject, `the moon orbits the earth`; by a date of history, `the first robot was built in 1954`; by what
        is far away, `coffee was banned in Sweden`; or by a habit, `apples are usually harvested in autumn`.
        """
        given = set(words)
        if given & (self.self_words | self.possessive | self.objects):
            return False
        if self._is_elsewhere(words):
            return True
        if self.is_present(words):
            return False
        if self._is_of_nature(words):
            return True
        return not self._not_of_habits & given and self._habits.within(words)

    def is_present(self, words: Sequence[str]) -> bool:
        """Whether a clause is about here and now, or about what has just been: `apples roll around here`."""
        return bool(self.deictic & set(words)) or self.progress.within(words)

    def _is_dated(self, words: Sequence[str]) -> bool:
        """Whether a clause has a date of history: `in 1954`, `years ago`."""
        return self._dates.search(" ".join(words)) is not None

    def _is_elsewhere(self, words: Sequence[str]) -> bool:
        """Whether a clause has a date of history, or what is far away and nothing near: `in Sweden`, `Mozart`."""
        given = set(words)
        if self._is_dated(words):
            return True
        is_near = bool(self.work & given) or bool(self.scene & given and self._certain & given)
        return not is_near and not self.is_present(words) and self._far.within(words)

    def _is_of_nature(self, words: Sequence[str]) -> bool:
        """Whether the subject of a clause is of nature or language, and nothing has happened."""
        begun = self.skip_lead(words)[:WORLD_WITHIN]
        noun = [word for word in begun if word not in self.articles]
        if not self._world.begin(noun) and not self._world.begin(noun[1:]):
            return False
        verbs = [word for word in (words if self.verb_second else begun) if word not in self.auxiliaries]
        return not any(word in self.acts or self.is_past(word) for word in verbs)

    def is_ability(self, after: Sequence[str], *, is_conditional: bool) -> bool:
        """Whether the robot only states what it can do, or would under a condition: `I can drive to the barn`.

        What it can see or report is no such thing, and `I can not reach it` reports an attempt.
        """
        modals = self.conditional if is_conditional else self.abilities
        if not after or after[0] not in modals or self.is_present(after):
            return False
        return not self._hidden.within(after[1:] if self.verb_second else after[1:ABILITY_WITHIN])

    def states_ability(self, words: Sequence[str]) -> bool:
        """Whether a clause begins with what the robot can do: `I can drive`."""
        bare = self.skip_lead(words)
        return bool(self.speaker & set(bare[:1])) and self.is_ability(bare[1:], is_conditional=False)

    def is_listed(self, words: Sequence[str]) -> bool:
        """Whether a clause adds only infinitives to an ability: `I can follow a row, stop at its end and turn`."""
        bare = [word for word in self.skip_lead(words) if word not in self.conjunctions]
        if not bare or bare[-1] in self.states or self.is_present(words):
            return False
        if self._stating & set(bare) or any(map(self.is_past, bare)):
            return False
        verb = bare[-1 if self.verb_second else 0]
        return self._infinitive.fullmatch(verb) is not None and verb not in self.work | self.scene | self.soft

    def is_foretold(self, words: Sequence[str]) -> bool:
        """Whether a clause behind a condition only foretells: `(if it rains,) the soil will be too wet`."""
        given = set(words)
        return bool(self.future & given) and not given & (self.self_words | self.deictic | self.foretold_not)

    def is_asked(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether the robot is only whom the person may ask: `Sie könnten mich fragen`."""
        before = set(words[: subject.start])
        return words[subject.start] in self.objects and bool(before & self.modals) and bool(before & self.person)

    def is_referring(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether `it` is no subject: `bring it to me`, `tea is best when it is hot`, `explain how it works`."""
        before, after = words[: subject.start], words[subject.end :]
        if after and after[0] in self.objects_after:
            return True
        is_open = bool(before) and before[-1] in self.asked and not self.auxiliaries & set(before[-2:-1])
        if is_open and not any(map(self.is_past, after[:1])):
            return True
        return bool(before) and self.is_kind(self.skip_lead(words))

    def is_gerund(self, words: Sequence[str]) -> bool:
        """Whether an act is only spoken of: `waiting is the safest choice`."""
        after = words[1:]
        at = next((at for at, word in enumerate(after) if word in self.stative or word in self.gerund_verbs), None)
        if at is None or not self.is_progressive(words[0]) or self.objects & set(words):
            return False
        return not self._reported & set(after[at:]) and not self.progress.within(words)

    def reports(self, after: Sequence[str], *, is_relative: bool) -> bool:
        """Whether what follows a word reports an act or a state: `has arrived`, `is done`, `went well`."""
        predicate = self.skip(after)
        if not predicate:
            return False
        if predicate[0] in self.perfect or predicate[0] in self.auxiliaries:
            rest = predicate[1:2] if set(predicate[1:2]) & self.states else self.skip(predicate[1:])
            is_bare = predicate[0] in self.auxiliaries and predicate[0] not in self.perfect
            if rest and (rest[0] in self.acts or rest[0] in self.states or rest[0] in self.strong):
                return True
            return self.has_act(predicate[1:]) or (is_bare and self.is_past(predicate[0]) and not is_relative)
        return predicate[0] in self.acts or (not is_relative and self.is_past(predicate[0]))

    def is_certain(self, words: Sequence[str], subject: Subject, *, is_fact: bool) -> bool:
        """Whether a clause is a claim by its structure alone: of whom it is, and what its verb reports.

        The robot itself with a past, a perfect or what it is doing, and a certain thing of the mission that begins the
        clause with any verb but a modal: `I have mowed`, `the tank holds ten litres`, but not `tanks hold water`.

        Args:
            words: Of the clause.
            subject: One of its subjects.
            is_fact: Whether its sentence has no modal, condition or habit.
        """
        before, after = words[: subject.start], words[subject.end :]
        turned = [*before[-1:], *after] if self.verb_second else []
        if subject.kind == "soft" or words[subject.start] in self.objects or self._is_of_kind(words, subject):
            return False
        if subject.kind == "work" and not is_fact:
            return False
        if self.reports(after, is_relative=False) or self.reports(turned, is_relative=False):
            return True
        predicate = self.skip(after)
        if subject.kind == "self":
            return self._is_done_by(predicate) or self._is_done_by(self.skip(turned))
        return subject.kind == "work" and bool(predicate) and self._is_begun_by(words, subject)

    def _is_of_kind(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a subject is any of its kind, or an `it` of no thing: `the door of a fridge`, `it is wise to ask`."""
        after = words[subject.end : subject.end + CERTAIN_WITHIN + 1]
        if subject.kind == "it":
            return "to" in after[2:] and not any(map(self.is_past, after))
        is_part = bool(set(after[:1]) & self.objects_after and set(after[1:2]) & self.indefinite)
        return subject.kind == "work" and (is_part or self.is_generic(words, subject))

    def _is_begun_by(self, words: Sequence[str], subject: Subject) -> bool:
        """Whether a subject begins its clause as a certain thing: `the red cube`, `my left wheel`, `row three`."""
        bare, named = self.skip_lead(words[: subject.end]), words[subject.start : subject.end]
        before = bare[: len(bare) - len(named)]
        if not before:
            return bool(self.possessive & set(named) or self.quantities & set(words[subject.end : subject.end + 1]))
        return len(before) <= CERTAIN_WITHIN and before[0] in self._owned | self.quantities

    def _is_done_by(self, predicate: Sequence[str]) -> bool:
        """Whether a verb group reports an act of its subject: `went`, `have mowed`, `am turning`."""
        if not predicate or predicate[0] in self.relative:
            return False
        if predicate[0] in self.perfect or predicate[0] in self.auxiliaries or predicate[0] in self.second:
            rest = self.skip(predicate[1:])
            near = rest if self.verb_second else rest[:1]
            return any(self.is_past(each) or self.is_progressive(each) for each in near)
        return self.is_past(predicate[0])

    def begins_certain(self, words: Sequence[str]) -> bool:
        """Whether a certain thing, or a number of things, begins a clause: `the red cube`, `both arms`, `no apple`."""
        bare = self.skip_lead(words)
        begun = self.quantities | self.definite | self.possessive | self.negations
        if bare and self.verb_second and bare[0] not in begun:  # `bei Baum 18 hat die Pumpe ausgesetzt`
            bare = next((bare[at + 1 :] for at, word in enumerate(bare) if word in self.perfect), [])
        return bool(bare) and bare[0] in begun - self.objective

    def is_scene(self, words: Sequence[str]) -> bool:
        """Whether a clause that a certain thing begins reports its place, its past, or what is here and now.

        `The scarf lies on the chair`, `the cable came loose`, `your desk is tidy again`.
        """
        if self.is_of_world(words):
            return False
        is_past = not self.verb_second and any(map(self.is_past, words))
        return is_past or bool(self.deictic & set(words)) or self.has_place(words)

    def is_doing(self, words: Sequence[str]) -> bool:
        """Whether a thing, but no person who is spoken to, is doing something: `a truck is blocking the road`."""
        if self.verb_second or self.person & set(words) or self.is_of_world(words):
            return False
        verbs = (self.skip(words[at + 1 :]) for at, word in enumerate(words) if at and word in self.auxiliaries)
        return any(map(self.is_progressive, (verb for rest in verbs for verb in rest[:1])))

    def is_habit(self, words: Sequence[str]) -> bool:
        """Whether it has what is usual, or the time of a year: `in autumn`, `usually`."""
        return self._habits.within(words)

    def has_finite(self, words: Sequence[str]) -> bool:
        """Whether a clause has a verb of its own: `waiting is safe`, `well matters more`, `you know`."""
        own = self.auxiliaries | self.perfect | self.modals | self.person | self.stative | self.gerund_verbs
        after = self.skip_lead(words)[1:]
        return bool(own & set(after)) or (not self.verb_second and any(map(self._substance_verb.fullmatch, after[:2])))

    def has_act(self, words: Sequence[str]) -> bool:
        """Whether an act of a robot follows an auxiliary; in German anywhere up to the clause's end."""
        if self.verb_second:
            return any(
                word in self.acts or self._past_pattern.fullmatch(word) for word in words if word not in self.not_past
            )
        rest = self.skip(words)
        while rest and rest[0] in self.perfect:
            rest = self.skip(rest[1:])
        return bool(rest) and rest[0] in self.acts

    def has_been(self, words: Sequence[str]) -> bool:
        """`has been looked at`: a perfect of the passive, whatever the act."""
        if self.verb_second or len(words) < 3 or words[1] not in self.been:
            return False
        rest = self.skip(words[2:])
        return bool(rest) and self.is_past(rest[0])

    def is_past(self, word: str) -> bool:
        """Whether it looks like a past tense or a participle."""
        return word in self._past or (word not in self.not_past and self._past_pattern.fullmatch(word) is not None)

    def is_progressive(self, word: str) -> bool:
        """Whether it looks like `moving`."""
        return word not in self.not_progressive and self._progressive.fullmatch(word) is not None

    def skip(self, words: Sequence[str]) -> list[str]:
        """Without the adverbs at its beginning."""
        at = 0
        while at < len(words) and (words[at] in self.adverbs or self._is_adverb(words[at])):
            at += 1
        return list(words[at:])

    def _is_adverb(self, word: str) -> bool:
        ending: str = self._data["adverb_ending"]
        return bool(ending) and word.endswith(ending) and len(word) > len(ending) + 2

    def skip_lead(self, words: Sequence[str]) -> list[str]:
        """Without what leads in: `okay`, `sure`, `now`."""
        at = 0
        while at < len(words) and words[at] in self.lead:
            at += 1
        return self.skip(words[at:])

    def leading(self, words: Sequence[str]) -> int:
        """How many words at its beginning only lead in."""
        at = 0
        while at < len(words) and (words[at] in self.lead or self._is_adverb(words[at])):
            at += 1
        return at

    def ends(self, words: Sequence[str]) -> Iterator[int]:
        """Where a clause may end, its harmless tails left out one after the other: `done | for you | today`."""
        end = len(words)
        yield end
        while tail := next((each for each in self._tails if tuple(words[:end])[-len(each) :] == each), None):
            end -= len(tail)
            yield end
