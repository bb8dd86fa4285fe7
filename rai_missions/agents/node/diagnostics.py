# SPDX-License-Identifier: Apache-2.0
"""How a mission fares, as `diagnostic_msgs` has it: OK, WARN, ERROR, and why.

Rule: a level is worked out from what is published anyway; nothing is remembered here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rai_missions.agents.node.bulletin import Bulletin
from rai_missions.cut import cut

__all__ = ("ERROR", "OK", "WARN", "array_of", "level")

OK, WARN, ERROR = 0, 1, 2


def level(bulletin: Bulletin, stale: Sequence[str] = (), strangers: int = 0) -> tuple[int, str]:
    """The level and the sentence.

    Args:
        bulletin: What the mission is doing.
        stale: Keys of the robot that are older than they may be, while the mission runs.
        strangers: Other nodes that have spoken under the same name.
    """
    if bulletin.fault:
        return ERROR, bulletin.fault
    if bulletin.mode in ("failed", "aborted"):
        return ERROR, f"{bulletin.mode}: {bulletin.why}"
    if strangers:
        return WARN, f"another node is called {bulletin.node} too; give one of them another name with --node"
    if bulletin.mode in ("paused", "canceling"):
        return WARN, bulletin.mode
    if bulletin.waits:
        return WARN, bulletin.waits
    if bulletin.questions:
        asked = bulletin.questions[0].question
        return WARN, cut(f"question {asked.number} waits for {asked.asked}: {asked.text}", 300)
    if stale:
        return WARN, f"not fresh: {', '.join(stale)}"
    return OK, bulletin.mode


def array_of(bulletin: Bulletin, *, at: float, stale: Sequence[str] = (), strangers: int = 0) -> dict[str, Any]:
    """The fields of a `diagnostic_msgs/msg/DiagnosticArray`.

    Args:
        bulletin: What the mission is doing.
        at: Wall time, in seconds since 1970.
        stale: As for `level`.
        strangers: As for `level`.
    """
    found, message = level(bulletin, stale, strangers)
    values = {
        "mission": f"{bulletin.mission} {bulletin.version}".strip(), "run": bulletin.run,
        "lifecycle": bulletin.lifecycle, "mode": bulletin.mode, "control": bulletin.control,
        "active": ", ".join(bulletin.active), "revision": str(bulletin.revision), "stale": ", ".join(stale),
    }  # fmt: skip
    status = {
        "level": found,
        "name": f"{bulletin.node}: mission",
        "message": message,
        "hardware_id": bulletin.instance,
        "values": [{"key": key, "value": value} for key, value in values.items()],
    }
    return {"header": {"stamp": at}, "status": [status]}
