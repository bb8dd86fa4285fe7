# SPDX-License-Identifier: Apache-2.0
"""The terminal of `run --talk`: a line to write on beneath what the run reports, and what the robot replies.

Rule: who writes here began the program, and is its operator. Reading happens on a thread of its own; the run never
waits for a person.
"""

from __future__ import annotations

import io
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

from rich.console import Console
from rich.text import Text

from rai_missions.agents.talk.doors import TalkLine
from rai_missions.answerers.terminal_input import LineReader
from rai_missions.cli.live_terminal import STYLES
from rai_missions.cli.progress import Lines, Tone, trimmed
from rai_missions.connectors.readable import readable
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import printable

__all__ = ("LineInput", "TalkLines", "TypedLines", "open_typing")

WAYS = {"rules": "robot", "model": "robot, the model thinks", "documents": "robot, quoting", "unknown": "robot"}
UNHEARD = {"cut": " (interrupted)", "failed": " (no one could be reached)"}
TakeLine = Callable[[str, float], str]
"""Takes a line, and how many seconds ago it came at the earliest; why it does not, or empty."""


def line_words(line: TalkLine) -> str:
    """A line of the conversation in one line of text."""
    who = WAYS.get(line.way, "robot") if line.by == "robot" else " ".join(filter(None, (line.by, line.author)))
    door = f" ({line.channel})" if line.by != "robot" else ""
    return f"{who}{door}: {trimmed(printable(line.text), 2_000)}{UNHEARD.get(line.spoken, '')}"


class Out(io.TextIOBase):
    """Standard output as it is now: while a line is being written on, what is printed goes above it."""

    def write(self, text: str) -> int:
        return sys.stdout.write(text)

    def flush(self) -> None:
        sys.stdout.flush()


class TalkLines(Lines):
    """Prints a run line by line, in colour, and what is talked in between.

    Args:
        mission: Whose run it is.
        verbose: Steps that changed nothing too.
        colours: Whether it is a terminal.
    """

    def __init__(self, mission: Mission, *, verbose: bool = False, colours: bool = True) -> None:
        target: Any = Out()
        super().__init__(mission, target, verbose=verbose)
        self._console = Console(file=target, highlight=False, force_terminal=colours or None, width=None)
        self._mine = threading.Lock()

    def talk(self, line: TalkLine) -> None:
        """A line of the conversation; what was typed here is on the screen already."""
        if line.by != "robot" and line.channel == "terminal":
            return
        style = "bold cyan" if line.way in ("model", "documents") else "bold" if line.by == "robot" else "cyan"
        with self._mine:
            self._console.print(Text(f"{'':4}{line_words(line)}", style=style), soft_wrap=True)

    def remark(self, words: str) -> None:
        """A line of the program's own."""
        self._print(f"{'':4}{trimmed(words)}", "remark")

    def foot(self) -> str:
        """The state of the run, for the bottom of the screen."""
        view = self._view
        if view is None:
            return ""
        states = " › ".join(name for _, name, _ in self._mission.walk() if name in view.active)
        return f"{view.now():9.2f} s  {view.outcome or view.mode}  {states}  control: {view.holder}"

    def _print(self, line: str, tone: Tone = "plain") -> None:
        with self._mine:
            self._console.print(Text(line, style=STYLES[tone]), soft_wrap=True)


class TypedLines(NamedTuple):
    """Where typed lines go."""

    receive: TakeLine
    refuse: Callable[[str], object]
    """Shows why a line was not taken."""
    on_end: Callable[[], object]
    """Called once nothing more is typed."""
    wait_answered: Callable[[], object]
    """Waits until what was taken is answered."""


class LineInput:
    """Reads what is typed, line by line, until `stop`.

    Args:
        to: Where the lines go.
    """

    def __init__(self, to: TypedLines) -> None:
        self._to = to
        self._thread = threading.Thread(target=self._work, name="typing", daemon=True)
        self._is_over = False
        self._came_at = -math.inf
        """When the last line came, at the earliest."""

    def start(self) -> None:
        self._thread.start()

    def stop(self, within_s: float = 1.0) -> None:
        """Read no more."""
        self._is_over = True
        self._wake()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def _wake(self) -> None:
        """End the reading that is under way."""

    def _work(self) -> None:
        try:
            while not self._is_over and (text := self._line()) is not None:
                waited_s = time.monotonic() - self._came_at
                if text.strip() and (why := self._to.receive(text.strip(), waited_s)):
                    self._to.refuse(why)
        except (EOFError, OSError, ValueError):
            return
        finally:
            self._to.on_end()

    def _line(self) -> str | None:
        raise NotImplementedError


class PlainInput(LineInput):
    """Whole lines from a terminal or a pipe, edited by the terminal itself.

    A pipe holds a script: each of its lines is taken once the one before is answered. A person's is taken at once.
    """

    def __init__(self, to: TypedLines, fd: int) -> None:
        super().__init__(to)
        self._reader = LineReader(fd)
        self._is_script = not os.isatty(fd)

    def _wake(self) -> None:
        self._reader.wake()

    def _line(self) -> str | None:
        text = self._reader.line(math.inf)
        self._came_at = self._reader.came_at
        if self._is_script:
            self._to.wait_answered()
        return text


class EditedInput(LineInput):
    """A line with history and editing, beneath what is printed, above the state of the run.

    Args:
        foot: The state of the run.
    """

    def __init__(self, to: TypedLines, foot: Callable[[], str]) -> None:
        super().__init__(to)
        from prompt_toolkit import PromptSession
        from prompt_toolkit.key_binding import KeyBindings

        keys = KeyBindings()
        keys.add("c-@")(_end_of_input)
        self._session: Any = PromptSession("> ", bottom_toolbar=foot, refresh_interval=0.25, key_bindings=keys)

    def _wake(self) -> None:
        app = self._session.app
        if app.is_running and app.loop is not None:
            with suppress(RuntimeError):
                app.loop.call_soon_threadsafe(lambda: app.exit(exception=EOFError()) if app.is_running else None)

    def _work(self) -> None:
        from prompt_toolkit.patch_stdout import patch_stdout

        with patch_stdout(raw=True):
            super()._work()

    def _line(self) -> str | None:
        is_ahead, began_at = self._is_typed_ahead(), self._came_at
        try:
            text = str(self._session.prompt(handle_sigint=False))
            self._came_at = began_at if is_ahead else time.monotonic()
            return text
        except KeyboardInterrupt:  # the key arrives here, and means the program
            os.kill(os.getpid(), signal.SIGINT)
            return ""

    def _is_typed_ahead(self) -> bool:
        """Whether keys were pressed before the line is asked for: it may be no answer to what was shown meanwhile."""
        from prompt_toolkit.input.typeahead import get_typeahead, store_typeahead

        keys = get_typeahead(self._session.input)
        store_typeahead(self._session.input, keys)
        return bool(keys or readable(self._session.input.fileno(), within_s=0.0))


def _end_of_input(event: Any) -> None:
    """Ctrl-D that was pressed before the line was asked for: the terminal that edits hands it over as NUL."""
    if not event.current_buffer.text:
        event.app.exit(exception=EOFError())


def open_typing(to: TypedLines, foot: Callable[[], str]) -> LineInput | None:
    """What reads standard input; None where there is nothing to be read.

    Args:
        to: Where the lines go.
        foot: The state of the run.
    """
    try:
        fd = sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None
    if os.isatty(fd) and sys.stdout.isatty():
        from importlib.util import find_spec

        if find_spec("prompt_toolkit") is not None:
            return EditedInput(to, foot)
    return PlainInput(to, fd)
