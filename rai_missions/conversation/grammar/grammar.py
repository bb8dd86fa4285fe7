# SPDX-License-Identifier: Apache-2.0
"""The grammar: what a whole utterance may mean now. A sentence inside other talk means nothing.

Rule: a stop counts wherever it is cried, first, last or again; any other order only as what the whole means. A clause
that begins what is typed with the word to stop stops, unless what follows makes it another one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from rai_missions.conversation.grammar.corrections import Draft
from rai_missions.conversation.grammar.free_answers import text_option
from rai_missions.conversation.grammar.names import called, missions_named
from rai_missions.conversation.grammar.order_lists import OrderLists, is_greeting, is_order
from rai_missions.conversation.grammar.senses import FAULT, STOP, Sense, is_fault
from rai_missions.conversation.grammar.sentence_grammar import MOST_MENDED, MOST_WORDS, NONE, SentenceGrammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import Language
from rai_missions.conversation.view import StatusView
from rai_missions.engine.decision import Question
from rai_missions.planning.text.normalise import is_slip, once, unrepeated

__all__ = ("Grammar",)

MOST_PARTS = 6
"""Sentences of an utterance that are read; of more, only a stop at its beginning or end counts."""
LONGEST_WARNING = 7
"""Words of the longest warning that has its danger in the same clause, and of the longest stop with other words."""
LONGEST_ALARM = 10
"""Words of the longest clause that cries of harm."""
LONGEST_STOP = 3
"""Words of the longest stop that a clause may begin with, and have as many behind it as one that cries of harm."""
LEAST_REFUSALS = 3
"""How often a no is cried with which a person refuses what the robot does."""
NO_RUN = StatusView()
LETTERS = re.compile(r"[^\W\d_]+")
CRY = re.compile(r"^\W*\w+\W*")
"""The first word of a text, with the signs around it."""
DRAWN_OUT = re.compile(r"([^\W\d_]{1,9}?)\1{2,}")
"""What is written as often as it is cried, thrice at least: a letter of `stooop`, the word of `stopstopstop`."""
STUTTERED = re.compile(r"\b([^\W\d_]{1,3})(?:-+ ?\1)*-+ ?(?=\1)", re.IGNORECASE)
"""The beginning of a word that is written ahead of it: `st-` of `st-stop`."""


class Grammar:
    """Reads utterances of one language, of a sentence or a few.

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
        self.sentence = SentenceGrammar(language, phrases, questions)
        """The grammar of each of its sentences."""
        self._lists = OrderLists(self.sentence)
        self._no_stop_behind = frozenset(
            word for name in ("turning", "ahead_of_a_stop", "quoting") for word in language.data[name]
        )

    def is_plain_stop(self, text: str) -> bool:
        """Whether it is a phrase of the language that orders to stop, as it is: some microseconds, as a flood needs."""
        return STOP in self.sentence.senses(self.language.normaliser.words(text), NO_RUN)

    def senses(
        self,
        text: str,
        view: StatusView,
        draft: Draft | None = None,
        *,
        is_typed: bool = True,
        earlier: Sequence[Sequence[str]] = (),
    ) -> tuple[Sense, ...]:
        """What the sentence may mean in this moment; several where it is ambiguous, empty for other talk.

        Args:
            text: The sentence, as it was received.
            view: The run: which options, missions and keys there are.
            draft: The order that it may correct.
            is_typed: Whether it is for the robot in any case; what is spoken may be for others.
            earlier: What was uttered before it, the last at the end, for `it` and `there`.
        """
        text = self.unrepeated(text)
        words = self.language.normaliser.words(text)
        if self.language.warnings["admiring"].fits(words):
            text = CRY.sub("", text)  # that `whoa` stops nothing; what is behind it may
            words = self.language.normaliser.words(text)
        whole = self.sentence.senses(words, view, draft)
        if earlier and all(each.kind in ("order", "fault") and each.name == "start" for each in whole):
            whole = self.sentence.referring(words, view, earlier) or whole
        if (
            (draft is None or draft.is_of_another)
            and any(each.name == "answer" for each in whole)
            and self._refuses_a_kind(text)
        ):
            whole = tuple(each for each in whole if each.name != "answer")
        is_open = _is_open(whole)
        corrected = (self._corrected_within(words, view) or self._completed_within(text, view)) if is_open else ()
        is_list = is_open or all(sense.kind == "order" and sense.name in self.language.orders for sense in whole)
        several = corrected or (self._lists.senses(text, view, whole, earlier) if is_list else ())
        if several and not is_open:
            return several
        parts = self.language.normaliser.parts(text) if is_open and not several else []
        edges = self._edges(text, view, is_typed=is_typed) if is_open else []
        is_stop = any(sense.is_stop for sense in several)
        is_urgent = is_open and not is_stop
        if is_urgent and (
            self._is_cried(text, words, edges, view, is_typed=is_typed) or self._is_stop_passed_on(words, view)
        ):
            return (STOP,)
        if is_urgent and is_typed and self._is_alarmed(text, words, edges, view):
            return (STOP,)
        if len(parts) < 2:
            clauses = self.language.normaliser.remarks(text) if any(each.thing for each in whole) else []
            found = several or tuple(each for each in whole if not each.thing or self._is_within(each, clauses))
        else:
            found = self._in_parts(parts, view, draft) or tuple(each for each in whole if self._is_within(each, parts))
        return (self._pause_at_first(text, edges) if is_fault(found or FAULT) else ()) or found

    def withdrawn(
        self, text: str, requests: Sequence[Sense], view: StatusView, *, is_recent: bool = False
    ) -> int | None:
        """The place of the request that a sentence wants no more, `forget the lobby`, `forget the last one`; or None.

        Args:
            text: The sentence, as it was received.
            requests: Those that wait, the oldest first.
            view: The run.
            is_recent: Whether the speaker has just ordered the last one, so that it may be `that`.
        """
        openings = self.language.normaliser.openings(self.language.normaliser.words(text)) if requests else ()
        for slots in (slots for words in openings for slots in self.language.forgetting.match(words)):
            thing = slots["thing"].split()
            if is_recent and all(word in self.language.data["pronouns"] for word in thing):
                return len(requests) - 1
            if (place := self.sentence.place_in(thing)) is not None and -len(requests) <= place < len(requests):
                return place % len(requests)
            for at in range(len(requests) - 1, -1, -1):
                if self.sentence.names(thing, requests[at], view):
                    return at
        return None

    def answers(self, text: str, questions: Sequence[Question]) -> bool:
        """Whether a sentence would answer one of these questions, as a whole or as a correction."""
        words = self.language.normaliser.words(self.unrepeated(text))
        return self.sentence.answers(self.language.normaliser.bare(words), questions)

    def free_answer(self, text: str, view: StatusView) -> Sense | None:
        """A sentence without another meaning as an answer in free words, to be read back; None where none is asked."""
        option = text_option(view.questions)
        words = self.language.normaliser.bare(self.language.normaliser.words(text), called(view.robot))
        is_short = 0 < len(words) <= MOST_WORDS
        return option.free(words) if option is not None and is_short and not text.rstrip().endswith("?") else None

    def without_reasons(self, text: str, view: StatusView) -> tuple[Sense, ...]:
        """What a sentence orders without its reasons, to be read back: `wait a minute while the kettle boils`.

        Empty where there is none, and where a reason may have an order in it.
        """
        reasons = [self.language.normaliser.words(each) for each in self.language.reasons.findall(text)]
        ends = (words[at:] for words in reasons for at in range(len(words)))
        if not reasons or self.language.may_quote(text) or any(map(self.sentence.begins_an_order, ends)):
            return ()
        senses = self.senses(self.language.reasons.sub("", text), view)
        return tuple(each._replace(is_partial=True) for each in senses) if is_order(senses) else ()

    def question_by_sense(self, text: str, view: StatusView) -> Sense | None:
        """What a sentence without another meaning asks in words of its own; None where it asks for no state."""
        return self.sentence.questions.by_sense(self.unrepeated(text), view)

    def answers_by_sense(self, text: str, view: StatusView) -> tuple[Sense, ...]:
        """What a sentence without another meaning answers in words of its own, to be read back."""
        return tuple(self.sentence.options.by_sense(self.unrepeated(text), view))

    def unrepeated(self, text: str) -> str:
        """A sentence that repeats words, letters or beginnings, with them once: `go!` of `go, g-go, gooo!`."""
        text = LETTERS.sub(lambda word: self._undrawn(word[0]), STUTTERED.sub("", text))
        words = self.language.normaliser.words(text)
        once_only, sign = unrepeated(words), text.rstrip()[-1:]
        return text if once_only == words else " ".join(once_only) + ("" if sign.isalnum() else sign)

    def _refuses_a_kind(self, text: str) -> bool:
        """Whether it begins with a negation of a kind of things, and no sign between: `no horn`, but not `no, horn`."""
        first, *rest = self.language.normaliser.words(next(iter(self.language.normaliser.clauses(text)), "")) or [""]
        return first in self.language.negations and bool(rest) and rest[0] not in self.language.articles

    def refuses(self, text: str) -> bool:
        """Whether it is a no that is cried again and again: `no no no no`."""
        words = self.language.normaliser.words(self.unrepeated(text))
        return len(words) == 1 and self.language.no.fits(words) and text.lower().count(words[0]) >= LEAST_REFUSALS

    def _undrawn(self, word: str) -> str:
        """The known word that is drawn out, `stop` of `STOPPP` and `soon` of `sooooon`; any other as it is."""
        if self.sentence.knows(word.lower()) or DRAWN_OUT.search(word.lower()) is None:
            return word
        ways = (DRAWN_OUT.sub(letters, word.lower()) for letters in (r"\1", r"\1\1"))
        misheard = self.language.data["mishearings"]
        return next((each for each in ways if self.sentence.knows(each) or each in misheard), word)

    def _is_within(self, sense: Sense, parts: Sequence[str]) -> bool:
        """Whether each text that a sense has is in one part: not the thing of `Find the cup. I am here`."""
        texts = [" ".join(self.language.normaliser.words(part)) for part in parts]
        return all(any(value in text for text in texts) for value in (*self.sentence.open_texts(sense), sense.thing))

    def _pause_at_first(self, text: str, edges: Sequence[list[str]]) -> tuple[Sense, ...]:
        """A pause as the first clause of other talk: `wait, I am coming`; none where something is asked."""
        asking = self.language.data["asking"]
        clauses = [self.language.normaliser.words(each) for each in self.language.normaliser.clauses(text)]
        is_asked = text.rstrip().endswith("?") or any(words[:1] == [each] for each in asking for words in clauses)
        is_pause = any(map(self.language.orders["pause"].fits, edges[:1]))
        return (Sense("order", "pause"),) if is_pause and not is_asked else ()

    def _is_cried(
        self, text: str, words: list[str], edges: Sequence[list[str]], view: StatusView, *, is_typed: bool
    ) -> bool:
        """Whether a stop is in it, or a warning: `stop, there is a child`; `stop stop you hit the cat`."""
        stop, first = self.language.orders["stop"], words[:1]
        is_again = words[1:2] == first and stop.fits(first)
        addressed = [each[1:] for each in edges if each[:1] and each[0] in self.language.data["addressed"]]
        heads = [self._ahead_of_reason(each) for each in edges if not text.rstrip().endswith("?")]
        return (
            is_again
            or any(map(stop.fits, (*edges, *heads, *addressed)))
            or self._warns(text, edges, view, is_typed=is_typed)
        )

    def _is_alarmed(self, text: str, words: list[str], edges: Sequence[list[str]], view: StatusView) -> bool:
        """Whether what is typed cries of harm, has a short clause that begins with the word to stop, or turns to it."""
        language = self.language
        if language.may_quote(text) or text.rstrip().endswith("?"):
            return False
        short = [each for each in (words, *edges) if len(each) <= LONGEST_ALARM]
        no_harm = language.warnings["no_harm"].fits
        is_harm = any(language.warnings["typed"].fits(each) and not no_harm(each) for each in short)
        begins = (self._begins_with_stop(self._ahead_of_reason(each), view) for each in edges)
        return is_harm or any(self._turns_to_stop(each, view) for each in edges) or any(begins)

    def _turns_to_stop(self, words: list[str], view: StatusView) -> bool:
        """Whether a clause comes to the order to stop: `there is a kid so stop`, `wrong way stop`."""
        data = self.language.data
        if self.language.conditions.begin(words):
            return False
        turns = [at + 1 for at, word in enumerate(words) if word in data["turning"]]
        if len(words) <= LONGEST_WARNING:
            stops = (at for at in range(1, len(words)) if words[at] in data["stops"])
            turns += [at for at in stops if words[at - 1] not in self._no_stop_behind]
        behind = (self._slipped(words[at:]) for at in turns[-2:])
        typed = (each for each in behind if each and (each[0] in data["stops"] or each[0] not in data["mishearings"]))
        return any(STOP in self.sentence.senses(each, view) for each in typed)  # `but stopped` is misheard, not typed

    def _begins_with_stop(self, words: list[str], view: StatusView) -> bool:
        """Whether a short clause begins with the word to stop and is no other: `stop you fool`."""
        language, stopping = self.language, self.language.warnings["stopping"]
        words = self._slipped(words)
        size = next((size for size in range(LONGEST_STOP, 1, -1) if language.orders["stop"].fits(words[:size])), 0)
        if not words or len(words) > (LONGEST_ALARM if size else LONGEST_WARNING):
            return False
        is_reported = not set(words).isdisjoint(language.data["quoting"])
        is_of_another = any(each.name != view.mission for each in missions_named(words[1:], view, language))
        is_on_condition = any(language.conditions.begin(words[at:]) for at in range(1, len(words)))
        is_stop = stopping.fits(words) or language.orders["stop"].fits(words)
        behind = [*words[:1], *words[size:]] if len(words) > LONGEST_WARNING else words  # `stop now the cat is there`
        is_no_stop = language.warnings["no_stop"].fits(behind) and not self.sentence.names_own_verb(words[1:2])
        is_otherwise = is_reported or is_on_condition or is_of_another or is_no_stop
        return is_stop and not is_otherwise

    def _slipped(self, words: list[str]) -> list[str]:
        """The words, the first one as the stop that a slip of the keyboard made it of."""
        if not words or self.sentence.knows(words[0]):
            return words
        meant = (each for each in sorted(self.language.warnings["stopping"].words) if is_slip(words[0], each))
        return [next(meant, words[0]), *words[1:]]

    def _is_stop_passed_on(self, words: list[str], view: StatusView) -> bool:
        """Whether another person wants a stop, `Mila wants you to stop`; not where none does, or in a question."""
        language = self.language
        is_asked = not set(words[:1]).isdisjoint(language.data["asking"])
        if is_asked or not language.negations.isdisjoint(words):
            return False
        relayed = language.relayed.match(language.normaliser.bare(words))
        passed_on = (language.imperative(slots["order"].split()) for slots in relayed)
        return any(STOP in self.sentence.senses(order, view) for order in passed_on)

    def _warns(self, text: str, edges: Sequence[list[str]], view: StatusView, *, is_typed: bool) -> bool:
        """Whether it is a warning, `watch out, the dog!`, and does not announce what the person wants to express.

        What is typed without a cry, and names a listed thing to look out for, warns of nothing.
        """
        normaliser, warnings = self.language.normaliser, self.language.warnings
        words = normaliser.bare(normaliser.words(text), called(view.robot))
        is_named = is_typed and "!" not in text and any(True for _ in self.sentence.places_in([words]))
        is_search = is_named and warnings["searching"].fits(words)
        if is_search or warnings["announcing"].fits(words):
            return False
        is_alone = len(normaliser.clauses(text)) == 1 and len(words) <= LONGEST_WARNING
        is_whole = is_alone and (
            warnings["whole"].fits(words) or (text.endswith("!") and warnings["cried"].fits(words))
        )
        return is_whole or any(map(warnings["alone"].fits, edges))

    def _edges(self, text: str, view: StatusView, *, is_typed: bool) -> list[list[str]]:
        """The first clause and the last one, the last one after no condition; and each sentence of a few.

        What is typed may name others: `she was like that, stop`; in speech, what is behind them may be their words.
        """
        normaliser = self.language.normaliser
        parts = normaliser.parts(text)
        whole = [normaliser.words(each) for each in parts[1:-1] if len(parts) <= MOST_PARTS]
        split = normaliser.clauses(text)
        if is_typed and len(split) == 1:
            split = normaliser.remarks(text)
        clauses = [normaliser.words(each) for each in split]
        is_on_condition = any(map(self.language.conditions.begin, clauses[:1]))
        edges = [*clauses[:1], *whole, *([] if is_on_condition else clauses[1:][-1:])]
        return [list(once(normaliser.bare(words, called(view.robot)))) for words in edges]

    def _ahead_of_reason(self, words: list[str]) -> list[str]:
        """The words ahead of a reason for them that begins without a comma: `stop now` of `stop now or you crash`."""
        begins = self.language.reason_joints.begin
        return words[: next((at for at in range(1, len(words)) if begins(words[at:])), len(words))]

    def _in_parts(self, parts: list[str], view: StatusView, draft: Draft | None) -> tuple[Sense, ...]:
        """What the sentences of an utterance mean together."""
        if len(parts) > MOST_PARTS:
            parts = [parts[0], "", parts[-1]]
        spoken_words = [self.language.normaliser.words(part) for part in parts]
        each = [self.sentence.part(words, view, draft) for words in spoken_words]
        if STOP in each[0] or STOP in each[-1]:
            return (STOP,)
        if corrected := self._corrected_at_once(each[0], spoken_words[1:], view):
            return corrected
        meant = [senses for senses in each if not is_greeting(senses)]
        if not all(each) or not meant:
            return ()
        return meant[0] if len(meant) == 1 else ()

    def _corrected_within(self, words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """`Go to the kitchen, no wait, the study`: the order of both; empty where no correction follows an order."""
        marks = self.language.data["correcting"]
        for at in range(max(1, len(words) - MOST_MENDED), min(len(words), MOST_WORDS)):
            if words[at] in marks and at < len(words) - 1:
                openings = self.language.normaliser.openings(words[at:])
                then = next(filter(self.language.correction.fits, openings), None)
                first = self.sentence.senses(words[:at], view) if then is not None else ()
                if then is not None and (found := self._corrected_at_once(first, [then], view)):
                    return found
        return ()

    def _completed_within(self, text: str, view: StatusView) -> tuple[Sense, ...]:
        """`Bring it to table one, the tea`: the order of both clauses, where the last has what the first lacks."""
        clauses = [self.language.normaliser.words(each) for each in self.language.normaliser.clauses(text)]
        if len(clauses) != 2 or self.language.conditions.begin(clauses[0]):
            return ()
        first = self.sentence.senses(clauses[0], view)
        is_open = is_order(first) or (is_fault(first) and self.sentence.has_pronoun(clauses[0]))
        if len(first) != 1 or first[0].name != "start" or not is_open:
            return ()
        found = self.sentence.half(clauses[1], Draft(first[0], is_asked_for=True), view)
        is_kept = found is not None and first[0].arguments.items() <= found.arguments.items()
        return (found,) if found is not None and is_kept and found.kind == "order" else ()

    def _corrected_at_once(
        self, first: tuple[Sense, ...], then: Sequence[list[str]], view: StatusView
    ) -> tuple[Sense, ...]:
        """`Go to the kitchen. No, the study!`: the one order of both; empty where they are none."""
        is_start = len(first) == 1 and (is_order(first) or first[0].name == "start")
        if not is_start or len(then) != 1 or not self.language.correction.fits(then[0]):
            return ()
        found = self.sentence.senses(then[0], view, Draft(first[0]))
        if not is_order(found):
            return ()
        is_plain = first[0].name in self.language.orders and found[0].name in self.language.orders
        is_refused = self.language.no.fits(then[0][:1])  # `cancel? no, continue`
        if is_plain and not is_refused:  # `cancel, I mean pause`
            return tuple(each._replace(is_partial=True) for each in found)
        return found if all(each.name == first[0].name for each in found) else ()


def _is_open(senses: Sequence[Sense]) -> bool:
    """Whether the words may be several sentences: they mean nothing, or have words as values that may fit or not."""
    return not senses or is_fault(senses) or all(sense.named or sense.thing for sense in senses)
