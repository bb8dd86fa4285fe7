# SPDX-License-Identifier: Apache-2.0
"""Sound devices by PortAudio, over a PulseAudio of its own whose microphone and speaker are null sinks.

Each test runs in a process that is new, since PortAudio looks for devices once.
"""

from __future__ import annotations

import importlib.util
import json
import logging
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import pytest

from rai_missions.connectors.sound.connector import FRAME_BYTES, SoundFrame
from rai_missions.connectors.sound.contract import check_sound_connector
from tests.connectors.sound.test_sound import waited
from tests.voice.conftest import LACKING as VOICE_LACKING
from tests.voice.conftest import quiet, spoken

T = TypeVar("T")
PROGRAMS = ("pulseaudio", "pactl", "pacat", "parec")
LACKING = [name for name in PROGRAMS if shutil.which(name) is None]
LACKING += [name for name in ("sounddevice", "numpy") if importlib.util.find_spec(name) is None]
RAW = ("--raw", "--rate=16000", "--channels=1", "--format=s16le", "--latency-msec=20")

pytestmark = [
    pytest.mark.skipif(bool(LACKING), reason=f"not installed, for null sinks: {', '.join(LACKING)}"),
    pytest.mark.xdist_group("sound devices"),
]


@pytest.fixture(scope="module")
def null_sinks() -> Iterator[None]:
    with null_server():
        yield


@contextmanager
def null_server() -> Iterator[subprocess.Popen[bytes]]:
    """PulseAudio with the null sinks `speaker` and `microphone`; what is played into the latter is recorded."""
    folder = Path(tempfile.mkdtemp(prefix="sound-"))
    socket = folder / "native"
    given = {"XDG_RUNTIME_DIR": str(folder), "HOME": str(folder), "PULSE_SERVER": f"unix:{socket}",
             "PULSE_SINK": "speaker", "PULSE_SOURCE": "microphone.monitor"}  # fmt: skip
    sinks = [
        part
        for name in ("speaker", "microphone")
        for part in ("-L", f"module-null-sink sink_name={name} rate=16000 channels=1")
    ]
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    server = subprocess.Popen(
        [
            "pulseaudio",
            "-n",
            "--daemonize=no",
            "--exit-idle-time=-1",
            "-L",
            f"module-native-protocol-unix auth-anonymous=1 socket={socket}",
            *sinks,
        ],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        answered = wait_until(
            lambda: subprocess.run(["pactl", "info"], capture_output=True, check=False).returncode == 0
        )
        if not answered:
            pytest.skip("PulseAudio does not start here")
        yield server
    finally:
        server.terminate()
        server.wait(10)
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})
        shutil.rmtree(folder, ignore_errors=True)


def wait_until(holds: Callable[[], bool], within_s: float = 15.0) -> bool:
    pause, end = threading.Event(), time.monotonic() + within_s
    while not (held := holds()) and time.monotonic() < end:
        pause.wait(0.1)
    return held


def in_new_process(work: Callable[[], T]) -> T:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work).result(60)


def contract() -> None:
    from rai_missions.connectors.sound.devices import DeviceSound

    check_sound_connector(lambda: DeviceSound("pulse", "pulse"), waited)


@pytest.mark.long
def test_devices_keep_the_contract(null_sinks: None) -> None:
    in_new_process(contract)


def numbered() -> list[bytes]:
    return [bytes([number, 40]) * (FRAME_BYTES // 2) for number in range(1, 61)]


def played() -> list[bytes]:
    from rai_missions.connectors.sound.devices import DeviceSound

    sound, frames, rest = DeviceSound("pulse", "pulse"), list[SoundFrame](), iter(numbered())
    sound.listen(frames.append)
    sound.play(lambda at: next(rest, b""))
    sound.start()
    waited(sound, 75)
    sound.stop()
    return [frame.played for frame in frames if any(frame.played)]


@pytest.mark.long
def test_each_frame_is_played_once_in_order_and_reaches_the_speaker(null_sinks: None, tmp_path: Path) -> None:
    """However many frames the sound system asks for in a row; on a busy machine it drops some after that."""
    file = tmp_path / "speaker.raw"
    with file.open("wb") as out:
        recorder = subprocess.Popen(["parec", *RAW, "-d", "speaker.monitor"], stdout=out)
    assert wait_until(lambda: file.stat().st_size > 0), "the monitor of the speaker records"
    found = in_new_process(played)
    recorder.terminate()
    recorder.wait(10)
    assert found == numbered()
    recorded = file.read_bytes()
    reached = sum(frame[: FRAME_BYTES // 2] in recorded for frame in numbered())
    assert reached >= 20, f"{reached} of 60 frames came out of the speaker"


def spoken_whole() -> int:
    from rai_missions.cli.sound import play_sound

    return play_sound(b"".join(numbered()), "pulse")


@pytest.mark.long
def test_what_is_played_is_played_to_its_end_before_the_device_is_closed(null_sinks: None, tmp_path: Path) -> None:
    """Each of the last frames, or a piece of it on a busy machine; 60 to 130 ms were lost."""
    file = tmp_path / "speaker.raw"
    with file.open("wb") as out:
        recorder = subprocess.Popen(["parec", *RAW, "-d", "speaker.monitor"], stdout=out)
    assert wait_until(lambda: file.stat().st_size > 0), "the monitor of the speaker records"
    assert in_new_process(spoken_whole) == 0
    ends = [each[:100] for each in numbered()[-6:]]
    try:
        assert wait_until(lambda: sum(each in file.read_bytes() for each in ends) >= 5, 5.0)
    finally:
        recorder.terminate()
        recorder.wait(10)


def level() -> tuple[int, ...]:
    from rai_missions.connectors.sound.devices import microphone_level

    return tuple(microphone_level("pulse"))


@pytest.mark.long
def test_a_microphone_is_looked_at_as_a_run_opens_it(null_sinks: None, tmp_path: Path) -> None:
    samples, loudest, clipped = in_new_process(level)
    assert samples >= 16_000
    assert (loudest, clipped) == (0, 0)
    file = tmp_path / "loud.raw"
    file.write_bytes((b"\xff\x7f" * 20 + b"\x00\x80" * 20) * 400 * 60)  # a minute
    player = subprocess.Popen(["pacat", "-p", *RAW, "-d", "microphone", str(file)])
    samples, loudest, clipped = in_new_process(level)
    player.terminate()
    player.wait(10)
    assert loudest >= 32_767
    assert clipped > samples / 4


@pytest.mark.drill
@pytest.mark.skipif(bool(VOICE_LACKING), reason=f"not installed, of the extra voice: {', '.join(VOICE_LACKING)}")
def test_what_is_spoken_into_the_microphone_is_printed(null_sinks: None) -> None:
    command = [sys.executable, "-m", "rai_missions.cli.main", "listen", "--json", "--device", "pulse"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as listening:
        assert listening.stdout is not None
        assert listening.stderr is not None
        assert "listening" in listening.stderr.readline()
        player = subprocess.Popen(["pacat", "-p", *RAW, "-d", "microphone"], stdin=subprocess.PIPE)
        assert player.stdin is not None
        player.stdin.write(quiet(1.0) + spoken("Cancel the mission.", "rms") + quiet(2.0))
        player.stdin.close()
        found = json.loads(listening.stdout.readline())
        listening.terminate()
        player.wait(30)
    assert found["text"] == "cancel the mission"


def away_and_back() -> list[str]:
    """The faults while a sound system is away, and once it is back; then what was logged."""
    from rai_missions.connectors.sound.devices import DeviceSound

    logged = list[str]()
    handler = logging.Handler()
    handler.emit = lambda record: logged.append(record.getMessage())  # type: ignore[method-assign]
    logging.getLogger("rai_missions").addHandler(handler)
    sound = DeviceSound("pulse", "pulse")
    with null_server() as server:
        sound.start()
        waited(sound, 10)
        faults = [sound.fault]
        server.kill()
        assert wait_until(lambda: bool(sound.fault))
        faults.append(sound.fault)
    with null_server():
        waited(sound, 10)
        assert wait_until(lambda: "device again" in logged[-1])
        faults.append(sound.fault)
        sound.stop()
    return [*faults, *logged]


@pytest.mark.long
def test_a_sound_system_that_is_away_is_a_fault_until_it_is_back() -> None:
    before, away, back, *logged = in_new_process(away_and_back)
    assert (before, back) == ("", "")
    assert away
    found = [each.endswith("it is tried again") for each in logged if each.endswith(("tried again", "device again"))]
    assert found == [True, False] * (len(found) // 2), f"a fault and its end are logged once each: {logged}"
    assert found, "on a busy machine there may be others before"


ENDS = """
import sys
from rai_missions.connectors.sound.devices import DeviceSound
from tests.connectors.sound.test_sound import waited
sound = DeviceSound("pulse", "pulse")
sound.start()
waited(sound, 3)
print("sounds", flush=True)
sys.stdin.readline()
sound.stop()
"""


@pytest.mark.long
@pytest.mark.parametrize("how", [signal.SIGSTOP, signal.SIGTERM, signal.SIGKILL])
def test_a_program_ends_where_its_sound_system_hangs_or_has_died(how: int) -> None:
    with (
        null_server() as server,
        subprocess.Popen([sys.executable, "-c", ENDS], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as program,
    ):
        assert program.stdin is not None
        assert program.stdout is not None
        assert program.stdout.readline() == b"sounds\n"
        server.send_signal(how)
        try:
            program.communicate(b"\n", timeout=30)
        finally:
            program.kill()
            server.kill()
    assert program.returncode == 0
