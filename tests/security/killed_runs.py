# SPDX-License-Identifier: Apache-2.0
"""A process in which a run takes words from everywhere, until it is killed: `python -m tests.security.killed_runs`.

Rule: it receives the secrets as a run does, by a variable and with its model, and never by its arguments.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
from pathlib import Path
from typing import Any

from pydantic import SecretStr

from rai_missions.agents.launch import prepare
from rai_missions.agents.run_config import RunConfig
from rai_missions.engine.step import Step
from tests.security.test_secrets_in_pieces import MISSION, ROBOT, Broken, Loose, Loud


def live(folder: Path, own: str, theirs: str, *, steps: int) -> None:
    """A run, or what is left of it in a folder, until it has made so many steps; then its process is killed."""
    journal, left = folder / "run.journal", steps

    def count(step: Step) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    life: dict[str, Any] = {"resume": journal} if journal.exists() else {"journal": journal}
    setting = RunConfig(
        None if journal.exists() else MISSION,
        ROBOT,
        model=Loose(key=SecretStr(own), theirs=theirs),
        connector=Loud(theirs),
        answerers={"someone": Broken(theirs)},
        record=folder / "run.mcap",
        on_step=count,
        **life,
    )
    with prepare(setting) as prepared:
        prepared.runner.run()


if __name__ == "__main__":
    logging.basicConfig(level=logging.DEBUG)
    live(Path(sys.argv[1]), json.load(sys.stdin), os.environ["STRANGERS_API_KEY"], steps=int(sys.argv[2]))
