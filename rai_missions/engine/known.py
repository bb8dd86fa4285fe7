# SPDX-License-Identifier: Apache-2.0
"""What a run knows from a step on, for those who follow its steps without its chart.

Rule: a step's writes are what it wrote. A migration brings a whole blackboard along, and a process that continues with
a run forgets what the robot must report again: both follow from the step's event.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

from rai_missions.engine.snapshot_json import unpacked
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.keys import Key, Stamped
from rai_missions.plain_data import is_number

__all__ = ("known_from", "migrated")


def migrated(step: Step) -> Mapping[str, Any] | None:
    """The snapshot with which a migrated run begins, for the step that has it; None for any other.

    Raises:
        UsageError: It is none: the journal was altered.
    """
    event = step.event
    if event.kind != "command" or event.name != "migrate" or step.refusal:
        return None
    try:
        was = unpacked(event.data["stands"])
        board = was["board"].values()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        board = (None,)
    if not all(isinstance(entry, Stamped) and is_number(entry.at) for entry in board):
        raise UsageError(
            f"step {step.seq} continues with a snapshot that is none; the journal was altered after the run"
        )
    return cast("Mapping[str, Any]", was)


def known_from(step: Step, keys: Mapping[str, Key]) -> Iterator[tuple[str, Any, float]]:
    """Each key that a step changes, with its value and stamp, in order; a value of None: it is no longer known.

    Args:
        step: The step of the run.
        keys: Those of its mission.

    Raises:
        UsageError: What a migration brings along was altered.
    """
    if (was := migrated(step)) is not None:
        yield from ((key, None, step.at) for key in keys if key not in was["board"])
        yield from ((key, entry.value, entry.at) for key, entry in was["board"].items())
    elif step.event.kind == "command" and step.event.name == "take_up":
        yield from ((name, None, step.at) for name, key in keys.items() if key.must_recur)
    yield from ((key, value, step.stamp_of(key)) for key, value in step.writes)
