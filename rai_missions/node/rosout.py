# SPDX-License-Identifier: Apache-2.0
"""Log lines on `/rosout`, where ROS's own tools look for them: what the mission logs, and what this package does.

Rule: a line leaves without secrets, on the publisher's thread; anyone who logs waits for no one.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rai_missions.engine.step import LogLine, SayAloud, Step
from rai_missions.errors import raised_text
from rai_missions.redaction import cut
from rai_missions.runtime.effects import MISSION_LINE

__all__ = ("LOG", "LogLines", "lines_of")

LOG = "rcl_interfaces/msg/Log"
LONGEST = 4_000
"""Characters of a line."""
LEVELS = (50, 40, 30, 20, 10)
"""The levels of rcl_interfaces/msg/Log, which are Python's."""
PACKAGE = "rai_missions"


class LogLines(logging.Handler):
    """Hands over what this package logs, from the level on that the program's logging is set to.

    Args:
        name: The node's, as ROS names its logger: `farm.tractor`.
        on_line: Receives the fields of each line; from any thread, and returns at once.
    """

    def __init__(self, name: str, on_line: Callable[[dict[str, Any]], None]) -> None:
        super().__init__()
        self._name, self._on_line = name, on_line

    def open(self) -> None:
        """Begin."""
        logging.getLogger(PACKAGE).addHandler(self)

    def close(self) -> None:
        logging.getLogger(PACKAGE).removeHandler(self)
        super().close()

    def emit(self, record: logging.LogRecord) -> None:
        """Hand over a line; where no one else takes it, it goes where Python's last resort leads, as without this."""
        last = logging.lastResort
        if last is not None and record.levelno >= last.level and not self._has_company():
            last.handle(record)
        if getattr(record, MISSION_LINE, False):
            return  # it is published with its step
        try:
            raised = record.exc_info[1] if record.exc_info else None
            text = cut(record.getMessage() + (f": {raised_text(raised)}" if raised else ""), LONGEST)
            place = {"file": Path(record.pathname).name, "function": record.funcName or "", "line": record.lineno}
            self._on_line(line_of(self._name, record.levelno, text, record.created) | place)
        except Exception:  # noqa: BLE001 - as Python has it: who logs is not disturbed
            self.handleError(record)

    def _has_company(self) -> bool:
        others = [*logging.getLogger(PACKAGE).handlers, *logging.getLogger().handlers]
        return any(not isinstance(each, LogLines) for each in others)


def line_of(name: str, level: int, text: str, at: float) -> dict[str, Any]:
    """The fields of a `rcl_interfaces/msg/Log`.

    Args:
        name: The logger's.
        level: As Python counts; the next lower of ROS's is taken.
        text: The line.
        at: Wall time, in seconds since 1970.
    """
    known = next((each for each in LEVELS if each <= level), LEVELS[-1])
    return {"stamp": at, "level": known, "name": name, "msg": text, "file": "", "function": "", "line": 0}


def lines_of(step: Step, name: str) -> list[dict[str, Any]]:
    """What a step of the mission logs and speaks."""
    texts = [
        each.text if isinstance(each, LogLine) else f"speaks: {each.text}"
        for each in step.effects
        if isinstance(each, LogLine | SayAloud)
    ]
    return [line_of(name, logging.INFO, cut(text, LONGEST), time.time()) for text in texts]
