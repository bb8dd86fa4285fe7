# SPDX-License-Identifier: Apache-2.0
"""What lies or stands in the alleys, as MuJoCo bodies: what they look like and what they weigh.

Rule: a figure has collision geoms (group 3, unseen) and visible ones (group 2); only the former touch anything.
"""

from __future__ import annotations

import numpy as np

from rai_missions.worlds.meshes import Mesh
from rai_missions.worlds.person import person_meshes

__all__ = ("FIGURES", "LIVING", "figure", "meshes")

LIVING = frozenset({"person", "animal"})
GHOST = 'contype="0" conaffinity="0" mass="0" group="2"'
SOLID = 'group="3" condim="6" friction="1.2 .05 .02" solref=".01 1"'
TWIGGY = 'group="3" condim="6" friction="1.2 .05 .06" solref=".01 1"'
"""Rolling friction: without it a branch is bulldozed for metres instead of being driven over."""
SKIN, VEST, TROUSERS, BOOTS, HAIR = ".86 .66 .53 1", ".95 .45 .08 1", ".16 .21 .36 1", ".14 .1 .08 1", ".2 .12 .07 1"
WOOL, HIDE = ".92 .9 .84 1", ".13 .11 .1 1"

FIGURES = {
    "branch": f"""<geom type="mesh" mesh="branch" material="bark" {GHOST}/>
 <geom type="mesh" mesh="twigs" material="leaf" {GHOST}/>
 <geom type="capsule" fromto="-1.15 0 0 1.1 0 0" size=".065" mass="12" {TWIGGY}/>""",
    "log": f"""<geom type="mesh" mesh="log" material="bark" {GHOST}/>
 <geom type="cylinder" euler="0 90 0" size=".2 1.17" material="wood" {GHOST}/>
 <geom type="cylinder" euler="0 90 0" size=".22 1.2" mass="180" {SOLID}/>""",
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
RESTS_AT_M = {"branch": 0.07, "log": 0.225, "crate": 0.305, "fallen_tree": 0.165, "person": 0.0, "animal": 0.0}


def figure(kind: str, name: str, x: float, y: float, turn_deg: float) -> str:
    """One obstacle's MJCF; what lives is moved by its will (mocap), the rest by forces."""
    moved = ("", ' mocap="true"') if kind in LIVING else ("<freejoint/>", "")
    place = f'pos="{x:.3f} {y:.3f} {RESTS_AT_M[kind]}" euler="0 0 {turn_deg:.1f}"'
    return f'<body name="{name}" {place}{moved[1]}>{moved[0]}{FIGURES[kind]}</body>'


def meshes() -> dict[str, bytes]:
    """The mesh files of every figure, by name."""
    rng = np.random.default_rng(11)
    made = {"branch": _branch(rng), "twigs": _twigs(rng), "log": _log(rng), "fallen": _fallen(rng)}
    made["fallen_crown"] = Mesh().ellipsoid((1.7, 0, 0.34), (0.95, 0.75, 0.55), lumps=8, rng=rng)
    return {f"{name}.obj": mesh.obj() for name, mesh in {**made, **person_meshes(), **_animal(rng)}.items()}


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
