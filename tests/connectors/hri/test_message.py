# SPDX-License-Identifier: Apache-2.0
"""A message between a person and a robot: what it takes, and what it refuses with a reason."""

from __future__ import annotations

import io
import re
import wave
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.hri.message import MOST_BYTES, Audio, HRIMessage
from rai_missions.connectors.hri.wire import message_from_data, message_to_data
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.image import Image

audios = st.builds(
    lambda frames, rate, channels: Audio(frames * channels, rate, channels),
    st.binary(max_size=40).map(lambda data: data[: len(data) // 2 * 2]),
    st.integers(4_000, 65_535),
    st.integers(1, 8),
)
texts = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=60)
pictures = st.integers(1, 3).map(lambda size: Image(f"picture of {size}", size, 1, "rgb8", bytes(3 * size)))
messages = st.builds(
    HRIMessage,
    texts,
    st.lists(pictures, max_size=3).map(tuple),
    st.lists(audios, max_size=3).map(tuple),
    st.sampled_from(["human", "ai"]),
    texts,
    texts,
    st.integers(0, 99),
    st.booleans(),
)


@given(messages)
def test_a_message_is_the_same_after_its_way_as_plain_data(message: HRIMessage) -> None:
    assert message_from_data(message_to_data(message), message.author) == message


@given(audios)
def test_sound_is_the_same_after_its_way_as_a_wav_file(audio: Audio) -> None:
    assert Audio.of_wav(audio.wav()) == audio


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.binary(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)
FIELDS = ("header", "text", "images", "audios", "communication_id", "seq_no", "seq_end")


@given(st.dictionaries(st.sampled_from(FIELDS), values))
def test_whatever_comes_is_a_message_or_an_error_that_names_the_topic(data: dict[str, Any]) -> None:
    why = ""
    try:
        message_from_data(data, "human", "/from_human")
    except ConnectorError as fault:
        why = str(fault)
    assert not why or why.startswith("/from_human: ")


def test_what_has_no_field_of_a_message_is_none() -> None:
    """A client over MQTT that misspells `text` learns of it: its "stop" would be an empty sentence."""
    with pytest.raises(ConnectorError) as refused:
        message_from_data({"txt": "stop"}, "human", "/from_human")
    assert str(refused.value) == '/from_human: {"txt": "stop"} has no field of a message; write {"text": …}'
    assert message_from_data({"communication_id": "7", "seq_end": True}, "human").text == ""


def test_a_message_has_no_role() -> None:
    assert not any("role" in name for name in HRIMessage.__slots__)


def beyond(wav: bytes) -> bytes:
    """The file with a first piece that ends beyond it."""
    return wav[:17] + b"\xff" + wav[18:]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: HRIMessage("x" * 10_000_000), "text: 10000000 characters; there are 100000 at the most"),
        (lambda: HRIMessage("a\0b"), "text: character 1 is NUL, which no message carries"),
        (lambda: HRIMessage("ab\ud800"), "text: character 2 is half a surrogate pair, which is no text"),
        (lambda: HRIMessage(7), "text: 7 is given where text belongs"),  # type: ignore[arg-type]
        (lambda: HRIMessage(author="god"), "author: 'god' is neither 'human' nor 'ai'"),  # type: ignore[arg-type]
        (lambda: HRIMessage(name="x" * 300), "name: 300 characters; there are 200 at the most"),
        (lambda: HRIMessage(seq_no=-1), "seq_no: -1 is no number of a part; the first is 0"),
        (lambda: HRIMessage(seq_end=1), "seq_end: 1 is neither true nor false"),  # type: ignore[arg-type]
        (lambda: HRIMessage(images=("x",)), "images: [\"x\"] is no tuple of Image"),  # type: ignore[arg-type]
        (lambda: HRIMessage(audios=(Audio(b"", 8000),) * 65), "audios: 65 of them; there are 64 at the most"),
        (lambda: HRIMessage(images=(Image("x", 9999, 9999, "rgb8", b""),)),
         f"images and audios: 299940003 bytes; a message carries {MOST_BYTES} at the most"),
        (lambda: Audio(b"abc", 8000), "audio: 3 bytes are no whole number of samples; 2 bytes for each of 1 channels'"),
        (lambda: Audio(b"abcd", 0), "audio: rate_hz 0 is no sample rate; one goes from 4000 to 65535"),
        (lambda: Audio(b"abcd", 8000, 0), "audio: 0 channels; there are 1 to 8"),
        (lambda: Audio([1], 8000), "audio: samples are bytes, not list"),  # type: ignore[arg-type]
        (lambda: Audio.of_wav(b"RIFF"), "audio: 4 bytes are no WAV file: 'it is cut short'"),
        (lambda: Audio.of_wav(b"no sound at all"), "audio: 15 bytes are no WAV file: 'file does not start with RIFF"),
        (lambda: Audio.of_wav(Audio(bytes(80), 8000).wav()[:-20]), "audio: a WAV file that is cut short: 30 of 40"),
        (lambda: Audio.of_wav(beyond(Audio(bytes(80), 8000).wav())), "124 bytes are no WAV file: 'it is cut short'"),
    ],
)  # fmt: skip
def test_what_is_no_message_is_refused_with_its_field(make: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(UsageError, match=re.escape(sentence)):
        make()


def test_a_wav_file_of_another_size_is_refused() -> None:
    file = io.BytesIO()
    with wave.open(file, "wb") as writer:
        writer.setnchannels(1), writer.setsampwidth(1), writer.setframerate(8000), writer.writeframes(b"abc")
    with pytest.raises(UsageError, match="samples of 8 bits; WAV files of 16 bits are read"):
        Audio.of_wav(file.getvalue())


def failing() -> bytes:
    raise RuntimeError("no light")


@pytest.mark.parametrize(
    ("image", "sentence"),
    [
        (Image("x", 2, 2, "rgb8", b"abc"), "images/0: 3 bytes are no 2x2 pixels of rgb8"),
        (Image("x", -1, -4, "rgb8", b"a" * 12), "images/0: 12 bytes are no -1x-4 pixels of rgb8"),
        (Image("x", 2, 2, "png", b"abc"), "images/0: 3 bytes are no picture in 'png'"),
        (Image("x", 2, 2, "exe", b"abc"), "images/0: 3 bytes are no picture in 'exe'"),
        (Image("x", 1, 1, "rgb8", failing), "images/0: the picture cannot be had: 'no light'"),
        ({"encoding": "16UC1", "data": b"abc"}, "images/0: encoding '16UC1' is no picture that can be shown"),
        (
            {"encoding": "rgb8", "width": 64, "height": 48, "step": 192, "data": b"abc"},
            "images/0: 3 bytes are no 64x48 pixels of rgb8, with 192 bytes a line",
        ),
        (7, "images/0: 7 is given where the fields of a message belong"),
    ],
)  # fmt: skip
def test_a_broken_picture_is_found_at_the_door(image: Any, sentence: str) -> None:
    with pytest.raises(ConnectorError, match=re.escape(sentence)):
        message_from_data({"images": [image]}, "human", "/from_human")
