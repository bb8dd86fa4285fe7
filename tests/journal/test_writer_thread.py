# SPDX-License-Identifier: Apache-2.0
"""The thread on which a journal is written: a hanging disk holds no run up."""

from __future__ import annotations

import math
import threading

import pytest

from rai_missions.errors import ConnectorError
from rai_missions.journal import writer_thread
from rai_missions.journal.writer_thread import WriterThread


def test_closing_does_not_wait_for_a_disk_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    answers, thread = threading.Event(), WriterThread(lambda: None)
    monkeypatch.setattr(writer_thread, "LONGEST_S", 0.0)
    with pytest.raises(ConnectorError, match="has not answered"):
        thread.do(answers.wait)
    monkeypatch.setattr(writer_thread, "LONGEST_S", math.inf)  # no thread can be waited for so long
    thread.close()
    assert not answers.is_set()
    answers.set()
