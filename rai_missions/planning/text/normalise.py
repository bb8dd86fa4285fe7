# SPDX-License-Identifier: Apache-2.0
"""A sentence as the grammar reads it: one case, no punctuation, contractions written out, politeness removed."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import product
from typing import Any

from rai_missions.redaction import clipped

__all__ = (
    "LONGEST", "LONGEST_WORD", "NEAREST", "Normaliser", "by_word", "each_way", "is_near", "is_slip", "nearest", "once",
    "readable", "unrepeated",
)  # fmt: skip

LONGEST = 2_000
"""Characters of a sentence that are read; no order is longer."""
LONGEST_WORD = 60
"""Letters of a word; a longer one is none, and a sentence with it is not read."""
SHORTEST_SLIP = 4
"""Letters of the shortest word that may lack a letter, or have one twice; in a shorter one two may be exchanged."""
NEAREST = 5
"""Letters of the shortest word in which any letter may be wrong."""
Cut = Callable[[str, int], str]
"""Cuts a text to a number of characters."""
QUOTES = re.compile(r"[\"“”„«»]|(?<!\w)'(?=\w).*[\w.,!?]'(?!\w)|^\s*>", re.MULTILINE)
"""Words of others, also lines of a mail in the reply to it, but for `'em` and `the boys' room`, which have one sign."""
SENTENCES = re.compile(r"(?<=[.!?;])\s+")
CLAUSES = re.compile(r"(?<=[.!?;,:])\s+|\s[-–—]+\s")
TOKEN = re.compile(r"\d+(?:st|nd|rd|th)\b|(?<![^\W_])-?\d+(?:[.,]\d+)*|[^\W\d_]+(?:'[^\W\d_]+)*|[^\W_]+|[@&]")


def readable(text: str, *, by: Cut = clipped) -> str:
    """The text in one Unicode form, without characters that are not shown, apostrophes alike, cut to `LONGEST`.

    Args:
        text: The text of a person.
        by: How it is cut: `redaction.cut` outside a step.
    """
    text = by(text, LONGEST)
    if not text.isascii():
        text = unicodedata.normalize("NFKC", text)
        text = "".join(each for each in text if unicodedata.category(each) not in ("Cf", "Cs", "Co"))
    return re.sub(r"[’‘ʼ`´]", "'", text)


def is_near(one: str, other: str) -> bool:
    """Whether two words differ by one letter at most: one too many, one missing, one wrong, or two exchanged."""
    if abs(len(one) - len(other)) > 1 or one == other:
        return one == other
    if len(one) > len(other):
        one, other = other, one
    for at, (a, b) in enumerate(zip(one, other, strict=False)):  # noqa: B007 - where they differ
        if a != b:
            break
    else:
        at = len(one)
    if len(one) < len(other):
        return one[at:] == other[at + 1 :]
    is_exchanged = one[at : at + 2] == other[at : at + 2][::-1] and one[at + 2 :] == other[at + 2 :]
    return one[at + 1 :] == other[at + 1 :] or is_exchanged


def is_slip(word: str, known: str) -> bool:
    """Whether a slip of the keyboard turned a known word into this one; any other error may be another word.

    A slip exchanges two letters, drops one that is not the first, or doubles one.
    """
    if word == known or len(word) < SHORTEST_SLIP - 1 or word[0] not in known[:2] or not is_near(word, known):
        return False
    if len(word) == len(known):
        return sorted(word) == sorted(known)
    if len(word) < SHORTEST_SLIP or word[0] != known[0]:
        return False
    at = next((at for at, (a, b) in enumerate(zip(word, known, strict=False)) if a != b), len(known))
    return len(word) < len(known) or word[at] == word[at - 1]


def nearest(word: str, known: Collection[str]) -> str:
    """The one known word that it is but for a letter; a short one only by letters exchanged or written twice.

    A short word that begins with another letter, or lacks one, may be another word: `rote` is no `orte`.
    """
    if word in known:
        return word
    if len(word) < NEAREST:
        near = [each for each in known if each[0] == word[0] and len(each) <= len(word) and is_slip(word, each)]
    else:
        sizes = range(max(NEAREST - 1, len(word) - 1), len(word) + 2)
        near = [each for each in known if len(each) in sizes and is_near(word, each)]
        near = [each for each in near if each[0] == word[0]] or near
    return near[0] if len(near) == 1 else word


class Normaliser:
    """Reads sentences of one language.

    Args:
        data: The language's file.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._contractions: Mapping[str, str] = data["contractions"]
        self._endings: Mapping[str, str] = data["contraction_endings"]
        self._any_ending = tuple(self._endings)
        self._fillers = frozenset(data["fillers"])
        self.lead, self.tail = _by_length(data["lead"]), _by_length(data["tail"])
        """Politeness and addresses that may come first, or last, the longest first."""
        self._leads, self._tails = by_word(self.lead, 0), by_word(self.tail, -1)
        self._reporting, self._speaking = frozenset(data["reporting"]), frozenset(data["speaking"])
        self._quoting = frozenset(data["quoting"])
        self._articles = frozenset(data["articles"])
        stops, titles = "|".join(data["stops"]), "|".join(data["titles"])
        self._title = re.compile(rf"\b({titles})\.\s+(?=\w)(?!(?:{stops})\b)", re.IGNORECASE)
        self._numbering: Mapping[str, str] = data["numbering"]
        self._numbered = re.compile(rf"\b({'|'.join(self._numbering)})\.\s*(?=\d)", re.IGNORECASE)
        self._called = lru_cache(maxsize=64)(self._words_of)

    def words(self, text: str) -> list[str]:
        """The words and numbers of a sentence, in lower case, contractions written out."""
        return self.words_in(readable(text))

    def _words_of(self, names: tuple[str, ...]) -> list[list[str]]:
        """How a robot is called, in words as its sentences have them: `rover2` is two; a mention, `@rover`, as well."""
        called = [words for name in names if (words := self.words(name))]
        return [[*self.words("@"), *words] for words in called] + called

    def words_in(self, text: str) -> list[str]:
        """The words of a text that is `readable`."""
        found = list[str]()
        for token in TOKEN.findall(self._without_abbreviations(text).lower()):
            found += (self._contractions.get(token) or self._written_out(token)).split()
        return found

    def _without_abbreviations(self, text: str) -> str:
        """The text without points that end no sentence: `Dr Miller` of `Dr. Miller`, `pump number 3` of `pump no. 3`.

        A word to stop behind a point is a sentence, whatever is ahead of it.
        """
        if "." not in text:
            return text
        text = self._numbered.sub(lambda found: f"{self._numbering[found[1].lower()]} ", text)
        return self._title.sub(r"\1 ", text)

    def _written_out(self, token: str) -> str:
        """A word whose last letters stand for a word of their own: `why've` is `why have`."""
        if not token.endswith(self._any_ending):
            return token
        ending = next(each for each in self._endings if token.endswith(each))
        return f"{token.removesuffix(ending)} {self._endings[ending]}"

    def spoken(self, words: Iterable[str]) -> list[str]:
        """The words without fillers."""
        return [word for word in words if word not in self._fillers]

    def openings(self, words: Iterable[str], names: Iterable[str] = ()) -> Iterator[list[str]]:
        """The words without fillers, then without each address or politeness ahead of them, one after the other.

        Args:
            words: The words of one sentence.
            names: How the robot is called.
        """
        called, left = self._called(tuple(names)), self.spoken(words)
        while left:
            yield left
            left = left[len(next(self._leading(left, called), left)) :]

    def bare(self, words: list[str], names: Iterable[str] = (), *, is_tail_first: bool = False) -> list[str]:
        """The words without politeness, address and fillers.

        Args:
            words: The words of one sentence.
            names: How the robot is called; each may come first or last.
            is_tail_first: What may come last is removed first: of `hi robot` a greeting is left, and no address.
        """
        called = self._called(tuple(names))
        words = self.spoken(words)
        ways = (self._without_tail, self._without_lead)
        before: list[str] = []
        while words != before and words not in called:  # of `rover 2` alone no `2` is left
            before = words
            for way in ways if is_tail_first else reversed(ways):
                words = way(words, called)
        return words

    def _without_lead(self, words: list[str], called: list[list[str]]) -> list[str]:
        lead = next((each for each in self._leading(words, called) if len(words) > len(each)), [])
        return words[len(lead) :]

    def _leading(self, words: list[str], called: list[list[str]]) -> Iterator[list[str]]:
        """Each address or politeness that words begin with; of `rover2`, `rover` ahead of a number is another robot."""
        for each in (*called, *self._leads.get("".join(words[:1]), ())):
            is_numbered = words[len(each) : len(each) + 1] and words[len(each)].isdigit()
            is_another = is_numbered and any(name[:-1] == each and name[-1].isdigit() for name in called)
            if words[: len(each)] == each and not is_another:
                yield each

    def _without_tail(self, words: list[str], called: list[list[str]]) -> list[str]:
        for each in (*called, *self._tails.get("".join(words[-1:]), ())):
            is_shorter = len(words) > len(each) and words[-len(each) :] == each
            if is_shorter and words[-len(each) - 1] not in self._articles:
                return words[: -len(each)]
        return words

    def is_quoting(self, text: str) -> bool:
        """Whether a text has words in quotation marks."""
        return QUOTES.search(readable(text)) is not None

    def parts(self, text: str) -> list[str]:
        """The sentences of an utterance; one alone where it quotes or reports the words of others."""
        return self._split(text, SENTENCES, self._reporting)

    def clauses(self, text: str) -> list[str]:
        """The parts of an utterance between its commas; one alone where it quotes or reports the words of others."""
        return self._split(text, CLAUSES, self._reporting)

    def remarks(self, text: str) -> list[str]:
        """The clauses of a text; the words of other people in it are left whole: `he wants his ball, find it`."""
        return self._split(text, CLAUSES, self._quoting)

    def _split(self, text: str, at: re.Pattern[str], reporting: frozenset[str]) -> list[str]:
        words = self.words(text)
        of_others = (word for word, by in zip(words, ["", *words], strict=False) if by not in self._speaking)
        if self.is_quoting(text) or not reporting.isdisjoint(of_others):
            return [text]
        return [each for each in at.split(self._without_abbreviations(text).strip()) if each]


def _by_length(given: Iterable[str]) -> list[list[str]]:
    return sorted((words for each in given for words in each_way(each)), key=len, reverse=True)


def by_word(phrases: Iterable[list[str]], at: int) -> Mapping[str, list[list[str]]]:
    """The phrases by their first word, or by their last, each list in their order."""
    found = dict[str, list[list[str]]]()
    for each in phrases:
        found.setdefault(each[at], []).append(each)
    return found


def each_way(phrase: str) -> Iterator[list[str]]:
    """The words of a phrase with each of its alternatives: `if you can` and `when you can` of `(if|when) you can`.

    Args:
        phrase: The phrase of a language's file; brackets are not within brackets.
    """
    parts = (part.split("|") for part in re.split(r"[()]", phrase))
    return ("".join(way).split() for way in product(*parts))


def once(words: list[str]) -> Iterator[str]:
    """The words without immediate repetitions: `stop stop stop` is `stop`."""
    last = ""
    for word in words:
        if word != last:
            yield word
        last = word


def unrepeated(words: list[str]) -> list[str]:
    """The words once, where they are but a repetition: `carry on carry on` is `carry on`."""
    sizes = (size for size in range(1, len(words) // 2 + 1) if len(words) % size == 0)
    return words[: next((size for size in sizes if words[size:] == words[:-size]), len(words))]
