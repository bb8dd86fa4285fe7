# SPDX-License-Identifier: Apache-2.0
"""The mission that the guide to the desk shows is checked and run as its reader does."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.cli.main import main
from tests.test_docs import ROOT, blocks

PROFILE = str(ROOT / "missions/desk/robot.sim.json")


@pytest.mark.long
def test_the_mission_of_the_guide_has_no_fault_and_succeeds(tmp_path: Path) -> None:
    guide = (ROOT / "docs/guide/desk.md").read_text(encoding="utf-8")
    shown = next(each.text for each in blocks(guide) if each.kind == "json" and '"format"' in each.text)
    mission = tmp_path / "mine.json"
    mission.write_text(shown, encoding="utf-8")
    assert main(["check", str(mission), "--robot", PROFILE]) == 0
    journal = str(tmp_path / "run.journal")
    assert main(["run", str(mission), "--robot", PROFILE, "--no-operator", "--journal", journal]) == 0
