# SPDX-License-Identifier: Apache-2.0
"""The pose of a thing of known shape, from its outlines in several pictures and the depth inside of them.

Rule: only what the pixels show counts. Where the outline borders on something nearer, the thing may continue behind
it, so there a fitted shape may reach beyond the outline, but never fall short of it.
Rule: poses are x, y, z and yaw, one a line; what is asked of several is asked at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.camera import Frame, Sight
from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.posture import about_z
from rai_missions.worlds.desk.shapes import corners, outside_m

__all__ = ("ContourInFrame", "Fit", "fit", "outline", "project")

Points = NDArray[np.float64]
DIRECTIONS = 24
TURNS = np.arange(DIRECTIONS) * 2 * math.pi / DIRECTIONS
WAYS: Points = np.stack([np.cos(TURNS), np.sin(TURNS)])
"""Directions in the picture: right and down."""
FEWEST_PIXELS = 60
EDGE_PX = 0.4
"""How far an outline reaches beyond the middle of its last pixel, on average."""
NEARER_M = 0.004
"""What borders on the outline and is no farther behind it hides the thing, or touches it."""
SAMPLES = 60
"""Points a picture whose depth counts."""
SIGMA_PX, SIGMA_DEPTH_M = 0.4, 0.004
HUBER = 2.5
"""Residuals of so many sigmas count in full, and larger ones less."""
ROUNDS, SETTLED = 8, 1e-5
STEPS = np.array([1e-4, 1e-4, 1e-4, 1e-3])
"""The steps of the numerical derivatives: x, y, z in m, yaw in rad."""
ASIDE: Points = np.concatenate([np.zeros((1, 4)), np.diag(STEPS)])
WEAK = 1e-3
"""Keeps the equations solvable where nothing is known of a coordinate."""


class ContourInFrame(NamedTuple):
    """A thing in one picture."""

    sight: Sight
    size: tuple[int, int]
    """Height and width of the picture."""
    reach: Points
    """How far it reaches in each of the directions, pixels."""
    is_edge: NDArray[np.bool_]
    """Whether that is its own edge, not the edge of something in front of it."""
    points: Points
    """Some of what is seen of it, m."""
    top_m: float
    """How high that is, but for its highest points."""


class Fit(NamedTuple):
    """A pose, and how well it explains the outlines."""

    x: float
    y: float
    z: float
    yaw: float
    residual_px: float
    """Median of the outlines' residuals: one direction in which another thing is in the way does not matter."""
    gap_m: float
    """What is seen is so far from the shape's surface, four in five points are nearer; more than noise: it leans."""
    spread_m: float
    """How far the pose could shift and explain the outlines as well: much where little of it is in sight."""


def outline(frame: Frame, sight: Sight, body: int, world: Sequence[int]) -> ContourInFrame | None:
    """A body's outline in a frame; None where too little of it is in sight.

    Args:
        frame: Depth and bodies.
        sight: Where the camera was.
        body: Of the model.
        world: Bodies that things are in front of, never behind: the desk.
    """
    lines, columns = np.nonzero(frame.body == body)
    if len(lines) < FEWEST_PIXELS:
        return None
    pixels = np.stack([columns + 0.5, lines + 0.5], 1)
    along = pixels @ WAYS
    last = np.argmax(along, axis=0)
    reach = along[last, np.arange(DIRECTIONS)] + EDGE_PX
    height, width = frame.body.shape
    beyond = np.floor(pixels[last] + 2.0 * WAYS.T).astype(int)
    inside = (beyond[:, 0] >= 0) & (beyond[:, 0] < width) & (beyond[:, 1] >= 0) & (beyond[:, 1] < height)
    u, v = np.clip(beyond[:, 0], 0, width - 1), np.clip(beyond[:, 1], 0, height - 1)
    own = frame.depth_m[lines[last], columns[last]]
    is_behind = np.isin(frame.body[v, u], world) | (frame.depth_m[v, u] > own + NEARER_M)
    some = np.linspace(0, len(lines) - 1, min(SAMPLES, len(lines))).astype(int)
    depth = frame.depth_m[lines[some], columns[some]].astype(float)
    points = unproject(pixels[some], depth, sight, (height, width))
    top_m = float(np.quantile(points[:, 2], 0.97))
    return ContourInFrame(sight, (height, width), reach, inside & is_behind, points, top_m)


def unproject(pixels: Points, depth: Points, sight: Sight, size: tuple[int, int]) -> Points:
    """Points in the world of pixels (right, down) and their depth."""
    height, width = size
    right = (pixels[:, 0] - width / 2) / sight.focal_px * depth
    up = -(pixels[:, 1] - height / 2) / sight.focal_px * depth
    return sight.position + np.stack([right, up, -depth], 1) @ sight.axes.T


def project(points: Points, sight: Sight, size: tuple[int, int]) -> tuple[Points, Points]:
    """Pixels (right, down) of points in the world, and their depth."""
    height, width = size
    local = (points - sight.position) @ sight.axes
    depth = -local[..., 2]
    right, down = local[..., 0] / depth * sight.focal_px, -local[..., 1] / depth * sight.focal_px
    return np.stack([right + width / 2, down + height / 2], -1), depth


def fit(kind: str, outlines: Sequence[ContourInFrame]) -> Fit:
    """The pose of a thing of a kind that explains its outlines best.

    Args:
        kind: Of `KINDS`; it lies upright, turned about z alone.
        outlines: At least one.
    """
    seen = np.concatenate([each.points for each in outlines])
    low, high = np.quantile(seen, (0.05, 0.95), axis=0)
    middle = (low + high) / 2
    middle[2] = high[2] - KINDS[kind].size[2] / 2
    turns = KINDS[kind].turns
    middles = [middle]
    if kind == "cube":  # of which one face may be all that is seen: it is behind that
        back = seen.mean(axis=0) - outlines[0].sight.position
        middles.append(middle + np.array([*back[:2], 0.0]) / np.hypot(*back[:2]) * KINDS[kind].size[0] / 2)
    found = []
    for start in middles:
        ranked = _ranked(kind, np.array([[*start, yaw] for yaw in _yaws(turns)]), outlines)
        first = ranked[0]
        other_ways = [each for each in ranked if math.cos(each[3] - first[3]) < 0][:1] if turns == 1 else []
        found += [_settled(kind, each, outlines) for each in (first, *other_ways)]
    pose = _ranked(kind, np.array(found), outlines)[0]
    spread = np.linalg.inv(_normal(kind, pose, outlines, 3)[0])
    edges = np.concatenate([_edges(kind, pose[None], each)[0] for each in outlines])
    x, y, z, yaw = map(float, pose)
    depths = np.concatenate([_depths(kind, pose[None], each)[0] for each in outlines])
    gap = 0.0 if KINDS[kind].is_container else float(np.quantile(np.abs(depths), 0.8)) * SIGMA_DEPTH_M
    return Fit(x, y, z, yaw, float(np.median(np.abs(edges))) * SIGMA_PX, gap, float(np.sqrt(np.max(spread.diagonal()))))


def _settled(kind: str, pose: Points, outlines: Sequence[ContourInFrame]) -> Points:
    free = 3 if KINDS[kind].turns == 0 else 4
    for _ in range(ROUNDS):
        pose, moved = _improved(kind, pose, outlines, free)
        if moved < SETTLED:
            break
    return pose


def _yaws(turns: int) -> Points:
    """Where the search for the yaw begins: a few degrees apart within what looks different."""
    if turns == 0:
        return np.zeros(1)
    whole = 2 * math.pi / turns
    count = {4: 8, 2: 12, 1: 24}[turns]
    return np.arange(count) * whole / count


def _improved(kind: str, pose: Points, outlines: Sequence[ContourInFrame], free: int) -> tuple[Points, float]:
    normal, slope = _normal(kind, pose, outlines, free)
    change = np.linalg.solve(normal, -slope)
    change[:3] = np.clip(change[:3], -0.03, 0.03)
    change[3:] = np.clip(change[3:], -0.3, 0.3)
    moved = pose.copy()
    moved[:free] += change
    return moved, float(np.abs(change).max())


def _normal(kind: str, pose: Points, outlines: Sequence[ContourInFrame], free: int) -> tuple[Points, Points]:
    """The normal equations at a pose: their matrix, and the slope of the cost."""
    found = _residuals(kind, pose + ASIDE[: 1 + free], outlines)
    here, slopes = found[0], ((found[1:] - found[0]) / STEPS[:free, None]).T
    weights = np.minimum(1.0, HUBER / np.maximum(np.abs(here), 1e-9))
    weighted = slopes * weights[:, None]
    return weighted.T @ slopes + np.eye(free) * WEAK, weighted.T @ here


def _ranked(kind: str, poses: Points, outlines: Sequence[ContourInFrame]) -> Points:
    """Poses in the order of their cost."""
    apart = np.abs(_residuals(kind, poses, outlines))
    costs = np.sum(np.where(apart < HUBER, apart**2, 2 * HUBER * apart - HUBER**2), axis=1)
    ranked: Points = poses[np.argsort(costs, kind="stable")]
    return ranked


def _residuals(kind: str, poses: Points, outlines: Sequence[ContourInFrame]) -> Points:
    parts = [part for each in outlines for part in (_edges(kind, poses, each), _depths(kind, poses, each))]
    return np.concatenate(parts, axis=1)


def _edges(kind: str, poses: Points, seen: ContourInFrame) -> Points:
    """How much farther than the shape the outline reaches, a pose and direction, in sigmas."""
    pixels, _ = project(corners(kind) @ _turns(poses).mT + poses[:, None, :3], seen.sight, seen.size)
    short = seen.reach - np.max(pixels @ WAYS, axis=1)
    counted: Points = np.where(seen.is_edge, short, np.maximum(short, 0.0)) / SIGMA_PX
    return counted


def _depths(kind: str, poses: Points, seen: ContourInFrame) -> Points:
    """How far what is seen is from the shape's surface, a pose and point, in sigmas of the mean over a picture."""
    turns, places = _turns(poses), poses[:, None, :3]
    outside = outside_m(kind, (seen.points - places) @ turns, (seen.sight.position - places) @ turns)
    if outside is None:
        return (seen.top_m - KINDS[kind].size[2] / 2 - poses[:, 2:3]) / 0.001
    return np.clip(outside, -0.02, 0.02) / SIGMA_DEPTH_M


def _turns(poses: Points) -> Points:
    return np.array([about_z(yaw) for yaw in poses[:, 3]])
