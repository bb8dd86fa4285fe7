# SPDX-License-Identifier: Apache-2.0
"""What machines remember, with everything left out that makes no difference to what can happen next."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.action import GoalActivity
from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.tree import RunningLeaf, TreeActivity
from rai_missions.guards.view import View
from rai_missions.prove.abstraction.nondeterminism import AnyOf, OpenFields
from rai_missions.prove.abstraction.open_world import NOW

__all__ = ("SOON", "key_of", "plain", "rested", "timer_key", "waits_for_time")

SOON = NOW + 1.0
"""When whatever runs would be due, if time continued."""
DIGITS = 6
STOPPED = {"status": "invalid"}
"""What a node remembers that was stopped: to what it does, the same as to have never run."""


def rested(state: Any, machine: Any, longest_s: float, view: View) -> Any:
    """A machine's state with its timers at the same distance as ever.

    What a tree remembers to have begun, or to have been true since, is no longer ago than any guard asks for.

    A question that has a deadline is put as if it had just begun to be asked: anyone who is asked last can do no more
    than anyone who is asked first, and the deadline does what comes of asking them all.
    """
    if isinstance(state, GoalActivity):
        return state._replace(until=SOON) if state.until != math.inf else state
    if isinstance(state, DecisionActivity):
        return _asked_again(state, machine)
    if isinstance(state, TreeActivity):
        leaves = {
            path: RunningLeaf(
                rested(leaf.state, machine.leaf_machines[path].machine, longest_s, view),
                SOON if leaf.deadline != math.inf else math.inf,
            )
            for path, leaf in state.leaves.items()
        }
        nodes = {path: _no_older(memory, NOW - longest_s) for path, memory in state.tree.nodes.items()}
        return state._replace(leaves=leaves, tree=state.tree._replace(nodes=nodes))
    wake = machine.wake_at(state, view)
    return machine.shift(state, SOON - wake) if NOW < wake < math.inf else state


def _no_older(memory: Mapping[str, Any], least: float) -> Mapping[str, Any]:
    late = {"began": max(memory["began"], least)} if "began" in memory else {}
    held = {name: max(since, least) for name, since in memory.get("held", {}).items()}
    return {**memory, **late, **({"held": held} if held else {})} if late or held else memory


def _asked_again(state: DecisionActivity, machine: Any) -> DecisionActivity:
    question = state.question
    until = SOON if question.until != math.inf else math.inf
    if state.deadline == math.inf:
        return state._replace(question=question._replace(until=until, refused=(), at=NOW))
    question = question._replace(until=until, refused=(), at=NOW, attempt=1, asked=machine.asked.ask[0])
    return state._replace(question=question, turn=0, deadline=SOON + 1.0)


def waits_for_time(state: Any) -> bool:
    """Whether time alone may bring a machine's state further."""
    if isinstance(state, TreeActivity):
        leaves = state.leaves.values()
        return state.wake != math.inf or any(each.deadline != math.inf or waits_for_time(each.state) for each in leaves)
    if isinstance(state, DecisionActivity):
        return min(state.deadline, state.question.until) != math.inf
    return isinstance(state, GoalActivity) and state.until != math.inf


def key_of(state: Any) -> Any:
    """What distinguishes a machine's state from others, without the numbers of starts and questions."""
    if isinstance(state, GoalActivity):
        result = sorted(state.result.items())
        return ("pursuit", state.phase, state.until == math.inf, result)
    if isinstance(state, DecisionActivity):
        question = state.question
        return ("asking", tuple(offer.name for offer in question.options), state.turn, question.attempt)
    if isinstance(state, TreeActivity):
        return _tree_key(state)
    fields = state._asdict()
    numbered = {"number": bool(fields["number"])} if "number" in fields else {}
    return (type(state).__name__, _rounded(fields | numbered))


def _tree_key(state: TreeActivity) -> Any:
    leaves = [(path, key_of(each.state), each.deadline == math.inf) for path, each in sorted(state.leaves.items())]
    known = ((path, _unnumbered(memory)) for path, memory in sorted(state.tree.nodes.items()))
    nodes = [(path, repr(_rounded(memory))) for path, memory in known if memory != STOPPED]
    ends = sorted((path, leaf.outcome) for path, leaf in state.tree.leaves.items())
    return ("tending", leaves, nodes, ends, _rounded(state.wake), state.limit)


def _unnumbered(memory: Mapping[str, Any]) -> Mapping[str, Any]:
    """How often a leaf has begun distinguishes its runs, and makes no difference to what it does."""
    return {word: value for word, value in memory.items() if word != "run"}


def _rounded(value: Any) -> Any:
    """Times as near as they can be distinguished: their sums differ in the last digits."""
    if isinstance(value, float):
        return round(value, DIGITS)
    if isinstance(value, Mapping):
        return [(name, _rounded(each)) for name, each in sorted(value.items())]
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    return value


def timer_key(key: tuple[str, Any], timer: Any) -> tuple[str, str, str]:
    """A delayed `raise` without an id is named by its number, which makes no difference; its event does."""
    kind, which = key
    if kind == "raise":
        name = "" if isinstance(which, int) else f" as {which}"
        return kind, f"{timer.name}{name}", f"{timer.control} {timer.data}"
    return kind, str(which), ""


def plain(value: Any) -> Any:
    """What is known of an object, field by field, or of a key that has one of several values."""
    if isinstance(value, AnyOf):
        return tuple(map(plain, value))
    return sorted(value.items()) if isinstance(value, OpenFields) else value
