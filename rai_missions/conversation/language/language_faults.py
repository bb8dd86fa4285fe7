# SPDX-License-Identifier: Apache-2.0
"""What is at fault in the file of a language: it has what English has, of the same sort and with the same slots.

Rule: every fault is found as the language is opened; none is left for the sentence that needs it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from string import Formatter
from typing import Any

from rai_missions.conversation.language.phrases import AROUND, SLOT, in_one_piece, parts_of, slots_of
from rai_missions.errors import Fault, UsageError, pointer, suggestion
from rai_missions.redaction import shown

__all__ = ("language_faults",)

OF_OWN_WORDS = frozenset(
    [
        "aliases",
        "clipped_endings",
        "contraction_endings",
        "contractions",
        "halves",
        "hundred",
        "indefinite",
        "measures",
        "mishearings",
        "numbering",
        "numbers",
        "ordinals",
        "prepositions_written",
        "spellings",
        "parts",
        "questions_alone",
        "repetitions",
        "shares",
        "turned",
        "unit_words",
        "verb_forms",
        "verbs",
    ]
)
"""Tables that have words of the language as names, in tables within them too; all others have ours."""
OF_A_KIND = re.compile("(refused|end)_")
"""Texts in whose place English has the engine's own sentence."""
KIND_SLOTS = frozenset(("name", "state", "why"))
SORTS = {bool: "true or false", int: "a number", float: "a number", str: "a text", list: "a list of texts"}
SINGLE = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]")
"""What matches one character: one with a backslash, and a class."""
GROUP, REPEATS = re.compile(r"\((?:\?(?:(<?[=!])|:|P<\w+>))?([^()]*)\)"), "\0"
"""A group without groups in it, which may only look, and what is put in its place where it repeats without a limit."""
UNLIMITED = re.compile(rf"[+*{REPEATS}]|{{\d*,}}")
NESTED = re.compile(rf"{REPEATS}(?:[+*]|{{\d*,}})")
NAMED_BY_PHRASES = ("/parts/", "/verbs/")
"""Tables without which no phrase can be read."""
Steps = tuple[str, ...]


def language_faults(data: Any, english: Mapping[str, Any]) -> tuple[Fault, ...]:
    """What a language lacks, has of another sort, or has written wrong; each with its place.

    Args:
        data: The file's content, and the word forms.
        english: The same of English, which is complete, with the code by which the language is offered.
    """
    if isinstance(data, Mapping) and isinstance(data.get("language"), str) and data["language"] != english["language"]:
        sentence = f"the file is of '{data['language']}', and it is '{english['language']}' here"
        return (Fault("/language", sentence),)
    found = tuple(_shape(data, english, ()))
    places = frozenset(fault.place for fault in found)
    if "" in places or any(f"{each}/".startswith(NAMED_BY_PHRASES) for each in places):
        return found  # the phrases cannot be read
    return (*found, *_writing(data, english, parts_of(data["parts"], data["verbs"]), (), places))


def _shape(own: Any, english: Any, steps: Steps) -> Iterator[Fault]:
    """Where a value is of another sort than in English, or has other entries."""
    place = pointer(steps)
    if not isinstance(english, Mapping):
        if why := _sort_fault(own, english):
            yield Fault(place, why)
        return
    if not isinstance(own, Mapping):
        yield Fault(place, f"{shown(own)} is no table; write an object with {_sample(english)}")
        return
    if OF_OWN_WORDS.intersection(steps):
        example = next(iter(english.values()))
        for name, value in own.items():
            yield from _shape(value, example, (*steps, name))
        return
    for name, value in english.items():
        if name in own:
            yield from _shape(own[name], value, (*steps, name))
        else:
            yield Fault(pointer((*steps, name)), f"missing; in English it is {_example(value)}")
    for name in own.keys() - english.keys():
        yield Fault(pointer((*steps, name)), f"English has no '{name}'{suggestion(name, english)}")


def _sort_fault(own: Any, english: Any) -> str:
    """Why a value is not of the sort that English has; empty if it is."""
    numbers = (int, float)
    of_a_sort = isinstance(own, numbers) if type(english) in numbers else isinstance(own, type(english))
    if isinstance(own, float) and not math.isfinite(own):
        return f"{shown(own)} is no finite number; in English it is {_example(english)}"
    if not of_a_sort or (isinstance(own, bool) and not isinstance(english, bool)):
        return f"{shown(own)} is not {SORTS[type(english)]}; in English it is {_example(english)}"
    odd = next((each for each in own if not isinstance(each, str)), None) if isinstance(own, list) else None
    return f"{shown(odd)} in the list is no text" if odd is not None else ""


def _writing(
    own: Any, english: Any, parts: Mapping[str, str], steps: Steps, passed: Collection[str]
) -> Iterator[Fault]:
    """Where a template, a phrase or a pattern cannot be read, or has a slot that has no value; `passed` has a fault."""
    if pointer(steps) in passed:
        return
    if isinstance(own, Mapping) and not OF_OWN_WORDS.intersection(steps):
        for name in [each for each in own if each in english]:
            yield from _writing(own[name], english[name], parts, (*steps, name), passed)
    elif steps[0] in ("parts", "verbs"):
        for name, value in own.items():
            pieces = [piece for each in value for piece in each.split(AROUND)] if isinstance(value, list) else [value]
            if why := _phrase_fault([f"({each})" for each in pieces], (), parts) or _around_fault(value):
                yield Fault(pointer((*steps, name)), why)
    elif why := _fault_of(own, english, parts, steps):
        yield Fault(pointer(steps), why)


def _fault_of(own: Any, english: Any, parts: Mapping[str, str], steps: Steps) -> str:
    """Why a template, a list of phrases or a pattern cannot be read; empty if it can."""
    if isinstance(own, list):
        slots = [slot for each in english for slot in SLOT.findall(each)]
        return _phrase_fault(own, slots, parts)
    if not isinstance(own, str):
        return ""
    is_pattern = steps[0] == "claims" or steps[-1].endswith("_pattern")
    return _pattern_fault(own) if is_pattern else _template_fault(own, _allowed(steps[-1], english))


def _allowed(name: str, english: str) -> frozenset[str]:
    """The slots that a template may have."""
    return KIND_SLOTS if OF_A_KIND.match(name) else frozenset(_slots(english))


def _slots(template: str) -> Iterator[str]:
    return (name for _, name, _, _ in Formatter().parse(template) if name is not None)


def _template_fault(own: str, allowed: frozenset[str]) -> str:
    """Why a template cannot be filled in; empty if it can."""
    try:
        used = frozenset(_slots(own))
    except ValueError as error:
        return f"{shown(own)} cannot be filled in: {error}; a sign by itself is '{{{{' or '}}}}'"
    there = ", ".join(f"{{{each}}}" for each in sorted(allowed)) or "none"
    if unknown := sorted(used - allowed):
        return f"nothing fills in {{{unknown[0]}}}; there is: {there}"
    odd = next((name for _, name, form, how in Formatter().parse(own) if form or how), None)
    return f"{shown(own)} has more than a name in {{{odd}}}; write {{{odd}}} alone" if odd is not None else ""


def _phrase_fault(phrases: Sequence[str], slots: Sequence[str], parts: Mapping[str, str]) -> str:
    """Why phrases cannot be read; empty if they can."""
    try:
        unknown = sorted(slots_of(phrases, parts).difference(slots))
    except UsageError as error:
        return str(error)
    there = ", ".join(f"{{{each}}}" for each in sorted(set(slots))) or "none"
    with_it = (each for each in phrases for slot in unknown[:1] if f"{{{slot}}}" in each)
    return next((f"the phrase {shown(each)} has {{{unknown[0]}}}; there is: {there}" for each in with_it), "")


def _around_fault(forms: str | Sequence[str]) -> str:
    """Why forms of a verb cannot be around its object; empty if they can, and for a part."""
    if isinstance(forms, str):
        return ""
    if not in_one_piece(forms):
        return f"each of its forms has a '{AROUND}'; write one without"
    several = (each for each in forms if each.count(AROUND) > 1)
    return next((f"the phrase {shown(each)} has '{AROUND}' twice; keep one" for each in several), "")


def _pattern_fault(pattern: str) -> str:
    """Why a regular expression cannot be read; empty if it can."""
    try:
        re.compile(pattern)
    except re.error as error:
        return f"{shown(pattern)} is no regular expression: {error}"
    return f"{shown(pattern)} repeats what repeats; a text could take hours" if _is_nested(pattern) else ""


def _is_nested(pattern: str) -> bool:
    """Whether a repetition without a limit is within another, so that the ways to match grow with each character."""
    left, before = SINGLE.sub("x", pattern), ""
    while left != before:
        left, before = (
            GROUP.sub(lambda each: "" if each[1] else REPEATS if UNLIMITED.search(each[2]) else "x", left),
            left,
        )
        if NESTED.search(left):
            return True
    return False


def _sample(table: Mapping[str, Any]) -> str:
    names = list(table)
    return ", ".join(f"'{each}'" for each in names[:3]) + (" …" if names[3:] else "")


def _example(value: Any) -> str:
    """What English has there, shortly."""
    if isinstance(value, Mapping):
        return f"a table with {_sample(value)}"
    return shown(value[:2], 120) if isinstance(value, list) else shown(value, 120)
