# SPDX-License-Identifier: Apache-2.0
"""Secrets are hidden in any thread, whatever others do to the variables of the process meanwhile."""

from __future__ import annotations

import os
import threading

import pytest

from rai_missions.redaction import HIDDEN, redacted, variables

pytestmark = pytest.mark.usefixtures("changes_threads_often")
SECRET = "correct-horse-battery-4711"


def test_a_text_is_redacted_while_variables_come_and_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BROKER_PASSWORD", SECRET)
    over = threading.Event()

    def come_and_go() -> None:
        while not over.is_set():
            os.environ["COMES_AND_GOES"] = "here"
            del os.environ["COMES_AND_GOES"]

    changing = threading.Thread(target=come_and_go, daemon=True)
    changing.start()
    try:
        for _ in range(500):
            assert redacted(f"it is {SECRET}.") == f"it is {HIDDEN}."
            assert variables(secret=True)["BROKER_PASSWORD"] == SECRET
    finally:
        over.set()
        changing.join()
