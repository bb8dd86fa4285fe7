# SPDX-License-Identifier: Apache-2.0
"""A behaviour tree as data, under py_trees' own names; what ticks it is given to the chart.

Rule: nothing here knows py_trees. A tree's state is a frozen value from which a ticker rebuilds.

Imports `guards` and the modules of the root.
"""

from rai_missions.states.tree.behaviour import ONLY_IN_PYTHON, BehaviourLeaf, factory_name
from rai_missions.states.tree.composites import Branch, ParallelTree, Selector, Sequence
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
from rai_missions.states.tree.leaves import (
    ActionLeaf,
    CallLeaf,
    CheckLeaf,
    DecisionLeaf,
    PublishLeaf,
    SetLeaf,
    WaitLeaf,
)
from rai_missions.states.tree.node import Decorator, TreeNode
from rai_missions.states.tree.tree import Tree

__all__ = (
    "ONLY_IN_PYTHON",
    "ActionLeaf", "BehaviourLeaf", "Branch", "CallLeaf", "CheckLeaf", "Condition", "DecisionLeaf", "Decorator",
    "EternalGuard", "FailureIsRunning", "FailureIsSuccess", "Inverter", "OneShot", "ParallelTree", "PassThrough",
    "PublishLeaf", "Repeat", "Retry", "RunningIsFailure", "RunningIsSuccess", "Selector", "Sequence", "SetLeaf",
    "StatusToBlackboard", "SuccessIsFailure", "SuccessIsRunning", "Timeout", "Tree", "TreeNode", "WaitLeaf",
    "factory_name",
)  # fmt: skip
