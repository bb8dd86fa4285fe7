# SPDX-License-Identifier: Apache-2.0
"""The package as a user installs it: whole, light to import, its command line at work. Run on the built wheel too."""

from __future__ import annotations

import importlib.metadata
import json
import subprocess
import sys
from pathlib import Path

import pytest

import rai_missions
import visualize

pytestmark = pytest.mark.installed

MISSION = str(Path(__file__).parents[1] / "missions" / "tractor" / "mission.json")
HEAVY = ("anthropic", "langchain_core", "langchain_openai", "mujoco", "openai", "py_trees", "rclpy", "xllamacpp")


def rai_missions_command(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    script = Path(sys.executable).with_name("rai-missions")
    return subprocess.run(
        [script, *arguments], cwd=cwd, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False
    )


def test_both_packages_come_from_one_place_and_are_typed() -> None:
    ours, drawing = Path(rai_missions.__file__).parent, Path(visualize.__file__).parent
    assert ours.parent == drawing.parent
    assert (ours / "py.typed").exists()
    assert (drawing / "py.typed").exists()


def test_the_licence_travels_with_the_package() -> None:
    metadata = importlib.metadata.metadata("rai-missions")
    assert metadata["License-Expression"] == "Apache-2.0"


@pytest.mark.parametrize("code", ["import rai_missions", "from rai_missions.cli.main import main; main(['--help'])"])
def test_what_is_heavy_is_imported_when_used(code: str) -> None:
    reported = (
        f"import sys\ntry:\n    {code}\nexcept SystemExit: pass\nprint([m for m in {HEAVY!r} if m in sys.modules])"
    )
    received = subprocess.run([sys.executable, "-c", reported], capture_output=True, text=True, check=True)
    assert received.stdout.splitlines()[-1] == "[]"


def test_help_names_every_command() -> None:
    received = rai_missions_command("--help")
    assert received.returncode == 0, received.stderr
    assert all(
        word in received.stdout for word in ("run", "check", "draw", "diff", "replay", "schema", "new", "doctor")
    )


def test_the_shipped_mission_passes_the_check() -> None:
    received = rai_missions_command("check", MISSION)
    assert received.returncode == 0, received.stdout + received.stderr


def test_a_faulty_mission_is_refused_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "bad.json").write_text('{"format": 1, "name": "bad", "initial": "nowhere", "states": {"here": {}}}')
    received = rai_missions_command("check", "bad.json", cwd=tmp_path)
    assert received.returncode == 2
    assert "nowhere" in received.stderr
    assert "Traceback" not in received.stderr


def test_the_schema_is_shipped() -> None:
    received = rai_missions_command("schema")
    assert received.returncode == 0, received.stderr
    assert json.loads(received.stdout)["$schema"]


def test_a_picture_is_drawn(tmp_path: Path) -> None:
    received = rai_missions_command("draw", MISSION, "-o", "tractor.svg", cwd=tmp_path)
    assert received.returncode == 0, received.stderr
    assert "<svg" in (tmp_path / "tractor.svg").read_text(encoding="utf-8")


def test_a_review_page_is_written_with_all_that_it_shows(tmp_path: Path) -> None:
    done = rai_missions_command("draw", MISSION, "-o", "review.html", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "review.html").read_text(encoding="utf-8")
    assert '"name":"tractor_orchard"' in page
    assert "class Chart {" in page
