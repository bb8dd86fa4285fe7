# SPDX-License-Identifier: Apache-2.0
"""What a broker reports about each packet that was sent to it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

__all__ = ("Acknowledgements", "OnCodes")

OnCodes = Callable[[Sequence[Any]], object]
"""Receives the reason codes of one packet, as paho has them; on paho's thread."""


class Acknowledgements:
    """The packets of one connection that wait for the broker's word.

    The broker may be quicker than the thread that sends: what comes before that thread knows the packet's number waits
    for it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._awaited: dict[int, OnCodes] = {}
        self._early: dict[int, Sequence[Any]] = {}
        self._sending = 0

    def track(self, send: Callable[[], tuple[Any, int]], on_codes: OnCodes) -> None:
        """Send a packet, and pass on what the broker reports about it.

        Args:
            send: Sends it, and returns paho's error (0 if there is none) and the packet's number.
            on_codes: Called at most once.
        """
        with self._lock:
            self._sending += 1
        number = None
        try:
            fault, mid = send()
            number = None if fault else mid
        finally:
            with self._lock:
                codes = None if number is None else self._early.pop(number, None)
                if number is not None and codes is None:
                    self._awaited[number] = on_codes
                self._sending -= 1
                if not self._sending:
                    self._early.clear()
        if codes is not None:
            on_codes(codes)

    def arrived(self, number: int, codes: Sequence[Any]) -> None:
        """The broker has reported about a packet."""
        with self._lock:
            on_codes = self._awaited.pop(number, None)
            if on_codes is None and self._sending:
                self._early[number] = codes
        if on_codes is not None:
            on_codes(codes)
