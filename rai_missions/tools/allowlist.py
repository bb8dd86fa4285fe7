# SPDX-License-Identifier: Apache-2.0
"""What tools may read, write and never touch: patterns over the names of topics, services and actions.

Rule: never goes before write, and write before read. A name that no pattern allows is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from rai_missions.errors import UsageError
from rai_missions.redaction import cut_repr

__all__ = ("AccessKind", "Allowlist")

AccessKind = Literal["read", "write"]
LONGEST_NAME = 255
"""Characters; the longest name of a topic that DDS carries."""
NAME = re.compile(r"(?:/[A-Za-z0-9_][A-Za-z0-9_.-]*)+")
"""Whole names alone: a relative one is resolved by the robot, after it was judged."""
SHOWN = 12
"""How many patterns a refusal names."""


@dataclass(frozen=True)
class Allowlist:
    """The names that tools may use, as patterns: `*` represents any characters, the slash too; `?` for one.

    Raises:
        UsageError: A pattern is no text, is empty, or fits no name, since each begins with a slash.
    """

    read: tuple[str, ...] = ("*",)
    """What may be looked at: topics received, everything listed."""
    write: tuple[str, ...] = ()
    """What may be published on, called and started; and read."""
    never: tuple[str, ...] = ()
    """What is not touched, whatever the others state; nor is anything below such a name."""

    def __post_init__(self) -> None:
        for word in ("read", "write", "never"):
            patterns = tuple(getattr(self, word))
            if isinstance(getattr(self, word), str) or not all(isinstance(each, str) and each for each in patterns):
                raise UsageError(
                    f"'{word}' is a list of patterns such as ['/tractor1/*'], not {cut_repr(patterns, 80)}"
                )
            if odd := next((each for each in patterns if not each.startswith(("/", "*", "?"))), ""):
                whole = cut_repr(f"/{odd}", 80)
                raise UsageError(f"'{word}': {cut_repr(odd, 80)} fits no name; each begins with a slash, as in {whole}")
            object.__setattr__(self, word, patterns)

    def allows(self, name: str, access: AccessKind) -> bool:
        """Whether a name may be read, or written."""
        return not self.refusal(name, access)

    def check(self, name: str, access: AccessKind) -> None:
        """Raises `UsageError` with the refusal, if a name may not be read, or written."""
        why = self.refusal(name, access)
        if why:
            raise UsageError(why)

    def refusal(self, name: str, access: AccessKind) -> str:
        """Why a name may not be read, or written, and what may; empty if it may."""
        if len(name) > LONGEST_NAME or not NAME.fullmatch(name):
            return (
                f"refused: {cut_repr(name, 60)} is no whole name; one begins with a slash, such as '/tractor1/battery'"
            )
        if _matches(self.never, *_and_above(name)):
            return f"refused: '{name}' must never be touched; {self._words(access)}"
        if _matches(self.write, name) or (access == "read" and _matches(self.read, name)):
            return ""
        return f"refused: '{name}' may not be {_done(access)}; {self._words(access)}"

    def _words(self, access: AccessKind) -> str:
        patterns = self.write if access == "write" else tuple(dict.fromkeys((*self.read, *self.write)))
        more = ", …" if len(patterns) > SHOWN else ""
        but = f", but never {', '.join(self.never[:SHOWN])}" if self.never and patterns else ""
        return f"what may be {_done(access)}: {', '.join(patterns[:SHOWN]) or 'nothing'}{more}{but}"


def _done(access: AccessKind) -> str:
    return "written" if access == "write" else "read"


def _matches(patterns: tuple[str, ...], *names: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns for name in names)


def _and_above(name: str) -> tuple[str, ...]:
    """`/a`, `/a/b` and `/a/b/c` for `/a/b/c`: an action's and a service's own topics lie below its name."""
    parts = name.split("/")[1:]
    return tuple("/" + "/".join(parts[: count + 1]) for count in range(len(parts)))
