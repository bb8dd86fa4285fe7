# SPDX-License-Identifier: Apache-2.0
"""Goals over things on a desk: what is wanted, what is seen, whether it holds, and which moves lead there.

Imports `model` and the modules of the root. Everything is in the robot's base frame (x forward, y to its left, z up,
the desk's top at z = 0), in metres and radians.
"""

from rai_missions.planning.goal import (
    Apart,
    AtPlace,
    Goal,
    Grouped,
    InContainer,
    LeftOf,
    NextTo,
    OnTop,
    Predicate,
    Refusal,
    Swapped,
    goal_schema,
    read_goal,
)
from rai_missions.planning.plan import Plan, PlannedMove, Pose, plan_data
from rai_missions.planning.planner import feasible, planned
from rai_missions.planning.relations import holds, reached, support, without_swaps
from rai_missions.planning.scene import DESK, Scene, Thing, read_scene
from rai_missions.planning.tolerances import JUDGE, STRICT
from rai_missions.planning.workspace import Workspace

__all__ = (
    "DESK", "JUDGE", "STRICT", "Apart", "AtPlace", "Goal", "Grouped", "InContainer", "LeftOf", "NextTo", "OnTop",
    "Plan", "PlannedMove", "Pose", "Predicate", "Refusal", "Scene", "Swapped", "Thing", "Workspace", "feasible",
    "goal_schema", "holds", "plan_data", "planned", "reached", "read_goal", "read_scene", "support", "without_swaps",
)  # fmt: skip
