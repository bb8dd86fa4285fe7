# SPDX-License-Identifier: Apache-2.0
"""Whoever answers a question: a model, a person, rules, a script; each is loaded when it is first used."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rai_missions.agents.agent import Agent
    from rai_missions.agents.decision import DecisionAgent
    from rai_missions.agents.mission import MissionAgent, run
    from rai_missions.agents.models import open_model
    from rai_missions.agents.operator import OperatorAgent
    from rai_missions.agents.rules import RulesAnswerer
    from rai_missions.agents.script import ScriptAnswerer

__all__ = (
    "Agent",
    "DecisionAgent",
    "MissionAgent",
    "OperatorAgent",
    "RulesAnswerer",
    "ScriptAnswerer",
    "open_model",
    "run",
)

ROOMS = {
    "Agent": "agent",
    "DecisionAgent": "decision",
    "MissionAgent": "mission",
    "OperatorAgent": "operator",
    "RulesAnswerer": "rules",
    "ScriptAnswerer": "script",
    "open_model": "models",
    "run": "mission",
}


def __getattr__(name: str) -> Any:
    if name not in ROOMS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{ROOMS[name]}"), name)
