# SPDX-License-Identifier: Apache-2.0
"""A run whose decision names `recall`: the model looks things up in the profile's identity, within its budget."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from langchain_core.messages import AIMessage

from rai_missions.agents import run
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError
from rai_missions.journal import read
from rai_missions.testing import call
from tests.rigs.documents import plain

CHOICE = AIMessage("", tool_calls=[call("left", number="2")])


def files(folder: Path, *, identity: bool = True, **decision: Any) -> tuple[Path, Path]:
    asked = {
        "question": "Where to?", "options": {"left": {}, "right": {}}, "ask": ["agent"], "deadline_s": 20,
        "fallback": "right", "tools": ["recall"], **decision,
    }  # fmt: skip
    states = {
        "asks": {"decision": asked, "transitions": [{"on": "left", "to": "l"}, {"on": "right", "to": "r"}]},
        "l": {"final": "aborted"}, "r": {"final": "failed"},
    }  # fmt: skip
    mission = {"format": 1, "name": "way", "version": "1.0.0", "initial": "asks", "states": states}
    profile: dict[str, Any] = {"format": 1, "name": "r", "connector": {"kind": "local"}, "blackboard": {}}
    (folder / "mission.json").write_text(json.dumps(mission))
    (folder / "robot.json").write_text(json.dumps(profile | ({"identity": "identity"} if identity else {})))
    (folder / "identity").mkdir()
    (folder / "identity" / "description.md").write_text("I am a small robot.")
    (folder / "identity" / "rules.txt").write_bytes(
        plain([(1, "Rules"), (0, "The key sk-proj-Zk3mQ9vT7wXyB2nC5dF8hJ1lP4rS6uA0 opens it. Keep to the wall.")])
    )
    return folder / "mission.json", folder / "robot.json"


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("rai_missions.embodiment.library.minilm", lambda: None)


def looking(question: str) -> AIMessage:
    return AIMessage("", tool_calls=[call("recall", question=question)])


def test_a_decision_looks_its_documents_up_and_the_journal_has_what_it_read(tmp_path: Path) -> None:
    mission, robot = files(tmp_path)
    model = ScriptedModel([looking("Which wall should I keep to?"), CHOICE])
    result = run(mission, robot, model=model, journal=tmp_path / "run.journal")
    assert result.why == "'l' was reached"
    (tool,) = [str(each.content) for each in model.received[-1][0] if each.type == "tool"]
    assert '"source": "rules.txt, Rules"' in tool and "Keep to the wall." in tool
    assert "[hidden]" in tool and "Zk3mQ9" not in tool
    system = [str(each.content) for each in model.received[-1][0] if each.type == "system"]
    assert "I am a small robot." in system[0] and "wall" not in system[0]
    with read(tmp_path / "run.journal") as record:
        looked = [step.event.data["looked"] for step in record.steps() if step.event.kind == "proposal"]
    assert looked[0][0]["tool"] == "recall" and "rules.txt, Rules" in str(looked[0][0])
    assert list((tmp_path / "cache" / "rai-missions").iterdir())


def test_looking_up_is_within_the_decisions_budget(tmp_path: Path) -> None:
    mission, robot = files(tmp_path, budget={"calls": 3}, attempts=1)
    model = ScriptedModel([looking("wall?"), looking("key?"), CHOICE])
    assert run(mission, robot, model=model).why == "'r' was reached", "the fallback: the second call was one too many"


def test_without_an_identity_it_is_not_there_and_the_log_reports_it(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    mission, robot = files(tmp_path, identity=False)
    assert run(mission, robot, model=ScriptedModel(['{"option": "left"}'] * 3)).why == "'l' was reached"
    assert (
        "/states/asks/decision/tools: the tool 'recall' is not there: the robot has no 'identity' here" in caplog.text
    )


def test_an_identity_that_cannot_be_read_refuses_the_start(tmp_path: Path) -> None:
    mission, robot = files(tmp_path)
    for number in range(201):
        (tmp_path / "identity" / f"{number}.txt").write_text("x")
    with pytest.raises(DefinitionError, match="has 203 files; at most 200 are read"):
        run(mission, robot, model=ScriptedModel([CHOICE]))


@pytest.mark.parametrize(("identity", "warned"), [(False, True), (True, False)])
def test_check_warns_of_a_tool_that_a_run_lacks(
    identity: bool, warned: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mission, robot = files(tmp_path, identity=identity)
    assert main(["check", str(mission), "--robot", str(robot)]) == 0
    why = "/identity: warning: missing, so the tool 'recall' is not there, which the mission names at"
    assert (why in capsys.readouterr().err) == warned


def test_check_warns_once_where_the_profile_has_no_tools(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mission, robot = files(tmp_path, tools=["recall", "look", "get_topics_names_and_types"])
    assert main(["check", str(mission), "--robot", str(robot)]) == 0
    assert capsys.readouterr().err.count("/tools: warning: missing") == 1
