# SPDX-License-Identifier: Apache-2.0
"""`rai-missions check`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rai_missions.cli.command import GuardsFile, MissionFile, RobotFile, command

if TYPE_CHECKING:
    from rai_missions.errors import Fault

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

    All faults are printed at once, each with its place in the file.

    Args:
        mission: A .json file, or a .py file with a function mission().
        robot: Check also that the profile has every name that the mission uses; a robot in Python is not executed here.
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

    from rai_missions.check import check as find_faults
    from rai_missions.check import exit_status
    from rai_missions.cli.inputs import is_robot_program, load_guards, warn
    from rai_missions.mission.files import load

    loaded = load(mission, python=not no_python)
    named = load_guards(guards, python=not no_python)
    findings = find_faults(loaded, named=set(named)) if named is not None else find_faults(loaded)
    lacking: Sequence[Fault] = ()
    if is_robot_program(robot):
        warn(
            f"{robot}: whether it covers the mission was not checked: check executes no robot, and run checks it first"
        )
    elif robot:
        from rai_missions.profile import load_profile, missing  # half as long to import as all the rest

        lacking = missing(loaded, load_profile(robot))
    if json:
        rows = [{"place": each.place, "sentence": each.sentence, "severity": each.severity} for each in findings]
        rows += [{"place": each.place, "sentence": each.sentence, "severity": "error"} for each in lacking]
        print(dumps(rows))
    else:
        for each in (*findings, *lacking):
            print(f"{mission}: {each}", file=sys.stderr)
        if not findings and not lacking:
            print(f"{mission}: {loaded.name} {loaded.version} holds ({sum(1 for _ in loaded.walk())} states)")
    return 2 if lacking else exit_status(findings, strict=strict)
