# SPDX-License-Identifier: Apache-2.0
"""Ears and voice on ROS for `rai-missions voice`: agents of their own, next to a mission in another process."""

from __future__ import annotations

from rai_missions.agents.runner import AgentRunner
from rai_missions.agents.text_to_speech import TextToSpeech
from rai_missions.agents.voice_recognition import VoiceRecognition
from rai_missions.cli.sound import line_of
from rai_missions.cli.speech_faults import SpeechFaults
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, HRIConnector
from rai_missions.connectors.sound.connector import SoundConnector
from rai_missions.voice.listener import Transcript
from rai_missions.voice.setup import ListenNames
from rai_missions.voice.spoken_text import SpokenEnd

__all__ = ("serve_voice",)

LAST_WORDS_S = 20.0
"""A mission's end is spoken whole, although the programs next to it end with it."""


def serve_voice(
    sound: SoundConnector, names: ListenNames, *, voice: str, language: str, domain: int | None, below: str
) -> int:
    """Listen and speak until an interrupt; returns the exit status.

    Args:
        sound: Microphone and speaker.
        names: Which recognisers and which wake word.
        voice: By name.
        language: Of what is spoken.
        domain: The ROS domain; None is that of `ROS_DOMAIN_ID`.
        below: What the robot's topics begin with: `/alpha`.

    Raises:
        UsageError: A recogniser is not installed.
        ConnectorError: There is no such device, or ROS cannot carry the messages.
    """
    from rai_missions.connectors.ros2 import open_connector

    connector = open_connector({} if domain is None else {"domain_id": domain})
    hri, faults = HRIConnector(connector), SpeechFaults("voice")
    speech = TextToSpeech(
        sound,
        hri,
        topic=below + TO_HUMAN,
        voice=voice,
        language=language,
        on_message_end=_show_end,
        on_fault=faults.take,
        last_words_s=LAST_WORDS_S,
    )

    def take(transcript: Transcript) -> None:
        speech.resume(cut=bool(transcript.text))
        if transcript.text:
            print(line_of(transcript, names), flush=True)

    recognition = VoiceRecognition(
        sound,
        hri,
        topic=below + FROM_HUMAN,
        names=names,
        on_transcript=take,
        on_present=speech.interrupt,
        on_fault=faults.take,
    )
    agents = AgentRunner({"voice": speech, "recognition": recognition}, connector=connector, name="speech")
    try:
        connector.start()
        agents.run()
        speech.wait_ready()
        recognition.wait_ready()
        faults.begin()
        sound.start()
        print("ready; Ctrl-C ends it", flush=True)
        return agents.serve()
    finally:
        hri.close()
        agents.stop()
        sound.stop()
        connector.stop()


def _show_end(text: str, how: SpokenEnd) -> None:
    print(f"robot ({how}): {text}", flush=True)
