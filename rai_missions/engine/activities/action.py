# SPDX-License-Identifier: Apache-2.0
"""The machine of an action: wait for the resources, send, be accepted, end, and let the facts settle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.engine.activities.activity import (
    GOALS,
    NO_KEYS,
    ActivityHost,
    Bench,
    Machine,
    Outcome,
    Turn,
    machine_of,
    remembered,
    result_writes,
)
from rai_missions.engine.step import CancelGoal, StartGoal
from rai_missions.engine.templates import SentTemplate
from rai_missions.event import Event
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Instant, Site, Test, View
from rai_missions.states.action import GoalFields

__all__ = ("GOAL_ENDS", "GoalActivity", "GoalMachine")

ITS_TURN = frozenset({GOALS})
"""What a goal waits for that another one obstructs."""
GOAL_ENDS = ("succeeded", "failed", "canceled", "rejected")
"""How a server reports that a goal has ended; any other word is a failure."""


@remembered("Pursuit")
class GoalActivity(NamedTuple):
    """How far a goal has come."""

    phase: Literal["waiting", "sent", "running", "settling", "stopped", "done", "again"]
    """`waiting` for resources, `sent`, `running` once accepted, `settling` once its server reported `succeeded`.

    In a pause `stopped`: its end is asked for; `done`: it has succeeded all the same. After it `again`: `waiting`, for
    that end too.
    """
    number: int = 0
    until: float = math.inf
    """When settling is over."""
    result: Mapping[str, Any] = {}


WAITING = GoalActivity("waiting")


class GoalMachine(Machine):
    """Pursues one action's goal.

    Args:
        definition: The state or leaf.
        owner: Its name.
        site: Where its guards are compiled.
        succeeded: The profile's guard for an action that is composed of services; None for one with a server.
        failed: The same for its failure.
    """

    def __init__(
        self,
        definition: GoalFields,
        owner: str,
        site: Site,
        *,
        succeeded: Guard | None = None,
        failed: Guard | None = None,
    ) -> None:
        self.definition = definition
        self.owner, self.site = owner, site
        self.achieved: Test | None = definition.achieved.compiled(site) if definition.achieved is not None else None
        self.settling_reads, self.settling_instants = site.watched, tuple(site.instants)
        self.goal = SentTemplate("goal", definition.goal, site)
        composed = Site(site.place, site.keys, site.state)
        self.succeeded = succeeded.compiled(composed, True) if succeeded is not None else None
        self.failed = failed.compiled(composed, True) if failed is not None else None
        self.composed_reads, self.composed_instants = composed.watched, tuple(composed.instants)

    def begin(self, host: ActivityHost) -> Turn:
        return self._start(host) or Turn(WAITING)

    def _start(self, host: ActivityHost) -> Turn | None:
        obstruction = host.obstruction(self.definition.action)
        if obstruction == "busy":
            return None
        if obstruction == "orphan" and not self.definition.over_orphan:
            why = "an earlier goal on the same resources never confirmed its end"
            return Turn(None, outcome=Outcome("rejected", why=why))
        goal, lack = self.goal.fill(host.view)
        if lack:
            return Turn(None, outcome=Outcome("rejected", why=lack))
        number = host.open_goal(self.owner, self.definition.action, self.definition.cancel_s)
        return Turn(GoalActivity("sent", number), (StartGoal(number, self.owner, self.definition.action, goal),))

    def receive(self, state: GoalActivity, event: Event, host: ActivityHost) -> Turn | None:
        if event.kind == "tick":
            return self._look(state, host)
        if event.number != state.number or not state.number or state.phase in ("settling", "done"):
            return None
        if state.phase in ("stopped", "again"):
            return self._succeed_late(state, event, host)
        if event.kind == "accepted":
            return self._look(state._replace(phase="running"), host) or Turn(state._replace(phase="running"))
        if event.kind != "result":
            return None
        if event.name == "succeeded":
            return self._settle(state._replace(result=dict(event.data)), host)
        if event.name not in GOAL_ENDS:
            why = str(event.data.get("why", "")) or f"its server said '{event.name}'"
            return Turn(None, outcome=Outcome("failed", dict(event.data), why))
        return Turn(None, outcome=Outcome(event.name, dict(event.data), str(event.data.get("why", ""))))

    def _succeed_late(self, state: GoalActivity, event: Event, host: ActivityHost) -> Turn | None:
        """A goal whose end was asked for has succeeded, so it is not done once more; nothing waits for another end."""
        if event.kind != "result" or event.name != "succeeded":
            return None
        done = state._replace(phase="done", result=dict(event.data))
        return Turn(done) if state.phase == "stopped" else self._settle(done, host)

    def _look(self, state: GoalActivity, host: ActivityHost) -> Turn | None:
        """Time has passed or a key has changed."""
        if state.phase in ("waiting", "again"):
            return self._start(host)
        if state.phase == "settling":
            return self._settled(state, host)
        if state.phase == "running" and self.succeeded is not None and self.succeeded(host.view) is True:
            host.close_goal(state.number)
            return self._settle(state, host)
        if state.phase == "running" and self.failed is not None and self.failed(host.view) is True:
            cancel = CancelGoal(state.number, self.definition.action)
            return Turn(None, (cancel,), Outcome("failed", why="the profile's guard for its failure is true"))
        return None

    def _settle(self, state: GoalActivity, host: ActivityHost) -> Turn:
        until = host.begins_at + self.definition.settle_s
        settling = state._replace(phase="settling", until=until)
        return self._settled(settling, host) or Turn(settling)

    def _settled(self, state: GoalActivity, host: ActivityHost) -> Turn | None:
        if self.achieved is None or self.achieved(host.view) is True:
            writes = result_writes(self.definition.result, state.result)
            return Turn(None, outcome=Outcome("succeeded", state.result), writes=writes)
        if host.view.at < state.until:
            return None
        assert self.definition.achieved is not None
        value = self.achieved(host.view)
        truth = "false" if value is False else f"unknown ({self._unknown(host.view)})"
        why = f"the server said succeeded, but '{self.definition.achieved.words()}' is {truth}"
        return Turn(None, outcome=Outcome("unverified", state.result, why))

    def _unknown(self, view: View) -> str:
        keys = sorted(key for key in self.site.reads if key not in view.board)
        return f"never heard: {', '.join(keys)}" if keys else "stale"

    def leave(self, state: GoalActivity, host: ActivityHost) -> Turn:
        runs = state.phase in ("sent", "running")
        return Turn(None, (CancelGoal(state.number, self.definition.action),) if runs else ())

    def stop(self, state: GoalActivity, host: ActivityHost) -> Turn:
        if not state.number:
            return Turn(None)
        phase: Literal["stopped", "done"] = "done" if state.phase == "settling" else "stopped"
        return Turn(state._replace(phase=phase, until=math.inf), self.leave(state, host).effects)

    def is_stopped(self, state: GoalActivity) -> bool:
        return state.phase in ("stopped", "done")

    def begin_again(self, state: GoalActivity, host: ActivityHost) -> Turn:
        if state.phase == "done":
            return self._settle(state, host)
        turn = self.begin(host)
        return turn if turn.state != WAITING else Turn(state._replace(phase="again"))

    def wake_at(self, state: GoalActivity, view: View) -> float:
        instants: tuple[Instant, ...] = ()
        if state.phase == "settling":
            instants = self.settling_instants
        elif state.phase == "running":
            instants = self.composed_instants
        if not instants:
            return state.until
        later = [instant for instant in (each(view) for each in instants) if instant > view.at]
        return min([state.until, *later])

    def reads(self, state: GoalActivity) -> frozenset[str]:
        if state.phase in ("waiting", "again"):
            return ITS_TURN
        if state.phase == "settling":
            return self.settling_reads
        return self.composed_reads if state.phase == "running" else NO_KEYS

    def awaits(self, state: GoalActivity) -> frozenset[int]:
        return frozenset({state.number} - {0}) if state.phase in ("sent", "running", "settling") else frozenset()

    def shift(self, state: GoalActivity, by_s: float) -> GoalActivity:
        return state._replace(until=state.until + by_s)


@machine_of.register(GoalFields)
def _(definition: GoalFields, bench: Bench) -> GoalMachine:
    succeeded, failed = (each.get(definition.action) for each in (bench.robot.succeeded, bench.robot.failed))
    return GoalMachine(definition, bench.owner, bench.site("achieved"), succeeded=succeeded, failed=failed)
