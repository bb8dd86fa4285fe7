# SPDX-License-Identifier: Apache-2.0
"""No piece of a secret is in what a killed process leaves, nor in what is made of that: by resume, replay and pages.

Rule: a process is killed by the system, so that nothing of it closes, cleans or completes a file.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rai_missions.replay.replay import replay
from tests.security.test_secrets_in_pieces import MISSION, SECRETS, assert_whole, secret_of
from visualize import draw_review

ROOT = Path(__file__).parents[2]
WHOLE = 10_000
"""More steps than a run makes: its process ends by itself."""


def everything(folder: Path) -> dict[str, bytes | str]:
    """The bytes of each file, at whatever depth."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class Life:
    """A process that runs until so many steps are made.

    Args:
        folder: What it writes, and what its temporary files are in.
        own: The key of its model.
        theirs: A secret in a variable, which all others report.
        steps: After so many it is killed.
    """

    def __init__(self, folder: Path, own: str, theirs: str, steps: int) -> None:
        (folder / "temporary").mkdir(exist_ok=True)
        given = {"STRANGERS_API_KEY": theirs, "TMPDIR": str(folder / "temporary")}
        command = [sys.executable, "-m", "tests.security.killed_runs", str(folder), str(steps)]
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=os.environ | given,
            input=json.dumps(own).encode(),
            capture_output=True,
            timeout=60,
            check=False,
        )
        self.printed = done.stdout + done.stderr
        self.is_killed = done.returncode == -signal.SIGKILL
        assert self.is_killed or not done.returncode, done.stderr[-2000:]


def leaves_nothing(own: str, theirs: str, cuts: list[int]) -> int:
    """How many of these lives were cut short."""
    killed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for steps in (*cuts, WHOLE):
            life = Life(folder, own, theirs, steps)
            killed += life.is_killed
            assert_whole(everything(folder) | {"printed": life.printed}, own, theirs)
            if not life.is_killed:
                break
        journal = folder / "run.journal"
        with pytest.MonkeyPatch.context() as patch:
            patch.delenv("STRANGERS_API_KEY", raising=False)
            assert replay(journal).holds
            draw_review(MISSION, folder / "page.html", [journal])
        assert_whole(everything(folder), own, theirs)
    return killed


CUTS = st.lists(st.integers(1, 30), min_size=1, max_size=3)


@pytest.mark.long
def test_no_piece_of_a_secret_is_in_what_a_killed_run_leaves() -> None:
    assert leaves_nothing(secret_of(3, 300, 0.1), secret_of(4, 2_001, 0.1), [20]) == 1


@pytest.mark.drill
@pytest.mark.timeout(3600)
@settings(deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.generate], max_examples=100)
@given(SECRETS, SECRETS, CUTS)
def test_no_piece_of_a_secret_is_in_what_many_killed_runs_leave(own: str, theirs: str, cuts: list[int]) -> None:
    leaves_nothing(own, theirs, cuts)
