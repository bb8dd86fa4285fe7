# SPDX-License-Identifier: Apache-2.0
"""A notebook shows a mission, and nothing is sent to a notebook where there is none."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.visualize.runs import ROOT, tractor, tractor_path
from visualize import show
from visualize.notebook import show_missions

SHOWN = """
from IPython.core.interactiveshell import InteractiveShell
shell = InteractiveShell.instance()
from rai_missions import load
mission = load("missions/tractor/mission.json")
before, _ = shell.display_formatter.format(mission)
import visualize
after, _ = shell.display_formatter.format(mission)
run, _ = shell.display_formatter.format(visualize.show(mission))
print(*sorted(before), "|", *sorted(after), "|", *sorted(run))
assert "image/svg+xml" not in after or "tractor_orchard" in after["image/svg+xml"]
assert after.get("image/svg+xml") == run.get("image/svg+xml")
"""


def notebook(**more: str) -> str:
    pytest.importorskip("IPython", reason="IPython is not installed")
    reported = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, '.')\n{SHOWN}"],
        cwd=ROOT,
        text=True,
        capture_output=True,
        check=False,
        env=more or None,
    )
    assert reported.returncode == 0, reported.stderr
    return reported.stdout.strip()


def test_a_notebook_shows_a_mission_once_visualize_is_imported(tmp_path: Path) -> None:
    path = f"{Path(sys.executable).parent}:/usr/bin:/bin"
    assert (
        notebook(PATH=path, IPYTHONDIR=str(tmp_path))
        == "text/plain | image/svg+xml text/plain | image/svg+xml text/plain"
    )


def test_a_drawing_is_an_svg_with_the_path_of_a_run() -> None:
    shown = show(tractor(), tractor_path())
    svg = shown._repr_svg_()
    assert svg is not None and svg.startswith("<?xml") and "entered 2× in steps" in svg.replace("\u00a0", " ")
    assert shown._repr_markdown_() is None
    assert repr(shown) == "<tractor_orchard: 10 states, 14 edges>"


def test_without_graphviz_a_notebook_shows_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    shown = show(tractor())
    assert shown._repr_svg_() is None
    assert (shown._repr_markdown_() or "").startswith("# tractor")


def test_where_there_is_no_notebook_nothing_is_loaded_and_nothing_registered() -> None:
    code = "import sys, visualize; assert not any(name.startswith('IPython') for name in sys.modules)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    assert not show_missions()
