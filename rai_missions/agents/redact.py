# SPDX-License-Identifier: Apache-2.0
"""Keeps keys and tokens out of whatever leaves this room: answers, reasons, the texts of exceptions, the log.

Rule: what is known to be a secret by its value is hidden wherever it comes from; what merely looks like one, only in
words that somebody made up: those of a model, its provider, an exception or the log.
"""

from __future__ import annotations

import json
import logging
import os
import re
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any
from urllib.parse import quote, unquote, urlsplit

from pydantic import SecretBytes, SecretStr

__all__ = ("Redaction", "held_by", "hush")

HIDDEN = "[hidden]"
SHORTEST = 6
"""A shorter value is no secret, and hiding it would garble the text."""
NUMBERS = frozenset({int, float, bool})
DEEPEST_DATA = 100
"""Objects and lists inside each other; the same is the bound of what is read as JSON."""
DEEPEST = 4
"""Objects inside each other in which a model's keys are looked for."""
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
)
"""What keys look like, by the prefixes that their issuers give them, or by the words before them."""
PACKAGES = ("rai_missions", "visualize")
"""Whose loggers are hushed, those too that are made later."""
TOLD: set[str] = set()
"""What was told of once, by `hush`, is a secret in the whole process: whoever prints it may know no model."""


class Redaction:
    """Hides secrets by their shape, by the values of variables such as `OPENAI_API_KEY`, and the ones it is told.

    Args:
        secrets: Further values never to be shown, such as a model's own key.
    """

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self._secrets = frozenset(secrets)
        self._at_first = self._known()

    def text(self, text: str) -> str:
        """The text without secrets, and without what UTF-8 cannot write down (half a surrogate pair)."""
        text = text.encode("utf-8", "replace").decode()
        return SHAPES.sub(HIDDEN, _without(text, self._known()))

    def json(self, value: Any) -> Any:
        """A JSON value in which no text holds a secret."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, Mapping):
            return {self.text(name): self.json(item) for name, item in value.items()}
        return [self.json(item) for item in value] if isinstance(value, list) else value

    def known(self, value: Any, depth: int = 0) -> Any:
        """A value in which no text holds what was known for a secret when this was made; all else stays as it is.

        Args:
            value: Plain data.
            depth: How deep in it this is; what is deeper than any message is hidden unseen.
        """
        if not self._at_first:
            return value
        if depth > DEEPEST_DATA:
            return HIDDEN
        if isinstance(value, str):
            return _without(value, self._at_first)
        if isinstance(value, Mapping):
            return {self.known(name): self.known(item, depth + 1) for name, item in value.items()}
        if isinstance(value, list) or type(value) is tuple:
            if NUMBERS.issuperset(map(type, value)):  # a scan or a map, and many of them a second
                return value
            return type(value)(self.known(item, depth + 1) for item in value)
        return value

    def _known(self) -> tuple[str, ...]:
        """The values, the longest first, in every spelling."""
        found = {form for secret in (*self._secrets, *TOLD, *_of_variables()) for form in _spellings(secret)}
        return tuple(sorted(found, key=len, reverse=True))


def _without(text: str, secrets: Iterable[str]) -> str:
    for secret in secrets:
        if secret in text:
            text = text.replace(secret, HIDDEN)
    return text


def _of_variables() -> Iterator[str]:
    for name, value in os.environ.items():
        if name.upper().endswith(VARIABLES):
            yield value
        elif "://" in value:
            yield from _passwords(value)


def _passwords(text: str) -> Iterator[str]:
    """The passwords in an address, such as a proxy's."""
    try:
        password = urlsplit(text).password
    except ValueError:
        return
    if password:
        yield from {password, unquote(password)}


def _spellings(secret: str) -> Iterator[str]:
    """A secret as it is, and as JSON, Python and addresses write it."""
    secret = secret.strip()
    if len(secret) >= SHORTEST:
        yield from {secret, json.dumps(secret)[1:-1], json.dumps(secret, ensure_ascii=False)[1:-1]}
        yield from {repr(secret)[1:-1], quote(secret, safe=""), quote(secret)}


def held_by(thing: Any, depth: int = 0, name: str = "") -> Iterator[str]:
    """The keys that something was made with, a model above all: by their type, by their name, and in addresses.

    Args:
        thing: A model, or what one holds.
        depth: How deep in it this is.
        name: Of the field that holds it.
    """
    if isinstance(thing, SecretStr):
        yield thing.get_secret_value()
    elif isinstance(thing, SecretBytes):
        yield thing.get_secret_value().decode("utf-8", "replace")
    elif isinstance(thing, str):
        if name.upper().replace("-", "_").endswith((*VARIABLES, "AUTHORIZATION")):
            yield from {thing, thing.rpartition(" ")[2]}
        elif "://" in thing:
            yield from _passwords(thing)
    elif depth < DEEPEST:
        yield from _held_inside(thing, depth + 1)


def _held_inside(thing: Any, depth: int) -> Iterator[str]:
    if isinstance(thing, Mapping):
        parts = list(thing.items())
    elif isinstance(thing, list | tuple):
        parts = [("", item) for item in thing]
    elif hasattr(type(thing), "model_fields") or hasattr(type(thing), "__dataclass_fields__"):
        parts = list(vars(thing).items()) if hasattr(thing, "__dict__") else []
    else:
        parts = []
    for name, item in parts[:200]:
        yield from held_by(item, depth, str(name))


class _Hush:
    """Makes records of what is logged, this project's without secrets, tracebacks included.

    Args:
        before: What made them until now.
    """

    def __init__(self, before: Callable[..., logging.LogRecord]) -> None:
        self._before = before

    def __call__(self, *given: Any, **words: Any) -> logging.LogRecord:
        record = self._before(*given, **words)
        if record.name.split(".")[0] in PACKAGES:
            _clean(record, Redaction())
        return record


def _clean(record: logging.LogRecord, redaction: Redaction) -> None:
    """Take the secrets out of a record; one that holds none is left as it is."""
    try:
        said = record.getMessage()
    except Exception:  # noqa: BLE001 - what is logged may be anybody's, and raise anything
        record.msg, record.args = f"{record.msg} (what stands here cannot be told in words)", None
        said = record.getMessage()
    if (clean := redaction.text(said)) != said:
        record.msg, record.args = clean, None
    if record.exc_info and record.exc_info[0] is not None:
        trace = "".join(traceback.format_exception(*record.exc_info)).rstrip()
        if (clean := redaction.text(trace)) != trace:
            record.exc_info, record.exc_text = None, clean


def hush(secrets: Iterable[str] = ()) -> Redaction:
    """Keep secrets out of this project's part of the log, from now on; may be called again.

    Args:
        secrets: Further values never to be shown.

    Returns:
        What hides elsewhere whatever was ever told here.
    """
    TOLD.update(secrets)
    if not isinstance(before := logging.getLogRecordFactory(), _Hush):
        logging.setLogRecordFactory(_Hush(before))
    return Redaction()
