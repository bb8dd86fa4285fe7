# SPDX-License-Identifier: Apache-2.0
"""The paper's agents, which live between `run()` and `stop()`; each is loaded when it is first used.

Imports `answerers`, `check`, `connectors`, `embodiment`, `engine`, `journal`, `mission`, `profile`, `recording`,
`replay`, `runtime` and `worlds`, and the modules of the root.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rai_missions.agents.agent import Agent
    from rai_missions.agents.mission import MissionAgent, run

__all__ = ("Agent", "MissionAgent", "run")

MODULES = {"Agent": "agent", "MissionAgent": "mission", "run": "mission"}


def __getattr__(name: str) -> Any:
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{MODULES[name]}"), name)
