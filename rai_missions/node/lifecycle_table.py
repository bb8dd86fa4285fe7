# SPDX-License-Identifier: Apache-2.0
"""The standard lifecycle of ROS 2 nodes, as a table (design.ros2.org/articles/node_lifecycle.html, `rcl_lifecycle`).

Rule: a state and a transition are here, or they do not exist. Ids and labels are those of `lifecycle_msgs`.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ("ACTS", "STATES", "TRANSITIONS", "NodeState", "NodeTransition", "leaving", "transition")


class NodeState(NamedTuple):
    """One of the standard lifecycle, by the number and the name that `lifecycle_msgs` gives it."""

    id: int
    label: str


class NodeTransition(NamedTuple):
    """A way between two states."""

    id: int
    label: str
    start: NodeState
    goal: NodeState


UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = (
    NodeState(1, "unconfigured"),
    NodeState(2, "inactive"),
    NodeState(3, "active"),
    NodeState(4, "finalized"),
)
CONFIGURING, CLEANINGUP, SHUTTINGDOWN, ACTIVATING, DEACTIVATING, ERRORPROCESSING = (
    NodeState(10, "configuring"),
    NodeState(11, "cleaningup"),
    NodeState(12, "shuttingdown"),
    NodeState(13, "activating"),
    NodeState(14, "deactivating"),
    NodeState(15, "errorprocessing"),
)
STATES = (
    NodeState(0, "unknown"),
    UNCONFIGURED,
    INACTIVE,
    ACTIVE,
    FINALIZED,
    CONFIGURING,
    CLEANINGUP,
    SHUTTINGDOWN,
    ACTIVATING,
    DEACTIVATING,
    ERRORPROCESSING,
)

ACTS = (
    NodeTransition(1, "configure", UNCONFIGURED, CONFIGURING),
    NodeTransition(2, "cleanup", INACTIVE, CLEANINGUP),
    NodeTransition(3, "activate", INACTIVE, ACTIVATING),
    NodeTransition(4, "deactivate", ACTIVE, DEACTIVATING),
    NodeTransition(5, "shutdown", UNCONFIGURED, SHUTTINGDOWN),
    NodeTransition(6, "shutdown", INACTIVE, SHUTTINGDOWN),
    NodeTransition(7, "shutdown", ACTIVE, SHUTTINGDOWN),
)
"""What a client may ask for."""


def _ends(first_id: int, within: NodeState, success: NodeState, failure: NodeState) -> tuple[NodeTransition, ...]:
    """How what is done in a state on the way ends."""
    return (
        NodeTransition(first_id, "transition_success", within, success),
        NodeTransition(first_id + 1, "transition_failure", within, failure),
        NodeTransition(first_id + 2, "transition_error", within, ERRORPROCESSING if first_id != 60 else FINALIZED),
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


def leaving(state: NodeState) -> tuple[NodeTransition, ...]:
    """What a client may ask for in a state."""
    return tuple(each for each in ACTS if each.start == state)


def transition(state: NodeState, label: str, number: int = 0) -> NodeTransition | None:
    """The way out of a state that has a label, or, without one, a number; None where there is none.

    As in rclcpp the label comes first, since one `shutdown` has three numbers.
    """
    ways = [each for each in TRANSITIONS if each.start == state]
    return next((each for each in ways if (each.label == label if label else each.id == number)), None)
