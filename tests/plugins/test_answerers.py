# SPDX-License-Identifier: Apache-2.0
"""An answerer of another package: asked where a mission lists its package, refused by name, imported by a run alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.cli.doctor.mission import answerers
from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import read
from rai_missions.kinds import offered
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.replay.replay import replay
from rai_missions.testing import ScriptAnswerer, check_answerer
from tests.plugins.test_plugins import HERE, laid_out

STRANGE = """
class Strange:
    def __init__(self, *needed): {begin}
    def ask(self, question, answer): {ask}
    {withdraw} = lambda self, number: None
    def stop(self): print("stopped")
"""


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(HERE / "installed"))


def asking(*names: str, uses: str = "orchard_kinds>=1.2") -> Mission:
    """A mission that is one decision: `go` has the fewest words, and the fallback is `stop`."""
    decision = {
        "question": "Go?", "options": {"go": {"about": "on"}, "stop": {"about": "stop here"}},
        "ask": list(names), "deadline_s": 5, "fallback": "stop",
    }  # fmt: skip
    transitions = [{"on": "go", "to": "gone"}, {"on": "stop", "to": "stopped"}]
    return Mission(
        "asking",
        uses=[uses] if uses else [],
        initial="a",
        states={
            "a": {"decision": decision, "transitions": transitions},
            "gone": {"final": "aborted"},
            "stopped": {"final": "failed"},
        },
    )


@pytest.fixture
def strange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Lays a package out that offers the answerer `strange`."""

    def lay(
        *,
        name: str = "strange",
        begin: str = "pass",
        ask: str = "pass",
        withdraw: str = "withdraw",
        above: str = "",
        target: str = "Strange",
    ) -> str:
        package = f"strange_{tmp_path.name}"
        code = above + STRANGE.format(begin=begin, ask=ask, withdraw=withdraw)
        offers = f"[rai_missions.answerers]\n{name} = {package}:{target}\n"
        monkeypatch.syspath_prepend(str(laid_out(tmp_path, package, "1.0", offers=offers, code=code)))
        return package

    return lay


def refusal(mission: Mission) -> str:
    with pytest.raises((DefinitionError, UsageError)) as caught:
        run(mission)
    return str(caught.value)


def unlisted(mission: Mission) -> list[str]:
    return [f"{each.place}: {each.sentence}" for each in check(mission) if each.rule == "unlisted-answerer"]


def test_an_answerer_of_a_listed_package_is_asked_and_the_journal_has_its_version(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    assert run(asking("cautious"), journal=path).state == ("gone",)
    with read(path) as record:
        assert record.header.versions["orchard-kinds"] == "1.2"
        verdicts = [verdict for step in record.steps() for verdict in step.verdicts]
    assert [(each.by, each.option, each.accepted) for each in verdicts] == [("cautious", "go", True)]


def test_it_keeps_the_contract_of_answerers() -> None:
    from orchard_kinds.cautious import Cautious  # type: ignore[import-not-found, unused-ignore]

    check_answerer(Cautious)


def test_a_package_that_is_not_listed_answers_nothing_and_check_names_it() -> None:
    mission = asking("cautious", uses="")
    assert run(mission).state == ("stopped",) == run(asking("cautious", uses="rai_missions")).state
    (sentence,) = unlisted(mission)
    assert sentence.startswith("/states/a/decision/ask/0: 'cautious' is not asked unless the program brings it")
    assert 'the answerer \'cautious\' of orchard-kinds 1.2 is meant, add "uses": ["orchard-kinds>=1.2"]' in sentence
    assert unlisted(asking("cautious")) == [] == unlisted(asking("night_shift", uses=""))


def test_an_answerer_of_the_program_comes_before_one_of_a_package(strange: Any) -> None:
    package = strange(above="raise RuntimeError('imported')\n")
    result = run(asking("strange", uses=package), answerers={"strange": ScriptAnswerer({"a": ["go"]})})
    assert result.state == ("gone",)


@pytest.mark.parametrize("name", ["agent", "operator", "rules"])
def test_names_of_ours_are_never_anothers(strange: Any, name: str) -> None:
    package = strange(name=name, above="raise RuntimeError('imported')\n")
    assert run(asking(name, uses=package)).state == ("stopped",)
    assert offered("rai_missions.answerers", name, {}) is not None


def test_a_package_that_is_missing_or_of_another_version_is_named() -> None:
    with pytest.raises(DefinitionError, match="the package 'not_there' is not installed"):
        asking("cautious", uses="not_there>=1")
    with pytest.raises(DefinitionError, match=r"installed in version 1.2, and >=2 is needed"):
        asking("cautious", uses="orchard_kinds>=2")


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"above": "import not_there_at_all\n"}, "does not load (ModuleNotFoundError"),
        ({"target": "Absent"}, "does not load (AttributeError"),
        ({"begin": "raise ValueError('no key')"}, "cannot be opened (ValueError: no key)"),
        ({"withdraw": "forget"}, "which is no answerer: it lacks 'withdraw'"),
        ({"target": "__name__"}, "cannot be opened (TypeError: 'str' object is not callable)"),
    ],
)  # fmt: skip
def test_one_that_cannot_be_opened_is_refused_by_name(strange: Any, given: dict[str, str], why: str) -> None:
    package = strange(**given)
    offer = f"the answerer 'strange' of {package.replace('_', '-')} 1.0"
    mission = asking("strange", uses=package)
    assert (sentence := refusal(mission)).startswith(offer) and why in sentence


def test_one_that_raises_or_proposes_what_is_not_offered_costs_its_attempt_alone(
    strange: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    package = strange(ask="answer({'option': 'fly'}) if question.attempt else None")
    assert run(asking("strange", uses=package)).state == ("stopped",)
    assert capsys.readouterr().out == "stopped\n"


def test_nothing_that_is_read_as_data_imports_it(strange: Any, tmp_path: Path) -> None:
    package = strange(above="raise RuntimeError('imported')\n")
    file, path = tmp_path / "mission.json", tmp_path / "run.journal"
    mission = asking("strange", uses=package)
    file.write_text(dump(mission))
    assert run(mission, answerers={"strange": ScriptAnswerer({"a": ["go"]})}, journal=path).state == ("gone",)
    assert main(["check", str(file)]) == 0
    assert main(["draw", str(file), "-o", str(tmp_path / "mission.svg")]) == 0
    assert replay(path).holds and prove(mission).is_whole
    assert "does not load (RuntimeError: imported)" in refusal(mission)


def test_a_name_that_two_packages_offer_is_reported_by_check_and_refused_by_a_run(strange: Any) -> None:
    package = strange(name="cautious")
    mission = asking("cautious", uses=package)
    assert "is offered by orchard-kinds 1.2 and" in unlisted(mission)[0] and "uninstall one" in refusal(mission)


def test_the_doctor_opens_each_in_a_process_of_its_own(
    strange: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = strange(begin="import os; os.abort()")
    monkeypatch.setenv("PYTHONPATH", f"{HERE / 'installed'}:{HERE.parents[1]}:{tmp_path}")
    mission = asking("cautious", "strange", "night_shift", uses="orchard_kinds>=1.2")
    mission = mission.model_copy(update={"uses": ("orchard_kinds>=1.2", package)})
    found = [(each.status, str(each)) for each in answerers(mission)]
    assert [status for status, _ in found] == ["ok", "missing", "absent"]
    assert "orchard-kinds 1.2 can be asked" in found[0][1] and "SIGABRT" in found[1][1]


def test_the_doctor_takes_a_mission(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mission.json"
    file.write_text(json.dumps(json.loads(dump(asking("agent"))) | {"uses": ["not_there"]}))
    assert main(["doctor", "--mission", str(file)]) == 2
    assert "/uses/0: the package 'not_there' is not installed" in capsys.readouterr().err
