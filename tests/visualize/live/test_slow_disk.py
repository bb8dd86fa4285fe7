# SPDX-License-Identifier: Apache-2.0
"""The page of a run whose disk hangs: its e-stop waits for nothing."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from rai_missions.journal import Journal
from tests.visualize.live.stage import until
from tests.visualize.live.test_command import Watched, watched

__all__ = ("watched",)


def test_the_page_stops_the_robot_while_the_disk_hangs_over_a_note_of_what_it_was_refused(
    watched: Callable[..., Watched], monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs, answers, note = threading.Event(), threading.Event(), Journal.note

    def slow(journal: Journal, text: str, data: Any = None) -> int:
        hangs.set()
        assert answers.wait(30)
        return note(journal, text, data)

    monkeypatch.setattr(Journal, "note", slow)
    one = watched()
    assert one.order(command="control", to="king")[0] == 409
    assert hangs.wait(30)
    asks = threading.Thread(target=lambda: one.order(command="e_stop"))
    asks.start()
    until(lambda: one.runner.view.urgent or one.mode == "ended", "the stop has come, though the disk hangs")
    assert not answers.is_set()
    answers.set()
    asks.join(30)
    assert one.end().outcome == "aborted"
    assert "refused: control king" in one.journal_text()
