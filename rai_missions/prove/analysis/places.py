# SPDX-License-Identifier: Apache-2.0
"""Places that one reading of the robot is near to or far from: a delivery's home, its shelf and its door.

Rule: only where it is near each of them counts. Where that represents all that guards can find out, a proof holds
wherever the places are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

from rai_missions.guards.near import distance

__all__ = ("AXES", "Places", "are_apart")

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Places:
    """A reading, and the arguments that it is compared with by a distance each: as many as there are axes, at the most.

    A place is on each axis, at its distance from the origin. So the sign of the reading's coordinate there decides
    whether it is near, whatever its other coordinates are: half of the least distance keeps to its side of each sphere.
    """

    reading: str
    within_m: Mapping[str, float]
    """Argument → the distance."""

    def poses(self, path: str, frame: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        """What the reading can be, or an argument, or a key that is set from arguments."""
        origin = {"x": 0.0, "y": 0.0, **frame}
        if path == self.reading:
            half_m = min(self.within_m.values()) / 2
            for signs in product((1, -1), repeat=len(self.within_m)):
                yield origin | {axis: sign * half_m for axis, sign in zip(AXES, signs, strict=False)}
        for axis, (given, within_m) in zip(AXES, self.within_m.items(), strict=False):
            if path == given or path not in (self.reading, *self.within_m):
                yield origin | {axis: within_m}


def are_apart(poses: list[Any], within_m: float) -> bool:
    """Whether no pose is near two of them, but for two that are one."""
    metres = [distance(one, other) for one, other in combinations(poses, 2)]
    return all(each is not None and (each == 0 or each > 2 * within_m) for each in metres)
