# SPDX-License-Identifier: Apache-2.0
"""The orchard as one MuJoCo model: ground, light, trees, obstacles, tractor.

Geom groups: 0 ground and trunks, 1 crowns, 2 tractor and obstacles as they are seen, 3 obstacles, 4 trunks and 5 the
tractor as they collide.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import Any

import mujoco
import numpy as np

from rai_missions.worlds.meshes import Mesh
from rai_missions.worlds.orchard import bodies as figures
from rai_missions.worlds.orchard import textures, tractor
from rai_missions.worlds.orchard.conditions import Conditions
from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import Obstacle

__all__ = ("TIMESTEP_S", "build")

TIMESTEP_S = 0.005
CROWNS, TRUNKS = 5, 3
OBSTACLE_GROUP, TRUNK_GROUP = 3, 4
MESH, FILE = re.compile(r'mesh="(\w+)"'), re.compile(r'file="(\w+)\.obj"')
TREE_GHOST = 'contype="0" conaffinity="0"'


def build(
    layout: Layout, obstacles: Sequence[Obstacle], *, shadows: bool = False, conditions: Conditions | None = None
) -> Any:
    """Compile the orchard; its surfaces are blank until `textures.paint` has given it them.

    Args:
        layout: Where everything stands.
        obstacles: What lies in the alleys; their bodies are called `obstacle_0`, `obstacle_1`, ...
        shadows: Cast shadows and smooth edges: prettier, and several times slower to render.
        conditions: Light and air; None: a clear day.
    """
    air = conditions or Conditions()
    middle = layout.length_m / 2, layout.centre_m(layout.alleys - 1) / 2
    bodies = f"""{_trees(layout)}
 {"".join(_obstacle(number, obstacle, layout) for number, obstacle in enumerate(obstacles))}
 {tractor.body(*layout.home)}"""
    sized = (figures.figure_assets(one.kind, f"obstacle_{n}", one.size) for n, one in enumerate(obstacles))
    meshes = _named_meshes(bodies) + "".join(sized)
    xml = f"""<mujoco model="orchard"><compiler angle="degree"/>
<option timestep="{TIMESTEP_S}" integrator="implicitfast" cone="elliptic" impratio="3"/>
<visual><global offwidth="1280" offheight="960"/>
 <quality shadowsize="{4096 if shadows else 0}" offsamples="{4 if shadows else 0}" numslices="16" numstacks="10"/>
 <map znear="0.01" {air.reach} zfar="10" shadowclip="1.2"/>
 <headlight {air.headlight} specular="0 0 0"/>
 <rgba fog="{air.colour}" haze="{air.colour}"/></visual>{air.marks}
<default><default class="tyre"><geom condim="4" friction="1.0 .01 .01" solref=".02 1.2"/></default></default>
<asset>{_materials(air)}{meshes}</asset>
<statistic extent="12" center="{middle[0]} {middle[1]} 1"/>
<worldbody>
 <light directional="true" pos="10 6 20" dir="{air.sun}" diffuse="{air.sunlight}" specular=".2 .2 .2"
  castshadow="{str(shadows).lower()}"/>
 <geom name="ground" type="plane" size="120 120 1" material="grass" friction="1 .01 .01"/>
 {bodies}
</worldbody>
<contact>{tractor.CONTACT}</contact><actuator>{tractor.ACTUATORS}</actuator></mujoco>"""
    files = {f"{name}.obj": _file(name) for name in FILE.findall(meshes)}
    model = mujoco.MjModel.from_xml_string(xml, files)
    excluded = _grown_together(model)
    if excluded:
        model = mujoco.MjModel.from_xml_string(xml.replace("</contact>", f"{excluded}</contact>"), files)
    return model


def _grown_together(model: Any) -> str:
    """What lies across a trunk from the beginning, as a fallen crown does, and is not to touch it.

    A force that grows with the depth would throw it out of its alley.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pairs = {
        tuple(model.body(model.geom_bodyid[geom]).name for geom in (one.geom1, one.geom2))
        for one in data.contact
        if one.dist < 0 and {*model.geom_group[[one.geom1, one.geom2]]} == {OBSTACLE_GROUP, TRUNK_GROUP}
    }
    return "".join(f'<exclude body1="{first}" body2="{second}"/>' for first, second in sorted(pairs))


def _obstacle(number: int, obstacle: Obstacle, layout: Layout) -> str:
    x, y = obstacle.place_m(layout)
    return figures.figure(
        obstacle.kind, f"obstacle_{number}", (x, y), obstacle.turn_deg, size=obstacle.size, variant=obstacle.variant
    )


def _materials(air: Conditions) -> str:
    surfaces = "".join(
        f'<texture name="{name}" type="2d" builtin="flat" colorspace="linear" '
        f'width="{textures.SURFACES[name].size}" height="{textures.SURFACES[name].size}"/>'
        f'<material name="{name}" texture="{name}" specular="{shine}" shininess=".1" {repeat}/>'
        for name, shine, repeat in (
            ("grass", 0, 'texrepeat="60 60"'),
            ("leaf", 0.05, ""),
            ("bark", 0.05, ""),
            ("wood", 0.1, ""),
            ("straw", 0.05, ""),
        )
    )
    return (
        f'<texture type="skybox" builtin="gradient" {air.sky} width="128" height="768"/>'
        + surfaces
        + '<material name="paint" rgba=".06 .42 .15 1" specular=".6" shininess=".7"/>'
    )


def _named_meshes(bodies: str) -> str:
    """The meshes that bodies name. A file that no body names takes as long to write and to read as any other."""
    named = {*MESH.findall(bodies)}
    return "".join(f'<mesh name="{name}" file="{name}.obj" inertia="shell"/>' for name in _meshes() if name in named)


@cache
def _file(name: str) -> bytes:
    """The file of a mesh, made once a process."""
    return _meshes()[name].obj()


@cache
def _meshes() -> dict[str, Mesh]:
    """Every mesh that there is, by name."""
    crowns = {f"crown{k}": _crown(k) for k in range(CROWNS)}
    trunks = {f"trunk{k}": _trunk(k) for k in range(TRUNKS)}
    return {**crowns, **trunks, **tractor.meshes(), **figures.meshes()}


def _trees(layout: Layout) -> str:
    rng = np.random.default_rng(5)
    out = []
    for number, (x, y) in enumerate(layout.trees()):
        turn, lean, high = rng.uniform(0, 360), rng.normal(size=2) * 0.06, rng.uniform(2.1, 2.4)
        crown, trunk = rng.integers(CROWNS), rng.integers(TRUNKS)
        out.append(
            f'<body name="tree_{number}" pos="{x + lean[0]:.3f} {y + lean[1]:.3f} 0" euler="0 0 {turn:.0f}">'
            f'<geom type="mesh" mesh="trunk{trunk}" material="bark" {TREE_GHOST} group="0"/>'
            f'<geom type="mesh" mesh="crown{crown}" material="leaf" pos="0 0 {high:.2f}" {TREE_GHOST} group="1"/>'
            f'<geom type="cylinder" pos="0 0 .8" size=".14 .8" group="{TRUNK_GROUP}"/></body>'
        )
    return "".join(out)


def _crown(seed: int) -> Mesh:
    rng = np.random.default_rng(100 + seed)
    radii = (rng.uniform(0.95, 1.15), rng.uniform(0.95, 1.15), rng.uniform(1.0, 1.25))
    mesh = Mesh().ellipsoid((0, 0, 0), radii, lumps=9, rng=rng)
    return mesh.leaves(radii, 46, rng).fruit(radii, 9, rng)


def _trunk(seed: int) -> Mesh:
    rng = np.random.default_rng(200 + seed)
    spine = np.zeros((4, 3))
    spine[:, 2] = (-0.05, 0.4, 0.85, 1.3)
    spine[1:, :2] = np.cumsum(rng.normal(size=(3, 2)) * 0.04, 0)
    mesh = Mesh().tube(spine.tolist(), [0.16, 0.12, 0.11, 0.1], 6)
    for k in range(4):
        turn = k * 1.57 + rng.random()
        out = np.array([np.cos(turn) * 0.22, np.sin(turn) * 0.22, 0.24])
        mesh.tube([(spine[3 - k % 2] + out * step).tolist() for step in (0, 1.2, 2.6)], [0.07, 0.05, 0.025], 4)
    return mesh
