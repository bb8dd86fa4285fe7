# SPDX-License-Identifier: Apache-2.0
"""`rai-missions gate` is held up by no search of all that was loaded for it."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.gate.ros.drill import Party

PROGRAM = """
import gc, json, signal
from rai_missions.cli.main import main
signal.signal(signal.SIGUSR1, lambda *_: print(json.dumps([gc.get_freeze_count(), len(gc.get_objects())]), flush=True))
main({words})
"""


@pytest.mark.long
def test_no_search_of_a_gate_visits_what_was_loaded_for_it(domain: int, tmp_path: Path) -> None:
    """A full search takes 34 ms; so long, a stop waited at the actuators."""
    words = ["gate", "--ros", "--domain", str(domain), "--memory", str(tmp_path / "gate.memory")]
    gate = Party("-c", PROGRAM.replace("{words}", repr(words)))
    try:
        gate.lines.wait(lambda lines: any("commands are received" in str(each[-1]) for each in lines), "it is open")
        gate.process.send_signal(signal.SIGUSR1)
        gate.lines.wait(lambda lines: lines[-1][0] != "text", "it has counted")
        left, searched = gate.lines.all[-1]
        assert searched < left / 5
        gate.process.send_signal(signal.SIGINT)
        gate.process.wait(60)
    finally:
        gate.end()
