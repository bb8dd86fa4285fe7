# SPDX-License-Identifier: Apache-2.0
"""The words by which claims are found, of one language: lists, and the forms of a single word."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.conversation.language.language import Language
from rai_missions.conversation.language.phrases import Phrases

__all__ = ("CLAUSES", "ClaimWords", "Subject", "SubjectKind")

CLAUSES = re.compile(r"(?:,(?!\d)|[;:()\n–—…|/])+|\s-+\s|[.!?]+\s+|(?<!\b[ioa][nft] )\b(?=that\b(?!\s\w+\W*$))", re.I)
"""Where a clause ends; `in that case` and `I know that name` are one."""
PAUSE = r"(?:,(?!\d)|[;:()\n…|/])+|[.!?]+\s|\s[–—-]+\s"
"""What is between two clauses of which each could be a sentence."""
POSSESSIVE = re.compile(r"(?<=\w{3})'s\b")
SIGNS = re.compile(r"[.!?:;,\n]")
"""What is in no name of a thing, but between words or at the end of a sentence."""
LONGEST_NAME = 2
"""Words of a name, without articles: `the red cup`."""
PREDICATIVE = (
    "second", "auxiliaries", "perfect", "modals", "acts", "states", "strong", "deictic", "particles", "negations",
    "stative", "adverbs", "person", "it", "gerund_verbs",
)  # fmt: skip
"""The lists whose words are of a predicate, or are its subject."""
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
        self.addresses: Mapping[str, Any] = data["addresses"]
        """What `Addresses` reads."""
        self.harmless, self.let, self.progress = map(self.phrases, ("harmless", "let", "progress"))
        self.idioms, self.whole_idioms = self.phrases("idioms"), self.phrases("whole_idioms")
        self.assents = self.phrases("assents")
        """What agrees or denies, as a whole clause."""
        self._turned: Mapping[str, str] = data["turned"]
        self._turning = re.compile(rf"\b({'|'.join(sorted(self._turned, key=len, reverse=True))})\b", re.IGNORECASE)
        self.allowed = {kind: Phrases(each, {}) for kind, each in data["allowed"].items()}
        self.kind_noun, self.substance_verb = self.pattern("kind_noun"), self.pattern("substance_verb")
        self.past_pattern, self._progressive = self.pattern("past_pattern"), self.pattern("progressive_pattern")
        self._past, self._place = frozenset(data["past"]), self.pattern("place_pattern")
        self._tails = [tuple(each.split()) for each in data["tails"]]
        self._counted, self._percent = (
            re.compile(rf"\b{data[f'{name}_pattern']}", re.IGNORECASE) for name in ("counted", "percent")
        )
        joining = rf"(?:{data['joining_pattern']})\s+"
        self._joints = re.compile(rf"\s*(?:{PAUSE})\s*(?:{joining})*|\s+(?:{joining})+", re.IGNORECASE)
        self.self_words = frozenset(data["self"])
        """The words for the robot itself."""
        self.asking_words = frozenset(language.data["asking"])
        """The words with which a question begins."""
        self.owned = self.definite | self.possessive
        small = self.function.union(self.adverbs, self.articles, self.auxiliaries, self.modals, self.person)
        self._predicative = self.self_words.union(*(getattr(self, each) for each in PREDICATIVE)) - self.articles
        self._small = small.union(self.substances, self.quantities)

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

    def phrases(self, name: str) -> Phrases:
        """The phrases of the file that have this name there."""
        return Phrases(self._data[name], {})

    def pattern(self, name: str) -> re.Pattern[str]:
        """The pattern of the file that has this name there."""
        return re.compile(self._data[name])

    def words(self, text: str) -> list[str]:
        """The words of a text that is `readable`; what may be a short `is` is one."""
        return self._words(POSSESSIVE.sub(" is", text) if not self.verb_second else text)

    def clauses(self, text: str) -> list[list[str]]:
        """The words of each clause of such a text."""
        return [words for part in CLAUSES.split(text) if (words := self.words(part))]

    def parts(self, text: str) -> list[str]:
        """The clauses of such a text of which each could be a sentence, without what joins them."""
        return [each for each in self._joints.split(text) if self.words(each)]

    def is_counted(self, text: str) -> bool:
        """Whether a text has a share of a number of things, such as `3 of 4` or `four of four`."""
        return self._counted.search(text) is not None

    def has_percent(self, text: str) -> bool:
        """Whether a text has a share of anything, such as `75 %`."""
        return self._percent.search(text) is not None

    def share(self, words: Sequence[str]) -> float:
        """How many of the words are the language's small words; 0 to 1."""
        return sum(word in self._small for word in words) / max(len(words), 1)

    def turned(self, text: str) -> str:
        """A person's text with the robot's words for itself: `I am at the gate?` of `are you at the gate?`."""
        return self._turning.sub(lambda found: self._turned[found[0].lower()], text)

    def is_name(self, text: str) -> bool:
        """Whether a text may name something and states nothing: few words, none of a predicate, and no sign."""
        words = self.words(text)
        is_short = 0 < len([each for each in words if each not in self.articles | self.owned]) <= LONGEST_NAME
        if not is_short or SIGNS.search(text) or self._predicative & set(words):
            return False
        return not any(self.is_past(each) or self.is_progressive(each) for each in words)

    def place_in(self, words: Sequence[str]) -> list[str]:
        """The words of a certain place in a clause; empty where it has none."""
        place = self._place.search(" ".join(words))
        return place.group().split() if place is not None else []

    def has_place(self, words: Sequence[str]) -> bool:
        """Whether a clause has a certain place."""
        return bool(self.place_in(words))

    def is_past(self, word: str) -> bool:
        """Whether it looks like a past tense or a participle."""
        return word in self._past or (word not in self.not_past and self.past_pattern.fullmatch(word) is not None)

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
