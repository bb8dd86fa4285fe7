# SPDX-License-Identifier: Apache-2.0
"""The battery: what the drive and the rest of a robot take from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.plain_data import is_number
from rai_missions.redaction import cut_repr
from rai_missions.worlds.options import check_names

__all__ = ("Battery",)

EFFICIENCY = 0.85
"""The share of the battery's power that reaches the wheels."""


class Battery:
    """Energy left, from the work of the wheels.

    Args:
        capacity_wh: Small by default, so that a short run shows.
        charge: At the start, 0 to 1.
        rest_w: What everything but the drive takes.
        volts: Empty and full.
    """

    def __init__(
        self,
        capacity_wh: float = 800.0,
        charge: float = 1.0,
        *,
        rest_w: float = 400.0,
        volts: tuple[float, float] = (44.0, 54.0),
    ) -> None:
        self._rest_w, self._volts = rest_w, volts
        self._capacity_j = capacity_wh * 3600.0
        self._left_j = self._capacity_j * min(1.0, max(0.0, charge))

    @classmethod
    def of(cls, options: Mapping[str, Any] | None, **ours: Any) -> Battery:
        """From plain data, which goes before the world's own words; a `UsageError` names what does not exist."""
        check_names("battery", options or {}, ("capacity_wh", "charge"), called="option")
        for name, value in (options or {}).items():
            if not is_number(value):
                raise UsageError(f"battery: {name} takes a finite number, not {cut_repr(value, 60)}")
        return cls(**{**ours, **(options or {})})

    def drain(self, drive_w: float, period_s: float) -> None:
        self._left_j = max(0.0, self._left_j - (self._rest_w + drive_w / EFFICIENCY) * period_s)

    def charge(self, power_w: float, period_s: float) -> None:
        self._left_j = min(self._capacity_j, self._left_j + power_w * period_s)

    @property
    def percentage(self) -> float:
        """0 to 1, as sensor_msgs/msg/BatteryState has it."""
        return self._left_j / self._capacity_j

    @property
    def voltage(self) -> float:
        empty, full = self._volts
        return empty + (full - empty) * self.percentage

    @property
    def is_empty(self) -> bool:
        return self._left_j <= 0.0
