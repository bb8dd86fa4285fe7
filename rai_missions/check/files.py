# SPDX-License-Identifier: Apache-2.0
"""A mission's file, checked whole: what cannot be read in it, and what is wrong in the rest.

Rule: a word that cannot be read hides no fault elsewhere, and causes no finding elsewhere.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.check.finding import Finding, document_order, faults_of
from rai_missions.check.rules import check, check_part, holds_anyway
from rai_missions.errors import DefinitionError, Fault, MissionError, steps_of
from rai_missions.mission.files import written_mission
from rai_missions.mission.garbage import few_collections
from rai_missions.mission.include import expanded
from rai_missions.mission.json_reader import read_json
from rai_missions.mission.legible import LegiblePart, legible_part
from rai_missions.mission.mission import Mission
from rai_missions.mission.origins import Origins
from rai_missions.states import Include

__all__ = ("CheckedFile", "FileFinding", "check_file", "errors_of", "load_whole")


class FileFinding(NamedTuple):
    """A finding, and the file that its place is in."""

    file: str
    finding: Finding

    def __str__(self) -> str:
        return f"{self.file}: {self.finding}"


class CheckedFile(NamedTuple):
    """What came of checking a file."""

    mission: Mission | None
    """None where it cannot be read as a whole; then what is unused, dead ends and cycles were not looked for."""
    findings: tuple[FileFinding, ...]


def check_file(path: str, *, python: bool = True, named: Collection[str] | None = None) -> CheckedFile:
    """Everything that is wrong or odd in a mission's file and in those that it includes.

    Args:
        path: As `load` takes it.
        python: Whether a `.py` file may be executed.
        named: The names of the registered predicates, as in `check`.

    Raises:
        UsageError: There is no such file, or it is of another kind.
    """
    read = _read(path, python=python)
    if read.whole is None:
        return CheckedFile(None, tuple(_with_rest(path, read, named)))
    return CheckedFile(read.whole, tuple(_located(path, read.whole, check(read.whole, named=named))))


def errors_of(
    mission: Mission, path: str | os.PathLike[str] = "", *, named: Collection[str] | None = None
) -> list[Fault]:
    """The errors that `check` finds in a mission that is about to run, each in the file that its author opens.

    Args:
        mission: As `load` made it.
        path: The file that it was loaded from; empty where it was made in Python.
        named: The names of the registered predicates, as in `check`.
    """
    found = [each for each in check(mission, named=named) if each.severity == "error"]
    return [each.finding.fault._replace(file=each.file) for each in _located(str(path), mission, found)]


def load_whole(path: str | os.PathLike[str], *, python: bool = True) -> Mission:
    """The mission in a file, as `load`; where it cannot be read, what is wrong in the rest is in the error as well.

    Args:
        path: As `load` takes it.
        python: Whether a `.py` file may be executed.

    Raises:
        DefinitionError: The mission is at fault; every error with its JSON pointer.
        UsageError: There is no such file, or it is of another kind.
    """
    read = _read(path, python=python)
    if read.whole is not None:
        return read.whole
    found = [each.finding for each in _with_rest(str(path), read, None)]
    raise DefinitionError(faults_of(found), read.source)


class _FileContent(NamedTuple):
    """What a file is read as: what is written there, and the whole with all that it includes; None for what is not."""

    written: Mission | None
    whole: Mission | None
    unread: tuple[Finding, ...]
    """What cannot be read."""
    source: str
    """The file with that."""


def _read(path: str | os.PathLike[str], *, python: bool) -> _FileContent:
    """Read a file as `load` does; one in Python is executed once.

    Raises:
        UsageError: There is no such file, or it is of another kind.
    """
    written: Mission | None = None
    try:
        with few_collections():
            written = written_mission(path, python=python)
            return _FileContent(written, expanded(written, Path(path)), (), str(path))
    except DefinitionError as error:
        return _FileContent(written, None, tuple(map(Finding.of, error.faults)), error.source or str(path))


def _located(path: str, mission: Mission, findings: Iterable[Finding]) -> Iterator[FileFinding]:
    """Findings in an expanded mission, each in the file and at the place where it is written."""
    origins = Origins(path, mission)
    for each in findings:
        there = origins.of(each.place)
        yield FileFinding(there.file, each._replace(place=there.place))


def _with_rest(path: str, read: _FileContent, named: Collection[str] | None) -> Iterator[FileFinding]:
    """What cannot be read, and what is wrong in the rest, in document order."""
    document: Any = None
    rest: tuple[Finding, ...] = ()
    try:
        if path.endswith(".json"):
            document = read_json(Path(path))
        elif read.written is not None:
            document = read.written.written()
        rest = _of_rest(document, path, read, named)
    except MissionError:
        rest = ()
    places = {each.place for each in read.unread}
    found = [*read.unread, *(each for each in rest if each.place not in places)]
    order = document_order(document)
    for each in sorted(found, key=lambda each: order(each.place)) if document is not None else found:
        yield FileFinding(read.source, each)


def _of_rest(document: Any, path: str, read: _FileContent, named: Collection[str] | None) -> tuple[Finding, ...]:
    if not isinstance(document, Mapping):
        return ()
    if read.written is not None:  # only what it includes cannot be read
        part = LegiblePart(read.written, _steps(read.unread), frozenset(), has_states=True, has_targets=True)
    elif (legible := legible_part(document)) is None:
        return ()
    else:
        part = legible
    hidden = (Finding.of(each) for each in part.faults)
    unfit: tuple[Finding, ...] = ()
    try:
        part = part._replace(mission=expanded(part.mission, Path(path)))
    except DefinitionError as error:
        unfit = tuple(Finding.of(each) for each in error.faults if each.place)
    included = [each for each in unfit if holds_anyway(each, "state", part, document)]
    # What a state reports that is an inclusion still is not known.
    reporting = (
        Finding(f"{place}/mission", "") for place, _, state in part.mission.walk() if isinstance(state, Include)
    )
    part = part._replace(unread=(*part.unread, *_steps(unfit), *_steps(reporting)))
    return (*hidden, *included, *check_part(part, document, named=named))


def _steps(findings: Iterable[Finding]) -> tuple[tuple[str, ...], ...]:
    """The steps to the place of each finding."""
    return tuple(steps_of(each.place) for each in findings)
