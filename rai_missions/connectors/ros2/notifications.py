# SPDX-License-Identifier: Apache-2.0
"""Notifications of the middleware: who has something to be received, without asking everyone.

Rule: what is notified is counted, never dropped; a count may be too large, and is never too small.

rcl calls back `(user data, count)` on a thread of the middleware when something has arrived. The callback is libc's
`eventfd_write(file, count)`, with the file's number as the user data: no Python runs on that thread, which would
wait for the interpreter's lock while it holds the middleware's. On a 64-bit machine both functions take their two
arguments in the same registers, and what `eventfd_write` returns is not read.
"""

from __future__ import annotations

import ctypes
import os
import select
import sys
import threading
from collections.abc import Hashable, Iterable, Mapping
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as rcl

from rai_missions.redaction import logger

__all__ = ("Notifications", "Source", "open_notifications", "sources_of")

log = logger(__name__)

Source = tuple[str, int]
"""A kind of rcl's entities, and where such an entity is in memory."""
SETTERS: Mapping[str, str] = {
    "subscription": "rcl_subscription_set_on_new_message_callback",
    "client": "rcl_client_set_on_new_response_callback",
    "service": "rcl_service_set_on_new_request_callback",
}
Setter = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
"""`rcl_ret_t set(entity, callback, user data)`; null for the callback takes it back."""
MOST_FILES = 512
"""Files that one connector opens; more parties share them, and are then looked at together. A process may usually open
1,024."""


class _WaitSet(ctypes.Structure):
    """`rcl_wait_set_t` (rcl/wait.h): arrays of pointers to entities, each with its length."""

    _fields_ = [
        field
        for kind in ("subscription", "guard_condition", "timer", "client", "service", "event")
        for field in ((kind, ctypes.POINTER(ctypes.c_void_p)), (f"{kind}_count", ctypes.c_size_t))
    ]


def sources_of(wait_set: Any) -> list[Source]:
    """The entities that are in a wait set now, but for guard conditions, timers and events, which notify no one."""
    with wait_set:
        held = _WaitSet.from_address(wait_set.pointer)
        return [
            (kind, pointer)
            for kind in SETTERS
            for pointer in getattr(held, kind)[: getattr(held, f"{kind}_count")]
            if pointer
        ]


def open_notifications() -> Notifications | None:
    """Notifications where the machine has what they need: Linux on 64 bits, and an rcl with callbacks."""
    if sys.platform != "linux" or sys.maxsize <= 2**32:
        return None
    try:
        return Notifications()
    except (AttributeError, OSError):
        log.debug("notifications of the middleware are not to be had", exc_info=True)
        return None


class Notifications:
    """Counts what arrives for each party, and waits for it. One thread waits; any thread may `ring`.

    Raises:
        AttributeError: A library has no such function.
        OSError: No more files can be opened.
    """

    def __init__(self) -> None:
        library = ctypes.CDLL(rcl.__file__)
        self._set = {kind: Setter((name, library)) for kind, name in SETTERS.items()}
        self._reset_error = library.rcutils_reset_error
        self._write = ctypes.cast(ctypes.CDLL(None).eventfd_write, ctypes.c_void_p)
        self._lock = threading.Lock()
        self._parties: dict[int, list[Hashable]] = {}
        self._sources: dict[Hashable, tuple[int, list[Source]]] = {}
        self._poll: select.epoll | None = select.epoll()
        self._bell = self._opened()
        try:
            self._shared = self._open()
        except OSError:
            os.close(self._bell)
            raise

    def __contains__(self, party: Hashable) -> bool:
        return party in self._sources

    def __iter__(self) -> Any:
        return iter(tuple(self._sources))

    def add(self, party: Hashable, sources: Iterable[Source]) -> bool:
        """Count from now on what arrives at a party's entities, and what has arrived already; False if rcl cannot.

        Args:
            party: Which.
            sources: Its entities.
        """
        file, known = self._file(), list(sources)
        self._sources[party] = (file, known)
        self._parties[file].append(party)
        return all(self._hook(source, file) for source in known)

    def discard(self, party: Hashable, *, is_alive: bool) -> None:
        """Forget a party.

        Args:
            party: Which.
            is_alive: Its entities are not destroyed yet; those that are notify no one.
        """
        file, sources = self._sources.pop(party)
        self._parties[file].remove(party)
        for kind, pointer in sources if is_alive else ():
            self._checked(self._set[kind](pointer, None, None))

    def wait(self, timeout_s: float) -> dict[Hashable, int]:
        """Who has been notified of how much since the last wait; empty after `timeout_s` or a `ring`."""
        found: dict[Hashable, int] = {}
        assert self._poll is not None
        for file, _ in self._poll.poll(timeout_s):
            count = os.eventfd_read(file)
            found.update(dict.fromkeys(self._parties.get(file, ()), count))
        return found

    def ring(self) -> None:
        """End the wait; from any thread, and of no effect once closed."""
        with self._lock:
            if self._poll is not None:
                os.eventfd_write(self._bell, 1)

    def close(self) -> None:
        """Close the files: afterwards none of the entities may be left, for they would write into other files."""
        with self._lock:
            poll, self._poll = self._poll, None
        if poll is not None:
            poll.close()
            for file in (self._bell, *self._parties):
                os.close(file)
            self._parties.clear()
            self._sources.clear()

    def _hook(self, source: Source, file: int) -> bool:
        kind, pointer = source
        return self._checked(self._set[kind](pointer, self._write, file))

    def _checked(self, returned: int) -> bool:
        """Whether rcl did it; its words on a failure are taken back, for rclpy would report them at its next fault."""
        if returned != 0:
            self._reset_error()
        return returned == 0

    def _file(self) -> int:
        """A file that no party has; one that is shared where there are too many."""
        files = (each for each in self._parties if each != self._shared)
        least = min(files, key=lambda each: len(self._parties[each]), default=None)
        if least is not None and (not self._parties[least] or len(self._parties) >= MOST_FILES):
            return least
        try:
            return self._open()
        except OSError:
            return self._shared if least is None else least

    def _open(self) -> int:
        file = self._opened()
        self._parties[file] = []
        return file

    def _opened(self) -> int:
        """A file that is waited for; none is left open where the system waits for no more of them."""
        file = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        assert self._poll is not None
        try:
            self._poll.register(file, select.EPOLLIN)
        except OSError:
            os.close(file)
            raise
        return file
