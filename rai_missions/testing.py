# SPDX-License-Identifier: Apache-2.0
"""Contracts and doubles for those who write connectors, agents and missions; each is loaded when it is first used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.agents.contract import check_agent
    from rai_missions.answerers.contract import QUESTION, ReplyCollector, answer_fault, check_answerer
    from rai_missions.answerers.script import ScriptAnswerer
    from rai_missions.answerers.test_answerers import ChatteringAnswerer, LateAnswerer, RaisingAnswerer, SilentAnswerer
    from rai_missions.answerers.test_models import (
        BabblingModel,
        HangingModel,
        LyingModel,
        RaisingModel,
        ScriptedModel,
        SilentModel,
        ToolFloodModel,
        WordyModel,
        call,
    )
    from rai_missions.connectors.chaos import ChaosConnector, Rates
    from rai_missions.connectors.contract import Inbox, PatientServer, check_connector
    from rai_missions.connectors.hri.contract import check_hri_connector
    from rai_missions.connectors.sound.contract import check_sound_connector
    from rai_missions.connectors.sound.room import RoomSound
    from rai_missions.conversation.contract import check_conversation, play_conversation
    from rai_missions.engine.contract import check_activity
    from rai_missions.guards.contract import check_guard
    from rai_missions.replay.play.passage import let_time_pass
    from rai_missions.voice.contract import check_recogniser, check_voice
    from rai_missions.worlds.contract import check_world

__all__ = (
    "QUESTION",
    "BabblingModel",
    "ChaosConnector",
    "ChatteringAnswerer",
    "HangingModel",
    "Inbox",
    "LateAnswerer",
    "LyingModel",
    "PatientServer",
    "RaisingAnswerer",
    "RaisingModel",
    "Rates",
    "ReplyCollector",
    "RoomSound",
    "ScriptAnswerer",
    "ScriptedModel",
    "SilentAnswerer",
    "SilentModel",
    "ToolFloodModel",
    "WordyModel",
    "answer_fault",
    "call",
    "check_activity",
    "check_agent",
    "check_answerer",
    "check_connector",
    "check_conversation",
    "check_guard",
    "check_hri_connector",
    "check_recogniser",
    "check_sound_connector",
    "check_voice",
    "check_world",
    "let_time_pass",
    "play_conversation",
)  # fmt: skip

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "agents.contract": ("check_agent",),
            "answerers.contract": ("QUESTION", "ReplyCollector", "answer_fault", "check_answerer"),
            "answerers.test_models": (
                "BabblingModel",
                "HangingModel",
                "LyingModel",
                "RaisingModel",
                "ScriptedModel",
                "SilentModel",
                "ToolFloodModel",
                "WordyModel",
                "call",
            ),
            "answerers.test_answerers": ("ChatteringAnswerer", "LateAnswerer", "RaisingAnswerer", "SilentAnswerer"),
            "answerers.script": ("ScriptAnswerer",),
            "connectors.chaos": ("ChaosConnector", "Rates"),
            "connectors.contract": ("Inbox", "PatientServer", "check_connector"),
            "connectors.hri.contract": ("check_hri_connector",),
            "connectors.sound.contract": ("check_sound_connector",),
            "connectors.sound.room": ("RoomSound",),
            "conversation.contract": ("check_conversation", "play_conversation"),
            "engine.contract": ("check_activity",),
            "guards.contract": ("check_guard",),
            "replay.play.passage": ("let_time_pass",),
            "voice.contract": ("check_recogniser", "check_voice"),
            "worlds.contract": ("check_world",),
        },
    )
