# SPDX-License-Identifier: Apache-2.0
"""Pictures become whole files or none, and drawing loads nothing before it must."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rai_missions.errors import UsageError
from tests.visualize.changed import changed
from tests.visualize.runs import ROOT, tractor, tractor_path
from visualize import FORMATS, difference, draw, draw_difference, drawn, picture


@pytest.mark.parametrize("form", FORMATS)
def test_a_picture_is_drawn_by_the_ending_of_its_file(form: str, tmp_path: Path) -> None:
    path = draw(tractor(), tmp_path / f"tractor.{form.upper()}", tractor_path())
    assert path.read_bytes() == drawn(picture(tractor(), tractor_path()), form)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_an_unknown_ending_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"tractor.bmp' .*the endings are .svg, .png, .dot, .mmd, .mermaid, .md"):
        draw(tractor(), tmp_path / "tractor.bmp")
    with pytest.raises(UsageError, match=r"not drawn as 'bmp'; the endings are .svg"):
        drawn(picture(tractor()), "bmp")
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written_is_reported_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match=r"a.dot' cannot be written: Not a directory; name another file"):
        draw(tractor(), tmp_path / "file" / "a.dot")
    (tmp_path / "folder.dot").mkdir()
    with pytest.raises(UsageError, match="cannot be written"):
        draw(tractor(), tmp_path / "folder.dot")
    assert {each.name for each in tmp_path.iterdir()} == {"file", "folder.dot"}


def test_a_picture_that_cannot_be_drawn_leaves_the_old_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.svg"
    path.write_text("old")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(UsageError):
        draw(tractor(), path)
    assert path.read_text() == "old"


def test_a_difference_is_drawn_like_a_mission(tmp_path: Path) -> None:
    found = difference(tractor(), changed())
    text = draw_difference(found, tmp_path / "a.mmd").read_text()
    assert "accTitle: tractor_orchard 1.1.0" in text
    with pytest.raises(UsageError, match=r"the endings are .html, .md, .json, .svg, .png, .dot, .mmd, .mermaid"):
        draw_difference(found, tmp_path / "a.txt")


def test_visualize_loads_graphviz_only_to_draw_with_it() -> None:
    code = "import sys, visualize; assert not {'graphviz', 'py_trees', 'rclpy'} & sys.modules.keys()"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
