# SPDX-License-Identifier: Apache-2.0
"""A dialogue: the state machine that sentences, a run's status and a model's text drive, and that speaks and orders.

Rule: it never waits. Each input returns at once with all outputs that follow from it, in the order to perform them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from rai_missions.conversation.inputs import ModelText, OrderEnd, SpeechEnd, Utterance
from rai_missions.conversation.outputs import Output, TalkTurn
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import StatusView

__all__ = ("Dialogue",)

SETTINGS, NO_RUN = Settings(), StatusView()


class Dialogue:
    """One conversation of a robot with all who talk to it. Not for several threads at once.

    Args:
        settings: What the profile sets.
        view: The run as it is now.
    """

    def __init__(self, settings: Settings = SETTINGS, view: StatusView = NO_RUN) -> None:
        self.settings, self.view = settings, view

    @property
    def wake_at(self) -> float | None:
        """The instant at which `on_time` has something to do, on the dialogue's clock; None: nothing is due."""
        return None

    @property
    def history(self) -> tuple[TalkTurn, ...]:
        """The last turns, oldest first; bounded by the settings."""
        return ()

    def on_utterance(self, utterance: Utterance, view: StatusView) -> tuple[Output, ...]:
        """A person's sentence.

        Args:
            utterance: The sentence, with the role of its door.
            view: The run at this moment: ages and states are as new as this.
        """
        return ()

    def on_status(self, view: StatusView, at: float) -> tuple[Output, ...]:
        """The run has changed: each change of `Status`, of the open question, and of the run itself."""
        self.view = view
        return ()

    def on_mission_speech(self, text: str, at: float) -> tuple[Output, ...]:
        """The mission's own effect `say`."""
        return ()

    def on_model(self, reply: ModelText) -> tuple[Output, ...]:
        """A piece of a model's reply."""
        return ()

    def on_speech_end(self, end: SpeechEnd) -> tuple[Output, ...]:
        """A speech has ended."""
        return ()

    def on_order_end(self, end: OrderEnd) -> tuple[Output, ...]:
        """An order was carried out, or refused by what should do so."""
        return ()

    def on_speaker(self, *, is_alive: bool, at: float) -> tuple[Output, ...]:
        """The speaker died, or speaks again: what it did not speak follows then, marked as repeated."""
        return ()

    def on_time(self, at: float) -> tuple[Output, ...]:
        """Time has passed: confirmations expire, a model is not waited for any longer, an owed report follows."""
        return ()

    def snapshot(self) -> dict[str, Any]:
        """What must outlive the process, as JSON: which reports were spoken, and which are owed."""
        return {}

    @classmethod
    def restore(cls, saved: Mapping[str, Any], settings: Settings = SETTINGS, view: StatusView = NO_RUN) -> Self:
        """The dialogue of a process that ended: nothing is confirmed or queued; owed reports follow, as repeated."""
        return cls(settings, view)
