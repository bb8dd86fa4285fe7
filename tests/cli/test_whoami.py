# SPDX-License-Identifier: Apache-2.0
"""`whoami` builds, asks and shows; each exit status and each fault is as the help states."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.embodiment.minilm import why_no_vectors
from tests.rigs.documents import plain


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("rai_missions.embodiment.library.minilm", lambda: None)
    home = tmp_path / "identity"
    home.mkdir()
    (home / "description.md").write_text("I am a small robot.")
    (home / "care.txt").write_bytes(plain([(1, "Care"), (2, "Tyres"), (0, "The tyres take 1.2 bar.")]))
    return str(home)


def test_a_file_of_another_format_is_named(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("manual.doc", "me.png", ".hidden.odt"):
        (Path(folder) / name).write_bytes(b"")
    main(["whoami", "build", folder])
    assert "not read: manual.doc; documents end in .docx, .htm, .html, .md, .pdf" in capsys.readouterr().err


def test_a_folder_is_built_asked_and_shown(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", "build", folder]) == 0
    built = capsys.readouterr()
    assert built.out.startswith("read care.txt\nread description.md\n2 documents, 2 passages, 0 embedded now: ")
    assert built.err.startswith("searched by words alone")
    assert main(["whoami", "ask", folder, "Which pressure do the tyres take?"]) == 0
    assert capsys.readouterr().out == "1. care.txt, Care › Tyres: “The tyres take 1.2 bar.”\n"
    assert main(["whoami", "show", folder]) == 0
    shown = capsys.readouterr().out
    assert "I am a small robot." in shown and "care.txt: 1 passage" in shown and "Pictures: none." in shown
    assert (why_no_vectors() or "Searched by words and by meaning.") in shown


def test_what_has_no_answer_exits_with_1(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", "ask", folder, "Who painted the Mona Lisa?"]) == 1
    assert capsys.readouterr().out == "The documents have no answer: they have nothing about painted, mona, lisa.\n"


def test_a_question_to_a_folder_that_is_no_identity_warns(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", "ask", folder, "Which tyres?"]) == 0
    assert "description.md" not in capsys.readouterr().err
    Path(folder, "description.md").unlink()
    assert main(["whoami", "ask", folder, "Which tyres?"]) == 0
    assert f"{folder} has no description.md, so a run takes it for no identity; all its" in capsys.readouterr().err


def test_a_bad_document_is_named_and_the_others_are_built(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    (Path(folder) / "bad.txt").write_bytes(b"\xff")
    assert main(["whoami", "build", folder, "--index", f"{folder}/x.index"]) == 2
    printed = capsys.readouterr()
    assert f"{folder}: /bad.txt: is not UTF-8 at byte 0; save it as UTF-8" in printed.err
    assert "2 documents" in printed.out and Path(folder, "x.index").is_file()


def test_a_build_names_all_that_a_run_with_this_identity_refuses(
    folder: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(folder, "description.md").unlink()
    Path(folder, "portrait.png").write_text("no picture")
    Path(folder, "a.urdf").write_text("<robot")
    assert main(["whoami", "build", folder]) == 2
    built = capsys.readouterr()
    assert "1 document, 1 passage" in built.out and built.err.count("a.urdf") == 1
    assert main(["whoami", "show", folder]) == 2
    refused = [line.strip() for line in capsys.readouterr().err.splitlines() if "/" in line]
    named = [line for line in built.err.splitlines() if line.startswith(folder)]
    places = ("/a.urdf", "/portrait.png", "/description.md")
    assert all(any(place in line for line in lines) for place in places for lines in (refused, named))


@pytest.mark.parametrize("count", ["0", "-1", "21"])
def test_a_count_beyond_its_bounds_is_refused(folder: str, count: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", "ask", folder, "Which tyres?", "--count", count]) == 2
    assert f"--count is how many passages are given, 1 to 20, not {count}" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["ask", "."], ["ask", ".", " "], ["build", ".", "Why?"]])
def test_a_question_is_for_ask(folder: str, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", *words]) == 2
    assert (
        "a QUESTION is for ask, and ask needs one: rai-missions whoami ask FOLDER QUESTION" in capsys.readouterr().err
    )


def test_what_is_no_folder_is_reported(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["whoami", "ask", f"{folder}/none", "tyres?"]) == 2
    assert "the identity's folder cannot be read (No such file or directory)" in capsys.readouterr().err


def test_nothing_of_it_is_loaded_before_it_is_used(tmp_path: Path) -> None:
    code = (
        "import sys, rai_missions; from rai_missions.cli.main import main\n"
        "try: main(['whoami', '--help'])\nexcept SystemExit: pass\n"
        "print([each for each in ('pypdf', 'onnxruntime', 'numpy', 'tokenizers', 'markdown_it', 'sqlite3',"
        " 'rai_missions.embodiment') if each in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=dict(os.environ), check=True
    )
    assert done.stdout.strip().endswith("[]") and "whoami" in done.stdout
