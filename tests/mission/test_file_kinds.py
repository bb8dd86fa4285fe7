# SPDX-License-Identifier: Apache-2.0
"""A file that is given in place of another is named, by each command that reads one."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.cli.main import main

ROOT = Path(__file__).parents[2]
MISSION, PROFILE = str(ROOT / "missions/tractor/mission.json"), str(ROOT / "missions/tractor/robot.sim.json")
CAMPAIGN = str(ROOT / "campaigns/quick.json")
MISTAKES = [
    (["check", PROFILE], f"{PROFILE}: /: this is a robot's profile; name a mission, and give this file with --robot"),
    (["prove", CAMPAIGN], f"{CAMPAIGN}: /: this is a campaign; rai-missions campaign runs it"),
    (["check", MISSION, "--robot", MISSION], f"{MISSION}: /: this is a mission; --robot takes a robot's profile"),
    (["campaign", "check", MISSION], f"{MISSION}: /: this is a mission; a campaign names one as its 'mission'"),
    (["campaign", "check", PROFILE], f"{PROFILE}: /: this is a robot's profile; a campaign names one as its 'robot'"),
]


@pytest.mark.parametrize(("words", "sentence"), MISTAKES)
def test_a_file_of_another_kind_is_named_in_one_line(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    printed = capsys.readouterr()
    lines = [line for line in (printed.out + printed.err).splitlines() if "this is" in line]
    assert len(lines) == 1 and lines[0].startswith(sentence)


def test_a_mission_without_states_is_still_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "m.json").write_text('{"format": 1, "name": "m"}', encoding="utf-8")
    assert main(["check", str(tmp_path / "m.json")]) == 2
    assert "'states' is missing" in "".join(capsys.readouterr())
