# SPDX-License-Identifier: Apache-2.0
"""How agents fare, as `diagnostic_msgs` has it: OK, WARN, ERROR, and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.agents.agent import AgentHealth
from rai_missions.plain_data import carried
from rai_missions.redaction import cut

__all__ = ("DIAGNOSTICS", "DIAGNOSTIC_ARRAY", "ERROR", "OK", "WARN", "diagnostics_of")

OK, WARN, ERROR = 0, 1, 2
DIAGNOSTICS, DIAGNOSTIC_ARRAY = "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"
LEVELS = {"ready": OK, "running": OK, "ended": OK, "stopped": WARN, "failed": ERROR, "died": ERROR, "hangs": ERROR}
LONGEST = 300


def diagnostics_of(name: str, agents: Mapping[str, AgentHealth], *, at: float) -> dict[str, Any]:
    """The fields of a `diagnostic_msgs/msg/DiagnosticArray`: one status an agent.

    Args:
        name: Of those together, before each agent's own.
        agents: Name → how it fares.
        at: Wall time, in seconds since 1970.
    """
    status = [
        {
            "level": LEVELS[health.state],
            "name": f"{name}: {agent}",
            "message": f"{health.state}: {cut(health.why, LONGEST)}" if health.why else health.state,
            "hardware_id": "",
            "values": [{"key": key, "value": cut(value, LONGEST)} for key, value in health.values.items()],
        }
        for agent, health in agents.items()
    ]
    report: dict[str, Any] = carried({"header": {"stamp": at}, "status": status})
    return report
