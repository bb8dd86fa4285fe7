# SPDX-License-Identifier: Apache-2.0
"""Lists: several orders or questions in one sentence, `go to the kitchen, then find the cup`.

Rule: a list is read where each of its parts means something by itself, or with what the part before it has; a text of
other words, and a value that may have the joint in it, stay whole.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import accumulate, islice, product
from typing import NamedTuple

from rai_missions.conversation.grammar.senses import STOP, Sense, is_fault, joined
from rai_missions.conversation.grammar.sentence_grammar import MOST_WORDS, SentenceGrammar
from rai_missions.conversation.grammar.state_questions import ALWAYS
from rai_missions.conversation.language.language import QUOTING
from rai_missions.conversation.view import StatusView

__all__ = ("OrderLists", "is_greeting", "is_order")

MOST_CUTS = 10
"""Places of a sentence at which one of its parts may end; with more it is other talk."""
MOST_SHARED = 4
"""Words of one part that the next may lack: `go to` of `go to the kitchen, then the study`."""
MOST_LATER = 12
"""Words of the longest order that is named ahead of the one that comes before it."""
MOST_WAYS = 16
"""Ways in which ambiguous parts may be meant together."""


class Cut(NamedTuple):
    """A place at which one part of a sentence may end and the next begin."""

    end: int
    """Words ahead of it."""
    begin: int
    """Words up to the next part."""
    is_marked: bool = True
    """A sign or a word is there; else an order begins there without one."""
    is_reversing: bool = False
    """What is behind it comes first: `go home, but first find the cup`."""


Part = tuple[Sense, ...]
"""What a part of a sentence may mean."""


class OrderLists:
    """Reads lists.

    Args:
        grammar: Reads their parts.
    """

    def __init__(self, grammar: SentenceGrammar) -> None:
        self._grammar, self._language = grammar, grammar.language
        data = self._language.data
        self._correcting = frozenset(data["correcting"])
        self._things = frozenset(data["thing_pronouns"]) - self._language.articles
        self._no_parts = [*self._language.joints, *([word] for word in data["going"])]
        """What joins two parts or begins one, `go` of `go find the cup`, and is none by itself."""

    def senses(
        self, text: str, view: StatusView, whole: Sequence[Sense], earlier: Sequence[Sequence[str]] = ()
    ) -> tuple[Sense, ...]:
        """The list that a sentence is, several where its parts are ambiguous; with the rest of it that is not read.

        Args:
            text: The sentence, as it was received.
            view: The run.
            whole: What it means as a whole.
            earlier: What was uttered before it, the last at the end.
        """
        clauses = [self._language.normaliser.words(each) for each in self._language.normaliser.clauses(text)]
        words = [word for clause in clauses for word in clause]
        cuts = list(self._cuts(clauses))
        if len(words) > MOST_WORDS or len(cuts) > MOST_CUTS or QUOTING in text:
            return ()
        if opening := next((each for each in self._language.before_openings if _begins(words, each)), []):
            return self._first_named_last(words[len(opening) :], view)
        if is_order(whole) and not any(map(self._grammar.open_texts, whole)):
            cuts = [each for each in cuts if each.is_marked or 1 < each.end < len(words) - 1]
        words, cuts = self._on_the_way(words, cuts)
        sizes = [len(self._language.normaliser.words(each)) for each in self._language.normaliser.parts(text)]
        reading = _Reading(
            self, words, cuts, view, ends=tuple(accumulate(sizes)), is_whole=is_order(whole), earlier=earlier
        )
        end = next((each.end for each in cuts if each.begin == len(words)), len(words))
        if len(parts := reading.parts(end)) > 1 or (parts and end < len(words)):
            return _together(parts)
        for cut in (each for each in reversed(cuts) if each.is_marked):
            first, rest = reading.parts(cut.end), words[cut.begin :]
            if any(STOP in part for part in first) and (not whole or is_fault(whole)):
                return (STOP,)
            if all(map(is_order, first)) and first and (is_fault(whole) or self._speaks_of_it(rest, whole)):
                read = (sense._replace(rest=" ".join(rest)) for sense in _together(first))
                return tuple(self._grammar.located(sense, words[: cut.end], rest, view) for sense in read)
        return ()

    def _on_the_way(self, words: list[str], cuts: list[Cut]) -> tuple[list[str], list[Cut]]:
        """The words without `on your way` at their end, which puts the last part before the one ahead of it."""
        end = next((at for at in range(1, len(words)) if self._language.on_the_way.fits(words[at:])), len(words))
        last = next((each for each in reversed(cuts) if each.is_marked and each.begin < end), None)
        if last is None or end == len(words):
            return words, cuts
        return words[:end], [each._replace(is_reversing=True) if each == last else each for each in cuts]

    def _first_named_last(self, words: Sequence[str], view: StatusView) -> tuple[Sense, ...]:
        """The list of `before you go to the kitchen find the cup`, of the words behind its opening."""
        for at in range(1, min(len(words), MOST_LATER)):
            later = self.part(words[:at], view)
            first = self.part(words[at:], view) if is_order(later) and STOP not in later else ()
            if is_order(first):
                return _together([first, later])
        return ()

    def _cuts(self, clauses: Sequence[Sequence[str]]) -> Iterator[Cut]:
        """Where a clause begins, where words join what is around them, and where an order of some words begins."""
        at, joints = 0, self._language.joints_by_word
        for clause in clauses:
            begun, place = at, 0
            while place < len(clause):
                left = clause[place:]
                joint = next((each for each in joints.get(left[0], ()) if _begins(left, each)), [])
                is_reversing = joint in self._language.reversing_joints
                is_marked = bool(joint) or place == 0
                if at + place and (is_marked or (len(left) > 1 and self._grammar.begins_an_order(left))):
                    yield Cut(at + place, at + place + len(joint), is_marked, is_reversing)
                place += len(joint) or 1
            at = begun + len(clause)

    def part(self, words: Sequence[str], view: StatusView) -> Part:
        """What a part of a sentence means: orders or questions; empty for all else, and for a joint or `please go`.

        Args:
            words: The words of the part.
            view: The run.
        """
        if list(words) in self._no_parts or self._language.normaliser.bare(list(words)) in self._no_parts:
            return ()
        for form in (list(words), self._language.imperative(words)):
            found = self._grammar.part(form, view)
            if found and all(sense.kind in ("order", "question") for sense in found):
                return found
        return ()

    def referring(self, words: Sequence[str], view: StatusView, before: Sequence[Sequence[str]]) -> Part:
        """What a part orders of what was named before it: `wait there`, `count it`; empty for nothing.

        Args:
            words: The words of the part.
            view: The run.
            before: What is ahead of it, the last at the end.
        """
        return self._grammar.referring(list(words), view, before)

    def shortened(self, words: Sequence[str], view: StatusView, before: Sequence[str], *, is_whole: bool) -> Part:
        """What a part means with words of an earlier one, `the study` behind `go to the kitchen`; empty for nothing.

        Args:
            words: The words of the part.
            view: The run.
            before: The words of the last part that is whole.
            is_whole: The sentence is an order as a whole: a value is one of it rather than of another order.
        """
        shared = self._language.normaliser.bare(list(before)) if words[0] not in self._correcting else []
        is_named = words[0] in self._language.articles and not self.is_value(words, view)
        is_thing = is_named and not self._grammar.begins_an_order(words)
        for size in range(1, min(MOST_SHARED, len(shared) - 1) + 1):
            sense = self._grammar.start_in([*shared[:size], *words], view)
            if sense is not None and (is_thing if self._grammar.open_texts(sense) else not is_whole):
                return (sense,)
        return ()

    def is_correction(self, words: Sequence[str]) -> bool:
        """Whether a part replaces what is ahead of it: `no, the study`."""
        return words[0] in self._correcting and self._language.correction.fits(words)

    def is_value(self, words: Sequence[str], view: StatusView) -> bool:
        """Whether a part is a value alone, `the study`, which needs what is ordered of it from an earlier part."""
        return self._grammar.is_value(words, view)

    def _speaks_of_it(self, words: Sequence[str], senses: Sequence[Sense]) -> bool:
        """Whether the end of a value is a clause about it: `bring it to me` of `find the cup and bring it to me`."""
        texts = [text for sense in senses for text in self._grammar.open_texts(sense)]
        return not self._things.isdisjoint(words) and any(text.endswith(" ".join(words)) for text in texts)


class _Reading:
    """The parts of one sentence; each run of its words is read once.

    Args:
        lists: Reads a part.
        words: The sentence's.
        cuts: Where a part may end.
        view: The run.
        ends: The places at which a sentence of an utterance ends: no part goes beyond one.
        is_whole: The sentence is an order as a whole as well.
        earlier: What was uttered before the sentence, the last at the end.
    """

    def __init__(
        self,
        lists: OrderLists,
        words: Sequence[str],
        cuts: Sequence[Cut],
        view: StatusView,
        *,
        ends: Sequence[int],
        is_whole: bool,
        earlier: Sequence[Sequence[str]],
    ) -> None:
        self._earlier = earlier
        self._lists, self._words, self._cuts, self._view, self._is_whole = lists, words, cuts, view, is_whole
        self._ends = ends
        self._known = dict[tuple[int, ...], Part]()

    def parts(self, end: int) -> list[Part]:
        """What each part of the words up to a place means, in its turn; empty where one of them means nothing."""
        return self._from(0, (0, 0), end)

    def _from(self, begin: int, whole: tuple[int, int], end: int) -> list[Part]:
        """The parts of the words from one place to another.

        Args:
            begin: The first place.
            whole: The place of the last part that means something by itself.
            end: The other place.
        """
        for then in self._cuts:
            if begin < then.end and then.begin < end and (first := self._part(begin, then.end, whole)):
                is_whole = bool(self._part(begin, then.end)) and not self._is_value(begin, then.end)
                if rest := self._from(then.begin, (begin, then.end) if is_whole else whole, end):
                    return [*rest, first] if then.is_reversing else [first, *rest]
        last = self._part(begin, end, whole)
        return [last] if last else []

    def _part(self, begin: int, end: int, whole: tuple[int, int] = (0, 0)) -> Part:
        place = (begin, end, *whole)
        if begin >= end or any(begin < each < end for each in self._ends):
            return ()
        if place not in self._known:
            words, earlier = self._words[begin:end], self._words[slice(*whole)]
            before = [*self._earlier, *([self._words[:begin]] if begin else [])]
            if referring := self._lists.referring(words, self._view, before):
                self._known[place] = referring
            elif not earlier:
                self._known[place] = self._lists.part(words, self._view)
            elif self._lists.is_correction(words):
                self._known[place] = ()
            else:
                alone = self._part(begin, end)
                found = () if alone and not self._is_value(begin, end) else self._shortened(words, earlier)
                self._known[place] = found or alone
        return self._known[place]

    def _is_value(self, begin: int, end: int) -> bool:
        return self._lists.is_value(self._words[begin:end], self._view)

    def _shortened(self, words: Sequence[str], earlier: Sequence[str]) -> Part:
        return self._lists.shortened(words, self._view, earlier, is_whole=self._is_whole)


def is_order(senses: Sequence[Sense]) -> bool:
    """Whether it can be taken for nothing but orders."""
    return bool(senses) and all(sense.kind == "order" for sense in senses)


def is_greeting(senses: Sequence[Sense]) -> bool:
    """Whether it is polite, and asks nothing."""
    return bool(senses) and all(sense.kind == "question" and sense.name in ALWAYS for sense in senses)


def _together(parts: Sequence[Part]) -> tuple[Sense, ...]:
    """What parts mean together, in each way in which they may be meant; what is polite is left out."""
    meant = [part for part in parts if not is_greeting(part)] or parts[:1]
    ways = (way for each in islice(product(*meant), MOST_WAYS) for way in _by_answer(each))
    found = (joined(way) for way in ways)
    return tuple({sense.identity: sense for sense in found}.values())


def _by_answer(parts: Part) -> Iterator[Part]:
    """The parts with one answer to each question: who names two options, `the first? the second`, is asked which.

    A stop among them counts, and none of these answers does.
    """
    options = {(part.question, part.option) for part in parts if part.option}
    asked = Counter(question for question, _ in options)
    rivals = sorted(each for each in options if asked[each[0]] > 1)
    others = tuple(part for part in parts if (part.question, part.option) not in rivals)
    if not rivals or STOP in parts:
        yield others
        return
    for rival in rivals:
        kept = (part for part in parts if part in others or (part.question, part.option) == rival)
        yield tuple(part._replace(is_partial=True) if part.option else part for part in kept)


def _begins(words: Sequence[str], joint: Sequence[str]) -> bool:
    return list(words[: len(joint)]) == list(joint)
