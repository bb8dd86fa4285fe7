# SPDX-License-Identifier: Apache-2.0
"""What a secret is, a text without secrets, and the one place where a text from outside is cut.

Rule: a value known as a secret is hidden wherever it comes from; what only looks like a key is hidden in words that
were made up: those of a model, its provider, an exception or the log. Secrets are removed from the whole text first,
and then it is cut, so that no half of a secret is left. The parts of a step were redacted before they entered it, and
the chart depends on nothing but its events: there `clipped` cuts without asking for secrets, and only there.
"""

from __future__ import annotations

import json
import logging
import os
import re
import threading
import traceback
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple
from urllib.parse import quote, quote_plus, unquote, urlsplit

from rai_missions.errors import in_words, one_line

__all__ = (
    "Redaction",
    "clipped",
    "closed",
    "cut",
    "cut_repr",
    "first_line",
    "is_secret_name",
    "logger",
    "passwords_in",
    "quotable",
    "redacted",
    "secrets_held",
    "shown",
    "variables",
)

HIDDEN = "[hidden]"
SHORTEST = 6
"""A shorter value is no secret, and hiding it would garble the text."""
HALF = re.compile(r"[\ud800-\udfff]")
"""Half a surrogate pair; a question mark in its place would make a statement a question."""
PLAIN = frozenset({int, float, bool, type(None)})
"""Types whose values hold no text."""
DEEPEST_DATA = 100
"""Objects and lists inside each other; the same is the bound of what is read as JSON."""
VARIABLES = (
    "API_KEY",
    "ACCESS_KEY",
    "SECRET_KEY",
    "PRIVATE_KEY",
    "TOKEN",
    "SECRET",
    "PASSWORD",
    "PASSWD",
    "PASSPHRASE",
)
"""How the names of variables end whose values are secrets: `OPENAI_API_KEY`, `HF_TOKEN`, `PGPASSWORD`."""
SHAPES = re.compile(
    r"\b(?:sk|pk|rk|gsk|xai|pplx|hf|r8|ghp|gho|ghs|github_pat|glpat|xox[abp])[-_][A-Za-z0-9_\-]{6,}"
    r"|\bAIza[A-Za-z0-9_\-]{10,}|\bAKIA[A-Z0-9]{12,}"
    r"|\beyJ[A-Za-z0-9_\-]{8,}\.[A-Za-z0-9_\-]{4,}(?:\.[A-Za-z0-9_\-]*)?"
    r"|(?<=://)[^\s/@:\"']*:[^\s/@\"']+(?=@)"
    r"|(?i:(?<=bearer )|(?<=basic ))(?=\S*[0-9=]|\S+[A-Z])[A-Za-z0-9_\-.+/=]{6,}"
    r"|(?i:(?<=api[-_ ]key[:=])|(?<=apikey[:=])|(?<=api[-_ ]key[:=] ))[^\s\"',;&]{6,}"
    r"|-----BEGIN [A-Z0-9 ]{0,30}PRIVATE KEY[A-Z ]{0,10}-----"
    r"[\s\S]*?(?:-----END [A-Z0-9 ]{0,30}PRIVATE KEY[A-Z ]{0,10}-----|\Z)"
)
"""What keys look like, by the prefixes that their issuers give them, or by the words before them."""
MOST_VARIABLES = 1_000
"""Values of variables whose secrets are remembered."""
MARK = r"[!-/:-@\[\]^-`{-~]"
"""What Markdown may have with a backslash before it, and mean the same."""
ANY_BACKSLASHES = r"\\*"
"""Within a secret, or a text of many backslashes would be looked at from each of them."""
LOOSE = re.compile(rf"\\*({MARK})|\\+|.", re.DOTALL)
_living: weakref.WeakSet[Redaction] = weakref.WeakSet()
"""Every redaction that something still holds: what prints a text may know neither a model nor its run."""
_turn = threading.RLock()
"""For those who add to `_living` and those who read it; a signal may log on the thread that is adding."""


def redacted(text: str) -> str:
    """The text without secrets, and without what UTF-8 cannot write down (half a surrogate pair)."""
    return _hidden(text, _known())


def _hidden(text: str, secrets: KnownSecrets) -> str:
    text = HALF.sub("\ufffd", text)
    return SHAPES.sub(HIDDEN, _without(text, secrets))


def _json(value: Any, secrets: KnownSecrets) -> Any:
    if isinstance(value, str):
        return _hidden(value, secrets)
    if isinstance(value, Mapping):
        return {_hidden(name, secrets): _json(item, secrets) for name, item in value.items()}
    return [_json(item, secrets) for item in value] if isinstance(value, list) else value


def secrets_held() -> list[str]:
    """The values that the redactions in this process hide, besides those of variables."""
    with _turn:
        return sorted({secret for each in _living for secret in each.secrets})


def variables(*, secret: bool) -> dict[str, str]:
    """The variables of this process that hold a secret, or those that hold none: what others may read of a process."""
    return {name: value for name, value in _environment() if any(_of_variable(name, value)) is secret}


def is_secret_name(name: str) -> bool:
    """Whether a variable or a field of this name holds a secret."""
    return name.upper().endswith(VARIABLES)


class Redaction:
    """Hides secrets: by their shape, by the values of variables such as `OPENAI_API_KEY`, and by the values given here.

    The values given are secrets in the whole process for as long as this object lives, and no longer: what opens a
    model holds the redaction of its keys, and so does each thread that may still print one of them.

    Args:
        secrets: Values never to be shown, such as a model's own keys.
    """

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self.secrets = frozenset(secrets)
        with _turn:
            _living.add(self)
        self._at_first = _known()
        self._shortest = min(map(len, self._at_first.forms), default=0)

    def text(self, text: str) -> str:
        """As `redacted`."""
        return redacted(text)

    def json(self, value: Any) -> Any:
        """A JSON value in which no text holds a secret; what is one is looked up once for all of it."""
        return _json(value, _known())

    def known(self, value: Any, depth: int = 0) -> Any:
        """A value in which no text holds what was known for a secret when this was made; all else stays as it is.

        Args:
            value: Plain data.
            depth: How deep in it this is; what is deeper than any message is hidden unseen.
        """
        if not self._at_first.forms:
            return value
        if depth > DEEPEST_DATA:
            return HIDDEN
        kind = type(value)
        if kind in PLAIN:
            return value
        if isinstance(value, str):
            return value if len(value) < self._shortest else _without(value, self._at_first)
        if kind is dict or isinstance(value, Mapping):
            return {self._known_name(name): self.known(item, depth + 1) for name, item in value.items()}
        if kind is tuple or isinstance(value, list):
            if PLAIN.issuperset(map(type, value)):  # a scan or a map, and many of them a second
                return value
            return kind(self.known(item, depth + 1) for item in value)
        return value

    def _known_name(self, name: Any) -> Any:
        """A name in data; most are shorter than any secret."""
        return name if isinstance(name, str) and len(name) < self._shortest else self.known(name)


def _values() -> Iterator[str]:
    yield from secrets_held()
    for name, value in _environment():
        yield from _of_variable(name, value)


def _environment() -> Iterator[tuple[str, str]]:
    """The variables of this process; another thread may take one away meanwhile."""
    for name in os.environ:  # the names of one moment
        value = os.environ.get(name)
        if value is not None:
            yield name, value


class KnownSecrets(NamedTuple):
    """The values that are secrets at one moment."""

    parts: tuple[str, ...]
    """Each, the longest first; of one with several lines each line as well."""
    forms: tuple[str, ...]
    """The values in every notation, the longest first."""


def _known() -> KnownSecrets:
    return _forms(tuple(sorted(set(_values()))))


@lru_cache(maxsize=8)
def _forms(secrets: tuple[str, ...]) -> KnownSecrets:
    parts = {part.strip() for secret in secrets for part in (secret, *_lines(secret))}
    parts = {part for part in parts if len(part) >= SHORTEST}
    found = {form for part in parts for form in _spellings(part)}
    return KnownSecrets(*(tuple(sorted(each, key=len, reverse=True)) for each in (parts, found)))


def _without(text: str, secrets: KnownSecrets) -> str:
    for form in secrets.forms:
        if form in text:
            text = text.replace(form, HIDDEN)
    if "\\" in text and (escaped := _escaped(secrets.parts)) is not None:
        text = escaped.sub(HIDDEN, text)
    return text


@lru_cache(maxsize=8)
def _escaped(secrets: tuple[str, ...]) -> re.Pattern[str] | None:
    """The secrets that have marks in them, with a backslash or several before any of these; None where none has."""
    loose = [LOOSE.sub(_loose, each).removeprefix(ANY_BACKSLASHES) for each in secrets if not each.isalnum()]
    return re.compile("|".join(loose)) if loose else None


def _loose(part: re.Match[str]) -> str:
    """How a part of a secret is looked for: a backslash in it or before a mark may be left out, or be there."""
    if part[0].startswith("\\") or part[1]:
        return ANY_BACKSLASHES + re.escape(part[1] or "")
    return re.escape(part[0])


@lru_cache(maxsize=MOST_VARIABLES)
def _of_variable(name: str, value: str) -> tuple[str, ...]:
    """The secrets in a variable; a process has the same ones for long, and each text asks for them."""
    if is_secret_name(name):
        return (value,)
    return (*passwords_in(value),) if "://" in value else ()


def passwords_in(text: str) -> Iterator[str]:
    """The password in an address, such as a proxy's, as it is written there and as it is meant."""
    try:
        password = urlsplit(text).password
    except ValueError:
        return
    if password:
        yield from {password, unquote(password)}


def _lines(secret: str) -> Iterator[str]:
    """The lines of a secret that has several, such as a private key: each of them alone is a secret."""
    lines = secret.splitlines()
    return (line for line in lines if len(lines) > 1)


def _spellings(secret: str) -> Iterator[str]:
    """A secret as it is, and as JSON, Python, addresses and Markdown write it; also where one quotes the other."""
    yield secret
    for form in {*_written(secret)}:
        yield form
        yield from _written(form)


def _written(text: str) -> Iterator[str]:
    plain = json.dumps(text, ensure_ascii=False)[1:-1]
    yield from (plain, json.dumps(text)[1:-1], plain.replace("/", "\\/"), repr(text)[1:-1])
    yield repr(f"\"'{text}")[len("'\"\\'") : -1]  # Python escapes one of both quotes where a text has both
    yield repr(text.encode("utf-8", "replace"))[2:-1]
    yield from (quote(text, safe=""), quote(text), quote_plus(text))
    yield from (re.sub(rf"\\({MARK})", r"\1", text), re.sub(MARK, r"\\\g<0>", text))


ESCAPES = {ord(each): f"\\u{ord(each):04x}" for each in "<>\x85\u2028\u2029"}
"""What JSON leaves as it is and could end a block, or begin a line for a reader of Unicode."""
MARKS = str.maketrans(dict.fromkeys('"“”„‟«»〝〞〟', "'"))
MARGIN = 1_000
"""Characters beyond the longest secret that are looked at, for those that are known by their shape."""


def cut(what: object, length: int) -> str:
    """A thing in words, without secrets, in so many characters at the most.

    Args:
        what: A text, an exception, or any other object.
        length: Characters.
    """
    text = in_words(what)
    secrets = _known()
    beyond = max(map(len, secrets.forms), default=0) + MARGIN
    window = length + beyond
    while True:
        clean = _hidden(text[:window], secrets)
        if window >= len(text) or len(clean) >= length + beyond:
            return clean[:length]
        window *= 2


def cut_repr(what: object, length: int) -> str:
    """As Python writes it, without secrets, in so many characters at the most."""
    try:
        text = repr(what)
    except Exception:  # noqa: BLE001 - it may be anything, and raise anything
        text = f"<{type(what).__name__}>"
    return cut(text, length)


def first_line(what: object, length: int = 300) -> str:
    """The first line of an exception or a text, without secrets; empty where there is none."""
    lines = cut(what, 10 * length).strip().splitlines()
    return lines[0][:length] if lines else ""


def clipped(text: str, length: int) -> str:
    """The beginning of a text in which there is no secret any more, since it is a part of a step."""
    return text[:length]


def closed(text: str) -> str:
    """JSON text as one line, with nothing in it that could end the block of a prompt that it is in."""
    return text.translate(ESCAPES)


def quotable(text: str) -> str:
    """A text in one line and without quotation marks: between two of them it is unable to end its quotation."""
    return " ".join(text.translate(MARKS).split())


def shown(value: Any, length: int = 60, *, by: Callable[[str, int], str] = cut) -> str:
    """A value as its author wrote it, cut short; text in single quotes.

    Args:
        value: Plain data.
        length: Characters.
        by: How it is cut: `clipped` inside a step.
    """
    if isinstance(value, str):
        return f"'{_short(value, length, by)}'"
    if isinstance(value, Mapping | list | tuple):
        kind, count = ("an object", "words") if isinstance(value, Mapping) else ("a list", "items")
        if len(value) > 4:
            return f"{kind} of {len(value)} {count}"
    try:
        text = json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        text = repr(value)
    return _short(text, length, by)


def _short(text: str, length: int, by: Callable[[str, int], str]) -> str:
    """In one line: what it holds of a stranger begins none of its own."""
    text = text.encode("utf-8", "backslashreplace").decode()
    found = one_line(by(text, length + 1))
    return found if len(found) <= length else found[: length - 1] + "…"


def logger(name: str) -> logging.Logger:
    """A module's logger, which writes no secret, tracebacks included."""
    made = logging.getLogger(name)
    made.addFilter(_clean)
    return made


def _clean(record: logging.LogRecord) -> bool:
    """Remove the secrets from a record; one without secrets stays as it is."""
    try:
        words = record.getMessage()
    except Exception:  # noqa: BLE001 - what is logged may come from any program, and raise anything
        record.msg, record.args = f"{record.msg} (its values cannot be written as text)", None
        words = record.getMessage()
    if (clean := redacted(words)) != words:
        record.msg, record.args = clean, None
    if record.exc_info and record.exc_info[0] is not None:
        trace = "".join(traceback.format_exception(*record.exc_info)).rstrip()
        if (clean := redacted(trace)) != trace:
            record.exc_info, record.exc_text = None, clean
    return True
