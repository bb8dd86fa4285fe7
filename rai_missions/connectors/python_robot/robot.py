# SPDX-License-Identifier: Apache-2.0
"""The robot that an author writes: functions by the names that missions use.

Rule: nothing is called here. A run's connector calls the functions, each on a thread of its own.
"""

from __future__ import annotations

import inspect
import re
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

from rai_missions.errors import UsageError
from rai_missions.plain_data import is_number
from rai_missions.redaction import cut_repr, logger

__all__ = (
    "EVENTS",
    "FACTS",
    "MESSAGES",
    "ActionFunction",
    "FactFunction",
    "PythonRobot",
    "RobotPeer",
    "ServiceFunction",
    "WrittenFact",
)

log = logger(__name__)

F = TypeVar("F", bound=Callable[..., Any])
NAME = re.compile(r"[a-z][a-z0-9_]*")
EVERY_S = 1.0
FACTS, EVENTS, MESSAGES = "facts/", "events/", "messages/"
"""What the topics of facts, of events and of published messages begin with; a name follows."""


@dataclass
class FactFunction:
    """Where the values of a key come from."""

    read: Callable[[], Any] | None = None
    """Left out, `write` alone brings them."""
    every_s: float = EVERY_S
    """Seconds of the run's clock from the end of one reading to the next."""


class ServiceFunction(NamedTuple):
    """What answers a request, or takes a message."""

    answer: Callable[[Any], Any]
    repeat: bool = False


class ActionFunction(NamedTuple):
    """What pursues a goal."""

    pursue: Callable[[Any, Any], Any]
    uses: tuple[str, ...] = ()
    keep: bool = False
    repeat: bool = False


class WrittenFact(NamedTuple):
    """A value that was written, and when, as `time.monotonic` counts."""

    value: Any
    written: float


class RobotPeer(Protocol):
    """The run that a robot is in."""

    def take_fact(self, name: str, value: Any) -> None:
        """A value was written; from any thread."""

    def take_event(self, name: str, data: Mapping[str, Any]) -> None:
        """Something has happened; from any thread."""


class PythonRobot:
    """A robot made of functions; `run --robot FILE.py` takes a file that offers it as `robot`, or from `def robot()`.

    Args:
        name: What it is called.
        about: For people.
        rules: State → who answers there as `rules`, as in a robot profile: `[{"when": guard, "answer": option}, …]`.
        conversation: How it talks, as in a robot profile: `{"phrases": {"go to {place}": {"task": "go"}}, …}`.
    """

    def __init__(
        self,
        name: str,
        *,
        about: str = "",
        rules: Mapping[str, list[Mapping[str, Any]]] | None = None,
        conversation: Mapping[str, Any] | None = None,
    ) -> None:
        self.name, self.about, self.rules, self.conversation = name, about, dict(rules or {}), conversation
        self.fact_functions: dict[str, FactFunction] = {}
        self.service_functions: dict[str, ServiceFunction] = {}
        self.action_functions: dict[str, ActionFunction] = {}
        self.topic_functions: dict[str, ServiceFunction] = {}
        """What takes the messages that a mission publishes."""
        self.written: dict[str, WrittenFact] = {}
        """The newest value of each key that `write` was called for."""
        self._peer: RobotPeer | None = None
        self._lock = threading.Lock()

    def fact(self, name: str, *, every_s: float | None = None) -> Callable[[F], F]:
        """Have a function polled for a key's value; None means that there is nothing new.

        Without a function, as in `robot.fact("pose")`, it declares a key that `write` alone brings.

        Args:
            name: The key.
            every_s: Seconds from the end of one reading to the next; 1 if left out.

        Raises:
            UsageError: The name is none, or is taken.
        """
        _check_name("fact", name, self.fact_functions)
        if every_s is not None and not (is_number(every_s) and every_s > 0):
            raise UsageError(f"fact '{name}': every_s is a number of seconds above 0, not {cut_repr(every_s, 40)}")
        fact = self.fact_functions[name] = FactFunction(every_s=EVERY_S if every_s is None else float(every_s))

        def decorate(function: F) -> F:
            _check_takes(f"fact '{name}'", function)
            fact.read = function
            return function

        return decorate

    def service(self, name: str, *, repeat: bool = False) -> Callable[[F], F]:
        """Have a function answer a service: it returns the response, a dict or None; what it raises is the failure.

        Args:
            name: The service.
            repeat: Asking twice does no harm: after a crash it may be asked again.

        Raises:
            UsageError: The name is none, or is taken.
        """
        _check_name("service", name, self.service_functions)

        def decorate(function: F) -> F:
            _check_takes(f"service '{name}'", function, "request")
            self.service_functions[name] = ServiceFunction(function, repeat)
            return function

        return decorate

    def topic(self, name: str) -> Callable[[F], F]:
        """Have a function take what a mission publishes on a topic.

        Raises:
            UsageError: The name is none, or is taken.
        """
        _check_name("topic", name, self.topic_functions)

        def decorate(function: F) -> F:
            _check_takes(f"topic '{name}'", function, "message")
            self.topic_functions[name] = ServiceFunction(function)
            return function

        return decorate

    def action(
        self, name: str, *, uses: Sequence[str] = (), keep: bool = False, repeat: bool = False
    ) -> Callable[[F], F]:
        """Have a function, or an `async def`, pursue the goals of an action; it returns the result, a dict or None.

        It receives the goal and its `ActionRun`, looks at `run.canceled`, and waits in `run.sleep`.

        Args:
            name: The action.
            uses: What it occupies; two that share one conflict. None named: all.
            keep: Its goal continues while the mission is paused.
            repeat: Starting twice does no harm: after a crash it starts again.

        Raises:
            UsageError: A name is none, or is taken.
        """
        _check_name("action", name, self.action_functions)
        if isinstance(uses, str):
            raise UsageError(f"action '{name}': uses is a list of names; write uses=[{cut_repr(uses, 40)}]")
        for each in uses:
            _check_name(f"action '{name}': uses", each, ())

        def decorate(function: F) -> F:
            _check_takes(f"action '{name}'", function, "goal", "run")
            self.action_functions[name] = ActionFunction(function, tuple(uses), keep, repeat)
            return function

        return decorate

    def write(self, name: str, value: Any) -> None:
        """A key has a value now; from any thread. Before a run it is kept for its start; None is no value."""
        if value is None:
            return
        self.written[name] = WrittenFact(value, time.monotonic())
        if (peer := self._peer) is not None:
            peer.take_fact(name, value)

    def raise_event(self, name: str, data: Mapping[str, Any] | None = None) -> None:
        """Something has happened; from any thread. Before the mission's start it is dropped, which is logged.

        Args:
            name: An event that the mission declares.
            data: Its payload, plain data.

        Raises:
            UsageError: The payload is no object.
        """
        if data is not None and not isinstance(data, Mapping):
            raise UsageError(f"the payload of event '{name}' is a dict, not {cut_repr(data, 60)}")
        if (peer := self._peer) is not None:
            peer.take_event(name, dict(data or {}))
        else:
            log.warning("event '%s' was raised while the robot '%s' is in no run; it is dropped", name, self.name)

    def attach(self, peer: RobotPeer) -> None:
        """A run begins.

        Raises:
            UsageError: Another one has not ended.
        """
        with self._lock:
            if self._peer is not None and self._peer is not peer:
                sentence = f"the robot '{self.name}' is in another run; offer `def robot():`, which makes one a run"
                raise UsageError(sentence)
            self._peer = peer

    def detach(self, peer: RobotPeer) -> None:
        """The run is over."""
        with self._lock:
            if self._peer is peer:
                self._peer = None


def _check_name(what: str, name: Any, taken: Mapping[str, Any] | tuple[()]) -> None:
    if inspect.isfunction(name):
        raise UsageError(f"{what}: the decorator takes a name; write @robot.{what}({cut_repr(name.__name__, 60)})")
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise UsageError(
            f"{what}: {cut_repr(name, 60)} is no name; it begins with a letter and has letters, digits and '_' alone, "
            "in lower case"
        )
    if name in taken:
        raise UsageError(f"{what} '{name}' has a function already; name another or drop one")


def _check_takes(what: str, function: Any, *words: str) -> None:
    """Whether a function can be called with so many arguments."""
    if not callable(function):
        raise UsageError(f"{what}: {cut_repr(function, 60)} is no function")
    try:
        signature = inspect.signature(function)
    except ValueError:  # a builtin without a signature
        return
    try:
        signature.bind(*words)
    except TypeError:
        name, wanted = getattr(function, "__name__", "it"), f"({', '.join(words)})"
        remedy = f"; write def {name}{wanted}" if name.isidentifier() else ""
        raise UsageError(f"{what}: '{name}' takes {signature}, and is called with {wanted}{remedy}") from None
