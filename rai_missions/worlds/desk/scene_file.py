# SPDX-License-Identifier: Apache-2.0
"""Which things are on the desk and where: from a file of JSON, from an option's value, or drawn from the seed.

Rule: what a scene names is checked whole before anything is built, and a fault is reported with its place (a JSON
pointer) and with what would be right. Where things overlap, the scene is not at fault: the world lifts them apart.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rai_missions.errors import UsageError, suggestion
from rai_missions.plain_data import is_number
from rai_missions.worlds.desk.catalogue import COLOURS, KINDS, free_name
from rai_missions.worlds.scene_files import read_scene_file

__all__ = ("DESK", "MOST", "DeskObject", "Scene", "desk_objects")

Scene = str | Mapping[str, Any] | None
"""The name of a file, its content, or None: drawn from the seed."""
DESK = (-0.2, -0.75, 0.95, 0.75)
"""Where a thing's middle may be: x and y from, x and y to, m in the frame `panda_link0`."""
HIGHEST_M = 0.6
MOST = 20
WORDS = ("about", "objects")
FIELDS = ("name", "type", "colour", "pose")
COORDINATES = ("x", "y", "z", "yaw")
MIDDLE, REACH_M = (0.3, 0.62, -0.36, 0.36), 0.72
"""Where the seed puts things: x from and to, y from and to, and no farther from the base than the arm reaches."""
APART_M = (0.0, 0.0, 0.01, 0.03, 0.06)
"""Gaps between the circles round two things that the seed draws from: some touch, most do not."""


@dataclass(frozen=True)
class DeskObject:
    """One thing, as a scene asks for it."""

    name: str
    """The scene's; those who see it give it a name of their own."""
    kind: str
    colour: str
    """Of a cube; else empty."""
    x: float
    y: float
    z: float
    """Of its middle, above the desk."""
    yaw: float


def desk_objects(scene: Scene, seed: int) -> tuple[DeskObject, ...]:
    """The things of a scene.

    Args:
        scene: See `Scene`.
        seed: What is not given (a cube's colour, a yaw, with None all) is drawn from it.

    Raises:
        UsageError: The scene cannot be read, or it is wrong; all faults are reported at once.
    """
    rng = random.Random(f"desk {seed}")
    if scene is None:
        return _drawn(rng)
    given = read_scene_file(scene) if isinstance(scene, str) else scene
    if not isinstance(given, Mapping):
        raise UsageError(f"scene: {given!r} is no object; give {{'objects': […]}}")
    faults = [f"/{word}: no such word{suggestion(str(word), WORDS)}" for word in given if word not in WORDS]
    objects = given.get("objects")
    if not isinstance(objects, Sequence) or isinstance(objects, str):
        faults.append(
            "/objects: a list is missing, as in [{'name': 'red_cube', 'type': 'cube', 'pose': {'x': 0.5, 'y': 0}}]"
        )
        objects = []
    if len(objects) > MOST:
        faults.append(f"/objects: {len(objects)} things; a desk has at most {MOST}")
    found: list[DeskObject] = []
    for number, one in enumerate(objects[:MOST]):
        read = _object(one, f"/objects/{number}", rng, [each.name for each in found], faults)
        if read is not None:
            found.append(read)
    if faults:
        raise UsageError("scene: " + "; ".join(faults))
    return tuple(found)


def _object(given: Any, place: str, rng: random.Random, taken: Sequence[str], faults: list[str]) -> DeskObject | None:
    if not isinstance(given, Mapping):
        faults.append(f"{place}: {given!r} is no object with {', '.join(FIELDS)}")
        return None
    before = len(faults)
    faults += [f"{place}/{word}: no such field{suggestion(str(word), FIELDS)}" for word in given if word not in FIELDS]
    kind, colour = _class(given, place, rng, faults)
    pose = _pose(given.get("pose"), f"{place}/pose", faults)
    name = given.get("name", free_name(kind, colour, taken))
    if not isinstance(name, str) or not name:
        faults.append(f"{place}/name: {name!r} is no name")
    elif name in taken:
        faults.append(f"{place}/name: two things are called {name!r}")
    if len(faults) > before:
        return None
    z = pose.get("z", KINDS[kind].size[2] / 2)
    return DeskObject(name, kind, colour, pose["x"], pose["y"], z, pose.get("yaw", 0.0))


def _class(given: Mapping[str, Any], place: str, rng: random.Random, faults: list[str]) -> tuple[str, str]:
    """Kind and colour: `red_cube` is a type too."""
    kind, colour = given.get("type"), given.get("colour")
    if isinstance(kind, str) and kind not in KINDS:
        first, _, rest = kind.partition("_")
        if first in COLOURS and rest in KINDS and KINDS[rest].has_colours:
            kind, colour = rest, colour if colour is not None else first
    if not isinstance(kind, str) or kind not in KINDS:
        faults.append(f"{place}/type: no type {kind!r}{suggestion(str(kind), KINDS)}")
        return "cube", "red"
    if not KINDS[kind].has_colours:
        if colour is not None:
            faults.append(f"{place}/colour: {kind} has a colour of its own; leave it out")
        return kind, ""
    named = str(given.get("name", "")).partition("_")[0]
    colour = colour if colour is not None else named if named in COLOURS else rng.choice(list(COLOURS))
    if colour not in COLOURS:
        faults.append(f"{place}/colour: no colour {colour!r}{suggestion(str(colour), COLOURS)}")
    return kind, str(colour)


def _pose(given: Any, place: str, faults: list[str]) -> dict[str, float]:
    if not isinstance(given, Mapping):
        faults.append(f"{place}: {given!r} is no pose; give {{'x': 0.5, 'y': 0.1}}, and z and yaw if you like")
        return {}
    for word, value in given.items():
        if word not in COORDINATES:
            faults.append(f"{place}/{word}: no such coordinate{suggestion(str(word), COORDINATES)}")
        elif not is_number(value):
            faults.append(f"{place}/{word}: {value!r} is no finite number")
    missing = [word for word in ("x", "y") if word not in given]
    faults += [f"{place}/{word}: is missing" for word in missing]
    limits = {"x": (DESK[0], DESK[2]), "y": (DESK[1], DESK[3]), "z": (0.0, HIGHEST_M), "yaw": (-7.0, 7.0)}
    for word, (least, most) in limits.items():
        value = given.get(word)
        if is_number(value) and not least <= value <= most:
            faults.append(f"{place}/{word}: {value:g} is off the desk; give {least:g} to {most:g}")
    return {word: float(value) for word, value in given.items() if is_number(value)}


def _drawn(rng: random.Random) -> tuple[DeskObject, ...]:
    """Four to eight things of different classes."""
    colours = rng.sample(list(COLOURS), rng.randint(2, 4))
    classes = [("cube", colour) for colour in colours]
    classes += [(kind, "") for kind in rng.sample(["apple", "tomato", "carrot", "corn"], rng.randint(1, 3))]
    classes += [(kind, "") for kind in rng.sample(["tray", "bin"], rng.randint(0, 1))]
    gap = rng.choice(APART_M)
    found: list[DeskObject] = []
    for kind, colour in sorted(classes, key=lambda one: -_radius(one[0])):
        place = _free_place(kind, found, gap, rng)
        if place is not None:
            name = free_name(kind, colour, [one.name for one in found])
            yaw = rng.uniform(-math.pi, math.pi)
            found.append(DeskObject(name, kind, colour, *place, KINDS[kind].size[2] / 2, yaw))
    return tuple(found)


def _radius(kind: str) -> float:
    return math.hypot(*KINDS[kind].size[:2]) / 2


def _free_place(kind: str, others: Sequence[DeskObject], gap: float, rng: random.Random) -> tuple[float, float] | None:
    west, east, south, north = MIDDLE
    for _ in range(300):
        x, y = rng.uniform(west, east), rng.uniform(south, north)
        is_free = all(math.dist((x, y), (one.x, one.y)) > _radius(kind) + _radius(one.kind) + gap for one in others)
        if is_free and math.hypot(x, y) <= REACH_M:
            return round(x, 4), round(y, 4)
    return None
