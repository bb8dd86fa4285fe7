# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --resume JOURNAL MISSION --migrate MAP`: a run that resumes in a mission that has changed."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import TYPE_CHECKING

from rai_missions.check import errors_of, load_whole
from rai_missions.cli.inputs import program_hashes, warn
from rai_missions.engine import Named
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import opened

if TYPE_CHECKING:
    from rai_missions.cli.run.options import RunOptions

__all__ = ("migrated",)


def migrated(options: RunOptions, named: Named | None) -> RunOptions:
    """Make the journal of the run in the mission as it is now; from then on the run resumes from it.

    Raises:
        DefinitionError: The mission or the map is at fault, or the map is not complete.
        UsageError: The run cannot be resumed, or the options do not name it and the mission.
    """
    from rai_missions.profile import is_program, load_profile
    from rai_missions.profile.python_robot import same_file
    from rai_missions.replay.migrate import load_map, migrate

    if not (options.migrate and options.resume and options.mission):
        raise UsageError("--migrate MAP goes with --resume JOURNAL and the mission as it is now: MISSION")
    mission = load_whole(options.mission, python=not options.no_python)
    if faults := errors_of(mission, options.mission, named=named or {}):
        raise DefinitionError(faults, options.mission)
    to = Path(options.journal) if options.journal else _free_name(Path(options.resume))
    if options.robot and is_program(options.robot):  # before anything is written
        with opened(options.resume) as record:
            same_file(Path(options.robot), _hash_of(record.header.profile))
    robot = load_profile(options.robot) if options.robot and not is_program(options.robot) else None
    done = migrate(
        options.resume, mission, load_map(options.migrate), to=to, robot=robot, named=named,
        programs=program_hashes(mission=options.mission, guards=options.guards), source=options.migrate,
    )  # fmt: skip
    warn(f"the run of {options.resume} resumes in {to}, as '{mission.name}' {mission.version}")
    for note in done.notes:
        warn(f"migrated: {note}")
    return options._replace(resume=str(to), journal=None)


def _hash_of(profile: str) -> str | None:
    """The hash of the file in Python that was the robot of a run; None where it was none, which is refused later."""
    found = json.loads(profile or "{}").get("connector", {}).get("sha256")
    return found if isinstance(found, str) else None


def _free_name(journal: Path) -> Path:
    """A name that nothing has yet."""
    numbers = itertools.chain(("",), (f"-{number}" for number in itertools.count(2)))
    names = (journal.with_stem(f"{journal.stem}-migrated{number}") for number in numbers)
    return next(path for path in names if not path.exists())
