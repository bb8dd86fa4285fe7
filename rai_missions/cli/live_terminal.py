# SPDX-License-Identifier: Apache-2.0
"""A run on a terminal: the lines scroll by, and below them the current state is shown.

Rule: while a person is asked the terminal is theirs: lines of steps wait until the question is closed.
"""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from rai_missions.cli.progress import Lines, Person, Tone, trimmed
from rai_missions.engine.activities.goal_ledger import may_move
from rai_missions.engine.decision import Answerer, Question
from rai_missions.engine.modes import Mode
from rai_missions.engine.step import Ask, Step
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result

__all__ = ("Screen",)

STYLES: Mapping[Tone, str] = {
    "plain": "", "question": "cyan", "refused": "bold yellow", "remark": "yellow", "ignored": "dim",
    "succeeded": "bold green", "failed": "bold red", "aborted": "bold red", "canceled": "bold yellow",
}  # fmt: skip
MODE_STYLES: Mapping[Mode, str] = {
    "ready": "bold green",
    "running": "bold green",
    "paused": "bold yellow",
    "canceling": "bold yellow",
    "succeeded": STYLES["succeeded"],
    "failed": STYLES["failed"],
    "aborted": STYLES["aborted"],
    "canceled": STYLES["canceled"],
}
MOST_HELD = 200
"""Lines that wait while a person is asked; of more, the last ones are printed."""


class Screen(Lines):
    """Prints a run as `Lines` does, in colour, above a live foot.

    Args:
        mission: Whose run it is.
        out: The terminal.
        verbose: Steps that changed nothing too.
    """

    def __init__(self, mission: Mission, out: TextIO, *, verbose: bool = False) -> None:
        super().__init__(mission, io.StringIO(), verbose=verbose)
        self._console = Console(file=out, highlight=False)
        self._live: Live | None = None
        self._status: Status | None = None
        self._is_asked = self._holds = False
        """Whether a person is asked here, and whether what is printed now has to wait for that."""
        self._held: deque[tuple[str, Tone]] = deque(maxlen=MOST_HELD)
        self._left_out = 0

    def lend(self, person: Person) -> Answerer:
        """A person who is asked on this terminal: the foot is removed first."""
        return _Borrower(self._hide, super().lend(person))

    def close(self) -> None:
        self._hide()
        self._release()
        super().close()

    def status(self, status: Status) -> None:
        """The run's mode, control or states have changed, or which goals may still move the robot."""
        super().status(status)
        self._status = status

    def step(self, step: Step) -> None:
        """One step; while a person is asked, its lines wait."""
        self._holds = self._is_asked
        super().step(step)
        self._holds = False
        questions = self._view.questions if self._view is not None else ()
        self._is_asked = any(self._is_for_a_person(question) for question in questions)
        if self._is_asked:
            self._hide()
            return
        self._release()
        if self._view is not None:
            self._show(self._foot(step.at))

    def _is_for_a_person(self, question: Question) -> bool:
        """Whether a question is asked on this terminal, by its own prompt."""
        return question.asked == "operator" and bool(self._persons)

    def _release(self) -> None:
        """Print what has waited."""
        held, left_out = list(self._held), self._left_out
        self._held.clear()
        self._left_out = 0
        if left_out:
            self._print(f"{'':13}meanwhile, {left_out} more lines; the journal has all steps", "remark")
        for line, tone in held:
            self._print(line, tone)

    def _show(self, foot: Group) -> None:
        if self._live is None:  # a new one each time: a stopped one would clear the lines above it
            self._live = Live(foot, console=self._console, refresh_per_second=8, transient=True)
            self._live.start()
        self._live.update(foot)

    def _hide(self) -> None:
        live, self._live = self._live, None
        if live is not None:
            live.stop()

    def end(self, result: Result, picture: str = "") -> None:
        self._hide()
        self._release()
        super().end(result, picture)

    def _question(self, ask: Ask) -> None:
        if self._is_for_a_person(ask.question):
            return
        super()._question(ask)

    def _print(self, line: str, tone: Tone = "plain") -> None:
        if self._holds:
            self._left_out += len(self._held) == MOST_HELD
            self._held.append((line, tone))
            return
        self._console.print(Text(line, style=STYLES[tone]), soft_wrap=True)

    def _foot(self, at: float) -> Group:
        view, status = self._view, self._status
        assert view is not None
        head = Text(f"{at:9.2f} s  ", style="bold")
        if status is not None:
            head.append(f"{status.mode}  ", style=MODE_STYLES[status.mode])
        head.append(" › ".join(name for _, name, _ in self._mission.walk() if name in view.active), style="bold")
        head.append(f"   control: {status.control if status else ''}", style="dim")
        if status is not None and status.waits:
            head.append(f"\n{'':13}{status.waits}", style="bold yellow")
        if status is not None and status.open_goals:
            head.append(f"\n{'':13}{trimmed(may_move(status.open_goals), 400)}", style="bold red")
        facts = Table.grid(padding=(0, 2))
        for key, entry in sorted(view.board.items()):
            if self._mission.blackboard[key].source == "robot":
                text = Text(trimmed(entry.value, 60))  # a string would be read as markup
                facts.add_row(Text(f"  {key}", style="dim"), text, f"{at - entry.at:.1f} s old")
        return Group(Text(""), head, facts)


class _Borrower:
    """Asks once the terminal is free."""

    def __init__(self, hide: Callable[[], None], person: Answerer) -> None:
        self._hide, self._person = hide, person

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        self._hide()
        self._person.ask(question, answer)

    def withdraw(self, number: int) -> None:
        self._person.withdraw(number)
