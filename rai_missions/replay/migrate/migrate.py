# SPDX-License-Identifier: Apache-2.0
"""Makes of the journal of a run that was cut short the beginning of another, in the mission as it is now.

Rule: the new journal appears whole or not at all, and nothing is done before the old one names it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.snapshot_json import packed
from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.event import Event
from rai_missions.journal import MIGRATED, Header, Journal, Note, Record, opened, read
from rai_missions.journal.sqlite import log_of
from rai_missions.mission.files import journal_text
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import renamed
from rai_missions.profile import ActionEntry, Robot, dump_profile, missing, robot_facts
from rai_missions.replay.migrate.activities import carry
from rai_missions.replay.migrate.blackboard import board
from rai_missions.replay.migrate.configuration import reached_states
from rai_missions.replay.migrate.map import Map
from rai_missions.replay.migrate.names import Naming
from rai_missions.replay.rebuild import Predicates, mission_of, recorded_robot, robot_of
from rai_missions.replay.resume import Resumption, resumption

__all__ = ("MigratedRun", "follow", "migrate")


class MigratedRun(NamedTuple):
    """A run that has another mission now."""

    journal: Path
    mission: Mission
    notes: tuple[str, ...]
    """What begins again there, is canceled or forgotten."""


def migrate(
    journal: str | Path,
    mission: Mission,
    map_: Map,
    *,
    to: str | Path,
    robot: Robot | None = None,
    named: Predicates | None = None,
    programs: Mapping[str, str] = {},
    source: str = "",
) -> MigratedRun:
    """Move a run that was cut short into a mission that has changed; nothing is started by this.

    Args:
        journal: The journal of the run.
        mission: The mission as it is now, in which `check` finds no fault.
        map_: What has become of what.
        to: The new journal, which must not be there; `run --resume` continues with it.
        robot: The profile as it is now; by default the journal's.
        named: The predicates that guards name.
        programs: The files in Python as they are now, as `Header.programs` has them.
        source: Where the map comes from, for its faults.

    Raises:
        DefinitionError: The map lacks something, or is wrong.
        UsageError: The run has ended, has not begun, or continues elsewhere; or the new journal cannot be there.
    """
    if Path(to).parent.resolve() != Path(journal).parent.resolve():  # `follow` looks nowhere else
        sentence = (
            f"{to} is in another folder than {journal}, and a run's journals know each other by their names alone"
        )
        raise UsageError(f"{sentence}: name a file next to it, and move both together afterwards")
    with opened(journal) as record:
        was = mission_of(record)
        resumed = resumption(record, was, named=named)
        if resumed.chart.unstarted or resumed.chart.outcome is not None:
            state = "has not begun" if resumed.chart.unstarted else f"has ended, {resumed.chart.outcome}"
            raise UsageError(f"the run of {journal} {state}: there is nothing to continue; start a new one")
        profile = robot or robot_of(record)
        naming = Naming(was, mission, map_)
        chart = Chart(mission, robot_facts=robot_facts(profile) if profile is not None else None, named=named)
        data, at = _data(naming, resumed, chart, source), resumed.at
        if profile is not None and (faults := [*missing(mission, profile), *_other(record, profile, resumed, naming)]):
            raise DefinitionError(faults, profile.name)
        chart.absorb((), at=at, seq=resumed.chart.seq)
        step = chart.send(Event("migrate", at, data, "command"))
        if faults := _broken(chart):
            raise DefinitionError(faults, source or mission.name)
        header = _header(record, naming, profile, Path(to))._replace(programs=dict(programs))
        notes = [each for each in record.notes() if each.data is not None and each.successor is None]
        with Journal.open(journal, seal=record.seal) as old:
            _write(Path(to), header, step, notes)
            with read(to) as new:
                _leave(old, new)
    return MigratedRun(Path(to), mission, tuple(data["notes"]))


def follow(record: Record) -> None:
    """Name a run's new journal in the one that it comes from, if the process that migrated it died before that.

    That one is looked for next to this one only: no journal makes a program read or write elsewhere.

    Raises:
        UsageError: That run continued meanwhile, or in another journal: this one counts no more.
    """
    name = record.header.migrated.get("journal", "")
    origin = record.path.parent / name
    if not name or Path(name).name != name or not origin.is_file():
        return
    with read(origin) as before:
        went = [note.successor for note in before.notes() if note.successor is not None]
        if went and went[-1]["seal"] == _birth(record):
            return
        if went or before.seal != record.header.migrated["seal"]:
            sentence = f"the run of {origin} continued otherwise after {record.path} was made of it"
            raise UsageError(f"{sentence}; this journal counts no more")
        with Journal.open(origin, seal=before.seal) as old:
            _leave(old, record)


def _leave(old: Journal, new: Record) -> None:
    """Name in a journal the one in which its run continues."""
    data = {"journal": os.path.relpath(new.path, old.path.parent), "seal": _birth(new)}
    old.note(MIGRATED, data)


def _birth(record: Record) -> str:
    """The hash of a journal's row 0, by which it is known wherever it is."""
    return str(next(record.raw())[3])


def _other(record: Record, now: Robot, resumed: Resumption, naming: Naming) -> list[Fault]:
    """An action whose goal is under way must be what it was, under the keys' names of today."""
    robot, _ = recorded_robot(record)
    was = {name: _as_now(action, naming) for name, action in robot.actions.items()} if robot is not None else {}
    started = {each.action for each in resumed.under.open.values() if isinstance(each, StartGoal)}
    return [
        Fault(f"/actions/{name}", "a goal of it is under way, and the profile has another action there now; leave it")
        for name in sorted(started)
        if robot is not None and was.get(name) != now.actions.get(name)
    ]


def _as_now(action: ActionEntry, naming: Naming) -> ActionEntry:
    """An action that looks at keys by their names of today; what its services reply has names of its own."""
    guards = {"succeeded": action.succeeded, "failed": action.failed}
    return action.model_copy(
        update={word: renamed(guard, naming.names) for word, guard in guards.items() if guard is not None}
    )


def _data(naming: Naming, resumed: Resumption, chart: Chart, source: str) -> dict[str, Any]:
    """The data of the step of the migration.

    Raises:
        DefinitionError: The map lacks something, or is wrong; every fault at once.
    """
    resumed.chart.settle_holds()
    was = resumed.chart.snapshot()
    found, lost = reached_states(naming, was, resumed.chart.active, chart)
    known, unknown = board(naming, was["board"], resumed.at)
    if faults := [*naming.faults(), *lost, *unknown]:
        raise DefinitionError(faults, source)
    carried = carry(naming, was, found, resumed.under)
    if carried.faults:
        raise DefinitionError(carried.faults, source)
    return {
        "stands": packed({**carried.snapshot, "board": known}),
        "begins": [list(each) for each in carried.begins],
        "under_way": packed(carried.under_way),
        "accepted": sorted(resumed.under.accepted),
        "notes": list(carried.notes),
    }


def _broken(chart: Chart) -> list[Fault]:
    """The invariants of the other mission that are false in the states of the run."""
    return [
        Fault(f"/invariants/{name}", f"it is false where the run would continue: {words}; give other values or states")
        for name, words in chart.broken()
    ]


def _header(record: Record, naming: Naming, robot: Robot | None, to: Path) -> Header:
    """Row 0 of the new journal: the same run, in the mission as it is now."""
    header, keys = record.header, naming.now.blackboard
    renamed = {naming.key(name): value for name, value in header.arguments.items()} | dict(naming.map.values)
    arguments = {name: value for name, value in renamed.items() if name in keys and keys[name].source == "argument"}
    origin = {
        "journal": os.path.relpath(record.path, to.parent),
        "seal": record.seal,
        "mission": naming.was.name,
        "version": naming.was.version,
        "map": json.dumps(naming.map.written()),
    }
    profile = dump_profile(robot) if robot is not None else ""
    return Header(
        journal_text(naming.now),
        profile,
        arguments,
        run=header.run,
        started=header.started,
        versions=naming.now.packages(),
        migrated=origin,
    )


def _write(path: Path, header: Header, step: Step, notes: Sequence[Note]) -> None:
    """A journal with its first rows, or none; what programs read from the notes of the run, such as talk, is in it."""
    if path.exists():
        raise UsageError(f"{path} is there already, and a journal is never overwritten; name another file")
    part = path.with_name(f".{path.name}.part")
    try:
        for left in (part, log_of(part), log_of(path)):
            left.unlink(missing_ok=True)  # of a process that died, or of a journal that is gone
        try:
            with Journal.create(part, header) as new:
                new.write(step, since=step.at)
                for note in notes:
                    new.note(note.text, note.data)
            if log_of(part).exists():  # what could not be moved from it into the file would not get the file's name
                raise UsageError(f"{path} cannot be written: the disk is full; make room, and migrate again")
            part.rename(path)
        except BaseException:
            for left in (part, log_of(part)):
                with suppress(OSError):
                    left.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise UsageError(f"a journal cannot be written at {path}: {error.strerror}; name another file") from None
