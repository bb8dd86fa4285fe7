# SPDX-License-Identifier: Apache-2.0
"""What is a secret, and a text without it: the one place that knows.

Rule: what is known to be a secret by its value is hidden wherever it comes from; what merely looks like one, only in
words that somebody made up: those of a model, its provider, an exception or the log. A text is cut after this, never
before (`rai_missions.redaction.cut`).
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any
from urllib.parse import quote, quote_plus, unquote, urlsplit

__all__ = ("Redaction", "held_by", "keep_secret", "longest_secret", "redacted", "secrets_kept", "variables")

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
KEPT: set[str] = set()
"""Given to `keep_secret` once, a value is a secret in the whole process: whatever prints it may know no model."""


def keep_secret(secrets: Iterable[str]) -> None:
    """Have values hidden from now on, such as a model's own keys; they are never forgotten."""
    KEPT.update(secrets)


def redacted(text: str) -> str:
    """The text without secrets, and without what UTF-8 cannot write down (half a surrogate pair)."""
    text = text.encode("utf-8", "replace").decode()
    return SHAPES.sub(HIDDEN, _without(text, _known()))


def longest_secret() -> int:
    """Characters of the longest secret in its longest notation; 0 where none is known."""
    return max(map(len, _known()), default=0)


def secrets_kept() -> list[str]:
    """What was given to `keep_secret`."""
    return sorted(KEPT)


def variables(*, secret: bool) -> dict[str, str]:
    """The variables of this process that hold a secret, or those that hold none: what others may read of a process."""
    return {name: value for name, value in os.environ.items() if any(_of_variable(name, value)) is secret}


class Redaction:
    """Hides secrets by their shape, by the values of variables such as `OPENAI_API_KEY`, and those that were kept.

    Args:
        secrets: Further values never to be shown, here alone.
    """

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self._secrets = frozenset(secrets)
        self._at_first = self._known()

    def text(self, text: str) -> str:
        """As `redacted`, and without this redaction's own."""
        return redacted(_without(text, _forms(tuple(sorted(self._secrets)))) if self._secrets else text)

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
        return _forms(tuple(sorted({*self._secrets, *_values()})))


def _values() -> Iterator[str]:
    yield from KEPT
    for name, value in os.environ.items():
        yield from _of_variable(name, value)


def _known() -> tuple[str, ...]:
    return _forms(tuple(sorted(set(_values()))))


@lru_cache(maxsize=8)
def _forms(secrets: tuple[str, ...]) -> tuple[str, ...]:
    """The values, the longest first, in every notation; of one with several lines each line as well."""
    parts = {part for secret in secrets for part in (secret, *_lines(secret))}
    found = {form for part in parts for form in _spellings(part)}
    return tuple(sorted(found, key=len, reverse=True))


def _without(text: str, secrets: Iterable[str]) -> str:
    for secret in secrets:
        if secret in text:
            text = text.replace(secret, HIDDEN)
    return text


def _of_variable(name: str, value: str) -> Iterator[str]:
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


def _lines(secret: str) -> Iterator[str]:
    """The lines of a secret that has several, such as a private key: whatever prints one of them alone tells of it."""
    lines = secret.splitlines()
    return (line for line in lines if len(lines) > 1)


def _spellings(secret: str) -> Iterator[str]:
    """A secret as it is, and as JSON, Python and addresses write it; also where one quotes the other."""
    secret = secret.strip()
    if len(secret) >= SHORTEST:
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


def held_by(thing: Any, depth: int = 0, name: str = "") -> Iterator[str]:
    """The keys that something was made with, a model above all: by their type, by their name, and in addresses.

    Args:
        thing: A model, or what one holds.
        depth: How deep in it this is.
        name: Of the field that holds it.
    """
    from pydantic import SecretBytes, SecretStr  # heavy, and few know a model

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
