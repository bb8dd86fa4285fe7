# SPDX-License-Identifier: Apache-2.0
"""Recordings at the command line: made, replayed, drawn, refused."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.main import main
from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.journal import Journal
from rai_missions.mission.json_reader import parse_json
from rai_missions.profile import Robot
from rai_missions.recording import journal_of
from rai_missions.replay.replay import replay
from tests.recording.kept import kept
from tests.rigs.journals import raw_rows_of
from tests.rigs.lamp import LAMP, lamp_folder

pytest.importorskip("mcap")
TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return lamp_folder(tmp_path, monkeypatch)


def test_a_run_is_recorded_replayed_and_drawn(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "lamp.json", "--journal", "a.journal", "--record", "out/run.mcap"]) == 1
    assert "recording: out/run.mcap (" in capsys.readouterr().out
    assert main(["replay", "out/run.mcap"]) == 0
    assert "2 steps done again from 2 rows, all the same; aborted: 'off' was reached" in capsys.readouterr().out
    assert main(["draw", "lamp.json", "--journal", "a.journal", "-o", "journal.dot"]) == 0
    assert main(["draw", "lamp.json", "--journal", "out/run.mcap", "-o", "recording.dot"]) == 0
    assert (folder / "journal.dot").read_text() == (folder / "recording.dot").read_text()
    with journal_of("out/run.mcap") as replayed:
        assert raw_rows_of(replayed.path) == raw_rows_of(folder / "a.journal")


def test_a_run_in_json_names_its_recording(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "lamp.json", "--journal", "a.journal", "--record", "run.mcap", "--json"])
    assert json.loads(capsys.readouterr().out)["recording"] == "run.mcap"


def test_a_recording_of_the_same_name_is_moved_aside(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        main(["run", "lamp.json", "--record", "run.mcap"])
    assert "the recording of an earlier run, which had this name, is now run.1.mcap" in capsys.readouterr().err
    assert main(["replay", "run.mcap"]) == main(["replay", "run.1.mcap"]) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--record", "run.bag"], "'run.bag' does not end so; name it 'run.mcap'"),
        (["--record", "notes.mcap"], "notes.mcap is there already, and is no recording; name another file"),
        (["--record", "lamp.json/run.mcap"], "a recording cannot be written at lamp.json/run.mcap: "),
        (["--record", "run.mcap", "--managed"], "--record is of one run"),
    ],
)
def test_what_cannot_be_recorded_is_refused_before_anything_happens(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    (folder / "notes.mcap").write_text("notes of mine")
    assert main(["run", "lamp.json", "--journal", "a.journal", *words]) == 2
    assert message in capsys.readouterr().err
    assert (folder / "notes.mcap").read_text() == "notes of mine"
    assert sorted(path.name for path in folder.iterdir()) == ["lamp.json", "notes.mcap"]


def test_without_the_library_a_run_that_is_recorded_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mcap", None)
    assert main(["run", "lamp.json", "--record", "run.mcap"]) == 2
    assert "[record]'" in capsys.readouterr().err


def test_a_recording_that_was_cut_off_is_replayed_as_far_as_it_goes(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["run", "lamp.json", "--record", "run.mcap"])
    whole = (folder / "run.mcap").read_bytes()
    (folder / "run.mcap").write_bytes(whole[: whole.index(b"rai_missions/end")])
    capsys.readouterr()
    assert main(["replay", "run.mcap"]) == 0
    printed = capsys.readouterr()
    assert "run.mcap is cut off" in printed.err and "2 steps done again" in printed.out


def test_a_recording_that_was_damaged_is_not_replayed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "lamp.json", "--record", "run.mcap"])
    bytes_of_it = bytearray((folder / "run.mcap").read_bytes())
    bytes_of_it[bytes_of_it.index(b"zstd") + 40] ^= 0xFF
    (folder / "run.mcap").write_bytes(bytes_of_it)
    assert main(["replay", "run.mcap"]) == 2
    assert "run.mcap: /: the recording is damaged before byte" in capsys.readouterr().err


def test_what_is_no_recording_is_not_replayed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "notes.mcap").write_text("notes of mine")
    assert main(["replay", "notes.mcap"]) == main(["replay", "missing.mcap"]) == 2
    printed = capsys.readouterr().err
    assert "no MCAP file; give one that `rai-missions run --record` has written" in printed
    assert "missing.mcap: there is no such file" in printed


def test_a_run_that_continues_is_recorded_from_its_beginning(folder: Path) -> None:
    """The recording of a run that continues holds what its journal held before."""
    slow = {**LAMP, "states": {**LAMP["states"], "on": {"transitions": [{"after_s": 0.5, "to": "off"}]}}}  # type: ignore[dict-item]
    (folder / "slow.json").write_text(json.dumps(slow))
    with prepare(RunConfig("slow.json", journal="b.journal")) as prepared:
        step = Chart(prepared.mission).start(0.0)
        assert isinstance(prepared.journal, Journal)
        prepared.journal.write(step, since=0.0)
    assert main(["run", "--resume", "b.journal", "--record", "run.mcap"]) == 1
    with journal_of("run.mcap") as replayed:
        assert raw_rows_of(replayed.path) == raw_rows_of(folder / "b.journal")
        assert replay(replayed.path).outcome == "aborted"


def test_a_journal_is_written_next_to_a_recording_where_none_is_named(tmp_path: Path) -> None:
    (tmp_path / "lamp.json").write_text(json.dumps(LAMP))
    with prepare(RunConfig(tmp_path / "lamp.json", record=tmp_path / "run.mcap")) as prepared:
        assert prepared.runner.run().journal == str(tmp_path / "run.journal")
    with prepare(RunConfig(tmp_path / "lamp.json", record=tmp_path / "run.mcap")) as prepared:
        assert prepared.recording is not None and prepared.recording.moved_aside == tmp_path / "run.1.mcap"
        assert prepared.moved_aside == str(tmp_path / "run.1.journal")


def test_a_run_that_breaks_off_leaves_a_recording_that_is_whole(tmp_path: Path) -> None:
    seen: list[Step] = []
    lamp = {**LAMP, "ready_s": 0.01, "blackboard": {"battery": {"type": "number", "source": "robot"}}}
    (tmp_path / "lamp.json").write_text(json.dumps(lamp))
    silent = Robot.model_validate({"name": "silent", "blackboard": {"battery": {"topic": "/b", "type": "x/msg/B"}}})
    setting = RunConfig(tmp_path / "lamp.json", silent, record=tmp_path / "run.mcap", on_step=seen.append)
    with prepare(setting) as prepared, pytest.raises(UsageError, match="the robot has not reported"):
        prepared.runner.run()
    with journal_of(tmp_path / "run.mcap") as replayed:
        assert replayed.warning == ""
        assert "the run breaks off" in str(raw_rows_of(replayed.path)[-1])


@pytest.mark.long
@pytest.mark.sim
def test_a_run_of_the_tractor_is_recorded_with_what_its_camera_saw(tmp_path: Path) -> None:
    profile = parse_json((TRACTOR / "robot.sim.json").read_bytes(), "robot.sim.json")
    profile["connector"] |= {"alleys": 1, "obstacles": ["branch"]}
    path, words = tmp_path / "run.mcap", {"arguments": {"alleys": 1}}
    with prepare(
        RunConfig(TRACTOR / "mission.json", Robot.model_validate(profile), record=path, **words)  # type: ignore[arg-type]
    ) as prepared:
        result = prepared.runner.run()
    assert result.outcome == "succeeded"
    found = kept(path)
    picture = found.messages["/tractor1/camera_image_color"][0]
    assert found.schemas["/tractor1/camera_image_color"][0][0] == "foxglove.RawImage"
    assert (picture["width"], picture["height"], picture["encoding"], picture["frame_id"]) == (
        640,
        480,
        "rgb8",
        "camera",
    )
    assert {
        "/tractor1/battery",
        "/tractor1/obstacle",
        "/rai_missions/calls",
        "/rai_missions/goals",
    } <= found.messages.keys()
    assert [each["mode"] for each in found.messages["/rai_missions/status"]][-1] == "succeeded"
    assert any(step["verdicts"] for step in found.messages["/rai_missions/steps"])
    assert all(len(name) == 64 for name in found.attachments)
    with journal_of(path) as replayed:
        assert raw_rows_of(replayed.path) == raw_rows_of(tmp_path / "run.journal")
        again = replay(replayed.path)
        assert again.holds and again.outcome == "succeeded"
