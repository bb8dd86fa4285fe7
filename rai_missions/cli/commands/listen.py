# SPDX-License-Identifier: Apache-2.0
"""`rai-missions listen`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, command

__all__ = ("listen",)


@command()
def listen(
    file: Annotated[str | None, Argument("FILE", files=("*.wav",))] = None,
    *,
    recogniser: Annotated[str, Argument("NAME")] = "whisper",
    second: Annotated[str, Argument("NAME")] = "pocketsphinx",
    wake_word: Annotated[str, Argument("WORD")] = "",
    device: Annotated[str | None, Argument("NAME")] = None,
    json: bool = False,
) -> int:
    """Print what a person speaks into the microphone or a file, one line a turn.

    Nothing is ordered by it: it shows what the recognisers make of speech.

    Args:
        file: A WAV file instead of the microphone.
        recogniser: whisper, or a recogniser of another package; with options as whisper:weights=base,
            whisper:folder=MODEL.
        second: The recogniser that has to agree on an order; empty for none.
        wake_word: okay_nabu, hey_jarvis, hey_mycroft or alexa: turns without it are not shown.
        device: The microphone, as 'doctor --voice' lists it.
        json: One JSON object a line, with times and the readings of each recogniser.

    Exit status:
        0 something was understood, or the microphone was listened to until the end (Ctrl-C, SIGTERM); 1 nothing was
        understood, or sound was lost since the ear or a recogniser failed; 2 the input is at fault

    Example:
        rai-missions listen question.wav
    """
    from rai_missions.cli.sound import listen_to
    from rai_missions.errors import UsageError
    from rai_missions.voice.setup import ListenNames

    if file is not None and device is not None:
        raise UsageError("--device is the microphone that is listened to instead of a FILE: leave one of them out")
    return listen_to(file, device, ListenNames(recogniser, second, wake_word), as_json=json)
