# SPDX-License-Identifier: Apache-2.0
"""Each command of the program with a kind of each sort from a package: it works, or refuses by the package's name."""

from __future__ import annotations

import io
import itertools
import json
import shutil
from pathlib import Path

import pytest

from rai_missions.cli.main import main

HERE = Path(__file__).parent
ASKING = {
    "format": 1, "name": "asking", "uses": ["orchard_kinds>=1.2"], "initial": "a",
    "states": {
        "a": {"decision": {"question": "Go?", "options": {"go": {"about": "on"}, "stop": {"about": "stop here"}},
                           "ask": ["cautious"], "deadline_s": 5, "fallback": "stop"},
              "transitions": [{"on": "go", "to": "gone"}, {"on": "stop", "to": "stopped"}]},
        "gone": {"final": "aborted"}, "stopped": {"final": "failed"}},
}  # fmt: skip
BARE = {"format": 1, "name": "bare", "initial": "over", "states": {"over": {"final": "aborted"}}}
TIN = {**json.loads((HERE / "robot.json").read_text()), "connector": {"kind": "tin_can"}}
CAMPAIGN = {
    "format": 1, "name": "green", "mission": "asking.json", "robot": "robot.json", "decision": "a",
    "scenes": {"world": "greenhouse", "given": [{"scene": "dry", "kind": "dry", "seed": 1, "options": {}}]},
    "models": ["constant:go"], "labels": "none",
}  # fmt: skip
SORTS = {"guard": "mission.json", "answerer": "asking.json"}
ON_MISSIONS = (
    "check {}", "prove {}", "draw {} -o new.svg", "draw {} -o new.html", "diff {} {}", "try {}", "run {} --no-operator",
    "doctor --mission {}", "textconv {}", "draw {} --journal {}.journal -o new.md",
)  # fmt: skip
ON_JOURNALS = ("replay {}.journal", "watch {}.journal", "run --resume {}.journal")
ON_ROBOTS = ("check mission.json --robot {}", "doctor --robot {}", "run bare.json --no-operator --robot {}")
WHOLE = {"textconv": "shows a file that it cannot read as it is", "verify": "looks at hashes alone"}
"""Commands that need no package, and why."""
SLOW = ("doctor", "campaign run")
"""Commands that start processes of their own."""
NAMES = {
    "mission.json": "orchard_kinds",
    "asking.json": "orchard_kinds",
    "tin.json": "tin_can",
    "robot.json": "greenhouse",
}
CASES = [
    *((command, file) for command, file in itertools.product((*ON_MISSIONS, *ON_JOURNALS), SORTS.values())),
    ("verify {}.journal", "mission.json"),
    *((command, file) for command, file in itertools.product(ON_ROBOTS, ("robot.json", "tin.json"))),
    ("campaign check green.json", "asking.json"),
    ("campaign run green.json --store new.db", "asking.json"),
    ("draw bare.json -o new.outline", ""),
    ("draw asking.json -o new.outline", "asking.json"),
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a file of each sort, and the journal of a run of each mission, which ended."""
    folder = tmp_path_factory.mktemp("made")
    for name in ("mission.json", "robot.json"):
        shutil.copy(HERE / name, folder)
    files = {"asking": ASKING, "bare": BARE, "tin": TIN, "green": CAMPAIGN}
    for name, data in files.items():
        (folder / f"{name}.json").write_text(json.dumps(data))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(HERE / "installed"))
        patch.chdir(folder)
        speed = ["--robot", "robot.json", "--speed", "max"]
        assert main(["run", "mission.json", "--no-operator", "--journal", "mission.json.journal", *speed]) == 0
        assert main(["run", "asking.json", "--no-operator", "--journal", "asking.json.journal"]) == 1
    return folder


@pytest.mark.parametrize(
    ("command", "file", "is_installed"),
    [
        pytest.param(*case, there, marks=[pytest.mark.long] * case[0].startswith(SLOW))
        for case in CASES
        for there in (True, False)
        if not (there and case[0].startswith("watch"))
    ],
)
def test_each_command_takes_each_sort_of_kind_or_refuses_it_by_name(
    command: str,
    file: str,
    is_installed: bool,
    made: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(folder)
    if is_installed:
        monkeypatch.syspath_prepend(str(HERE / "installed"))
    if command.startswith("run {}") and file == "mission.json":
        command += " --robot robot.json --speed max"
    monkeypatch.setattr("sys.stdin", io.StringIO())
    status = main(command.replace("{}", file).split())
    output = "".join(capsys.readouterr())
    assert "Traceback" not in output
    assert "/uses/0" not in output or "/states/" not in output, "the words of a package that lacks are no faults"
    if "--resume" in command and is_installed:
        assert status == 2 and "has ended" in output
    elif is_installed or command.split()[0] in WHOLE:
        assert status in (0, 1), output
    elif not file:
        assert status == 2 and ".outline" in output, output
    else:
        assert NAMES[file] in output and status == (1 if "doctor --robot" in command else 2), output
