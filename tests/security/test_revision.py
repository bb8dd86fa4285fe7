# SPDX-License-Identifier: Apache-2.0
"""A repository from elsewhere: comparing a mission with itself there starts no program, and writes nothing outside."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from rai_missions.cli import git as revision
from rai_missions.cli.main import main
from rai_missions.mission.files import dump
from tests.fuzz.seeds import LAMP

pytestmark = pytest.mark.skipif(shutil.which("git") is None, reason="there is no git on this machine")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("GIT_AUTHOR_NAME", "GIT_AUTHOR_EMAIL", "GIT_COMMITTER_NAME", "GIT_COMMITTER_EMAIL"):
        monkeypatch.setenv(name, "stranger")
    made = tmp_path / "repository"
    made.mkdir()
    git(made, "init", "-q")
    dump(LAMP, made / "lamp.json")
    git(made, "add", "lamp.json")
    git(made, "commit", "-qm", "a lamp")
    return made


def git(place: Path, *words: str, reported: bytes = b"") -> str:
    done = subprocess.run(["git", "-C", str(place), *words], input=reported, capture_output=True, check=True)
    return done.stdout.decode().strip()


def test_what_a_repository_lacks_is_fetched_by_no_program_of_its(place: Path) -> None:
    lamp, ran = git(place, "rev-parse", "HEAD:lamp.json"), place.parent / "ran"
    (place / ".git/objects" / lamp[:2] / lamp[2:]).unlink()
    for name, value in {
        "extensions.partialClone": "origin",
        "core.repositoryFormatVersion": "1",
        "remote.origin.promisor": "true",
        "remote.origin.url": str(place),
        "remote.origin.uploadpack": f"touch {ran}; git-upload-pack",
        "core.fsmonitor": f"touch {ran}",
        "core.pager": f"touch {ran}",
        "core.sshCommand": f"touch {ran}",
    }.items():
        git(place, "config", name, value)
    assert main(["diff", "--git", "HEAD", str(place / "lamp.json")]) == 2
    assert not ran.exists()
    subprocess.run(["git", "-C", str(place), "cat-file", "blob", lamp], capture_output=True, check=False)
    assert ran.exists(), "git by itself does run it"


def test_a_tree_with_a_way_out_writes_nothing_outside(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = tmp_path / "temporary"
    room.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(room))
    inner = git(place, "hash-object", "-w", "lamp.json")
    outer = {**LAMP.written(), "initial": "x", "states": {"x": {"mission": "../evil.json"}}}
    (place / "lamp.json").write_text(json.dumps(outer))
    tree = bytes.fromhex(git(place, "mktree", reported=f"100644 blob {inner}\tevil.json\n".encode()))
    file = bytes.fromhex(git(place, "hash-object", "-w", "lamp.json"))
    raw = b"40000 ..\0" + tree + b"100644 lamp.json\0" + file
    whole = git(place, "hash-object", "-w", "-t", "tree", "--literally", "--stdin", reported=raw)
    git(place, "update-ref", "refs/heads/evil", git(place, "commit-tree", whole, "-m", "evil"))
    assert "../evil.json" in git(place, "ls-tree", "-r", "evil")
    assert main(["diff", "--git", "evil", str(place / "lamp.json")]) == 2
    assert list(room.iterdir()) == []


def test_an_enormous_file_is_not_taken_out(
    place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(revision, "MOST_BYTES", 100)
    assert main(["diff", "--git", "HEAD", str(place / "lamp.json")]) == 2
    assert "100 are the most" in capsys.readouterr().err
