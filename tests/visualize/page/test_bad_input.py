# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a mission or a journal is on the page where that helps, else it is reported."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path

import pytest

from rai_missions.check import check
from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.image import Image
from rai_missions.mission.mission import Mission
from tests.visualize.page.reading import answered, data_of, journal_of
from tests.visualize.runs import ROOT, document, tractor
from visualize import draw, draw_review
from visualize.page import review
from visualize.page.images import Gallery


def broken(path: Path) -> Path:
    database = sqlite3.connect(path)
    database.execute("UPDATE rows SET content = replace(content, 'anomaly', 'anomalx') WHERE number > 2")
    database.commit()
    database.close()
    return path


def test_a_journal_of_another_mission_is_refused_with_its_name(tmp_path: Path) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    other = Mission.model_validate({**document(), "name": "other"})
    with pytest.raises(DefinitionError, match=r"journal of another mission, 'tractor_orchard' 1.0.0, not of 'other'"):
        review(other, [path])


def test_a_journal_of_another_version_is_shown_with_that_on_the_page(tmp_path: Path) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    newer = Mission.model_validate({**document(), "version": "1.1.0"})
    [run] = data_of(review(newer, [path]))["runs"]
    assert run["steps"]
    assert run["faults"][0].startswith("this is the journal of version 1.0.0, drawn on 1.1.0")


def test_an_altered_journal_is_shown_with_the_rows_that_were(tmp_path: Path) -> None:
    path = broken(journal_of(tmp_path / "a.journal", tractor(), answered(tractor())))
    [run] = data_of(review(tractor(), [path]))["runs"]
    assert run["steps"]
    assert any("the journal was altered after the run" in fault for fault in run["faults"])


def test_a_row_that_cannot_be_read_ends_the_run_on_the_page_and_is_named(tmp_path: Path) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    database = sqlite3.connect(path)
    database.execute("UPDATE rows SET content = '{' WHERE number = 4")
    database.commit()
    database.close()
    [run] = data_of(review(tractor(), [path]))["runs"]
    assert len(run["steps"]) == 3
    assert any("row 4" in fault for fault in run["faults"])


def test_what_is_no_journal_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.journal").write_text("nothing of the kind")
    with pytest.raises(DefinitionError, match=r"a\.journal"):
        review(tractor(), [tmp_path / "a.journal"])
    with pytest.raises(UsageError, match="nowhere"):
        review(tractor(), [tmp_path / "nowhere.journal"])


def test_a_mission_that_does_not_check_is_drawn_with_what_was_found() -> None:
    given = document()
    given["states"]["crossing"]["transitions"][1]["to"] = "nowhere"
    mission = Mission.model_validate(given)
    data = data_of(review(mission, findings=check(mission)))
    assert {"place": "/states/crossing/transitions/1/to", "severity": "error"}.items() <= next(
        found.items() for found in data["findings"] if "nowhere" in found["sentence"]
    )
    assert "crossing" in {state["name"] for state in data["chart"]["states"]}


def test_a_picture_is_what_its_first_bytes_say() -> None:
    gallery = Gallery()
    jpeg = gallery.add(Image("a", 1, 1, "png", b"\xff\xd8\xff and more"))
    script = gallery.add(Image("b", 1, 1, "png", b"<svg onload=alert(1)>"))
    short = gallery.add(Image("c", 2, 2, "rgb8", b"123"))
    assert gallery.shown[jpeg]["uri"].startswith("data:image/jpeg;base64,")
    assert gallery.shown[script] == {"why": "its 21 bytes are neither PNG nor JPEG"}
    assert "uri" not in gallery.shown[short]


def test_pictures_that_are_too_many_are_left_out_and_that_is_reported() -> None:
    gallery = Gallery(budget=20)
    first = gallery.add(Image("a", 1, 1, "jpeg", b"\xff\xd8\xff first"))
    second = gallery.add(Image("b", 1, 1, "jpeg", b"\xff\xd8\xff second, and longer"))
    assert "uri" in gallery.shown[first]
    assert gallery.shown[second]["why"].startswith("left out")


def test_a_picture_whose_bytes_were_not_kept_is_reported() -> None:
    def lost() -> bytes:
        raise UsageError("the journal keeps pictures that a question showed")

    gallery = Gallery()
    name = gallery.add(Image("a", 1, 1, "png", lost))
    assert gallery.shown[name] == {"why": "the journal keeps pictures that a question showed"}


def test_draw_writes_the_page_from_several_journals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [journal_of(tmp_path / f"{name}.journal", tractor(), answered(tractor())) for name in "ab"]
    mission, page = tmp_path / "mission.json", tmp_path / "review.html"
    mission.write_text(json.dumps(document()))
    given = [part for path in paths for part in ("--journal", str(path))]
    assert main(["draw", str(mission), "-o", str(page), *given]) == 0
    assert capsys.readouterr().out == f"{page}\n"
    assert [run["name"] for run in data_of(page.read_bytes())["runs"]] == ["a.journal", "b.journal"]


def test_draw_reports_on_stderr_that_a_journal_was_altered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = broken(journal_of(tmp_path / "a.journal", tractor(), answered(tractor())))
    given = ["draw", str(ROOT / "tests/data/tractor_design.json"), "-o", str(tmp_path / "a.html")]
    assert main([*given, "--journal", str(path)]) == 0
    printed = capsys.readouterr().err
    assert printed.startswith(f"{path}: drawn with this error: row ")
    assert printed.endswith("the journal was altered after the run\n")
    assert len(printed.splitlines()) == 1


@pytest.mark.parametrize("ending", ["html", "svg"])
def test_draw_reports_on_stderr_that_a_mission_does_not_check(
    ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written = document()
    written["states"]["crossing"]["transitions"][1]["to"] = "nowhere"
    mission = tmp_path / "mission.json"
    mission.write_text(json.dumps(written))
    assert main(["draw", str(mission), "-o", str(tmp_path / f"a.{ending}")]) == 0
    printed = capsys.readouterr().err
    assert printed.startswith(f"{mission}: drawn with this error: /states/crossing/transitions/1/to")
    assert len(printed.splitlines()) == 1


@pytest.mark.parametrize("ending", ["html", "svg"])
@pytest.mark.parametrize("kept", [1000, 6000, 20000])
def test_a_torn_journal_is_called_damaged(
    ending: str, kept: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))
    path.write_bytes(path.read_bytes()[:kept])
    page = tmp_path / f"a.{ending}"
    given = ["draw", str(ROOT / "tests/data/tractor_design.json"), "-o", str(page), "--journal", str(path)]
    assert main(given) == 2
    printed = capsys.readouterr().err
    assert "the journal is damaged: a part of its file is missing or was overwritten" in printed
    assert "malformed" not in printed
    assert not page.exists()


def test_draw_reports_what_keeps_a_journal_from_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "review.html"
    given = ["draw", str(ROOT / "missions/tractor/mission.json"), "-o", str(page)]
    assert main([*given, "--journal", str(tmp_path / "none.journal")]) == 2
    assert "none.journal" in capsys.readouterr().err
    assert not page.exists()


def test_a_run_without_a_journal_is_on_the_page_too(tmp_path: Path) -> None:
    page = draw(tractor(), tmp_path / "a.HTML", answered(tractor()))
    assert len(data_of(page.read_bytes())["runs"][0]["steps"]) == len(answered(tractor()))
    assert data_of(draw(tractor(), page).read_bytes())["runs"] == []


def test_a_review_ends_in_html(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"the endings are \.html"):
        draw_review(tractor(), tmp_path / "a.svg")
