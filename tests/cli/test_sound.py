# SPDX-License-Identifier: Apache-2.0
"""`speak`, `listen` and `doctor --voice`, as a person at a terminal uses them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rai_missions.cli.doctor.speech import speech
from rai_missions.cli.main import main
from rai_missions.cli.run.options import RunOptions
from rai_missions.cli.run.talk import normalise_voice_args
from rai_missions.connectors.sound.devices import sound_devices
from rai_missions.connectors.sound.wav import write_wav
from rai_missions.errors import MissionError
from tests.plugins.test_plugins import laid_out
from tests.voice.conftest import needs_voice, spoken


@pytest.mark.long
@needs_voice
@pytest.mark.xdist_group("voice")
def test_what_speak_writes_listen_understands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "question.wav")
    assert main(["speak", "Where are you going?", "-o", file]) == 0
    assert capsys.readouterr().out == f"wrote {file}: 1.4 s\n"
    assert main(["listen", file, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["text"], found["readings"], found["turn"]) == ("Where are you going?", ["Where are you going?"], 1)


@needs_voice
@pytest.mark.long
def test_a_turn_is_a_line_with_its_times_its_number_and_its_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(tmp_path / "question.wav")
    assert main(["speak", "Where are you going?", "-o", file]) == 0
    capsys.readouterr()
    assert main(["listen", file]) == 0
    assert capsys.readouterr().out.split(maxsplit=5)[2:] == ["1", "of", "2", "Where are you going?\n"]
    assert main(["listen", file, "--second", ""]) == 0
    assert capsys.readouterr().out.split(maxsplit=5)[2:] == ["1", "of", "1", "Where are you going?\n"]


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.drill
def test_a_file_without_speech_exits_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_wav(tmp_path / "silence.wav", bytes(32_000))
    assert main(["listen", str(tmp_path / "silence.wav")]) == 1
    printed = capsys.readouterr()
    assert (printed.out, "nothing was understood in" in printed.err) == ("", True)


SHORT_OF_EARS = """
from rai_missions.voice.kind import Reading

class Recogniser:
    def transcribe(self, samples, phrases):
        assert len(samples) < 2 * 32000, "too long"
        return Reading("halt")
"""


@needs_voice
@pytest.mark.xdist_group("voice")
def test_a_file_of_which_a_turn_is_lost_exits_with_1_after_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    offers = "[rai_missions.recognisers]\nears = short_of_ears:Recogniser\n"
    monkeypatch.syspath_prepend(str(laid_out(tmp_path, "short_of_ears", "1.0", offers=offers, code=SHORT_OF_EARS)))
    long = spoken("Where are you going with the red cup and the plant?")
    write_wav(tmp_path / "two.wav", spoken("Stop.") + bytes(32_000) + long)
    assert main(["listen", str(tmp_path / "two.wav"), "--recogniser", "ears", "--second", ""]) == 1
    printed = capsys.readouterr()
    assert printed.out.split(maxsplit=5)[5] == "halt\n"
    assert "the recogniser 'ears' failed" in printed.err and "1 turn of" in printed.err


SHORT_OF_BREATH = """
class Voice:
    def speak(self, text):
        assert len(text) <= 10, f"{len(text)} letters"
        yield bytes(2 * 160 * len(text))
open_voice = Voice
"""


@pytest.mark.parametrize(
    ("text", "status", "written"),
    [
        ("Halt it.", 0, "0.1 s"),
        (" ".join(["Halt it."] * 200), 0, "16.0 s"),
        ("...", 2, ""),
        ("Halt it and wait", 2, ""),
    ],
)
def test_a_text_is_spoken_sentence_by_sentence_however_long_it_is(
    text: str,
    status: int,
    written: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    offers = "[rai_missions.voices]\nbreath = short_of_breath:open_voice\n"
    monkeypatch.syspath_prepend(str(laid_out(tmp_path, "short_of_breath", "1.0", offers=offers, code=SHORT_OF_BREATH)))
    assert main(["speak", text, "--voice", "breath", "-o", str(tmp_path / "out.wav")]) == status
    assert capsys.readouterr().out == (f"wrote {tmp_path}/out.wav: {written}\n" if written else "")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["speak", "  "], "there is nothing to speak: the text is empty"),
        (["speak", "x", "--voice", "flit"], "no voice 'flit' is known; did you mean 'flite'?"),
        (["speak", "x", "--voice", "flite:speaker"], "the option 'speaker' of 'flite' has no value"),
        (["speak", "x", "--voice", "piper:model=no.onnx"], "piper"),
        (["speak", "x", "-o", "out.mp3"], "'out.mp3' does not end in .wav"),
        (["voice", "a.wav", "-o", "out.mp3", "--ros"], "'out.mp3' does not end in .wav"),
        (["listen", "a.wav", "--device", "mic"], "--device is the microphone"),
        (["speak", "x", "-o", "a.wav", "--device", "box"], "--device is the speaker"),
        (["voice", "a.wav", "--speaker", "box", "--ros"], "a FILE is listened to without devices"),
        (["listen", "--recogniser", ""], "no recogniser '' is known; there is: pocketsphinx, whisper"),
        (["listen", "--second", "sphinx"], "no recogniser 'sphinx' is known; did you mean 'pocketsphinx'?"),
        (["listen", "--recogniser", "pocketsphinx", "--second", ""], "'pocketsphinx' takes any sound for a phrase"),
        (["listen", "--second", "whisper"], "'whisper' as the second recogniser agrees with itself"),
        (["listen", "no.wav"], "there is no file no.wav"),
        (["listen", "pyproject.toml"], "pyproject.toml is no WAV file that can be read"),
    ],
)
def test_a_fault_of_the_input_is_one_sentence(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    assert main(words) == 2
    error = capsys.readouterr().err
    assert sentence in error and not caplog.records
    assert error.startswith(f"rai-missions {words[0]}: ")
    assert len(error.strip().splitlines()) == 1


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.drill
def test_an_unknown_recogniser_or_wake_word_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_wav(tmp_path / "a.wav", bytes(2048))
    assert main(["listen", str(tmp_path / "a.wav"), "--recogniser", "whispr"]) == 2
    assert capsys.readouterr().err.count("no recogniser 'whispr' is known; did you mean 'whisper'?") == 1
    assert main(["listen", str(tmp_path / "a.wav"), "--wake-word", "alexia"]) == 2
    assert "there is no wake word 'alexia'; did you mean 'alexa'?" in capsys.readouterr().err


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.drill
def test_the_doctor_opens_what_listens_and_speaks() -> None:
    found = {finding.what: finding for finding in speech()}
    assert found["voice flite"].status == "ok"
    assert all(each.status == "ok" for what, each in found.items() if what.startswith(("ear", "recogniser")))
    assert "GPL-3.0-or-later" in found["voice piper"].remedy
    assert any("microphones" in what or "devices of sound" in what for what in found)


def test_the_sound_of_a_conversation_needs_a_conversation(capsys: pytest.CaptureFixture[str]) -> None:
    mission = ["missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json"]
    assert main(["run", *mission, "--voice"]) == 2
    assert "--voice is the sound of a conversation: give --talk too" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--voice", "espeek"], "no voice 'espeek' is known; did you mean 'espeak'?"),
        (["--voice", "--recogniser", "wisper"], "no recogniser 'wisper' is known; did you mean 'whisper'?"),
        (["--voice", "--recogniser", ""], "no recogniser '' is known; there is: pocketsphinx, whisper"),
        (
            ["--recogniser", "pocketsphinx"],
            "the recogniser 'pocketsphinx' takes any sound for a phrase: it may be the second, which agrees",
        ),
        (["--wake-word", "alexa"], "--wake-word is of this machine's microphone: give --voice too"),
    ],
)
def test_what_speaks_and_listens_next_to_a_run_is_refused_before_the_start(
    capsys: pytest.CaptureFixture[str], words: list[str], why: str
) -> None:
    mission = ["missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json"]
    assert main(["run", *mission, "--talk", *words]) == 2
    assert capsys.readouterr().err == f"rai-missions run: {why}\n"


@needs_voice
@pytest.mark.xdist_group("voice")
@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--voice", "flite:spkr=slt"], "the voice 'flite' has no option 'spkr'; did you mean 'speaker'?"),
        (["--voice", "flite:speaker=bob"], "flite has no speaker 'bob'; there is: slt, rms, awb, kal, kal16"),
        (["--voice", "--wake-word", "alexia"], "there is no wake word 'alexia'; did you mean 'alexa'?"),
        (
            ["--voice", "--recogniser", "whisper:wieghts=base"],
            "the recogniser 'whisper' has no option 'wieghts'; did you mean 'weights'?",
        ),
    ],
)
def test_a_wrong_option_of_what_speaks_and_listens_is_named_ahead_of_the_device_and_the_journal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, words: list[str], why: str
) -> None:
    journal = tmp_path / "run.journal"
    mission = ["missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json"]
    assert main(["run", *mission, "--journal", str(journal), "--no-operator", "--talk", *words]) == 2
    out, error = capsys.readouterr()
    assert error.strip().splitlines()[-1] == f"rai-missions run: {why}" and not out
    assert not journal.exists()


def test_a_mission_behind_voice_is_the_mission() -> None:
    given = RunOptions(talk=True, voice="mission.json")
    assert normalise_voice_args(given) == RunOptions("mission.json", talk=True, voice="flite")
    named = RunOptions("mission.json", talk=True, voice="espeak")
    assert normalise_voice_args(named) == named


@needs_voice
@pytest.mark.drill
def test_a_run_that_cannot_be_spoken_with_names_the_device_and_does_not_begin(
    capsys: pytest.CaptureFixture[str],
) -> None:
    try:
        if sound_devices():
            pytest.skip("there are devices of sound here")
    except MissionError:
        pass
    mission = ["missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json"]
    assert main(["run", *mission, "--no-operator", "--talk", "--voice"]) == 2
    out, error = capsys.readouterr()
    assert "libportaudio2" in error or "doctor --voice" in error
    assert not out, "no journal is begun"
