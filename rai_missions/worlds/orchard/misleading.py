# SPDX-License-Identifier: Apache-2.0
"""Obstacles whose looks or measures mislead, as MuJoCo bodies: high and soft, or low and not to be driven over.

Rule: what gives way to a tyre without a force that matters (blades of grass, film, water) is sensed by beams and
camera, and touches nothing; all else has the mass and the shape that it looks like.
"""

from __future__ import annotations

import math

import numpy as np

from rai_missions.worlds.meshes import Mesh

__all__ = ("GHOST", "SOLID", "companion", "geoms", "meshes")

GHOST = 'contype="0" conaffinity="0" mass="0" group="2"'
SENSED = 'contype="0" conaffinity="0" mass="0" group="3"'
SOLID = 'group="3" condim="6" friction="1.2 .05 .02" solref=".01 1"'
HOSE_R, RUNG_R, LADDER_M, HOSE_M = 0.03, 0.016, 2.3, 2.3
FENCE_M, FENCE_WIDE_M, FENCE_HIGH_M = 2.2, 2.6, 0.5
"""The panel as it lies: one edge on the ground, the other held up by its posts."""


def geoms(kind: str, size: float, variant: str) -> str:
    """One obstacle's geoms in its own frame.

    Args:
        kind: One of the kinds of this file.
        size: 1 is the usual size; the geoms of grass scale in height, those of a puddle in extent.
        variant: One of the kind's variants.
    """
    if kind == "tall_grass":
        return _grass(size)
    if kind == "plastic_bag":
        return _bag(variant)
    if kind == "puddle":
        return _puddle(size, variant)
    return {"hose": _hose, "ladder": _ladder, "cat": _cat, "scarecrow": _scarecrow, "fallen_fence": _fence}[kind]()


def companion(kind: str, variant: str, name: str, place: str) -> str:
    """A body of its own that comes with an obstacle: the bridge over a hose.

    Args:
        kind: The kind of the obstacle.
        variant: The variant of the obstacle.
        name: The name of the obstacle's body.
        place: Attributes of a body at the same place.
    """
    if (kind, variant) != ("hose", "bridged"):
        return ""
    ramps = "".join(_ramp(x) for x in (-0.82, 0.82))
    return f'<body name="{name}_bridge" {place}>{ramps}</body>'


def meshes(rng: np.random.Generator) -> dict[str, Mesh]:
    """The meshes by name."""
    return {"blades": _blades(rng), "bag": _film(rng), "cat": _curled(rng), "straw": _straw(rng)}


def _grass(size: float) -> str:
    return f"""<geom type="mesh" mesh="blades" material="straw" {GHOST}/>
 <geom type="box" pos="0 0 {0.4 * size}" size=".5 1.1 {0.4 * size}" {SENSED}/>"""


def _bag(variant: str) -> str:
    film = '<geom type="mesh" mesh="bag" rgba=".86 .9 .94 .92" ' + GHOST + "/>"
    if variant == "full":
        return f'{film}<geom type="ellipsoid" size=".29 .27 .2" mass="38" {SOLID}/>'
    return f'{film}<geom type="ellipsoid" size=".29 .27 .2" {SENSED}/>'


def _puddle(size: float, variant: str) -> str:
    wide = f"{1.0 * size} {1.25 * size}"
    water = f'<geom type="cylinder" size="{1.05 * size} .012" rgba=".34 .42 .5 1" {GHOST}/>'
    sensed = f'<geom type="box" pos="0 0 .02" size="{0.7 * size} {0.9 * size} .02" {SENSED}/>'
    if variant != "deep":
        return water + sensed
    mud = (
        f'<geom type="box" pos="0 0 .006" size="{wide} .006" priority="2" condim="6" friction=".12 .05 .35" group="0"'
        ' rgba=".36 .3 .22 1"/>'
    )
    return water + sensed + mud


def _hose() -> str:
    half = HOSE_M / 2
    return f"""<geom type="capsule" fromto="-{half} 0 0 {half} 0 0" size="{HOSE_R}" rgba=".1 .5 .16 1" {GHOST}/>
 <geom type="capsule" fromto="-{half} 0 0 {half} 0 0" size="{HOSE_R}" mass="4" {SOLID}/>"""


def _ramp(x: float) -> str:
    """Half a bridge: up, over the hose and down again, for the tyres of one side."""
    rise, run, up = 0.1, 0.5, 0.075
    turn = math.degrees(math.atan2(rise, run))
    sides = "".join(
        f'<geom type="box" pos="{x} {side * 0.33:.3f} .022" euler="{-side * turn:.2f} 0 0" size=".4 .26 .012"'
        f' rgba=".9 .72 .1 1" group="3" friction="1 .01 .01"/>'
        f'<geom type="box" pos="{x} {side * 0.33:.3f} .022" euler="{-side * turn:.2f} 0 0" size=".4 .26 .014"'
        f' rgba=".9 .72 .1 1" {GHOST}/>'
        for side in (-1, 1)
    )
    top = f'pos="{x} 0 {up + 0.012}" size=".4 .12 .012" rgba=".12 .12 .12 1"'
    return f'{sides}<geom type="box" {top} group="3" friction="1 .01 .01"/><geom type="box" {top} {GHOST}/>'


def _ladder() -> str:
    half, out = LADDER_M / 2, []
    silver = 'rgba=".74 .76 .78 1"'
    for y in (-0.21, 0.21):
        out.append(f'<geom type="box" pos="0 {y} 0" size="{half} .012 .034" {silver} {GHOST}/>')
        out.append(f'<geom type="box" pos="0 {y} 0" size="{half} .012 .034" mass="4.5" {SOLID}/>')
    for k in range(8):
        x = -half + 0.15 + k * 0.29
        ends = f'fromto="{x:.2f} -.2 0 {x:.2f} .2 0" size="{RUNG_R}"'
        out.append(f'<geom type="capsule" {ends} {silver} {GHOST}/><geom type="capsule" {ends} mass=".3" {SOLID}/>')
    return "".join(out)


def _cat() -> str:
    return f"""<geom type="mesh" mesh="cat" rgba=".36 .3 .26 1" {GHOST}/>
 <geom type="ellipsoid" pos="0 0 .1" size=".24 .17 .1" group="3"/>"""


def _scarecrow() -> str:
    wood = 'material="bark"'
    return f"""<geom type="capsule" fromto="0 0 .02 0 0 1.6" size=".035" {wood} {GHOST}/>
 <geom type="capsule" fromto="0 -.6 1.3 0 .6 1.3" size=".03" {wood} {GHOST}/>
 <geom type="mesh" mesh="vest" rgba=".8 .42 .1 1" {GHOST}/>
 <geom type="mesh" mesh="trousers" rgba=".2 .23 .36 1" {GHOST}/>
 <geom type="ellipsoid" pos="0 0 1.63" size=".12 .11 .14" rgba=".85 .74 .45 1" {GHOST}/>
 <geom type="cylinder" pos="0 0 1.74" size=".22 .012" rgba=".5 .38 .2 1" {GHOST}/>
 <geom type="cylinder" pos="0 0 1.8" size=".11 .07" rgba=".5 .38 .2 1" {GHOST}/>
 <geom type="mesh" mesh="straw" rgba=".88 .78 .42 1" {GHOST}/>
 <geom type="box" size=".25 .25 .02" mass="10" {SOLID}/>
 <geom type="capsule" fromto="0 0 .05 0 0 1.6" size=".06" mass="5" {SOLID}/>
 <geom type="capsule" fromto="0 -.55 1.3 0 .55 1.3" size=".05" mass="1.5" {SOLID}/>"""


def _fence() -> str:
    """A panel of boards: its low edge is at -x, its high one at +x."""
    tilt = math.degrees(math.atan2(FENCE_HIGH_M, FENCE_M))
    boards = "".join(
        f'<geom type="box" pos="{x:.3f} 0 0" size=".09 {FENCE_WIDE_M / 2} .014" material="wood" {GHOST}/>'
        for x in np.linspace(-FENCE_M / 2 + 0.1, FENCE_M / 2 - 0.1, 9)
    )
    posts = "".join(
        f'<geom type="box" pos="1.0 {y} {FENCE_HIGH_M / 2 - 0.02}" size=".05 .05 {FENCE_HIGH_M / 2 - 0.03}"'
        f' material="bark" {GHOST}/>'
        for y in (-1.1, 0.0, 1.1)
    )
    inner = f'<geom type="box" size="{FENCE_M / 2} {FENCE_WIDE_M / 2} .025" {SOLID}/>'
    # frames of MJCF turn what they hold
    return f'{posts}<frame pos="0 0 {FENCE_HIGH_M / 2}" euler="0 {-tilt:.2f} 0">{boards}{inner}</frame>'


def _blades(rng: np.random.Generator) -> Mesh:
    """A clump of upright blades, 0.8 m high, over half a metre along and two across."""
    blades = []
    for _ in range(420):
        x, y, turn = rng.uniform(-0.5, 0.5), rng.uniform(-1.1, 1.1), rng.uniform(0, math.pi)
        high, (lean_x, lean_y), wide = rng.uniform(0.5, 0.84), rng.normal(size=2) * 0.12, rng.uniform(0.008, 0.016)
        out = math.cos(turn) * wide, math.sin(turn) * wide, 0.0
        blades.append([(x, y, 0.0), (x + lean_x, y + lean_y, high), out, (-lean_x * 0.2, -lean_y * 0.2, 0.04)])
    foot, tip, out, bend = np.array(blades).swapaxes(0, 1)
    middle = (foot + tip) / 2 + bend
    corners = np.stack([foot - out, foot + out, middle + out, middle - out, tip + out * 0.2, tip - out * 0.2], 1)
    sides = np.array([(0, 1, 2, 3), (3, 2, 4, 5), (3, 2, 1, 0), (5, 4, 2, 3)])
    quads = 6 * np.arange(len(blades))[:, None, None] + sides
    return Mesh().flat_faces(corners.reshape(-1, 3), quads.reshape(-1, 4))


def _film(rng: np.random.Generator) -> Mesh:
    mesh = Mesh().ellipsoid((0, 0, 0), (0.33, 0.31, 0.23), fineness=2, lumps=7, rng=rng)
    return mesh.tube([[0, 0, 0.16], [0.02, 0, 0.26], [0.06, 0.02, 0.33]], [0.05, 0.03, 0.09], 7, 0.4)


def _curled(rng: np.random.Generator) -> Mesh:
    """A cat, curled up asleep."""
    mesh = Mesh().ellipsoid((0, 0, 0.09), (0.24, 0.17, 0.1), fineness=2, lumps=40, rng=rng)
    mesh.ellipsoid((0.17, 0.1, 0.1), (0.07, 0.06, 0.06), fineness=1)
    for side in (-1, 1):
        mesh.ellipsoid((0.18 + 0.03 * side, 0.1, 0.165), (0.016, 0.012, 0.03), fineness=1)
    return mesh.tube([[-0.2, -0.05, 0.04], [-0.1, -0.18, 0.03], [0.08, -0.2, 0.03]], [0.03, 0.025, 0.015], 6)


def _straw(rng: np.random.Generator) -> Mesh:
    """What sticks out of a scarecrow's sleeves and collar."""
    mesh = Mesh()
    for y, z in ((-0.6, 1.3), (0.6, 1.3), (0.0, 1.5)):
        for _ in range(9):
            tip = np.array([0.0, y, z]) + rng.normal(size=3) * (0.07, 0.05, 0.06) + (0, 0.12 * np.sign(y), 0)
            mesh.tube([[0, y, z], ((np.array([0, y, z]) + tip) / 2).tolist(), tip.tolist()], [0.012, 0.01, 0.006], 4)
    return mesh
