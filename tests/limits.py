# SPDX-License-Identifier: Apache-2.0
"""How a test ends that does not end by itself.

Rule: each test ends by its limit, whatever it runs in. pytest's own timeout fails the test by an exception that
hypothesis takes for a failing example, so that it continues with the next; and it waits for C code to return.
"""

from __future__ import annotations

import faulthandler
import signal
from types import FrameType
from typing import Any

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key

__all__ = ("GRACE_S", "OutOfTime", "pytest_timeout_cancel_timer", "pytest_timeout_set_timer")

GRACE_S = 20.0
"""Seconds after its limit at which the process of a test ends that did not let itself be interrupted."""


class OutOfTime(BaseException):
    """A test has reached its limit. No `Exception`: neither hypothesis nor the code under test takes it for its own."""


@pytest.hookimpl(tryfirst=True, optionalhook=True)
def pytest_timeout_set_timer(item: pytest.Item, settings: Any) -> bool:
    """Interrupt the test at its limit; where it does not return, end the process and print what each thread does."""
    limit = settings.timeout

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise OutOfTime(f"{item.nodeid} was not over after {limit:g} s")

    signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, limit, GRACE_S / 4)
    faulthandler.dump_traceback_later(limit + GRACE_S, exit=True, file=item.config.stash[fault_handler_stderr_fd_key])
    return True


@pytest.hookimpl(tryfirst=True, optionalhook=True)
def pytest_timeout_cancel_timer(item: pytest.Item) -> bool:
    """The test is over."""
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    faulthandler.cancel_dump_traceback_later()
    return True
