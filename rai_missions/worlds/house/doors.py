# SPDX-License-Identifier: Apache-2.0
"""The crates that are in doorways, and when."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.worlds.house.layout import CRATE, DOORS
from rai_missions.worlds.house.scene import AWAY_Z, crate
from rai_missions.worlds.options import check_names

__all__ = ("Blocked", "Doors")

Blocked = Sequence[str] | Mapping[str, Sequence[float]]
"""Doors that are blocked all the time, or each with the seconds from and until, once or several times."""
WITHIN_M = 1.5
"""How near a person must be to a crate to carry it away."""
ROOM_M = 0.8
"""No one puts a crate onto the robot: it waits until the robot is so far away."""


class Doors:
    """Blocks and frees doorways.

    Args:
        model: The compiled house.
        data: Its state.
        blocked: As a world's options have it.

    Raises:
        UsageError: No such door, or no time in which it is blocked.
    """

    def __init__(self, model: Any, data: Any, blocked: Blocked) -> None:
        self._data = data
        self._mocap = {door: model.body_mocapid[model.body(crate(door)).id] for door in DOORS}
        self._times = dict(blocked.items() if isinstance(blocked, Mapping) else ((door, ()) for door in blocked))
        check_names("blocked", self._times, DOORS, called="door")
        for door, times in self._times.items():
            if len(times) % 2 or list(times) != sorted(times):
                sentence = "is not when it begins and ends, as in [20, 60] or [20, 60, 90, 120]"
                raise UsageError(f"blocked: {door}: {list(times)} {sentence}")
        self._wanted: dict[str, bool] = {}

    def set(self, door: str, is_blocked: bool) -> None:
        """Block or free a door from now on, whatever its times state."""
        self._wanted[door] = is_blocked

    def clear_near(self, person: tuple[float, float]) -> None:
        """Have a person carry away the crates within reach; it is done at once."""
        for door, place in DOORS.items():
            if self.is_blocked(door) and math.dist(place, person) <= WITHIN_M:
                self.set(door, False)

    def is_blocked(self, door: str) -> bool:
        """Whether its crate stands there now."""
        return bool(self._data.mocap_pos[self._mocap[door]][2] > 0)

    @property
    def blocked(self) -> list[tuple[float, float]]:
        """The doorways that a crate is in now."""
        return [place for door, place in DOORS.items() if self.is_blocked(door)]

    def step(self, at: float, robot: tuple[float, float]) -> None:
        for door, place in DOORS.items():
            wanted = self._wanted.get(door, self._is_due(door, at))
            if wanted and not self.is_blocked(door) and math.dist(place, robot) > ROOM_M:
                self._data.mocap_pos[self._mocap[door]][2] = CRATE[2]
            elif not wanted:
                self._data.mocap_pos[self._mocap[door]][2] = AWAY_Z

    def _is_due(self, door: str, at: float) -> bool:
        times = self._times.get(door)
        if times is None:
            return False
        return not times or any(begins <= at < ends for begins, ends in zip(times[::2], times[1::2], strict=True))
