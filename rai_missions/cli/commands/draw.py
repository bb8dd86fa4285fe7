# SPDX-License-Identifier: Apache-2.0
"""`rai-missions draw`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from rai_missions.cli.command import Argument, JournalFile, MissionFile, command

if TYPE_CHECKING:
    from rai_missions.check import Finding
    from rai_missions.cli.long_work import LongWork
    from rai_missions.errors import Fault
    from rai_missions.mission.mission import Mission

__all__ = ("draw",)

REMEDY = (
    "a picture of it would look like that of a sound run; a page (-o review.html) shows what can be read of it, and"
    " what is wrong with it"
)


@command(only_reads=True)
def draw(
    mission: MissionFile,
    *,
    output: Annotated[str | None, Argument("FILE", "-o", files=("*",))] = None,
    journal: tuple[JournalFile, ...] = (),
    no_python: bool = False,
) -> int:
    """Draw a mission, with the path of a run in bold.

    Args:
        mission: A .json file, or a .py file with a mission or a function mission().
        output: The file to write. Its ending decides the kind: .html is a page for review; .svg .png .dot .mmd .md
            are pictures. Without it: NAME.svg.
        journal: Draw the path of this run in bold; may be repeated.
        no_python: Refuse a mission in Python.

    Exit status:
        0 it was drawn, 2 the input is at fault

    Example:
        rai-missions draw mission.json -o review.html
    """
    from rai_missions.check import check, load_whole
    from rai_missions.cli.inputs import journal_steps, warn
    from visualize import draw as draw_picture
    from visualize.mermaid import oversize

    loaded = load_whole(mission, python=not no_python)
    path = output or f"{loaded.name.replace('/', '_')}.svg"
    findings = check(loaded)
    errors = [each for each in findings if each.severity == "error"]
    warn(_first_of(mission, errors, "'rai-missions check' lists all"))
    if path.lower().endswith(".html"):
        _draw_review(loaded, path, journal, findings)
    else:
        steps = [step for each in journal for step in journal_steps(each, loaded, remedy=REMEDY)]
        with _progress(loaded):
            drawn = draw_picture(loaded, path, steps=steps)
        warn(oversize(drawn))
    print(path)
    return 0


def _first_of(path: str, faults: Sequence[Fault | Finding], where: str) -> str:
    """What is wrong with what is drawn, in a line; empty for nothing."""
    more = f" (and {len(faults) - 1} more; {where})" if len(faults) > 1 else ""
    return f"{path}: drawn with this error: {faults[0]}{more}" if faults else ""


def _progress(mission: Mission) -> LongWork:
    """How long it has taken; Graphviz does not report how far it is."""
    from rai_missions.cli.long_work import LongWork, WorkPace

    pace, states = WorkPace(), sum(1 for _ in mission.walk())
    return LongWork(lambda: f"drawing {states:,} states, {pace.elapsed_s:.0f} s")


def _draw_review(mission: Mission, output: str, journals: Sequence[str], findings: Sequence[Finding]) -> None:
    from contextlib import ExitStack
    from pathlib import Path

    from rai_missions.cli.inputs import warn
    from rai_missions.journal import verify
    from rai_missions.recording import journal_of
    from visualize import draw_review

    with ExitStack() as open_recordings:
        found = [(path, open_recordings.enter_context(journal_of(path))) for path in journals]
        with _progress(mission):
            draw_review(mission, output, [(Path(path).name, each.path) for path, each in found], findings)
        for path, each in found:
            warn(each.warning)
            warn(_first_of(path, verify(each.path), "the page lists all"))
