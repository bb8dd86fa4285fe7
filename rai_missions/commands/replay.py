# SPDX-License-Identifier: Apache-2.0
"""`rai-missions replay`: a run, done again."""

from __future__ import annotations

import argparse
import json
import sys

from rai_missions.commands.given import warn
from rai_missions.load import load
from rai_missions.progress import Lines

__all__ = ("replay",)


def replay(given: argparse.Namespace) -> int:
    """Do a run again."""
    from rai_missions.journal import read
    from rai_missions.rebuild import mission_of
    from rai_missions.recording import journal_of
    from rai_missions.replay import replay as again

    with journal_of(given.journal) as found:
        warn(found.warning)
        with read(found.path) as record:
            mission = load(given.mission, python=not given.no_python) if given.mission else mission_of(record)
        lines = Lines(mission, sys.stdout)
        result = again(found.path, on_step=lines.step if given.verbose and not given.json else None, mission=mission)
    holds = result.holds and result.steps > 0
    if given.json:
        print(
            json.dumps(
                {
                    "holds": holds,
                    "steps": result.steps,
                    "difference": result.difference,
                    "outcome": result.outcome,
                    "why": result.why,
                }
            )
        )
    elif not result.steps and result.holds:
        print(f"{given.journal} holds no step of a run: there is nothing to compare")
    elif result.holds:
        ended = f"{result.outcome}: {result.why}" if result.outcome else "it had not ended"
        print(f"{result.steps} steps done again, all the same; {ended}")
    else:
        print(f"{result.steps} steps were the same, then: {result.difference}")
    return 0 if holds else 1
