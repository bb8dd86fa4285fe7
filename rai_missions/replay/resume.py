# SPDX-License-Identifier: Apache-2.0
"""What a run that was cut short needs to continue: its chart as it was, and what it had under way.

Rule: a run continues only if this program does its steps in the same way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.journal import Note, Record, StepRow, checked, difference
from rai_missions.journal.in_flight import InFlight
from rai_missions.mission.mission import Mission
from rai_missions.replay.rebuild import JournalReplayer, Predicates

__all__ = ("Resumption", "resumption")


class Resumption(NamedTuple):
    """What a run was when its journal ends."""

    chart: Chart
    under: InFlight
    last: Step | None
    """The last step that was written down."""
    began: float
    """When the run began, on its own clock."""
    decisions: int
    """Questions asked so far."""
    run: str
    """The run's identity."""
    fresh: bool = False
    """The surroundings know of nothing that was done: a simulated world that begins again."""
    exact: bool = False
    """The surroundings are where the run is, as the branch of its world is: nothing need be received again."""
    arguments: Mapping[str, Any] = {}
    """The arguments that the run was made with; where it had not begun, they are written again."""
    waits: bool = False
    """Where it had not begun: it waits, ready, for the command to start."""
    mode_by: str = ""
    """Who brought it into its mode by a command; empty where no one did."""

    @property
    def at(self) -> float:
        """The instant on the run's clock from which it continues."""
        return self.chart.at


def resumption(record: Record, mission: Mission, named: Predicates | None = None) -> Resumption:
    """Do the steps of a journal again, to continue after the last.

    Args:
        record: The journal of the run that was cut short; whether its chain holds is looked at on the way.
        mission: The mission of its run.
        named: The predicates that guards name.

    Raises:
        DefinitionError: The journal was altered, or a step comes out differently: program or predicate has changed.
        UsageError: The run has ended, continues in another mission, or was played.
    """
    if record.header.played:
        sentence = f"the run of {record.path} was played by a person, and no robot is where it ended"
        raise UsageError(f"{sentence}: it cannot be continued; start a new one")
    replayer, under = JournalReplayer(record, mission, named=named), InFlight()
    chart, last, began, decisions = replayer.chart, None, 0.0, 0
    mode, mode_by = "", ""
    for row in checked(record):
        under.follow(row)
        if isinstance(row, Note) and row.successor is not None:
            successor = record.path.parent / str(row.successor["journal"])
            raise UsageError(f"the run of {record.path} continues in another mission: --resume {successor}")
        if not isinstance(row, StepRow):
            continue
        got = replayer.again(row)
        if found := difference(row.step, got, without=replayer.reworded):
            sentence = f"the run cannot continue, because this program does not do what was done: {found}"
            raise DefinitionError([Fault(f"row {row.row}", sentence)], str(record.path))
        began = row.since if last is None else began
        last = row.step
        decisions += last.questions
        if last.mode and last.mode != mode:
            mode, mode_by = last.mode, str(last.event.data.get("by", "")) if last.event.kind == "command" else ""
    if chart.outcome is not None and not chart.awaited_goals and not under.unsure:
        raise UsageError(f"the run of {record.path} has ended, {chart.outcome}: {chart.why}; start a new one")
    replayer.stop_replaying()
    arguments = {name: value for name, value in record.header.arguments.items() if name in mission.blackboard}
    run = record.header.run
    return Resumption(chart, under, last, began, decisions, run, arguments=arguments, mode_by=mode_by)
