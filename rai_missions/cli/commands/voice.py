# SPDX-License-Identifier: Apache-2.0
"""`rai-missions voice`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("voice",)


@command()
def voice(
    file: Annotated[str | None, Argument("FILE", files=("*.wav",))] = None,
    *,
    ros: bool = False,
    domain: Annotated[int | None, Argument("N")] = None,
    below: Annotated[str, Argument("TOPIC")] = "",
    output: Annotated[str | None, Argument("FILE", short="-o", files=("*.wav",))] = None,
    voice: Annotated[str, Argument("NAME")] = "flite",
    language: Annotated[str, Argument("CODE")] = "en",
    recogniser: Annotated[str, Argument("NAME")] = "whisper",
    second: Annotated[str, Argument("NAME")] = "pocketsphinx",
    wake_word: Annotated[str, Argument("WORD")] = "",
    microphone: Annotated[str | None, Argument("NAME")] = None,
    speaker: Annotated[str | None, Argument("NAME")] = None,
) -> int:
    """Listen and speak for a robot on ROS, in a process of its own.

    What a person speaks is published on /from_human; what the robot reports on /to_human is spoken, and stops when a
    person speaks. Both are printed. /voice_commands (play, pause, tog_play, stop) steers the voice. Its health is on
    /diagnostics.

    Args:
        file: A WAV file instead of the microphone, at the pace of the wall; silence follows it.
        ros: On the ROS 2 graph.
        domain: The ROS domain, instead of ROS_DOMAIN_ID.
        below: Of several robots the one that is talked with: its profile's hri_below, as /alpha.
        output: With FILE: a WAV file that is written at the end, with all that was spoken.
        voice: flite, espeak, piper, kokoro, or a voice of another package; with options as flite:speaker=rms.
        language: Of what the robot reports, as de: that of its profile's conversation.
        recogniser: whisper, or a recogniser of another package; with options as whisper:weights=base,
            whisper:folder=MODEL.
        second: The recogniser that has to agree on an order; empty for none.
        wake_word: okay_nabu, hey_jarvis, hey_mycroft or alexa: turns without it are not published.
        microphone: As 'doctor --voice' lists it.
        speaker: As 'doctor --voice' lists it.

    Exit status:
        0 it was ended (Ctrl-C, SIGTERM), 1 it can listen or speak no more, 2 the input is at fault

    Example:
        rai-missions voice --ros
    """
    from rai_missions.cli.voice_server import serve_voice
    from rai_missions.connectors.sound.connector import SoundConnector
    from rai_missions.connectors.sound.devices import DeviceSound
    from rai_missions.connectors.sound.files import FileSound
    from rai_missions.connectors.sound.wav import check_wav_name
    from rai_missions.conversation.language.language import language as words_of
    from rai_missions.errors import UsageError
    from rai_missions.voice.setup import ListenNames

    if not ros:
        raise UsageError(
            "name where the robot is: 'rai-missions voice --ros' joins the ROS graph; "
            "in one process with its mission: rai-missions run MISSION --robot ROBOT --talk --voice"
        )
    if below and not below.startswith("/"):
        raise UsageError(f"'--below {below}' is no beginning of a topic's name; write it like '/alpha'")
    if file is None and output is not None:
        raise UsageError("-o writes what is spoken next to a FILE; a speaker plays it: leave -o out, or name a FILE")
    if file is not None and (microphone, speaker) != (None, None):
        raise UsageError("a FILE is listened to without devices: leave --microphone and --speaker out, or the FILE")
    words_of(language)
    if output is not None:
        check_wav_name(output)
    sound: SoundConnector = (
        FileSound(file, output, paced=True) if file is not None else DeviceSound(microphone, speaker)
    )
    names = ListenNames(recogniser, second, wake_word)
    return serve_voice(sound, names, voice=voice, language=language, domain=domain, below=below)
