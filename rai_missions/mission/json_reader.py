# SPDX-License-Identifier: Apache-2.0
"""JSON as authors write it, read within bounds: whatever is wrong with it is a fault with its place.

Rule: any bytes give a JSON value or a `DefinitionError`; a file that is not there is a `UsageError`.
"""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import accumulate, islice
from math import isinf
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.errors import DefinitionError, Fault, UsageError, irregular, meant_file, pointer
from rai_missions.redaction import shown

__all__ = ("MAX_BYTES", "MAX_DEPTH", "file_bytes", "parse_json", "read_json", "too_deep")

MAX_BYTES = 16 * 2**20
MAX_DEPTH = 100
"""Objects and lists inside each other."""
INTEGERS = range(-(2**63), 2**63)
TOKEN = re.compile(r'"(?:[^"\\]++|\\.)*+(?:"|\Z)|([\[\]{}])', re.DOTALL)
DEEPER = {"[": 1, "{": 1, "]": -1, "}": -1, None: 0}
"""What a token, or a string (None), adds to the depth."""
NO_BRACKETS = bytes(set(range(256)) - set(b"[]{}"))
SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


class UnusableNumber(NamedTuple):
    """A number as it is written that has no value here."""

    written: str
    why: str


class RepeatingObject(dict[str, Any]):
    """An object in which words appear twice."""

    words: tuple[str, ...] = ()


def file_bytes(path: Path) -> bytes:
    """What a file holds.

    Raises:
        UsageError: There is no such file, or it cannot be read.
        DefinitionError: It is too large.
    """
    if not os.path.exists(path):  # pathlib's raises on a name that is too long
        raise UsageError(f"there is no file {shown(str(path), 200)}{meant_file(path, path.suffix)}")
    if sort := irregular(path):
        raise UsageError(f"{shown(str(path), 200)} is {sort}; name a .json or .py file")
    try:
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UsageError(f"{shown(str(path), 200)} cannot be read: {error.strerror}") from error
    if len(raw) > MAX_BYTES:
        raise _refused(f"the file is larger than {MAX_BYTES // 2**20} MiB; split the mission", str(path))
    return raw


def read_json(path: Path) -> Any:
    """The JSON value in a file; raises as `file_bytes` and `parse_json` do."""
    return parse_json(file_bytes(path), str(path))


def parse_json(raw: bytes, source: str = "") -> Any:
    """The JSON value in UTF-8 text, with or without a byte order mark.

    Raises:
        DefinitionError: It is not UTF-8, not JSON or cut short, nested deeper than `MAX_DEPTH`, holds a word twice in
            one object, or a number or text that JSON does not have.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        sentence = f"line {line}, byte {error.start}: not UTF-8; save the file in that encoding"
        raise _refused(sentence, source) from None
    if (at := too_deep(text)) is not None:
        where = _where(text, at)
        raise _refused(f"{where}: more than {MAX_DEPTH} objects and lists inside each other; nest less", source)
    if not text.strip():
        raise _refused("the file is empty; write a JSON object", source)
    suspects: list[Any] = []
    value = _parsed(text, suspects, source)
    if suspects or SURROGATE.search(text):
        faults = tuple(_oddities(value, ()))
        if faults:
            raise DefinitionError(faults, source)
    return value


def too_deep(text: str) -> int | None:
    """Where JSON text first nests deeper than `MAX_DEPTH`, if it does."""
    if _is_shallow(text):
        return None

    def depths() -> Iterator[int]:
        return accumulate(map(DEEPER.__getitem__, map(itemgetter(1), TOKEN.finditer(text))))

    if max(depths(), default=0) <= MAX_DEPTH:
        return None
    number = next((number for number, depth in enumerate(depths()) if depth > MAX_DEPTH), None)
    return None if number is None else next(islice(TOKEN.finditer(text), number, None)).start()


def _is_shallow(text: str) -> bool:
    """Whether it is plain at once that text nests within `MAX_DEPTH`; where it is not, each token has to be counted.

    A round takes away two levels at most: the empty objects, then the empty lists.
    """
    if "\\" in text:  # a quote may be part of a string then
        return False
    brackets = "".join(text.split('"')[::2]).encode(errors="replace").translate(None, NO_BRACKETS)
    for _ in range(MAX_DEPTH // 2):
        fewer = brackets.replace(b"{}", b"").replace(b"[]", b"")
        if len(fewer) in (0, len(brackets)):
            return not fewer
        brackets = fewer
    return False


def _parsed(text: str, suspects: list[Any], source: str) -> Any:
    def odd(written: str, why: str) -> UnusableNumber:
        suspects.append(written)
        return UnusableNumber(written, why)

    def integer(written: str) -> int | UnusableNumber:
        if len(written) > 20 or int(written) not in INTEGERS:
            return odd(written, "does not fit in 64 bits; give a smaller number")
        return int(written)

    def decimal(written: str) -> float | UnusableNumber:
        value = float(written)
        return odd(written, "is larger than any number here; give a smaller one") if isinf(value) else value

    def words(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) == len(pairs):
            return found
        doubled = RepeatingObject(found)
        doubled.words = tuple(name for name, times in Counter(name for name, _ in pairs).items() if times > 1)
        suspects.append(doubled)
        return doubled

    def constant(written: str) -> UnusableNumber:
        return odd(written, "is not a number that JSON has; give a finite one")

    try:
        return json.loads(
            text, object_pairs_hook=words, parse_int=integer, parse_float=decimal, parse_constant=constant
        )
    except json.JSONDecodeError as error:
        raise _refused(f"{_where(text, error.pos)}: {_syntax(error, text)}", source) from None


def _syntax(error: json.JSONDecodeError, text: str) -> str:
    reason = error.msg[0].lower() + error.msg[1:]
    if error.pos >= len(text.rstrip()) or error.msg.startswith("Unterminated string"):
        return f"the text ends in the middle ({reason}); is the file cut short?"
    if error.msg == "Extra data":
        return "there is more after the end of the JSON value; keep one value a file"
    rest = text[error.pos :]
    remedy = next((remedy for pattern, remedy in REMEDIES if pattern.match(rest)), "")
    if COMMA.match(rest) or (text[: error.pos].rstrip().endswith(",") and rest[:1] in "}]"):
        remedy = "; take away the comma before the end"
    return f"not JSON: {reason.removesuffix(' at')}, at {shown(rest[:20].partition(chr(10))[0])}{remedy}"


COMMA = re.compile(r",\s*[}\]]")
REMEDIES = (
    (re.compile(r"//|/\*|#"), '; JSON has no comments: write what is for people as "about"'),
    (re.compile("'"), "; texts and words are in double quotes"),
    (re.compile("True|False"), "; write true or false, in lower case"),
    (re.compile("None"), "; write null"),
    (re.compile(r"\t"), "; inside a text a tabulator is \\t"),
    (re.compile(r"[\r\n]"), "; end the text with a quote on its line, or write \\n for a new line"),
    (re.compile(r"---|[A-Za-z_][\w-]*\s*:"), '; JSON has braces around it, and its words in quotes: {"format": 1}'),
)
"""What those write who know another format → what is right here."""


def _where(text: str, at: int) -> str:
    line = text.count("\n", 0, at) + 1
    return f"line {line}, column {at - text.rfind(chr(10), 0, at)}"


def _oddities(value: Any, steps: tuple[str | int, ...]) -> Iterator[Fault]:
    """What JSON text can hold and a mission cannot."""
    if isinstance(value, UnusableNumber):
        yield Fault(pointer(steps), f"{shown(value.written)} {value.why}")
    elif isinstance(value, str):
        if _is_broken(value):
            yield Fault(pointer(steps), f"{shown(value)} holds half a character (a lone surrogate); write it whole")
    elif isinstance(value, Mapping):
        for word in getattr(value, "words", ()):
            yield Fault(pointer((*steps, word)), f"{shown(word)} appears more than once in this object; keep one")
        for word, item in value.items():
            if _is_broken(word):
                yield Fault(pointer((*steps, word)), f"the word {shown(word)} holds half a character; write it whole")
            yield from _oddities(item, (*steps, word))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _oddities(item, (*steps, index))


def _is_broken(text: str) -> bool:
    return any("\ud800" <= character <= "\udfff" for character in text)


def _refused(sentence: str, source: str) -> DefinitionError:
    return DefinitionError([Fault("", sentence)], source)
