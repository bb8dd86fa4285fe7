# SPDX-License-Identifier: Apache-2.0
"""The Panda with its hand as fragments of MJCF: links, joints, fingers and what drives them.

Rule: no element relies on a default class of the scene that it is pasted into. Angles are radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import NamedTuple

from rai_missions.worlds.desk.scene import Fragment

__all__ = (
    "FINGERS", "FINGER_JOINTS", "HOME", "JOINTS", "LAG_S", "LOWER", "MAX_WIDTH_M", "TCP", "TIP_BELOW_TCP_M", "UPPER",
    "bodies", "fragment",
)  # fmt: skip

JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
FINGERS = ("panda_leftfinger", "panda_rightfinger")
FINGER_JOINTS = ("panda_finger_joint1", "panda_finger_joint2")
TCP = "panda_tcp"
"""A site between the finger tips; z is the direction of approach, the fingers close along y."""
LOWER = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
UPPER = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
"""Limits of the joints, rad (Franka Control Interface, "Robot and interface specifications")."""
HOME = (0.0, -0.9, 0.0, -2.45, 0.0, 1.6, 0.785398)
"""Where the arm waits, rad: the hand above the base, so that the cameras see the desk."""
MAX_WIDTH_M = 0.08
TIP_BELOW_TCP_M = 0.009
"""How far the finger tips reach below the TCP."""
GRIP_N = 20.0
"""With what each finger presses at most."""


class ArmLink(NamedTuple):
    """One moving link: what of it collides is a hull, or several."""

    place: str
    """Attributes of its body."""
    axis_range: tuple[float, float] | None
    inertia: str
    hulls: tuple[str, ...]


LINKS = (
    ArmLink(
        "",
        None,
        'mass="0.629769" pos="-0.041018 -0.00014 0.049974" '
        'fullinertia="0.00315 0.00388 0.004285 8.2904e-7 0.00015 8.2299e-6"',
        ("link0.stl",),
    ),
    ArmLink(
        'pos="0 0 0.333"',
        (LOWER[0], UPPER[0]),
        'mass="4.970684" pos="0.003875 0.002081 -0.04762" '
        'fullinertia="0.70337 0.70661 0.009117 -0.000139 0.006772 0.019169"',
        ("link1.stl",),
    ),
    ArmLink(
        'quat="1 -1 0 0"',
        (LOWER[1], UPPER[1]),
        'mass="0.646926" pos="-0.003141 -0.02872 0.003495" '
        'fullinertia="0.007962 0.02811 0.025995 -0.003925 0.010254 0.000704"',
        ("link2.stl",),
    ),
    ArmLink(
        'pos="0 -0.316 0" quat="1 1 0 0"',
        (LOWER[2], UPPER[2]),
        'mass="3.228604" pos="0.027518 0.039252 -0.066502" '
        'fullinertia="0.037242 0.036155 0.01083 -0.004761 -0.011396 -0.012805"',
        ("link3.stl",),
    ),
    ArmLink(
        'pos="0.0825 0 0" quat="1 1 0 0"',
        (LOWER[3], UPPER[3]),
        'mass="3.587895" pos="-0.05317 0.104419 0.027454" '
        'fullinertia="0.025853 0.019552 0.028323 0.007796 -0.001332 0.008641"',
        ("link4.stl",),
    ),
    ArmLink(
        'pos="-0.0825 0.384 0" quat="1 -1 0 0"',
        (LOWER[4], UPPER[4]),
        'mass="1.225946" pos="-0.011953 0.041065 -0.038437" '
        'fullinertia="0.035549 0.029474 0.008627 -0.002117 -0.004037 0.000229"',
        ("link5_collision_0.obj", "link5_collision_1.obj", "link5_collision_2.obj"),
    ),
    ArmLink(
        'quat="1 1 0 0"',
        (LOWER[5], UPPER[5]),
        'mass="1.666555" pos="0.060149 -0.014117 -0.010517" '
        'fullinertia="0.001964 0.004354 0.005433 0.000109 -0.001158 0.000341"',
        ("link6.stl",),
    ),
    ArmLink(
        'pos="0.088 0 0" quat="1 1 0 0"',
        (LOWER[6], UPPER[6]),
        'mass="0.735522" pos="0.010517 -0.004252 0.061597" '
        'fullinertia="0.012516 0.010027 0.004815 -0.000428 -0.001196 -0.000741"',
        ("link7.stl",),
    ),
)
GAINS = (
    (4500, 450, 87),
    (4500, 450, 87),
    (3500, 350, 87),
    (3500, 350, 87),
    (2000, 200, 12),
    (2000, 200, 12),
    (2000, 200, 12),
)
"""The gains of the joints' position control: N·m/rad, N·m·s/rad, and the largest torque in N·m."""
LAG_S = 0.1
"""By what the position control lags at an even speed: the ratio of its gains."""
COLLIDES = 'contype="2" conaffinity="1"'
"""Links meet what is on the desk, and not each other."""
WHITE, GREY = 'rgba=".92 .92 .93 1"', 'rgba=".25 .25 .26 1"'


def fragment() -> Fragment:
    """The whole arm with its meshes; the base `panda_link0` is at the origin, on the desk's top."""
    files = mesh_files()
    assets = "".join(f'<mesh name="{_mesh(file)}" file="{file}"/>' for file in files)
    joints = zip(JOINTS, GAINS, LOWER, UPPER, strict=True)
    actuators = "".join(
        f'<position name="{name}" joint="{name}" kp="{kp}" kv="{kv}" forcelimited="true" forcerange="-{most} {most}" '
        f'ctrllimited="true" ctrlrange="{low} {high}"/>'
        for name, (kp, kv, most), low, high in joints
    )
    actuators += (
        f'<position name="panda_gripper" tendon="panda_split" kp="4000" kv="60" forcelimited="true" '
        f'forcerange="-{GRIP_N} {GRIP_N}" ctrllimited="true" ctrlrange="-0.02 {MAX_WIDTH_M}"/>'
    )
    extras = (
        '<tendon><fixed name="panda_split"><joint joint="panda_finger_joint1" coef="1"/>'
        '<joint joint="panda_finger_joint2" coef="1"/></fixed></tendon>'
        '<equality><joint joint1="panda_finger_joint1" joint2="panda_finger_joint2" solimp=".95 .99 .001" '
        'solref=".005 1"/></equality><sensor>'
        + "".join(f'<touch name="{finger}_touch" site="{finger}_pad"/>' for finger in FINGERS)
        + "</sensor>"
    )
    return Fragment(assets, files, bodies(), actuators, extras)


def bodies(*, hulls: bool = True) -> str:
    """The arm's bodies; without hulls they are joints and masses alone, as inverse kinematics need them."""
    nested = _hand(hulls=hulls)
    for number in reversed(range(len(LINKS))):
        link = LINKS[number]
        joint = ""
        if link.axis_range is not None:
            low, high = link.axis_range
            joint = (
                f'<joint name="{JOINTS[number - 1]}" axis="0 0 1" limited="true" range="{low} {high}" armature=".1" '
                'damping="1"/>'
            )
        geoms = "".join(_hull(file, WHITE) for file in link.hulls) if hulls else ""
        nested = (
            f'<body name="panda_link{number}" {link.place} gravcomp="1"><inertial {link.inertia}/>{joint}{geoms}'
            f"{nested}</body>"
        )
    return nested


@cache
def mesh_files() -> Mapping[str, bytes]:
    """File name → bytes of every mesh."""
    folder = resources.files("rai_missions.worlds.desk.panda") / "meshes"
    names = sorted(one.name for one in folder.iterdir() if one.name.endswith((".stl", ".obj")))
    return {f"panda_{name}": (folder / name).read_bytes() for name in names}


def _mesh(file: str) -> str:
    return file.rpartition(".")[0]


def _hull(name: str, colour: str) -> str:
    return f'<geom type="mesh" mesh="{_mesh("panda_" + name)}" group="1" mass="0" {COLLIDES} {colour}/>'


def _hand(*, hulls: bool) -> str:
    """The hand, 45° about the flange, its TCP and the two fingers, the right one turned by half a turn."""
    palm = _hull("hand.stl", WHITE) if hulls else ""
    fingers = _finger(1, "", hulls=hulls) + _finger(2, 'quat="0 0 0 1"', hulls=hulls)
    return (
        '<body name="panda_hand" pos="0 0 0.107" quat="0.9238795 0 0 -0.3826834" gravcomp="1">'
        '<inertial mass="0.73" pos="-0.01 0 0.03" diaginertia="0.001 0.0025 0.0017"/>'
        f'{palm}<site name="{TCP}" pos="0 0 0.1034" size=".004" rgba="0 0 0 0"/>{fingers}</body>'
    )


def _finger(number: int, turned: str, *, hulls: bool) -> str:
    """A finger: boxes collide, the pad flat against what is held; the meshes are seen only."""
    shapes = (
        '<geom type="mesh" mesh="panda_finger_0" contype="0" conaffinity="0" group="2" mass="0" '
        f'{WHITE}/><geom type="mesh" mesh="panda_finger_1" contype="0" conaffinity="0" group="2" mass="0" {GREY}/>'
        f'<geom name="{FINGERS[number - 1]}_pad" type="box" pos="0 .0055 .0445" size=".0085 .0055 .0092" group="3" '
        f'mass="0" friction="1.4 .01 .001" condim="4" solref=".006 1" {COLLIDES}/>'
        f'<site name="{FINGERS[number - 1]}_pad" type="box" pos="0 .0005 .0445" size=".0095 .003 .0102" group="4" '
        'rgba="0 0 0 0"/>'
        f'<geom type="box" pos="0 .014 .014" size=".0105 .012 .014" group="3" mass="0" {COLLIDES}/>'
    )
    return (
        f'<body name="{FINGERS[number - 1]}" pos="0 0 .0584" {turned} gravcomp="1">'
        '<inertial mass=".1" pos="0 .01 .02" diaginertia="5e-5 5e-5 1e-5"/>'
        f'<joint name="panda_finger_joint{number}" type="slide" axis="0 1 0" limited="true" range="0 .04" '
        f'armature=".1" damping="2"/>{shapes if hulls else ""}</body>'
    )
