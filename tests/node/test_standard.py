# SPDX-License-Identifier: Apache-2.0
"""The node's lifecycle is ROS 2's: its states, its transitions, and no other way."""

from __future__ import annotations

import importlib
import logging
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.node.lifecycle_table import ACTS, STATES, TRANSITIONS, NodeTransition, leaving, transition
from rai_missions.node.managed_lifecycle import ManagedLifecycle

LABELS = ("configure", "activate", "deactivate", "cleanup", "shutdown", "create", "transition_success", "")
ENDS = ("success", "failure", "error", "later")


def test_the_ids_are_those_of_lifecycle_msgs() -> None:
    pytest.importorskip("rclpy")
    messages = importlib.import_module("lifecycle_msgs.msg")
    known = {getattr(messages.State, name) for name in vars(type(messages.State)) if "_STATE_" in name}
    assert {state.id for state in STATES} == known
    reported = {
        name: getattr(messages.Transition, name) for name in dir(messages.Transition) if name.startswith("TRANS")
    }
    for way in TRANSITIONS:
        assert reported[f"TRANSITION_{_constant(way).upper()}"] == way.id, way


def _constant(way: NodeTransition) -> str:
    """The name that a transition has in `lifecycle_msgs`."""
    if way in ACTS:
        return f"{way.start.label}_{way.label}" if way.label == "shutdown" else way.label
    doing = next((act.label for act in ACTS if act.goal == way.start), "error")
    return way.label.replace("transition", f"on_{doing}")


@given(st.lists(st.tuples(st.sampled_from(LABELS), st.sampled_from(ENDS)), max_size=12))
def test_the_node_moves_along_the_table_alone(asked: list[tuple[str, str]]) -> None:
    logging.disable(logging.CRITICAL)
    try:
        moves, later = walk(asked)
    finally:
        logging.disable(logging.NOTSET)
    at = "unconfigured"
    for move in moves:
        assert move in TRANSITIONS and move.start.label == at
        at = move.goal.label
    assert later or at in ("unconfigured", "inactive", "active", "finalized"), "nothing stays on its way unasked"


def walk(asked: list[tuple[str, str]]) -> tuple[list[NodeTransition], bool]:
    """Ask for transitions whose acts end as reported; the moves made, and whether one is still under way."""
    moves: list[NodeTransition] = []
    how = ["success"]
    waiting: list[Callable[[str], None]] = []

    def act(finish: Callable[[str], None]) -> None:
        if how[0] == "error":
            raise RuntimeError("unforeseen")
        if how[0] == "failure":
            raise UsageError("no")
        if how[0] == "later":
            waiting.append(finish)
        else:
            finish("")

    labels = [*LABELS, "error"]
    lifecycle = ManagedLifecycle(dict.fromkeys(labels, act) | {"error": lambda _finish: None}, moves.append)
    for label, end in asked:
        how[0] = end
        before, state = len(moves), lifecycle.state
        reported = lifecycle.change(label)
        known = label in [way.label for way in leaving(state)]
        assert reported is (known and end in ("success", "later")) or (not known and not reported)
        assert (len(moves) > before) is known, "what does not leave a state moves nothing"
        assert not known or end == "later" or bool(lifecycle.fault) is (end != "success")
        if len(waiting) > 1:
            waiting.pop(0)("")
    return moves, bool(waiting)


def test_a_transition_that_ends_later_is_under_way_until_then() -> None:
    moves: list[NodeTransition] = []
    ends: list[Callable[[str], None]] = []
    lifecycle = ManagedLifecycle({"configure": ends.append}, moves.append)
    assert lifecycle.change("configure") and lifecycle.state.label == "configuring"
    assert not lifecycle.change("configure")
    ends[0]("")
    ends[0]("twice")
    assert lifecycle.state.label == "inactive" and lifecycle.fault == "" and len(moves) == 2


def test_a_transition_is_found_by_its_number_too() -> None:
    for way in ACTS:
        assert transition(way.start, "", way.id) == transition(way.start, way.label) == way
