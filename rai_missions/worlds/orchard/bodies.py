# SPDX-License-Identifier: Apache-2.0
"""What lies or stands in the alleys, as MuJoCo bodies: what they look like and what they weigh.

Rule: a figure has collision geoms (group 3, unseen) and visible ones (group 2); only the former touch anything.
"""

from __future__ import annotations

import math

import numpy as np

from rai_missions.worlds.meshes import Mesh
from rai_missions.worlds.orchard import misleading
from rai_missions.worlds.orchard.kinds import KINDS
from rai_missions.worlds.orchard.misleading import GHOST, SOLID
from rai_missions.worlds.person import person_meshes

__all__ = ("figure", "figure_assets", "meshes")

TWIGGY = 'group="3" condim="6" friction="1.2 .05 .06" solref=".01 1"'
"""Rolling friction: without it a branch is bulldozed for metres instead of being driven over."""
SKIN, VEST, TROUSERS, BOOTS, HAIR = ".86 .66 .53 1", ".95 .45 .08 1", ".16 .21 .36 1", ".14 .1 .08 1", ".2 .12 .07 1"
WOOL, HIDE = ".92 .9 .84 1", ".13 .11 .1 1"

RADII_M, MASSES_KG = {"branch": 0.065, "log": 0.22}, {"branch": 12.0, "log": 180.0}
SIZED = {
    "branch": f"""<geom type="mesh" mesh="branch" material="bark" {GHOST}/>
 <geom type="mesh" mesh="twigs" material="leaf" {GHOST}/>
 <geom type="capsule" fromto="-1.15 0 0 1.1 0 0" size="{{r:.6g}}" mass="{{mass:.6g}}" {TWIGGY}/>""",
    "log": f"""<geom type="mesh" mesh="log" material="bark" {GHOST}/>
 <geom type="cylinder" euler="0 90 0" size="{{thin:.6g}} 1.17" material="wood" {GHOST}/>
 <geom type="cylinder" euler="0 90 0" size="{{r:.6g}} 1.2" mass="{{mass:.6g}}" {SOLID}/>""",
}
"""What scales with its size: radius, mass and the height that it rests at."""
LYING_M = 0.85
"""From a person's feet to the middle."""
MOVED_BY = {"forces": ("<freejoint/>", ""), "will": ("", ' mocap="true"'), "nothing": ("", "")}
"""What moves a body → its joint, and its attribute. An empty bag gives way on the spot: nothing moves it."""
SCALED = {"branch": ("branch", "twigs"), "log": ("log",), "tall_grass": ("blades",)}
"""Kinds whose meshes scale."""
FIGURES = {
    "crate": f"""<geom type="box" size=".3 .3 .3" material="wood" {GHOST}/>
 <geom type="box" size=".3 .3 .3" mass="35" group="3"/>""",
    "fallen_tree": f"""<geom type="mesh" mesh="fallen" material="bark" {GHOST}/>
 <geom type="mesh" mesh="fallen_crown" material="leaf" {GHOST}/>
 <geom type="capsule" fromto="-1.9 0 0 1.0 0 0" size=".16" mass="260" {SOLID}/>
 <geom type="ellipsoid" pos="1.7 0 .3" size=".8 .6 .46" mass="60" group="3"/>""",
    "person": f"""<geom type="mesh" mesh="skin" rgba="{SKIN}" {GHOST}/>
 <geom type="mesh" mesh="vest" rgba="{VEST}" {GHOST}/>
 <geom type="mesh" mesh="stripes" rgba=".93 .95 .8 1" {GHOST}/><geom type="mesh" mesh="hair" rgba="{HAIR}" {GHOST}/>
 <geom type="mesh" mesh="trousers" rgba="{TROUSERS}" {GHOST}/><geom type="mesh" mesh="boots" rgba="{BOOTS}" {GHOST}/>
 <geom type="capsule" fromto="0 0 .3 0 0 1.5" size=".25" group="3"/>""",
    "animal": f"""<geom type="mesh" mesh="fleece" rgba="{WOOL}" {GHOST}/>
 <geom type="mesh" mesh="hide" rgba="{HIDE}" {GHOST}/>
 <geom type="capsule" fromto="-.3 0 .55 .3 0 .55" size=".28" group="3"/>
 <geom type="sphere" pos=".58 0 .82" size=".14" group="3"/>""",
}
PERSON = FIGURES["person"]
EXTRAS = {
    ("person", "muffs"): "".join(
        f'<geom type="cylinder" pos=".02 {y} 1.65" euler="90 0 0" size=".055 .03" rgba=".95 .1 .1 1" {GHOST}/>'
        for y in (-0.105, 0.105)
    ),
    ("animal", "tethered"): f"""<geom type="capsule" fromto=".5 0 .7 1.1 .5 .03" size=".015" rgba=".9 .2 .1 1" {GHOST}/>
 <geom type="cylinder" pos="1.1 .5 .2" size=".03 .2" rgba=".9 .2 .1 1" {GHOST}/>""",
    ("lying_person", "resting"): f"""<geom type="cylinder" pos=".3 .55 .9" euler="0 90 0" size=".2 .12" material="wood"
 {GHOST}/><geom type="ellipsoid" pos="-.1 0 1.68" size=".06 .2 .2" rgba=".85 .74 .45 1" {GHOST}/>""",
}
"""What shows the variants of the living: ear muffs, a tether with its peg, a basket and a straw hat."""


def figure(kind: str, name: str, place: tuple[float, float], turn_deg: float, *, size: float, variant: str) -> str:
    """One obstacle's MJCF; what lives is moved by its will (mocap), the rest by forces or not at all.

    Args:
        kind: One of `KINDS`.
        name: The name of its body.
        place: x and y, m.
        turn_deg: Of its x axis, counter-clockwise.
        size: 1 is the usual size.
        variant: One of the kind's variants.
    """
    what = KINDS[kind]
    joint, attribute = MOVED_BY["nothing" if (kind, variant) == ("plastic_bag", "") else what.moved_by]
    height = what.rests_at_m * (size if kind in SCALED else 1.0)
    along = LYING_M if kind == "lying_person" else 0.0
    x, y = place[0] + along * math.cos(math.radians(turn_deg)), place[1] + along * math.sin(math.radians(turn_deg))
    at = f'pos="{x:.3f} {y:.3f} {height:.4g}" {_turned(kind, turn_deg)}'
    ground = f'pos="{place[0]:.3f} {place[1]:.3f} 0" euler="0 0 {turn_deg:.1f}"'
    inside = _geoms(kind, size, variant)
    for mesh in SCALED.get(kind, ()) if size != 1 else ():
        inside = inside.replace(f'mesh="{mesh}"', f'mesh="{name}_{mesh}"')
    return (
        f'<body name="{name}" {at}{attribute}>{joint}{inside}</body>{misleading.companion(kind, variant, name, ground)}'
    )


def figure_assets(kind: str, name: str, size: float) -> str:
    """The meshes of one obstacle of another size than usual."""
    scale = "1 1" if kind == "tall_grass" else f"1 {size}"
    return "".join(
        f'<mesh name="{name}_{mesh}" file="{mesh}.obj" scale="{scale} {size}" inertia="shell"/>'
        for mesh in (SCALED.get(kind, ()) if size != 1 else ())
    )


def _geoms(kind: str, size: float, variant: str) -> str:
    if kind in ("branch", "log"):
        return SIZED[kind].format(
            r=RADII_M[kind] * size, thin=(RADII_M[kind] - 0.02) * size, mass=MASSES_KG[kind] * size**2
        )
    if kind == "lying_person":
        return PERSON.replace('size=".25"', 'size=".17"') + EXTRAS.get((kind, variant), "")
    if kind in FIGURES:
        return FIGURES[kind] + EXTRAS.get((kind, variant), "")
    return misleading.geoms(kind, size, variant)


def _turned(kind: str, turn_deg: float) -> str:
    if kind != "lying_person":
        return f'euler="0 0 {turn_deg:.1f}"'
    half, quarter = math.radians(turn_deg) / 2, math.radians(-90) / 2
    turn = (math.cos(half), math.sin(half))
    lie = (math.cos(quarter), math.sin(quarter))
    # a turn about z after one about y: the person lies on the back
    w, x, y, z = turn[0] * lie[0], -turn[1] * lie[1], turn[0] * lie[1], turn[1] * lie[0]
    return f'quat="{w:.6f} {x:.6f} {y:.6f} {z:.6f}"'


def meshes() -> dict[str, Mesh]:
    """The meshes of every figure, by name."""
    rng = np.random.default_rng(11)
    made = {"branch": _branch(rng), "twigs": _twigs(rng), "log": _log(rng), "fallen": _fallen(rng)}
    made["fallen_crown"] = Mesh().ellipsoid((1.7, 0, 0.34), (0.95, 0.75, 0.55), lumps=8, rng=rng)
    return {**made, **person_meshes(), **_animal(rng), **misleading.meshes(rng)}


def _branch(rng: np.random.Generator) -> Mesh:
    spine = np.stack([np.linspace(-1.2, 1.2, 9), rng.normal(size=9) * 0.03, np.zeros(9)], 1)
    mesh = Mesh().tube(spine.tolist(), np.linspace(0.07, 0.03, 9).tolist())
    for k in range(7):
        start, side = spine[2 + k % 6], 1 if k % 2 else -1
        out = np.array([0.12, side * 0.13, 0.015]) * rng.uniform(0.7, 1.2)
        mesh.tube([(start + out * step).tolist() for step in range(4)], [0.03, 0.022, 0.016, 0.01], 5)
    return mesh


def _twigs(rng: np.random.Generator) -> Mesh:
    mesh = Mesh()
    for _ in range(3):
        mesh.leaves((0.95, 0.4, 0.05), 10, rng, size=0.08)
    return mesh


def _log(rng: np.random.Generator) -> Mesh:
    spine = np.stack([np.linspace(-1.16, 1.16, 6), np.zeros(6), np.zeros(6)], 1)
    return Mesh().tube(spine.tolist(), (0.225 + rng.normal(size=6) * 0.006).tolist(), 12)


def _fallen(rng: np.random.Generator) -> Mesh:
    spine = np.stack([np.linspace(-2.0, 1.3, 7), rng.normal(size=7) * 0.02, np.zeros(7)], 1)
    mesh = Mesh().tube(spine.tolist(), np.linspace(0.17, 0.11, 7).tolist(), 8)
    for k in range(5):
        turn = k * 1.256
        tip = np.array([-2.3, 0.3 * np.cos(turn), 0.3 * np.sin(turn)])
        mesh.tube([[-1.95, 0, 0], ((tip + spine[0]) / 2).tolist(), tip.tolist()], [0.09, 0.05, 0.02], 5)
    return mesh


def _animal(rng: np.random.Generator) -> dict[str, Mesh]:
    """A black-faced sheep, looking along x."""
    fleece = Mesh().ellipsoid((0, 0, 0.6), (0.5, 0.3, 0.31), fineness=3, lumps=60, rng=rng)
    fleece.ellipsoid((0.45, 0, 0.86), (0.12, 0.1, 0.1), lumps=20, rng=rng)
    hide = Mesh().tube([[0.4, 0, 0.72], [0.52, 0, 0.86], [0.74, 0, 0.74]], [0.12, 0.1, 0.055], 8, 0.85)
    for side in (-1, 1):
        hide.ellipsoid((0.5, side * 0.14, 0.9), (0.035, 0.09, 0.025), fineness=1)
        for x in (-0.28, 0.28):
            hide.tube(
                [[x, side * 0.14, 0.5], [x + 0.02, side * 0.14, 0.25], [x, side * 0.14, 0.0]], [0.055, 0.035, 0.04], 6
            )
    return {"fleece": fleece, "hide": hide}
