# SPDX-License-Identifier: Apache-2.0
"""Signals as they are in a terminal, wherever the tests were started: `nohup` ignores SIGHUP, for one."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

from rai_missions.runtime.interrupts import DEFAULTS

__all__ = ("in_terminal",)


@contextmanager
def in_terminal() -> Iterator[None]:
    """The signals that ask a program to end have their defaults, for so long."""
    before = {each: signal.signal(each, default) for each, default in DEFAULTS.items()}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
