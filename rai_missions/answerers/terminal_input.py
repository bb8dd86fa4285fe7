# SPDX-License-Identifier: Apache-2.0
"""Lines that a person types, read so that the reading can be given up at any moment.

Rule: no byte is read beyond the end of the line asked for, so that what is typed later is there for anyone who reads
next.
"""

from __future__ import annotations

import contextlib
import math
import os
import time

from rai_missions.connectors.readable import readable

__all__ = ("LineReader", "in_foreground")

LONGEST = 4_096
"""Bytes of a line that are kept; no terminal passes on more."""


def in_foreground(fd: int) -> bool:
    """Whether this program may read from its terminal now; in the background that would stop it."""
    try:
        return os.tcgetpgrp(fd) == os.getpgrp()
    except OSError:  # a terminal that does no job control for us
        return True


class LineReader:
    """Reads lines from a descriptor until it is woken; closes nothing but its own pipe.

    Args:
        fd: Where lines come from: a terminal, or a pipe.
    """

    def __init__(self, fd: int) -> None:
        self.fd = fd
        self.came_at = -math.inf
        """When the last line came, at the earliest: the end of the last wait for any of it, on `time.monotonic`."""
        self._woken, self._waker = os.pipe()
        os.set_blocking(self._woken, False)
        os.set_blocking(self._waker, False)

    def wake(self) -> None:
        """End the reading that is under way, or the next one; may be called from any thread."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._waker, b"!")

    def close(self) -> None:
        os.close(self._woken)
        os.close(self._waker)

    def forget(self) -> None:
        """Drop what was typed before now: it was no answer to what is asked next."""
        with contextlib.suppress(BlockingIOError):
            os.read(self._woken, LONGEST)
        if os.isatty(self.fd) and in_foreground(self.fd):
            import termios  # no such module where there are no terminals

            with contextlib.suppress(termios.error):
                termios.tcflush(self.fd, termios.TCIFLUSH)

    def line(self, until: float) -> str | None:
        """The next line without its end, which the last of a pipe may lack; None once woken, or at `until`.

        Args:
            until: On `time.monotonic`.

        Raises:
            EOFError: No one types here any more, or the program is in the background.
        """
        typed = bytearray()
        while True:
            left = until - time.monotonic()
            if left <= 0:
                return None
            ready = readable(self.fd, self._woken, within_s=0.0)
            if not ready:
                ready = readable(self.fd, self._woken, within_s=left)
                self.came_at = time.monotonic()
            if self.fd in ready:  # first, so that a line that has begun to come is not left there in halves
                byte = self._byte()
                if not byte and not typed:
                    raise EOFError("the operator passed")
                if byte in (b"\n", b""):
                    return typed.decode("utf-8", "replace").rstrip("\r")
                typed += byte if len(typed) < LONGEST else b""
            elif ready:
                with contextlib.suppress(BlockingIOError):
                    os.read(self._woken, LONGEST)
                return None

    def _byte(self) -> bytes:
        if not in_foreground(self.fd):
            raise EOFError("the program is in the background")
        try:
            return os.read(self.fd, 1)
        except OSError as error:  # the other end of the terminal is gone
            raise EOFError(f"the terminal is gone: {error.strerror}") from None
