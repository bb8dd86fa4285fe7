# SPDX-License-Identifier: Apache-2.0
"""Keeps the tractor on its moves: how fast to go and how to steer, from the pose alone.

The steering law is the rear-axle feedback of Samson's path following: curvature of the path, corrected by the errors of
heading and of place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rai_missions.worlds.orchard.planner import PathSegment
from rai_missions.worlds.orchard.tractor import TractorPose

__all__ = ("Follower",)

CRUISE_MPS, TURN_MPS, BACKWARDS_MPS = 1.6, 1.2, 1.2
BRAKE_MPS2 = 0.7
ARRIVED_M = 0.12
PREVIEW_S = 0.3
"""The front wheels need about so long to turn; the path's curvature is read so far ahead."""


class Follower:
    """Drives moves one after the other; those that go the same way are one line without a stop."""

    def __init__(self) -> None:
        self.moves: tuple[PathSegment, ...] = ()
        self._index = 0
        self._points = np.zeros((0, 4))
        self._left = np.zeros(0)
        self._ends: list[int] = []
        self._begun = 0

    def take(self, moves: Sequence[PathSegment]) -> None:
        """Forget what was to be driven, and drive these."""
        self.moves, self._index, self._begun = tuple(moves), 0, 0
        self._gather()

    def extend(self, moves: Sequence[PathSegment]) -> None:
        """Drive these after what is still to be driven."""
        self.moves += tuple(moves)
        self._index -= self._begun
        self._gather()

    @property
    def move(self) -> PathSegment | None:
        """The move under the rear axle."""
        return self.moves[0] if self.moves else None

    @property
    def left_m(self) -> float:
        """To the end of the present move."""
        return float(self._left[self._index] - self._left[self._ends[0]]) if self.moves else 0.0

    @property
    def distance_m(self) -> float:
        """To the end of everything."""
        return self.left_m + sum(move.length_m for move in self.moves[1:])

    def off_m(self, pose: TractorPose) -> float:
        """How far the tractor is from where it should be."""
        if not self.moves:
            return 0.0
        x, y = self._points[self._index, :2]
        return math.hypot(pose.x - x, pose.y - y)

    def rest_of_move(self) -> PathSegment | None:
        """What is left of the present move, to be driven on later."""
        if not self.moves:
            return None
        points = self._points[self._index : self._ends[0] + 1]
        return self.moves[0]._replace(
            points=points if len(points) > 1 else self._points[self._index - 1 : self._index + 1]
        )

    def step(self, pose: TractorPose) -> tuple[float, float]:
        """The speed (m/s) and curvature (1/m) to command now; speed 0 at the end of everything."""
        self._advance(pose)
        if not self.moves:
            return 0.0, 0.0
        ahead = self.moves[0].ahead
        x, y, heading, _ = self._points[self._index]
        ahead_index = min(len(self._points) - 1, self._index + round(PREVIEW_S * max(abs(pose.speed), 0.3) / 0.1))
        bend = self._points[ahead_index, 3]
        side = -math.sin(heading) * (pose.x - x) + math.cos(heading) * (pose.y - y)
        turn = math.remainder(pose.heading - heading, 2 * math.pi)
        steer = bend * math.cos(turn) / max(0.4, 1 - bend * side) - 1.6 * ahead * turn - 0.9 * _sinc(turn) * side
        return ahead * self._speed(ahead), steer

    def _speed(self, ahead: int) -> float:
        soon = self._points[self._index : self._index + 12, 3]
        top = BACKWARDS_MPS if ahead < 0 else TURN_MPS if np.any(np.abs(soon) > 0.05) else CRUISE_MPS
        return max(0.15, min(top, math.sqrt(2 * BRAKE_MPS2 * float(self._left[self._index]))))

    def _advance(self, pose: TractorPose) -> None:
        if not self.moves:
            return
        window = self._points[self._index : self._index + 15, :2]
        self._index += int(np.argmin(np.hypot(window[:, 0] - pose.x, window[:, 1] - pose.y)))
        while len(self._ends) > 1 and self._index > self._ends[0]:
            self._begun = self._ends.pop(0) + 1
            self.moves = self.moves[1:]
        if self._left[self._index] < ARRIVED_M:
            self.moves = self.moves[len(self._ends) :]
            self._index = 0
            self._gather()

    def _gather(self) -> None:
        """Make one line of the first moves that go the same way, the part already driven left in place."""
        same: list[PathSegment] = []
        for move in self.moves:
            if same and move.ahead != same[0].ahead:
                break
            same.append(move)
        self._begun = 0
        if not same:
            return
        self._points = np.concatenate([move.points for move in same])
        self._ends = (np.cumsum([len(move.points) for move in same]) - 1).tolist()
        steps = np.hypot(*np.diff(self._points[:, :2], axis=0).T)
        self._left = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if abs(angle) > 1e-6 else 1.0
