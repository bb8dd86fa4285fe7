# SPDX-License-Identifier: Apache-2.0
"""How a reader with a colour blindness sees a colour, and how far two colours are apart.

The matrices are those of Machado, Oliveira and Fernandes (IEEE TVCG 15(6), 2009) for a complete loss; the distance is
that of CIE 1976 L*a*b*, under D65.
"""

from __future__ import annotations

import math

__all__ = ("BLINDNESSES", "distance", "seen")

Triple = tuple[float, float, float]
Matrix = tuple[Triple, Triple, Triple]

BLINDNESSES: dict[str, Matrix] = {
    "none": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "protanopia": (
        (0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998),
    ),
    "deuteranopia": (
        (0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881),
    ),
    "tritanopia": (
        (1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900),
    ),
}  # fmt: skip
XYZ: Matrix = ((0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041))
WHITE: Triple = (0.95047, 1.0, 1.08883)


def seen(colour: str, blindness: str) -> Triple:
    """`#rrggbb` as L*a*b* of what such a reader sees."""
    plain = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
    light = tuple(each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in plain)
    left = tuple(min(1.0, max(0.0, each)) for each in _times(BLINDNESSES[blindness], light))
    x, y, z = (_root(each / white) for each, white in zip(_times(XYZ, left), WHITE, strict=True))
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


def distance(one: str, other: str, blindness: str) -> float:
    """2.3 is what a trained eye can just report, side by side."""
    return math.dist(seen(one, blindness), seen(other, blindness))


def _times(matrix: Matrix, vector: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix)


def _root(value: float) -> float:
    return math.cbrt(value) if value > 216 / 24389 else (value * 24389 / 27 + 16) / 116
