# SPDX-License-Identifier: Apache-2.0
"""How many steps a run took: one number, whichever command or page shows it."""

from __future__ import annotations

import json
import re
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.engine import Chart
from rai_missions.engine.step import step_count
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.runtime.result import Result
from tests.rigs.runs import Rig, mission
from tests.visualize.page.reading import data_of

RESTING = mission({"resting": {"transitions": [{"on": "go", "to": "over"}]}, "over": {"final": "aborted"}})


def sensed_run(path: Path) -> Result:
    """A run in which most steps are readings that enable nothing, which a journal holds with the next row."""
    with closing(Journal.create(path, Header(dump(RESTING)))) as journal:
        rig = Rig(RESTING, journal=journal)
        rig.stage.play({at / 10: lambda at=at: rig.publish("/battery", percentage=1 - at / 100) for at in range(1, 30)})
        rig.stage.play({3.0: lambda: rig.post("go")})
        return rig.run()


def printed(capsys: pytest.CaptureFixture[str], *command: str) -> str:
    main(list(command))
    return capsys.readouterr().out


def test_run_replay_drawing_and_page_report_one_number_of_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    result = sensed_run(Path("a.journal"))
    Path("m.json").write_text(dump(RESTING))
    replayed: dict[str, Any] = json.loads(printed(capsys, "replay", "a.journal", "--json"))
    words = printed(capsys, "replay", "a.journal")
    printed(capsys, "draw", "m.json", "--journal", "a.journal", "-o", "m.md")
    printed(capsys, "draw", "m.json", "--journal", "a.journal", "-o", "m.html")
    drawn = re.search(r"A run of (\d+) steps", Path("m.md").read_text())
    (run,) = data_of(Path("m.html").read_bytes())["runs"]
    assert drawn is not None
    assert result.steps == replayed["steps"] == int(drawn[1]) == run["count"]
    assert result.steps > 2 * len(run["steps"])  # readings are steps, and have no rows of their own
    assert words.startswith(f"{result.steps} steps done again from {len(run['steps'])} rows, all the same")


def test_two_runs_have_the_steps_of_both() -> None:
    first, second = Chart(RESTING), Chart(RESTING)
    steps = [first.start(at=0.0), first.send(Event("go", 1.0))]
    for at in range(3):
        second.write("battery", 0.5, at=at / 10)
    later = [second.start(at=0.3)]
    assert (step_count(()), step_count(steps), step_count([*steps, *later])) == (0, 2, 6)


def test_one_of_a_thing_is_in_the_singular(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.json").write_text(json.dumps({"name": "m", "initial": "over", "states": {"over": {"final": "aborted"}}}))
    printed(capsys, "run", "m.json", "--journal", "a.journal")
    printed(capsys, "draw", "m.json", "--journal", "a.journal", "-o", "m.md")
    words = Path("m.md").read_text(encoding="utf-8")
    words += printed(capsys, "check", "m.json") + printed(capsys, "prove", "m.json").partition("\n")[0]
    assert re.findall(r"\b1 (?:state|step)s?\b", words) == ["1 step", "1 state", "1 state", "1 step"]
