# SPDX-License-Identifier: Apache-2.0
"""Which poses the gripper reaches, and the limits that its motions keep."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco")
pytest.importorskip("ruckig")

from rai_missions.worlds.desk.kinematics import TILTS, Kinematics, ToolPose, Unreachable, toward
from rai_missions.worlds.desk.panda.model import HOME, LOWER, UPPER
from rai_missions.worlds.desk.path import across, follow, straight
from rai_missions.worlds.desk.trajectory import CONTROL_S, JERK, PUSH, VELOCITY, Trajectory

pytestmark = pytest.mark.sim

ARM = Kinematics()
RADII = st.floats(0.32, 0.76)
BEARINGS = st.floats(-1.4, 1.4)
HEIGHTS = st.floats(0.02, 0.3)
QUARTERS = st.floats(-math.pi / 2, math.pi / 2)
POSES = st.builds(
    lambda radius, bearing, z, turn: ToolPose(
        radius * math.cos(bearing), radius * math.sin(bearing), z, bearing + turn
    ),
    RADII,
    BEARINGS,
    HEIGHTS,
    QUARTERS,
)


@given(POSES)
@settings(max_examples=40, deadline=None)
def test_joints_of_a_pose_within_reach_bring_the_gripper_there(pose: ToolPose) -> None:
    joints = ARM.reach(pose)
    assert (joints >= LOWER).all()
    assert (joints <= UPPER).all()
    found = ARM.pose(joints)
    assert math.dist(found[:3], pose[:3]) < 5e-4
    assert abs(math.remainder(found.yaw - pose.yaw, math.tau)) < 5e-3
    assert abs(found.tilt) < 5e-3


def test_from_straight_above_the_gripper_reaches_a_ring_and_a_leaning_hand_reaches_more() -> None:
    def reached(radius: float, tilt: float) -> bool:
        pose = ToolPose(radius, 0.0, 0.022, 0.0, tilt)
        return ARM.solve(pose, toward(pose)) is not None

    assert all(reached(radius, 0.0) for radius in (0.3, 0.4, 0.5, 0.6, 0.7, 0.78))
    assert not reached(0.2, 0.0)
    assert not reached(0.85, 0.0)
    assert any(reached(0.2, tilt) for tilt in TILTS)
    assert any(reached(0.85, tilt) for tilt in TILTS)
    assert not any(reached(1.0, tilt) for tilt in TILTS)


def test_a_pose_out_of_reach_is_refused_with_the_place_and_the_distance() -> None:
    with pytest.raises(Unreachable, match=r"cannot reach \(0\.900, 0\.300, 0\.100\) m, 0\.95 m from the base"):
        ARM.reach(ToolPose(0.9, 0.3, 0.1, 0.0))


@given(POSES, POSES, st.floats(0.15, 0.35), st.integers(0, 400))
@settings(max_examples=20, deadline=None)
def test_a_motion_keeps_the_limits_of_every_joint_also_where_it_is_stopped(
    begin: ToolPose, end: ToolPose, height: float, stop_at: int
) -> None:
    start = ARM.reach(begin)
    try:
        motion = follow(ARM, across(begin, end, height), start)
    except Unreachable:
        return
    points, stopped = [start], False
    while not motion.is_over:
        if len(points) == stop_at:
            motion.stop()
            stopped = True
        points.append(motion.step())
        assert len(points) < 1500
    speeds = np.diff(np.array(points), axis=0) / CONTROL_S
    pushes = np.diff(speeds, axis=0) / CONTROL_S
    jerks = np.diff(pushes, axis=0) / CONTROL_S
    assert (np.abs(speeds) <= 1.01 * VELOCITY).all()
    assert (np.abs(pushes) <= 1.05 * PUSH).all()
    assert (np.abs(jerks) <= 1.3 * JERK).all()  # of differences over a period, in which the limit may change
    if not stopped:
        assert math.dist(ARM.pose(points[-1])[:3], end[:3]) < 1e-3


def test_a_stopped_motion_comes_to_rest_soon_and_on_its_path() -> None:
    begin, end = ToolPose(0.5, -0.4, 0.03, 0.0), ToolPose(0.5, 0.4, 0.03, 0.0)
    motion = follow(ARM, across(begin, end, 0.3), ARM.reach(begin))
    for _ in range(120):
        last = motion.step()
    motion.stop()
    rest = [last]
    while not motion.is_over:
        rest.append(motion.step())
    assert len(rest) * CONTROL_S < 0.8
    stopped = ARM.pose(rest[-1])
    assert abs(stopped.z - 0.3) < 0.01, "it stopped on the way across, at the height of the transit"
    assert (motion.step() == rest[-1]).all()


def test_the_way_across_is_above_what_stands_and_straight_above_its_ends() -> None:
    begin, end = ToolPose(0.4, -0.3, 0.03, 0.0), ToolPose(0.6, 0.3, 0.05, 1.0)
    knots = across(begin, end, 0.31)
    assert knots[0] == begin
    assert knots[-1] == pytest.approx(end)
    assert max(knot.z for knot in knots) == 0.31
    for knot in knots:
        if knot.z < 0.25:
            assert min(math.dist(knot[:2], begin[:2]), math.dist(knot[:2], end[:2])) < 1e-6


def test_a_motion_to_where_the_arm_is_already_is_over_at_once() -> None:
    home = np.array(HOME)
    assert Trajectory([home, home], [0.0]).is_over
    here = ARM.pose(home)
    assert follow(ARM, straight(here, here), home).end == pytest.approx(home, abs=1e-3)
