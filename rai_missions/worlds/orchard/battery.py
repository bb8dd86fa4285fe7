# SPDX-License-Identifier: Apache-2.0
"""The battery: what the drive and the rest of the tractor take from it."""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.errors import UsageError

__all__ = ("Battery",)

AT_REST_W, EFFICIENCY = 400.0, 0.85
EMPTY_V, FULL_V = 44.0, 54.0


class Battery:
    """Energy left, from the work of the wheels.

    Args:
        capacity_wh: Small by default, so that a short run shows.
        charge: At the start, 0 to 1.
    """

    def __init__(self, capacity_wh: float = 800.0, charge: float = 1.0) -> None:
        self._capacity_j = capacity_wh * 3600.0
        self._left_j = self._capacity_j * min(1.0, max(0.0, charge))

    @classmethod
    def of(cls, options: Mapping[str, float] | None) -> Battery:
        """From plain data; a `UsageError` names what does not exist."""
        unknown = sorted(set(options or {}) - {"capacity_wh", "charge"})
        if unknown:
            raise UsageError(f"battery: no option {unknown[0]!r}; there are: capacity_wh, charge")
        return cls(**(options or {}))

    def drain(self, drive_w: float, period_s: float) -> None:
        self._left_j = max(0.0, self._left_j - (AT_REST_W + drive_w / EFFICIENCY) * period_s)

    @property
    def percentage(self) -> float:
        """0 to 1, as sensor_msgs/msg/BatteryState has it."""
        return self._left_j / self._capacity_j

    @property
    def voltage(self) -> float:
        return EMPTY_V + (FULL_V - EMPTY_V) * self.percentage

    @property
    def is_empty(self) -> bool:
        return self._left_j <= 0.0
