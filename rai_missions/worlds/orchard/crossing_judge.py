# SPDX-License-Identifier: Apache-2.0
"""Was the obstacle driven over? The judge who looks at the physics: contacts, lift, tilt, and where things end up.

Rule: no kind of obstacle is named here. What was pushed along was not driven over, and whatever lives must not be
touched at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from rai_missions.worlds.orchard.tractor import TAIL_M, Tractor, TractorPose

__all__ = ("STRUCK_N", "TILTED_DEG", "Crossing", "Judge", "Outcome")

Outcome = Literal["open", "passed", "failed", "left"]
PUSHED_M, TILTED_DEG, STRUCK_N, STUCK_S = 1.0, 18.0, 25_000.0, 6.0
EXTENT: Mapping[Any, Callable[[Any, Any], float]] = {
    mujoco.mjtGeom.mjGEOM_SPHERE: lambda size, axes: size[0],
    mujoco.mjtGeom.mjGEOM_CAPSULE: lambda size, axes: size[0] + size[1] * abs(axes[2]),
    mujoco.mjtGeom.mjGEOM_CYLINDER: lambda size, axes: size[1] * abs(axes[2]) + size[0] * math.hypot(axes[0], axes[1]),
    mujoco.mjtGeom.mjGEOM_BOX: lambda size, axes: float(np.abs(axes) @ size),
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: lambda size, axes: float(np.linalg.norm(axes * size)),
}
"""How far a geom reaches along a direction, given the direction in its own axes."""


@dataclass
class Crossing:
    """One obstacle that was handed over for, from the handover until it lies behind the tractor."""

    number: int | None
    """The obstacle; None: there was nothing (a false alarm)."""
    along: tuple[float, float]
    """The way that the tractor was going, a unit vector."""
    far_m: float
    """Where the obstacle ended at the handover, along that way."""
    start: tuple[float, float]
    """Where it was at the handover."""
    outcome: Outcome = "open"
    why: str = ""
    lift_m: float = 0.0
    """Of the highest wheel."""
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    contact_n: float = 0.0
    """The strongest force between the tractor and the obstacle."""
    chassis_n: float = 0.0
    """The strongest force on anything but the tyres."""
    moved_m: float = 0.0
    """How far the obstacle is from where it was at the handover."""
    stuck_s: float = 0.0
    touched_living: bool = False

    def facts(self) -> dict[str, Any]:
        """The measures, as plain data."""
        names = ("lift_m", "pitch_deg", "roll_deg", "contact_n", "chassis_n", "moved_m")
        return {"outcome": self.outcome, "why": self.why, **{name: round(getattr(self, name), 3) for name in names}}


class Judge:
    """Watches the tractor and the obstacles.

    Args:
        model: The compiled orchard.
        data: Its state.
        living: For each obstacle, whether it lives.
    """

    def __init__(self, model: Any, data: Any, tractor: Tractor, living: tuple[bool, ...]) -> None:
        self._model, self._data, self._tractor, self._living = model, data, tractor, living
        self._bodies = [model.body(f"obstacle_{number}").id for number in range(len(living))]
        of_body = {body: number for number, body in enumerate(self._bodies)}
        self._obstacle = np.array([of_body.get(int(body), -1) for body in model.geom_bodyid])
        self._tractors = np.array([model.body_rootid[body] == tractor.body_id for body in model.geom_bodyid])
        self._is_tyre = np.array([model.geom(g).name.endswith("_tyre") for g in range(model.ngeom)])
        self._geoms = [np.flatnonzero((self._obstacle == n) & (model.geom_contype > 0)) for n in range(len(living))]
        self.crossing: Crossing | None = None
        self.touched: set[int] = set()
        """The living obstacles that were touched, ever."""

    def begin(self, pose: TractorPose, distance_m: float) -> None:
        """The tractor handed over for something so far ahead of its nose."""
        along = (math.cos(pose.heading), math.sin(pose.heading))
        ahead = [n for n in range(len(self._bodies)) if self._is_ahead(n, pose, along)]
        number = min(ahead, key=lambda n: self._reach(n, along)[0], default=None)
        here = pose.x * along[0] + pose.y * along[1]
        far = here + 2.5 + distance_m + 0.5 if number is None else self._reach(number, along)[1]
        self.crossing = Crossing(number, along, far, self._place(number))

    def leave(self) -> None:
        """The tractor goes another way: the obstacle stays where it is, not passed."""
        if self.crossing is not None and self.crossing.outcome == "open":
            self.crossing.outcome = "left"

    def watch(self, pose: TractorPose, period_s: float, *, driving: bool) -> None:
        """Look at the contacts of this instant."""
        forces = self._contacts()
        touched = {number for number, _, _ in forces if self._living[number]}
        self.touched |= touched
        crossing = self.crossing
        if crossing is None or crossing.outcome != "open":
            return
        crossing.touched_living = crossing.touched_living or bool(touched)
        self._measure(crossing, forces)
        crossing.stuck_s = crossing.stuck_s + period_s if driving and abs(pose.speed) < 0.05 else 0.0
        crossing.why = self._fault(crossing)
        if crossing.why:
            crossing.outcome = "failed"
        elif self._is_behind(crossing, pose):
            crossing.outcome = "passed"

    def _contacts(self) -> list[tuple[int, bool, float]]:
        """Who touches the tractor now: the obstacle, whether a tyre touches it, and the force in N."""
        pairs = self._data.contact.geom
        if len(pairs) == 0 or not self._bodies:
            return []
        first, second = pairs[:, 0], pairs[:, 1]
        here = (self._tractors[first] & (self._obstacle[second] >= 0)) | (
            self._tractors[second] & (self._obstacle[first] >= 0)
        )
        found, force = [], np.zeros(6)
        for index in np.flatnonzero(here):
            mujoco.mj_contactForce(self._model, self._data, int(index), force)
            a, b = pairs[index]
            number = int(max(self._obstacle[a], self._obstacle[b]))
            found.append((number, bool(self._is_tyre[a] or self._is_tyre[b]), float(force[0])))
        return found

    def _measure(self, crossing: Crossing, forces: list[tuple[int, bool, float]]) -> None:
        pitch, roll = self._tractor.tilt_deg
        crossing.lift_m = max(crossing.lift_m, self._tractor.lift_m)
        crossing.pitch_deg = max(crossing.pitch_deg, abs(pitch))
        crossing.roll_deg = max(crossing.roll_deg, abs(roll))
        x, y = self._place(crossing.number)
        crossing.moved_m = math.hypot(x - crossing.start[0], y - crossing.start[1])
        for number, by_tyre, newton in forces:
            if number == crossing.number:
                crossing.contact_n = max(crossing.contact_n, newton)
                crossing.chassis_n = max(crossing.chassis_n, 0.0 if by_tyre else newton)

    def _fault(self, crossing: Crossing) -> str:
        lives = crossing.number is not None and self._living[crossing.number]
        if crossing.touched_living:
            return "touched something alive"
        if not lives and crossing.moved_m > PUSHED_M:
            return f"pushed it {crossing.moved_m:.1f} m along instead of driving over it"
        if max(crossing.pitch_deg, crossing.roll_deg) > TILTED_DEG:
            return f"tilted by {max(crossing.pitch_deg, crossing.roll_deg):.0f} degrees"
        if crossing.chassis_n > STRUCK_N:
            return f"struck the chassis with {crossing.chassis_n / 1000:.0f} kN"
        return "stuck" if crossing.stuck_s > STUCK_S else ""

    def _is_behind(self, crossing: Crossing, pose: TractorPose) -> bool:
        tail = pose.x * crossing.along[0] + pose.y * crossing.along[1] - TAIL_M
        if tail < crossing.far_m:
            return False
        if crossing.number is None or self._living[crossing.number]:
            return True
        return tail > self._reach(crossing.number, crossing.along)[1]

    def _is_ahead(self, number: int, pose: TractorPose, along: tuple[float, float]) -> bool:
        x, y = self._place(number)
        ahead = (x - pose.x) * along[0] + (y - pose.y) * along[1]
        return 0 < ahead < 14 and abs((y - pose.y) * along[0] - (x - pose.x) * along[1]) < 2.2

    def _place(self, number: int | None) -> tuple[float, float]:
        if number is None:
            return 0.0, 0.0
        x, y, _ = self._data.xpos[self._bodies[number]]
        return float(x), float(y)

    def _reach(self, number: int, along: tuple[float, float]) -> tuple[float, float]:
        """From where to where an obstacle extends along a direction."""
        way, near, far = np.array([*along, 0.0]), math.inf, -math.inf
        for geom in self._geoms[number]:
            axes = way @ self._data.geom_xmat[geom].reshape(3, 3)
            middle = float(way @ self._data.geom_xpos[geom])
            extent = EXTENT[mujoco.mjtGeom(int(self._model.geom_type[geom]))](self._model.geom_size[geom], axes)
            near, far = min(near, middle - extent), max(far, middle + extent)
        return near, far
