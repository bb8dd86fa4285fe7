# SPDX-License-Identifier: Apache-2.0
"""`rai-missions check`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from rai_missions.cli.command import GuardsFile, MissionFile, RobotFile, command

if TYPE_CHECKING:
    from rai_missions.check import CheckedFile, FileFinding
    from rai_missions.mission.mission import Mission

__all__ = ("check",)


@command(only_reads=True)
def check(
    mission: MissionFile,
    *,
    robot: RobotFile | None = None,
    guards: GuardsFile | None = None,
    no_python: bool = False,
    strict: bool = False,
    json: bool = False,
) -> int:
    """Find every fault of a mission before it runs.

    All faults are printed at once, each with its file and its place in it, errors before warnings; a word that cannot
    be read hides none of the rest.

    Args:
        mission: A .json file, or a .py file with a mission or a function mission().
        robot: Check the profile as well, and that it has every name that the mission uses; a robot in Python is not
            executed here.
        guards: A Python file with the predicates of 'named' guards. It is executed.
        no_python: Refuse a mission and guards in Python.
        strict: Treat warnings as faults: exit 1.
        json: Print the findings as one JSON list.

    Exit status:
        0 no fault was found, 1 with --strict there are warnings, 2 the input is at fault

    Example:
        rai-missions check mission.json --robot robot.json
    """
    import sys
    from json import dumps
    from pathlib import Path

    from rai_missions.check import FileFinding, check_file, exit_status
    from rai_missions.cli.inputs import is_robot_program, load_guards, warn
    from rai_missions.mission.json_reader import file_bytes

    named = load_guards(guards, python=not no_python)
    checked = check_file(mission, python=not no_python, named=named)
    profile, lacking, read = "", tuple[FileFinding, ...](), frozenset[str]()
    if is_robot_program(robot) and robot is not None:
        file_bytes(Path(robot))  # it must be there
        warn(
            f"{robot}: whether it covers the mission was not checked: check executes no robot, and run checks it first"
        )
    elif robot:
        profile, lacking, read = _checked_profile(robot, checked.mission)
    own = _without_read_keys(checked.findings, mission, read)
    found = sorted([*own, *lacking], key=lambda each: each.finding.severity != "error")
    if json:
        print(dumps([{"file": file, **finding._asdict()} for file, finding in found]))
    else:
        for each in found:
            print(each, file=sys.stderr)
        print(_summary(mission, checked, profile, found), file=sys.stderr if found else sys.stdout)
    return exit_status((each.finding for each in found), strict=strict)


def _without_read_keys(found: Iterable[FileFinding], mission: str, read: Iterable[str]) -> Iterator[FileFinding]:
    """What was found in a mission, without the keys that nothing but the profile reads."""
    from rai_missions.errors import pointer

    places = {pointer(["blackboard", name]) for name in read}
    for each in found:
        if each.finding.rule != "unused-key" or each.file != mission or each.finding.place not in places:
            yield each


def _checked_profile(path: str, mission: Mission | None) -> tuple[str, tuple[FileFinding, ...], frozenset[str]]:
    """A profile's name, or that of its file, what is wrong with it or lacks in it, and the keys that it reads."""
    from rai_missions.agents.talk.settings import conversation_faults, conversation_oddities
    from rai_missions.check import FileFinding, Finding
    from rai_missions.errors import DefinitionError, Fault
    from rai_missions.profile import (  # slow
        connector_faults,
        field_faults,
        keys_read,
        load_whole_profile,
        missing,
        missing_tools,
        missing_world,
    )

    try:
        profile = load_whole_profile(path, mission)
    except DefinitionError as error:
        faults = tuple(FileFinding(error.source or path, Finding.of(each)) for each in error.faults)
        return path, faults, frozenset()
    names = missing(mission, profile) if mission is not None else ()
    over = tuple(connector_faults(profile)) or field_faults(mission, profile)
    lacking = (*over, *names, *conversation_faults(profile, mission))
    odd: list[Fault] = []
    if mission is not None:
        odd += [*missing_world(mission, profile), *missing_tools(mission, profile)]
        odd += conversation_oddities(profile, mission)
    errors = tuple(FileFinding(each.file or path, Finding.of(each)) for each in lacking)
    warnings = tuple(FileFinding(path, Finding(each.place, each.sentence, "warning")) for each in odd)
    read = keys_read(mission, profile) if mission is not None else frozenset[str]()
    return profile.name or path, errors + warnings, read


def _summary(path: str, checked: CheckedFile, profile: str, found: Sequence[FileFinding]) -> str:
    """What was checked and what came of it, in a line."""
    from rai_missions.errors import counted

    both = "mission and profile" if profile else "mission"
    errors = sum(each.finding.severity == "error" for each in found)
    counts = f"{counted(errors, 'error')}, {counted(len(found) - errors, 'warning')}"
    if checked.mission is None:
        has_rest = any(finding.place for _, finding in checked.findings)
        rest = "the rest is checked when this can be read: what is unused, dead ends, cycles, the profile's names"
        return f"{path}: {rest}" if has_rest else f"{path}: {both}: {counts}"
    states = counted(sum(1 for _ in checked.mission.walk()), "state")
    what = f"{checked.mission.name} {checked.mission.version}, {states}{f'; {profile}' if profile else ''}"
    return f"{path}: {both}: {counts if found else 'no fault'} ({what})"
