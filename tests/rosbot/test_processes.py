# SPDX-License-Identifier: Apache-2.0
"""The script that has the house in processes of their own: each that ends is named, and the rest ends with the run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.tractor.ros2_processes import PATIENCE_S, ROOT

SCRIPT = ROOT / "missions/rosbot/processes.sh"
PROGRAM = f"""#!{sys.executable}
import os, pathlib, signal, sys, time
name = sys.argv[1]

def end(*_):
    time.sleep(0.5 * (name == "run"))
    with open("ends", "a") as ends:
        ends.write(f"{{name}} was interrupted\\n")
    os._exit(0)

signal.signal(signal.SIGINT, end)
if name == "world" and "BROKEN" in os.environ:
    sys.exit("no such option")
if name == "world":
    print("ready; Ctrl-C ends it", flush=True)
pathlib.Path(name).write_text(str(os.getpid()))
while not (name == "run" and os.path.exists("over")):
    time.sleep(0.05)
sys.exit(3)
"""
"""In place of `rai-missions world|voice|run`: lasts until it is interrupted; the run, until there is a file `over`."""
Begin = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def begin(tmp_path: Path) -> Iterator[Begin]:
    program = tmp_path / "bin" / "rai-missions"
    program.parent.mkdir()
    program.write_text(PROGRAM)
    program.chmod(0o755)
    begun: list[subprocess.Popen[str]] = []

    def begin_one(**variables: str) -> subprocess.Popen[str]:
        environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}", "VOICE": "", **variables}
        begun.append(
            subprocess.Popen(
                ["bash", SCRIPT],
                cwd=tmp_path,
                env=environment,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        )
        return begun[-1]

    yield begin_one
    for each in begun:
        if each.poll() is None:
            os.killpg(each.pid, signal.SIGKILL)
        each.communicate()


def number_in(path: Path) -> int:
    """The process that has written its number there."""
    until = time.monotonic() + PATIENCE_S
    while not (path.is_file() and path.read_text().strip()):
        assert time.monotonic() < until, f"{path.name} has not begun"
        os.sched_yield()
    return int(path.read_text())


@pytest.mark.parametrize("name", ["world", "voice"])
def test_a_process_that_is_killed_is_named_while_the_run_continues(name: str, begin: Begin, tmp_path: Path) -> None:
    script = begin()
    number_in(tmp_path / "run")
    killed = number_in(tmp_path / name)
    os.kill(killed, signal.SIGKILL)
    assert script.stderr is not None
    named = next(line for line in script.stderr if line.startswith("processes.sh"))
    assert named == f"processes.sh: the {name} (process {killed}) has ended, and the run has not\n"
    assert script.poll() is None
    (tmp_path / "over").touch()
    assert script.wait(PATIENCE_S) == 3, "the status of the run"
    other = {"world": "voice", "voice": "world"}[name]
    assert (tmp_path / "ends").read_text() == f"{other} was interrupted\n"


def test_the_end_of_the_run_ends_the_others_and_is_no_fault_of_theirs(begin: Begin, tmp_path: Path) -> None:
    script = begin()
    number_in(tmp_path / "run")
    (tmp_path / "over").touch()
    _, printed = script.communicate(timeout=PATIENCE_S)
    assert (script.returncode, "processes.sh" in printed) == (3, False)
    assert sorted((tmp_path / "ends").read_text().splitlines()) == ["voice was interrupted", "world was interrupted"]


def test_an_interrupt_of_all_reaches_the_run_alone_and_the_others_end_after_it(begin: Begin, tmp_path: Path) -> None:
    script = begin()
    for name in ("run", "world", "voice"):
        number_in(tmp_path / name)
    os.killpg(script.pid, signal.SIGINT)
    script.communicate(timeout=PATIENCE_S)
    first, *others = (tmp_path / "ends").read_text().splitlines()
    assert (first, sorted(others)) == ("run was interrupted", ["voice was interrupted", "world was interrupted"])


def test_a_world_that_cannot_begin_is_reported_with_its_reason(begin: Begin) -> None:
    script = begin(BROKEN="1")
    _, printed = script.communicate(timeout=PATIENCE_S)
    assert (script.returncode, printed) == (2, "no such option\n")
