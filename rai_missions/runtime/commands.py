# SPDX-License-Identifier: Apache-2.0
"""What a person or a program may do to a run, from any thread: pause, stop, resume, cancel, e-stop, hand over, answer.

Rule: nothing is done here and now. The run does it on its own thread, in its turn; an e-stop overtakes. No order is
refused for what it gives as `by`, which is for people.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.event import Event, Origin
from rai_missions.given import check_event, check_given, given_names
from rai_missions.journal.json_values import to_json
from rai_missions.runtime.control_handover import Handovers
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.scheduler import Scheduler

__all__ = ("RunCommands",)


class RunCommands:
    """What a person or another program may do to a run; each from any thread, each an event in the journal.

    Args:
        scheduler: The run's.
        control: Who holds control.
        handovers: How control is handed over.
    """

    def __init__(self, scheduler: Scheduler, control: Control, handovers: Handovers) -> None:
        self._scheduler, self._control, self._handovers = scheduler, control, handovers
        self.closed = ""
        """Why every door takes only what ends something; empty where it takes all. The node's lifecycle sets it."""

    def pause(self, by: str = "operator") -> None:
        self._command("pause", by)

    def stop(self, by: str = "operator") -> None:
        """Pause, and end also the goals that a pause would keep."""
        self._command("stop", by)

    def resume(self, by: str = "operator") -> None:
        self._command("resume", by)

    def cancel(self, by: str = "operator") -> None:
        self._command("cancel", by)

    def kill(self, by: str = "operator") -> None:
        self.post_urgent(Event("kill", self._scheduler.now(), {"by": str(by)}, "command"))

    def control(self, to: str, by: str = "operator", role: Origin = "operator") -> str:
        """Ask for control to change its holder; returns why it may not, or empty.

        Args:
            to: Who is to have it.
            by: Who asks, for people.
            role: Whose request it is, by the door through which it came.
        """
        why = self._control.refuses(to, role)
        if not why:
            self.call_soon(lambda: self._hand_over(to, by, role))
        return why

    def _hand_over(self, to: str, by: str, role: Origin) -> None:
        if not self._control.request(to, role):
            self._handovers.hand_over(to, by, role)

    def answer(
        self, number: int, option: str, parameters: Mapping[str, Any] | None = None, by: str = "operator"
    ) -> None:
        """Answer an open question.

        Raises:
            UsageError: What is given is no number of a question, no name or no parameters.
        """
        check_given(option, str, "an answer", "the name of an option")
        given = given_names({} if parameters is None else parameters, "parameters", "values")
        data = {"option": option, "parameters": dict(given), "by": str(by)}
        self.post(Event(str(by), self._scheduler.now(), data, "proposal", number))

    def post(self, event: Event) -> None:
        """Something has happened outside.

        Raises:
            UsageError: It is no event, or no journal could hold its data.
        """
        check_event(event, "a run")
        to_json(event.data)
        self._scheduler.post(event)

    def post_urgent(self, event: Event) -> None:
        """Post an event that is taken next, whatever waits, and whatever its data are.

        Raises:
            UsageError: It is no event.
        """
        check_event(event, "a run")
        self._scheduler.mailbox.post_urgent(event)

    def drop_if(self, is_overdue: Callable[[Event], bool]) -> None:
        """Drop each event that is overdue when it is taken; `is_overdue` answers its sender."""
        self._scheduler.mailbox.drop_if(is_overdue)

    def call_soon(self, do: Callable[[], None]) -> None:
        """Have something done on the run's thread, before its next event."""
        self._scheduler.call_soon(do)

    def _command(self, name: str, by: str) -> None:
        self.post(Event(name, self._scheduler.now(), {"by": str(by)}, "command"))
