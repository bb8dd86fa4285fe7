# SPDX-License-Identifier: Apache-2.0
"""The things of a household as MuJoCo geoms: what they look like, and which of them the lidar meets.

Rule: geoms of group 1 are met by the lidar and by the robot; those of group 2 are only seen; those of group 4 are met
by the robot and by the rays of its depth camera, since the lidar looks over them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rai_missions.worlds.person import person_meshes

__all__ = ("COLOURS", "FIGURES", "LOOKALIKES", "Figure", "figure", "person", "person_assets")

SEEN = 'contype="0" conaffinity="0" group="2"'
SOLID = 'group="1"'
LOW = 'group="4"'
COLOURS: Mapping[str, str] = {
    "red": ".8 .1 .1", "green": ".1 .5 .2", "blue": ".1 .2 .7", "yellow": ".9 .75 .1", "white": ".93 .93 .9",
    "brown": ".45 .28 .15",
}  # fmt: skip
"""Names of colours → red, green and blue, 0 to 1."""


class Figure(NamedTuple):
    """One kind of thing."""

    geoms: str
    """MJCF with `{colour}`; the origin is where it touches what it is on."""
    colours: tuple[str, ...]
    """What it may have, the usual one first."""
    on_floor: bool = False
    """Its place is the floor, not furniture."""


LEGS = "".join(
    f'<geom type="cylinder" pos="{x} {y} .22" size=".022 .22" rgba="{{colour}} 1" {SOLID}/>'
    for x in (-0.17, 0.17)
    for y in (-0.17, 0.17)
)
FIGURES: Mapping[str, Figure] = {
    "ball": Figure(
        f'<geom type="sphere" pos="0 0 .11" size=".11" rgba="{{colour}} 1" {SOLID}/>', ("red", "blue"), True
    ),
    "book": Figure(
        f'<geom type="box" pos="0 0 .12" size=".09 .025 .12" rgba="{{colour}} 1" {SEEN}/>'
        f'<geom type="box" pos=".006 0 .12" size=".088 .02 .115" rgba=".95 .94 .88 1" {SEEN}/>',
        ("blue", "red"),
    ),
    "bottle": Figure(
        f'<geom type="cylinder" pos="0 0 .1" size=".04 .1" rgba="{{colour}} 1" {SEEN}/>'
        f'<geom type="cylinder" pos="0 0 .24" size=".016 .05" rgba="{{colour}} 1" {SEEN}/>',
        ("green", "blue"),
    ),
    "bowl": Figure(
        f'<geom type="cylinder" pos="0 0 .04" size=".1 .04" rgba="{{colour}} 1" {SEEN}/>'
        f'<geom type="cylinder" pos="0 0 .075" size=".085 .007" rgba=".3 .25 .2 1" {SEEN}/>',
        ("white", "yellow"),
    ),
    "chair": Figure(
        f'<geom type="box" pos="0 0 .45" size=".2 .2 .02" rgba="{{colour}} 1" {SOLID}/>'
        f'<geom type="box" pos="-.18 0 .7" size=".015 .19 .24" rgba="{{colour}} 1" {SOLID}/>{LEGS}',
        ("brown", "white"),
        on_floor=True,
    ),
    "cup": Figure(
        f'<geom type="cylinder" pos="0 0 .055" size=".045 .055" rgba="{{colour}} 1" {SEEN}/>'
        f'<geom type="box" pos="0 .06 .055" size=".007 .02 .03" rgba="{{colour}} 1" {SEEN}/>',
        ("red", "white", "blue"),
    ),
    "lamp": Figure(
        f'<geom type="cylinder" pos="0 0 .01" size=".07 .01" rgba=".2 .2 .2 1" {SEEN}/>'
        f'<geom type="cylinder" pos="0 0 .15" size=".01 .14" rgba=".2 .2 .2 1" {SEEN}/>'
        f'<geom type="cylinder" pos="0 0 .34" size=".1 .07" rgba="{{colour}} 1" {SEEN}/>',
        ("yellow", "white"),
    ),
    "plant": Figure(
        f'<geom type="cylinder" pos="0 0 .06" size=".07 .06" rgba="{{colour}} 1" {SEEN}/>'
        f'<geom type="ellipsoid" pos="0 0 .22" size=".12 .12 .12" rgba=".15 .5 .15 1" {SEEN}/>'
        f'<geom type="ellipsoid" pos=".05 .05 .3" size=".07 .07 .1" rgba=".2 .55 .2 1" {SEEN}/>',
        ("brown", "white"),
    ),
}
LOOKALIKES: Mapping[str, tuple[str, ...]] = {
    "ball": ("bowl",), "book": ("bottle",), "bottle": ("cup", "lamp"), "bowl": ("cup",), "chair": ("plant",),
    "cup": ("bowl", "bottle"), "lamp": ("plant", "bottle"), "person": ("chair",), "plant": ("lamp",),
}  # fmt: skip
"""What each is taken for when it is taken for something else."""
HARDLY_SEEN = ".2 .2 .25 .004"
"""A ray passes through what is quite invisible."""
CLOTHES = (".2 .45 .65 1", ".65 .25 .3 1", ".3 .5 .3 1")


def figure(kind: str, colour: str, name: str, place: tuple[float, float, float], turn_deg: float) -> str:
    """One object's MJCF; it does not move."""
    geoms = FIGURES[kind].geoms.format(colour=COLOURS[colour])
    x, y, z = place
    return f'<body name="{name}" pos="{x:.3f} {y:.3f} {z:.3f}" euler="0 0 {turn_deg:.1f}">{geoms}</body>'


def person(name: str, number: int, place: tuple[float, float], *, lies: bool = False) -> str:
    """One person's MJCF, moved by their will (mocap); the lidar meets the legs, as high as it looks.

    Args:
        name: The name of the body.
        number: Chooses the colour of the clothes.
        place: Where they are at first, m.
        lies: On the back, lower than the lidar looks; the robot and its depth camera meet the body, the lidar does not.
    """
    parts = {
        "skin": ".86 .66 .53 1",
        "vest": CLOTHES[number % len(CLOTHES)],
        "hair": ".2 .12 .07 1",
        "trousers": ".16 .18 .25 1",
        "boots": ".14 .1 .08 1",
    }
    seen = "".join(f'<geom type="mesh" mesh="{mesh}" rgba="{rgba}" {SEEN}/>' for mesh, rgba in parts.items())
    solid = f'<geom type="cylinder" pos="0 0 .45" size=".17 .45" rgba="{HARDLY_SEEN}" {SOLID}/>'
    if lies:
        seen = f'<frame pos=".85 0 .12" euler="0 -90 0">{seen}</frame>'
        solid = f'<geom type="capsule" fromto="-.8 0 .1 .7 0 .1" size=".1" rgba="{HARDLY_SEEN}" {LOW}/>'
    return f'<body name="{name}" mocap="true" pos="{place[0]:.3f} {place[1]:.3f} 0">{seen}{solid}</body>'


def person_assets() -> dict[str, bytes]:
    """The mesh files of a person, by name."""
    return {f"{name}.obj": mesh.obj() for name, mesh in person_meshes().items()}
