# SPDX-License-Identifier: Apache-2.0
"""What `listen` and `speak` do with sound."""

from __future__ import annotations

import json
import sys
import threading
from collections import Counter

from rai_missions.cli.speech_faults import SpeechFaults
from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SoundConnector
from rai_missions.connectors.sound.devices import DeviceSound
from rai_missions.connectors.sound.files import FileSound
from rai_missions.runtime.interrupts import until_signals
from rai_missions.voice.listener import ListenSettings, SpeechListener, Transcript
from rai_missions.voice.setup import ListenNames, open_recognition

__all__ = ("line_of", "listen_to", "play_sound")

AHEAD = 64
"""Frames of a file that may wait to be looked at."""
AFTER_S = 1.0
"""Silence after the end of a file, so that its last turn ends."""


def play_sound(sound: bytes, device: str | None) -> int:
    """Play 16 kHz samples to their end; returns an exit status."""
    speaker, done = DeviceSound(speaker=device), threading.Event()
    pieces = iter(range(0, len(sound), FRAME_BYTES))

    def source(_: float) -> bytes:
        start = next(pieces, None)
        if start is None:
            done.set()
            return b""
        return sound[start : start + FRAME_BYTES]

    speaker.start()
    close = speaker.play(source)
    try:
        is_played = done.wait(len(sound) / (2 * 16000) + 10.0)
    finally:
        close()
        speaker.stop()
    if not is_played:
        print("rai-missions speak: the device took no sound", file=sys.stderr)
    return int(not is_played)


def listen_to(file: str | None, device: str | None, names: ListenNames, *, as_json: bool) -> int:
    """Print each transcript; returns an exit status."""
    sound: SoundConnector = FileSound(file) if file is not None else DeviceSound(device)
    count, faults = Counter[str](), SpeechFaults("listen")

    def show(transcript: Transcript) -> None:
        faults.take(transcript.fault)
        count["lost"] += bool(transcript.fault)
        if transcript.text:
            count["understood"] += 1
            print(json.dumps(transcript._asdict()) if as_json else line_of(transcript, names), flush=True)

    recognition = open_recognition(names, ListenSettings(), on_transcript=show, on_fault=faults.take)
    try:
        recognition.wait_ready()
        faults.begin()
        sound.listen(recognition.listener.take)
        sound.start()
        if isinstance(sound, FileSound):
            _to_the_end(sound, recognition.listener)
        else:
            print("listening; Ctrl-C ends it", file=sys.stderr)
            with until_signals():
                threading.Event().wait()
            return 0
    finally:
        sound.stop()
        recognition.close()
    lost_s = recognition.listener.lost_s
    if lost_s:
        print(f"rai-missions listen: {lost_s:.2f} s of {file} were lost with the ear", file=sys.stderr)
    if lost := count["lost"]:
        print(f"rai-missions listen: {lost} turn{'s' * (lost > 1)} of {file} could not be read", file=sys.stderr)
    elif not count["understood"]:
        print(f"rai-missions listen: nothing was understood in {file}", file=sys.stderr)
    return int(lost > 0 or lost_s > 0 or not count["understood"])


def line_of(transcript: Transcript, names: ListenNames) -> str:
    """A transcript in one line: when, how many of the recognisers agree, and the text."""
    agree, recognisers = sum(reading == transcript.text for reading in transcript.readings), 1 + bool(names.second)
    return f"{transcript.began:6.1f} s  {agree} of {recognisers}  {transcript.text}"


def _to_the_end(sound: FileSound, listener: SpeechListener) -> None:
    steps, last = 0, AFTER_S / FRAME_S
    while not sound.over or last > 0:
        last -= sound.over
        sound.step()
        steps += 1
        if steps % AHEAD == 0:
            listener.catch_up()
    listener.finish()
