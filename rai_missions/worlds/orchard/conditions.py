# SPDX-License-Identifier: Apache-2.0
"""Light and air in the orchard: what they do to the camera's pictures, and how much worse a detector sees in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from rai_missions.worlds.options import check_numbers

__all__ = ("Conditions",)

NEAR_M = 2.0
"""What is nearer is seen through any fog."""
EXTENT_M = 12.0
"""MuJoCo's `statistic extent`, in which distances of fog are counted."""


@dataclass(frozen=True)
class Conditions:
    """Light and air; each from 0 (none of it) to 1."""

    dusk: float = 0.0
    """How little light there is; 1 is late dusk."""
    glare: float = 0.0
    """How low the sun is ahead of a tractor that drives east."""
    fog: float = 0.0
    """1: nothing is seen beyond about 10 m."""
    dust: float = 0.0
    """Brown instead of white."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | Conditions | None) -> Conditions:
        """From plain data.

        Raises:
            UsageError: A field does not exist, or its value is no number from 0 to 1.
        """
        if isinstance(options, Conditions):
            return options
        check_numbers("conditions", options or {}, {field.name: 1.0 for field in fields(cls)})
        return cls(**(options or {}))

    @property
    def thick(self) -> float:
        """How thick the air is, 0 to 1."""
        return max(self.fog, self.dust)

    @property
    def reach(self) -> str:
        """Where fog begins and ends, as attributes of MJCF."""
        if not self.thick:
            return 'fogstart="2.4" fogend="7"'
        end = 10.0 + 60.0 * (1 - self.thick) ** 2
        return f'fogstart="{NEAR_M / EXTENT_M:.3f}" fogend="{end / EXTENT_M:.3f}"'

    @property
    def marks(self) -> str:
        """What a renderer looks for in the model: whether there is fog to draw."""
        return '<custom><numeric name="fog" data="1"/></custom>' if self.thick else ""

    @property
    def sky(self) -> str:
        """The sky's two colours, as attributes of MJCF."""
        high, low = (
            " ".join(f"{v * self._light:.3f}" for v in rgb) for rgb in ((0.35, 0.58, 0.88), (0.85, 0.91, 0.96))
        )
        return f'rgb1="{high}" rgb2="{low}"'

    @property
    def headlight(self) -> str:
        ambient = " ".join(f"{v * self._light:.3f}" for v in (0.44, 0.44, 0.47))
        diffuse = f"{0.24 * self._light:.3f}"
        return f'ambient="{ambient}" diffuse="{diffuse} {diffuse} {diffuse}"'

    @property
    def sunlight(self) -> str:
        return " ".join(f"{v * self._light * (1 + 0.5 * self.glare):.3f}" for v in (0.75, 0.72, 0.64))

    @property
    def sun(self) -> str:
        """Where its light goes."""
        return f"{-0.35 - 0.6 * self.glare:.3f} {-0.45 * (1 - self.glare):.3f} {-0.8 + 0.62 * self.glare:.3f}"

    @property
    def colour(self) -> str:
        """The colour of the air, as an attribute of MJCF."""
        white, brown = (0.78, 0.86, 0.93), (0.66, 0.56, 0.42)
        mixed = brown if self.dust > self.fog else white
        return " ".join(f"{v * max(0.25, self._light):.3f}" for v in mixed) + " 1"

    @property
    def _light(self) -> float:
        return 1.0 - 0.82 * self.dusk
