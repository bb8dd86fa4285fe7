# SPDX-License-Identifier: Apache-2.0
"""Ways to take a thing and to set it down: no finger meets a wall of a container, while it opens or closes either."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.worlds.desk.catalogue import KINDS, WALL_M
from rai_missions.worlds.desk.footprints import SeenThing
from rai_missions.worlds.desk.grasps import Grasp, HeldThing, grasps, releases
from rai_missions.worlds.desk.kinematics import ToolPose
from rai_missions.worlds.desk.panda.model import TIP_BELOW_TCP_M

TIP_M, TIP_SIDE_M = 0.011, 0.0095
"""How thick the tip of a finger is, and half of how wide."""
X, Y, YAW = 0.55, -0.1, 0.4
LONG, BROAD, HIGH = KINDS["tray"].size
TRAY = SeenThing("tray", "tray", X, Y, HIGH / 2, YAW, KINDS["tray"].size)
SHARES = st.floats(-0.9, 0.9)


def in_tray(kind: str, u: float, v: float, turned: float) -> SeenThing:
    """A thing whose middle is at shares of the tray's half extents from its middle."""
    u, v = u * (LONG / 2 - WALL_M), v * (BROAD / 2 - WALL_M)
    x, y = X + math.cos(YAW) * u - math.sin(YAW) * v, Y + math.sin(YAW) * u + math.cos(YAW) * v
    return SeenThing(kind, kind, x, y, WALL_M + KINDS[kind].size[2] / 2, YAW + turned, KINDS[kind].size)


def tips(grasp: Grasp, wide: float) -> Iterator[tuple[float, float]]:
    """Points of both tips between the thing's sides and where the fingers are open: x and y in the tray's frame."""
    pose = grasp.pose
    moments, thick, aside = (0.0, 0.25, 0.5, 0.75, 1.0), (0.0, TIP_M / 2, TIP_M), (-TIP_SIDE_M, 0.0, TIP_SIDE_M)
    for moment, side, out, by in product(moments, (-1.0, 1.0), thick, aside):
        far = side * ((wide + moment * (grasp.opening_m - wide)) / 2 + out)
        dx = pose.x + math.sin(pose.yaw) * far + math.cos(pose.yaw) * by - X
        dy = pose.y - math.cos(pose.yaw) * far + math.sin(pose.yaw) * by - Y
        yield math.cos(YAW) * dx + math.sin(YAW) * dy, math.cos(YAW) * dy - math.sin(YAW) * dx


def meets_a_wall(grasp: Grasp, wide: float) -> bool:
    if grasp.pose.z - TIP_BELOW_TCP_M >= HIGH:
        return False
    return any(
        abs(u) <= LONG / 2 and abs(v) <= BROAD / 2 and (abs(u) >= LONG / 2 - WALL_M or abs(v) >= BROAD / 2 - WALL_M)
        for u, v in tips(grasp, wide)
    )


@given(st.sampled_from(("cube", "apple", "carrot")), SHARES, SHARES, st.sampled_from((0.0, math.pi / 2)))
@example("carrot", -0.5, -0.75, 0.0)
def test_no_finger_meets_a_wall_between_a_thing_and_where_it_opens(
    kind: str, u: float, v: float, turned: float
) -> None:
    thing = in_tray(kind, u, v, turned)
    wide = thing.size[1]
    assert not any(meets_a_wall(each, wide) for each in grasps(thing, [TRAY]))
    held = HeldThing(thing._replace(x=0.4, y=0.2), ToolPose(0.4, 0.2, thing.z, thing.yaw))
    offered = list(releases(held, thing.x, thing.y, thing.z, thing.yaw, [TRAY]))
    assert offered and not any(meets_a_wall(each, wide) for each in offered)
