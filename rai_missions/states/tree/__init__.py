# SPDX-License-Identifier: Apache-2.0
"""A behaviour tree as data, under py_trees' own names; what ticks it is given to the chart.

Rule: nothing here knows py_trees. A tree's state is a frozen value from which a ticker rebuilds.
Rule: a leaf is offered under its word of the format: `tree.Action` is next to the state `Action`.

Imports `guards` and `model`, and the modules of the root.
"""

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names
from rai_missions.states.tree.behaviour import BehaviourLeaf as Behaviour
from rai_missions.states.tree.composites import Branch, Selector, Sequence
from rai_missions.states.tree.composites import ParallelTree as Parallel
from rai_missions.states.tree.decorators import (
    Condition,
    EternalGuard,
    FailureIsRunning,
    FailureIsSuccess,
    Inverter,
    OneShot,
    PassThrough,
    Repeat,
    Retry,
    RunningIsFailure,
    RunningIsSuccess,
    StatusToBlackboard,
    SuccessIsFailure,
    SuccessIsRunning,
    Timeout,
)
from rai_missions.states.tree.leaves import ActionLeaf as Action
from rai_missions.states.tree.leaves import CallLeaf as Call
from rai_missions.states.tree.leaves import CheckLeaf as Check
from rai_missions.states.tree.leaves import DecisionLeaf as Decision
from rai_missions.states.tree.leaves import PublishLeaf as Publish
from rai_missions.states.tree.leaves import SetLeaf as Set
from rai_missions.states.tree.leaves import WaitLeaf as Wait
from rai_missions.states.tree.node import Decorator, TreeNode
from rai_missions.states.tree.tree import Tree

__all__ = (
    "Action", "Behaviour", "Branch", "Call", "Check", "Condition", "Decision", "Decorator", "EternalGuard",
    "FailureIsRunning", "FailureIsSuccess", "Inverter", "OneShot", "Parallel", "PassThrough", "Publish", "Repeat",
    "Retry", "RunningIsFailure", "RunningIsSuccess", "Selector", "Sequence", "Set", "StatusToBlackboard",
    "SuccessIsFailure", "SuccessIsRunning", "Timeout", "Tree", "TreeNode", "Wait",
)  # fmt: skip

if not TYPE_CHECKING:  # else a type checker would take any name for one of ours
    __getattr__, _ = lazy_names(globals(), {})  # a misspelled name is reported with the nearest
