# SPDX-License-Identifier: Apache-2.0
"""`rai-missions prove` as it is typed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from tests.prove.explored import ROOT
from tests.prove.test_missions import TRACTOR, Json, over_people


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Writes a mission with a change into an empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)

    def write(change: Callable[[Json], Any] = lambda given: None) -> str:
        given = json.loads((ROOT / TRACTOR).read_text(encoding="utf-8"))
        change(given)
        Path("mission.json").write_text(json.dumps(given), encoding="utf-8")
        return "mission.json"

    return write


def test_what_is_proved_is_reported_claim_by_claim(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["prove", written()]) == 0
    reported = capsys.readouterr().out
    assert reported.startswith("tractor_orchard 1.0.0: ") and reported.count("  proved ") == 9
    assert "the operator may pause, stop, resume" in reported and "not explored: a process that is killed" in reported
    assert not list(Path().glob("*.journal"))


def test_a_refutation_is_reported_and_written_down(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    mission = written(over_people)
    assert main(["prove", mission, "-o", "runs/flaw.journal"]) == 1
    reported = capsys.readouterr().out
    assert (
        "  refuted        invariants:" in reported
        and "      4. answer of the model to 'assessing': drive_over" in reported
    )
    assert main(["replay", "runs/flaw.journal"]) == 0
    assert "aborted: invariant 'nobody_is_driven_over' is false" in capsys.readouterr().out
    assert main(["draw", mission, "--journal", "runs/flaw.journal", "-o", "flaw.dot"]) == 0


def test_a_journal_that_cannot_be_written_takes_no_proof_away(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    mission = written(over_people)
    Path("full").write_text("a file where a folder is wanted")
    assert main(["prove", mission, "-o", "full/flaw.journal"]) == 1
    reported = capsys.readouterr().out
    assert "  refuted        invariants:" in reported and reported.count("  proved ") == 8
    assert "      a journal cannot be written at full/flaw.journal: Not a directory; name another file" in reported
    assert main(["prove", mission, "-o", "full/flaw.journal", "--json"]) == 1
    (flaw,) = [each for each in json.loads(capsys.readouterr().out)["claims"] if each["verdict"] == "refuted"]
    assert flaw["journal"] is None and flaw["unwritten"].startswith("a journal cannot be written") and flaw["run"]


def test_the_facts_of_a_refutation_are_written_as_in_a_mission(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    def at_a_place(given: Json) -> None:
        given["blackboard"]["gate"] = {"type": "pose", "source": "argument", "frame": "map"}
        given["invariants"]["away"] = {"key": "gate.x", "!=": 0}

    assert main(["prove", written(at_a_place)]) == 1
    assert 'gate {"x": 0.0, "y": 0.0, "frame": "map"}' in capsys.readouterr().out


def test_a_journal_that_is_there_is_left_alone(written: Callable[..., str]) -> None:
    mission = written(over_people)
    for _ in range(2):
        assert main(["prove", mission]) == 1
    assert sorted(path.name for path in Path().glob("*.journal")) == [
        "tractor_orchard-invariants-2.journal",
        "tractor_orchard-invariants.journal",
    ]


def test_the_object_holds_what_the_lines_state(written: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prove", written(over_people), "--json"]) == 1
    reported = json.loads(capsys.readouterr().out)
    refuted = [claim for claim in reported["claims"] if claim["verdict"] == "refuted"]
    assert reported["verdict"] == "refuted" and [claim["claim"] for claim in refuted] == ["invariants"]
    assert refuted[0]["shows"] is True and refuted[0]["run"][-1]["outcome"] == "aborted"


def test_a_bound_that_was_hit_is_no_proof(written: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prove", written(), "--states", "10"]) == 1
    assert "explored 10 states" in capsys.readouterr().out


def test_input_at_fault_is_reported_before_anything_is_explored(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(given: Json) -> None:
        given["states"]["crossing"]["transitions"][0]["to"] = "asessing"

    assert main(["prove", written(broken)]) == 2
    assert "did you mean 'assessing'?" in capsys.readouterr().err
    assert main(["prove", written(), "--states", "0"]) == 2
    assert "give --states a number above 0" in capsys.readouterr().err
