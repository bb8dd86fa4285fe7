# SPDX-License-Identifier: Apache-2.0
"""Goals over things on a desk: what is wanted, what is seen, whether it holds, and which moves lead there.

Imports `model` and the modules of the root. Everything is in the robot's base frame (x forward, y to its left, z up,
the desk's top at z = 0), in metres and radians.
"""

from typing import TYPE_CHECKING

from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.planning.goal import (
        Apart,
        AtPlace,
        Behind,
        Between,
        Goal,
        Grouped,
        InContainer,
        LeftOf,
        NextTo,
        OnTop,
        Predicate,
        Refusal,
        Shifted,
        Swapped,
        goal_schema,
        read_goal,
    )
    from rai_missions.planning.ordering import place_for_the_hand
    from rai_missions.planning.plan import AvoidedPlace, Plan, PlannedMove, Pose, avoided_after, plan_data
    from rai_missions.planning.planner import feasible, planned
    from rai_missions.planning.relations import at_first_poses, holds, reached, support
    from rai_missions.planning.scene import DESK, Scene, Thing, read_scene
    from rai_missions.planning.tolerances import JUDGE, STRICT
    from rai_missions.planning.workspace import Workspace

__all__ = (
    "DESK", "JUDGE", "STRICT", "Apart", "AtPlace", "AvoidedPlace", "Behind", "Between", "Goal", "Grouped",
    "InContainer", "LeftOf", "NextTo", "OnTop", "Plan", "PlannedMove", "Pose", "Predicate", "Refusal", "Scene",
    "Shifted", "Swapped", "Thing", "Workspace", "at_first_poses", "avoided_after", "feasible", "goal_schema", "holds",
    "place_for_the_hand", "plan_data", "planned", "reached", "read_goal", "read_scene", "support",
)  # fmt: skip

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy_names(
        globals(),
        {
            "goal": (
                "Apart",
                "AtPlace",
                "Behind",
                "Between",
                "Goal",
                "Grouped",
                "InContainer",
                "LeftOf",
                "NextTo",
                "OnTop",
                "Predicate",
                "Refusal",
                "Shifted",
                "Swapped",
                "goal_schema",
                "read_goal",
            ),
            "ordering": ("place_for_the_hand",),
            "plan": ("AvoidedPlace", "Plan", "PlannedMove", "Pose", "avoided_after", "plan_data"),
            "planner": ("feasible", "planned"),
            "relations": ("at_first_poses", "holds", "reached", "support"),
            "scene": ("DESK", "Scene", "Thing", "read_scene"),
            "tolerances": ("JUDGE", "STRICT"),
            "workspace": ("Workspace",),
        },
    )
