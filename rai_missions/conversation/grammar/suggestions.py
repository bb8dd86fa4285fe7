# SPDX-License-Identifier: Apache-2.0
"""Suggestions: the order or question in one clause of a sentence that means nothing as a whole.

"I am hungry, go to the kitchen" has an order in it, and "my cup is gone, find it" one whose thing was named before. A
clause without a comma, "that is it for today go back to your dock", has one where it addresses the robot.
Rule: an order that is suggested is read back, whatever it is; other talk never becomes an order by it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rai_missions.conversation.grammar.senses import FAULT, STOP, Sense, is_fault, joined
from rai_missions.conversation.grammar.sentence_grammar import SentenceGrammar
from rai_missions.conversation.grammar.state_questions import ALWAYS
from rai_missions.conversation.view import StatusView

__all__ = ("Suggestions",)

MOST_CLAUSES = 8
"""Clauses of the longest sentence in which one is looked for."""
MOST_WORDS = 40
"""Words of the longest clause in which one is looked for: each may begin one, with each place before it."""
LONGEST_ORDER = 8
"""Words of the longest order of the language that is looked for within a clause."""
LONGEST_THING = 3
"""Words of the longest name of a thing in whose place a pronoun may be."""
LONGEST_SUBJECT = 4
"""Words of the longest subject of a fact."""
REPLIES = frozenset({"yes", "no", "quiet", "withdraw", "again", "other"})
"""What a clause may mean with which the person reacts to the robot, so that the others do, too."""


class Suggestions:
    """Finds the order or question that other talk may have in it.

    Args:
        grammar: Reads the clauses.
    """

    def __init__(self, grammar: SentenceGrammar) -> None:
        self._grammar, self._language = grammar, grammar.language
        data = self._language.data
        self._pronouns = frozenset(data["thing_pronouns"])
        sequels = {" ".join(joint) for joint in self._language.joints} - {self._language.text("and")}
        self._articles, self._ends = self._language.articles, sequels.union(data["thing_ends"])
        self._determiners = self._articles | frozenset(data["owners"])
        self._fillers = frozenset(data["fillers"])
        self._openings = frozenset(map(tuple, self._language.normaliser.lead))
        self._joints, self._addressed = frozenset(data["clause_joints"]), frozenset(data["addressed"])
        self._addressing = frozenset(data["addressing"])
        self._unordered = self._language.negations.union(data["quoting"])
        self._going = [[word] for word in data["going"]]
        self._requesting, self._reasoning = frozenset(data["requesting"]), frozenset(data["reasoning"])
        self._place_joints: Sequence[str] = data["place_joints"]
        self._place_pronouns = sorted((each.split() for each in data["place_pronouns"]), key=len, reverse=True)
        self._asking = frozenset(data["asking"]) - self._requesting

    def suggested(self, text: str, view: StatusView, earlier: Sequence[list[str]] = ()) -> tuple[Sense, ...]:
        """The orders in it and its questions, or its first question, or what an order lacks; empty with a condition.

        A question for a thing comes with the order to look for it, where that is the only one.

        Args:
            text: The sentence, as it was received, which means nothing as a whole, or has values that do not fit.
            view: The run.
            earlier: What was uttered before it, the last at the end.
        """
        clauses = [] if self._language.may_quote(text) else self._joined(list(self._clauses(text)), view)
        if len(clauses) > MOST_CLAUSES or any(len(words) > MOST_WORDS for words in clauses):
            return ()
        if any(self._is_conditional(words, view) for words in clauses):
            return ()
        orders, asked, faults = dict[str, tuple[Sense, ...]](), list[Sense](), list[Sense]()
        unread = list[list[str]]()
        is_question = text.rstrip().endswith("?")
        is_addressed = any(self._addressing & set(words) for words in clauses)
        for at, words in enumerate(clauses):
            senses = self._clause(words, view) or (() if is_question else self._bidden(words, view))
            if any(sense.kind in REPLIES or sense == STOP for sense in senses):
                return ()
            order = _order(senses) or self._grammar.referring(words, view, [*earlier, *clauses[:at]])
            order = order or self._resolved(words, clauses[:at], senses, view)
            order = order or (self._placed(words, clauses[:at], view) if is_fault(senses or FAULT) else ())
            order = order or self._inside(words, view, is_addressed=is_addressed, is_question=is_question)
            if order:
                behind = [word for each in clauses[at + 1 :] for word in each]
                order = (*order[:-1], self._grammar.located(order[-1], words, behind, view))
                orders[order[-1].identity] = (*order[:-1], order[-1]._replace(is_partial=True))
                unread += [order[-1].rest.split()] if order[-1].rest else []
            elif is_fault(senses):
                faults.append(senses[0])
                unread.append(words)
            elif senses and senses[0].kind == "question" and senses[0].name not in ALWAYS:
                asked.append(senses[0])
            elif not senses and self._may_ask(words, is_behind=bool(orders)):
                unread.append(words)
        if not orders:
            return tuple((asked or faults)[:1])
        rest = ", ".join(map(" ".join, unread))
        if len(orders) == 1 and not asked:
            return tuple(sense._replace(rest=rest) for sense in next(iter(orders.values())))
        return (joined([*(each[-1] for each in orders.values()), *asked])._replace(rest=rest),)

    def left_out(self, text: str, sense: Sense, view: StatusView) -> str:
        """The clauses that a stop or a pause at the edge of a sentence leaves out, in their words: orders, or unread.

        Args:
            text: The sentence, as it was received.
            sense: What it means.
            view: The run.
        """
        read = {each.identity for each in (*sense.each, *([Sense("order", "pause")] if sense.is_stop else ()))}
        clauses = list(self._clauses(text)) if not self._language.may_quote(text) else []
        meant = [self._clause(words, view) for words in clauses]
        left = (
            words
            for words, senses in zip(clauses, meant, strict=True)
            if (senses or self._may_ask(words, is_behind=True))
            and not (sense.is_stop and self._cries_stop(words))
            and all(each.kind in ("order", "fault") and each.identity not in read for each in senses)
        )
        return ", ".join(map(" ".join, left))

    def _cries_stop(self, words: Sequence[str]) -> bool:
        """Whether a clause begins or ends with the order to stop."""
        stop = self._language.orders["stop"]
        return stop.begin(words) or any(stop.fits(words[at:]) for at in range(len(words)))

    def _may_ask(self, words: list[str], *, is_behind: bool) -> bool:
        """Whether a clause without a meaning may ask for something, so that it must not be left out unnamed.

        Args:
            words: The words of the clause.
            is_behind: An order is ahead of it; if not, two words may be an address.
        """
        bare = self._language.normaliser.bare(words)
        if len(bare) < 2:
            return False
        is_asking = bare[0] in self._language.data["asking"] or self._language.conditions.begin(bare)
        if is_asking or any(self._grammar.begins_an_order(bare[at:]) for at in range(len(bare))):
            return True
        stated = (slots.get("thing", "").split() for slots in self._language.statement.match(bare))
        is_talk = self._language.wish.fits(bare) or any(len(thing) <= LONGEST_SUBJECT for thing in stated)
        return not is_talk and (is_behind or len(bare) > 2 or self._grammar.knows(bare[0]))

    def _is_conditional(self, words: list[str], view: StatusView) -> bool:
        """Whether a clause is a condition, and nothing by itself as `if not, go home` is."""
        return self._language.conditions.begin(words) and not self._grammar.senses(words, view)

    def _joined(self, clauses: list[list[str]], view: StatusView) -> list[list[str]]:
        """The clauses; two that are an order together are one: `it would be nice, if you went home`.

        So are two that pass on an order: `Anna fragt, ob du nach Hause fährst`.
        """
        made = list[list[str]]()
        for words in clauses:
            is_second = bool(made) and self._language.conditions.begin(words)
            both = [*made[-1], *words] if made else []
            is_joined = is_second and bool(_order(self._grammar.senses(both, view)))
            if is_joined or self._language.relayed.fits(both):
                made[-1] = both
            else:
                made.append(words)
        return made

    def _clauses(self, text: str) -> Iterator[list[str]]:
        """The words of each clause: what is between commas, and around the words that join clauses."""
        alone: Mapping[str, str] = self._language.data["questions_alone"]
        for clause in self._language.normaliser.remarks(text):
            part, words = list[str](), self._language.normaliser.words(clause)
            for word in alone.get(" ".join(words), "").split() or words:
                if word not in self._joints or self._language.excepting.fits([*part[-1:], word]):
                    part.append(word)
                elif part:
                    yield from [] if part in self._going else [part]  # `go and find it` is one order
                    part = []
            if part and tuple(part) not in self._openings:
                yield part

    def _clause(self, words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """What a clause means; nothing where it is one word that has to be mended: no launch of `since lunch`."""
        is_word = len(words) > 1 or self._grammar.knows(words[0])
        senses = self._grammar.senses(words, view) if is_word else ()
        return tuple(each for each in senses if each.kind not in ("yes", "no")) or senses

    def _bidden(self, words: list[str], view: StatusView) -> tuple[Sense, ...]:
        """What a clause orders that begins with whom it bids, `you go home`, or with whose wish it passes on.

        That is `go home` of `Anna wants me to ask you to go home`.
        """
        first, *rest = self._language.normaliser.spoken(words) or [""]
        if first in self._addressed:
            return self._grammar.senses(rest, view)
        relayed = (slots["order"].split() for slots in self._language.relayed.match([first, *rest]))
        found = (self._grammar.senses(self._language.imperative(order), view) for order in relayed)
        return next(filter(_order, found), ())

    def _resolved(
        self, words: list[str], before: Sequence[list[str]], senses: Sequence[Sense], view: StatusView
    ) -> tuple[Sense, ...]:
        """The order of a clause that lacks a value and has a pronoun, with the thing that was named last in its place.

        One that a fact has a word of comes before the others: the cup of `I put my cup down this morning. Find it!`
        """
        places = [at for at, word in enumerate(words) if word in self._pronouns]
        if len(places) != 1:
            return ()
        (at,) = places
        if not any(sense.lacks for sense in senses or self._grammar.senses(words[: at + 1], view)):
            return ()
        named, known = self._things_of(before), self.words_of_facts(view)
        rests = (words[at + 1 :], []) if len(words) - at <= LONGEST_THING else (words[at + 1 :],)
        for thing in sorted(named, key=lambda thing: not known & set(thing)):
            for rest in rests:
                order = _order(self._grammar.senses([*words[:at], *thing, *rest], view))
                if order and " ".join(thing) in self._grammar.open_texts(order[-1]):
                    return order
        return ()

    def _placed(self, words: list[str], before: Sequence[list[str]], view: StatusView) -> tuple[Sense, ...]:
        """The order with the place that was named last for `here` or `there`: `I am in the kitchen, come here`."""
        pronouns = list(self._place_pronouns_in(words))
        places = dict.fromkeys(map(tuple, self._grammar.places_in(before))) if pronouns else ()
        for at, size in pronouns:
            for place in places:
                for joint in self._place_joints:
                    placed = [*words[:at], joint, *place, *words[at + size :]]
                    order = _order(self._grammar.senses(placed, view)) if self._may_start(placed) else ()
                    if order and len(order[-1].named) == 1:
                        return order
        return ()

    def _may_start(self, words: Sequence[str]) -> bool:
        """Whether words may be a start, once what is polite is left out and a verb at their end comes first."""
        forms = ((each, self._language.imperative(each)) for each in self._language.normaliser.openings(words))
        return any(self._grammar.begins_a_start(each) for form in forms for each in form)

    def _place_pronouns_in(self, words: Sequence[str]) -> Iterator[tuple[int, int]]:
        """Where what is in place of a place begins, with how many words it has, the longest first."""
        for each in self._place_pronouns:
            yield from ((at, len(each)) for at in range(1, len(words)) if words[at : at + len(each)] == each)

    def _inside(
        self, words: list[str], view: StatusView, *, is_addressed: bool, is_question: bool
    ) -> tuple[Sense, ...]:
        """The one order within a clause that has more words; none with a negation, words of others, or in a question.

        Args:
            words: The words of the clause.
            view: The run.
            is_addressed: The sentence addresses the robot; if not, the start must come first.
            is_question: The sentence is one; without a request in the clause, nothing is to be done.
        """
        is_request = bool(self._requesting & set(words))
        if self._unordered & set(words) or words[0] in self._asking or (is_question and not is_request):
            return ()
        behind = [words[:at] for at, word in enumerate(words) if word not in self._fillers]
        words, found, at = self._language.normaliser.spoken(words), dict[str, Sense](), 0
        while at < len(words):
            is_free = self._language.may_order_behind(behind[at], is_addressed=True)
            may_begin = at == 0 or self._language.may_order_behind(behind[at], is_addressed=is_addressed)
            sense, size = self._longest(words[at:], view) if may_begin else (None, 0)
            if sense is None and may_begin:
                sense, size = self._ordered(words[at:], view)
            if sense is None and is_free:
                sense, size = self._about_earlier(words, at, view)
            if sense is not None:
                around = (
                    each for each in (words[:at], words[at + size :]) if each and self._may_ask(each, is_behind=False)
                )
                found[sense.identity] = sense._replace(rest=", ".join(map(" ".join, around)))
            at += size or 1
        return tuple(found.values()) if len(found) == 1 else ()

    def _ordered(self, words: list[str], view: StatusView) -> tuple[Sense | None, int]:
        """The longest order of the language that the words begin with, where at most another clause is behind it."""
        for size in range(min(len(words), LONGEST_ORDER), 0, -1):
            if size < len(words) and words[size] not in self._reasoning:
                continue
            found = self._grammar.orders(self._language.normaliser.bare(words[:size]), view)
            if _order(found):
                return found[0], size
        return None, 0

    def _about_earlier(self, words: list[str], at: int, view: StatusView) -> tuple[Sense | None, int]:
        """The start at the end of a clause with a pronoun for what the clause has named: `my cup is gone find it`."""
        rest, before = words[at:], [words[:at]]
        is_thing = words[-1] in self._pronouns and self._grammar.begins_a_start(rest)
        order = self._resolved(rest, before, (), view) if is_thing else self._placed(rest, before, view)
        return (order[-1], len(rest)) if order else (None, 0)

    def _longest(self, words: list[str], view: StatusView) -> tuple[Sense | None, int]:
        """The longest start that the words begin with, and how many words it has; None and 0 where there is none."""
        for size in range(len(words), 1, -1) if self._grammar.begins_a_start(words) else ():
            sense = self._grammar.start_in(words[:size], view)
            if sense is None and size == len(words):
                starts = [each for each in self._grammar.senses(words, view) if each.name == "start"]
                sense = starts[0] if _order(starts) else None
            if sense is not None and self._is_whole(sense, words[size:]):
                return sense, size
        return None, 0

    def _is_whole(self, sense: Sense, rest: list[str]) -> bool:
        """Whether a start has all words of its values, its texts name things, and nothing behind it changes it."""
        texts = [self._language.without_articles(text.split()) for text in self._grammar.open_texts(sense)]
        are_things = all(0 < len(words) <= LONGEST_THING and not self._ends & set(words) for words in texts)
        is_open = self._language.conditions.begin(rest) or rest[:1] == [self._language.text("or")]
        return are_things and not is_open and self._grammar.is_complete(sense, rest)

    def _things_of(self, clauses: Sequence[list[str]]) -> list[list[str]]:
        """The names of things in clauses, the last first; those where something is come after the others."""
        named = [(thing, is_place) for clause in reversed(clauses) for thing, is_place in self.things(clause)]
        return [thing for thing, _ in sorted(named, key=lambda each: each[1])]

    def words_of_facts(self, view: StatusView) -> frozenset[str]:
        """The words of all texts that the run has: what one of them names is a thing rather than a time or a person."""
        values = (key.value for key in view.keys.values())
        texts = (text for value in values for text in (value if isinstance(value, list | tuple) else [value]))
        return (
            frozenset(word for text in texts if isinstance(text, str) for word in self._language.normaliser.words(text))
            - self._articles
        )

    def things(self, words: list[str]) -> Iterator[tuple[list[str], bool]]:
        """The names of things, the last first: each article with the words behind it, up to one that names nothing.

        Each comes with whether something is there: `in the box`.

        A clause of a word or two that the grammar has not is such a name itself: `lamp? find it`.
        """
        for at in range(len(words) - 1, -1, -1):
            if words[at] in self._determiners:
                rest = words[at + 1 : at + 1 + LONGEST_THING]
                size = next((place for place, word in enumerate(rest) if word in self._ends), len(rest))
                if size and rest[size - 1] not in self._pronouns:
                    yield rest[:size], at > 0 and words[at - 1] in self._language.spatial
        if len(words) < LONGEST_THING and not any(map(self._grammar.knows, words)):
            yield words, False


def _order(senses: Sequence[Sense]) -> tuple[Sense, ...]:
    """What a clause orders, where it can mean nothing else, after the question for its thing that it may be as well.

    An answer is none, for it needs its question.
    """
    orders = [sense for sense in senses if sense.kind == "order" and sense.name != "answer"]
    is_else = any(not sense.thing for sense in senses if sense not in orders)
    return tuple(senses) if len(orders) == 1 and senses[-1] in orders and not is_else else ()
