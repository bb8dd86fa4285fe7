# SPDX-License-Identifier: Apache-2.0
"""Anyone who takes what is printed, late or never: the run continues, and so does its e-stop."""

from __future__ import annotations

import io
import signal
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rai_missions.cli.output import MAX_PENDING, BufferedStream, nonblocking_output, wait_for_output
from rai_missions.cli.progress import Lines
from rai_missions.runtime.interrupts import on_interrupts
from tests.rigs.runs import Rig, mission

PATIENCE_S = 30.0
ROUND: dict[str, Any] = {
    "moving": {"action": "move", "timeout_s": 900, "transitions": [
        {"on": "again", "do": [{"set": "count", "add": 1}]}]},
}  # fmt: skip


class Stalled(io.StringIO):
    """A terminal that takes nothing until it is let go."""

    def __init__(self) -> None:
        super().__init__()
        self.released = threading.Event()

    def write(self, text: str) -> int:
        assert self.released.wait(PATIENCE_S)
        return super().write(text)


@pytest.fixture
def stalled() -> Iterator[Stalled]:
    made = Stalled()
    yield made
    made.released.set()


def fill(stream: Any) -> None:
    """Print more than can wait, once the first piece is on its way."""
    stream.write("0\n")
    while stream.waiting:
        threading.Event().wait(0.001)
    for number in range(1, MAX_PENDING + 500):
        stream.write(f"{number}\n")


def test_a_run_whose_lines_no_one_takes_is_stopped_all_the_same(stalled: Stalled) -> None:
    going = mission(ROUND)
    aside = BufferedStream(stalled)
    rig = Rig(going, on_step=Lines(going, aside, verbose=True).step)  # type: ignore[arg-type]
    rig.stage.each = lambda: rig.post("again")
    rig.stage.play({200.0: rig.runner.kill})
    result = rig.run()
    assert result.outcome == "aborted" and rig.move.canceled == rig.move.goals != []
    stalled.released.set()
    aside.settle()
    printed = stalled.getvalue()
    assert len(printed.splitlines()) < 2 * MAX_PENDING


def test_what_is_printed_comes_whole_and_in_its_order_and_what_is_left_out_is_counted(stalled: Stalled) -> None:
    aside = BufferedStream(stalled)
    fill(aside)
    stalled.released.set()
    while aside.waiting:
        threading.Event().wait(0.001)
    aside.write("and on\n")
    aside.settle()
    lines = stalled.getvalue().split("\n")
    kept = [int(line) for line in lines if line.isdigit()]
    assert kept == list(range(MAX_PENDING + 1)), "one was on its way"
    (left_out,) = [line for line in lines if "left out" in line]
    assert lines[-5:-1] == [str(kept[-1]), "", left_out, "and on"], "where it was left out"
    assert left_out.startswith(f"… {MAX_PENDING + 500 - len(kept)} pieces")


class Sink(io.StringIO):
    """A terminal that keeps the pieces that it was given."""

    def __init__(self) -> None:
        super().__init__()
        self.pieces: list[str] = []

    def write(self, text: str) -> int:
        self.pieces.append(text)
        return super().write(text)


def test_lines_of_two_threads_and_two_streams_are_whole() -> None:
    terminal = Sink()
    out, error = BufferedStream(terminal), BufferedStream(terminal)
    second = threading.Thread(target=lambda: [print("from", "another", file=out) for _ in range(200)])
    second.start()
    for _ in range(200):
        print("from", "one", file=out)
        print("a", "fault", file=error)
    second.join()
    out.settle()
    error.settle()
    whole = {"from another", "from one", "a fault"}
    assert set(terminal.getvalue().splitlines()) == whole
    assert {piece.strip() for piece in terminal.pieces} <= whole | {""}


def test_a_prompt_is_out_as_it_is_flushed_and_a_line_that_is_never_ended_at_the_end() -> None:
    terminal = Sink()
    out = BufferedStream(terminal)
    print("your answer: ", end="", file=out)
    assert not out.waiting and terminal.getvalue() == ""
    out.flush()
    while out.waiting or not terminal.getvalue():
        threading.Event().wait(0.001)
    assert terminal.getvalue() == "your answer: "
    print("no end", end="", file=out)
    out.settle()
    assert terminal.getvalue() == "your answer: no end"


def test_what_is_left_out_last_is_counted_as_well_and_what_is_reported_at_the_end_is_not_left_out(
    stalled: Stalled, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdout", stalled)
    with nonblocking_output():
        fill(sys.stdout)
        threading.Timer(0.1, stalled.released.set).start()
        wait_for_output()
        sys.stdout.write("the mission succeeded\n")
    before, _, after = stalled.getvalue().partition(" pieces of text are left out")
    kept = sum(line.isdigit() for line in before.splitlines())
    assert before.splitlines()[-1] == f"… {MAX_PENDING + 500 - kept}"
    assert after.splitlines()[-1] == "the mission succeeded"


def test_at_the_end_all_of_it_is_out_and_the_streams_are_as_before(capsys: pytest.CaptureFixture[str]) -> None:
    before = sys.stdout, sys.stderr
    with nonblocking_output():
        sys.stdout.write("to the reader\n")
        sys.stderr.write("to the operator\n")
        kept = sys.stderr
    assert (sys.stdout, sys.stderr) == before
    assert capsys.readouterr() == ("to the reader\n", "to the operator\n")
    kept.write("later\n")
    assert capsys.readouterr().err == "later\n"


class Gone(io.StringIO):
    """A terminal that no one has any more."""

    def write(self, text: str) -> int:
        raise BrokenPipeError


def test_an_interrupt_cancels_the_run_although_no_one_can_be_reported_so(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig(mission(ROUND))
    rig.stage.play({1.0: lambda: signal.raise_signal(signal.SIGTERM)})
    monkeypatch.setattr(sys, "stderr", Gone())
    with on_interrupts(rig.runner.cancel, rig.runner.kill):
        assert rig.run().outcome == "canceled"


def test_no_run_ends_otherwise_since_its_reader_has_gone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdout", Gone())
    with nonblocking_output():
        sys.stdout.write("to no one")
        wait_for_output()
        sys.stdout.write("the end")
        sys.stdout.flush()
    assert capsys.readouterr().err == ""


def test_what_is_not_printed_on_a_full_disk_is_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        with nonblocking_output():
            wait_for_output()
            sys.stdout.write("the end")
    assert "No space left" in capsys.readouterr().err
