# SPDX-License-Identifier: Apache-2.0
"""What a run knows from a step on, for those who follow its steps without its chart.

Rule: a step's writes are what it wrote. A migration brings a whole blackboard along, and a process that continues with
a run forgets what the robot must report again: both follow from the step's event.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.engine.snapshot_json import unpacked
from rai_missions.engine.step import Step
from rai_missions.keys import Key

__all__ = ("known_from", "migrated")


def migrated(step: Step) -> Mapping[str, Any] | None:
    """The snapshot with which a migrated run begins, for the step that has it; None for any other."""
    event = step.event
    is_begin = event.kind == "command" and event.name == "migrate" and not step.refusal
    return unpacked(event.data["stands"]) if is_begin else None


def known_from(step: Step, keys: Mapping[str, Key]) -> Iterator[tuple[str, Any, float]]:
    """Each key that a step changes, with its value and stamp, in order; a value of None: it is no longer known.

    Args:
        step: Of the run.
        keys: Those of its mission.
    """
    if (was := migrated(step)) is not None:
        yield from ((key, None, step.at) for key in keys if key not in was["board"])
        yield from ((key, entry.value, entry.at) for key, entry in was["board"].items())
    elif step.event.kind == "command" and step.event.name == "take_up":
        yield from ((name, None, step.at) for name, key in keys.items() if key.must_recur)
    yield from ((key, value, step.stamp_of(key)) for key, value in step.writes)
