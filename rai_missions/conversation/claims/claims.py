# SPDX-License-Identifier: Apache-2.0
"""Claims: which sentences of a model are about the robot or its work, and so are replaced by the status.

A sentence whose subject is the robot or its work passes only with a verb of a short list; so does one that has no
subject, or whose passive leaves open who did it, or whose subject is a certain thing around the robot. A share, such as
`3 of 4`, never passes. What cannot be judged, as of another language, is replaced as well. Of what is left a sentence
passes with a mark of what is no report alone: a question, a modal, a condition, a kind of things, a definition.
What is in doubt by these rules passes where its words are those of harmless sentences, and a sentence whose words are
those of claims never does (`claim_score`). What is in brackets or behind a dash is also judged by itself, and so is
each clause that could be a sentence: what asks, bids, leaves open or states something harmless covers no other one.
Rule: in doubt it is a claim. A harmless sentence that is replaced costs a sentence; a claim that passes costs trust.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from itertools import chain, pairwise

from rai_missions.conversation.claims.claim_score import MOST_IN_DOUBT, MOST_OF_CLAUSE, MOST_OF_KNOWN, claim_weights
from rai_missions.conversation.claims.claim_words import CLAUSES
from rai_missions.conversation.claims.harmless_clauses import LEAST_PREDICATE
from rai_missions.conversation.claims.judged_sentence import CERTAIN, ClaimKind, JudgedSentence, claim_rules
from rai_missions.conversation.language.language import language, languages, spoken
from rai_missions.conversation.sentences import sentences
from rai_missions.conversation.view import StatusView
from rai_missions.planning.text.normalise import LONGEST, LONGEST_WORD, readable
from rai_missions.redaction import HIDDEN, cut

__all__ = ("Claims", "plain", "scored_clauses")

BRACKETED = re.compile(rf"(?!{re.escape(HIDDEN)})[(\[{{]([^()\[\]{{}}]*)[)\]}}]")
"""What is in brackets; the mark of a hidden secret is no statement."""
STATEMENTS = re.compile(r"\s[–—-]+\s|;\s|<[^<>]*>")
"""Where another statement begins that is a sentence by itself: behind a dash, a semicolon, or a mark of layout."""
DISGUISES = str.maketrans({"0": "o", "1": "i", "3": "e", "4": "a", "5": "s", "7": "t", "@": "a", "$": "s"})
MIXED = re.compile(r"\b(?!\d{4}s\b)(?=\w*[^\W\d_])(?=\w*\d)\w+|\b\w*[@$]\w+")
SPACED = re.compile(r"(?<![\w'])(?:(?:[^\W\d_]|') ){2,}[^\W\d_](?![\w'])")
SPACED_SHORT = re.compile(r"\b[^\W\d_] [^\W\d_]\b")
BEHIND = r"[\"'”’)\]*_`]*"
"""Quotes, brackets and marks behind the end of a sentence."""
ENDS = re.compile(rf"[.!?…:]+{BEHIND}$")
QUESTION = re.compile(rf"\?{BEHIND}\s*$")
CLOSED = re.compile(rf"(?<!\.\.)[.!?]{BEHIND}$")
ITEM = re.compile(r"\s*(?:[-*+•]|\d+[.)])\s")
PAUSES = re.compile(r"[-–…!?]|\.(?!\d)")
MARKS = re.compile(r"[*_`~#>\"“”„«»\[\]{}]+|(?<!\w)'|'(?!\w)")
DONE_SIGNS = frozenset("✅✔☑🏁🎉👍👌🆗💯🚀")
"""Signs that report a result without a word."""
UNKNOWN: frozenset[ClaimKind] = frozenset(("", "language", "fragment"))
"""The kinds that show nothing of a clause among others: a name or an item of a list is a fragment, too."""
UNMARKED: frozenset[ClaimKind] = frozenset(("", "report", "fragment"))
"""The kinds of a sentence without a mark, which one of the world needs none of."""
NAMED: frozenset[ClaimKind] = UNKNOWN | {"subject", "report", "place"}
"""The kinds that a name may have: `the red cup` begins as a subject does."""
LEAST_SHARE = 0.15
"""The share of another language's small words in a sentence below which that one's rules do not judge it."""
LONGEST_PIECE = 4
"""Words up to which a sentence may be the beginning of the next, as in `The way. Is free.`, or a value no sentence."""
LONGEST_BEGUN = 400
"""Characters of what was begun that are kept."""
LEAST_SCORED = 3
"""Words from which on a clause is scored by itself."""
SHORT = 2
"""Words up to which a sentence passes only if it is listed as harmless, or has a small word."""


class Claims:
    """Finds the sentences of a model that are claims.

    Args:
        code: The dialogue's language; claims in the others are found as well.
    """

    def __init__(self, code: str) -> None:
        self._own, self._harmless, self._reports, self._addresses = claim_rules(code)
        self._weights = claim_weights(code)
        self._letters = frozenset("".join(language(each).data["claims"]["letters"] for each in languages()))
        self._every = (claim_rules(code), *(claim_rules(each) for each in languages() if each != code))

    def why_replaced(self, sentence: str, view: StatusView) -> ClaimKind:
        """Why the status is put in the place of a sentence; empty where it may be spoken.

        Args:
            sentence: One sentence of a model.
            view: The run: its robot, mission, states and keys are subjects, too.
        """
        sentence = cut(sentence, LONGEST)
        parts = [self._addresses.unconditioned(plain(each)) for each in statements(sentence)]
        judged = [sentence] if parts == [plain(sentence)] else [sentence, *parts]
        whole = (self._why(each, view) for each in judged)
        return next(filter(None, chain(whole, (self._why_clause(each, view) for each in judged))), "")

    def why_assented(self, sentence: str, asked: str, view: StatusView) -> ClaimKind:
        """Why a yes or a no is a claim: what it agrees to, or denies, would be one; empty where it is neither.

        Args:
            sentence: One sentence of a model.
            asked: The person's sentence that it answers.
            view: The run.
        """
        if not any(map(self._own.assents.fits, self._own.clauses(plain(sentence)))):
            return ""
        return self.why_replaced(f"{self._own.turned(asked).rstrip('.!? ')}.", view)

    def why_refused(self, text: str, view: StatusView) -> ClaimKind:
        """Why a text is no value of an order; empty where it may be read back: a name may be no sentence.

        Args:
            text: A model's.
            view: The run.
        """
        text = cut(text, LONGEST)
        whole, rest = sentences(text)
        each = (sentence for sentence in (" ".join(text.split()), *whole, rest) if sentence)
        return next(filter(None, (self._why_value(sentence, view) for sentence in each)), "")

    def _why_value(self, text: str, view: StatusView) -> ClaimKind:
        """See `why_refused`; of the whole text, or of a sentence in it."""
        if plain(text) == text and self._own.is_name(text) and self.why_suspected(text, view) in NAMED:
            return ""
        if len(text.split()) > LONGEST_PIECE:
            return self.why_replaced(text, view)
        parts = (plain(each) for each in statements(text))
        return next(filter(None, (self._why_stated_clause(each, view, self._weights.least) for each in parts)), "")

    def _why_clause(self, sentence: str, view: StatusView) -> ClaimKind:
        """See `why_replaced`; of the clauses of a sentence of which each states something by itself."""
        text, is_question = self._addresses.unconditioned(plain(sentence)), _is_question(sentence)
        most = MOST_IN_DOUBT if self._addresses.is_statement(text, is_question=is_question) else self._weights.least
        clauses = self._addresses.uncovered(text, is_question=is_question)
        is_list = any(self._harmless.states_ability(self._own.words(each)) for each in clauses[:1])
        stated = (each for each in clauses if not (is_list and self._harmless.is_listed(self._own.words(each))))
        return next(filter(None, (self._why_stated_clause(each, view, most) for each in stated)), "")

    def _why_stated_clause(self, clause: str, view: StatusView, most: float) -> ClaimKind:
        """See `why_replaced`; of one clause, which is too short for another language.

        Args:
            clause: The clause, as a sentence.
            view: The run.
            most: The score up to which it passes where the rules doubt it.
        """
        kind = self.why_suspected(clause, view)
        if kind in CERTAIN and kind != "language":
            return kind
        if self._own.harmless.fits(self._own.words(clause)):
            return ""
        if kind in UNKNOWN:
            is_known = self._states_ability(clause) or self._is_of_world(clause)
            most = MOST_OF_KNOWN if is_known else MOST_OF_CLAUSE
        elif len(clause.split()) <= SHORT:
            most = MOST_IN_DOUBT
        return (kind or "report") if self._weights.score(clause) > most else ""

    def _why(self, sentence: str, view: StatusView) -> ClaimKind:
        """See `why_replaced`; of a sentence that is one statement."""
        kind = self.why_suspected(sentence, view)
        if kind in CERTAIN:
            return kind
        text = plain(sentence)
        if self._own.harmless.fits(self._own.words(text)):
            return ""
        is_of_world = kind in UNMARKED and self._is_of_world(text)
        if is_of_world or not kind:
            is_known = is_of_world or self._states_ability(text)
            return "report" if self._weights.is_claim(text, is_known=is_known) else ""
        return "" if self._weights.is_harmless(text, scored_clauses(text)) else kind

    def _states_ability(self, text: str) -> bool:
        return any(map(self._harmless.states_ability, self._own.clauses(text)))

    def _is_of_world(self, text: str) -> bool:
        """Whether each clause is of the world, or states a wish: no mission changes either."""
        return all(self._harmless.is_of_world(each) or self._harmless.is_wish(each) for each in self._own.clauses(text))

    def why_suspected(self, sentence: str, view: StatusView) -> ClaimKind:
        """Why a sentence is a claim, or may be one, by the rules alone; empty where it is none.

        Args:
            sentence: One sentence of a model.
            view: The run.
        """
        if DONE_SIGNS & set(sentence):
            return "script"
        text = plain(sentence.lower() if sentence.isupper() else sentence)
        if any(each.isalpha() and "LATIN" not in unicodedata.name(each, "") for each in text):
            return "script"
        words = self._own.words(text)
        if words and max(map(len, words)) > LONGEST_WORD:
            return "script"
        if not words:
            return "script" if sentence.strip(" \n.!?…-") else ""
        shares = [(rules.words, each) for each in (text, PAUSES.sub(" ", text)) for rules in self._every]
        if any(their.is_counted(each) for their, each in shares):
            return "result"
        if any(their.has_percent(each) for their, each in shares):
            return "progress"
        if self._own.harmless.fits(words):
            return ""
        if any(not each.isascii() and each not in self._letters for each in text.lower() if each.isalpha()):
            return "language"
        return self._why_stated(words, text, view, is_question=_is_question(sentence))

    def _why_stated(self, words: Sequence[str], text: str, view: StatusView, *, is_question: bool) -> ClaimKind:
        """Why what a sentence states is replaced.

        Args:
            words: All of the sentence.
            text: It as it is.
            view: The run.
            is_question: Whether it ends with a question mark.
        """
        known = self._addresses.known(text)
        clauses = self._own.clauses(known)
        if self._is_address(words, clauses, is_question=is_question):
            return ""
        names, share = _names(view), self._own.share(words)
        doubt: ClaimKind = ""
        for rules in self._every:
            theirs = rules.words.words(known)
            if rules.words is self._own or rules.words.share(theirs) >= max(share, LEAST_SHARE):
                kind = JudgedSentence(rules, known, names, is_conditional=known != text).kind
                if kind != "report" and kind:
                    return kind
                doubt = doubt or kind
        if not self._is_marked(clauses, is_question=is_question, is_conditional=known != text):
            doubt = "report"
        elif not doubt and any(self._reports.is_placed(each) for each in clauses):
            doubt = "place"
        return self._unknown(words, text, share) or doubt

    def begun(self, before: str, sentence: str, view: StatusView) -> str:
        """The two as one sentence, where a reader may take them for one; empty where they are two.

        Args:
            before: What was spoken before of the same reply, as a sentence or as this returned it; may be empty.
            sentence: The next one.
            view: The run.
        """
        before, sentence = readable(before, by=cut), readable(sentence, by=cut)
        bare, rules = ENDS.sub("", before.strip()), self._own
        words, rest = rules.words(bare), rules.words(sentence)
        is_calm = rules.harmless.fits(words) and not rules.self_words & set(words)
        if not words or is_calm or rules.harmless.fits(rest):
            return ""
        if self._is_address(rest, rules.clauses(sentence), is_question=_is_question(sentence)):
            return ""
        is_open = not CLOSED.search(before.strip()) and not ITEM.match(sentence)
        is_continued = next((each for each in sentence if each.isalpha()), "").islower()
        is_short = len(words) <= LONGEST_PIECE or len(rest) <= SHORT or words[-1].isdigit()
        is_begun = is_short or any(each.end == len(words) for each in self._reports.subjects(words, _names(view)))
        return f"{bare[-LONGEST_BEGUN:]} {sentence}" if is_open or is_continued or is_begun else ""

    def _is_address(self, words: Sequence[str], clauses: Sequence[Sequence[str]], *, is_question: bool) -> bool:
        is_idiom = self._own.whole_idioms.fits(words)
        return not is_idiom and self._addresses.is_address(clauses, is_question=is_question)

    def _is_marked(self, clauses: Sequence[Sequence[str]], *, is_question: bool, is_conditional: bool) -> bool:
        """Whether each clause that states something has a mark of what is no report."""
        rules, main, is_list = self._own, self._addresses.main(clauses), False
        stated = self._stated_in(main) if is_question else main
        least = 1 if is_conditional else LEAST_PREDICATE
        for before, each in pairwise([[], *stated]):
            is_list = is_list and self._harmless.is_listed(each)
            is_open = is_list or (is_conditional and self._harmless.is_foretold(each))
            is_open = is_open or self._harmless.is_aside(each, before)
            if not (is_open or self._harmless.is_marked(each, least=least) or rules.harmless.fits(each)):
                return False
            is_list = is_list or self._harmless.states_ability(each)
        return True

    def _stated_in(self, clauses: Sequence[Sequence[str]]) -> Sequence[Sequence[str]]:
        """What a question states on its way: `Did you know that …`, also where another language follows."""
        relative = (any(each[0] in rules.words.relative for rules in self._every) for each in clauses[1:])
        return clauses[next((at for at, is_relative in enumerate(relative, 1) if is_relative), len(clauses)) :]

    def _unknown(self, words: Sequence[str], text: str, share: float) -> ClaimKind:
        """Whether a sentence is in a language that cannot be judged, or too short for that."""
        if len(words) <= SHORT:
            return "" if share else "fragment"
        return "" if self._weights.is_language_of(text) else "language"


def statements(sentence: str) -> list[str]:
    """The statements of a sentence that could be sentences: in brackets, and on each side of a dash or semicolon."""
    texts = [BRACKETED.sub(" ", sentence), *BRACKETED.findall(sentence)]
    parts = [each for text in texts for each in STATEMENTS.split(text) if any(map(str.isalnum, each))]
    return [each if ENDS.search(each) else f"{each.rstrip()}." for each in parts] if parts[1:] else [sentence]


def scored_clauses(text: str) -> list[str]:
    """The clauses of a plain sentence that are scored by themselves."""
    return [each for each in CLAUSES.split(text) if len(each.split()) >= LEAST_SCORED]


def _is_question(sentence: str) -> bool:
    return QUESTION.search(sentence) is not None


def plain(sentence: str) -> str:
    """Without marks, quotes and disguises; the sentence has no secrets."""
    text = readable(sentence)
    if SPACED.search(text):
        for spaced in (SPACED, SPACED_SHORT):
            text = spaced.sub(lambda found: found.group().replace(" ", ""), text)
        text = re.sub(" +", " ", text)
    text = MARKS.sub(" ", text)
    return MIXED.sub(lambda found: found.group().translate(DISGUISES), text)


def _names(view: StatusView) -> frozenset[str]:
    """The words by which this robot, its mission, its states and its keys are called."""
    own = re.findall(r"[^\W\d_]{3,}", f"{view.robot.partition(',')[0]} {spoken(view.mission)}".lower())
    keys = [word for name in view.keys for word in spoken(name).split() if len(word) > 3]
    return frozenset([*own, *keys, *(word for word in view.robot.lower().partition(",")[0].split() if word)])
