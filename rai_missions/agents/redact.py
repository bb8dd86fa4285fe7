# SPDX-License-Identifier: Apache-2.0
"""Keeps keys and tokens out of whatever leaves this room: answers, reasons, the texts of exceptions."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from typing import Any

__all__ = ("Redaction",)

HIDDEN = "[hidden]"
SHORTEST = 6
"""A shorter value is no secret, and hiding it would garble the text."""
VARIABLES = ("API_KEY", "ACCESS_KEY", "SECRET_KEY", "TOKEN", "SECRET", "PASSWORD", "PASSWD")
"""How the names of variables end whose values are secrets: `OPENAI_API_KEY`, `HF_TOKEN`, `PGPASSWORD`."""
SHAPES = re.compile(
    r"\b(?:sk|pk|rk|gsk|xai|pplx|hf|r8|ghp|gho|ghs|github_pat|glpat|xox[abp])[-_][A-Za-z0-9_\-]{6,}"
    r"|\bAIza[A-Za-z0-9_\-]{10,}|\bAKIA[A-Z0-9]{12,}"
    r"|\beyJ[A-Za-z0-9_\-]{8,}\.[A-Za-z0-9_\-]{4,}(?:\.[A-Za-z0-9_\-]*)?"
    r"|(?<=://)[^\s/@:\"']*:[^\s/@\"']+(?=@)"
    r"|(?i:(?<=bearer )|(?<=basic ))[A-Za-z0-9_\-.+/=]{6,}"
    r"|(?i:(?<=api[-_ ]key[:=])|(?<=apikey[:=])|(?<=api[-_ ]key[:=] ))[^\s\"',;&]{6,}"
)
"""What keys look like, by the prefixes that their issuers give them, or by the words before them."""


class Redaction:
    """Hides secrets by their shape, by the values of variables such as `OPENAI_API_KEY`, and the ones it is told.

    Args:
        secrets: Further values never to be shown, such as a model's own key.
    """

    def __init__(self, secrets: Iterable[str] = ()) -> None:
        self._secrets = frozenset(secret for secret in secrets if len(secret) >= SHORTEST)

    def text(self, text: str) -> str:
        """The text without secrets, and without what UTF-8 cannot write down (half a surrogate pair)."""
        text = text.encode("utf-8", "replace").decode()
        known = {value for name, value in os.environ.items() if name.upper().endswith(VARIABLES)}
        for secret in sorted(self._secrets | known, key=len, reverse=True):
            if len(secret) >= SHORTEST:
                text = text.replace(secret, HIDDEN)
        return SHAPES.sub(HIDDEN, text)

    def json(self, value: Any) -> Any:
        """A JSON value in which no text holds a secret."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, Mapping):
            return {self.text(name): self.json(item) for name, item in value.items()}
        return [self.json(item) for item in value] if isinstance(value, list) else value
