# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C and SIGTERM do while a command has something in hand."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ("on_signals",)


@contextmanager
def on_signals(do: Callable[[int, Any], None]) -> Iterator[None]:
    """Have an interrupt or SIGTERM do this; afterwards they do again what they did before."""
    before = {each: signal.signal(each, do) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
