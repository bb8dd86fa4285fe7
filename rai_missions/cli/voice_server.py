# SPDX-License-Identifier: Apache-2.0
"""Ears and voice on ROS for `rai-missions voice`: agents of their own, next to a mission in another process."""

from __future__ import annotations

import itertools
import sys

from rai_missions.agents.runner import AgentRunner
from rai_missions.agents.text_to_speech import TextToSpeech
from rai_missions.agents.voice_recognition import VoiceRecognition
from rai_missions.cli.sound import line_of
from rai_missions.connectors.hri.connector import TO_HUMAN, HRIConnector
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.sound.connector import SoundConnector
from rai_missions.voice.listener import Transcript
from rai_missions.voice.setup import ListenNames
from rai_missions.voice.spoken_text import SpokenEnd, SpokenText

__all__ = ("serve_voice",)


def serve_voice(sound: SoundConnector, names: ListenNames, *, voice: str, domain: int | None) -> int:
    """Listen and speak until an interrupt; returns the exit status.

    Args:
        sound: Microphone and speaker.
        names: Which recognisers and which wake word.
        voice: By name.
        domain: The ROS domain; None is that of `ROS_DOMAIN_ID`.

    Raises:
        UsageError: A recogniser is not installed.
        ConnectorError: There is no such device, or ROS cannot carry the messages.
    """
    from rai_missions.connectors.ros2 import open_connector

    connector = open_connector({} if domain is None else {"domain_id": domain})
    hri = HRIConnector(connector)
    texts, numbers = dict[str, str](), itertools.count(1)

    def show_end(key: str, how: SpokenEnd) -> None:
        print(f"robot ({how}): {texts.pop(key)}", flush=True)

    speech = TextToSpeech(sound, voice=voice, on_end=show_end, on_fault=_warn)

    def speak(message: HRIMessage) -> None:
        if message.text:
            texts[key := str(next(numbers))] = message.text
            speech.speak(SpokenText(key, message.text))

    def take(transcript: Transcript) -> None:
        speech.resume(cut=bool(transcript.text))
        if transcript.text:
            print(line_of(transcript), flush=True)

    recognition = VoiceRecognition(
        sound, hri, names=names, on_transcript=take, on_present=speech.interrupt, on_fault=_warn
    )
    agents = AgentRunner({"voice": speech, "recognition": recognition}, connector=connector, name="speech")
    try:
        connector.start()
        agents.run()
        hri.listen(TO_HUMAN, speak)
        hri.listen_to_voice_commands(speech.steer)
        recognition.wait_ready()
        sound.start()
        print("ready; Ctrl-C ends it", flush=True)
        return agents.serve()
    except KeyboardInterrupt:
        return 0
    finally:
        hri.close()
        agents.stop()
        sound.stop()
        connector.stop()


def _warn(why: str) -> None:
    print(f"rai-missions voice: {why}", file=sys.stderr, flush=True)
