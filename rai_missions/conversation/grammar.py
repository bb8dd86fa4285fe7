# SPDX-License-Identifier: Apache-2.0
"""The grammar: what a whole sentence may mean now. A sentence inside other talk means nothing.

Rule: the word to stop comes first, whatever else it could be; it needs no question, no state and no confirmation.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

from rai_missions.conversation.arguments import IN_WORDS, BadValue, read_arguments
from rai_missions.conversation.corrections import Corrections, Draft
from rai_missions.conversation.free_answers import TextOption, text_option
from rai_missions.conversation.language import Language, spoken
from rai_missions.conversation.names import key_named, missions_named, option_named
from rai_missions.conversation.senses import Sense
from rai_missions.conversation.start_phrases import StartPhrases
from rai_missions.conversation.state_answers import ALWAYS
from rai_missions.conversation.view import KeyView, MissionView, StatusView
from rai_missions.engine.decision import Offer, Question
from rai_missions.planning.text.normalise import LONGEST_WORD, is_near, once

__all__ = ("STOP", "Grammar")

STOP = Sense("order", "stop")
FAULT = (Sense("fault"),)
MOST_WORDS = 40
"""Words of the longest sentence that may be an order or a question of state."""
MOST_MENDED = 12
"""Words of the longest sentence in which misspelled words are mended, and of the longest correction inside one."""
MOST_PARTS = 6
"""Sentences of an utterance that are read; of more, only a stop at its beginning or end counts."""
DRAWN_OUT = re.compile(r"([^\W\d_])\1{2,}")
"""A letter that is written as long as it is drawn out: `stooop`; a digit counts as often as it is written."""
LONGEST_WARNING = 7
"""Words of the longest warning that has its danger in the same clause."""
POLITE, LONGEST_GREETING = ("hello", "thanks", "sorry"), 3
"""Questions that are none and may be ahead of any sentence, and the words of the longest."""
MOST_NESTED = 3
"""Questions and tags that are read inside one another."""
NEAREST = 5
"""Letters of the shortest word whose misspelling is mended."""
NONE: Mapping[str, str] = {}


class Grammar:
    """Reads sentences of one language.

    Args:
        language: Its data.
        phrases: Sentences of the robot's own that start a mission.
        questions: Questions of the robot's own → the key, or the field of one, whose value answers them.

    Raises:
        UsageError: A question is not closed, or names a part that does not exist.
    """

    def __init__(
        self, language: Language, phrases: StartPhrases | None = None, questions: Mapping[str, str] = NONE
    ) -> None:
        self.language = language
        self._phrases = phrases or StartPhrases((), {}, language)
        self._corrections = Corrections(language, self._phrases)
        self._own_questions = [(language.own_phrases([each]), path) for each, path in questions.items()]
        words = frozenset(word for each, _ in self._own_questions for word in each.words)
        self._things = frozenset(language.data["thing_pronouns"]) - frozenset(language.data["articles"])
        self._subjects = frozenset(language.data["pronouns"]) - frozenset(language.data["thing_pronouns"])
        self._persons = frozenset(language.data["pronouns"]) - language.articles
        self._vocabulary = language.vocabulary() | self._phrases.words | words

    def senses(self, text: str, view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        """What the sentence may mean in this moment; several where it is ambiguous, empty for other talk.

        Args:
            text: The sentence, as it was received.
            view: The run: which options, missions and keys there are.
            draft: The order that it may correct.
        """
        words = self.language.normaliser.words(text)
        whole = self.sentence(words, view, draft)
        is_open = _is_open(whole)
        corrected = self._corrected_within(words, view) if is_open else ()
        several = corrected or (self._several(words, view, whole) if is_open else ())
        parts = self.language.normaliser.parts(text) if is_open and not several else []
        edges = self._edges(text, view) if is_open else []
        if is_open and STOP not in several and self._is_cried(text, words, edges, view):
            return (STOP,)
        if len(parts) < 2:
            clauses = self.language.normaliser.remarks(text) if any(each.thing for each in whole) else []
            found = several or tuple(each for each in whole if not each.thing or self._is_within(each, clauses))
        else:
            found = self._in_parts(parts, view, draft) or tuple(each for each in whole if self._is_within(each, parts))
        return (self._pause_at_first(text, edges) if _is_fault(found or FAULT) else ()) or found

    def _is_within(self, sense: Sense, parts: Sequence[str]) -> bool:
        """Whether each text that a sense has is in one part: not the thing of `Find the cup. I am here`."""
        texts = [" ".join(self.language.normaliser.words(part)) for part in parts]
        return all(any(value in text for text in texts) for value in (*self.open_texts(sense), sense.thing))

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
        """Whether the words begin with a phrase of the robot's own that starts a mission."""
        return self._phrases.begin(words)

    def start_in(self, words: Sequence[str], view: StatusView) -> Sense | None:
        """The start that the words are by a phrase of the robot's own; None where there is none, or several."""
        found = list(self._phrases.senses(words, view.missions))
        return found[0] if len(found) == 1 and found[0].kind == "order" else None

    def knows(self, word: str) -> bool:
        """Whether a word is in a phrase of the language or of the robot."""
        return word in self._vocabulary

    def _pause_at_first(self, text: str, edges: Sequence[list[str]]) -> tuple[Sense, ...]:
        """A pause as the first clause of other talk: `wait, I am coming`; none where something is asked."""
        asking = self.language.data["asking"]
        clauses = [self.language.normaliser.words(each) for each in self.language.normaliser.clauses(text)]
        is_asked = text.rstrip().endswith("?") or any(words[:1] == [each] for each in asking for words in clauses)
        is_pause = any(map(self.language.orders["pause"].fits, edges[:1]))
        return (Sense("order", "pause"),) if is_pause and not is_asked else ()

    def _is_cried(self, text: str, words: list[str], edges: Sequence[list[str]], view: StatusView) -> bool:
        """Whether a stop is in it, or a warning: `stop, there is a child`; `stop stop you hit the cat`."""
        stop, first = self.language.orders["stop"], words[:1]
        is_again = words[1:2] == first and stop.fits(first)
        return is_again or any(map(stop.fits, edges)) or self._warns(text, edges, view)

    def _warns(self, text: str, edges: Sequence[list[str]], view: StatusView) -> bool:
        """Whether it is a warning, `watch out, the dog!`, and does not announce what the person wants to express."""
        normaliser, warnings = self.language.normaliser, self.language.warnings
        words = normaliser.bare(normaliser.words(text), _called(view.robot))
        if warnings["announcing"].fits(words):
            return False
        is_alone = len(normaliser.clauses(text)) == 1 and len(words) <= LONGEST_WARNING
        is_whole = is_alone and (
            warnings["whole"].fits(words) or (text.endswith("!") and warnings["cried"].fits(words))
        )
        return is_whole or any(map(warnings["alone"].fits, edges))

    def _edges(self, text: str, view: StatusView) -> list[list[str]]:
        """The first clause and the last one, the last one after no condition; and each sentence of a few."""
        normaliser = self.language.normaliser
        parts = normaliser.parts(text)
        whole = [normaliser.words(each) for each in parts[1:-1] if len(parts) <= MOST_PARTS]
        clauses = [normaliser.words(each) for each in normaliser.clauses(text)]
        is_on_condition = any(words[:1] == [each] for each in self.language.data["conditions"] for words in clauses[:1])
        edges = [*clauses[:1], *whole, *([] if is_on_condition else clauses[1:][-1:])]
        return [list(once(normaliser.bare(words, _called(view.robot)))) for words in edges]

    def _in_parts(self, parts: list[str], view: StatusView, draft: Draft | None) -> tuple[Sense, ...]:
        """What the sentences of an utterance mean together."""
        if len(parts) > MOST_PARTS:
            parts = [parts[0], "", parts[-1]]
        spoken_words = [self.language.normaliser.words(part) for part in parts]
        each = [self.sentence(words, view, draft) for words in spoken_words]
        if STOP in each[0] or STOP in each[-1]:
            return (STOP,)
        if corrected := self._corrected_at_once(each[0], spoken_words[1:], view):
            return corrected
        meant = [(senses, part) for senses, part in zip(each, parts, strict=True) if not _is_greeting(senses)]
        if not all(each) or not meant:
            return ()
        if len(meant) == 1:
            return meant[0][0]
        if not all(map(_is_order, each)) or any(self.language.correction.fits(words) for words in spoken_words[1:]):
            return ()
        rest = " ".join(part for _, part in meant[1:]).rstrip(".!?; ")
        return tuple(sense._replace(rest=rest) for sense in meant[0][0])

    def _corrected_within(self, words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """`Go to the kitchen, no wait, the study`: the order of both; empty where no correction follows an order."""
        marks = self.language.data["correcting"]
        for at in range(max(1, len(words) - MOST_MENDED), min(len(words), MOST_WORDS)):
            if words[at] in marks and at < len(words) - 1:
                openings = self.language.normaliser.openings(words[at:])
                then = next(filter(self.language.correction.fits, openings), None)
                first = self.sentence(words[:at], view) if then is not None else ()
                if then is not None and (found := self._corrected_at_once(first, [then], view)):
                    return found
        return ()

    def _corrected_at_once(
        self, first: tuple[Sense, ...], then: Sequence[list[str]], view: StatusView
    ) -> tuple[Sense, ...]:
        """`Go to the kitchen. No, the study!`: the one order of both; empty where they are none."""
        is_start = len(first) == 1 and (_is_order(first) or first[0].name == "start")
        if not is_start or len(then) != 1 or not self.language.correction.fits(then[0]):
            return ()
        found = self.sentence(then[0], view, Draft(first[0]))
        return found if _is_order(found) and all(each.name == first[0].name for each in found) else ()

    def _several(self, words: list[str], view: StatusView, whole: tuple[Sense, ...]) -> tuple[Sense, ...]:
        """The first of several orders in one sentence, with the rest of it: `go to the kitchen and find the cup`.

        Args:
            words: Of the sentence.
            view: The run.
            whole: What the sentence means as a whole.
        """
        if len(words) > MOST_WORDS:
            return ()
        for joint, at in _joints(words, self.language):
            left, right = words[:at], words[at + len(joint) :]
            first = self.sentence(left, view)
            second = self.sentence(right, view) if _is_order(first) else ()
            if STOP in second or (STOP in first and not whole):
                return (STOP,)
            if _is_order(first) and (_is_order(second) or _is_fault(whole) or self._speaks_of_it(right, whole)):
                return tuple(sense._replace(rest=" ".join(right)) for sense in first)
        return ()

    def _speaks_of_it(self, words: Sequence[str], senses: Sequence[Sense]) -> bool:
        """Whether the end of a value is a clause about it: `bring it to me` of `find the cup and bring it to me`."""
        texts = [text for sense in senses for text in self.open_texts(sense)]
        return not self._things.isdisjoint(words) and any(text.endswith(" ".join(words)) for text in texts)

    def sentence(self, words: list[str], view: StatusView, draft: Draft | None = None) -> tuple[Sense, ...]:
        """What these words may mean as one sentence; see `senses`."""
        normaliser = self.language.normaliser
        if not words or len(words) > MOST_WORDS or max(map(len, words)) > LONGEST_WORD:
            return ()
        bare = list(once(normaliser.bare(words, _called(view.robot))))
        found = next(filter(None, (self._words(each, view, draft) for each in self._forms(words, bare, view))), ())
        found = found or self._indirect(bare, view)
        mended = self._mended(bare, view, draft) if len(bare) <= MOST_MENDED and _is_fault(found or FAULT) else ()
        return mended if mended and not _is_fault(mended) else found or mended

    def _forms(self, words: list[str], bare: list[str], view: StatusView) -> Iterator[list[str]]:
        """What of a sentence may be what is meant, the likeliest first; what is not asked for is not worked out."""
        normaliser, called = self.language.normaliser, _called(view.robot)
        yield bare
        yield from self._polite(words, called)
        yield words
        yield self._unnamed(bare, view)
        yield normaliser.bare(words, called, is_tail_first=True)
        yield from self._ungreeted(words)
        yield from self._infinitive(words)
        yield from normaliser.openings(words, called)

    def _polite(self, words: list[str], called: Sequence[str]) -> Iterator[list[str]]:
        """The order inside a polite sentence, in the form of an order: `go home` of `would you mind going home`."""
        for opening in self.language.normaliser.openings(words, called):
            for slots in self.language.polite.match(opening):
                yield self.language.imperative(self.language.normaliser.bare(slots["order"].split(), called))

    def _infinitive(self, words: list[str]) -> Iterator[list[str]]:
        """The order that ends with an infinitive, in languages that have such: `in die Küche fahren`; no statement."""
        data, bare = self.language.data, self.language.normaliser.spoken(words)
        if data["infinitive_orders"] and bare[-1:] != bare[:1] and not self._persons & set(bare):
            yield self.language.imperative(bare)

    def _indirect(self, words: list[str], view: StatusView, depth: int = MOST_NESTED) -> tuple[Sense, ...]:
        """The question inside another or with a tag: `where are you` of `I wonder where you are, roughly`.

        Args:
            words: Of the sentence, without politeness.
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
        asked = list(self._questions(words, view))
        is_order = any(each.thing for each in asked) or (not asked and words[0] in self.language.data["asking"])
        return tuple(self._asked_or_ordered(asked, self._phrased(words, view))) if is_order else tuple(asked)

    def _direct(self, words: list[str]) -> Iterator[list[str]]:
        """The words of a clause with a verb ahead of the subject, `where are you`; then as they are."""
        subjects = self.language.data["subjects"]
        at = next((at for at, word in enumerate(words) if word in subjects), len(words))
        for verb in range(len(words) - 1, at, -1):
            yield [*words[:at], words[verb], *words[at:verb], *words[verb + 1 :]]
        for auxiliary in self.language.data["auxiliaries"] if at < len(words) else ():
            yield [*words[:at], auxiliary, *words[at:]]
        yield words

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

    def _mended(self, words: list[str], view: StatusView, draft: Draft | None) -> tuple[Sense, ...]:
        """As after small errors of a recogniser or a keyboard."""
        known = {*self._vocabulary, *_words_of(view)}
        misheard = self.language.data["mishearings"]
        short = [word if word in known else DRAWN_OUT.sub(r"\1", word) for word in words]
        mended = [misheard.get(word, word) if word not in known else word for word in short]
        if len(words) == 1:
            mended = [misheard.get(short[0], short[0])]
        mended = [self._nearest(word, known) for word in mended]
        bare = self.language.normaliser.bare(mended, _called(view.robot))
        return self._words(bare, view, draft) if mended != words else ()

    def _nearest(self, word: str, known: set[str]) -> str:
        if word in known or len(word) < NEAREST:
            return word
        near = [each for each in known if len(each) >= NEAREST - 1 and is_near(word, each)]
        near = [each for each in near if each[0] == word[0]] or near
        return near[0] if len(near) == 1 else word

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
        found += self._answers(words, view)
        found += [Sense("order", name) for name, each in language.orders.items() if each.fits(words)]
        found += [Sense("again")] if language.again.fits(words) else []
        found += self._phrased(words, view)
        found += self._starts(words, view)
        if _is_fault(found):  # `go to the kitchen instead` has no place of that name in it
            found = [each for each in self._corrected(words, view, draft) if each.kind == "order"] or found
        found = found or self._corrected(words, view, draft)
        if not found and text_option(view.questions) is None:
            found = list(self._phrases.valued(words, view.missions))
        if not found or words[0] in self.language.data["asking"]:
            found = self._asked_or_ordered(list(self._questions(words, view)), found)
        return tuple({sense.identity: sense for sense in found}.values())

    def _asked_or_ordered(self, asked: list[Sense], found: list[Sense]) -> list[Sense]:
        """A question alone, where nothing else fits; with the order to look for its thing: `where is my cup`."""
        if not found or _is_fault(found):
            return asked or found
        return [*(each for each in asked if each.thing), *found]

    # -- corrections ---------------------------------------------------------------------------------------------------

    def _corrected(self, words: list[str], view: StatusView, draft: Draft | None) -> list[Sense]:
        """What it has in place of what was ordered: another order, or the draft's with another value."""
        if self.language.other.fits(words):
            return [self._corrections.other(draft, view) if draft is not None else Sense("other")]
        completed = self._corrections.completed(words, draft, view) if draft is not None else None
        if completed is not None:
            return [completed]
        faults = list[Sense]()
        for instead in self._corrections.instead(words):
            inner = self._words(instead, view)
            if _is_fault(inner):
                faults += inner
                continue
            if inner and (inner[0].kind == "order" or inner[0].name not in ("key", "value")):
                return [
                    each._replace(is_partial=each.is_partial or each.name == "answer", is_correction=draft is not None)
                    for each in inner
                ]
            corrected = self._corrections.corrected(instead, draft, view) if draft is not None else None
            if corrected is not None and corrected.kind == "order":
                return [corrected]
            if inner:
                return list(inner)
            faults += [corrected] if corrected is not None else []
        if draft is not None and draft.is_read_back and self.language.rejected.fits(words):
            return [self._corrections.other(draft, view)]
        return faults[:1]

    # -- the open question ---------------------------------------------------------------------------------------------

    def _answers(self, words: list[str], view: StatusView) -> list[Sense]:
        """What it answers: the one open question that has such an option; of several the oldest, to be read back."""
        each = [self._answers_to(question, words) for question in view.questions]
        found = [sense for sense in each if sense is not None]
        whole = [sense for sense in found if not sense.is_partial]
        chosen = (whole or found)[:1]
        return chosen if len(whole or found) < 2 else [sense._replace(is_partial=True) for sense in chosen]

    def answers(self, text: str, questions: Sequence[Question]) -> bool:
        """Whether a sentence would answer one of these questions, as a whole or as a correction."""
        words = self.language.normaliser.bare(self.language.normaliser.words(text))
        ways = [words, *self._corrections.instead(words)] if words and len(words) <= MOST_MENDED else []
        found = (self._answers_to(question, each) for question in questions for each in ways)
        return any(sense is not None and not sense.is_partial for sense in found)

    def _answers_to(self, question: Question, words: list[str]) -> Sense | None:
        found, text = list[Sense](), text_option([question])
        if text is not None and text.means(words, self.language):
            return text.free(words)
        for slots in self.language.answer.match(words):
            named = option_named(slots["option"].split(), question.options, self.language)
            is_text = text is not None and named is not None and named.is_partial and named.offer is text.offer
            if named is not None and not is_text:
                found.append(self._answer(named.offer, is_partial=named.is_partial))
        whole = [sense for sense in found if not sense.is_partial]
        found = whole or found or self._with_values(words, question.options) or self._with_text(words, text)
        return found[0]._replace(question=question.number) if found else None

    def _answer(self, offer: Offer, *, is_partial: bool, words: Sequence[str] = ()) -> Sense:
        schema = offer.parameters or {}
        properties = schema.get("properties") or {}
        if not words and not schema.get("required"):
            return Sense("order", "answer", option=offer.name, is_partial=is_partial)
        kinds = {name: str(each.get("type")) for name, each in properties.items()}
        keys = [KeyView(name, kind if kind in IN_WORDS else "object") for name, kind in kinds.items()]  # type: ignore[arg-type]
        try:
            values = read_arguments(words, keys, self.language, owner=offer.name)
        except BadValue as error:
            return Sense("fault", "answer", fault=str(error))
        lacking = [spoken(name) for name in schema.get("required") or () if name not in values]
        if lacking:
            names = self.language.listed(lacking)
            return Sense(
                "fault", "answer", fault=self.language.text("needs_values", option=spoken(offer.name), names=names)
            )
        return Sense("order", "answer", option=offer.name, parameters=values, is_partial=is_partial)

    def _with_values(self, words: list[str], options: Sequence[Offer]) -> list[Sense]:
        taking = [offer for offer in options if offer.parameters]
        for slots in self.language.with_values.match(words) if taking else ():
            for way in self.language.answer.match(slots["option"].split()):
                named = option_named(way["option"].split(), taking, self.language)
                if named is not None:
                    return [self._answer(named.offer, is_partial=named.is_partial, words=slots["arguments"].split())]
        return []

    def _with_text(self, words: list[str], text: TextOption | None) -> list[Sense]:
        if text is None:
            return []
        found = (text.named(slots["option"].split()) for slots in self.language.answer.match(words))
        return [sense for sense in found if sense is not None][:1]

    def free_answer(self, text: str, view: StatusView) -> Sense | None:
        """A sentence without another meaning as an answer in free words, to be read back; None where none is asked."""
        option = text_option(view.questions)
        words = self.language.normaliser.bare(self.language.normaliser.words(text), _called(view.robot))
        is_short = 0 < len(words) <= MOST_WORDS
        return option.free(words) if option is not None and is_short and not text.rstrip().endswith("?") else None

    def _phrased(self, words: list[str], view: StatusView) -> list[Sense]:
        """A start by a phrase of the profile; where a text is asked for, it may be that as well."""
        found, option = list(self._phrases.senses(words, view.missions)), text_option(view.questions)
        return [*found, option.free(words)] if found and option is not None else found

    # -- start ---------------------------------------------------------------------------------------------------------

    def _starts(self, words: list[str], view: StatusView) -> list[Sense]:
        faults = list[Sense]()
        for slots in self.language.start.match(words):
            named = (slots.get("mission") or slots.get("called", "")).split()
            is_called = "called" in slots
            for sense in self._start(named, slots.get("arguments", "").split(), view, is_called=is_called):
                if sense.kind != "fault":
                    return [sense]
                faults.append(sense)
        return faults[:1]

    def _start(self, named: list[str], arguments: list[str], view: StatusView, *, is_called: bool) -> Iterator[Sense]:
        language = self.language
        offered = language.listed([spoken(each.name) for each in view.missions], "or")
        found = missions_named(named, view, language) if named else _own(view)
        if len(found) == 1:
            yield self._start_with(found[0], arguments)
        elif found or not named:
            text = "which_mission" if view.missions else "no_run"
            yield Sense("fault", "start", fault=language.text(text, missions=offered))
        elif is_called:
            yield Sense("fault", "start", fault=language.text("no_mission", given=" ".join(named), missions=offered))

    def _start_with(self, mission: MissionView, arguments: list[str]) -> Sense:
        try:
            values = read_arguments(
                arguments, mission.arguments, self.language, owner=mission.name, value=self._phrases.argument
            )
        except BadValue as error:
            lacks = (error.key,) if error.key else ()
            return Sense(
                "fault", "start", mission.name, error.others, fault=str(error), named=tuple(error.others), lacks=lacks
            )
        return Sense("order", "start", mission=mission.name, arguments=values, named=tuple(values))

    # -- questions of state --------------------------------------------------------------------------------------------

    def _key_done(self, named: list[str], done: list[str], view: StatusView) -> str:
        """The key that counts what was done: `alleys driven` for `how many alleys did you drive`."""
        for ending in ("", *self.language.data["participle_endings"]):
            if path := key_named([*named, *done[:-1], done[-1] + ending], view, self.language, strict=bool(ending)):
                return path
        return ""

    def _thing(self, name: str, thing: list[str], view: StatusView) -> Sense:
        """A question about a thing: of a key of that name, or of whatever fact has it."""
        path = key_named(thing, view, self.language, strict=True)
        return Sense("question", "key", key=path) if path else Sense("question", name, thing=" ".join(thing))

    def _questions(self, words: list[str], view: StatusView) -> Iterator[Sense]:
        for own, path in self._own_questions:
            if path.partition(".")[0] in view.keys and own.fits(words):
                yield Sense("question", "value", key=path)
                return
        for name, phrases in self.language.questions.items():
            for slots in phrases.match(words):
                if thing := slots.get("thing", "").split():
                    if thing[0] in self.language.data["pronouns"] or not self.language.without_articles(thing):
                        continue
                    yield self._thing(name, thing, view)
                    return
                if "key" not in slots:
                    yield Sense("question", name)
                    return
                named, done = slots["key"].split(), slots.get("done", "").split()
                path = self._key_done(named, done, view) if done else ""
                path = path or key_named(named, view, self.language, strict=len(named) == len(words))
                if path:
                    yield Sense("question", name, key=path)
                    return


def _is_greeting(senses: Sequence[Sense]) -> bool:
    return bool(senses) and all(sense.kind == "question" and sense.name in ALWAYS for sense in senses)


def _is_fault(senses: Sequence[Sense]) -> bool:
    """Whether it gives values that do not fit, and means nothing else."""
    return bool(senses) and all(sense.kind == "fault" for sense in senses)


def _is_open(senses: Sequence[Sense]) -> bool:
    """Whether the words may be several sentences: they mean nothing, or have words as values that may fit or not."""
    return not senses or _is_fault(senses) or all(sense.named or sense.thing for sense in senses)


def _is_order(senses: Sequence[Sense]) -> bool:
    """Whether it can be taken for nothing but orders."""
    return bool(senses) and all(sense.kind == "order" for sense in senses)


def _joints(words: Sequence[str], language: Language) -> Iterator[tuple[list[str], int]]:
    """Each place at which one order may end and the next begin, with the words that join them."""
    joints = sorted((each.split() for each in language.data["order_joints"]), key=len, reverse=True)
    for at in range(1, len(words) - 1):
        joint = next((each for each in joints if words[at : at + len(each)] == each), None)
        if joint is not None and at + len(joint) < len(words):
            yield joint, at


def _own(view: StatusView) -> list[MissionView]:
    """The missions that are meant where none is named: the run's own, or the only one."""
    own = view.mission_named(view.mission)
    return list(view.missions) if own is None else [own]


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


def _called(robot: str) -> tuple[str, ...]:
    """How people address a robot: `tractor1` as `tractor`, too, and `ROSbot XL, simulated` as `ROSbot`."""
    name = robot.partition(",")[0]
    first = name.split()[:1]
    return tuple(dict.fromkeys([robot, spoken(robot), name, *first, *(each.rstrip("0123456789") for each in first)]))
