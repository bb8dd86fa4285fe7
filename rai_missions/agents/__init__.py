# SPDX-License-Identifier: Apache-2.0
"""The paper's agents, which live between `run()` and `stop()`; each is loaded when it is first used.

Imports `answerers`, `check`, `connectors`, `conversation`, `embodiment`, `engine`, `guards`, `journal`, `mission`,
`planning`, `profile`, `recording`, `replay`, `runtime`, `states`, `tools`, `voice` and `worlds`, and the modules of the
root.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.agents.agent import Agent, AgentHealth
    from rai_missions.agents.hri_langchain import from_langchain, to_langchain
    from rai_missions.agents.mission import MissionAgent, run
    from rai_missions.agents.process_agent import ProcessAgent
    from rai_missions.agents.runner import AgentRunner, exit_with
    from rai_missions.agents.text_to_speech import TextToSpeech
    from rai_missions.agents.voice_recognition import VoiceRecognition

__all__ = (
    "Agent",
    "AgentHealth",
    "AgentRunner",
    "MissionAgent",
    "ProcessAgent",
    "TextToSpeech",
    "VoiceRecognition",
    "exit_with",
    "from_langchain",
    "run",
    "to_langchain",
)

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "agent": ("Agent", "AgentHealth"),
            "hri_langchain": ("from_langchain", "to_langchain"),
            "mission": ("MissionAgent", "run"),
            "process_agent": ("ProcessAgent",),
            "runner": ("AgentRunner", "exit_with"),
            "text_to_speech": ("TextToSpeech",),
            "voice_recognition": ("VoiceRecognition",),
        },
    )
