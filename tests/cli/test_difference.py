# SPDX-License-Identifier: Apache-2.0
"""`diff` in a git repository as a reviewer and a build use it, and the workflow that the examples bring."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main

ROOT = Path(__file__).parents[2]
DOCK: dict[str, Any] = {
    "name": "dock", "initial": "in_it", "states": {"in_it": {"transitions": [{"after_s": 1.0, "to": "out"}]},
                                                   "out": {"final": "succeeded"}},
}  # fmt: skip
HOME: dict[str, Any] = {
    "name": "home", "initial": "dock",
    "states": {"dock": {"mission": "parts/dock.json", "transitions": [{"on": "succeeded", "to": "end"}]},
               "end": {"final": "aborted"}},
}  # fmt: skip


def git(folder: Path, *words: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True)
    return done.stdout


def write(path: Path, document: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(document))


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A commit of a mission that includes another, in a folder whose name begs for quotes."""
    for word in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{word}_NAME", "a")
        monkeypatch.setenv(f"GIT_{word}_EMAIL", "a@b.invalid")
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", os.devnull)
    git(tmp_path, "init", "-q", "-b", "main")
    write(tmp_path / "my $(touch owned) robots/mission.json", HOME)
    write(tmp_path / "my $(touch owned) robots/parts/dock.json", DOCK)
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-q", "-m", "first")
    monkeypatch.chdir(tmp_path / "my $(touch owned) robots")
    return tmp_path


def test_a_mission_is_compared_with_itself_at_a_revision(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diff", "--git", "HEAD", "mission.json"]) == 0
    write(Path("mission.json"), {**HOME, "settle_s": 9})
    assert main(["diff", "--git", "main", "mission.json"]) == 1
    assert "mission: 'settle_s' grew" in capsys.readouterr().out


def test_what_a_mission_includes_is_that_of_the_revision_too(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dock = json.loads(json.dumps(DOCK))
    dock["states"]["in_it"]["transitions"][0]["after_s"] = 7.0
    write(Path("parts/dock.json"), dock)
    assert main(["diff", "--git", "HEAD", "mission.json", "--fail-on", "any"]) == 1
    assert "'after_s' changed" in capsys.readouterr().out
    git(repository, "commit", "-qam", "second")
    assert main(["diff", "--git", "HEAD", "mission.json", "--fail-on", "any"]) == 0
    assert main(["diff", "--git", "HEAD~1", "mission.json", "--fail-on", "any"]) == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--git", "nowhere", "mission.json"], "there is no revision 'nowhere'"),
        (["--git", "--output=x", "mission.json"], "expected one argument"),
        (["--git", "HEAD", "other.json"], "is not a file of 'HEAD'"),
        (["--git", "HEAD", "mission.json", "mission.json"], "compares one mission with itself"),
        (["mission.json"], "give two missions"),
        (["--git", "HEAD", "away/mission.json"], "there is no folder"),
    ],
)
def test_what_cannot_be_compared_exits_with_2_and_reports_why(
    repository: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["diff", *words])
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert message in capsys.readouterr().err


def test_a_form_that_there_is_not_is_refused_before_anything_is_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "dock.json", DOCK)
    write(tmp_path / "later.json", {**DOCK, "version": "2"})
    mission, later, good = (str(tmp_path / name) for name in ("dock.json", "later.json", "a.md"))
    assert main(["diff", mission, later, "-o", good, "-o", "a.txt"]) == 2
    printed = capsys.readouterr()
    assert "'a.txt' does not end in a form of picture; the endings are .html" in printed.err
    assert not printed.out and not Path(good).exists()


def test_a_revision_that_looks_like_an_option_is_none(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diff", "--git=--output=x", "mission.json"]) == 2
    assert "there is no revision '--output=x'" in capsys.readouterr().err
    assert not Path("x").exists()


def test_a_mission_in_python_of_another_revision_is_executed_only_when_asked_for(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = "from pathlib import Path\nfrom rai_missions import load\nPath('ran').write_text('x')\n"
    code += "def mission():\n    return load(Path(__file__).with_name('parts') / 'dock.json')\n"
    Path("mission.py").write_text(code)
    git(repository, "add", ".")
    git(repository, "commit", "-qm", "python")
    assert main(["diff", "--git", "HEAD", "mission.py"]) == 2
    assert "only with --python" in capsys.readouterr().err
    assert not Path("ran").exists()
    assert main(["diff", "--git", "HEAD", "mission.py", "--python"]) == 0


@pytest.mark.long
def test_git_shows_missions_as_lines_of_meaning(repository: Path) -> None:
    script = Path(sys.executable).with_name("rai-missions")
    git(repository, "config", "diff.mission.textconv", f"{script} textconv")
    (repository / ".gitattributes").write_text("mission.json diff=mission\n")
    write(Path("mission.json"), dict(reversed(HOME.items())))
    assert git(repository, "diff", "--", ".") == ""
    write(Path("mission.json"), {**HOME, "settle_s": 9})
    shown = git(repository, "diff", "--", ".")
    assert "+settle_s: 9.0" in shown
    assert sum(line.startswith(("+", "-")) for line in shown.splitlines()) == 3


def test_what_is_no_mission_is_printed_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.json").write_text('{"initial": 1}\n')
    assert main(["textconv", str(tmp_path / "a.json")]) == 0
    assert capsys.readouterr().out == '{"initial": 1}\n'


def workflow() -> dict[Any, Any]:
    yaml = pytest.importorskip("yaml", reason="no PyYAML here")
    found: dict[Any, Any] = yaml.safe_load((ROOT / "docs/examples/mission-review.yml").read_text(encoding="utf-8"))
    return found


def test_no_step_of_the_workflow_pastes_what_others_wrote_into_a_script() -> None:
    steps = workflow()["jobs"]["review"]["steps"]
    scripts = [step["run"] for step in steps if "run" in step]
    assert len(scripts) == 4
    for script in scripts:
        assert "${{" not in script
        subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    assert "pull_request_target" not in workflow()[True]  # YAML 1.1 reads `on` so


def test_the_workflow_compares_what_a_pull_request_changed(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    base = git(repository, "rev-parse", "HEAD").strip()
    write(Path("mission.json"), {**HOME, "settle_s": 9})
    git(repository, "commit", "-qam", "looser")
    (script,) = (step["run"] for step in workflow()["jobs"]["review"]["steps"] if step.get("id") == "compare")
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    monkeypatch.setenv("GITHUB_OUTPUT", str(repository / "output"))
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(repository / "summary.md"))
    subprocess.run(["bash", "-c", script], cwd=repository, env={**os.environ, "BASE": base}, check=True)
    assert (repository / "output").read_text() == "count=1\nsafety=yes\n"
    assert "1 safety-relevant change" in (repository / "summary.md").read_text()
    assert {each.suffix for each in (repository / "review").iterdir()} == {".md", ".html", ".svg"}
    assert not list(repository.rglob("owned"))
