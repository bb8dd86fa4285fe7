# SPDX-License-Identifier: Apache-2.0
"""The node's standard lifecycle at work: what a transition does, and how it ends.

Rule: one transition at a time. What takes longer than its request ends later, in the state on the way until then.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Data
from rai_missions.errors import MissionError, raised_text
from rai_missions.node.lifecycle_table import (
    ACTS,
    ERRORPROCESSING,
    STATES,
    TRANSITIONS,
    UNCONFIGURED,
    NodeState,
    NodeTransition,
    leaving,
    transition,
)
from rai_missions.node.names import NodeName
from rai_missions.redaction import Redaction, cut, logger

__all__ = ("EVENT_TYPE", "Finish", "ManagedLifecycle", "event_fields", "serve_lifecycle")

log = logger(__name__)

Finish = Callable[[str], None]
"""Ends a transition: with nothing, or with why it failed; only the first call counts."""
EVENT_TYPE = "lifecycle_msgs/msg/TransitionEvent"
SERVICES = "lifecycle_msgs/srv/"


class ManagedLifecycle:
    """The lifecycle of one node.

    Args:
        acts: Transition's label → what it does; also `error`, which cleans up after what went wrong unforeseen.
        moved: Receives each move, in order.
    """

    def __init__(self, acts: Mapping[str, Callable[[Finish], None]], moved: Callable[[NodeTransition], None]) -> None:
        self._acts, self._moved = acts, moved
        self._lock = threading.RLock()
        self.state: NodeState = UNCONFIGURED
        self._next = ""
        self.fault = ""
        """Why the last transition failed; empty once one has succeeded."""

    def change(self, label: str, number: int = 0) -> bool:
        """Do a transition, by its label or its number.

        Returns:
            Whether it has succeeded, or is under way; false where it does not leave this state, too.
        """
        with self._lock:
            way = transition(self.state, label, number)
            if way is None or way not in ACTS:
                return False
            self._go(way)
            ends: list[bool] = []

            def finish(why: str) -> None:
                with self._lock:
                    if not ends:
                        ends.append(not why)
                        self._end("transition_failure" if why else "transition_success", why)

            try:
                self._acts[way.label](finish)
            except MissionError as error:
                finish(f"{error}")
            except Exception as error:
                log.exception("'%s' broke off", way.label)
                ends.append(False)
                self._break(f"{way.label}: {raised_text(error)}")
            return not ends or ends[0]

    def change_next(self, label: str) -> None:
        """Do a transition, by its label; where another is under way, once that has ended."""
        with self._lock:
            if not self.change(label) and not leaving(self.state):
                self._next = label

    def _end(self, label: str, why: str) -> None:
        self.fault = Redaction().text(why)
        way = transition(self.state, label)
        if way is not None:
            self._go(way)
        if self._next and leaving(self.state):
            following, self._next = self._next, ""
            self.change(following)

    def _break(self, why: str) -> None:
        self._end("transition_error", why)
        if self.state == ERRORPROCESSING:
            try:
                self._acts["error"](lambda _why: None)
            except Exception:
                log.exception("what was begun could not be cleaned up")
                self._end("transition_failure", why)
            else:
                self._end("transition_success", why)

    def _go(self, way: NodeTransition) -> None:
        self.state = way.goal
        self._moved(way)


def serve_lifecycle(connector: Connector, name: NodeName, lifecycle: ManagedLifecycle) -> list[Close]:
    """Serve the standard services of a managed node."""

    def change(request: Data) -> Data:
        asked = request.get("transition") or {}
        return {"success": lifecycle.change(cut(asked.get("label", ""), 64), int(asked.get("id", 0)))}

    answers: Mapping[str, tuple[str, Callable[[Data], Data]]] = {
        "get_state": ("GetState", lambda _: {"current_state": _state(lifecycle.state)}),
        "change_state": ("ChangeState", change),
        "get_available_states": ("GetAvailableStates", lambda _: {"available_states": [_state(s) for s in STATES]}),
        "get_available_transitions": ("GetAvailableTransitions", lambda _: _described(leaving(lifecycle.state))),
        "get_transition_graph": ("GetAvailableTransitions", lambda _: _described(TRANSITIONS)),
    }
    return [
        connector.serve(name.below(service), f"{SERVICES}{kind}", answer) for service, (kind, answer) in answers.items()
    ]


def event_fields(way: NodeTransition) -> dict[str, Any]:
    """The fields of a `lifecycle_msgs/msg/TransitionEvent`."""
    return {"timestamp": time.time_ns(), **_description(way)}


def _state(state: NodeState) -> dict[str, Any]:
    return {"id": state.id, "label": state.label}


def _description(way: NodeTransition) -> dict[str, Any]:
    named = {"id": way.id, "label": way.label}
    return {"transition": named, "start_state": _state(way.start), "goal_state": _state(way.goal)}


def _described(ways: tuple[NodeTransition, ...]) -> Data:
    return {"available_transitions": [_description(way) for way in ways]}
