# SPDX-License-Identifier: Apache-2.0
"""The command `campaign`, and what goes over the pipes of its workers."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.campaign.cells import Cell
from rai_missions.campaign.records import CellRecord, LabelRecord, PictureRecord, SceneRecord
from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import SceneTask
from rai_missions.campaign.worker import PIECE, record_words, task_in, task_words
from rai_missions.cli.main import main
from rai_missions.connectors.process.frames import LONGEST_REPLY, outward
from tests.campaign.choosing import campaign_data, write_campaign


def test_check_counts_the_cells(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_campaign(tmp_path, campaign_data(3))
    assert main(["campaign", "check", str(path)]) == 0
    expected = "choosing: 18 cells: 3 scenes × 3 models × 1 embodiment × 2 orders of options\n"
    assert capsys.readouterr().out == expected


@pytest.mark.parametrize(("scenes", "fault"), [
    ({"given": [{"scene": "a", "kind": "even", "seed": 1, "options": {"aleys": 2}}]},
     "/scenes/given/0/options: the world 'orchard' has no option 'aleys'"),
    ({"given": [{"scene": "a", "kind": "even", "seed": 1, "options": {"detector": {"mis": 0.5}}}]},
     "/scenes/given/0/options: detector: no option 'mis'"),
    ({"world": "house", "seeds": [3, -1]}, "/scenes/options: the world 'house' cannot be opened with seed=-1"),
    ({"seeds": [1], "options": {"conditions": {"fgo": 0.5}}}, "/scenes/options: conditions: no option 'fgo'"),
])  # fmt: skip
def test_check_reports_what_no_world_takes(
    scenes: dict[str, Any], fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_campaign(tmp_path, campaign_data() | {"scenes": {"world": "orchard"} | scenes})
    assert main(["campaign", "check", str(path)]) == 2
    assert fault in capsys.readouterr().err


NEEDY = {"type": "object", "properties": {"far_m": {"type": "number"}}, "required": ["far_m"]}


@pytest.mark.parametrize(("words", "fault"), [
    ({"labels": "rollouts"}, "/rollouts/parameters/left: the option is tried with these parameters, which do not fit: "
     "$: 'far_m' is a required property"),
    ({"rollouts": {"parameters": {"left": {"far_m": "3"}}}}, "$.far_m: '3' is not of type 'number'"),
    ({"rollouts": {"parameters": {"wait": {"s": 3}}}}, "/rollouts/parameters/wait: the option takes no parameters"),
    ({"models": ["local:none.gguf"], "scripts": {}}, "/models/0: there is no file 'none.gguf'; name a GGUF file"),
    ({"labels": "rollouts", "rollouts": {"parameters": {"left": {"far_m": 3}}}}, ""),
])  # fmt: skip
def test_check_reports_what_a_run_would_find_at_work(
    words: dict[str, Any], fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_campaign(tmp_path, campaign_data(1, **words))
    mission = json.loads((tmp_path / "mission.json").read_text())
    mission["states"]["choosing"]["decision"]["options"]["left"]["parameters"] = NEEDY
    (tmp_path / "mission.json").write_text(json.dumps(mission))
    assert main(["campaign", "check", str(path)]) == (2 if fault else 0)
    assert fault in capsys.readouterr().err


def test_a_world_that_lacks_its_package_is_refused_and_no_cell_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, store = write_campaign(tmp_path, campaign_data()), tmp_path / "a.db"
    (tmp_path / "mujoco.py").write_text("raise ModuleNotFoundError('gone', name='mujoco')", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    assert main(["campaign", "run", str(path), "--store", str(store), "--jobs", "1"]) == 2
    refusal = "a worker of the campaign cannot work: the world 'orchard' needs the package 'mujoco'"
    assert refusal in capsys.readouterr().err
    with ResultStore(store) as opened:
        assert list(opened.cells()) == []


def test_a_world_that_lacks_its_package_is_found_by_the_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_campaign(tmp_path, campaign_data())
    for name in [name for name in sys.modules if name.startswith("rai_missions.worlds.orchard")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["campaign", "check", str(path)]) == 2
    assert f"{path}: /scenes/world: the world 'orchard' needs the package 'mujoco'" in capsys.readouterr().err


def test_the_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "campaign"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "A campaign of rai_missions"


@pytest.mark.long
@pytest.mark.sim
def test_run_stores_reports_and_compares(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, store, page = write_campaign(tmp_path, campaign_data(1)), tmp_path / "a.db", tmp_path / "a.html"
    assert main(["campaign", "run", str(path), "--store", str(store), "--jobs", "1", "--report", str(page)]) == 0
    assert "6 cells answered, 0 without an answer, in " in capsys.readouterr().out
    assert page.exists() and page.with_suffix(".csv").exists()
    assert main(["campaign", "compare", str(store), str(store)]) == 0
    assert capsys.readouterr().out.strip()
    with ResultStore(store) as opened:
        assert opened.meta["name"] == "choosing"


@pytest.mark.parametrize("words", [["check"], ["run", "--jobs", "1"]])
def test_a_mission_in_python_is_not_executed_for_a_campaign(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, mark = write_campaign(tmp_path, campaign_data(1, mission="mission.py")), tmp_path / "executed"
    (tmp_path / "mission.py").write_text(f"open({str(mark)!r}, 'w').close()\n", encoding="utf-8")
    assert main(["campaign", words[0], str(path), "--store", str(tmp_path / "a.db"), *words[1:]]) == 2
    assert (
        "mission.py' is Python, which is not to be executed here; give the mission as JSON" in capsys.readouterr().err
    )
    assert not mark.exists()


@pytest.mark.sim
def test_label_reports_what_stopped_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, store = write_campaign(tmp_path, campaign_data(2, labels="rollouts")), tmp_path / "a.db"
    words = ["campaign", "label", str(path), "--store", str(store), "--jobs", "1", "--seconds", "1e-9"]
    assert main(words) == 1
    printed = capsys.readouterr().out
    assert re.match(r"(0 scenes with labels, 2 without|1 scene with labels, 1 without), in ", printed)
    assert f" s; the budget of 1e-09 seconds is spent; results: {store}" in printed


@pytest.mark.parametrize(("words", "fault"), [
    (["run", "CAMPAIGN", "--jobs", "0"], "--jobs is how many workers there are, 1 or more, not 0"),
    (["compare", "a.db"], "compare needs two stores"),
    (["run", "CAMPAIGN", "other.db"], "compare needs two stores"),
    (["report", "nowhere.db"], "no results at nowhere.db"),
    (["run", "CAMPAIGN", "--model", "openai:gpt", "--jobs", "1"], "OPENAI_API_KEY"),
    (["run", "CAMPAIGN", "--seconds", "0"], "--seconds is the wall time of the run, above 0, not 0"),
    (["run", "CAMPAIGN", "--report", "notes.txt", "--jobs", "1"], "not 'notes.txt'; name it .html"),
    (["run", "CAMPAIGN", "--replay-answers", "nowhere.db", "--jobs", "1"], "no results at"),
])  # fmt: skip
def test_a_wrong_use_is_named(
    tmp_path: Path, words: list[str], fault: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = write_campaign(tmp_path, campaign_data(1))
    given = [str(path) if word == "CAMPAIGN" else word for word in words]
    assert main(["campaign", *given]) == 2
    assert fault in capsys.readouterr().err


texts = st.text(max_size=20)


@given(texts, st.lists(texts, unique=True, max_size=3), st.dictionaries(texts, texts, max_size=3), st.booleans())
def test_a_task_over_a_pipe_is_the_same_task(scene: str, keys: list[str], labels: dict[str, str], shows: bool) -> None:
    cells = tuple((key, Cell("m", scene, 3, "rules", "none", "written")) for key in keys)
    task = SceneTask(SceneRecord(scene, "orchard", "log", 3, "tune", "{}"), cells, labels, shows)
    assert task_in(json.loads(json.dumps(task_words(task)))) == task


@pytest.mark.parametrize("size", [0, 1, PIECE - 1, PIECE, PIECE + 1, 3 * PIECE])
def test_a_picture_goes_in_pieces_that_fit(size: int) -> None:
    messages = list(record_words(PictureRecord("s", "camera", bytes(size))))
    assert [message["is_last"] for message in messages] == [False] * (len(messages) - 1) + [True]
    assert all(len(outward(message)[0]) < LONGEST_REPLY for message in messages)


def test_other_records_are_one_message_each() -> None:
    cell = CellRecord("k", "m", "s", 1, "rules", "none", "written", "answered", raw="x" * 20_000)
    for record in (cell, LabelRecord("s", "left", "harms", "{}")):
        (message,) = record_words(record)
        assert message == {"record": type(record).__name__, "of": list(record)}
        assert len(outward(message)[0]) < LONGEST_REPLY
