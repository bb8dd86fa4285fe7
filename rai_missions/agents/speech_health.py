# SPDX-License-Identifier: Apache-2.0
"""How the processes of an agent that listens or speaks fare."""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.agents.agent import AgentHealth
from rai_missions.voice.process import SpeechProcess

__all__ = ("health_of",)


def health_of(processes: Sequence[SpeechProcess]) -> AgentHealth:
    """`died` where one cannot be opened; else `running`, with how often each was started again."""
    restarts = {f"{each.sort} {each.name}": f"{each.restarts} restarts" for each in processes}
    for process in processes:
        if process.absent:
            return AgentHealth("died", process.absent, restarts)
    return AgentHealth("running", values=restarts)
