# SPDX-License-Identifier: Apache-2.0
"""What travels in the gate: what happens to it, what it remembers, and what it has done where the actuators are.

Rule: all frozen. What the gate knows is one `Gate`; the next one is made from it in `rules.py` alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.states.control import HOLDERS

__all__ = (
    "COMMANDERS",
    "ActuatorCommand",
    "Alive",
    "Answer",
    "ControlChange",
    "Gate",
    "GateEffect",
    "GateEvent",
    "GateRules",
    "Halt",
    "Pass",
    "PublishStatus",
    "Refuse",
    "Request",
    "TimeUpdate",
    "status_of",
)  # fmt: skip

COMMANDERS: tuple[str, ...] = tuple(each for each in HOLDERS if each != "nobody")
"""Who can command the actuators while they hold control."""


class GateRules(NamedTuple):
    """What a gate is configured with before it begins."""

    leases: Mapping[str, float] = {}
    """Holder → seconds of silence after which it loses control; one that is not here may be silent for ever."""
    safe: str = "autonomy"
    """Who has control when the holder falls silent: `autonomy` or `nobody`."""
    status_s: float = 1.0
    """Seconds between two statuses when nothing changes."""
    unlooked: frozenset[str] = frozenset()
    """Topics on which a number may be NaN or infinite."""


# -- what happens ------------------------------------------------------------------------------------------------------


class Request(NamedTuple):
    """Someone asks for control to go to someone."""

    at: float
    to: str
    by: str


class ActuatorCommand(NamedTuple):
    """Someone commands an actuator."""

    at: float
    who: str
    topic: str
    """The actuators' own topic."""
    data: Mapping[str, Any]
    made: float = math.inf
    """When it was made, by its own stamp, on the gate's clock; infinity where it has none."""


class Alive(NamedTuple):
    """Someone is there, and has nothing to command."""

    at: float
    who: str


class TimeUpdate(NamedTuple):
    """Time has passed."""

    at: float


GateEvent = Request | ActuatorCommand | Alive | TimeUpdate


# -- what is done ------------------------------------------------------------------------------------------------------


class ControlChange(NamedTuple):
    """Control goes from one to another: the stop is published first."""

    revision: int
    former: str
    holder: str
    why: str


class Halt(NamedTuple):
    """The actuators are stopped, no matter who holds control: the gate begins or ends."""

    why: str


class Pass(NamedTuple):
    """A command is passed on to the actuators."""

    revision: int
    command: ActuatorCommand


class Refuse(NamedTuple):
    """A command goes no further."""

    revision: int
    command: ActuatorCommand
    why: str


class Answer(NamedTuple):
    """What becomes of a request; `why` is empty where it is granted."""

    revision: int
    request: Request
    why: str


class PublishStatus(NamedTuple):
    """Publish who holds control, and how much was passed and refused."""

    gate: Gate


GateEffect = ControlChange | Halt | Pass | Refuse | Answer | PublishStatus


# -- what is known -----------------------------------------------------------------------------------------------------


class Gate(NamedTuple):
    """Everything that a gate remembers."""

    holder: str = "autonomy"
    kept: bool = False
    """The operator has taken control, rather than been given it: only the operator gives it back."""
    revision: int = 0
    """Counts the changes of holder: the number of the grant in force."""
    since: float = 0.0
    """When the holder was given control."""
    why: str = "the gate has begun"
    at: float = 0.0
    """The last instant that it knows of."""
    published: float = -math.inf
    """When the status was last reported."""
    alive: Mapping[str, float] = {}
    """Who → its last sign of life: a command, refused or not, or a heartbeat."""
    commanded: Mapping[str, float] = {}
    """Who → its last command."""
    passed: Mapping[str, int] = {}
    """Who → its commands that were passed on."""
    refused: Mapping[str, int] = {}
    """Who → its commands that did not."""
    requests_refused: Mapping[str, int] = {}
    """Who → its requests for control that were not granted."""
    last_refusal: str = ""
    """Who was refused last, and why."""

    def lapses_at(self, rules: GateRules) -> float:
        """When the holder loses control if it stays silent; infinity for never."""
        if self.holder == "nobody" or self.holder not in rules.leases:
            return math.inf
        return max(self.since, self.alive.get(self.holder, -math.inf)) + rules.leases[self.holder]

    def wake_at(self, rules: GateRules) -> float:
        """When the gate next does something by itself."""
        return min(self.lapses_at(rules), self.published + rules.status_s)


def status_of(gate: Gate, rules: GateRules) -> dict[str, Any]:
    """The status, as everybody reads it; instants are seconds on the gate's clock, `at` among them."""
    return {
        "revision": gate.revision,
        "holder": gate.holder,
        "why": gate.why,
        "taken": gate.kept,
        "since": round(gate.since, 6),
        "at": round(gate.at, 6),
        "safe": rules.safe,
        "leases": dict(rules.leases),
        "last_command_age_s": {
            who: round(gate.at - gate.commanded[who], 6) if who in gate.commanded else None for who in COMMANDERS
        },
        "passed": {who: gate.passed.get(who, 0) for who in COMMANDERS},
        "refused": {who: gate.refused.get(who, 0) for who in COMMANDERS},
        "requests_refused": {who: gate.requests_refused.get(who, 0) for who in COMMANDERS},
        "last_refusal": gate.last_refusal,
    }
