# SPDX-License-Identifier: Apache-2.0
"""What happened outside: the only thing that moves a mission.

Rule: an event is raw. It holds what was received, never what it means; what it means is worked out inside the Step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple, get_args

__all__ = ("KINDS", "Event", "EventKind", "Origin", "Role", "Tick", "is_e_stop", "is_taken")

Role = Literal["operator", "viewer", "person"]
"""What a client may do: steer a run, look at it, or what a person without a token may.

The door through which a message came sets it: a page's token, the terminal, a voice; never what the message holds.
"""
Origin = Role | Literal["software"]
"""Whose an order is: a client's by its role, or `software` of the robot itself, such as its autonomy stack."""

NOTHING: Mapping[str, Any] = {}
EventKind = Literal[
    "event",
    "tick",
    "write",
    "accepted",
    "feedback",
    "result",
    "proposal",
    "control",
    "behaviour",
    "command",
    "doubt",
    "refused",
    "lost",
    "contested",
    "stray",
    "over",
    "overdue",
    "outcome",
]
"""The kinds of events; the table of `Event.kind` has what each means."""
KINDS: tuple[EventKind, ...] = tuple(kind for kind in get_args(EventKind) if kind != "outcome")
"""The kinds that can come from outside."""


class Event(NamedTuple):
    """One thing that happened, with the time at which it did."""

    name: str
    """A declared event's name, or, for the other kinds, as in `kind`'s table."""
    at: float = 0.0
    """Seconds on the run's clock."""
    data: Mapping[str, Any] = NOTHING
    """The payload; `event.<field>` in the guards of the transition that it fires."""
    kind: EventKind = "event"
    """The kind, on which the meaning of `name` and `number` depends:

    | kind         | name                                              | number            |
    |--------------|---------------------------------------------------|-------------------|
    | `event`      | an event the mission declares                     | –                 |
    | `tick`       | `tick`: time has passed                           | –                 |
    | `write`      | the key that was written (`data["value"]`)        | –                 |
    | `accepted`   | the action or call that was accepted              | number of start   |
    | `feedback`   | the action that reports on its way                | number of start   |
    | `result`     | of a goal: `succeeded`, `failed`, `canceled`, `rejected` | number of start |
    | `result`     | of a call: `succeeded`, `failed`, `timed_out`, `unavailable` | number of start |
    | `refused`    | the action whose server refuses a cancel          | number of start   |
    | `lost`       | the action whose server is gone; its `result` comes next | number of start |
    | `contested`  | the action that a second server serves            | number of start   |
    | `stray`      | the action that executes though its end was reported (`data["owner"]`) | number of start |
    | `over`       | the action that executes nowhere any more, after it was lost or stray  | number of start |
    | `overdue`    | the action that was canceled and is not waited for any longer | number of start |
    | `proposal`   | the answerer that answers, declines or fails      | number of question|
    | `control`    | who holds control now                             | –                 |
    | `behaviour`  | `behaviour`; its end is in `data["status"]`   | number of start   |
    | `command`    | `pause`, `stop`, `resume`, `cancel`, `kill`, `take_up`, `migrate` | –                 |
    | `doubt`      | `uncertain`: whether it was done (`data["name"]`) is unknown | – |
    | `outcome`    | an outcome of a state that waits for the hand-back; never from outside | – |

    `take_up`: another process continues with the run. The first reading of each fact that was known is in
    `data["heard"]`, and the instant from which on effects are carried out again in `data["present"]`.
    `migrate`: a run of another mission continues in this one; its state is in the data.
    """
    number: int = 0
    """The number of the start or question that this answers; a late one is known by it."""

    def moved(self, at: float) -> Event:
        """The event at another time; `_replace` takes three times as long."""
        return Event(self.name, at, self.data, self.kind, self.number)


def Tick(at: float) -> Event:  # noqa: N802 - reads as the event it makes
    """Time has passed: whatever was due until `at` happens now."""
    return Event("tick", at, NOTHING, "tick")


def is_e_stop(event: Event) -> bool:
    """Whether it is the e-stop: the command that Python and the journal's rows name `kill`."""
    return event.kind == "command" and event.name == "kill"


def is_taken(event: Event, *, holder: str, taken: bool, asked: str) -> bool:
    """Whether the operator holds control by having taken it, once a `control` event has happened.

    Args:
        event: Who holds control from now on; in its data the `role` of the client that asked for it, or `by` whom else
            it came about: the `mission` or the `robot`. What a client calls itself counts for nothing.
        holder: Who held it before.
        taken: Whether the operator had taken it before.
        asked: For whom the mission has asked for control that has not come yet; empty for no one.
    """
    role = event.data.get("role")
    if event.name != "operator" or role == "operator":
        return event.name == "operator"
    is_missions = role is None and event.data.get("by") == "mission"
    return taken if holder == "operator" else not is_missions and asked != "operator"
