# SPDX-License-Identifier: Apache-2.0
"""Who answers a decision's question: a model, a person, rules, a script; each is loaded when it is first used.

Imports `check`, `connectors`, `embodiment`, `engine`, `guards`, `mission`, `profile` and `tools`, and the modules of
the root. Knows no runner.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.answerers.model.providers import open_model
    from rai_missions.answerers.rules import RulesAnswerer
    from rai_missions.answerers.script import ScriptAnswerer
    from rai_missions.answerers.terminal_operator import OperatorAgent

__all__ = ("DecisionAgent", "OperatorAgent", "RulesAnswerer", "ScriptAnswerer", "open_model")

MODULES = {
    "DecisionAgent": "model.agent",
    "OperatorAgent": "terminal_operator",
    "RulesAnswerer": "rules",
    "ScriptAnswerer": "script",
    "open_model": "model.providers",
}


def __getattr__(name: str) -> Any:
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{MODULES[name]}"), name)
