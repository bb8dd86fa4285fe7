# SPDX-License-Identifier: Apache-2.0
"""Reads from a journal what a run that was cut short is made of, and refuses what is no longer the same.

Rule: what has changed meanwhile is reported, never guessed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import DefinitionError, Fault
from rai_missions.journal import Header, Record, opened
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.replay.migrate import follow
from rai_missions.replay.rebuild import Predicates, mission_of, robot_of
from rai_missions.replay.resume import Resumption, resumption

__all__ = ("OpenedRun", "open_run")

MAY_CHANGE = frozenset({"$schema", "name", "about", "connector", "identity", "rules"})
"""The words of a profile that may differ: how the robot is reached and who answers, not what it receives and does."""


class OpenedRun(NamedTuple):
    """A run that continues."""

    record: Record
    mission: Mission
    robot: Robot | None
    resumption: Resumption


def open_run(
    journal: str | Path,
    *,
    mission: Mission | None = None,
    robot: Robot | None = None,
    named: Predicates | None = None,
    programs: Mapping[str, str] = {},
) -> OpenedRun:
    """Read a run that was cut short.

    Args:
        journal: Where it was written down.
        mission: The mission as it is now, if it is to be compared; needed for one with behaviours in Python.
        robot: The profile as it is now, if not the journal's is used.
        named: The predicates that guards name.
        programs: The files in Python that were named, as `Header.programs` has them.

    Raises:
        DefinitionError: The journal is damaged, or the mission, the profile or a file in Python has changed.
        UsageError: There is no such journal, or its run has ended or continues elsewhere.
    """
    record = opened(journal)
    try:
        was = mission_of(record) if record.header.mission or mission is None else mission
        if mission is not None and mission != was:
            sentence = f"the mission has changed since the run began ({was.version} then, {mission.version} now)"
            raise DefinitionError(
                [Fault("", f"{sentence}; continue with the one that the journal holds, or migrate")], str(journal)
            )
        if other := _others(record.header, programs):
            sentence = f"the file of the {' and that of the '.join(other)} has changed since the run began"
            raise DefinitionError(
                [Fault("", f"{sentence}; continue with the file as it was, or migrate")], str(journal)
            )
        before = robot_of(record)
        if robot is not None and before is not None and (changed := _changes(before, robot)):
            sentence = f"the robot profile has changed since the run began: {', '.join(changed)}"
            raise DefinitionError(
                [Fault("", f"{sentence}; continue with the one that the journal holds")], str(journal)
            )
        resumed = resumption(record, was, named=named)
        follow(record)
        return OpenedRun(record, was, before, resumed)
    except BaseException:
        record.close()
        raise


def _others(header: Header, programs: Mapping[str, str]) -> list[str]:
    """Which files in Python have other bytes now; a mission that is in the journal is compared as what it means."""
    return [
        name
        for name, now in programs.items()
        if header.programs.get(name, now) != now and not (name == "mission" and header.mission)
    ]


def _changes(before: Robot, now: Robot) -> list[str]:
    """The sections of a profile that mean something else now."""
    was, is_now = json.loads(dump_profile(before)), json.loads(dump_profile(now))
    return [each for each in sorted((was.keys() | is_now.keys()) - MAY_CHANGE) if was.get(each) != is_now.get(each)]
