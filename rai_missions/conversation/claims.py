# SPDX-License-Identifier: Apache-2.0
"""Claims: which sentences of a model are about the robot or its work, and so are replaced by the status.

A sentence whose subject is the robot or its work passes only with a verb of a short list; so does one that has no
subject, or whose passive leaves open who did it, or whose subject is a certain thing around the robot. A share, such as
`3 of 4`, never passes. What cannot be judged, as of another language, is replaced as well. Of what is left a sentence
passes with a mark of what is no report alone: a question, a modal, a condition, a kind of things, a definition.
What is in doubt by these rules passes where its words are those of harmless sentences, and a sentence whose words are
those of claims never does (`claim_score`). What is in brackets or behind a dash is also judged by itself.
Rule: in doubt it is a claim. A harmless sentence that is replaced costs a sentence; a claim that passes costs trust.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain, pairwise
from typing import Literal, NamedTuple

from rai_missions.conversation.addresses import Addresses
from rai_missions.conversation.claim_score import claim_weights
from rai_missions.conversation.claim_words import ClaimWords, Subject
from rai_missions.conversation.harmless_clauses import LEAST_PREDICATE, HarmlessClauses
from rai_missions.conversation.language import language, languages, spoken
from rai_missions.conversation.reporting_clauses import ReportingClauses
from rai_missions.conversation.view import StatusView
from rai_missions.planning.text.normalise import LONGEST_WORD, readable
from rai_missions.redaction import HIDDEN, cut

__all__ = ("CERTAIN", "ClaimKind", "Claims", "plain", "scored_clauses")

ClaimKind = Literal[
    "", "script", "language", "idiom", "subject", "passive", "progress", "result", "fragment", "place", "report"
]
"""Why a sentence is replaced; empty where it is not.

Those in `CERTAIN` are claims by their structure, or cannot be judged; the others are in doubt.
"""
CERTAIN: frozenset[ClaimKind] = frozenset(("script", "language", "result", "subject"))
"""The kinds that no score of a sentence's words takes back."""
CLAUSES = re.compile(r"(?:,(?!\d)|[;:()\n–—…|/])+|\s-+\s|[.!?]+\s+|(?<!\b[ioa][nft] )\b(?=that\b(?!\s\w+\W*$))", re.I)
"""Where a clause ends; `in that case` and `I know that name` are one."""
BRACKETED = re.compile(rf"(?!{re.escape(HIDDEN)})[(\[{{]([^()\[\]{{}}]*)[)\]}}]")
"""What is in brackets; the mark of a hidden secret is no statement."""
STATEMENTS = re.compile(r"\s[–—-]+\s|;\s")
"""Where another statement begins that is a sentence by itself."""
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
NAMED = re.compile(r"(?<=[a-z,] )[A-Z][a-z]+")
"""What English writes as the name of a person or a place."""
CAPITALS = re.compile(r"(?<=\w )[A-ZÄÖÜ]\w+")
"""What German writes as a noun, but for the first word of a sentence."""
PAUSES = re.compile(r"[-–…!?]|\.(?!\d)")
MARKS = re.compile(r"[*_`~#>\"“”„«»\[\]{}]+|(?<!\w)'|'(?!\w)")
DONE_SIGNS = frozenset("✅✔☑🏁🎉👍👌🆗💯🚀")
"""Signs that report a result without a word."""
LEAST_SHARE = 0.15
"""Of a sentence's words that are another language's small words, below which it is not judged by that one's rules."""
LONGEST_PIECE = 4
"""Words up to which a sentence may be the beginning of the next: `The way. Is free.`"""
LONGEST_BEGUN = 400
"""Characters of what was begun that are kept."""
NOUN_WITHIN = 4
"""Words at the beginning of a German clause among which the noun of its article is: `das kleine rote Buch`."""
LEAST_SCORED = 3
"""Words from which on a clause is scored by itself."""
SHORT = 2
"""Words up to which a sentence passes only if it is listed as harmless, or has a small word."""


class ClaimRules(NamedTuple):
    """What is known of one language."""

    words: ClaimWords
    harmless: HarmlessClauses
    reports: ReportingClauses


@cache
def _rules(code: str) -> ClaimRules:
    """The rules of a language, compiled once for all conversations."""
    words = ClaimWords(language(code))
    harmless = HarmlessClauses(words)
    return ClaimRules(words, harmless, ReportingClauses(words, harmless))


@cache
def _addresses(code: str) -> Addresses:
    return Addresses(_rules(code).words)


class Claims:
    """Finds the sentences of a model that are claims.

    Args:
        code: The dialogue's language; claims in the others are found as well.
    """

    def __init__(self, code: str) -> None:
        self._own, self._harmless, self._reports = _rules(code)
        self._addresses, self._weights = _addresses(code), claim_weights(code)
        self._letters = frozenset("".join(language(each).data["claims"]["letters"] for each in languages()))
        self._every = (_rules(code), *(_rules(each) for each in languages() if each != code))

    def why_replaced(self, sentence: str, view: StatusView) -> ClaimKind:
        """Why the status is put in the place of a sentence; empty where it may be spoken.

        Args:
            sentence: One sentence of a model.
            view: The run: its robot, mission, states and keys are subjects, too.
        """
        parts = [self._addresses.unconditioned(plain(each)) for each in statements(sentence)]
        judged = [sentence] if parts == [plain(sentence)] else [sentence, *parts]
        return next(filter(None, (self._why(each, view) for each in judged)), "")

    def _why(self, sentence: str, view: StatusView) -> ClaimKind:
        """See `why_replaced`; of a sentence that is one statement."""
        kind = self.why_suspected(sentence, view)
        if kind in CERTAIN:
            return kind
        text = plain(sentence)
        if not kind:
            return "report" if self._weights.is_claim(text) else ""
        return "" if self._weights.is_harmless(text, scored_clauses(text)) else kind

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
        if any(rules.words.is_counted(each) for each in (text, PAUSES.sub(" ", text)) for rules in self._every):
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
        clauses = _clauses(known, self._own)
        if self._is_address(words, clauses, is_question=is_question):
            return ""
        names, share = _names(view), self._own.share(words)
        doubt: ClaimKind = ""
        for rules in self._every:
            theirs = rules.words.words(known)
            if rules.words is self._own or rules.words.share(theirs) >= max(share, LEAST_SHARE):
                kind = _JudgedSentence(rules, known, names, is_conditional=known != text).kind
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
        if self._is_address(rest, _clauses(sentence, rules), is_question=_is_question(sentence)):
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


def _clauses(text: str, rules: ClaimWords) -> list[list[str]]:
    return [words for part in CLAUSES.split(text) if (words := rules.words(part))]


def _is_question(sentence: str) -> bool:
    return QUESTION.search(sentence) is not None


def plain(sentence: str) -> str:
    """Without marks, quotes and disguises."""
    text = readable(sentence, by=cut)
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


class _JudgedSentence:
    """One sentence, judged by the words of one language."""

    def __init__(self, language_rules: ClaimRules, text: str, names: frozenset[str], *, is_conditional: bool) -> None:
        rules, self._harmless, self._reports = language_rules
        self._rules, self._names, self._is_conditional = rules, names, is_conditional
        self._nouns = frozenset(each.lower() for each in CAPITALS.findall(text)) if rules.verb_second else frozenset()
        self._names_other = any(each.lower() not in names for each in NAMED.findall(text)) and not rules.verb_second
        clauses = _clauses(text, rules)
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
            return "idiom"
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
