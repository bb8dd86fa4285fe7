# SPDX-License-Identifier: Apache-2.0
"""What acts: publishing, calling services, and actions from their start to their confirmed end.

Rule: the words state what became of it, and never more than the robot confirmed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from rai_missions.connectors.connector import Data, Reply
from rai_missions.errors import UsageError
from rai_missions.redaction import cut, cut_repr
from rai_missions.tools.access import AllowedConnector, until
from rai_missions.tools.arguments import Name, Timeout, TypeName
from rai_missions.tools.goals import GoalState, ToolGoals
from rai_missions.tools.result import ToolResult

__all__ = ("ActuatorTools", "result_of")

LONGEST_MESSAGE = 100_000
"""Characters of a message, request or goal, as JSON."""
REPLIES: Mapping[str, str] = {
    "succeeded": "answered",
    "failed": "FAILED",
    "timed_out": "did NOT ANSWER in time, and whether it did what was asked is unknown",
    "unavailable": "is NOT THERE, and nothing was done",
}
NOTHING: Data = {}
GoalId = Annotated[Name, Field(description="The id that the start gave.")]
VANISHED = "is GONE since the request was sent, and whether it did what was asked is unknown"


class ActuatorTools:
    """The tools that act.

    Args:
        reach: The way to the robot.
        goals: The goals that were started.
    """

    def __init__(self, reach: AllowedConnector, goals: ToolGoals) -> None:
        self._reach, self._goals = reach, goals

    def publish_message(
        self,
        topic: Annotated[Name, Field(description="The topic's whole name.")],
        message: Annotated[
            Data, Field(description="The message's fields by name; what is left out keeps its default.")
        ],
        *,
        type_name: TypeName = "",
        timeout_s: Timeout = 2.0,
    ) -> ToolResult:
        """Publish one message on a topic."""
        fields = _checked("message", message)
        found = self._reach.type_of("topics", topic, type_name, until(timeout_s), "write")
        self._reach.publish(topic, found, fields)
        words = f"The message was published on {topic}; whether anybody received it is unknown."
        return ToolResult(words, {"topic": topic, "type": found, "message": fields})

    def call_service(
        self,
        service: Annotated[Name, Field(description="The service's whole name, such as '/tractor1/flash'.")],
        request: Annotated[Data, Field(description="The request's fields by name.")] = NOTHING,
        *,
        timeout_s: Timeout = 5.0,
        type_name: TypeName = "",
    ) -> ToolResult:
        """Call a service and wait for its reply."""
        fields = _checked("request", request)
        ends = until(timeout_s)
        found = self._reach.type_of("services", service, type_name, ends, "write")
        reply = self._reach.call(service, found, fields, timeout_s)
        done = reply.outcome == "succeeded" and reply.data.get("success") is not False
        words = f"The service {service} {self._ended(reply)}."
        facts = {word: item for word, item in (("reply", reply.data), ("why", reply.why)) if item}
        data = {"service": service, "outcome": reply.outcome, "done": done, "reply": reply.data, "why": reply.why}
        return ToolResult(words, data, facts or None)

    def _ended(self, reply: Reply) -> str:
        if reply.outcome == "succeeded" and reply.data.get("success") is False:
            return "answered that it did NOT do it (success: false)"
        return VANISHED if reply.may_have_arrived else REPLIES[reply.outcome]

    def start_action(
        self,
        action: Annotated[Name, Field(description="The action's whole name, such as '/navigate_to_pose'.")],
        goal: Annotated[Data, Field(description="The goal's fields by name.")] = NOTHING,
        *,
        timeout_s: Timeout = 5.0,
        type_name: TypeName = "",
    ) -> ToolResult:
        """Start an action.

        Reports whether its server took the goal, and the goal's id for watch_action and cancel_action; it does not
        wait for the end, and an accepted goal has not succeeded.
        """
        fields = _checked("goal", goal)
        ends = until(timeout_s)
        found = self._reach.type_of("actions", action, type_name, ends, "write")
        return result_of(self._goals.start(action, found, fields, ends))

    def watch_action(
        self,
        goal_id: GoalId,
        *,
        timeout_s: Annotated[Timeout, Field(description="How long to wait for its end, in seconds; 0 to 60.")] = 0.0,
    ) -> ToolResult:
        """How a goal is that start_action or navigate_to_pose started.

        It is running, succeeded, aborted, canceled, rejected or lost, with its feedback and result. Waits for its end
        as long as it may.
        """
        return result_of(self._goals.watch(goal_id, until(timeout_s)))

    def list_goals(
        self, only_running: Annotated[bool, Field(description="Only those that are not over.")] = False
    ) -> ToolResult:
        """The goals that were started here, with their states."""
        every = self._goals.all()
        listed = [status for status in every if not (only_running and status.is_over)]
        facts = {status.goal_id: f"{status.action}: {status.state}" for status in reversed(listed)}
        running = sum(not status.is_over for status in every)
        words = f"{len(every)} goals were started here, of which {running} are not over; newest first:"
        return ToolResult(words, {"goals": [status.data() for status in listed], "running": running}, facts)

    def cancel_action(self, goal_id: GoalId, *, timeout_s: Timeout = 5.0) -> ToolResult:
        """Ask for the end of a goal, and state how it ended or that it has not."""
        return result_of(self._goals.cancel(goal_id, until(timeout_s)))


def result_of(status: GoalState) -> ToolResult:
    """How a goal is, in words and data."""
    parts = (("result", status.result), ("newest feedback", status.feedback), ("why", status.why))
    facts = {word: item for word, item in parts if item}
    words = status.words()
    return ToolResult(f"{words[0].upper()}{words[1:]}.", status.data(), facts or None)


def _checked(what: str, given: Any) -> dict[str, Any]:
    """What a message, request or goal is made of; a model may send anything."""
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise UsageError(f"{what}: {cut_repr(given, 60)} is given where an object with fields belongs")
    try:
        length = len(json.dumps(given, default=lambda item: "x" * len(item) if isinstance(item, bytes) else str(item)))
    except (TypeError, ValueError, RecursionError) as fault:
        raise UsageError(f"{what}: it is no plain data: {cut(fault, 80)}") from None
    if length > LONGEST_MESSAGE:
        raise UsageError(f"{what}: {length} characters; {LONGEST_MESSAGE} are the most")
    return dict(given)
