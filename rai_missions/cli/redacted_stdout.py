# SPDX-License-Identifier: Apache-2.0
"""What a command prints: without secrets, and without what would command the terminal that shows it.

Rule: whatever a mission, a journal, a robot or an exception says is words to whoever reads it, and nothing else.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import Any, TextIO, cast

from rai_missions.redaction import Redaction

__all__ = ("redacted_output",)

SHOWN_AS = "\N{REPLACEMENT CHARACTER}"
CONTROLS = {code: SHOWN_AS for code in (*range(32), *range(127, 160)) if chr(code) not in "\t\n"}
"""The control characters (ECMA-48): with them a terminal is made to write, hide, or answer."""
TURNS = dict.fromkeys((0x200E, 0x200F, 0x061C, *range(0x202A, 0x202F), *range(0x2066, 0x206A)), SHOWN_AS)
"""What turns the direction of writing, so that words are read in another order than they stand in (Unicode, UAX 9)."""


class Discreet:
    """A stream to which words are written without secrets.

    Args:
        stream: Where they go.
        controls: Whether control characters are let through.
    """

    def __init__(self, stream: TextIO, *, controls: bool) -> None:
        self._stream, self._unshown = stream, {} if controls else CONTROLS | TURNS
        self._redaction = Redaction()

    def write(self, text: str) -> int:
        """Write a text."""
        if text == "\n":
            return self._stream.write(text)
        self._stream.write(self._redaction.text(text).translate(self._unshown))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write texts."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def redacted_output(*, controls: bool) -> Iterator[None]:
    """Have all that is printed meanwhile looked through; a fault of this program is told without secrets as well.

    Args:
        controls: Whether the command draws on the terminal, and so lets control characters through.
    """
    out = sys.stdout if controls else cast(TextIO, Discreet(sys.stdout, controls=False))
    with redirect_stdout(out), redirect_stderr(cast(TextIO, Discreet(sys.stderr, controls=controls))):
        try:
            yield
        except Exception:
            told = traceback.format_exc()
            if Redaction().text(told) == told:
                raise
            sys.stderr.write(told)
            raise SystemExit(1) from None
