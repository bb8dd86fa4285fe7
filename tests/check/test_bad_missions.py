# SPDX-License-Identifier: Apache-2.0
"""Bad missions, each next to the exact messages expected: `tests/bad_missions/NAME.json` and `NAME.txt`.

`REWRITE_BAD_MISSIONS=1 pytest tests/check` writes the messages again, for a person to read.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from rai_missions.check import RULES, Finding, check, check_file, exit_status
from rai_missions.mission.mission import Mission

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests" / "bad_missions"
NAMES = sorted(path.stem for path in FOLDER.glob("*.json"))
REGISTERED = ("is_crossable",)
"""The predicates that are taken to be registered."""


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that offers an answerer; its metadata alone is read."""
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "plugins" / "installed"))


def mission_of(path: Path) -> Mission:
    return Mission.model_validate(json.loads(path.read_text(encoding="utf-8")))


def findings(name: str) -> tuple[Finding, ...]:
    return check(mission_of(FOLDER / f"{name}.json"), named=REGISTERED)


@pytest.mark.parametrize("name", NAMES)
def test_a_bad_mission_is_sent_every_fault_with_its_place(name: str) -> None:
    reported = "".join(f"{finding}\n" for finding in findings(name))
    expected = FOLDER / f"{name}.txt"
    if os.environ.get("REWRITE_BAD_MISSIONS"):
        expected.write_text(reported, encoding="utf-8")
    assert reported == expected.read_text(encoding="utf-8")


def test_each_rule_has_a_bad_mission_of_its_name_that_breaks_it() -> None:
    assert sorted(rule.name.replace("-", "_") for rule in RULES) == NAMES
    for rule in RULES:
        broken = [finding for finding in findings(rule.name.replace("-", "_")) if finding.rule == rule.name]
        assert broken, rule.name
        assert {finding.severity for finding in broken} == {rule.severity}


@pytest.mark.parametrize("name", NAMES)
def test_a_bad_mission_breaks_only_the_rule_it_is_named_for_and_warnings(name: str) -> None:
    others = {each.rule for each in findings(name) if each.severity == "error"} - {name.replace("_", "-")}
    assert not others


def test_an_error_ends_with_two_and_a_warning_with_one_where_warnings_count() -> None:
    error, warning = findings("dead_end"), findings("unused_key")
    assert [exit_status(error), exit_status(warning), exit_status(())] == [2, 0, 0]
    assert [exit_status(each, strict=True) for each in (error, warning, ())] == [2, 1, 0]


def test_every_sentence_states_what_would_be_right() -> None:
    remedy = re.compile(r"; |\?$|and no|move this one")
    for name in NAMES:
        for finding in findings(name):
            assert remedy.search(finding.sentence), finding
            assert not finding.sentence.endswith("."), finding


def test_every_place_is_in_the_document() -> None:
    for name in NAMES:
        document = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
        for finding in findings(name):
            here = document
            for word in finding.place.split("/")[1:]:
                here = here[int(word)] if isinstance(here, list) else here[word.replace("~1", "/").replace("~0", "~")]


def test_the_guide_lists_each_rule_once_under_its_severity_with_an_example_that_check_reports() -> None:
    guide = (ROOT / "docs" / "guide" / "checks.md").read_text(encoding="utf-8")
    parts = re.findall(r"^### ([^\n]+)\n(.*?)(?=^##)", guide, re.DOTALL | re.MULTILINE)
    listed = [
        (name, "warning" if title == "Warnings" else "error")
        for title, text in parts
        for name in re.findall(r"^- `([\w-]+)`: ", text, re.MULTILINE)
    ]
    assert sorted(listed) == sorted((rule.name, rule.severity) for rule in RULES)
    shown = " ".join(guide.split())
    for rule in RULES:
        results = [str(finding) for finding in findings(rule.name.replace("-", "_")) if finding.rule == rule.name]
        assert any(" ".join(each.split()) in shown for each in results), rule.name


UNREAD = sorted((FOLDER / "unread").glob("*.json"))
"""Missions that cannot be read whole, or whose message is of their own."""


@pytest.mark.parametrize("path", UNREAD, ids=lambda path: path.stem)
def test_a_word_that_cannot_be_read_hides_no_fault_of_the_rest(path: Path) -> None:
    reported = "".join(f"{each.finding}\n" for each in check_file(str(path)).findings)
    expected = path.with_suffix(".txt")
    if os.environ.get("REWRITE_BAD_MISSIONS"):
        expected.write_text(reported, encoding="utf-8")
    assert reported == expected.read_text(encoding="utf-8")
