# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --resume JOURNAL MISSION --migrate MAP`: a run that goes on in a mission that has changed."""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path

from rai_missions.check import check, faults_of
from rai_missions.cli.arguments import warn
from rai_missions.engine import Named
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.files import load

__all__ = ("migrated",)


def migrated(given: argparse.Namespace, named: Named | None) -> None:
    """Make the journal of the run in the mission as it is now; from then on it is the one that is gone on with.

    Raises:
        DefinitionError: The mission or the map is at fault, or the map does not say enough.
        UsageError: The run cannot go on, or it is not said which one, or in what.
    """
    from rai_missions.profile import load_profile
    from rai_missions.replay.migrate import load_map, migrate

    if not (given.resume and given.mission):
        raise UsageError("--migrate MAP goes with --resume JOURNAL and the mission as it is now: MISSION")
    mission = load(given.mission, python=not given.no_python)
    if faults := faults_of(check(mission, named=set(named or ()))):
        raise DefinitionError(faults, given.mission)
    to = Path(given.journal) if given.journal else _beside(Path(given.resume))
    robot = load_profile(given.robot) if given.robot else None
    done = migrate(
        given.resume, mission, load_map(given.migrate), to=to, robot=robot, named=named, source=given.migrate
    )
    warn(f"the run of {given.resume} goes on in {to}, as '{mission.name}' {mission.version}")
    for note in done.notes:
        warn(f"migrated: {note}")
    given.resume, given.journal = str(to), None


def _beside(journal: Path) -> Path:
    """A name that nothing has yet."""
    numbers = itertools.chain(("",), (f"-{number}" for number in itertools.count(2)))
    names = (journal.with_stem(f"{journal.stem}-migrated{number}") for number in numbers)
    return next(path for path in names if not path.exists())
