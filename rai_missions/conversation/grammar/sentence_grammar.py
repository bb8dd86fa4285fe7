# SPDX-License-Identifier: Apache-2.0
"""The grammar of one sentence: what its words may mean now.

Rule: the word to stop comes first, whatever else it could be; it needs no question, no state and no confirmation.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, groupby

from rai_missions.conversation.grammar.corrections import Corrections, Draft
from rai_missions.conversation.grammar.free_answers import text_option
from rai_missions.conversation.grammar.mission_starts import MissionStarts
from rai_missions.conversation.grammar.names import called, missions_named
from rai_missions.conversation.grammar.option_answers import OptionAnswers
from rai_missions.conversation.grammar.senses import FAULT, STOP, Sense, is_fault
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.grammar.state_questions import StateQuestions
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.view import StatusView
from rai_missions.engine.decision import Question
from rai_missions.planning.text.normalise import LONGEST_WORD, nearest, once

__all__ = ("MOST_MENDED", "MOST_WORDS", "NONE", "SentenceGrammar")

MOST_WORDS = 40
"""Words of the longest sentence that may be an order or a question of state."""
MOST_MENDED = 12
"""Words of the longest sentence in which misspelled words are mended, and of the longest correction inside one."""
DRAWN_OUT = re.compile(r"([^\W\d_])\1{2,}")
"""A letter that is written as long as it is drawn out: `stooop`; a digit counts as often as it is written."""
POLITE, LONGEST_GREETING = ("hello", "thanks", "sorry"), 3
"""Questions that are none and may be ahead of any sentence, and the words of the longest."""
MOST_NESTED = 3
"""Questions and tags that are read inside one another."""
MOST_READ = 1_000
"""Readings that are remembered while the run is the same."""
NONE: Mapping[str, str] = {}


class SentenceGrammar:
    """Reads single sentences of one language.

    Args:
        language: Its data.
        phrases: Sentences of the robot's own that start a mission.
        questions: Questions of the robot's own → the key, or the field of one, whose value answers them.

    Raises:
        UsageError: A question is not closed, or names a part that does not exist.
    """

    def __init__(self, language: Language, phrases: StartPhrases | None, questions: Mapping[str, str]) -> None:
        self.language = language
        self._phrases = phrases or StartPhrases({}, {}, language)
        self._corrections = Corrections(language, self._phrases)
        self.options, self._starts = OptionAnswers(language), MissionStarts(language, self._phrases)
        self.questions = StateQuestions(language, questions)
        data = language.data
        self._quoting, self._informing = frozenset(data["quoting"]), frozenset([*data["speaking"], *data["addressed"]])
        """Words that report those of others, and who may report their own: `as I wrote`."""
        pronouns = frozenset(data["pronouns"])
        self._things = frozenset(data["thing_pronouns"])
        self._undecided = language.negations | {language.text("or")}
        self._subjects = pronouns - self._things
        self._there = sorted((each.split() for each in data["there"]), key=len, reverse=True)
        self._ends_of_there = frozenset(each[-1] for each in self._there)
        self._referring = self._things | self._ends_of_there | (pronouns & language.articles)
        """Words of which one is in each sentence that is about what was named before."""
        self._persons = pronouns - language.articles
        self._view: StatusView | None = None
        self._known = dict[tuple[str, ...], tuple[Sense, ...]]()
        """What words mean in this view: a sentence, its clauses and its parts are read by several."""
        self._vocabulary = language.vocabulary | self._phrases.words | self.questions.words

    def senses(self, words: list[str], view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        """What the words may mean in this moment; several where they are ambiguous, empty for other talk.

        Args:
            words: The words of one sentence.
            view: The run: which options, missions and keys there are.
            draft: The order that it may correct.
        """
        if draft is not None:
            return self._read(words, view, draft)
        if view is not self._view or len(self._known) >= MOST_READ:
            self._view, self._known = view, {}
        key = tuple(words)
        if key not in self._known:
            self._known[key] = self._read(words, view)
        return self._known[key]

    def _read(self, words: list[str], view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        normaliser = self.language.normaliser
        if not words or len(words) > MOST_WORDS or max(map(len, words)) > LONGEST_WORD:
            return ()
        bare = list(once(normaliser.bare(words, called(view.robot))))
        found = self._first(words, bare, view, draft) or self._indirect(bare, view)
        found = found or tuple(self._phrases.incomplete(bare, view.missions))
        for mended in self._mended(bare, view) if len(bare) <= MOST_MENDED and is_fault(found or FAULT) else ():
            again = self._first(mended, normaliser.bare(mended, called(view.robot)), view, draft)
            if again and not is_fault(again):
                return self._unsure(again, mended, view)
            found = found or again
        return self._unsure(found, words, view)

    def _unsure(self, senses: tuple[Sense, ...], words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """The senses of which the words leave doubt are partial: of `first, second`, of `yes, I suppose`.

        So is a greeting to another.
        """
        if any(each.kind == "question" and each.name in POLITE for each in senses):
            return tuple(each._replace(is_partial=self._greets_another(words, view)) for each in senses)
        ordinals = self.language.data["ordinals"]
        places = {ordinals[word] for word in words if word in ordinals and len(word) > 1}  # "a" is an article too
        is_asked = words[0] in self.language.data["asking"] and words[0] not in self.language.data["requesting"]
        is_open = len(places) > 1 or is_asked or self.language.doubting.within(words)
        is_doubtful = (
            is_open if each.option else each.kind == "yes" and (is_open or not self._agrees(words, view))
            for each in senses
        )
        both = zip(senses, is_doubtful, strict=True)
        return tuple(each._replace(is_partial=True) if doubtful else each for each, doubtful in both)

    def _agrees(self, words: list[str], view: StatusView) -> bool:
        """Whether words are a yes but for politeness, and have no refusal: `never mind, okay`, `perfect, hardly`."""
        normaliser, names = self.language.normaliser, called(view.robot)
        forms = (words, *(normaliser.bare(words, names, is_tail_first=each) for each in (False, True)))
        return any(map(self.language.yes.fits, forms)) and not self.language.no.within(words)

    def _first(self, words: list[str], bare: list[str], view: StatusView, draft: Draft | None) -> tuple[Sense, ...]:
        """What the likeliest form of a sentence means that means something."""
        return next(filter(None, (self._words(each, view, draft) for each in self._forms(words, bare, view))), ())

    def part(self, words: list[str], view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        """What one part of several means; a greeting to another, `hey Otto`, is not read: the rest may be for Otto."""
        found = self.senses(words, view, draft)
        return () if any(each.name in POLITE and each.is_partial for each in found) else found

    def open_texts(self, sense: Sense) -> list[str]:
        """The texts that a start has from the sentence for arguments that take any words."""
        values = (sense.arguments.get(name) for name in sense.named if not self._phrases.choices(name))
        return [value for value in values if isinstance(value, str)]

    def is_complete(self, sense: Sense, rest: Sequence[str]) -> bool:
        """Whether words behind a start cannot belong to its values: all are of a list, or another subject follows."""
        return (
            not rest
            or rest[0] in self._subjects
            or all(self._phrases.choices(name) or isinstance(sense.arguments[name], str) for name in sense.named)
        )

    def begins_a_start(self, words: Sequence[str]) -> bool:
        """Whether the words begin with a phrase of the robot's own that starts a mission, `go` ahead of it or not."""
        going = self.language.data["going"]
        return self._phrases.begin(words) or (words[0] in going and self._phrases.begin(words[1:]))

    def orders(self, words: list[str], view: StatusView) -> list[Sense]:
        """The orders of the language that words are.

        What may start as well as resume, `off you go`, resumes a run that has begun, and starts one that has not. Words
        of others order nothing: `keep going, he wrote`.
        """
        if not self._quoting.isdisjoint(words) and self._informing.isdisjoint(words):
            return []
        found = [Sense("order", name) for name, each in self.language.orders.items() if each.fits(words)]
        starts = self._starts.senses(words, view) if self.language.start.fits(words) else []
        if Sense("order", "resume") in found and view.is_alive and not view.is_before_start:
            return found
        return [*(each for each in found if each.name != "resume" or not starts), *starts]

    def begins_an_order(self, words: Sequence[str]) -> bool:
        """Whether the words begin with a phrase of an order."""
        return self.begins_a_start(words) or self.language.any_order.begin(words)

    def is_value(self, words: Sequence[str], view: StatusView) -> bool:
        """Whether the words are a start by a value alone: `the kitchen`."""
        return any(True for _ in self._phrases.valued(self.language.normaliser.bare(list(words)), view.missions))

    def start_in(self, words: Sequence[str], view: StatusView, before: Sequence[Sequence[str]] = ()) -> Sense | None:
        """The start that the words are by a phrase of the robot's own; None where there is none, or several.

        Args:
            words: The words of a sentence, or of a part of one.
            view: The run.
            before: What was uttered before, for pronouns.
        """
        found = list(self._phrases.senses(words, view.missions, before))
        return found[0] if len(found) == 1 and found[0].kind == "order" else None

    def referring(self, words: list[str], view: StatusView, before: Sequence[Sequence[str]]) -> tuple[Sense, ...]:
        """The start whose pronouns are what was named before: `hand it to her`, `wait there`; empty where none is.

        Args:
            words: The words of a sentence, or of a part of one.
            view: The run.
            before: What was uttered before, the last at the end.
        """
        if not before or self._referring.isdisjoint(words):
            return ()
        bare = self.language.normaliser.bare(words, called(view.robot))
        forms = chain(self._forms(words, bare, view), self._corrections.instead(bare))
        found = (
            self._placed(form, view, before) or self.start_in(form, view, before)
            for form in forms
            if form and self._is_about_earlier(form, view)
        )
        sense = next((each for each in found if each is not None), None)
        return (sense,) if sense is not None else ()

    def _is_about_earlier(self, words: Sequence[str], view: StatusView) -> bool:
        """Whether words are no start by themselves, or have one of the words for a place that was named."""
        return self.start_in(words, view) is None or not self._ends_of_there.isdisjoint(words)

    def _placed(self, words: Sequence[str], view: StatusView, before: Sequence[Sequence[str]]) -> Sense | None:
        """The start with the place that was named last for `there`: `wait there`; None where there is none."""
        found = (
            (at, len(each)) for each in self._there for at in range(1, len(words)) if words[at:][: len(each)] == each
        )
        at, size = next(found, (0, 0))
        place = next(self.places_in(before), []) if size else []
        for joint in self.language.data["place_joints"] if place else ():
            in_place = [*joint.split(), *place]
            sense = self.start_in([*words[:at], *in_place, *words[at + size :]], view, before)
            if sense is not None and not set(in_place).intersection(" ".join(self.open_texts(sense)).split()):
                return sense
        return None

    def places_in(self, clauses: Sequence[Sequence[str]]) -> Iterator[list[str]]:
        """The listed values that clauses name, the last first, each as it is called there."""
        for words in reversed(clauses):
            for at in range(len(words) - 1, -1, -1):
                yield from (list(name) for name in self._phrases.names if tuple(words[at : at + len(name)]) == name)

    def located(self, sense: Sense, words: Sequence[str], rest: Sequence[str], view: StatusView) -> Sense:
        """The start with the one place that words about its thing name: `find the cup, it is in the study`.

        Args:
            sense: A start with a thing and no place of its own, or any other sense, which stays as it is.
            words: The words of the start.
            rest: The clauses behind it.
            view: The run.
        """
        pronouns = self._things - self.language.articles
        is_about_it = not self._things.isdisjoint(rest[:1]) or not pronouns.isdisjoint(rest)
        texts = self.open_texts(sense)
        if not texts or not is_about_it or not self._undecided.isdisjoint(rest):
            return sense
        bare, found = self.language.normaliser.bare(list(words)), list[Sense]()
        for place in self.places_in([rest]):
            end = next(at for at in range(len(rest)) if rest[at : at + len(place)] == place) + len(place)
            begins = (at for at in range(end - len(place) - 1, -1, -1) if rest[at] in self.language.spatial)
            starts = (self.start_in([*bare, *rest[at:end]], view) for at in begins)
            found += [each for each in starts if each is not None and self.open_texts(each) == texts][:1]
        return found[0]._replace(is_partial=True) if len(found) == 1 else sense

    def half(self, words: Sequence[str], draft: Draft, view: StatusView) -> Sense | None:
        """The draft with the values that a half sentence names; None for other talk."""
        return self._corrections.half(words, draft, view)

    def names(self, words: Sequence[str], sense: Sense, view: StatusView) -> bool:
        """Whether words are a half sentence whose values are all of a start."""
        return self._corrections.names(words, sense, view)

    def has_pronoun(self, words: Sequence[str]) -> bool:
        """Whether a thing is not named in words, but pointed at: `it`."""
        return not (self._things - self.language.articles).isdisjoint(words)

    def place_in(self, words: Sequence[str]) -> int | None:
        """The place of which words are but the number, from 0: -1 for `the last one`; None for other words."""
        ordinals: Mapping[str, int] = self.language.data["ordinals"]
        places = [ordinals[word] for word in words if word in ordinals and len(word) > 1]
        is_plain = all(word in ordinals or self._corrections.is_around(word) for word in words)
        return places[0] - (places[0] > 0) if is_plain and len(places) == 1 else None

    def names_own_verb(self, words: Sequence[str]) -> bool:
        """Whether a verb is one of the robot's phrases, in another form: `laying`, of `lay {bricks} on {wall}`."""
        stems = (stem for stem in self.language.verb_stems(words) if stem != list(words)) if words else ()
        return any(self._phrases.own_words.issuperset(stem) for stem in stems)

    def knows(self, word: str) -> bool:
        """Whether a word is in a phrase of the language or of the robot."""
        return word in self._vocabulary

    def answers(self, words: list[str], questions: Sequence[Question]) -> bool:
        """Whether the words would answer one of these questions, as a whole or as a correction."""
        ways = [words, *self._corrections.instead(words)] if words and len(words) <= MOST_MENDED else []
        return any(self.options.fits(each, questions) for each in ways)

    def _forms(self, words: list[str], bare: list[str], view: StatusView) -> Iterator[list[str]]:
        """What of a sentence may be what is meant, the likeliest first; what is not asked for is not worked out."""
        normaliser, names = self.language.normaliser, called(view.robot)
        yield from self._verb_behind(words, view)
        yield bare
        yield from self._polite(words, view)
        yield words
        yield self._unnamed(bare, view)
        yield normaliser.bare(words, names, is_tail_first=True)
        yield from self._ungreeted(words)
        yield from self._infinitive(words, view)
        yield from normaliser.openings(words, names)
        yield from self._directed(words, view)
        yield from self._counted(bare, view)

    def _polite(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The order inside a polite sentence, in the form of an order: `go home` of `would you mind going home`."""
        names = called(view.robot)
        for opening in self.language.normaliser.openings(words, names):
            for slots in self.language.polite.match(opening):
                yield from self._imperatives(self.language.normaliser.bare(slots["order"].split(), names), view)

    def _verb_behind(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The start whose verb is behind its thing: `wipe the hob` of `give the hob a wipe`, `the hob needs wiping`."""
        for opening in self.language.normaliser.openings(words, called(view.robot)):
            for slots in self.language.verbs_behind.match(opening):
                verbs = self.language.verb_stems(slots["verb"].split())
                forms = ([*verb, *slots["thing"].split()] for verb in verbs)
                yield from (form for form in forms if self.start_in(form, view))

    def _directed(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The start that lacks its verb: `go to the dock` of `then off to the dock`; it answers an open question."""
        openings = self.language.normaliser.openings(words, called(view.robot)) if not view.questions else ()
        for opening in openings:
            for slots in self.language.directed.match(opening):
                ways = (opening, slots.get("way", "").split())
                forms = [[verb, *way] for verb in self.language.data["going_to"] for way in ways]
                yield from (form for form in forms if self.start_in(form, view))

    def _infinitive(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The order that ends with an infinitive, in languages that have such: `in die Küche fahren`; no statement."""
        bare = self.language.normaliser.spoken(words)
        if self.language.data["infinitive_orders"] and bare[-1:] != bare[:1] and not self._persons & set(bare):
            yield from self._imperatives(bare, view)

    def _imperatives(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """An order whose verb has another form, as it is in an order; the verb may be one of the robot's phrases."""
        yield self.language.imperative(words)
        if self.language.data["infinitive_orders"]:
            forms = ([*verb, *words[:-1]] for verb in self.language.verb_stems(words[-1:]))
            yield from (form for form in forms if self.start_in(form, view))

    def _counted(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The start whose number is ahead of its noun: `open the drawer 2` of `open the second drawer`."""
        ordinals: Mapping[str, int] = self.language.data["ordinals"]
        places = (at for at, word in enumerate(words[:-1]) if len(word) > 1 and ordinals.get(word, 0) > 0)
        forms = ([*words[:at], words[at + 1], str(ordinals[words[at]]), *words[at + 2 :]] for at in places)
        yield from (form for form in forms if self.start_in(form, view))

    def _indirect(self, words: list[str], view: StatusView, depth: int = MOST_NESTED) -> tuple[Sense, ...]:
        """The question inside another or with a tag: `where are you` of `I wonder where you are, roughly`.

        Args:
            words: The words of the sentence, without politeness.
            view: The run.
            depth: How many questions may still be inside one another.
        """
        for slots in self.language.indirect.match(words) if depth else ():
            inner = (slots.get("question") or slots["clause"]).split()
            forms = self._direct(inner) if "clause" in slots else [inner]
            each = (self._asked(form, view) for form in forms)
            if found := next(filter(None, each), ()) or self._indirect(inner, view, depth - 1):
                return found
        return ()

    def _asked(self, words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """The question that words are; with the order to look for its thing, where a phrase of the robot has one."""
        asked = self.questions.sense(words, view)
        is_order = bool(asked.thing) if asked is not None else words[0] in self.language.data["asking"]
        found = self._phrased(words, view) if is_order else []
        return tuple(self._asked_or_ordered(asked, found))

    def _direct(self, words: list[str]) -> Iterator[list[str]]:
        """The words of a clause with a verb ahead of the subject, `where are you`; then as they are."""
        subjects = self.language.data["subjects"]
        at = next((at for at, word in enumerate(words) if word in subjects), len(words))
        for verb in range(len(words) - 1, at, -1):
            yield [*words[:at], words[verb], *words[at:verb], *words[verb + 1 :]]
        for auxiliary in self.language.data["auxiliaries"] if at < len(words) else ():
            yield [*words[:at], auxiliary, *words[at:]]
        yield words

    def _greets_another(self, words: list[str], view: StatusView) -> bool:
        """Whether a greeting has a name behind it that is none of this robot's."""
        normaliser, names = self.language.normaliser, called(view.robot)
        forms = (words, *(normaliser.bare(words, names, is_tail_first=each) for each in (False, True)))
        return not any(self.language.questions[name].fits(form) for name in POLITE for form in forms)

    def _ungreeted(self, words: list[str]) -> Iterator[list[str]]:
        """The words after a greeting: `good morning, who are you?`; then the greeting, where they are but a name."""
        for at in range(min(LONGEST_GREETING, len(words) - 1), 0, -1):
            if any(self.language.questions[name].fits(words[:at]) for name in POLITE):
                yield words[at:]
                yield words[:at] if len(words) - at == 1 else []
                return

    def _unnamed(self, words: list[str], view: StatusView) -> list[str]:
        """The words with `mission` in place of the running mission's name: `pause the patrol`."""
        name, word = set(spoken(view.mission).split()), self.language.data["mission_word"]
        runs = [(is_name, list(run)) for is_name, run in groupby(words, key=name.__contains__)]
        named = [run for is_name, run in runs if is_name]
        if not named or not all(_is_own(run, view, self.language) for run in named):
            return []
        return [each for is_name, run in runs for each in ([word] if is_name else run)]

    def _mended(self, words: list[str], view: StatusView) -> Iterator[list[str]]:
        """The words without small errors of a recogniser or a keyboard: with the certain ones mended, then with all."""
        known = {*self._vocabulary, *_words_of(view)}
        misheard = self.language.data["mishearings"]
        short = [word if word in known else DRAWN_OUT.sub(r"\1", word) for word in words]
        mended = [misheard.get(word, word) if word not in known else word for word in short]
        if len(words) == 1:
            mended = [misheard.get(short[0], short[0])]
        certain = [self.language.spelled(self.language.unclipped(word, known), known) for word in mended]
        near = [nearest(word, known) for word in certain]
        yield from (each for each, before in ((certain, words), (near, certain)) if each != before)

    def _words(self, words: list[str], view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        language = self.language
        if not words:
            return ()
        if language.quiet.fits(words):
            return (Sense("quiet"),)
        if language.withdraw.fits(words):
            return (Sense("withdraw"),)
        if language.orders["stop"].fits(words):
            return (STOP,)
        found = [Sense("yes")] if language.yes.fits(words) else [Sense("no")] if language.no.fits(words) else []
        found += self.options.senses(words, view)
        found += self.orders(words, view)
        found += [Sense("again")] if language.again.fits(words) else []
        found += self._phrased(words, view)
        if is_fault(found):  # `go to the kitchen instead` has no place of that name in it
            found = [each for each in self._corrected(words, view, draft) if each.kind == "order"] or found
        found = found or self._corrected(words, view, draft)
        if not found and text_option(view.questions) is None:
            found = list(self._phrases.valued(words, view.missions))
        if not found or words[0] in self.language.data["asking"]:
            found = self._asked_or_ordered(self.questions.sense(words, view), found)
        return tuple({sense.identity: sense for sense in found}.values())

    def _phrased(self, words: list[str], view: StatusView) -> list[Sense]:
        """A start by a phrase of the profile; where a text is asked for, it may be that as well."""
        found, option = list(self._phrases.senses(words, view.missions)), text_option(view.questions)
        return [*found, option.free(words)] if found and option is not None else found

    def _asked_or_ordered(self, asked: Sense | None, found: list[Sense]) -> list[Sense]:
        """A question alone, where nothing else fits; with the order to look for its thing: `where is my cup`."""
        if asked is None:
            return found
        if not found or is_fault(found):
            return [asked]
        return [asked, *found] if asked.thing else found

    def _corrected(self, words: list[str], view: StatusView, draft: Draft | None) -> list[Sense]:
        """What it has in place of what was ordered: another order, or the draft's with another value."""
        if draft is not None and (half := self._corrections.half(words, draft, view)) is not None:
            return [half]
        draft = None if draft is not None and draft.is_of_another else draft
        if self.language.other.fits(words):
            return [self._corrections.other(draft, view) if draft is not None else Sense("other")]
        completed = self._corrections.completed(words, draft, view) if draft is not None else None
        if completed is not None:
            return [completed]
        faults = list[Sense]()
        for instead in self._corrections.instead(words):
            corrected = self._corrections.corrected(instead, draft, view) if draft is not None else None
            if corrected is not None and corrected.kind == "order" and self.is_value(instead, view):
                return [corrected]
            inner = self._words(instead, view)
            if is_fault(inner):
                faults += inner
                continue
            if inner and (inner[0].kind == "order" or inner[0].name not in ("key", "value")):
                return [
                    each._replace(is_partial=each.is_partial or each.name == "answer", is_correction=draft is not None)
                    for each in inner
                ]
            if corrected is not None and corrected.kind == "order":
                return [corrected]
            if inner:
                return list(inner)
            faults += [corrected] if corrected is not None else []
        if draft is not None and draft.is_read_back and self.language.rejected.fits(words):
            return [self._corrections.other(draft, view)]
        return faults[:1]


def _is_own(words: list[str], view: StatusView, language: Language) -> bool:
    """Whether they name the mission that runs, and no other."""
    return [each.name for each in missions_named(words, view, language)] == [view.mission]


def _words_of(view: StatusView) -> Iterator[str]:
    for name in (*view.keys, *(each.name for each in view.missions)):
        yield from spoken(name).split()
    for mission in view.missions:
        yield from (word for key in mission.arguments for word in spoken(key.name).split())
    for offer in (offer for question in view.questions for offer in question.options):
        yield from spoken(offer.name).split()
        yield from offer.about.lower().split()
