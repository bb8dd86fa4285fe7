# SPDX-License-Identifier: Apache-2.0
"""A journal whose name another run takes is moved aside, whole, and every output reports where it is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rai_missions.agents.mission import run
from rai_missions.cli.main import main
from rai_missions.journal import read

MISSION = {
    "name": "short",
    "initial": "a",
    "states": {"a": {"transitions": [{"after_s": 0.05, "to": "b"}]}, "b": {"final": "canceled"}},
}
SENTENCE = "the journal of an earlier run, which had this name, is now out.1.journal"


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.json").write_text(json.dumps(MISSION))


def seal(path: str) -> str:
    with read(path) as record:
        return record.seal


def test_the_terminal_states_it_once_at_the_start(capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", "m.json", "--journal", "out.journal"])
    first = seal("out.journal")
    assert "earlier run" not in capsys.readouterr().out
    main(["run", "m.json", "--journal", "out.journal"])
    head, _, tail = capsys.readouterr().out.partition("canceled: ")
    assert head.count(SENTENCE) == 1 and SENTENCE not in tail
    assert seal("out.1.journal") == first != seal("out.journal")


def test_json_and_the_result_have_a_field_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for _ in range(3):
        main(["run", "m.json", "--journal", "out.journal", "--json"])
        found.append(json.loads(capsys.readouterr().out)["moved_aside"])
    assert found == [None, "out.1.journal", "out.2.journal"]
    assert run("m.json", journal="out.journal").moved_aside == "out.3.journal"
    assert run("m.json", journal="other.journal").moved_aside is None
