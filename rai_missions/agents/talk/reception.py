# SPDX-License-Identifier: Apache-2.0
"""Sentences from the doors: how many may come and may wait, and the turn of each on the conversation's thread.

Rule: a flood slows no run and no door, and uses up nothing of what is kept for an order to stop.
"""

from __future__ import annotations

import threading
import time
from collections import deque

from rai_missions.connectors.worker import Work, Worker
from rai_missions.conversation import StatusView
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import STOP
from rai_missions.planning.text.normalise import LONGEST

__all__ = ("MOST_WAITING", "Reception")

EVERY_S, MOST = 0.1, 20
MOST_DOORS = 64
LONGEST_STOP = 200
"""Characters of a sentence that may be an order to stop."""
MOST_WAITING = 64
"""Sentences that may wait for their turn."""


class Reception:
    """Lets sentences in, from any thread, and has each handled in its turn.

    Args:
        worker: The conversation's thread.
        grammar: Finds orders to stop.
    """

    def __init__(self, worker: Worker, grammar: Grammar) -> None:
        self._worker, self._grammar = worker, grammar
        self._lock = threading.Lock()
        self._received: deque[Work] = deque()
        """What is done in its turn: one piece, then all else that was posted meanwhile, then the next."""
        self.waiting = 0
        """Sentences that were let in and have not had their turn."""
        self._pace, self._stops, self._looks = DoorPace(), DoorPace(), DoorPace()
        """Of sentences, of plain stops, and of looks for a stop in what else comes in a flood, which take milliseconds.
        """

    def refuses(self, text: str, door: str) -> str:
        """Why a sentence is not let in; empty where it is, and `take` must follow.

        Args:
            text: The sentence.
            door: Its door and role.
        """
        if len(text) > LONGEST:  # no rule reads the rest
            return f"a sentence has at most {LONGEST} characters, not {len(text)}"
        if not text.strip():
            return "there is no text in it"
        if not self._may_come(text, door):
            return "too many sentences at once; wait a moment"
        with self._lock:
            if self.waiting >= MOST_WAITING and not self.is_stop(text):
                return f"{MOST_WAITING} sentences wait already; speak again in a moment"
            self.waiting += 1
        return ""

    def take(self, handle: Work) -> bool:
        """Have a sentence that was let in handled in its turn; False where the conversation has ended."""

        def turn() -> None:
            self._leave()
            handle()

        is_taken = self.after_all(turn)
        if not is_taken:
            self._leave()
        return is_taken

    def is_stop(self, text: str) -> bool:
        """Whether a sentence orders to stop, by the grammar alone; from any thread."""
        return len(text) <= LONGEST_STOP and STOP in self._grammar.senses(text, StatusView())

    def after_all(self, do: Work) -> bool:
        """Do something on the conversation's thread once all that was received so far is answered; from any thread.

        Nothing else waits for that: however many persons talk on, the end of a speech and that of the run come next.

        Returns:
            False where the conversation has ended, and so it is not done.
        """
        with self._lock:
            self._received.append(do)
            is_taken = len(self._received) > 1 or self._worker.post(self._take_turn)
            if not is_taken:
                self._received.clear()
        return is_taken

    def _take_turn(self) -> None:
        try:
            self._received[0]()
        finally:
            with self._lock:
                self._received.popleft()
                is_more = bool(self._received)
            if is_more and not self._worker.post(self._take_turn):
                self._take_turn()  # it is closed: what waits is done before it ends

    def _leave(self) -> None:
        with self._lock:
            self.waiting -= 1

    def _may_come(self, text: str, door: str) -> bool:
        """Whether the door has not had too many sentences; what else comes uses up nothing of a stop."""
        if self._pace.take(door):
            return True
        if len(text) <= LONGEST_STOP and self._grammar.is_plain_stop(text):
            return self._stops.take(door)
        return self._looks.take(door) and self.is_stop(text)


class DoorPace:
    """Ten sentences a second for each door and role, and twenty at once."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._left: dict[str, tuple[float, float]] = {}
        """Door → sentences left, and when that was so."""

    def take(self, door: str) -> bool:
        """Whether another sentence may come now."""
        now = time.monotonic()
        with self._lock:
            left, at = self._left.get(door, (float(MOST), now))
            left = min(float(MOST), left + (now - at) / EVERY_S)
            if door in self._left or len(self._left) < MOST_DOORS:
                self._left[door] = max(0.0, left - 1.0), now
            return left >= 1.0
