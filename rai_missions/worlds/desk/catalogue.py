# SPDX-License-Identifier: Apache-2.0
"""The things of a desk: how large they are, what they look like, and how they touch.

Rule: lengths are metres; the origin of a thing is the middle of its `size`, and its long axis is x.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import chain, count
from typing import NamedTuple

import numpy as np

from rai_missions.worlds.meshes import Mesh
from rai_missions.worlds.open_set_detector import ObjectClass

__all__ = (
    "CARROT", "COLOURS", "CORN", "CORN_HUSK", "KINDS", "WALL_M", "Kind", "Profile", "assets", "body",
    "carrot_leaves", "free_name", "lookalikes",
)  # fmt: skip

CUBE_M = 0.044
COLOURS: Mapping[str, str] = {
    "red": ".85 .1 .1", "green": ".1 .62 .2", "blue": ".12 .25 .85", "yellow": ".95 .8 .1", "orange": ".95 .48 .08",
    "purple": ".5 .2 .7", "white": ".92 .92 .9", "black": ".12 .12 .13",
}  # fmt: skip
"""Colours of cubes → red, green and blue, 0 to 1."""
SEEN = 'group="2" contype="0" conaffinity="0" mass="0"'
SOLID, HIDDEN = 'group="1"', 'group="3"'
FLAT = 'friction="1.2 .01 .001" condim="4" solref=".006 1"'
ROUND = 'friction="1.2 .02 .003" condim="6" solref=".006 1"'
"""A round thing rolls to a stop."""
WALL_M = 0.005
Profile = tuple[tuple[float, float], ...]
"""The profile of a body of revolution about x: pairs of x and radius."""
CARROT: Profile = (
    (-0.07, 0.004), (-0.068, 0.013), (-0.06, 0.018), (-0.03, 0.0185), (0.0, 0.0165), (0.03, 0.013), (0.055, 0.0095),
    (0.067, 0.005), (0.07, 0.0005),
)  # fmt: skip
CORN: Profile = ((-0.08, 0.0005), (-0.076, 0.008), (-0.06, 0.016), (-0.03, 0.021), (0.0, 0.022), (0.05, 0.0205))
CORN_HUSK: Profile = ((0.015, 0.0225), (0.035, 0.0235), (0.055, 0.02), (0.07, 0.012), (0.08, 0.0005))


class Kind(NamedTuple):
    """One kind of thing."""

    size: tuple[float, float, float]
    """Extents along its own axes, m."""
    turns: int
    """How many turns about z make it look the same in a full one; 0: all do."""
    geoms: str
    """MJCF with `{colour}`."""
    is_container: bool = False
    has_colours: bool = False
    """It comes in the colours of `COLOURS`, and is named by them."""


def _container(size: tuple[float, float, float], rgba: str, mass: float) -> str:
    x, y, z = (side / 2 for side in size)
    wall = WALL_M / 2
    boxes = (
        ((0.0, 0.0, -z + wall), (x, y, wall)),
        *(((side * (x - wall), 0.0, 0.0), (wall, y, z)) for side in (-1, 1)),
        *(((0.0, side * (y - wall), 0.0), (x, wall, z)) for side in (-1, 1)),
    )
    touch = f'mass="{mass / 5}" {SOLID} {FLAT}'
    return "".join(
        f'<geom type="box" pos="{_numbers(at)}" size="{_numbers(half)}" rgba="{rgba}" {touch}/>' for at, half in boxes
    )


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.4f}" for value in values)


TRAY, BIN = (0.30, 0.20, 0.03), (0.18, 0.18, 0.10)
HALF = CUBE_M / 2
KINDS: Mapping[str, Kind] = {
    "cube": Kind(
        (CUBE_M, CUBE_M, CUBE_M),
        4,
        f'<geom type="box" size="{HALF} {HALF} {HALF}" rgba="{{colour}} 1" mass=".06" {SOLID} {FLAT}/>',
        has_colours=True,
    ),
    "apple": Kind(
        (0.068, 0.068, 0.064),
        0,
        f'<geom type="ellipsoid" size=".034 .034 .032" rgba=".5 .72 .13 1" mass=".12" {SOLID} {ROUND}/>'
        f'<geom type="capsule" fromto="0 0 .028 .004 0 .042" size=".002" rgba=".35 .22 .1 1" {SEEN}/>'
        f'<geom type="ellipsoid" pos=".012 0 .037" euler="0 -.35 0" size=".011 .006 .001" rgba=".15 .45 .1 1" {SEEN}/>',
    ),
    "tomato": Kind(
        (0.064, 0.064, 0.054),
        0,
        f'<geom type="ellipsoid" size=".032 .032 .027" rgba=".84 .12 .07 1" mass=".08" {SOLID} {ROUND}/>'
        + "".join(
            f'<geom type="ellipsoid" pos="{0.011 * np.cos(turn):.4f} {0.011 * np.sin(turn):.4f} .0252" '
            f'xyaxes="{np.cos(turn):.3f} {np.sin(turn):.3f} -.31 {-np.sin(turn):.3f} {np.cos(turn):.3f} 0" '
            f'size=".012 .004 .0015" rgba=".1 .42 .1 1" {SEEN}/>'
            for turn in np.arange(5) * 2 * np.pi / 5
        ),
    ),
    "carrot": Kind(
        (0.14, 0.04, 0.04),
        1,
        f'<geom type="capsule" fromto="-.052 0 0 0 0 0" size=".018" mass=".05" {HIDDEN} {ROUND}/>'
        f'<geom type="capsule" fromto="0 0 0 .06 0 0" size=".011" mass=".02" {HIDDEN} {ROUND}/>'
        f'<geom type="mesh" mesh="carrot" rgba=".93 .45 .08 1" {SEEN}/>'
        f'<geom type="mesh" mesh="carrot_leaves" rgba=".16 .5 .13 1" {SEEN}/>',
    ),
    "corn": Kind(
        (0.16, 0.044, 0.044),
        2,
        f'<geom type="capsule" fromto="-.056 0 0 .056 0 0" size=".022" mass=".1" {HIDDEN} {ROUND}/>'
        f'<geom type="mesh" mesh="corn" rgba=".95 .78 .2 1" {SEEN}/>'
        f'<geom type="mesh" mesh="corn_husk" rgba=".42 .62 .22 1" {SEEN}/>',
    ),
    "tray": Kind(TRAY, 2, _container(TRAY, ".55 .58 .62 1", 0.6), is_container=True),
    "bin": Kind(BIN, 4, _container(BIN, ".2 .32 .38 1", 0.8), is_container=True),
}
LOOKALIKES: Mapping[str, tuple[str, ...]] = {
    "apple": ("tomato",), "tomato": ("apple",), "carrot": ("corn",), "corn": ("carrot",), "tray": ("bin",),
    "bin": ("tray",), "red": ("orange", "purple"), "orange": ("red", "yellow"), "yellow": ("orange", "white"),
    "green": ("blue",), "blue": ("purple", "green"), "purple": ("blue", "red"), "white": ("yellow",),
    "black": ("blue", "purple"),
}  # fmt: skip
"""Kinds and colours → what each is taken for when it is taken for something else."""


def free_name(kind: str, colour: str, taken: Collection[str]) -> str:
    """The name of one more thing of a class: `red_cube` or `apple`, or `red_cube_2` where that is taken."""
    stem = f"{colour}_{kind}" if colour else kind
    numbered = (f"{stem}_{number}" for number in count(2))
    return next(name for name in chain([stem], numbered) if name not in taken)


def lookalikes(thing: ObjectClass) -> list[ObjectClass]:
    """The classes that a thing may be taken for: another kind, or the same kind in another colour."""
    if KINDS[thing.kind].has_colours:
        return [ObjectClass(thing.kind, other) for other in LOOKALIKES[thing.colour]]
    return [ObjectClass(other, "") for other in LOOKALIKES[thing.kind]]


def body(name: str, kind: str, colour: str) -> str:
    """The MJCF of one thing that moves freely; it has the mass and the contacts of its kind."""
    geoms = KINDS[kind].geoms.replace("{colour}", COLOURS.get(colour, ".5 .5 .5"))
    return f'<body name="{name}"><freejoint name="{name}"/>{geoms}</body>'


def assets() -> tuple[str, dict[str, bytes]]:
    """The meshes: MJCF for `<asset>`, and the files by name."""
    meshes = {
        "carrot": _spun(CARROT),
        "carrot_leaves": carrot_leaves(),
        "corn": _spun(CORN),
        "corn_husk": _spun(CORN_HUSK),
    }
    listed = "".join(f'<mesh name="{name}" file="{name}.obj"/>' for name in meshes)
    return listed, {f"{name}.obj": mesh.obj() for name, mesh in meshes.items()}


def _spun(profile: Profile) -> Mesh:
    return Mesh().tube([[x, 0, 0] for x, _ in profile], [radius for _, radius in profile], 16)


def carrot_leaves() -> Mesh:
    """The green of a carrot: eight stalks that spread behind its thick end."""
    mesh = Mesh()
    for turn in np.arange(8) * 2 * np.pi / 8:
        out = np.array([0.0, np.cos(turn), np.sin(turn) * 0.6])
        spine = [
            np.array([-0.067 - 0.045 * step, 0.0, 0.0]) + out * 0.016 * step**1.5 for step in (0.0, 0.33, 0.66, 1.0)
        ]
        mesh.tube([point.tolist() for point in spine], [0.0035, 0.0028, 0.0022, 0.001], 5)
    return mesh
