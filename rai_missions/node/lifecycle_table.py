# SPDX-License-Identifier: Apache-2.0
"""The standard lifecycle of ROS 2 nodes, as a table (design.ros2.org/articles/node_lifecycle.html, `rcl_lifecycle`).

Rule: a state and a transition are here, or they do not exist. Ids and labels are those of `lifecycle_msgs`.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ("ACTS", "STATES", "TRANSITIONS", "State", "Transition", "leaving", "transition")


class State(NamedTuple):
    """A state of the node."""

    id: int
    label: str


class Transition(NamedTuple):
    """A way between two states."""

    id: int
    label: str
    start: State
    goal: State


UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = (
    State(1, "unconfigured"), State(2, "inactive"), State(3, "active"), State(4, "finalized"),
)  # fmt: skip
CONFIGURING, CLEANINGUP, SHUTTINGDOWN, ACTIVATING, DEACTIVATING, ERRORPROCESSING = (
    State(10, "configuring"), State(11, "cleaningup"), State(12, "shuttingdown"), State(13, "activating"),
    State(14, "deactivating"), State(15, "errorprocessing"),
)  # fmt: skip
STATES = (
    State(0, "unknown"), UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED,
    CONFIGURING, CLEANINGUP, SHUTTINGDOWN, ACTIVATING, DEACTIVATING, ERRORPROCESSING,
)  # fmt: skip

ACTS = (
    Transition(1, "configure", UNCONFIGURED, CONFIGURING),
    Transition(2, "cleanup", INACTIVE, CLEANINGUP),
    Transition(3, "activate", INACTIVE, ACTIVATING),
    Transition(4, "deactivate", ACTIVE, DEACTIVATING),
    Transition(5, "shutdown", UNCONFIGURED, SHUTTINGDOWN),
    Transition(6, "shutdown", INACTIVE, SHUTTINGDOWN),
    Transition(7, "shutdown", ACTIVE, SHUTTINGDOWN),
)
"""What a client may ask for."""


def _ends(first_id: int, within: State, success: State, failure: State) -> tuple[Transition, ...]:
    """How what is done in a state on the way ends."""
    return (
        Transition(first_id, "transition_success", within, success),
        Transition(first_id + 1, "transition_failure", within, failure),
        Transition(first_id + 2, "transition_error", within, ERRORPROCESSING if first_id != 60 else FINALIZED),
    )


TRANSITIONS = (
    *ACTS,
    *_ends(10, CONFIGURING, INACTIVE, UNCONFIGURED),
    *_ends(20, CLEANINGUP, UNCONFIGURED, INACTIVE),
    *_ends(30, ACTIVATING, ACTIVE, INACTIVE),
    *_ends(40, DEACTIVATING, INACTIVE, ACTIVE),
    *_ends(50, SHUTTINGDOWN, FINALIZED, FINALIZED),
    *_ends(60, ERRORPROCESSING, UNCONFIGURED, FINALIZED),
)


def leaving(state: State) -> tuple[Transition, ...]:
    """What a client may ask for in a state."""
    return tuple(each for each in ACTS if each.start == state)


def transition(state: State, label: str, number: int = 0) -> Transition | None:
    """The way out of a state that has a label, or, without one, a number; None where there is none.

    As in rclcpp the label comes first, since one `shutdown` has three numbers.
    """
    ways = [each for each in TRANSITIONS if each.start == state]
    return next((each for each in ways if (each.label == label if label else each.id == number)), None)
