# SPDX-License-Identifier: Apache-2.0
"""`rai-missions replay`: a run, or every run of a folder, done again."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rai_missions.cli.arguments import warn
from rai_missions.cli.progress import Lines
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.files import load
from rai_missions.redaction import first_line

if TYPE_CHECKING:
    from rai_missions.mission.mission import Mission
    from rai_missions.replay.replay import Replay

__all__ = ("replay",)


SUFFIXES = (".journal", ".mcap")
"""What counts as a run in a folder."""


def replay(given: argparse.Namespace) -> int:
    """Do a run again, or each run of a folder."""
    folder = Path(given.journal)
    return _replay_folder(folder, given) if folder.is_dir() else _replay_one(given)


def _replay_one(given: argparse.Namespace) -> int:
    mission = load(given.mission, python=not given.no_python) if given.mission else None
    result = _again(given.journal, mission, verbose=given.verbose and not given.json)
    if given.json:
        print(json.dumps(_as_json(result)))
    else:
        print(_sentence(given.journal, result))
    return 0 if _holds(result) else 1


def _replay_folder(folder: Path, given: argparse.Namespace) -> int:
    """Do every run of a folder and the folders in it again: a verdict each, in the order of their paths."""
    paths = sorted(path for path in folder.rglob("*") if path.suffix in SUFFIXES and path.is_file())
    if not paths:
        raise UsageError(f"there is no run in '{folder}'; a run's file ends in {' or '.join(SUFFIXES)}")
    mission = load(given.mission, python=not given.no_python) if given.mission else None
    runs, held = [], 0
    for path in paths:
        name = path.relative_to(folder).as_posix()
        try:
            result = _again(str(path), mission, verbose=False)
        except (DefinitionError, UsageError) as error:
            runs.append({"run": name, "holds": False, "fault": str(error)})
            said = f"cannot be read: {first_line(error, 300)}"
        else:
            runs.append({"run": name, **_as_json(result)})
            held += _holds(result)
            said = _sentence(name, result).removeprefix(f"{name} ")
        if not given.json:
            print(f"{name}: {said}", flush=True)
    if given.json:
        print(json.dumps({"holds": held == len(paths), "runs": runs}))
    else:
        print(f"{held} of {len(paths)} runs are the same")
    return 0 if held == len(paths) else 1


def _again(journal: str, mission: Mission | None, *, verbose: bool) -> Replay:
    from rai_missions.journal import read
    from rai_missions.recording import journal_of
    from rai_missions.replay.rebuild import mission_of
    from rai_missions.replay.replay import replay as again

    with journal_of(journal) as found:
        warn(found.warning)
        if mission is None:
            with read(found.path) as record:
                mission = mission_of(record)
        return again(found.path, on_step=Lines(mission, sys.stdout).step if verbose else None, mission=mission)


def _holds(result: Replay) -> bool:
    return result.holds and result.steps > 0


def _as_json(result: Replay) -> dict[str, object]:
    return {
        "holds": _holds(result), "steps": result.steps, "difference": result.difference,
        "outcome": result.outcome, "why": result.why,
    }  # fmt: skip


def _sentence(name: str, result: Replay) -> str:
    if not result.holds:
        return f"{result.steps} steps were the same, then: {result.difference}"
    if not result.steps:
        return f"{name} holds no step of a run: there is nothing to compare"
    ended = f"{result.outcome}: {result.why}" if result.outcome else "it had not ended"
    return f"{result.steps} steps done again, all the same; {ended}"
