# SPDX-License-Identifier: Apache-2.0
"""The house as one MuJoCo model: floor, walls, furniture, objects, people, crates that may block doorways, the robot.

Geom groups: 0 the floor, 1 whatever the lidar sees, 2 the robot, objects and people as they are seen, 3 the wheels as
they collide, and 4 who lies on the floor, as they collide.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco

from rai_missions.worlds.house import figures, rosbot
from rai_missions.worlds.house.layout import CRATE, DOORS, FURNITURE, PLACES, WALLS, Box
from rai_missions.worlds.house.objects import HouseObject
from rai_missions.worlds.house.people import Resident

__all__ = ("TIMESTEP_S", "build", "crate", "object_name", "person_name")

TIMESTEP_S = 0.005
AWAY_Z = -3.0
"""Where a crate waits while its door is free: below the floor."""


def crate(door: str) -> str:
    """The name of the body that blocks a door."""
    return f"crate_{door}"


def object_name(number: int) -> str:
    """The name of an object's body."""
    return f"object_{number}"


def person_name(number: int) -> str:
    """The name of a person's body."""
    return f"person_{number}"


def build(objects: Sequence[HouseObject] = (), people: Sequence[Resident] = ()) -> Any:
    """Compile the house."""
    meshes = figures.person_assets() if people else {}
    bodies = "".join(
        figures.person(person_name(number), number, (one.x, one.y), lies=one.plan.lies)
        for number, one in enumerate(people)
    )
    mesh_list = "".join(f'<mesh name="{name.removesuffix(".obj")}" file="{name}"/>' for name in meshes)
    xml = f"""<mujoco model="house"><compiler angle="degree"/>
<option timestep="{TIMESTEP_S}" integrator="implicitfast"/>
<visual><global offwidth="1280" offheight="960"/><quality shadowsize="0" offsamples="0"/><map znear=".01" zfar="20"/>
 <headlight ambient=".4 .4 .4" diffuse=".45 .45 .45" specular="0 0 0"/></visual>
<statistic extent="5" center="5 4 1"/>
<asset>
 <texture name="floor" type="2d" builtin="checker" rgb1=".66 .48 .31" rgb2=".62 .45 .29" width="256" height="256"/>
 <material name="floor" texture="floor" texrepeat="20 16" specular=".1"/>
 <texture type="skybox" builtin="flat" rgb1=".8 .85 .9" width="16" height="96"/>{mesh_list}</asset>
<worldbody>
 <light pos="2.5 6 2.4" diffuse=".4 .4 .38" castshadow="false"/>
 <light pos="7.5 2 2.4" diffuse=".4 .4 .38" castshadow="false"/>
 <geom name="floor" type="plane" pos="5 4 0" size="6 5 .1" material="floor" friction="1 .005 .0001"/>
 {"".join(_box(box) for box in (*WALLS, *FURNITURE.values()))}
 {"".join(_crate(door) for door in DOORS)}
 {"".join(_object(number, one) for number, one in enumerate(objects))}
 {bodies}
 {_dock()}
 {rosbot.body(PLACES["dock"])}
 <camera name="top" pos="5 4 9.2" xyaxes="1 0 0 0 1 0" fovy="52"/>
</worldbody><actuator>{rosbot.ACTUATORS}</actuator></mujoco>"""
    return mujoco.MjModel.from_xml_string(xml, meshes)


def _box(box: Box) -> str:
    (x, y), half = box.middle, box.height / 2
    size = f"{(box.east - box.west) / 2:.3f} {(box.north - box.south) / 2:.3f} {half:.3f}"
    return f'<geom type="box" pos="{x:.3f} {y:.3f} {half:.3f}" size="{size}" rgba="{box.colour} 1" group="1"/>'


def _object(number: int, one: HouseObject) -> str:
    return figures.figure(one.kind, one.colour, object_name(number), one.place, one.turn_deg)


def _crate(door: str) -> str:
    x, y = DOORS[door]
    size = " ".join(f"{half:.2f}" for half in CRATE)
    return (
        f'<body name="{crate(door)}" mocap="true" pos="{x} {y} {AWAY_Z}">'
        f'<geom type="box" size="{size}" rgba=".55 .42 .25 1" group="1"/></body>'
    )


def _dock() -> str:
    x, y, _ = PLACES["dock"]
    return (
        f'<geom type="box" pos="{x - 0.25} {y} .03" size=".04 .12 .03" rgba=".1 .5 .2 1" '
        'contype="0" conaffinity="0" group="0"/>'
    )
