# SPDX-License-Identifier: Apache-2.0
"""What the command reports where a run cannot continue: a sentence, with what would be right, and status 2."""

from __future__ import annotations

import errno
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.main import main
from rai_missions.engine import Chart
from rai_missions.errors import DefinitionError
from rai_missions.journal import Header, Journal, verify
from rai_missions.mission.files import dump, load
from rai_missions.mission.mission import Mission
from tests.rigs.lamp import LAMP, lamp_folder

FULL = """
import resource, signal, sys
from pathlib import Path
from rai_missions.cli.main import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
size = Path("run.journal-wal").stat().st_size + 1  # a copy of the log has room, and no row more
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
sys.exit(main(["run", "--resume", "run.journal"]))
"""


ROUND = {
    "name": "round",
    "blackboard": {"stops": {"type": "list", "initial": ["a", "b"]}, "stop": {"type": "string"}},
    "initial": "out",
    "states": {
        "out": {
            "parallel": {
                "tour": {"each": "stops", "as": "stop", "initial": "at", "states": {"at": {}}},
                "watch": {"initial": "looking", "states": {"looking": {}}},
            },
            "transitions": [{"after_s": 5, "to": "home"}],
        },
        "home": {"final": "aborted"},
    },
}


@pytest.fixture
def killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run that died after its first step, as its files are left; and its mission next to it."""
    lamp_folder(tmp_path, monkeypatch)
    mission = load("lamp.json")
    with Journal.create("living", Header(dump(mission))) as journal:
        journal.write(Chart(mission).start(), since=0.0)
        for number in range(8):  # the log is longer than the file that a reader makes of both
            journal.note("waits", number)
        for suffix in ("", "-wal"):
            shutil.copyfile(f"living{suffix}", f"run.journal{suffix}")
    return tmp_path / "run.journal"


def test_a_mission_that_has_changed_is_reported_by_what_changed_and_what_to_do(
    killed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("now.json").write_text(json.dumps(LAMP).replace("0.01", "5"))
    assert main(["run", "--resume", "run.journal", "now.json"]) == 2
    first, *changed, remedy = capsys.readouterr().err.splitlines()
    assert first == "rai-missions run: now.json is not the mission of run.journal:"
    assert any("on → off after 5 s" in line or "after_s" in line or "5 s" in line for line in changed)
    assert not any(line.startswith("now.json") for line in changed)
    assert remedy.endswith("with a map of its states and keys: --migrate MAP")


@pytest.mark.parametrize("words", [["--set", "x=1"], ["--talk", "--json"], ["--voice"]], ids=" ".join)
def test_options_that_do_not_go_together_migrate_nothing(killed: Path, words: list[str]) -> None:
    Path("map.json").write_text("{}")
    before = killed.read_bytes(), {each.name for each in killed.parent.iterdir()}
    assert main(["run", "--resume", "run.journal", "lamp.json", "--migrate", "map.json", *words]) == 2
    assert (killed.read_bytes(), {each.name for each in killed.parent.iterdir()}) == before


OUTDATED: dict[str, Any] = {
    "name": "bench", "actions": {"go": {"start": "", "cancel": "/stop", "succeeded": {"key": "at", "==": 1}}},
    "services": {"horn": {"service": ""}}, "topics": {"lamp": {"topic": "", "type": "std_msgs/msg/Bool"}},
    "tools": {"never": ["/e_stop", "cmd_vel"]},
}  # fmt: skip
"""A profile as it was accepted before empty names and patterns without a slash were refused."""
SINCE = ("/actions/go/start", "/services/horn/service", "/topics/lamp/topic", "/tools/never/1")
"""The places at which it is refused."""


def test_a_profile_that_was_accepted_then_is_replayed_with_a_warning_and_begins_no_run(
    killed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = json.dumps(OUTDATED)
    with Journal.create("old.journal", Header(dump(load("lamp.json")), profile=profile)) as journal:
        journal.write(Chart(load("lamp.json")).start(), since=0.0)
    assert main(["replay", "old.journal"]) == 0
    shown = capsys.readouterr()
    assert "1 step done again from 1 row, all the same" in shown.out
    prefix = "old.journal, row 0: warning: the profile of this run would be refused today: "
    assert [line.removeprefix(prefix).partition(": ")[0] for line in shown.err.splitlines()] == list(SINCE)
    Path("robot.json").write_text(profile)
    for words in (["run", "lamp.json", "--robot", "robot.json"], ["run", "--resume", "old.journal"]):
        assert main(words) == 2
        refused = capsys.readouterr().err
        assert all(place in refused for place in SINCE)
    assert "continues with a profile that is mended: --robot PROFILE --migrate MAP" in refused
    tools = {**OUTDATED["tools"], "never": ["/e_stop", "/cmd_vel"]}
    named = json.loads(profile.replace('""', '"/bench"'))
    Path("robot.json").write_text(json.dumps({**named, "tools": tools}))
    Path("map.json").write_text("{}")
    mended = ["--robot", "robot.json", "--migrate", "map.json"]
    assert main(["run", "--resume", "old.journal", "lamp.json", *mended]) == 1, "it ends as the mission does"
    assert main(["replay", "old-migrated.journal"]) == 0
    assert "refused today" not in capsys.readouterr().err


def test_a_disk_that_is_full_is_reported_in_a_sentence(killed: Path) -> None:
    reported = subprocess.run([sys.executable, "-c", FULL], capture_output=True, text=True, check=False)
    assert reported.returncode == 2
    assert reported.stderr.endswith("run.journal cannot be written: disk I/O error; row 10 is lost\n")
    assert reported.stderr.count("\n") == 1, "the reason is given once"
    assert verify("run.journal") == ()
    assert main(["run", "--resume", "run.journal"]) == 1, "once there is room again, it continues"


def test_a_disk_without_room_for_the_copy_that_is_read_is_reported_in_a_sentence(killed: Path) -> None:
    less = FULL.replace("(size, size)", "(9000, 9000)")
    reported = subprocess.run([sys.executable, "-c", less], capture_output=True, text=True, check=False)
    assert reported.returncode == 2
    assert reported.stderr.startswith("rai-missions run: the journal run.journal cannot be read: ")
    assert main(["run", "--resume", "run.journal"]) == 1


def test_a_file_that_could_not_be_read_is_named(
    killed: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(source: Any, target: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(source), None, "/somewhere/journal")

    monkeypatch.setattr(shutil, "copyfile", fails)
    assert main(["run", "--resume", "run.journal"]) == 2
    printed = capsys.readouterr().err
    assert "the journal run.journal cannot be read: No space left on device: /somewhere/journal" in printed


def test_a_list_in_which_nothing_would_be_active_is_no_place_to_continue(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("round.json").write_text(json.dumps(ROUND))
    Path("map.json").write_text('{"states": {"at": null}}')
    with Journal.create("run.journal", Header(dump(load("round.json")))) as journal:
        journal.write(Chart(load("round.json")).start(), since=0.0)
    assert main(["run", "--resume", "run.journal", "round.json", "--migrate", "map.json"]) == 2
    assert capsys.readouterr().err == (
        "map.json: /states: 'tour' goes through a list, and nothing inside it would be active; name a state inside it, "
        "or one outside\n"
    )


def test_a_fault_of_the_mission_that_a_journal_holds_is_reported_with_the_journal_s_name(tmp_path: Path) -> None:
    trap = Mission.model_validate({"name": "trap", "initial": "shut", "states": {"shut": {}}})
    with Journal.create(tmp_path / "run.journal", Header(dump(trap))) as journal:
        journal.write(Chart(trap).start(), since=0.0)
    with pytest.raises(DefinitionError, match="nothing can leave 'shut'") as refused:
        prepare(RunConfig(None, resume=tmp_path / "run.journal"))
    assert refused.value.source == str(tmp_path / "run.journal")
