# SPDX-License-Identifier: Apache-2.0
"""Sound from files and in a simulated room, frame by frame; what a broken file is answered with."""

from __future__ import annotations

import struct
import threading
import wave
from collections.abc import Callable
from pathlib import Path

import pytest

from rai_missions.connectors.hri.connector import HRIConnector
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.connectors.local import LocalConnector
from rai_missions.connectors.sound import wav
from rai_missions.connectors.sound.connector import FRAME_BYTES, FRAME_S, SoundConnector, SoundFrame
from rai_missions.connectors.sound.contract import check_sound_connector
from rai_missions.connectors.sound.files import FileSound
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.connectors.sound.topics import TopicSound
from rai_missions.connectors.sound.wav import converted, read_wav, write_wav
from rai_missions.errors import UsageError
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.testing import Inbox

pytest.importorskip("numpy", reason="needs the extra voice")
TONE = struct.pack("<512h", *([4000, -4000] * 256))


def stepped(sound: SoundConnector, frames: int) -> None:
    assert isinstance(sound, FileSound)
    for _ in range(frames):
        sound.step()


def waited(sound: SoundConnector, frames: int) -> None:
    passed, done = [0], threading.Event()

    def count(_: SoundFrame) -> None:
        passed[0] += 1
        if passed[0] > frames:
            done.set()

    close = sound.listen(count)
    assert done.wait(10), "no frames come"
    close()


@pytest.mark.parametrize(
    ("make", "pass_time"),
    [(FileSound, stepped), (RoomSound, stepped), (lambda: FileSound(paced=True), waited)],
    ids=["file", "room", "file at the pace of the wall"],
)
def test_every_connector_keeps_the_contract(
    make: Callable[[], SoundConnector], pass_time: Callable[[SoundConnector, int], None]
) -> None:
    check_sound_connector(make, pass_time)


def test_a_connector_that_gives_half_a_frame_breaks_the_contract() -> None:
    class Half(FileSound):
        def recorded_at(self, start: int, played: bytes) -> bytes:
            return super().recorded_at(start, played)[::2]

    with pytest.raises(AssertionError, match="a frame has 1024 bytes each way"):
        check_sound_connector(Half, stepped)


def test_a_simulated_clock_steps_a_file() -> None:
    sound, frames = FileSound(TONE * 3), list[SoundFrame]()
    sound.listen(frames.append)
    sound.start()
    SimulatedClock(sound).wait(Mailbox(), 5 * FRAME_S - 1e-9, paced=False)
    assert [frame.at for frame in frames] == [pytest.approx(count * FRAME_S) for count in range(5)]
    assert [any(frame.recorded) for frame in frames] == [True, True, True, False, False]


def test_what_was_played_is_written(tmp_path: Path) -> None:
    sound = FileSound(b"", tmp_path / "out.wav")
    sound.play(lambda at: TONE if at < 0.05 else b"")
    sound.start()
    stepped(sound, 4)
    sound.stop()
    assert read_wav(tmp_path / "out.wav") == TONE * 2 + bytes(2 * FRAME_BYTES)


def test_a_room_returns_what_is_played_later_and_quieter() -> None:
    room, frames = RoomSound(echo_db=-20.0, delay_ms=64.0, noise=0.0), list[SoundFrame]()
    room.play(lambda at: TONE if at == 0 else b"")
    room.listen(frames.append)
    room.start()
    stepped(room, 4)
    loudest = [max(map(abs, struct.unpack("<512h", frame.recorded))) for frame in frames]
    assert loudest == [0, 0, 400, 0], "64 ms are two frames, and -20 dB a tenth"


@pytest.mark.parametrize("rate", [8_000, 22_050, 44_100, 48_000])
def test_any_usual_rate_becomes_16_khz_mono(rate: int, tmp_path: Path) -> None:
    pytest.importorskip("samplerate", reason="needs the extra voice")
    file = tmp_path / "stereo.wav"
    with wave.open(str(file), "wb") as out:
        out.setparams((2, 2, rate, 0, "NONE", ""))
        out.writeframes(struct.pack("<hh", 1000, 3000) * rate)
    sound = struct.unpack(f"<{len(read_wav(file)) // 2}h", read_wav(file))
    assert len(sound) == pytest.approx(16_000, abs=32)
    assert sound[8_000] == pytest.approx(2000, abs=10), "the mean of both channels"


def test_a_sound_that_cannot_be_written_is_refused_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as caught:
        write_wav(tmp_path, TONE)
    assert str(caught.value) == f"{tmp_path} cannot be written: Is a directory; name another file"


def write(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def test_a_broken_file_is_named_with_what_is_wrong(tmp_path: Path) -> None:
    write_wav(tmp_path / "good.wav", TONE * 20)
    good = (tmp_path / "good.wav").read_bytes()
    with wave.open(str(tmp_path / "8bit.wav"), "wb") as out:
        out.setparams((1, 1, 16_000, 0, "NONE", ""))
        out.writeframes(b"\x80" * 100)
    whole, sound = struct.pack("<I", len(good) - 6), struct.pack("<I", len(good) - 43)
    odd = good[:4] + whole + good[8:40] + sound + good[44:] + b"xx"
    faults = {
        tmp_path / "none.wav": "there is no file",
        tmp_path: "is a folder, no WAV file",
        write(tmp_path / "text.wav", b"no sound at all"): "is no WAV file that can be read",
        write(tmp_path / "empty.wav", b""): "is no WAV file that can be read",
        write(tmp_path / "beyond.wav", good[:17] + b"\xff" + good[18:]): r"can be read \(it is cut short\)",
        write(tmp_path / "cut.wav", good[:-1000]): "is cut short: 9740 of 10240 samples are there",
        tmp_path / "8bit.wav": "has 8 bits a sample; give PCM, 16 bits",
        write(
            tmp_path / "piped.wav", good[:40] + struct.pack("<I", 2**32 - 1) + good[44:-100]
        ): "is cut short: 10190 of 2147483647 samples are there",
        write(tmp_path / "odd.wav", odd): "ends within a sample: 20481 bytes are no multiple of 2",
        write(tmp_path / "slow.wav", good[:24] + struct.pack("<I", 100) + good[28:]): "has a rate of 100 Hz",
        write(tmp_path / "still.wav", good[:24] + struct.pack("<I", 0) + good[28:]): "has a rate of 0 Hz",
    }
    for path, sentence in faults.items():
        with pytest.raises(UsageError, match=sentence) as caught:
            read_wav(path)
        assert str(path) in str(caught.value)


def test_a_file_that_is_longer_than_an_hour_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wav, "LONGEST_S", 0.5)
    write_wav(tmp_path / "half.wav", bytes(16_000))
    assert len(read_wav(tmp_path / "half.wav")) == 16_000
    write_wav(tmp_path / "longer.wav", bytes(16_002))
    with pytest.raises(UsageError, match="is longer than an hour; give a shorter file"):
        read_wav(tmp_path / "longer.wav")


def test_time_passes_whatever_a_listener_raises() -> None:
    asked, done = list[float](), threading.Event()

    def leave(_: SoundFrame) -> None:
        raise SystemExit

    def source(at: float) -> bytes:
        asked.append(at)
        if len(asked) == 3:
            done.set()
        return b""

    sound = FileSound(paced=True)
    sound.listen(leave)
    sound.play(source)
    sound.start()
    assert done.wait(5.0)
    sound.stop()


@pytest.mark.parametrize(
    ("data", "rate", "channels", "sentence"),
    [
        (b"\0\0", 0, 1, "has a rate of 0 Hz; 4000 to 192000 Hz can be read"),
        (b"\0\0", 16_000, 0, "has 0 channels; 1 to 16 can be read"),
        (b"\0\0\0", 16_000, 1, "ends within a sample: 3 bytes are no multiple of 2"),
    ],
)
def test_sound_of_no_known_form_is_refused(data: bytes, rate: int, channels: int, sentence: str) -> None:
    with pytest.raises(UsageError, match=sentence):
        converted(data, rate, channels)


# -- topics ------------------------------------------------------------------------------------------------------------


def topic_sound() -> tuple[TopicSound, HRIConnector]:
    connector = LocalConnector(now=lambda: 0.0)
    connector.start()
    hri = HRIConnector(connector, now=lambda: 0.0)
    return TopicSound(hri, "/mic", "/speaker", now=lambda: 0.0), hri


def published(sound: SoundConnector, frames: int) -> None:
    """Sound that another program records: the frames pass as its messages come."""
    assert isinstance(sound, TopicSound)
    passed, done = [0], threading.Event()

    def count(_: SoundFrame) -> None:
        passed[0] += 1
        if passed[0] >= frames:
            done.set()

    close = sound.listen(count)
    sound._hri.send(HRIMessage(audios=(Audio(bytes(frames * FRAME_BYTES), 16_000),)), "/mic")
    done.wait(5.0 if sound.running else 0.0)
    close()


def test_sound_on_topics_keeps_the_contract() -> None:
    check_sound_connector(lambda: topic_sound()[0], published)


def test_all_pieces_of_a_message_pass() -> None:
    sound, hri = topic_sound()
    frames, done = list[SoundFrame](), threading.Event()
    sound.start()
    sound.listen(lambda frame: (frames.append(frame), len(frames) == 60 and done.set()))
    hri.send(HRIMessage(audios=tuple(Audio(bytes(FRAME_BYTES), 16_000) for _ in range(60))), "/mic")
    assert done.wait(5.0), f"{len(frames)} of 60"
    sound.stop()


def test_what_is_played_is_sent_and_broken_sound_is_left_out(caplog: pytest.LogCaptureFixture) -> None:
    pytest.importorskip("samplerate", reason="needs the extra voice")
    sound, hri = topic_sound()
    sent = Inbox[HRIMessage]()
    hri.listen("/speaker", sent, author="ai")
    sound.play(lambda at: TONE if at < 2 * FRAME_S - 1e-9 else b"")
    sound.start()
    hri.send(HRIMessage(audios=(Audio(b"\0\0", 4_000, 1), Audio(bytes(1024), 65_535, 8))), "/mic")
    published(sound, 4)
    (message,) = sent.wait(bool, "what was played is sent")
    assert [audio.samples for audio in message.audios] == [TONE * 2]
    sound.stop()
    assert caplog.text == ""
