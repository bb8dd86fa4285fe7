# SPDX-License-Identifier: Apache-2.0
"""How a process continues with a run that another was killed in: what was under way first, then what is so now.

Rule: no one is asked, and nothing is decided, on what the robot reported before the process died.
"""

from __future__ import annotations

import math

from rai_missions.engine import Chart
from rai_missions.engine.step import StartGoal
from rai_missions.event import Event
from rai_missions.journal.buffer import BufferedWriter
from rai_missions.keys import stale_at, type_error
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.effects import EffectExecutor

__all__ = ("ResyncWindow", "resume_effects")


def resume_effects(resumed: Resumption, performer: EffectExecutor, scribe: BufferedWriter) -> None:
    """Continue with what was under way, and write down what was done again; raises what the journal raises."""
    chart, under = resumed.chart, resumed.under
    performer.resume(under, chart.awaited, chart.wanted, fresh=resumed.fresh)
    for seq, effects in under.unsure.items():
        if resumed.fresh or (chart.outcome is not None and not any(isinstance(each, StartGoal) for each in effects)):
            scribe.settle(seq, "performed" if resumed.fresh else "in doubt")
        elif not any(performer.is_doubtful(each) for each in effects):
            scribe.settle(seq, "repeated")


class ResyncWindow:
    """What a resumed process receives of the robot, until all that was known has been received again.

    The first value of each fact that was known is the one with which the run continues: it counts from the beginning.
    Whatever else arrives waits, each event with the instant of its arrival.

    Args:
        chart: How far the run had come.
        now: The instant on the run's clock from which it continues.
    """

    def __init__(self, chart: Chart, now: float) -> None:
        self._keys, board = chart.mission.blackboard, chart.view.board
        known = {name: entry for name, entry in board.items() if self._keys[name].source == "robot"}
        waits = not chart.unstarted and chart.outcome is None
        self._missing = {
            name: stale_at(self._keys[name], entry) - entry.at
            for name, entry in known.items()
            if waits and now < stale_at(self._keys[name], entry) < math.inf
        }
        self._known, self._start, self._patience_s = known.keys(), now, chart.mission.ready_s
        self.received: dict[str, tuple[object, float]] = {}
        """Key → its first value and stamp."""
        self.rest: list[Event] = []
        """Whatever else has happened meanwhile, in the order of its arrival."""

    @property
    def missing(self) -> tuple[str, ...]:
        """The keys that it waits for."""
        return tuple(self._missing)

    @property
    def until(self) -> float:
        """When it has waited long enough: a key that need not be there is missed for as long as it would last."""
        if any(not self._keys[name].optional for name in self._missing):
            return self._start + self._patience_s
        return self._start + min(self._patience_s, max(self._missing.values(), default=-math.inf))

    def take(self, event: Event) -> None:
        """Something has come."""
        value, is_first = event.data.get("value"), event.name in self._known and event.name not in self.received
        if event.kind != "write" or not is_first or type_error(self._keys[event.name], value):
            self.rest.append(event)
            return
        self.received[event.name] = (value, min(float(event.data.get("stamp", event.at)), event.at))
        self._missing.pop(event.name, None)

    def event(self, present: float) -> Event:
        """The step with which the run continues, at the instant from which it does: what waits happens after it.

        Args:
            present: Now: nothing that the run asks for while it catches up is carried out before.
        """
        received = {name: list(each) for name, each in self.received.items()}
        return Event("take_up", self._start, {"heard": received, "present": present}, "command")
