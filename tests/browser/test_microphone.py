# SPDX-License-Identifier: Apache-2.0
"""The page's microphone in a browser whose device plays a recording: it is opened and shut by its button alone."""

from __future__ import annotations

import wave
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.browser.conftest import Launch, Look, looking, until
from tests.visualize.live import stage
from tests.visualize.live.test_sound import SpokenRun

RATE_HZ, TONE_HZ = 16_000, 440


@pytest.fixture
def recorded(launch: Launch, tmp_path: Path) -> Iterator[Look]:
    """Opens pages in a browser whose microphone plays two seconds of a tone, again and again."""
    np = pytest.importorskip("numpy")
    tone = 8_000 * np.sin(2 * np.pi * TONE_HZ * np.arange(2 * RATE_HZ) / RATE_HZ)
    path = tmp_path / "tone.wav"
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(tone.astype("<i2").tobytes())
    started = launch(
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-audio-capture={path}",
    )
    yield from looking(started)
    started.close()


@pytest.mark.long
def test_the_microphone_is_open_from_one_click_to_the_next_and_its_sound_is_passed_on(recorded: Look) -> None:
    np = pytest.importorskip("numpy")
    with SpokenRun() as run:
        run.start()
        window = recorded(run.page)
        window.keyboard.press("c")
        assert window.inner_text("#talk-speak") == "speak" and not run.listener.pieces
        window.click("#talk-speak")
        stage.until(lambda: len(run.listener.pieces) >= 12, "sound")
        assert window.get_attribute("#talk-speak", "aria-pressed") == "true"
        window.click("#talk-speak")
        stage.until(lambda: run.listener.pieces[-1][4], "the last piece")
        assert window.inner_text("#talk-speak") == "speak"
    sounds = [np.frombuffer(sound, "<i2").astype(float) for sound, *_ in run.listener.pieces[4:12]]
    assert {len(each) for each in sounds} == {2048}, "128 ms at 16 kHz"
    loud = max(sounds, key=lambda each: float(np.abs(each).sum()))
    found = np.argmax(np.abs(np.fft.rfft(loud * np.hanning(len(loud))))) * RATE_HZ / len(loud)
    assert abs(found - TONE_HZ) < 2 * RATE_HZ / len(loud), "the tone, at its own rate"


SLOW = """() => {
  const given = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
  navigator.mediaDevices.getUserMedia = async (wanted) => {
    await new Promise((allow) => { window.allow = allow; });
    return (window.given = await given(wanted));
  };
}"""


@pytest.mark.long
def test_a_microphone_that_is_shut_before_it_is_allowed_records_nothing(recorded: Look) -> None:
    with SpokenRun() as run:
        run.start()
        window = recorded(run.page)
        window.keyboard.press("c")
        window.evaluate(SLOW)
        window.click("#talk-speak")
        until(window, "Boolean(window.allow)")
        window.click("#talk-speak")
        assert window.inner_text("#talk-speak") == "speak"
        window.evaluate("window.allow()")
        until(window, "window.given && window.given.getTracks().every((track) => track.readyState === 'ended')")


@pytest.mark.long
def test_a_refusal_shuts_the_microphone_with_its_reason(recorded: Look) -> None:
    with SpokenRun() as run:
        run.start()
        run.listener.why = "another microphone is open"
        window = recorded(run.page)
        window.keyboard.press("c")
        window.click("#talk-speak")
        until(window, "document.querySelector('#notice').textContent === 'not taken: another microphone is open'")
        assert window.get_attribute("#talk-speak", "aria-pressed") == "false"


def test_a_run_that_recognises_nothing_shows_the_reason_in_the_place_of_the_button(look: Look) -> None:
    with SpokenRun("speech needs ctranslate2") as run:
        run.start()
        window = look(run.page)
        window.keyboard.press("c")
        assert window.inner_text("#talk-deaf") == "No microphone: speech needs ctranslate2"
        assert not window.is_visible("#talk-speak")
