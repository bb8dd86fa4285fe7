# SPDX-License-Identifier: Apache-2.0
"""Conversation with a robot that works: what is asked, ordered, confirmed and reported, as a pure state machine.

No threads, no clocks, no models: values come in with their instant, and values go out. Agents build the rest around it.

Its parts, each above the next: `dialogue` drives the others; `claims` judges the text of a model, `answers` puts what
is known into words; `grammar` reads words; `language` is the data of both ways.

Imports `engine`, `mission`, `model`, `planning`, `profile` and `voice`, and the modules of the root.
"""

from rai_missions.conversation.dialogue.dialogue import Dialogue
from rai_missions.conversation.inputs import DocumentQuote, FoundQuotes, ModelText, OrderEnd, SpeechEnd, Utterance
from rai_missions.conversation.outputs import (
    AskModel,
    DropModel,
    LookUp,
    Order,
    Output,
    Silence,
    Speech,
    TalkNote,
    TalkTurn,
)
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import BuildView, KeyView, MissionView, ProgressView, RunEvent, StatusView

__all__ = (
    "AskModel",
    "BuildView",
    "Dialogue",
    "DocumentQuote",
    "DropModel",
    "FoundQuotes",
    "KeyView",
    "LookUp",
    "MissionView",
    "ModelText",
    "Order",
    "OrderEnd",
    "Output",
    "ProgressView",
    "RunEvent",
    "Settings",
    "Silence",
    "Speech",
    "SpeechEnd",
    "StatusView",
    "TalkNote",
    "TalkTurn",
    "Utterance",
)
