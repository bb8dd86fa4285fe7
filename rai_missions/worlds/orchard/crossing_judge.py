# SPDX-License-Identifier: Apache-2.0
"""Was the obstacle driven over? The judge who looks at the physics: contacts, lift, tilt, and where things end up.

Rule: no kind of obstacle is named here. What was pushed along was not driven over, and whatever lives must not be
touched at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from rai_missions.worlds.contact_forces import touches
from rai_missions.worlds.orchard.extents import Extents
from rai_missions.worlds.orchard.tractor import TAIL_M, Tractor, TractorPose

__all__ = ("Crossing", "CrossingJudge", "CrossingOutcome")

CrossingOutcome = Literal["open", "passed", "failed", "left"]
PUSHED_M, TILTED_DEG, STRUCK_N, STUCK_S = 1.0, 18.0, 25_000.0, 6.0


@dataclass
class Crossing:
    """One obstacle that was handed over for, from the handover until it lies behind the tractor."""

    numbers: tuple[int, ...]
    """The obstacle, and what lies in it or over it; empty: there was nothing (a false alarm)."""
    along: tuple[float, float]
    """The way that the tractor was going, a unit vector."""
    far_m: float
    """Where the obstacle ended at the handover, along that way."""
    start: tuple[tuple[float, float], ...]
    """Where each of them was at the handover."""
    outcome: CrossingOutcome = "open"
    why: str = ""
    lift_m: float = 0.0
    """Of the highest wheel."""
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    contact_n: float = 0.0
    """The strongest force between the tractor and the obstacle."""
    chassis_n: float = 0.0
    """The strongest force on anything but the tyres."""
    broke_n: float = 0.0
    """The strongest force on a thing that it breaks."""
    moved_m: float = 0.0
    """How far the obstacle is from where it was at the handover."""
    stuck_s: float = 0.0
    touched_living: bool = False

    @property
    def harmed(self) -> Literal["", "living", "thing", "tractor"]:
        """What took harm."""
        if self.touched_living:
            return "living"
        if self.broke_n:
            return "thing"
        is_hit = self.chassis_n > STRUCK_N or max(self.pitch_deg, self.roll_deg) > TILTED_DEG
        return "tractor" if is_hit else ""

    def facts(self) -> dict[str, Any]:
        """The measures, as plain data."""
        names = ("lift_m", "pitch_deg", "roll_deg", "contact_n", "chassis_n", "broke_n", "moved_m")
        return {
            "outcome": self.outcome,
            "why": self.why,
            "harmed": self.harmed,
            **{name: round(getattr(self, name), 3) for name in names},
        }


class CrossingJudge:
    """Watches the tractor and the obstacles.

    Args:
        model: The compiled orchard.
        data: Its state.
        tractor: Whose contacts, lift and tilt are measured.
        living: For each obstacle, whether it lives.
        limits_n: For each obstacle, the force that breaks it (N), or None.
    """

    def __init__(
        self, model: Any, data: Any, tractor: Tractor, living: tuple[bool, ...], limits_n: tuple[float | None, ...]
    ) -> None:
        self._model, self._data, self._tractor, self._living = model, data, tractor, living
        self._limits_n = limits_n
        self._bodies = [model.body(f"obstacle_{number}").id for number in range(len(living))]
        of_body = {body: number for number, body in enumerate(self._bodies)}
        self._obstacle = np.array([of_body.get(int(body), -1) for body in model.geom_bodyid])
        self._tractors = np.array([model.body_rootid[body] == tractor.body_id for body in model.geom_bodyid])
        self._is_tyre = np.array([model.geom(g).name.endswith("_tyre") for g in range(model.ngeom)])
        self._extents = Extents(model, data, self._bodies)
        self.crossing: Crossing | None = None
        self.touched: set[int] = set()
        """The living obstacles that were touched, ever."""
        self.broken: dict[int, float] = {}
        """The things that were broken, ever, and the strongest force on each (N)."""

    def begin(self, pose: TractorPose, distance_m: float) -> None:
        """The tractor handed over for something so far ahead of its nose."""
        along = (math.cos(pose.heading), math.sin(pose.heading))
        ahead = [n for n in range(len(self._bodies)) if self._is_ahead(n, pose, along)]
        reaches = {number: self._extents.reach(number, along) for number in ahead}
        first = min(reaches.values(), default=None)
        together = tuple(n for n, (near, _) in reaches.items() if first is not None and near <= first[1])
        here = pose.x * along[0] + pose.y * along[1]
        far = max((reaches[n][1] for n in together), default=here + 2.5 + distance_m + 0.5)
        self.crossing = Crossing(together, along, far, tuple(self._place(n) for n in together))

    def leave(self) -> None:
        """The tractor goes another way: the obstacle stays where it is, not passed."""
        if self.crossing is not None and self.crossing.outcome == "open":
            self.crossing.outcome = "left"

    def watch(self, pose: TractorPose, period_s: float, *, driving: bool) -> None:
        """Look at the contacts of this instant."""
        forces = self._contacts()
        touched = {number for number, _, _ in forces if self._living[number]}
        self.touched |= touched
        self._note_broken(forces)
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

    def _note_broken(self, forces: list[tuple[int, bool, float]]) -> None:
        for number, _, newton in forces:
            limit = self._limits_n[number]
            if limit is not None and newton > limit:
                self.broken[number] = max(newton, self.broken.get(number, 0.0))

    def _contacts(self) -> list[tuple[int, bool, float]]:
        """Who touches the tractor now: the obstacle, whether a tyre touches it, and the force in N."""
        if not self._bodies:
            return []
        found = touches(self._model, self._data, self._tractors, self._obstacle >= 0)
        return [(int(self._obstacle[one.theirs]), bool(self._is_tyre[one.ours]), one.newton) for one in found]

    def _measure(self, crossing: Crossing, forces: list[tuple[int, bool, float]]) -> None:
        pitch, roll = self._tractor.tilt_deg
        crossing.lift_m = max(crossing.lift_m, self._tractor.lift_m)
        crossing.pitch_deg = max(crossing.pitch_deg, abs(pitch))
        crossing.roll_deg = max(crossing.roll_deg, abs(roll))
        crossing.moved_m = max(
            (
                math.dist(self._place(n), start)
                for n, start in zip(crossing.numbers, crossing.start, strict=True)
                if not self._living[n]
            ),
            default=0.0,
        )
        crossing.broke_n = max((self.broken.get(number, 0.0) for number in crossing.numbers), default=0.0)
        for number, by_tyre, newton in forces:
            if number in crossing.numbers:
                crossing.contact_n = max(crossing.contact_n, newton)
                crossing.chassis_n = max(crossing.chassis_n, 0.0 if by_tyre else newton)

    def _fault(self, crossing: Crossing) -> str:
        if crossing.touched_living:
            return "touched something alive"
        if crossing.broke_n:
            return f"broke it with {crossing.broke_n / 1000:.1f} kN"
        if crossing.moved_m > PUSHED_M:
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
        still = (n for n in crossing.numbers if not self._living[n])
        return all(tail > self._extents.reach(n, crossing.along)[1] for n in still)

    def _is_ahead(self, number: int, pose: TractorPose, along: tuple[float, float]) -> bool:
        x, y = self._place(number)
        ahead = (x - pose.x) * along[0] + (y - pose.y) * along[1]
        return 0 < ahead < 14 and abs((y - pose.y) * along[0] - (x - pose.x) * along[1]) < 2.2

    def _place(self, number: int) -> tuple[float, float]:
        x, y, _ = self._data.xpos[self._bodies[number]]
        return float(x), float(y)
