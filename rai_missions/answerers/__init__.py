# SPDX-License-Identifier: Apache-2.0
"""Who answers a decision's question: a model, a person, rules, a script; each is loaded when it is first used.

Imports `check`, `connectors`, `embodiment`, `engine`, `guards`, `mission`, `profile` and `tools`, and the modules of
the root. Knows no runner.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.answerers.model.providers import open_model
    from rai_missions.answerers.rules import RulesAnswerer
    from rai_missions.answerers.script import ScriptAnswerer
    from rai_missions.answerers.terminal_operator import OperatorAgent

__all__ = ("DecisionAgent", "OperatorAgent", "RulesAnswerer", "ScriptAnswerer", "open_model")

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "model.agent": ("DecisionAgent",),
            "model.providers": ("open_model",),
            "rules": ("RulesAnswerer",),
            "script": ("ScriptAnswerer",),
            "terminal_operator": ("OperatorAgent",),
        },
    )
