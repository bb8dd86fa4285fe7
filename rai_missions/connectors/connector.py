# SPDX-License-Identifier: Apache-2.0
"""The door to the robot: publish-subscribe, services and actions, the three modes of the RAI paper.

Rule: nothing here waits. What comes back is passed to a callback, which may run on any thread and must return at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

__all__ = (
    "ENDS",
    "TYPE_KINDS",
    "ActionServer",
    "Answer",
    "Close",
    "Connector",
    "ConnectorMode",
    "Hindrance",
    "HostsActions",
    "ListsItself",
    "Message",
    "Mode",
    "OnMessage",
    "OnReply",
    "OnReport",
    "RawMessage",
    "Reply",
    "Report",
    "ResolvesNames",
    "SupportsAdoption",
    "SupportsDiscoveryCount",
    "SupportsInspection",
    "SupportsParameters",
    "SupportsPreconnect",
    "SupportsRawMessages",
    "Surveyor",
    "TypeKind",
)

ConnectorMode = Literal["topics", "services", "actions"]
Mode = ConnectorMode
"""`ConnectorMode` by its earlier name, for connectors that import it."""
TypeKind = Literal["msg", "srv", "action"]
TYPE_KINDS: Mapping[ConnectorMode, TypeKind] = {"topics": "msg", "services": "srv", "actions": "action"}
"""What the types of each mode are called, in ROS and in profiles."""
Data = Mapping[str, Any]
"""A message as plain data: numbers, strings, lists, mappings, bytes, `Image`."""
Answer = Callable[[Data], Data | Future[Data]]
"""Answers a request, at once or by a future; it may be set on any thread."""
Close = Callable[[], None]
"""Ends what was opened; calling it twice does nothing the second time."""


class Message(NamedTuple):
    """One message received on a topic."""

    topic: str
    data: Data
    at: float
    """When it was so, in seconds on the run's clock: its own stamp where it has one, negative before the run began, and
    never after its receipt."""
    age_s: float | None = None
    """Receipt minus its own stamp, on its sender's clock; negative for a stamp in the future, None without a stamp."""
    kept: bool = False
    """It was published before this connector listened, and kept for later readers (latched, retained)."""


class RawMessage(NamedTuple):
    """One message as it came over the wire."""

    topic: str
    type: str
    """Its type's full name, `std_msgs/msg/String`."""
    data: bytes
    at: float
    """As a `Message`'s."""
    quality: str = ""
    """What its topic's publishers offered when the first message was received, as the wire's own recorders write it."""


class Reply(NamedTuple):
    """How a call of a service ended."""

    outcome: Literal["succeeded", "failed", "timed_out", "unavailable"]
    data: Data
    why: str = ""
    age_s: float | None = None
    """As a `Message`'s."""
    may_have_arrived: bool = False
    """Of one that is unavailable: the request was sent and its server is gone, so what it asks for may be under way."""


class Report(NamedTuple):
    """What an action's server reports about one goal.

    `failed` is an action's `aborted`; `lost` means that the server is gone or knows nothing of the goal. These two,
    `rejected`, `succeeded` and `canceled` are ends: one of them is reported, and no other report follows but two.
    `stray`: the goal is executing at some server although its end was reported; it is canceled there. `over`: a goal
    that was lost or stray is executing nowhere any more. `overdue`: a goal that was canceled does not end, and is not
    waited for any longer. `cancel_rejected` means that the server does not cancel the goal, `contested` that a second
    server of the action was seen while the goal was under way.
    """

    goal_id: str
    status: Literal[
        "accepted",
        "rejected",
        "feedback",
        "succeeded",
        "failed",
        "canceled",
        "cancel_rejected",
        "lost",
        "contested",
        "stray",
        "over",
        "overdue",
    ]
    data: Data
    why: str = ""
    may_run: bool = True
    """Of a lost goal: whether it may be executing; it may not where its server is there and knows nothing of it."""


ENDS = ("rejected", "succeeded", "failed", "canceled", "lost")
"""The statuses of a report that end a goal."""
OnMessage = Callable[[Message], None]
OnReply = Callable[[Reply], None]
OnReport = Callable[[Report], None]


class ActionServer(Protocol):
    """The side that serves an action. All calls come one after the other."""

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        """A goal has come: report `accepted` or `rejected`, then feedback, then one end."""

    def cancel(self, goal_id: str) -> None:
        """The client wants the goal to end: report `canceled` once it has, or `cancel_rejected`."""


@runtime_checkable
class SupportsRawMessages(Protocol):
    """A connector whose messages can be had as they came over the wire too, for anyone who records them."""

    def definition(self, type_name: str) -> str:
        """How the bytes of a type are read, as the wire's own language reports it; raises `ConnectorError`."""

    def tap(self, topic: str, type_name: str, on_message: OnMessage, on_raw: Callable[[RawMessage], None]) -> Close:
        """Subscribe; each message comes raw first, then as plain data."""


@runtime_checkable
class SupportsPreconnect(Protocol):
    """A connector that has to find the other side before they can speak, and would rather do that in good time."""

    def expect(self, mode: ConnectorMode, name: str, type_name: str) -> None:
        """A service or an action will be used, or a topic published on; others see the topic from now on.

        Raises:
            ConnectorError: It cannot be, as its first use would state.
        """


@runtime_checkable
class SupportsDiscoveryCount(Protocol):
    """A connector that counts the peers that publish or serve; `listed` has those that only wait, too."""

    def offered(self, mode: ConnectorMode) -> Mapping[str, int]:
        """Name → how many publish on the topic, or serve the service or action."""


class Hindrance(NamedTuple):
    """What is wrong with what is there under a name."""

    name: str
    what: str
    """After the name, it makes a sentence: `has 2 servers: /a and /b`."""
    remedy: str
    is_fatal: bool = True
    """Otherwise it works, with less than is expected."""


@runtime_checkable
class SupportsInspection(Protocol):
    """A connector that knows what hinders a mission to use what is there."""

    def hindrances(self, wanted: Iterable[tuple[ConnectorMode, str, bool]]) -> Sequence[Hindrance]:
        """Look, and send nothing.

        Args:
            wanted: Mode, name, and whether the mission publishes there.
        """


@runtime_checkable
class ListsItself(Protocol):
    """A connector whose middleware keeps to itself what others offer: `listed` has what it does itself."""

    lists_itself: bool


@runtime_checkable
class SupportsAdoption(Protocol):
    """A connector on which a server can be offered that pursues a goal already, as in the branch of a world."""

    def adopt_goal(self, action: str, goal_id: str) -> OnReport:
        """Take note of a goal that its server has accepted; `find_goal` finds it.

        Returns:
            What the server reports to from now on.
        """


@runtime_checkable
class ResolvesNames(Protocol):
    """A connector that may have a profile's name under another one: in a namespace, or remapped."""

    def resolved(self, mode: ConnectorMode, name: str) -> str:
        """The name in full, as `listed` has it; as it was given if it is none or the connector is not started."""


@runtime_checkable
class SupportsParameters(Protocol):
    """A connector whose node can be given parameters by who starts the process."""

    def parameters(self) -> Mapping[str, Any]:
        """Name → value of what was given from outside; without the middleware's own, and those of the profile."""


@runtime_checkable
class HostsActions(Protocol):
    """A connector whose actions are executed by this process: a goal that another process sent executes no more."""

    def conclude(self, on_end: Callable[[], None]) -> None:
        """The mission is over: wait for what is executed still, for a bounded time on the wall.

        What has not ended by then is reported `overdue`. `on_end` is called once, from any thread, after the last
        report.
        """


@runtime_checkable
class Surveyor(Protocol):
    """A connector on whose names two servers may be, and that finds out whether both live."""

    def survey(self, action: str, type_name: str, *, within_s: float, on_result: Callable[[str], None]) -> None:
        """Find out whether more than one server answers for an action.

        Args:
            action: Its name.
            type_name: Its type.
            within_s: How long a second server may take to go.
            on_result: Receives a sentence that names the servers, once and from any thread; empty where at most one
                answers.
        """


@runtime_checkable
class Connector(Protocol):
    """A way to reach a robot. `rai_missions.testing.check_connector` holds the contract."""

    modes: frozenset[ConnectorMode]

    @property
    def running(self) -> bool:
        """Whether the connector was started, and not stopped since."""

    def start(self) -> None:
        """Open; a connector that was stopped can be started again."""

    def stop(self) -> None:
        """Close everything; afterwards no callback runs. Goals that still run are canceled first."""

    def listed(self, mode: ConnectorMode) -> Mapping[str, str]:
        """What is there now, by name: each with the name of its type, empty where no one reports it.

        What someone listens to counts as a topic too. A connector that does not run lists nothing.
        """

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close: ...

    def publish(self, topic: str, type_name: str, message: Data) -> None: ...

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        """Call a service; `on_reply` is called exactly once."""

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        """Ask an action's server to pursue a goal under the id given."""

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        """Ask for a goal that an earlier process sent, and be notified of it from now on.

        Reports `accepted` if it runs, its end if it has ended, and `lost` if its server knows nothing of it or no one
        serves the action.
        """

    def cancel_goal(self, goal_id: str) -> None:
        """Ask for a goal's end; before its acceptance too. An unknown or ended goal: nothing happens."""

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        """Serve a service; an exception of `answer`, or of the future that it gives, is a `failed` reply."""

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        """Serve an action."""
