# SPDX-License-Identifier: Apache-2.0
"""What happened outside: the only thing that moves a mission.

Rule: an event is raw. It says what was received, never what it means; what it means is worked out inside the Step.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

__all__ = ("KINDS", "Event", "Image", "Tick", "is_operator", "is_taken")

NOTHING: Mapping[str, Any] = {}
KINDS = (
    "event", "tick", "write", "accepted", "feedback", "result", "proposal", "control", "behaviour", "command",
    "doubt", "refused", "lost", "contested", "stray", "over",
)  # fmt: skip
"""What sort of happening an event can be; `Event.kind` says what each means."""


class Event(NamedTuple):
    """One thing that happened, with the time at which it did."""

    name: str
    """A declared event's name, or, for the other kinds, what is said in `kind`'s table."""
    at: float = 0.0
    """Seconds on the run's clock."""
    data: Mapping[str, Any] = NOTHING
    """The payload; `event.<field>` in the guards of the row it fires."""
    kind: str = "event"
    """What sort of happening, and so what `name` and `number` say:

    | kind         | name                                              | number            |
    |--------------|---------------------------------------------------|-------------------|
    | `event`      | an event the mission declares                     | –                 |
    | `tick`       | `tick`: time has passed                           | –                 |
    | `write`      | the key that was written (`data["value"]`)        | –                 |
    | `accepted`   | the action or call that was accepted              | number of start   |
    | `feedback`   | the action that reports on its way                | number of start   |
    | `result`     | `succeeded`, `failed`, `canceled`, `rejected`     | number of start   |
    | `refused`    | the action whose server refuses a cancel          | number of start   |
    | `lost`       | the action whose server is gone; its `result` comes next | number of start |
    | `contested`  | the action that a second server serves            | number of start   |
    | `stray`      | the action that executes though its end was reported (`data["owner"]`) | number of start |
    | `over`       | the action that executes nowhere any more, after it was lost or stray  | number of start |
    | `proposal`   | the answerer that answers, declines or fails      | number of question|
    | `control`    | who holds control now                             | –                 |
    | `behaviour`  | `behaviour`; its end stands in `data["status"]`   | number of start   |
    | `command`    | `pause`, `resume`, `cancel`, `kill`, `take_up`, `migrate` | –                 |
    | `doubt`      | `uncertain`: whether it was done (`data["name"]`) no one can say | – |

    `take_up`: another process continues with the run. The first reading of each fact that was known is in
    `data["heard"]`, and the instant from which on effects are carried out again in `data["present"]`.
    `migrate`: a run of another mission continues in this one; where it stands is in the data.
    """
    number: int = 0
    """The number of the start or question that this answers; a late one is known by it."""


def Tick(at: float) -> Event:  # noqa: N802 - reads as the event it makes
    """Time has passed: whatever was due until `at` happens now."""
    return Event("tick", at, NOTHING, "tick")


def is_operator(by: str) -> bool:
    """Whether a client acts as the operator: `operator`, or that and who it is, as in `operator Anna (page)`."""
    return by == "operator" or by.startswith("operator ")


def is_taken(event: Event, *, holder: str, taken: bool, asked: str) -> bool:
    """Whether the operator holds control by having taken it, once a `control` event has happened.

    Args:
        event: Who holds control from now on, and `by` whom that is.
        holder: Who held it before.
        taken: Whether the operator had taken it before.
        asked: For whom the mission has asked for control that has not come yet; empty for no one.
    """
    by = str(event.data.get("by", ""))
    if event.name != "operator" or is_operator(by):
        return event.name == "operator"
    return taken if holder == "operator" else by != "mission" and asked != "operator"


class Image:
    """A picture someone took, as a reference; its bytes are made when they are first asked for.

    Two images are equal when they have the same reference.

    Args:
        ref: What identifies the picture in a run, such as `camera@12.300`.
        width: Pixels.
        height: Pixels.
        encoding: `rgb8` (raw, row by row), `png` or `jpeg`.
        data: The bytes, or what makes them when asked.
    """

    __slots__ = ("_data", "encoding", "height", "ref", "width")

    def __init__(self, ref: str, width: int, height: int, encoding: str, data: bytes | Callable[[], bytes]) -> None:
        self.ref, self.width, self.height, self.encoding = ref, width, height, encoding
        self._data = data

    @property
    def data(self) -> bytes:
        if callable(self._data):
            self._data = self._data()
        return self._data

    @property
    def digest(self) -> str:
        """SHA-256 of the bytes, in hex."""
        return hashlib.sha256(self.data).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Image) and other.ref == self.ref

    def __hash__(self) -> int:
        return hash(self.ref)

    def __repr__(self) -> str:
        return f"Image({self.ref!r}, {self.width}x{self.height}, {self.encoding})"
