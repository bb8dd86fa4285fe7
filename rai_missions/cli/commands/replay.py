# SPDX-License-Identifier: Apache-2.0
"""`rai-missions replay`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rai_missions.cli.command import Argument, JournalFile, command

if TYPE_CHECKING:
    from rai_missions.engine.step import Step
    from rai_missions.mission.mission import Mission
    from rai_missions.replay.replay import Replay

__all__ = ("replay",)

Follow = Callable[["Mission"], Callable[["Step"], object]]
SUFFIXES = (".journal", ".mcap")
"""What counts as a run in a folder."""


@command()
def replay(
    journal: JournalFile,
    *,
    mission: Annotated[str | None, Argument("FILE.py", files=("*.py",))] = None,
    no_python: bool = False,
    json: bool = False,
    verbose: bool = False,
) -> int:
    """Repeat runs from their journals or recordings and compare every step.

    Args:
        journal: A journal, a recording (.mcap), or a folder of them, with a verdict for each.
        mission: The mission, where it has behaviours in Python. It is executed.
        no_python: Refuse a mission in Python.
        json: Print one object at the end.
        verbose: Print the steps; with --json they are in the object, as `trace`.

    Exit status:
        0 every step is the same, 1 one differs, 2 the input is at fault

    Example:
        rai-missions replay journals
    """
    from json import dumps

    from rai_missions.check import load_whole
    from rai_missions.engine.description import step_json

    loaded = load_whole(mission, python=not no_python) if mission else None
    if Path(journal).is_dir():
        return _replay_folder(Path(journal), loaded, json=json)
    trace: list[Step] = []
    follow: Follow = (lambda _: trace.append) if json else _lines
    result = _replay(journal, loaded, follow if verbose else None)
    found = _as_json(result) | ({"trace": [step_json(step) for step in trace]} if verbose else {})
    print(dumps(found) if json else _sentence(journal, result))
    return 0 if _holds(result) else 1


def _replay_folder(folder: Path, mission: Mission | None, *, json: bool) -> int:
    """Repeat every run of a folder and the folders in it: a verdict each, in the order of their paths."""
    from json import dumps

    from rai_missions.errors import DefinitionError, UsageError
    from rai_missions.redaction import first_line

    paths = sorted(path for path in folder.rglob("*") if path.suffix in SUFFIXES and path.is_file())
    if not paths:
        raise UsageError(f"there is no run in '{folder}'; a run's file ends in {' or '.join(SUFFIXES)}")
    runs, held = [], 0
    for path in paths:
        name = path.relative_to(folder).as_posix()
        try:
            result = _replay(str(path), mission)
        except (DefinitionError, UsageError) as error:
            runs.append({"run": name, "holds": False, "fault": str(error)})
            verdict = f"cannot be read: {first_line(error, 300)}"
        else:
            runs.append({"run": name, **_as_json(result)})
            held += _holds(result)
            verdict = _sentence("it", result)
        if not json:
            print(f"{name}: {verdict}", flush=True)
    holds = held == len(paths)
    print(dumps({"holds": holds, "runs": runs}) if json else f"{held} of {len(paths)} runs are the same")
    return 0 if holds else 1


def _lines(mission: Mission) -> Callable[[Step], object]:
    """Prints the steps of a run."""
    import sys

    from rai_missions.cli.progress import Lines

    return Lines(mission, sys.stdout).step


def _replay(journal: str, mission: Mission | None, follow: Follow | None = None) -> Replay:
    from rai_missions.cli.inputs import warn
    from rai_missions.cli.long_work import LongWork, WorkPace
    from rai_missions.journal import read
    from rai_missions.recording import journal_of
    from rai_missions.replay.rebuild import mission_of
    from rai_missions.replay.replay import replay as repeat

    with journal_of(journal) as found:
        warn(found.warning)
        if mission is None:
            with read(found.path) as record:
                mission = mission_of(record)
        if follow is not None:
            result = repeat(found.path, on_step=follow(mission), mission=mission)
        else:
            pace = WorkPace()
            with LongWork(lambda: f"{pace.percent} % of {pace.total:,} steps done again, {pace.rate:,.0f} steps/s"):
                result = repeat(found.path, mission=mission, progress=pace.set)
    for each in result.outdated:
        warn(f"{journal}, row 0: warning: the profile of this run would be refused today: {each}")
    return result


def _holds(result: Replay) -> bool:
    return result.holds and result.steps > 0


def _as_json(result: Replay) -> dict[str, object]:
    return {
        "holds": _holds(result),
        "steps": result.steps,
        "difference": result.difference,
        "outcome": result.outcome,
        "why": result.why,
    }


def _sentence(name: str, result: Replay) -> str:
    from rai_missions.errors import counted

    again = f"{counted(result.steps, 'step')} done again from {counted(result.rows, 'row')}"
    if not result.holds:
        return f"{again}, the same so far, then: {result.difference}"
    if not result.steps:
        return f"{name} holds no step of a run: there is nothing to compare"
    ended = f"{result.outcome}: {result.why}" if result.outcome else "it had not ended"
    return f"{again}, all the same; {ended}"
