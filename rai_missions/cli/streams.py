# SPDX-License-Identifier: Apache-2.0
"""The standard streams as every command may use them: they are there, and take any text.

Rule: what a terminal cannot show is printed as its escape, and a stream that the caller has closed takes all; neither
ends a command, let alone a run.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from io import TextIOWrapper
from typing import TextIO

__all__ = ("discard", "standard_streams")

RAISING = ("strict", "surrogateescape")
"""How streams treat a character that they cannot encode, where that raises for some."""


@contextmanager
def standard_streams() -> Iterator[None]:
    """Have `sys.stdin`, `sys.stdout` and `sys.stderr` be usable, as above."""
    with ExitStack() as before:
        for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):  # in order: each takes its own number
            stream = getattr(sys, name)
            if stream is None:
                before.callback(setattr, sys, name, None)
                setattr(sys, name, before.enter_context(open(os.devnull, mode, encoding="utf-8")))
            elif mode == "w" and isinstance(stream, TextIOWrapper):
                before.callback(_leave, stream, str(stream.errors))
                if stream.errors in RAISING:
                    stream.reconfigure(errors="backslashreplace")
        yield


def _leave(stream: TextIOWrapper, errors: str) -> None:
    """Have a stream be as before; if its reader is gone, what it still holds is dropped, or Python would exit with 120.

    Args:
        stream: The stream.
        errors: How it treated characters that it cannot encode.
    """
    with suppress(ValueError):  # it is closed
        try:
            stream.reconfigure(errors=errors)  # flushes
        except OSError:
            discard(stream)


def discard(stream: TextIO) -> None:
    """Have what a stream still holds go nowhere, with all that is written later."""
    with suppress(OSError, ValueError):  # it is no file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
