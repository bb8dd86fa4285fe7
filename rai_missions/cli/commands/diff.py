# SPDX-License-Identifier: Apache-2.0
"""`rai-missions diff`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Literal

from rai_missions.cli.command import Argument, command

if TYPE_CHECKING:
    from rai_missions.mission.mission import Mission

__all__ = ("diff",)

MISSIONS = ("*.json", "*.py")


@command(only_reads=True)
def diff(
    old: Annotated[str, Argument("OLD", files=MISSIONS)],
    new: Annotated[str | None, Argument("NEW", files=MISSIONS)] = None,
    *,
    git: Annotated[str | None, Argument("REV")] = None,
    output: tuple[Annotated[str, Argument("FILE", "-o", files=("*",))], ...] = (),
    fail_on: Literal["safety", "any", "none"] = "safety",
    no_python: bool = False,
    python: bool = False,
) -> int:
    """Print what changed between two missions, by meaning; what a reviewer must not miss comes first.

    Args:
        old: The mission before. With --git, the one mission.
        new: The mission after.
        git: Compare one mission with itself at a commit, branch or tag. The missions that it includes are taken from
            there too.
        output: Write the difference to a file. Its ending decides the kind: .html is a page; .md is for a comment;
            .json is for programs; .svg .png .dot .mmd show both missions in one picture. May be repeated.
        fail_on: What exits 1.
        no_python: Refuse a mission in Python.
        python: Execute a mission in Python of another revision too.

    Exit status:
        0 nothing changed that diff weighs as safety-relevant, 1 something did (--fail-on changes what counts), 2 the
        input is at fault. It weighs what lets something happen that could not before, or removes a protection: an
        option newly offered to a model, a weaker guard, a longer timeout, a lost invariant, a new way to succeeded;
        and every change that it cannot judge. It does not weigh, so that a 0 means nothing for it: a change that
        makes the mission stricter, texts for people, the robot's profile, programs behind the mission, and the model
        that answers.

    Example:
        rai-missions diff old.json new.json -o difference.html
        rai-missions diff --git main mission.json
    """
    from rai_missions.check import load_whole
    from rai_missions.cli.inputs import distinct, warn
    from visualize import check_ending, difference, draw_difference
    from visualize.files import COMPARED
    from visualize.mermaid import oversize

    for path in output:
        for word, mission in (("OLD", old), ("NEW", new)):
            distinct({word: mission, "--output": path})
        check_ending(path, COMPARED)
    with _before(old, new, git, no_python=no_python, python=python) as before:
        found = difference(before, load_whole(new or old, python=not no_python))
    for line in found.lines():
        print(line)
    for path in output:
        warn(oversize(draw_difference(found, path)))
        print(f"written: {path}")
    return int(bool({"safety": found.safety, "any": found.changes, "none": ()}[fail_on]))


@contextmanager
def _before(old: str, new: str | None, revision: str | None, *, no_python: bool, python: bool) -> Iterator[Mission]:
    """The mission before: a file, or a file at another revision."""
    from pathlib import Path

    from rai_missions.check import load_whole
    from rai_missions.cli.git import at_revision
    from rai_missions.errors import UsageError

    if revision is None:
        if new is None:
            raise UsageError("give two missions, OLD and NEW, or one and where it was: diff --git REV MISSION")
        yield load_whole(old, python=not no_python)
        return
    if new is not None:
        raise UsageError("--git compares one mission with itself at a revision: diff --git REV MISSION")
    with at_revision(revision, Path(old), python=python and not no_python) as file:
        yield load_whole(file)
