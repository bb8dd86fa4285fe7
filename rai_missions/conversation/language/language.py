# SPDX-License-Identifier: Apache-2.0
"""A language as data: its grammar, its templates and what counts as a claim; one file each in `languages/`.

Rule: no sentence of any language is written in code; a new language is a new file, here or in a package of its own.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property, lru_cache
from itertools import chain, product
from pathlib import Path
from typing import Any

from rai_missions.conversation.language.language_faults import language_faults
from rai_missions.conversation.language.phrases import (
    NO_SLOTS,
    SLOT,
    AnyPhrase,
    Phrases,
    around_object,
    examples_of,
    part_of_verb,
    parts_of,
)
from rai_missions.errors import DefinitionError, UsageError, suggestion
from rai_missions.kinds import known_names, offered
from rai_missions.mission.json_reader import read_json
from rai_missions.planning.text.language_file import LanguageTexts, language_codes, language_file, spoken, word_forms
from rai_missions.planning.text.normalise import Normaliser, by_word, each_way
from rai_missions.planning.text.numbers import numbered

__all__ = ("QUOTING", "Language", "language", "languages", "spoken")

WORD = re.compile(r"\{\w*\}|<\w*>|[^\s()\[\]|{}<>*]+")
"""A word of a phrase, a slot or a part."""
FOLDER = Path(__file__).parents[1] / "languages"
ENGLISH = "en"
GROUP = "rai_missions.languages"
"""The entry points of languages: a code, and where its file is."""
QUOTING = ":"
"""What is behind it in a sentence may be the words of others."""
NO_MEANING = ("asking", "articles", "pronouns", "addressing", "prepositions", "auxiliaries", "subjects", "fillers")
"""Tables of words that may be in any question."""
SHORTEST_MEANING = 3
"""Letters of the shortest word that may name a key without being its whole name."""
MOST_NAMES = 1000
"""Names of the format that are remembered without their unit: each sentence asks for those of all keys."""
MOST_PHRASES = 300
"""Phrases of profiles that are remembered as they were compiled."""


class Language(LanguageTexts):
    """The grammar and the templates of one language.

    Args:
        data: The file's content, and the language's word forms.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        super().__init__(data)
        self.normaliser = Normaliser(data)
        self.examples = lru_cache(MOST_NAMES)(lambda phrase: examples_of(phrase, self.parts))
        """Plain sentences of a phrase."""
        self._name_and_unit = lru_cache(MOST_NAMES)(self._split_name)
        self._orders_of = lru_cache(MOST_PHRASES)(self._compiled_orders)
        self.articles = frozenset(data["articles"])
        self.negations = frozenset(data["claims"]["negations"])
        """The words that deny a clause: `not`, `never`."""
        self.spatial = frozenset(data["parts"]["spatial"].replace("|", " ").split())
        """The words that relate a thing to a place: `in`, `next`, `to`."""
        self._without_meaning = frozenset(word for table in NO_MEANING for word in data[table])
        self._plural_ending: str = data["plural_ending"]
        verbs: Mapping[str, Sequence[str]] = data["verbs"]
        self.parts: Mapping[str, str] = parts_of(data["parts"], verbs)
        self._verb = re.compile(rf"(?<![\w{{<])({'|'.join(sorted(verbs, key=len, reverse=True))})(?![\w}}>])")
        one_article = "|".join(map(re.escape, data["articles"]))
        self._optional_article = re.compile(rf"\[(?:{one_article})(?:\|(?:{one_article}))*\]")
        self._any_article = f"[{'|'.join(data['articles'])}]"
        self._two_objects = re.compile(
            r"(?P<verb>[^{}]*?\W)(?P<thing>(?:\[[^]{}]*\] )?\{\w+\})(?P<between>[^{}]*(?:\{\w+\}[^{}]*)??) "
            rf"(?:{'|'.join(data['two_objects']['joints'])}) (?P<receiver>(?:\[[^]{{}}]*\] )?\{{\w+\}})(?P<end>.*)"
        )
        """A phrase with a verb, a thing, and for whom it is."""
        self._may_lack = re.compile(rf"\[((?:{'|'.join(data['two_objects']['joints'])}) (?:\[[^\]]*\] )?{{\w+}})\]")
        """For whom it is, where a sentence may lack it: `[to {person}]`."""
        self.orders, self.warnings, self.questions = map(self._named_phrases, ("orders", "warnings", "questions"))
        self.any_order = AnyPhrase(each.pattern for each in self.orders.values())
        """The phrases of all orders."""
        self.yes, self.no, self.quiet, self.withdraw = map(self._phrases, ("yes", "no", "quiet", "withdraw"))
        self.hesitating, self.doubting = self._phrases("hesitating"), self._phrases("doubting")
        """What leaves it open whether a yes is one: `I suppose`, `later`."""
        self.again, self.other, self.forgetting = map(self._phrases, ("again", "other", "forgetting"))
        self.correction, self.rejected = self._phrases("correction"), self._phrases("rejected")
        self.start, self.answer = self._phrases("start"), self._phrases("answer")
        self.argument, self.with_values = self._phrases("argument"), self._phrases("with_values")
        self.polite, self.indirect = self._phrases("polite"), self._phrases("indirect")
        self.directed = self._phrases("directed")
        self.relayed, self.verbs_behind = self._phrases("relayed"), self._phrases("verbs_behind")
        self.reasons = re.compile(rf"(?<![,\s])[,\s]+{data['reason_pattern']}[^,.;:!?–—]*", re.IGNORECASE)
        """What begins with a word for a reason, up to the next sign, with what is ahead of it."""
        self.reason_joints, self.on_the_way = self._phrases("reason_joints"), self._phrases("on_the_way")
        self.question_senses = self._named_phrases("question_senses")
        self.option_senses, self.advising = self._named_phrases("option_senses"), self._phrases("advising")
        self.statement, self.wish = self._phrases("statement"), self._phrases("wish")
        self.conditions, self.wanted = self._phrases("conditions"), self._phrases("wanted")
        self.excepting, self.other_times = self._phrases("excepting"), self._phrases("other_times")
        self._stating = frozenset(self.parts["verb"].split("|"))
        self._no_order_after, self._quoting = frozenset(data["no_order_after"]), frozenset(data["quoting"])
        names = ("order_joints", "reversing_joints", "before_openings")
        order_joints, self.reversing_joints, self.before_openings = map(self._each_way, names)
        self.joints = sorted(order_joints + self.reversing_joints, key=len, reverse=True)
        """The words that join two orders, the longest first."""
        self.joints_by_word = by_word(filter(None, self.joints), 0)
        """The joints by their first word."""

    def _phrases(self, name: str) -> Phrases:
        return Phrases(self.data[name], self.parts)

    def _named_phrases(self, name: str) -> dict[str, Phrases]:
        return {each: Phrases(phrases, self.parts) for each, phrases in self.data[name].items()}

    def _each_way(self, name: str) -> list[list[str]]:
        return [self.normaliser.words(" ".join(way)) for joint in self.data[name] for way in each_way(joint)]

    @cached_property
    def vocabulary(self) -> frozenset[str]:
        """Every word of the grammar: what a misspelled word may be meant as."""
        alone = (
            self.yes,
            self.no,
            self.quiet,
            self.withdraw,
            self.again,
            self.start,
            self.correction,
            self.other,
            self.rejected,
            self.polite,
            self.indirect,
        )
        every = (*self.orders.values(), *self.questions.values(), *alone)
        around = (*self.normaliser.lead, *self.normaliser.tail)
        forms = (verb for verb in self.data["verb_forms"] if " " not in verb)
        return frozenset([*self.data["fillers"], *forms]).union(*around, *(each.words for each in every))

    @cached_property
    def light_verbs(self) -> frozenset[str]:
        """The words with which phrases of several options' senses begin, `go`, `take`: alone they name no option."""
        senses: Iterable[Sequence[str]] = self.data["option_senses"].values()
        examples = ([each.split() for phrase in phrases for each in self.examples(phrase)] for phrases in senses)
        first = chain.from_iterable({word for word, *_ in each} for each in examples)
        return frozenset(word for word, times in Counter(first).items() if times > 1)

    def unclipped(self, word: str, known: Collection[str]) -> str:
        """A known word whose last letters a person leaves out: `going` of `goin`; the word as it is, if none is."""
        clipped: Mapping[str, str] = self.data["clipped_endings"]
        whole = (word.removesuffix(end) + full for end, full in clipped.items() if word.endswith(end))
        return word if word in known else next((each for each in whole if each in known), word)

    def spelled(self, word: str, known: Collection[str]) -> str:
        """A known word that a keyboard without its letters has written: `küche` of `kueche`; any other as it is."""
        whole = word
        for written, letter in self.data["spellings"].items():
            whole = whole.replace(written, letter)
        return word if word in known or whole not in known else whole

    def imperative(self, words: Sequence[str]) -> list[str]:
        """An order whose verb has another form, as it is in an order: `go home` of `going home`.

        A verb at the end becomes the first word, also in place of one to go: `hole die post` of `geh die post holen`;
        what follows `…` in its form stays at the end.
        """
        forms: Mapping[str, str] = self.data["verb_forms"]
        before = words[:-1]
        before = before[1:] if before[:1] and before[0] in self.data["going"] else before
        for verb, rest in ((words[:1], words[1:]), (words[-1:], before)):
            if form := forms.get("".join(verb)):
                begun, _, end = form.partition("…")
                return [*begun.split(), *rest, *end.split()]
        return list(words)

    def verb_stems(self, words: Sequence[str]) -> Iterator[list[str]]:
        """What a verb may be in an order, itself first: `scan` of `scanning`, `wasch` and `wasche` of `gewaschen`."""
        yield list(words)
        yield self.imperative(words)
        *before, verb = words
        parts = product(self.data["verb_prefixes"], self.data["verb_endings"])
        for prefix, ending in parts:
            if not (verb.startswith(prefix) and verb.endswith(ending)):
                continue
            stem = verb.removeprefix(prefix).removesuffix(ending)
            twice = [stem[:-1]] * (stem[-2:-1] == stem[-1:])
            yield from ([*before, each] for each in (stem, f"{stem}e", *twice) if len(each) > 1)

    def may_quote(self, text: str) -> bool:
        """Whether a text may have the words of others: in quotation marks, or behind a colon."""
        return QUOTING in text or self.normaliser.is_quoting(text)

    def may_order_behind(self, words: Sequence[str], *, is_addressed: bool = False) -> bool:
        """Whether an order may begin behind words without a comma: `my cup is gone find it`, but not `I have to`.

        Args:
            words: Ahead of it, of its clause.
            is_addressed: Whether the robot is addressed; if not, they must be a statement.
        """
        is_free = bool(words) and words[-1] not in self._no_order_after and self._quoting.isdisjoint(words)
        return is_free and (is_addressed or not self._stating.isdisjoint(words))

    def own_phrases(self, phrases: Iterable[str]) -> Phrases:
        """Phrases of a robot's profile: each word as a sentence has it once it is read, in lower case and written out.

        Raises:
            UsageError: One is not closed, or names a part that does not exist.
        """
        return Phrases(map(self._own, phrases), self.parts)

    def order_phrases(self, phrases: Iterable[str], slots: Mapping[str, str] = NO_SLOTS) -> Phrases:
        """Phrases of orders in a profile: a verb that the language lists is any verb of its sense, as `head` for `go`.

        Args:
            phrases: The phrases of the profile.
            slots: The regular expression of what may be in a slot; any words in one that it lacks.

        Raises:
            UsageError: One is not closed, or names a part that does not exist.
        """
        return self._orders_of(tuple(phrases), tuple(sorted(slots.items())))

    def _compiled_orders(self, phrases: tuple[str, ...], slots: tuple[tuple[str, str], ...]) -> Phrases:
        """See `order_phrases`; the same profile is compiled for each of its conversations."""
        return Phrases((way for phrase in phrases for way in self._with_verbs(phrase)), self.parts, dict(slots))

    def with_two_objects(self, phrase: str, listed: Collection[str] = ()) -> list[str]:
        """The phrase with whom something is for ahead of it, `bring {person} {item}` of `bring {item} to {person}`.

        Empty where it has no one for whom something is, or where its verb has no such form and one of both is free.

        Args:
            phrase: The phrase of the profile.
            listed: The arguments that list their values: what is which is known by its words, whatever the verb is.
        """
        found = self._two_objects.fullmatch(self._may_lack.sub(r"\1", phrase))
        if found is None:
            return []
        is_listed = set(SLOT.findall(found["thing"] + found["receiver"])) <= set(listed)
        if not is_listed and set(self.data["two_objects"]["verbs"]).isdisjoint(re.findall(r"\w+", found["verb"])):
            return []
        return [f"{found['verb']}{found['receiver']} {found['thing']}{found['between']}{found['end']}"]

    def order_examples(self, phrase: str) -> list[str]:
        """Plain sentences of a phrase of a robot's profile, with each verb of a sense."""
        return self.examples(self._with_verbs(phrase)[-1])

    def _with_verbs(self, phrase: str) -> list[str]:
        """The phrase with each verb around its object; then with the others of its sense, each preposition written.

        An article that may be left out is any article: `[die] {plant}` has `den Salat`, too.
        """
        forms: Mapping[str, str] = self.data["prepositions_written"]
        own = self._optional_article.sub(self._any_article, self._own(phrase))
        verb = self._verb.match(own)
        ways = around_object(self.data["verbs"][verb[0]], own[verb.end() :]) if verb else []
        ways.append(self._verb.sub(lambda found: f"<{part_of_verb(found[0])}>", own))
        return [WORD.sub(lambda found: f"({forms[found[0]]})" if found[0] in forms else found[0], way) for way in ways]

    def _own(self, phrase: str) -> str:
        return WORD.sub(lambda found: self.written_out(found[0]), phrase)

    def written_out(self, text: str) -> str:
        """The words as a sentence has them once it is read; a slot or a part as it is."""
        return text if text[:1] in ("{", "<") else " ".join(self.normaliser.words(text)) or text.lower()

    def without_articles(self, words: Iterable[str]) -> list[str]:
        """What is left of a thing's name: `cup` of `my cup`."""
        return [word for word in words if word not in self.articles]

    def singular(self, word: str) -> str:
        """A word without the ending of a plural, so that `cups` is `cup`; only for comparing."""
        return word.removesuffix(self._plural_ending)

    def meanings(self, word: str) -> frozenset[str]:
        """The words of a key's name that a word of a question may mean: `temperature` of `hot`; none of `the`."""
        if word in self._without_meaning or len(word) < SHORTEST_MEANING:
            return frozenset()
        forms = (word + ending for ending in self.data["participle_endings"])
        return frozenset(map(self.singular, (word, *forms, *self.data["measures"].get(word, ()))))

    def name_of(self, name: str) -> str:
        """A name of the format as it is spoken, without its unit: `height_m` is `height`."""
        return self._name_and_unit(name)[0]

    def unit_of(self, name: str) -> str:
        """The unit that a name of the format ends with: `m` of `height_m`; empty where it has none."""
        return self._name_and_unit(name)[1]

    def factors(self, unit: str) -> Mapping[str, float]:
        """The words for what a unit measures → how many of that unit each is: 60 for `minutes`, of `s`."""
        tables: Iterable[Mapping[str, float]] = self.data["unit_words"].values()
        sizes = next((table for table in tables if unit in table), {})
        return {word: size / sizes[unit] for word, size in sizes.items()}

    def ways_of(self, name: str) -> Iterator[tuple[str, ...]]:
        """The words of a name, with its numbers in words and in digits: `bed three`, `bed 3`, `the third bed`."""
        words = self.written_out(spoken(name)).split()
        yield tuple(words)
        yield from numbered(words, self.data)

    def _split_name(self, name: str) -> tuple[str, str]:
        """A name without its unit, and the unit."""
        parts = name.split("_")
        for count in (2, 1):
            unit = self.data["units"].get("_".join(parts[-count:]))
            if len(parts) > count and unit is not None:
                return spoken("_".join(parts[:-count])), unit
        return spoken(name), ""

    def decimals(self, digits: str) -> str:
        """A number in digits with the language's sign for decimals."""
        return digits.replace(".", self.data["decimal"])

    def word(self, table: str, name: str) -> str:
        """The word of a table for a name of the format; the name itself where it has none."""
        found: str = self.data[table].get(name, spoken(name))
        return found


def languages() -> tuple[str, ...]:
    """The languages of this package, by their codes."""
    return language_codes(FOLDER)


def known_languages() -> tuple[str, ...]:
    """The languages that a profile may name: those of this package, and of installed ones."""
    return known_names(GROUP, languages())


@cache
def language(code: str) -> Language:
    """The language of a code.

    Raises:
        DefinitionError: A package's file of it is not as that of English, each fault with its place.
        UsageError: There is none, or it does not load.
    """
    own = languages()
    if code in own:
        return Language(_data(code))
    offer = offered(GROUP, code, {})
    if offer is None:
        raise UsageError(f"no language '{code}'{suggestion(code, known_languages())}")
    with offer.opening():
        file = Path(offer.load())
    data = read_json(file)
    if faults := language_faults(data, {**_data(ENGLISH), "language": code}):
        raise DefinitionError(faults, str(file))
    return Language(data)


def _data(code: str) -> dict[str, Any]:
    """What the files of a language of this package hold."""
    return {**word_forms(code), **language_file(FOLDER, code)}
