# SPDX-License-Identifier: Apache-2.0
"""`rai-missions check draw`: a mission before it runs."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import ExitStack
from pathlib import Path

from rai_missions.check import check, exit_status
from rai_missions.commands.given import named_in, steps_of, warn
from rai_missions.errors import Fault
from rai_missions.load import load
from rai_missions.mission import Mission

__all__ = ("check_mission", "draw")


def check_mission(given: argparse.Namespace) -> int:
    """Print every fault of a mission, and of what a profile lacks."""
    mission = load(given.mission, python=not given.no_python)
    named = named_in(given.guards)
    findings = list(check(mission, named=set(named))) if named is not None else list(check(mission))
    lacks: tuple[Fault, ...] = ()
    if given.robot:
        from rai_missions.robot import load_profile, missing

        lacks = missing(mission, load_profile(given.robot))
    if given.json:
        rows = [{"place": each.place, "sentence": each.sentence, "severity": each.severity} for each in findings]
        rows += [{"place": each.place, "sentence": each.sentence, "severity": "error"} for each in lacks]
        print(json.dumps(rows))
    else:
        for each in (*findings, *lacks):
            print(f"{given.mission}: {each}", file=sys.stderr)
        if not findings and not lacks:
            states = sum(1 for _ in mission.walk())
            print(f"{given.mission}: {mission.name} {mission.version} holds ({states} states)")
    return 2 if lacks else exit_status(findings, strict=given.strict)


def draw(given: argparse.Namespace) -> int:
    """Draw a mission; as a page for review where the file ends so."""
    mission = load(given.mission, python=not given.no_python)
    output = given.output or f"{mission.name.replace('/', '_')}.svg"
    if output.lower().endswith(".html"):
        _draw_review(given, mission, output)
    else:
        from visualize import draw as draw_picture

        steps = [step for journal in given.journal for step in steps_of(journal, mission)]
        draw_picture(mission, output, steps=steps)
    print(output)
    return 0


def _draw_review(given: argparse.Namespace, mission: Mission, output: str) -> None:
    from rai_missions.recording import journal_of
    from visualize import draw_review

    with ExitStack() as open_recordings:
        found = [(path, open_recordings.enter_context(journal_of(path))) for path in given.journal]
        for _, journal in found:
            warn(journal.warning)
        journals = [(Path(path).name, journal.path) for path, journal in found]
        draw_review(mission, output, journals, check(mission))
