# SPDX-License-Identifier: Apache-2.0
"""How far from exact each relation may be: all tolerances, next to the camera's error for which they are made.

Rule: each tolerance is at least three standard deviations of what it is compared with, `hypot` of two things'.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.planning.scene import Thing

__all__ = (
    "APART", "APART_M", "AT", "BETWEEN", "CAMERA_SIGMA_M", "CONTACT", "GROUPED", "JUDGE", "LEFT_OF", "LEVEL", "NEXT_TO",
    "STRICT", "WALL_M", "contact", "fit",
)  # fmt: skip

STRICT = -2.0
"""Sigmas that a mission's guard adds to each tolerance: success is claimed with room to spare."""
JUDGE = 1.0
"""Sigmas that a judge adds, who knows the true poses and asks whether the camera could have seen it so."""

CAMERA_SIGMA_M: Mapping[str, float] = {
    "cube": 0.001, "apple": 0.003, "tomato": 0.003, "carrot": 0.005, "corn": 0.005, "tray": 0.002, "bin": 0.002,
}  # fmt: skip
"""Type → the standard deviation of a measured position in metres, for which the tolerances are made."""

AT = 0.025
"""Metres between the centre of a thing and the place that was named."""
CONTACT: Mapping[str, float] = {
    "cube": 0.01, "apple": 0.015, "tomato": 0.015, "carrot": 0.022, "corn": 0.022, "tray": 0.01, "bin": 0.01,
}  # fmt: skip
"""Type → metres of gap or overlap, up and down, which count as contact; of two things the larger."""
FIT: Mapping[str, float] = {
    "cube": 0.008, "apple": 0.012, "tomato": 0.012, "carrot": 0.018, "corn": 0.018, "tray": 0.01, "bin": 0.01,
}  # fmt: skip
"""Type → metres by which a footprint may reach beyond what it is to be inside of."""
LEFT_OF = 0.022
"""Metres by which two things may overlap along y and one still be left of the other; also the error of a gap."""
BETWEEN = 0.022
"""Metres by which a thing may reach past an end of the line between two others, or lie off that line."""
NEXT_TO = 0.07
"""Metres between the footprints of two things that are next to each other, at the most."""
GROUPED = 0.09
"""Metres between the footprints of two neighbours in a group, at the most."""
APART_M = 0.12
"""Metres between the footprints of things that are to be apart."""
APART = 0.03
"""Metres that may lack from them."""
LEVEL = 0.04
"""Metres between the undersides of two things side by side, at the most."""
WALL_M = 0.005
"""Metres: the thickness of the walls and the floor of a tray and a bin."""


def contact(*things: Thing) -> float:
    """Metres of gap or overlap between these things that count as contact."""
    return max(CONTACT[thing.type] for thing in things)


def fit(thing: Thing) -> float:
    """Metres by which a thing may reach beyond what it is to be inside of."""
    return FIT[thing.type]
