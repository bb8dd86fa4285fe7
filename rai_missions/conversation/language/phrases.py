# SPDX-License-Identifier: Apache-2.0
"""Phrases of a grammar as data, compiled: `(start|begin) [the] {mission}`.

`(a|b)` is one of several, `[a|b]` may be left out, `{slot}` is one or more words, `*` too, `<part>` a list of the file,
`~ing` a word with this ending, `$` the end of the words; in a verb, `…` is its object.
Rule: a phrase matches a whole sentence or nothing.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property

from rai_missions.errors import UsageError

__all__ = (
    "AROUND", "NO_SLOTS", "SLOT", "AnyPhrase", "Phrases", "around_object", "example_of", "examples_of", "in_one_piece",
    "part_of_verb", "parts_of", "slots_of", "without_slots",
)  # fmt: skip

ATOM = re.compile(r"[()\[\]|*$]|\{(\w+)\}|<(\w+)>|[^\s()\[\]|{}<>*$]+")
SLOT = re.compile(r"\{(\w+)\}")
"""The place of a value in a phrase or a text: `stack {rest}`."""
WORDS = r"(?:\S+ )+?"
AROUND = "…"
"""The place of the object in a verb that is around it."""
NAMED = re.compile(r"\(\?P<(\w+)>")
"""A slot in the regular expression of a phrase."""
NO_SLOTS: Mapping[str, str] = {}
"""Any words may be in each slot."""


def _compiled(
    phrase: str, parts: Mapping[str, str], within: tuple[str, ...] = (), slots: Mapping[str, str] = NO_SLOTS
) -> str:
    """The regular expression of a phrase, over words that each end with a space.

    Args:
        phrase: As the module's docstring has it.
        parts: The lists that `<part>` names.
        within: The parts that it is in.
        slots: The regular expression of what may be in a slot; any words in one that it lacks.

    Raises:
        UsageError: The phrase is not closed, names a part that does not exist, or one that it is in.
    """
    made = list[str]()
    for atom in ATOM.finditer(phrase):
        text = atom.group()
        if atom.group(1):
            made.append(f"(?P<{atom.group(1)}>{slots.get(atom.group(1), WORDS)})")
        elif atom.group(2):
            if atom.group(2) not in parts:
                raise UsageError(f"the phrase '{phrase}' names no part: '{text}'; there is: {', '.join(parts)}")
            if atom.group(2) in within:
                raise UsageError(f"the phrase '{phrase}' is in the part that it names: '{text}'; write its words")
            made.append(f"(?:{_compiled(parts[atom.group(2)], parts, (*within, atom.group(2)))})")
        else:
            ending = text.removeprefix("~")
            made.append(_SIGNS.get(text) or (r"\S+" if ending != text else "") + f"{re.escape(ending)} ")
    if why := _malformed(phrase):
        raise UsageError(f"the phrase '{phrase}' {why}")
    return "".join(made)


def slots_of(phrases: Iterable[str], parts: Mapping[str, str]) -> frozenset[str]:
    """The slots of phrases that are not compiled.

    Raises:
        UsageError: One is not closed, names a part that does not exist, or one that it is in.
    """
    return frozenset(slot for phrase in phrases for slot in NAMED.findall(_compiled(phrase, parts)))


PAIRS = {"(": ")", "[": "]", "{": "}", "<": ">"}


def _malformed(phrase: str) -> str:
    """What of a phrase cannot be read; empty where all can."""
    opened = list[str]()
    for sign in phrase:
        if sign in PAIRS:
            opened.append(sign)
        elif sign in PAIRS.values() and (not opened or PAIRS[opened.pop()] != sign):
            return f"is not closed: '{sign}' closes what is not open there"
    if opened:
        return f"is not closed: '{opened[-1]}' lacks its '{PAIRS[opened[-1]]}'"
    if unread := re.search(r"[{<](?![^\W\d]\w*[}>])[^}>]*[}>]", phrase):
        name = "one word of letters, digits and '_' that begins with no digit, as in {place}"
        return f"has '{unread[0]}', which is no name; it is {name}"
    slots = SLOT.findall(phrase)
    return next((f"has {{{each}}} twice; keep one" for each in slots if slots.count(each) > 1), "")


LAST_ATOM = re.compile(r"(?:\[[^\[\]]*\]|\([^()]*\)|[^\s()\[\]{}]+)$")
"""The last word of a phrase, or group of words."""
LEFT_OUT = re.compile(r"\[[^()\[\]]*\]|<\w+>|\$")
ONE_OF = re.compile(r"\(([^()\[\]|]*)[^()\[\]]*\)")


def part_of_verb(verb: str) -> str:
    """The name of a verb as a part of phrases: `look_around`."""
    return verb.replace(" ", "_")


def parts_of(parts: Mapping[str, str], verbs: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """What phrases of a language name as `<part>`: its parts, and each verb with the others of its sense."""
    return {**parts, **{part_of_verb(verb): "|".join(in_one_piece(each)) for verb, each in verbs.items()}}


def in_one_piece(forms: Iterable[str]) -> list[str]:
    """The forms of a verb but for those around its object, `tidy … up`."""
    return [each for each in forms if AROUND not in each]


def around_object(forms: Iterable[str], rest: str) -> list[str]:
    """The phrases that begin with a verb around its object: `tidy {place} up [now]` and `tidy {place} [now] up`.

    Args:
        forms: Of the verb.
        rest: What follows it in a phrase, `{place} [now]`; the first slot is the object.
    """
    if (thing := SLOT.search(rest)) is None:
        return []
    ends = dict.fromkeys((thing.end(), len(rest)))
    pieces = (form.split(AROUND, 1) for form in forms if AROUND in form)
    return [f"{begin} {rest[:end]} {last} {rest[end:]}" for begin, last in pieces for end in ends]


def without_slots(phrase: str, joining: Collection[str]) -> dict[str, list[str]]:
    """The slots that a phrase needs → the phrase without each: `escort {person}` of `escort {person} to {door}`.

    What joins a slot to the words ahead is left out as well, `give a tour` of `give a tour of {minutes}`; with the last
    slot, so is all behind the one before it. A verb alone lacks nothing: `look for`.

    Args:
        phrase: As the module's docstring has it.
        joining: Words without a meaning of their own that may be ahead of a slot, as prepositions and articles.
    """
    found, slots = dict[str, list[str]](), list(SLOT.finditer(phrase))
    for slot, before in zip(slots, [None, *slots], strict=False):
        begin = phrase[: slot.start()].rstrip()
        while (ahead := LAST_ATOM.search(begin)) and _joins(ahead[0], joining):
            begin = begin[: ahead.start()].rstrip()
        parts = [f"{begin}{phrase[slot.end() :]}"] if begin and not SLOT.match(begin) else []
        parts += [phrase[: before.end()]] if before is not None and slot is slots[-1] else []
        found[slot[1]] = [part for part in dict.fromkeys(parts) if not _malformed(part) and _has_object(part, joining)]
    return {name: parts for name, parts in found.items() if parts}


def _has_object(phrase: str, joining: Collection[str]) -> bool:
    """Whether a phrase has more than a verb: a slot, or another word with a meaning of its own."""
    words = [word for word in example_of(phrase).split() if word not in joining]
    return SLOT.search(phrase) is not None or len(words) > 1


def _joins(atom: str, joining: Collection[str]) -> bool:
    """Whether an atom ahead of a slot may be left out with it: what is in brackets, or words that join."""
    return atom.startswith("[") or set(re.findall(r"[^\s()|]+", atom)) <= set(joining)


def example_of(phrase: str) -> str:
    """The plainest sentence of a phrase, with `…` for what is free: `find …` for `[please] (find|search) {object}`."""
    text, before = re.sub(r"\{\w+\}|\*", "…", phrase), ""
    while text != before:
        text, before = ONE_OF.sub(r"\1", LEFT_OUT.sub("", text)), text
    return " ".join(text.split())


def examples_of(phrase: str, parts: Mapping[str, str]) -> list[str]:
    """Plain sentences of a phrase, each alternative in one of them: what may be left out is, slots are as they are.

    Args:
        phrase: As the module's docstring has it.
        parts: The lists that `<part>` names.
    """
    return _examples(deque(atom.group() for atom in ATOM.finditer(phrase)), parts)


def _examples(atoms: deque[str], parts: Mapping[str, str]) -> list[str]:
    """The sentences of the atoms up to the end of their group, which are removed."""
    done, plain = list[str](), [""]
    while atoms and (atom := atoms.popleft()) not in (")", "]"):
        if atom == "|":
            done, plain = [*done, *plain], [""]
            continue
        ways = _examples(atoms, parts) if atom in ("(", "[") else [atom]
        ways = examples_of(parts[atom[1:-1]], parts) if atom[0] == "<" else ways
        ways = [""] if atom in ("[", "$", "*") else ways
        first, *others = plain
        each = [*(f"{first} {way}" for way in ways), *(f"{other} {ways[0]}" for other in others)]
        plain = [" ".join(one.split()) for one in each]
    return [*done, *plain]


NOTHING = r"(?!)"
"""What no text matches."""
_SIGNS = {"(": "(?:", ")": ")", "[": "(?:", "]": ")?", "|": "|", "*": WORDS, "$": "$"}


class AnyPhrase:
    """Phrases that are looked for together: whether one of them is there, and not which.

    Args:
        patterns: The regular expression of each, without slots.
    """

    def __init__(self, patterns: Iterable[str]) -> None:
        self.pattern = "|".join(patterns) or NOTHING
        self._any = re.compile(self.pattern)

    def begin(self, words: Iterable[str]) -> bool:
        """Whether the words begin with one of them."""
        return self._any.match(_text(words)) is not None

    def within(self, words: Iterable[str]) -> bool:
        """Whether one of them is anywhere in the words."""
        text = _text(words)
        starts = (0, *(at + 1 for at, sign in enumerate(text[:-1]) if sign == " "))
        return any(self._any.match(text, at) for at in starts)

    def fits(self, words: Iterable[str]) -> bool:
        """Whether the words fit one of them as a whole."""
        return self._any.fullmatch(_text(words)) is not None


class Phrases(AnyPhrase):
    """Several phrases of one sense.

    Args:
        phrases: Each as the module's docstring has it.
        parts: The lists that `<part>` names.
        slots: The regular expression of what may be in a slot; any words in one that it lacks.
    """

    def __init__(self, phrases: Iterable[str], parts: Mapping[str, str], slots: Mapping[str, str] = NO_SLOTS) -> None:
        phrases = list(phrases)
        compiled = [_compiled(phrase, parts, slots=slots) for phrase in phrases]
        super().__init__(f"(?:{re.sub(r'[(][?]P<[^>]+>', '(?:', each)})" for each in compiled)
        self._sources = tuple(compiled)
        self.slots = frozenset(slot for each in compiled for slot in NAMED.findall(each))
        sources = " ".join([*phrases, *parts.values()])
        self.words = frozenset(re.findall(r"[^\W\d_]+", re.sub(r"\{\w+\}|<\w+>", " ", sources)))

    @cached_property
    def _each(self) -> list[re.Pattern[str]]:
        """Each by itself, for its slots; of most lists only is asked whether one of them is there."""
        return [re.compile(each) for each in self._sources]

    def match(self, words: Iterable[str]) -> Iterator[Mapping[str, str]]:
        """The slots of each phrase that the words fit as a whole."""
        text = _text(words)
        for each in self._each if self._any.fullmatch(text) else ():
            if found := each.fullmatch(text):
                yield {name: value.strip() for name, value in found.groupdict().items() if value}


def _text(words: Iterable[str]) -> str:
    """The words as a regular expression of phrases has them: each ends with a space."""
    return " ".join([*words, ""])
