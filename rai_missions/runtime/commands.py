# SPDX-License-Identifier: Apache-2.0
"""What anybody may do to a run, from any thread: pause, resume, cancel, kill, hand control over, answer, tell.

Rule: nothing is done here and now. The run takes it up on its own thread, in its turn; an emergency stop overtakes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rai_missions.event import Event
from rai_missions.journal.buffer import BufferedWriter, raised_by
from rai_missions.runtime.clock import Clock, Mailbox
from rai_missions.runtime.lifecycle import Lifecycle

if TYPE_CHECKING:
    from rai_missions.runtime.effects import EffectExecutor

__all__ = ("RunCommands",)


class RunCommands:
    """The side of a run that others act on; its `Commands`."""

    mailbox: Mailbox
    clock: Clock
    lifecycle: Lifecycle
    performer: EffectExecutor
    _requests: deque[Callable[[], None]]
    """What is to be done on the run's thread before its next event."""
    _notes: deque[tuple[str, Any]]
    """What is to be written down then."""
    _scribe: BufferedWriter
    _lose_journal: Callable[[Exception], None]

    def pause(self, by: str = "operator") -> None:
        self._command("pause", by)

    def resume(self, by: str = "operator") -> None:
        self._command("resume", by)

    def cancel(self, by: str = "operator") -> None:
        self._command("cancel", by)

    def kill(self, by: str = "operator") -> None:
        self.mailbox.post_urgent(Event("kill", self.clock.now(), {"by": by}, "command"))

    def control(self, to: str, by: str = "operator") -> str:
        why = self.lifecycle.control.refuses(to, by)
        if not why:
            self.soon(lambda: self._hand_over(to, by))
        return why

    def _hand_over(self, to: str, by: str) -> None:
        if not self.lifecycle.control.request(to, by):
            self.performer.handovers.hand_over(to, by)

    def answer(
        self, number: int, option: str, parameters: Mapping[str, Any] | None = None, by: str = "operator"
    ) -> None:
        data = {"option": option, "parameters": dict(parameters or {}), "by": by}
        self.post(Event(by, self.clock.now(), data, "proposal", number))

    def post(self, event: Event) -> None:
        self.mailbox.post(event)

    def soon(self, do: Callable[[], None]) -> None:
        """Have something done on the run's thread, before its next event."""
        self._requests.append(do)
        self.mailbox.wake()

    def note(self, text: str, data: Any = None) -> None:
        """Have a sentence written into the journal, in its turn; whoever says so waits for no disk.

        Args:
            text: For people.
            data: The same for programs.
        """
        self._notes.append((text, data))
        self.soon(self._write_notes)

    def _write_notes(self) -> None:
        while self._notes:
            each = self._notes.popleft()
            if lost := raised_by(lambda each=each: self._scribe.note(*each)):  # type: ignore[misc]
                self._lose_journal(lost)

    def _command(self, name: str, by: str) -> None:
        self.post(Event(name, self.clock.now(), {"by": by}, "command"))
