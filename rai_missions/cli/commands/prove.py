# SPDX-License-Identifier: Apache-2.0
"""`rai-missions prove`."""

from __future__ import annotations

from typing import Annotated

from rai_missions.cli.command import Argument, GuardsFile, MissionFile, ProfileFile, command

__all__ = ("prove",)


@command(only_reads=True)
def prove(
    mission: MissionFile,
    *,
    robot: ProfileFile | None = None,
    states: Annotated[int | None, Argument("N")] = None,
    max_seconds: Annotated[float, Argument("S")] = 900.0,
    max_memory: Annotated[float, Argument("MIB")] = 4096.0,
    all_: bool = False,
    guards: GuardsFile | None = None,
    no_python: bool = False,
    output: Annotated[str | None, Argument("FILE", "-o", files=("*.journal",))] = None,
    json: bool = False,
) -> int:
    """Explore every run of a mission: each claim is proved, or refuted by a shortest run.

    Args:
        mission: A .json file, or a .py file with a mission or a function mission().
        robot: The profile, for which actions exclude each other and what composed actions depend on.
        states: The most states to explore; without it, a million.
        max_seconds: The most wall time, in seconds.
        max_memory: The most memory, in MiB.
        all_: After a refutation, explore the other claims to the limits. Without it, for ten times what the
            refutation cost.
        guards: A Python file with the predicates of 'named' guards. In a proof they may give any answer.
        no_python: Refuse a mission and guards in Python.
        output: The file for the run that refutes a claim. Without it: NAME-CLAIM.journal.
        json: Print one object.

    Exit status:
        0 every claim is proved, 1 one is refuted or a limit was reached, 2 the input is at fault

    Example:
        rai-missions prove mission.json --robot robot.json --max-seconds 60
    """
    from json import dumps

    from rai_missions.check import errors_of, load_whole
    from rai_missions.cli.inputs import distinct, load_guards
    from rai_missions.cli.long_work import LongWork, WorkPace
    from rai_missions.cli.proof_report import as_json, how_far, limits_of, report, write_journals
    from rai_missions.errors import DefinitionError
    from rai_missions.prove import prove as explore

    distinct({"MISSION": mission, "--robot": robot, "--guards": guards, "--output": output})
    loaded = load_whole(mission, python=not no_python)
    profile = None
    if robot:
        from rai_missions.profile import load_whole_profile, missing, robot_facts  # takes longer than a small proof

        profile = load_whole_profile(robot, loaded)
    named = load_guards(guards, python=not no_python)
    faults = errors_of(loaded, mission, named=named)
    if profile is not None:
        faults += (each._replace(file=robot or "") for each in missing(loaded, profile))
    if faults:
        raise DefinitionError(faults, mission)
    limits = limits_of(states, max_seconds, max_memory)
    facts = robot_facts(profile) if profile is not None else None
    pace = WorkPace()
    with LongWork(lambda: how_far(pace)):
        proof = explore(
            loaded, robot_facts=facts, progress=lambda found, done: pace.set(done, found), continues=all_, **limits
        )
    journals = write_journals(proof, loaded, profile, output)
    if json:
        print(dumps(as_json(loaded, proof, journals)))
    else:
        for line in report(loaded, proof, journals):
            print(line)
    return 0 if proof.verdict == "proved" else 1
