# SPDX-License-Identifier: Apache-2.0
"""A language of another package: one file, held to English as it is opened, and spoken as ours are."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.talk.settings import conversation_faults
from rai_missions.cli.main import main
from rai_missions.conversation import Dialogue, ModelText, Settings, Speech, StatusView, Utterance
from rai_missions.conversation.language.language import language, languages
from rai_missions.conversation.language.language_faults import language_faults
from rai_missions.errors import UsageError
from rai_missions.profile import ConversationPolicy, Robot

ENGLISH = dict(language("en").data)
Change = Callable[[dict[str, Any]], object]


def own(change: Change = lambda data: None) -> dict[str, Any]:
    """The file of a language that has German's words, with a change."""
    data: dict[str, Any] = deepcopy(dict(language("de").data)) | {"language": "it"}
    change(data)
    return data


@pytest.mark.parametrize("code", languages())
def test_each_language_of_ours_has_no_fault(code: str) -> None:
    assert language_faults(language(code).data, {**ENGLISH, "language": code}) == ()


FAULTS: dict[str, tuple[Change, str]] = {
    "a text is missing": (
        lambda data: data["texts"].pop("report_ready"),
        "/texts/report_ready: missing; in English it is 'The mission '{mission}' is ready and waits for the order to "
        "start.'",
    ),
    "a text is misspelled": (
        lambda data: data["texts"].update(reprot_ready="…"),
        "/texts/reprot_ready: English has no 'reprot_ready'; did you mean 'report_ready'?",
    ),
    "a slot is translated": (
        lambda data: data["texts"].update(report_ready="{missione} è pronta"),
        "/texts/report_ready: nothing fills in {missione}; there is: {mission}",
    ),
    "a template is not closed": (
        lambda data: data["texts"].update(report_ready="{mission è pronta"),
        "/texts/report_ready: '{mission è pronta' cannot be filled in: expected '}' before end of string; a sign by "
        "itself is '{{' or '}}'",
    ),
    "a slot has a form": (
        lambda data: data["texts"].update(report_ready="{mission:d} è pronta"),
        "/texts/report_ready: '{mission:d} è pronta' has more than a name in {mission}; write {mission} alone",
    ),
    "a text is a number": (
        lambda data: data["texts"].update(report_ready=7),
        "/texts/report_ready: 7 is not a text; in English it is 'The mission '{mission}' is ready and waits for the "
        "order to start.'",
    ),
    "a section is missing": (
        lambda data: data.pop("modes"),
        "/modes: missing; in English it is a table with 'ready', 'running', 'paused' …",
    ),
    "a section is a list": (
        lambda data: data.update(modes=["pronto"]),
        "/modes: [\"pronto\"] is no table; write an object with 'ready', 'running', 'paused' …",
    ),
    "a list is a text": (
        lambda data: data["orders"].update(pause="pausa"),
        "/orders/pause: 'pausa' is not a list of texts; in English it is",
    ),
    "a list has a number": (lambda data: data["yes"].append(1), "/yes: 1 in the list is no text"),
    "a phrase is not closed": (
        lambda data: data["orders"]["stop"].append("(ferma"),
        "/orders/stop: the phrase '(ferma' is not closed: '(' lacks its ')'",
    ),
    "a phrase has another slot": (
        lambda data: data["questions"]["key"].append("quanto {chiave}"),
        "/questions/key: the phrase 'quanto {chiave}' has {chiave}; there is: {done}, {key}, {of}",
    ),
    "a phrase names no part": (
        lambda data: data["yes"].append("<avverbio> si"),
        "/yes: the phrase '<avverbio> si' names no part: '<avverbio>'; there is:",
    ),
    "a part is in itself": (
        lambda data: data["parts"].update(avverbio="ora|<avverbio>"),
        "/parts/avverbio: the phrase 'ora|<avverbio>' is in the part that it names: '<avverbio>'; write its words",
    ),
    "a pattern is not closed": (
        lambda data: data.update(reason_pattern="("),
        "/reason_pattern: '(' is no regular expression: missing ), unterminated subpattern at position 0",
    ),
    "a pattern repeats what repeats": (
        lambda data: data.update(reason_pattern="(?:(?:perché|che) ?\\w+)+x"),
        "/reason_pattern: '(?:(?:perché|che) ?\\w+)+x' repeats what repeats; a text could take hours",
    ),
    "a number is infinite": (
        lambda data: data["numbers"].update(due=float("inf")),
        "/numbers/due: Infinity is no finite number; in English it is",
    ),
    "a number is a word": (lambda data: data["numbers"].update(due="2"), "/numbers/due: '2' is not a number; in"),
    "another language": (
        lambda data: data.update(language="de"),
        "/language: the file is of 'de', and it is 'it' here",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_of_a_file_has_its_place_and_what_is_right(name: str) -> None:
    change, expected = FAULTS[name]
    (fault,) = language_faults(own(change), {**ENGLISH, "language": "it"})
    assert str(fault).startswith(expected)


def test_all_that_is_missing_is_reported_at_once() -> None:
    faults = language_faults(own(lambda data: data["texts"].clear()), {**ENGLISH, "language": "it"})
    assert {each.place for each in faults} == {f"/texts/{name}" for name in ENGLISH["texts"]}


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Path]]:
    """Installs a package that offers Italian, with what its file holds; returns the file."""

    def install(content: str) -> Path:
        (tmp_path / "it.json").write_text(content, "utf-8")
        (tmp_path / "parole.py").write_text("from pathlib import Path\nITALIAN = Path(__file__).parent / 'it.json'\n")
        metadata = tmp_path / "parole-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: parole\nVersion: 1.0\n")
        (metadata / "entry_points.txt").write_text("[rai_missions.languages]\nit = parole:ITALIAN\n")
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "parole", raising=False)
        language.cache_clear()
        return tmp_path / "it.json"

    yield install
    language.cache_clear()


def robot() -> Robot:
    return Robot(name="r", conversation=ConversationPolicy(language="it"))


def test_a_language_of_a_package_is_spoken(package: Callable[[str], Path]) -> None:
    def italian(data: dict[str, Any]) -> None:
        data["questions"]["doing"].append("che cosa fai")
        data["modes"]["ready"] = "è pronta"

    package(json.dumps(own(italian)))
    assert conversation_faults(robot()) == ()
    view = StatusView(run="r1", mode="ready", mission="giro")
    dialogue = Dialogue(Settings(language="it"), view)
    asked = dialogue.on_utterance(Utterance("Che cosa fai?", "viewer", "page", at=2.0), view)
    spoken = [(each.text, each.way) for each in asked if isinstance(each, Speech)]
    assert spoken[-1] == ("Die Mission 'giro' è pronta.", "rules")


def test_without_weights_each_doubtful_sentence_of_a_model_is_replaced(package: Callable[[str], Path]) -> None:
    package(json.dumps(own()))
    view = StatusView(run="r1", mode="running", mission="giro")
    dialogue = Dialogue(Settings(language="it", has_model=True), view)
    dialogue.on_utterance(Utterance("Erzähl mir etwas über den Mond.", "viewer", "page", at=2.0), view)
    text = "La consegna dei campioni al reparto è ormai completata da parecchio tempo."
    replies = dialogue.on_model(ModelText(1, text, is_end=True, at=3.0))
    assert all("consegna" not in each.text for each in replies if isinstance(each, Speech))


def test_a_file_at_fault_is_found_with_the_profile(package: Callable[[str], Path]) -> None:
    file = package(json.dumps(own(lambda data: data["texts"].pop("report_ready"))))
    (fault,) = conversation_faults(robot())
    assert (fault.place, fault.file) == ("/texts/report_ready", str(file))


def test_faults_of_all_sorts_are_reported_at_once_and_with_the_file(
    package: Callable[[str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def wrong(data: dict[str, Any]) -> None:
        data["texts"].pop("report_ready")
        data["orders"]["stop"].append("(ferma")
        data["texts"]["report_start"] = "{missione}"

    file, profile = package(json.dumps(own(wrong))), tmp_path / "robot.json"
    profile.write_text(json.dumps({"name": "r", "connector": {"kind": "local"}, "conversation": {"language": "it"}}))
    assert main(["check", "missions/templates/patrol/mission.json", "--robot", str(profile)]) == 2
    reported = [each for each in capsys.readouterr().err.splitlines() if each.startswith(f"{file}: /")]
    places = ("/texts/report_ready", "/orders/stop", "/texts/report_start")
    assert [each.split(": ")[1] for each in reported] == [*places]


def test_a_file_that_is_no_json_is_named_with_its_line(package: Callable[[str], Path]) -> None:
    file = package('{"language": "it",}')
    (fault,) = conversation_faults(robot())
    assert fault.file == str(file) and "take away the comma before the end" in fault.sentence


def test_a_language_that_no_package_offers_is_named_with_those_there_are(package: Callable[[str], Path]) -> None:
    package(json.dumps(own()))
    with pytest.raises(UsageError, match=r"^no language 'pl'; there is: de, en, it$"):
        language("pl")
