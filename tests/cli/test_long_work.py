# SPDX-License-Identifier: Apache-2.0
"""How far a long piece of work is: where it is shown, and what is left of it."""

from __future__ import annotations

import io
import threading
from pathlib import Path

import pytest

from rai_missions.cli.long_work import ERASE, LINE_S, LongWork, WorkPace
from rai_missions.cli.output import redacted_output, terminal_of
from rai_missions.cli.proof_report import how_far
from rai_missions.replay.replay import replay
from tests.cli.test_counts import sensed_run


class Terminal(io.StringIO):
    """A terminal of a test."""

    def isatty(self) -> bool:
        return True

    def __init__(self) -> None:
        super().__init__()
        self.written = threading.Event()

    def flush(self) -> None:
        self.written.set()


def test_on_a_terminal_a_line_is_updated_and_removed_at_the_end() -> None:
    out, texts = Terminal(), iter(["10 %", "20 %" * 100])
    with LongWork(lambda: next(texts, "done"), out) as work:
        assert out.written.wait(20)  # by the thread that looks again and again
        work.show()
    parts = out.getvalue().split(ERASE)
    assert parts[:2] == ["", "10 %"] and parts[-1] == ""
    assert all(len(part) < 200 and "\n" not in part for part in parts)


def test_elsewhere_it_is_a_line_each_ten_seconds_and_quick_work_shows_nothing() -> None:
    out = io.StringIO()
    with LongWork(lambda: "10 %", out) as work:
        assert out.getvalue() == "" and LINE_S == 10.0
        work.show()
    assert out.getvalue() == "10 %\n"


def test_what_is_drawn_reaches_the_terminal_below_what_is_redacted(capsys: pytest.CaptureFixture[str]) -> None:
    import sys

    with redacted_output(controls=False):
        terminal_of(sys.stderr).write(ERASE)
        sys.stderr.write(ERASE)
    assert capsys.readouterr().err == ERASE + ERASE.replace("\r", "\N{REPLACEMENT CHARACTER}").replace(
        "\x1b", "\N{REPLACEMENT CHARACTER}"
    )


def test_a_pace_counts_by_the_clock_that_it_was_given() -> None:
    times = iter([0.0, 2.0, 2.0, 4.0])
    pace = WorkPace(lambda: next(times))
    pace.set(50, 200)
    assert (pace.percent, pace.rate) == (25, 25.0)
    assert WorkPace().percent == 0
    exploring = WorkPace(lambda: 3.0)
    assert how_far(exploring) == "exploring, 0 s"
    exploring.set(1000, 3194)
    assert how_far(exploring) == "3,194 states found, 1,000 of them explored, 2,194 left, 0 states/s"


def test_a_replay_reports_each_step_that_it_has_done_again(tmp_path: Path) -> None:
    result, seen = sensed_run(tmp_path / "a.journal"), list[tuple[int, int]]()
    replay(tmp_path / "a.journal", progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (result.steps, result.steps)
    assert [done for done, _ in seen] == sorted({done for done, _ in seen})
