# SPDX-License-Identifier: Apache-2.0
"""`rai-missions check draw`: a mission before it runs."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rai_missions.check import Finding, check, exit_status
from rai_missions.cli.arguments import named_in, steps_of, warn
from rai_missions.errors import Fault
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission

__all__ = ("check_mission", "draw")

ON_THE_PAGE = (
    "a picture of it would look like that of a sound run; a page (-o review.html) shows what can be read of it, and"
    " what is wrong with it"
)


def check_mission(given: argparse.Namespace) -> int:
    """Print every fault of a mission, and of what a profile lacks."""
    mission = load(given.mission, python=not given.no_python)
    named = named_in(given.guards, python=not given.no_python)
    findings = list(check(mission, named=set(named))) if named is not None else list(check(mission))
    lacks: tuple[Fault, ...] = ()
    if given.robot:
        from rai_missions.profile import load_profile, missing

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
    findings = check(mission)
    warn(_told(given.mission, [each for each in findings if each.severity == "error"], "'rai-missions check' says all"))
    if output.lower().endswith(".html"):
        _draw_review(given, mission, output, findings)
    else:
        from visualize import draw as draw_picture
        from visualize.mermaid import oversize

        steps = [step for journal in given.journal for step in steps_of(journal, mission, remedy=ON_THE_PAGE)]
        warn(oversize(draw_picture(mission, output, steps=steps)))
    print(output)
    return 0


def _told(path: str, faults: Sequence[Fault | Finding], where: str) -> str:
    """What is wrong with what is drawn, in a line; empty for nothing."""
    more = f" (and {len(faults) - 1} more; {where})" if len(faults) > 1 else ""
    return f"{path}: drawn with this error: {faults[0]}{more}" if faults else ""


def _draw_review(given: argparse.Namespace, mission: Mission, output: str, findings: Sequence[Finding]) -> None:
    from rai_missions.journal import verify
    from rai_missions.recording import journal_of
    from visualize import draw_review

    with ExitStack() as open_recordings:
        found = [(path, open_recordings.enter_context(journal_of(path))) for path in given.journal]
        journals = [(Path(path).name, journal.path) for path, journal in found]
        draw_review(mission, output, journals, findings)
        for path, journal in found:
            warn(journal.warning)
            warn(_told(path, verify(journal.path), "the page says all"))
