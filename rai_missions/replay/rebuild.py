# SPDX-License-Identifier: Apache-2.0
"""A chart brought, from a journal's events, to where its run was.

Rule: the chart that is rebuilt is the chart that ran; nothing of a step is taken from the journal but its event.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, Fault, MissionError, raised_text
from rai_missions.event import is_e_stop
from rai_missions.guards.guard import RaisedBefore
from rai_missions.guards.view import Truth
from rai_missions.journal import Record, StepRow
from rai_missions.mission.json_reader import parse_json
from rai_missions.mission.mission import Mission
from rai_missions.model.validation_errors import validated
from rai_missions.profile import Robot, recorded_profile, robot_facts

__all__ = ("JournalReplayer", "Predicates", "mission_of", "recorded_robot", "robot_of")

Predicates = Mapping[str, Callable[..., Truth]]


class JournalReplayer:
    """Does a run's steps again, one by one.

    Args:
        record: The journal.
        mission: The mission of its run.
        ticker: What ticks trees, if not as compiled by the chart.
        named: The predicates that guards name, for when the chart has been rebuilt; until then their values are those
            of the journal.
    """

    def __init__(
        self, record: Record, mission: Mission, ticker: Trees | None = None, named: Predicates | None = None
    ) -> None:
        robot, self.outdated = recorded_robot(record)
        """What in the profile of the run would be refused today; of it a replay needs the actions and services."""
        self.reworded: tuple[str, ...] = ()
        """The fields of steps that mean the same in other words than when they were recorded. After an e-stop `why` is
        made of that event alone, and earlier versions had another word for the stop."""
        self._source, self._live = str(record.path), named or {}
        self._recorded: deque[tuple[str, Truth]] | None = deque()
        """The values of predicates that the step in hand has looked at; None once the predicates are asked."""
        self._notes: tuple[str, ...] = ()
        try:
            self.chart = Chart(
                mission,
                ticker,
                robot_facts=robot_facts(robot) if robot is not None else None,
                named={name: partial(self._predicate, name) for name in mission.predicates()},
            )
        except MissionError:
            raise
        except Exception as error:
            sentence = f"no run is of such a mission ({raised_text(error)}); it was altered"
            raise DefinitionError([Fault("row 0", sentence)], self._source) from error

    def again(self, row: StepRow) -> Step:
        """The step that the chart makes of a row's event.

        Raises:
            DefinitionError: The chart can make nothing of it: no run has brought such an event.
        """
        chart, step = self.chart, row.step
        self._recorded = deque((place[6:], value) for place, value in step.guards if place.startswith("named:"))
        self._notes = step.notes
        if is_e_stop(step.event) and step.outcome:
            self.reworded = ("why",)
        try:
            chart.absorb(row.before, at=row.since, seq=step.seq - 1)
            if step.event.kind == "command" and step.event.name == "start":
                return chart.start(step.event.at)
            return chart.send(step.event)
        except MissionError:
            raise
        except Exception as error:
            sentence = f"no run brings such an event ({raised_text(error)}); it was altered"
            raise DefinitionError([Fault(f"row {row.row}", sentence)], self._source) from error

    def stop_replaying(self) -> None:
        """From now on the predicates themselves are asked."""
        self._recorded = None

    def _predicate(self, name: str, known: Mapping[str, Any], /, **arguments: Any) -> Truth:
        """The value of a predicate of the user's program, as the journal has it."""
        if self._recorded is None:
            return self._live[name](known, **arguments)
        asked, _, note = self._recorded[0][0].partition("#") if self._recorded else ("", "", "")
        if asked != name:
            return None
        if note:
            self._recorded.popleft()
            raise RaisedBefore(self._notes[int(note)])
        return self._recorded.popleft()[1]


def mission_of(record: Record) -> Mission:
    """The mission that a journal's run was of.

    Raises:
        DefinitionError: Row 0 holds none.
    """
    source = f"{record.path}, row 0"
    if not record.header.mission:
        sentence = "the mission has behaviours in Python and is not in its journal; give its file: --mission FILE.py"
        raise DefinitionError([Fault("", sentence)], source)
    data = parse_json(record.header.mission.encode("utf-8", "surrogatepass"), source)
    mission = validated(Mission, data, source)
    if faults := list(_of_other_versions(mission, record.header.versions)):
        raise DefinitionError(faults, source)
    return mission


def _of_other_versions(mission: Mission, then: Mapping[str, str]) -> Iterator[Fault]:
    """The packages whose kinds the mission uses that are here in another version than its run was made with."""
    for package, now in mission.packages().items():
        if then.get(package) != now:
            was = f"{package} {then[package]}" if package in then else f"no {package}"
            remedy = f"pip install '{package}=={then[package]}'" if package in then else "replay it where it was made"
            yield Fault("", f"the run was made with {was}, and {now} is installed; {remedy}")


def recorded_robot(record: Record) -> tuple[Robot | None, tuple[Fault, ...]]:
    """The profile of a run by the rules of its day, and what in it would be refused today; None without one."""
    profile = record.header.profile
    return recorded_profile(profile, f"{record.path}, row 0") if profile else (None, ())


def robot_of(record: Record) -> Robot | None:
    """The profile that a journal's run was made with, for a run that continues with it; None for one without.

    Raises:
        DefinitionError: It would be refused today.
    """
    robot, outdated = recorded_robot(record)
    if outdated:
        remedy = "a run that was made with it continues with a profile that is mended: --robot PROFILE --migrate MAP"
        raise DefinitionError([*outdated, Fault("", remedy)], f"{record.path}, row 0")
    return robot
