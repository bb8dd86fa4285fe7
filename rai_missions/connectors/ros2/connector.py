# SPDX-License-Identifier: Apache-2.0
"""The connector to ROS 2: types by name, plain data, and what really became of every call and goal.

Rule: what a caller has wrong is reported on the caller's thread, at once; everything else is reported by the callbacks.
"""

from __future__ import annotations

import atexit
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from rclpy.action import get_action_names_and_types
from rclpy.node import Node

from rai_missions.connectors.answers import check_action_server, check_answer
from rai_missions.connectors.connector import (
    TYPE_KINDS,
    ActionServer,
    Answer,
    Close,
    ConnectorMode,
    Data,
    Hindrance,
    OnMessage,
    OnReply,
    OnReport,
    RawMessage,
    Reply,
    Report,
)
from rai_missions.connectors.ros2.config import read_options
from rai_missions.connectors.ros2.endpoints import full_action
from rai_missions.connectors.ros2.inspection import hindrances
from rai_missions.connectors.ros2.messages import is_picture, to_message, to_message_later
from rai_missions.connectors.ros2.msg_definitions import definition_of
from rai_missions.connectors.ros2.names import check_name, find_type
from rai_missions.connectors.ros2.session import Session
from rai_missions.errors import ConnectorError, UsageError

__all__ = ("Ros2Connector",)

HIDDEN = "/_"
"""Is in the names that ROS keeps for itself, such as the topics and services that an action is made of."""
OF_ROS = ("use_sim_time", "start_type_description_service")
"""Parameters that each node of ROS has."""
OF_QUALITY = "qos_overrides."


class Ros2Connector:
    """Topics, services and actions of the ROS 2 graph; a `Connector`.

    Callbacks run one after the other on the connector's own thread and must return at once. It has a context of its
    own, and lives next to whatever else the process does with rclpy.

    Args:
        options: What a profile's `connector` states besides its `kind`.
        now: Seconds on the run's clock; left out, ROS time.

    Raises:
        UsageError: An option is not understood.
    """

    modes: frozenset[ConnectorMode] = frozenset({"topics", "services", "actions"})

    def __init__(self, options: Mapping[str, Any] | None = None, *, now: Callable[[], float] | None = None) -> None:
        self._options, self._now = read_options(options or {}), now
        self._lock = threading.Lock()
        self._session: Session | None = None
        self._types: dict[tuple[ConnectorMode, str], str] = {}

    @property
    def running(self) -> bool:
        """Whether the connector was started, not stopped since, and ROS has not been shut down by others."""
        session = self._session
        return session is not None and session.runtime.is_open

    def start(self) -> None:
        """Open the node.

        Raises:
            UsageError: A name or an argument that ROS does not take.
        """
        with self._lock:
            if self._session is None or not self._session.runtime.is_open:
                self._types.clear()
                self._session = Session(self._options, self._now)
                # A thread that still spins when the interpreter ends would abort the whole process.
                atexit.register(self.stop)

    def stop(self) -> None:
        with self._lock:
            session, self._session = self._session, None
        atexit.unregister(self.stop)
        if session is not None:
            session.close()

    def listed(self, mode: ConnectorMode) -> Mapping[str, str]:
        """What the graph has at this moment, hidden names left out.

        Types that contradict each other are side by side. Anyone who has just started, here or elsewhere, is not known
        yet: ask again a second later.

        Raises:
            ConnectorError: The connector's thread does not answer, since a callback does not return.
        """
        session = self._session
        return {} if session is None else session.runtime.ask(lambda: _listed(session.runtime.node, mode), {})

    def offered(self, mode: ConnectorMode) -> Mapping[str, int]:
        """Name → how many publish on the topic, or serve the service or action, this connector's own included.

        Raises:
            ConnectorError: As `listed`.
        """
        session = self._session
        return {} if session is None else session.runtime.ask(lambda: _offered(session.runtime.node, mode), {})

    def resolved(self, mode: ConnectorMode, name: str) -> str:
        """The name in full: in the node's namespace and remapped by `--ros-args`.

        Raises:
            ConnectorError: As `listed`.
        """
        session = self._session
        return (
            name if session is None else session.runtime.ask(lambda: _resolved(session.runtime.node, mode, name), name)
        )

    def hindrances(self, wanted: Iterable[tuple[ConnectorMode, str, bool]]) -> Sequence[Hindrance]:
        session, asked = self._session, tuple(wanted)
        nothing: tuple[Hindrance, ...] = ()
        if session is None:
            return nothing
        look = partial(hindrances, session.runtime.node, self._options, asked)
        return session.runtime.ask(lambda: tuple(dict.fromkeys(look())), nothing)

    def parameters(self) -> Mapping[str, Any]:
        """The node's parameters that `--ros-args` gave, without those of ROS itself and of the profile.

        Raises:
            ConnectorError: As `listed`.
        """
        session = self._session
        if session is None:
            return {}
        nothing: Mapping[str, Any] = {}
        found = session.runtime.ask(lambda: _parameters(session.runtime.node), nothing)
        return {name: value for name, value in found.items() if name not in self._options.parameters}

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage) -> Close:
        return self._opened().subscribe(topic, self._type("topics", topic, type_name), on_message)

    def definition(self, type_name: str) -> str:
        """How a message's bytes are read: .msg text with all that it depends on."""
        return definition_of(type_name)

    def tap(self, topic: str, type_name: str, on_message: OnMessage, on_raw: Callable[[RawMessage], None]) -> Close:
        """Subscribe once, and receive each message as CDR and as plain data."""
        cls = self._type("topics", topic, type_name)
        return self._opened().subscribe(topic, cls, on_message, on_raw)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        session = self._session
        if session is not None:
            cls = self._type("topics", topic, type_name)
            if is_picture(message):
                session.publish_later(topic, cls, to_message_later(cls, message, topic))
            else:
                session.publish(topic, cls, to_message(cls, message, topic))

    def expect(self, mode: ConnectorMode, name: str, type_name: str) -> None:
        """Have a service's or an action's client made and found by its server before it is used, or a publisher.

        A reply to a client that its server has only just met is dropped by the middleware, without a word.
        """
        session = self._session
        if session is not None:
            session.expect(mode, name, self._type(mode, name, type_name))

    def call(
        self, service: str, type_name: str, request: Data, *, on_reply: OnReply, timeout_s: float | None = None
    ) -> None:
        def begin(session: Session) -> None:
            cls = self._type("services", service, type_name)
            session.call(service, cls, to_message(cls.Request, request, service), on_reply, timeout_s)

        why, is_open = self._attempt(service, begin)
        if why:
            on_reply(Reply("failed" if is_open else "unavailable", {}, why))

    def send_goal(self, action: str, type_name: str, goal: Data, *, goal_id: str, on_report: OnReport) -> None:
        def begin(session: Session) -> None:
            cls = self._type("actions", action, type_name)
            session.send_goal(action, cls, to_message(cls.Goal, goal, action), goal_id, on_report)

        why, _ = self._attempt(action, begin)
        if why:
            on_report(Report(goal_id, "rejected", {}, why))

    def find_goal(self, action: str, type_name: str, *, goal_id: str, on_report: OnReport) -> None:
        why, _ = self._attempt(
            action,
            lambda session: session.find_goal(action, self._type("actions", action, type_name), goal_id, on_report),
        )
        if why:
            on_report(Report(goal_id, "lost", {}, why))

    def _attempt(self, name: str, begin: Callable[[Session], None]) -> tuple[str, bool]:
        """Begin something with a server; why that cannot be, and whether the connector is open."""
        session = self._session
        if session is None:
            return f"no server offers {name}: the connector is not started", False
        try:
            begin(session)
        except ConnectorError as fault:
            return str(fault), True
        return "", True

    def survey(self, action: str, type_name: str, *, within_s: float, on_result: Callable[[str], None]) -> None:
        """Find out whether more than one server answers for an action, each by a reply to a request of no effect."""
        session = self._session
        try:
            cls = self._type("actions", action, type_name) if session is not None else None
        except ConnectorError:  # its first use raises it
            cls = None
        if session is None or cls is None:
            on_result("")
        else:
            session.survey(action, cls, within_s, on_result)

    def cancel_goal(self, goal_id: str) -> None:
        session = self._session
        if session is not None:
            session.cancel_goal(goal_id)

    def serve(self, service: str, type_name: str, answer: Answer) -> Close:
        """Serve a service.

        ROS has no word for a server that fails: where a response has `success` and `message` (std_srvs), these state
        why; other clients are left to their timeout.
        """
        check_answer(answer, service)
        return self._opened().serve(service, self._type("services", service, type_name), answer)

    def offer(self, action: str, type_name: str, server: ActionServer) -> Close:
        """Serve an action.

        ROS has no word for why a goal is rejected, and none for a cancel that is refused after it was taken.
        """
        check_action_server(server, action)
        return self._opened().offer(action, self._type("actions", action, type_name), server)

    def _opened(self) -> Session:
        session = self._session
        if session is None:
            raise UsageError("the ROS 2 connector is not started: call start() first")
        return session

    def _type(self, mode: ConnectorMode, name: str, type_name: str) -> Any:
        kind, known = TYPE_KINDS[mode], self._types.get((mode, name), "")
        check_name(name, kind)
        if known and type_name and known != type_name:
            raise ConnectorError(f"{name} is a {known}, not a {type_name}")
        found = find_type(type_name or known, kind)
        self._types[mode, name] = type_name or known
        return found


def _listed(node: Node, mode: ConnectorMode) -> Mapping[str, str]:
    """Names and types of a mode, hidden ones left out. On the node's thread only."""
    find = {
        "topics": node.get_topic_names_and_types,
        "services": node.get_service_names_and_types,
        "actions": lambda: get_action_names_and_types(node),
    }
    return {name: ", ".join(sorted(types)) for name, types in sorted(find[mode]()) if HIDDEN not in name}


def _offered(node: Node, mode: ConnectorMode) -> Mapping[str, int]:
    """How many publish on each topic, or serve each service or action; who only asks is not counted."""
    counts = {
        "topics": node.count_publishers,
        "services": node.count_services,
        "actions": lambda name: node.count_services(f"{name}/_action/send_goal"),
    }
    counted = {name: counts[mode](name) for name in _listed(node, mode)}
    return {name: number for name, number in counted.items() if number}


def _resolved(node: Node, mode: ConnectorMode, name: str) -> str:
    """The full name of a profile's name. On the node's thread only."""
    try:
        if mode == "actions":
            return full_action(node, name)
        return str(node.resolve_topic_name(name) if mode == "topics" else node.resolve_service_name(name))
    except (ValueError, RuntimeError):  # it is no name; its first use states why
        return name


def _parameters(node: Node) -> Mapping[str, Any]:
    """The values of a node's parameters but for those that ROS itself declares. On the node's thread only."""
    found = node.get_parameters_by_prefix("")
    return {name: each.value for name, each in found.items() if name not in OF_ROS and not name.startswith(OF_QUALITY)}
