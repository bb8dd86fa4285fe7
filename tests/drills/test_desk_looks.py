# SPDX-License-Identifier: Apache-2.0
"""Looks at crowded desks: each error is within what is reported of it, and no class is wrong at the worst detector."""

from __future__ import annotations

import json
import math
from random import Random
from typing import Any

import pytest

from rai_missions.connectors.connector import Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world
from rai_missions.worlds.desk.catalogue import free_name
from rai_missions.worlds.desk.pixel_eye import PixelEye
from rai_missions.worlds.desk.posture import lean_of
from rai_missions.worlds.desk.ray_eye import RayEye
from rai_missions.worlds.desk.scene import object_name

pytestmark = [pytest.mark.sim, pytest.mark.drill, pytest.mark.timeout(900)]
CROWDED_DESKS, CLASS_DESKS = 60, 60
COLOURS = ("red", "green", "blue", "yellow", "orange", "purple", "white", "black")
KINDS = ("cube", "cube", "apple", "tomato", "carrot", "corn", "tray", "bin")
STRAIGHT_RAD = 0.05


def crowded(seed: int) -> dict[str, Any]:
    """A tower of two to five cubes, and eight things close around it and on each other."""
    rng = Random(f"crowded {seed}")
    x, y = rng.uniform(0.35, 0.6), rng.uniform(-0.25, 0.25)
    things = [
        ("cube", x + rng.gauss(0, 0.004), y + rng.gauss(0, 0.004), 0.022 + 0.045 * level, rng.uniform(0, 0.3))
        for level in range(rng.randint(2, 5))
    ]
    for _ in range(8):
        place = x + rng.uniform(-0.2, 0.2), y + rng.uniform(-0.22, 0.22)
        things.append((rng.choice(KINDS), *place, rng.choice((0.05, 0.1)), rng.uniform(-3, 3)))
    return {
        "objects": [
            {"name": f"{kind}_{number}", "type": kind, "pose": {"x": x, "y": y, "z": z, "yaw": yaw}}
            | ({"colour": COLOURS[number % len(COLOURS)]} if kind == "cube" else {})
            for number, (kind, x, y, z, yaw) in enumerate(things)
        ]
    }


def test_every_error_is_within_what_is_reported_of_it() -> None:
    off: dict[str, list[float]] = {"pixels": [], "rays": []}
    for seed in range(CROWDED_DESKS):
        world: Any = open_world("desk", scene=crowded(seed), seed=seed)
        kinds = {int(world.model.body(object_name(n)).id): one.kind for n, one in enumerate(world.objects)}
        eyes: dict[str, Any] = {"pixels": PixelEye(world.camera, kinds, seed), "rays": RayEye(world.model, kinds, seed)}
        for name, eye in eyes.items():
            for seen in eye.look(world.data, 1).bodies:
                if lean_of(kinds[seen.body], world.data.xmat[seen.body].reshape(3, 3)) < STRAIGHT_RAD:
                    true = world.data.xpos[seen.body]
                    off[name] += [abs(one - float(t)) / seen.sigma_m for one, t in zip(seen[1:4], true, strict=True)]
        world.close()
    for name, errors in off.items():
        square = math.sqrt(sum(error * error for error in errors) / len(errors))
        assert 0.2 < square < 1.2 and sum(error > 4 for error in errors) <= len(errors) / 500, name


def test_no_class_is_wrong_with_one_look_in_ten_wrong() -> None:
    wrong: list[tuple[int, set[str]]] = []
    for seed in range(CLASS_DESKS):
        world: Any = open_world("desk", seed=seed, camera=False, detector={"miss": 0.1, "swap": 0.1})
        facts: list[dict[str, Any]] = []

        def receive(message: Message, facts: list[dict[str, Any]] = facts) -> None:
            facts.append(json.loads(message.data["data"]))

        connector = LocalConnector(now=lambda world=world: world.at)  # type: ignore[misc]
        connector.subscribe("/desk/objects", "", receive)
        world.open(connector)
        connector.start()
        for _ in range(120):
            world.step()
        there = {free_name(one.kind, one.colour, ()) for one in world.objects}
        seen = {one["name"] for fact in facts for one in fact["things"]}
        if not seen <= there or {one["name"] for one in facts[-1]["things"]} != there:
            wrong.append((seed, seen ^ there))
    assert wrong == []
