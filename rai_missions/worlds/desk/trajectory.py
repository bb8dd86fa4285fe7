# SPDX-License-Identifier: Apache-2.0
"""A path of joints and the motion along it: a spline through knots, and how fast it may be followed.

Rule: velocity, acceleration and jerk of every joint stay within their limits, also where a motion is stopped: it stops
on its path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ruckig import ControlInterface, InputParameter, OutputParameter, Result, Ruckig

from rai_missions.worlds.desk.kinematics import Joints

__all__ = ("CONTROL_S", "JERK", "PACE", "PUSH", "VELOCITY", "Trajectory")

CONTROL_S = 0.01
"""Between two set-points."""
VELOCITY = np.array([1.7, 1.7, 1.7, 1.7, 2.1, 2.1, 2.1])
PUSH = np.array([8.0, 6.0, 8.0, 8.0, 10.0, 12.0, 12.0])
JERK = np.array([150.0, 120.0, 150.0, 150.0, 200.0, 250.0, 250.0])
"""Limits of the joints, rad/s, rad/s², rad/s³: four fifths of the arm's speeds, and far less than its accelerations and
jerks, so that what is held does not slip."""
PACE = 1.0, 5.0, 60.0
"""Along a path, in seconds of its own measure a second: its rate, and two derivatives of it."""
ROUNDS = 12
"""Rounds of slowing down where a path bends, before the whole is slowed down."""


class Trajectory:
    """A motion along knots, at rest at its ends.

    Args:
        knots: Joints, in order; the first is where the arm is.
        speeds: Of each stretch between two knots: the seconds that it takes at least, when the pace is even.
    """

    def __init__(self, knots: Sequence[Joints], speeds: Sequence[float]) -> None:
        points = np.array(knots)
        stretches = np.maximum(np.array(speeds), (np.abs(np.diff(points, axis=0)) / VELOCITY).max(axis=1))
        kept = np.concatenate([[True], stretches > 1e-4])
        self._points = points[kept]
        self._lay(stretches[kept[1:]])
        for _ in range(ROUNDS):
            local = self._factors()
            if local.size == 0 or np.max(local) <= 1.05:
                break
            self._lay(np.diff(self._marks) * _widened(np.maximum(local, 1.0)))
        self._slower = max(1.0, float(np.max(self._factors(), initial=1.0)))
        self._length = float(self._marks[-1])
        self._marks_ahead = _sampled(_to_end(self._length, self._slower))
        self._ahead = self._along(self._marks_ahead[:, 0])
        self._done = 0

    @property
    def knots(self) -> list[Joints]:
        """What it goes through, its ends included."""
        return list(self._points)

    @property
    def is_over(self) -> bool:
        return self._done >= len(self._ahead)

    @property
    def end(self) -> Joints:
        """Where it leads, unless it is stopped."""
        return np.array(self._points[-1])

    def step(self) -> Joints:
        """The set-point of the next period; the last one once it is over."""
        self._done = min(self._done + 1, len(self._ahead))
        return np.array(self._ahead[self._done - 1] if self._done else self._points[0])

    def stop(self) -> None:
        """Come to rest on the path, as soon as the limits allow; it is over then."""
        if self.is_over or not self._done:
            self._ahead = self._ahead[: self._done]
            return
        self._marks_ahead = _sampled(_to_rest(self._marks_ahead[self._done - 1], self._slower))
        self._ahead = np.vstack([self._ahead[self._done - 1], self._along(self._marks_ahead[:, 0])])
        self._done = 1

    def _lay(self, stretches: NDArray[np.float64]) -> None:
        """Put the knots so far apart on the path's own measure, and the spline through them."""
        self._marks = np.concatenate([[0.0], np.cumsum(stretches)])
        self._curved = _second_derivatives(self._marks, self._points)

    def _factors(self) -> NDArray[np.float64]:
        """For each stretch, by what its time must grow so that no joint exceeds a limit with the pace of `PACE`.

        With a path q(s), q̇ = q′ṡ, q̈ = q″ṡ² + q′s̈, q⃛ = q‴ṡ³ + 3q″ṡs̈ + q′s⃛: stretched by k, they shrink by k, k², k³.
        """
        pace, push, jerk = PACE
        wide = np.diff(self._marks)[:, None]
        bent, bends = self._curved[:-1], self._curved[1:]
        chord = np.diff(self._points, axis=0) / wide
        slopes = [
            chord - wide * (2 * bent + bends) / 6,
            chord + wide * (bent - bends) / 24,
            chord + wide * (bent + 2 * bends) / 6,
        ]
        first = np.abs(slopes).max(axis=0)
        second = np.maximum(np.abs(bent), np.abs(bends))
        third = np.abs(bends - bent) / wide
        turns = (first * pace / VELOCITY).max(axis=1)
        pushes = ((second * pace**2 + first * push) / PUSH).max(axis=1) ** (1 / 2)
        jerks = ((third * pace**3 + 3 * second * pace * push + first * jerk) / JERK).max(axis=1) ** (1 / 3)
        return np.asarray(np.maximum(np.maximum(turns, pushes), jerks))

    def _along(self, marks: NDArray[np.float64]) -> NDArray[np.float64]:
        """The joints at places of the path, by its measure."""
        if self._length == 0.0:
            return np.repeat(self._points[:1], len(marks), axis=0)
        marks = np.clip(marks, 0.0, self._length)
        number = np.clip(np.searchsorted(self._marks, marks) - 1, 0, len(self._marks) - 2)
        begin, end = self._marks[number], self._marks[number + 1]
        wide, ahead, past = ((end - begin)[:, None], (end - marks)[:, None], (marks - begin)[:, None])
        low, high = self._points[number], self._points[number + 1]
        bent, bends = self._curved[number], self._curved[number + 1]
        return np.asarray(
            bent * ahead**3 / (6 * wide)
            + bends * past**3 / (6 * wide)
            + (low / wide - bent * wide / 6) * ahead
            + (high / wide - bends * wide / 6) * past
        )


def _sampled(wanted: Any) -> NDArray[np.float64]:
    """Place, speed and acceleration along the path after each period, until it is over: an array of n × 3."""
    otg, out, samples = Ruckig(1, CONTROL_S), OutputParameter(1), []
    if wanted.target_position == [0.0] and wanted.control_interface == ControlInterface.Position:
        return np.empty((0, 3))
    is_over = False
    while not is_over:
        is_over = otg.update(wanted, out) != Result.Working
        samples.append((out.new_position[0], out.new_velocity[0], out.new_acceleration[0]))
        out.pass_to_input(wanted)
    return np.array(samples)


def _to_end(length: float, slower: float) -> Any:
    """From rest at 0 to rest at the end of a path."""
    wanted = _limits(slower)
    wanted.current_position, wanted.target_position = [0.0], [length]
    return wanted


def _to_rest(moving: NDArray[np.float64], slower: float) -> Any:
    """From a motion along the path to rest, wherever that is."""
    wanted = _limits(slower)
    wanted.control_interface = ControlInterface.Velocity
    place, speed, push = moving.tolist()
    wanted.current_position, wanted.current_velocity, wanted.current_acceleration = [place], [speed], [push]
    wanted.target_velocity, wanted.target_acceleration = [0.0], [0.0]
    return wanted


def _limits(slower: float) -> Any:
    pace, push, jerk = PACE
    wanted = InputParameter(1)
    wanted.max_velocity = [pace / slower]
    wanted.max_acceleration = [push / slower**2]
    wanted.max_jerk = [jerk / slower**3]
    return wanted


def _second_derivatives(marks: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The second derivatives of the natural cubic spline through the points (Numerical Recipes, §3.3)."""
    count = len(marks)
    curved = np.zeros_like(points)
    if count < 3:
        return curved
    wide = np.diff(marks)
    slopes = np.diff(points, axis=0) / wide[:, None]
    matrix = np.diag((wide[:-1] + wide[1:]) / 3) + np.diag(wide[1:-1] / 6, 1) + np.diag(wide[1:-1] / 6, -1)
    curved[1:-1] = np.linalg.solve(matrix, np.diff(slopes, axis=0))
    return curved


def _widened(factors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each as large as its neighbours nearly are, so that the pace changes gently."""
    padded = np.concatenate([factors[:1], factors, factors[-1:]])
    return np.asarray(np.maximum(factors, 0.5 * (factors + np.maximum(padded[:-2], padded[2:]))))
