# SPDX-License-Identifier: Apache-2.0
"""How a mission fares, as `diagnostic_msgs` has it: OK, WARN, ERROR, and why.

Rule: a level is worked out from what is published anyway; nothing is remembered here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.agents.health import ERROR, OK, WARN
from rai_missions.engine.activities.goal_ledger import may_move
from rai_missions.node.status_message import StatusMessage
from rai_missions.redaction import cut
from rai_missions.runtime.readings import SourceState, offset_words

__all__ = ("Symptoms", "array_of", "level")


class Symptoms(NamedTuple):
    """What is wrong around a mission, next to its status."""

    stale: Sequence[str] = ()
    """Keys of the robot that are older than they may be, while the mission runs."""
    strangers: int = 0
    """Other nodes that have spoken under the same name."""
    sources: Mapping[str, SourceState] = {}
    """Robot key → what is known of the readings of its source."""
    rivals: Sequence[str] = ()
    """Of each other mission that commands the robot, a sentence."""

    def misread(self) -> str:
        """What is received from sources and not understood."""
        return ", ".join(f"{key}: {state.misread}" for key, state in self.sources.items() if state.misread)

    def offsets(self) -> str:
        """The sources whose stamps are off, and by how much."""
        off = {key: state.offset_s for key, state in self.sources.items()}
        return ", ".join(f"{key}: {offset_words(offset_s)}" for key, offset_s in off.items() if offset_s is not None)


HEALTHY = Symptoms()


def level(status: StatusMessage, symptoms: Symptoms = HEALTHY) -> tuple[int, str]:
    """The level and the sentence."""
    if status.fault:
        return ERROR, status.fault
    if status.mode in ("failed", "aborted"):
        moving = f"; {may_move(status.open_goals)}" if status.open_goals else ""
        return ERROR, f"{status.mode}: {status.why}{moving}"
    if status.open_goals:
        return ERROR, may_move(status.open_goals)
    if symptoms.strangers:
        return WARN, f"another node is called {status.node} too; give one of them another name with --node"
    if symptoms.rivals:
        return WARN, symptoms.rivals[0]
    if status.mode in ("paused", "canceling"):
        return WARN, status.mode
    if status.waits:
        return WARN, status.waits
    if status.questions:
        asked = status.questions[0].question
        return WARN, cut(f"question {asked.number} waits for {asked.asked}: {asked.text}", 300)
    if symptoms.stale:
        return WARN, f"not fresh: {', '.join(symptoms.stale)}"
    if misread := symptoms.misread():
        return WARN, cut(f"received and not understood: {misread}", 300)
    if offsets := symptoms.offsets():
        return WARN, offsets
    return OK, status.mode


def array_of(status: StatusMessage, symptoms: Symptoms, *, at: float, robot: str = "") -> dict[str, Any]:
    """The fields of a `diagnostic_msgs/msg/DiagnosticArray`.

    Args:
        status: What the mission is doing.
        symptoms: What is wrong around it.
        at: Wall time, in seconds since 1970.
        robot: The robot's name.
    """
    found, message = level(status, symptoms)
    values = {
        "mission": f"{status.mission} {status.version}".strip(),
        "run": status.run,
        "lifecycle": status.lifecycle,
        "mode": status.mode,
        "control": status.control,
        "active": ", ".join(status.active),
        "revision": str(status.revision),
        "stale": ", ".join(symptoms.stale),
        "clock offsets": symptoms.offsets(),
        "not understood": cut(symptoms.misread(), 1000),
        "instance": status.instance,
        "rivals": cut("; ".join(symptoms.rivals), 1000),
        "open_goals": may_move(status.open_goals),
    }
    diagnostic = {
        "level": found,
        "name": f"{status.node}: mission",
        "message": message,
        "hardware_id": robot,
        "values": [{"key": key, "value": value} for key, value in values.items()],
    }
    return {"header": {"stamp": at}, "status": [diagnostic]}
