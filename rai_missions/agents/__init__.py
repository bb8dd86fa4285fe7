# SPDX-License-Identifier: Apache-2.0
"""The paper's agents, which live between `run()` and `stop()`; each is loaded when it is first used.

Imports `answerers`, `check`, `connectors`, `embodiment`, `engine`, `journal`, `mission`, `profile`, `recording`,
`replay`, `runtime` and `worlds`, and the modules of the root.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.agents.agent import Agent
    from rai_missions.agents.mission import MissionAgent, run

__all__ = ("Agent", "MissionAgent", "run")

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(globals(), {"agent": ("Agent",), "mission": ("MissionAgent", "run")})
