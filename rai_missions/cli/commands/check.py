# SPDX-License-Identifier: Apache-2.0
"""`rai-missions check`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rai_missions.cli.command import GuardsFile, MissionFile, RobotFile, command

if TYPE_CHECKING:
    from rai_missions.check import CheckedFile, FileFinding
    from rai_missions.errors import Fault
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import Robot

__all__ = ("check",)


@command()
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
        mission: A .json file, or a .py file with a function mission().
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
    profile, lacking = "", tuple[FileFinding, ...]()
    if is_robot_program(robot) and robot is not None:
        file_bytes(Path(robot))  # it must be there
        warn(
            f"{robot}: whether it covers the mission was not checked: check executes no robot, and run checks it first"
        )
    elif robot:
        profile, lacking = _checked_profile(robot, checked.mission)
    found = sorted([*checked.findings, *lacking], key=lambda each: each.finding.severity != "error")
    if json:
        print(dumps([{"file": file, **finding._asdict()} for file, finding in found]))
    else:
        for each in found:
            print(each, file=sys.stderr)
        print(_summary(mission, checked, profile, found), file=sys.stderr if found else sys.stdout)
    return exit_status((each.finding for each in found), strict=strict)


def _checked_profile(path: str, mission: Mission | None) -> tuple[str, tuple[FileFinding, ...]]:
    """A profile's name, that of its file where it has none, and what is wrong with it or lacks in it."""
    from rai_missions.agents.talk.settings import conversation_faults, conversation_oddities
    from rai_missions.check import FileFinding, Finding
    from rai_missions.errors import DefinitionError
    from rai_missions.profile import load_profile, missing  # half as long to import as all the rest

    try:
        profile = load_profile(path)
    except DefinitionError as error:
        faults = (*error.faults, *_of_rest(path, mission))
        return path, tuple(FileFinding(error.source or path, Finding.of(each)) for each in faults)
    names = missing(mission, profile) if mission is not None else ()
    lacking = (*_connector_faults(profile), *names, *conversation_faults(profile, mission))
    odd = conversation_oddities(profile, mission) if mission is not None else ()
    findings = (*map(Finding.of, lacking), *(Finding(each.place, each.sentence, "warning") for each in odd))
    return profile.name or path, tuple(FileFinding(path, each) for each in findings)


def _of_rest(path: str, mission: Mission | None) -> Iterator[Fault]:
    """What is wrong with a profile of which some entries cannot be read, whatever those turn out to be."""
    from pathlib import Path

    from rai_missions.errors import DefinitionError
    from rai_missions.mission.json_reader import read_json
    from rai_missions.profile import legible_profile, missing_anyway

    try:
        document = read_json(Path(path))
    except DefinitionError:
        return
    robot = legible_profile(document)
    if robot is None:
        return
    if robot.connector == document.get("connector"):
        yield from (each for each in _connector_faults(robot) if each.place.startswith("/connector"))
    if mission is not None:
        yield from missing_anyway(mission, robot, document)


def _connector_faults(robot: Robot) -> Iterator[Fault]:
    """A kind of connector, a simulated world, an option of one, or a name there, that there is not."""
    from rai_missions.connectors.registry import check_connector, check_options
    from rai_missions.errors import Fault, UsageError
    from rai_missions.profile import misnamed
    from rai_missions.worlds.world import check_local

    connector = robot.connector
    kind, options = str(connector["kind"]), {word: each for word, each in connector.items() if word != "kind"}
    try:
        offer = check_connector(kind)
    except UsageError as error:
        yield Fault("/connector/kind", str(error))
        return
    try:
        if offer is not None:
            check_options(offer, options)
            if why_no_name := getattr(offer.load(), "why_no_name", None):
                yield from misnamed(robot, why_no_name)
        elif kind == "local":
            check_local(options)
    except UsageError as error:
        yield Fault("/connector", str(error))


def _summary(path: str, checked: CheckedFile, profile: str, found: Sequence[FileFinding]) -> str:
    """What was checked and what came of it, in a line."""
    from rai_missions.errors import counted

    both = "mission and profile" if profile else "mission"
    if checked.mission is None:
        return (
            f"{path}: the rest is checked when this can be read: what is unused, dead ends, cycles, the profile's names"
        )
    states = sum(1 for _ in checked.mission.walk())
    what = f"{checked.mission.name} {checked.mission.version}, {states} states{f'; {profile}' if profile else ''}"
    if not found:
        return f"{path}: {both}: no fault ({what})"
    errors = sum(each.finding.severity == "error" for each in found)
    return f"{path}: {both}: {counted(errors, 'error')}, {counted(len(found) - errors, 'warning')} ({what})"
