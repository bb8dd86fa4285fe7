# SPDX-License-Identifier: Apache-2.0
"""More than one server on one action's name: how many answer, and which of our goals any of them is executing.

Rule: rclpy's client takes the first answer to a request and drops the others. All are looked at here, before it does.
"""

from __future__ import annotations

import uuid
from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from rai_missions.connectors.ros2.node_thread import guarded

__all__ = ("ObservedClient", "Sightings", "statuses_in")

ACTIVE = frozenset({GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING})
KEPT = 1000
"""Requests whose answers are counted."""
OnStatus = Callable[[bytes, int, int], None]
OnSecond = Callable[[bytes], None]


class Sightings:
    """What the status messages of all servers report about one goal.

    They carry no sender, but the instant of the acceptance: two servers give two.
    """

    def __init__(self) -> None:
        self._statuses: dict[int, int] = {}

    def follow(self, stamp: int, status: int) -> None:
        """A status message has the goal.

        Args:
            stamp: When it was accepted, in nanoseconds on its server's clock.
            status: One of `GoalStatus`.
        """
        self._statuses[stamp] = status

    def __bool__(self) -> bool:
        """A status message has had the goal."""
        return bool(self._statuses)

    @property
    def is_active(self) -> bool:
        """Some server is executing it, as far as is known."""
        return any(status in ACTIVE for status in self._statuses.values())

    @property
    def ends(self) -> frozenset[int]:
        """The statuses in which it has ended at any server."""
        return frozenset(self._statuses.values()) - ACTIVE


class ObservedClient(ActionClient):  # type: ignore[misc]
    """rclpy's action client, all of whose answers are counted. On the runtime's thread only.

    Args:
        node: Its node.
        cls: The action's class.
        action: Its name.
        on_status: Notified of each goal in a status message: id, stamp of its acceptance, status.
        on_second: Notified of a goal whose request a second server has answered.
        servers: How many servers are on the graph.
        qualities: As rclpy's client takes them.
    """

    def __init__(
        self,
        node: Any,
        cls: Any,
        action: str,
        *,
        on_status: OnStatus,
        on_second: OnSecond,
        servers: Callable[[], int],
        **qualities: Any,
    ) -> None:
        self._on_status, self._on_second, self._servers = on_status, on_second, servers
        self._result_answers: OrderedDict[int, int] = OrderedDict()
        self._goal_answers: OrderedDict[int, bytes] = OrderedDict()
        self._cancel_answers: OrderedDict[int, int] = OrderedDict()
        super().__init__(node, cls, action, **qualities)

    async def execute(self, taken_data: dict[str, Any]) -> None:
        guarded(lambda: self._observe(taken_data))
        if "result" in taken_data and self._is_premature(*taken_data["result"]):
            del taken_data["result"]
        await super().execute(taken_data)

    def _is_premature(self, number: int, response: Any) -> bool:
        """A server that knows nothing of a goal has answered, and another one may have its result."""
        count = self._result_answers.get(number, 0) + 1
        _keep(self._result_answers, number, count)
        return bool(response.status == GoalStatus.STATUS_UNKNOWN) and count < self._servers()

    def probe(self) -> Callable[[], int]:
        """Ask for the end of a goal that no server has; returns what counts the servers that have answered so far."""
        none = ClientGoalHandle(self, UUID(uuid=list(uuid.uuid4().bytes)), None)
        future = none.cancel_goal_async()
        number = next(number for number, each in self._pending_cancel_requests.items() if each is future)
        return lambda: self._cancel_answers.get(number, 0)

    def _observe(self, taken: dict[str, Any]) -> None:
        if "goal" in taken:
            number = taken["goal"][0]
            if number in self._goal_answers:
                self._on_second(self._goal_answers[number])
            elif number in self._goal_sequence_number_to_goal_id:
                goal_id = self._goal_sequence_number_to_goal_id[number]
                _keep(self._goal_answers, number, bytes(goal_id.uuid))
        if "cancel" in taken:
            number = taken["cancel"][0]
            _keep(self._cancel_answers, number, self._cancel_answers.get(number, 0) + 1)
        if "status" in taken:
            for sighting in statuses_in(taken["status"]):
                self._on_status(*sighting)


def statuses_in(message: Any) -> Iterator[tuple[bytes, int, int]]:
    """The goals in an `action_msgs/msg/GoalStatusArray`: id, stamp of acceptance in ns, status."""
    for each in message.status_list:
        stamp = each.goal_info.stamp
        yield bytes(each.goal_info.goal_id.uuid), stamp.sec * 10**9 + stamp.nanosec, each.status


def _keep(kept: OrderedDict[int, Any], number: int, value: Any) -> None:
    kept[number] = value
    while len(kept) > KEPT:
        kept.popitem(last=False)
