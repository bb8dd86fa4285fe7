# SPDX-License-Identifier: Apache-2.0
"""`rai-missions speak`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("speak",)


@command()
def speak(
    text: Annotated[str, Argument("TEXT")],
    *,
    output: Annotated[str | None, Argument("FILE", short="-o", files=("*.wav",))] = None,
    voice: Annotated[str, Argument("NAME")] = "flite",
    device: Annotated[str | None, Argument("NAME")] = None,
) -> int:
    """Speak a text, or write its sound into a file.

    Args:
        text: What is spoken.
        output: A WAV file, written instead of played.
        voice: flite, espeak, piper, kokoro, or a voice of another package; with options as flite:speaker=rms.
        device: The speaker, as 'doctor --voice' lists it.

    Exit status:
        0 it was spoken, 1 it was not, 2 the input is at fault

    Example:
        rai-missions speak hello -o hello.wav
    """
    from rai_missions.cli.sound import play_sound
    from rai_missions.connectors.sound.wav import check_wav_name, write_wav
    from rai_missions.errors import UsageError
    from rai_missions.voice.process import SpeechProcess
    from rai_missions.voice.setup import split_options
    from rai_missions.voice.spoken_text import sentences

    if output is not None:
        check_wav_name(output)
        if device is not None:
            raise UsageError("--device is the speaker that plays what -o writes into a file: leave one of them out")
    if not (parts := sentences(text)):
        raise UsageError("there is nothing to speak: the text is empty")
    name, options = split_options(voice)
    process = SpeechProcess("voice", name, options, within_s=30.0, on_fault=lambda _: None)  # the reply has it
    process.open()
    sound = bytearray()
    try:
        for part in parts:  # each has its time, however many they are
            reply, made = process.ask_and_wait({"do": "speak", "text": part})
            if reply.fault:
                raise UsageError(process.absent or reply.fault)
            sound += made
    finally:
        process.close()
    if output is None:
        return play_sound(bytes(sound), device)
    write_wav(output, bytes(sound))
    print(f"wrote {output}: {len(sound) / 32000:.1f} s")
    return 0
