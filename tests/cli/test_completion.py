# SPDX-License-Identifier: Apache-2.0
"""Shells complete commands, options, choices and files: each is run with what the command line prints for it."""

from __future__ import annotations

import os
import pty
import select
import shutil
import subprocess
from pathlib import Path

import pytest

from rai_missions.cli.commands import names
from rai_missions.cli.main import main

BASH = """
source ./completion
COMP_WORDS=({words}) COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
{last}
$(complete -p rai-missions | sed -E 's/.*-F ([^ ]+).*/\\1/')
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
ZSH = r"""
fpath=($PWD $fpath)
autoload -Uz compinit; compinit -u -D
compadd() { local -a found; builtin compadd -A found "$@"; print -rl -- $found >> found; builtin compadd "$@" }
offer() { zle complete-word; print "$(( 6 * 7 ))-over" }
zle -N offer; bindkey '^I' offer
print "$(( 6 * 7 ))-ready"
"""
FISH = "source ./completion; complete -C 'rai-missions {line}'"


def completed_by_zsh(line: str, folder: Path) -> set[str]:
    """The same by zsh, which completes at a terminal only."""
    (folder / "_rai-missions").write_text((folder / "completion").read_text())
    (folder / "found").write_text("")
    terminal, other = pty.openpty()
    with subprocess.Popen(["zsh", "-f", "-i"], stdin=other, stdout=other, stderr=other, cwd=folder) as ran:
        for sent, awaited in ((ZSH, b"42-ready"), (f"rai-missions {line}\t", b"42-over")):
            os.write(terminal, sent.encode())
            printed = b""
            while awaited not in printed:
                assert select.select([terminal], [], [], 60.0)[0], printed
                printed += os.read(terminal, 4096)
        ran.kill()
    os.close(terminal)
    os.close(other)
    return {*(folder / "found").read_text().split("\n")} - {""}


def completed(shell: str, line: str, folder: Path) -> set[str]:
    """What a shell offers for the last word of a line."""
    if shell == "zsh":
        return completed_by_zsh(line, folder)
    if shell == "bash":
        words = f"rai-missions {line}"
        program = BASH.format(
            words=words, last="COMP_WORDS+=('') COMP_CWORD=$((COMP_CWORD+1))" if f" {line}".endswith(" ") else ""
        )
    else:
        program = FISH.format(line=line)
    ran = subprocess.run(
        [shell, *(["--norc"] if shell == "bash" else ["--no-config"]), "-c", program],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return {found.partition("\t")[0] for found in ran.stdout.splitlines() if found}


@pytest.fixture
def folder(tmp_path: Path, request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]) -> Path:
    shell = request.node.callspec.params["shell"]
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    assert main(["completion", shell]) == 0
    (tmp_path / "completion").write_text(capsys.readouterr().out)
    for name in ("lamp.json", "lamp.py", "lamp.txt", "a.journal", "b.mcap"):
        (tmp_path / name).touch()
    (tmp_path / "missions").mkdir()
    return tmp_path


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_a_shell_completes_commands(shell: str, folder: Path) -> None:
    assert set(names()) <= completed(shell, "", folder)
    assert completed(shell, "che", folder) == {"check"}


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_a_shell_completes_options(shell: str, folder: Path) -> None:
    assert completed(shell, "run --mod", folder) == {"--model", "--model-memory"}
    assert completed(shell, "check lamp.json --str", folder) == {"--strict"}


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_a_shell_completes_choices(shell: str, folder: Path) -> None:
    assert completed(shell, "diff --fail-on ", folder) == {"safety", "any", "none"}
    assert completed(shell, "completion ", folder) >= {"bash", "zsh", "fish"}
    assert completed(shell, "schema ro", folder) == {"robot"}


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_a_shell_completes_the_files_that_an_argument_takes(shell: str, folder: Path) -> None:
    plain = {name.rstrip("/") for name in completed(shell, "check lam", folder)}
    assert plain == {"lamp.json", "lamp.py"}
    assert {name.rstrip("/") for name in completed(shell, "replay ", folder)} >= {"a.journal", "b.mcap", "missions"}
    assert {name.rstrip("/") for name in completed(shell, "run --robot lam", folder)} == {"lamp.json", "lamp.py"}
    assert {name.rstrip("/") for name in completed(shell, "prove lamp.json --robot lam", folder)} == {"lamp.json"}


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh"])
def test_what_a_shell_reads_is_of_its_syntax(shell: str, folder: Path) -> None:
    subprocess.run([shell, "-n", str(folder / "completion")], check=True, timeout=60)
