# SPDX-License-Identifier: Apache-2.0
"""Arrangements of things and goals over them, from a generator of random numbers: possible ones, and any."""

from __future__ import annotations

import itertools
import random
from typing import Any

from rai_missions.planning import Goal, Scene, Thing, read_goal
from tests.planning.scenes import SIZES, scene, thing

__all__ = ("KINDS", "any_goal", "arrangement", "goal_of_kind", "names_for", "target_goal")

CUBES = ("red_cube", "green_cube", "blue_cube", "yellow_cube", "white_cube", "red_cube_2", "green_cube_2")
FOOD = ("apple", "tomato", "carrot", "corn", "apple_2", "tomato_2")
CELLS = tuple((x, y) for x in (0.34, 0.5, 0.66) for y in (-0.2, 0.0, 0.2, 0.4))
CONTAINERS = {"tray": (0.55, -0.45), "bin": (0.28, -0.45)}
KINDS = ("at", "left_of", "behind", "between", "next_to", "tower", "grouped")
"""The kinds of goals that are asked for over one to nine things."""


def kind_of(name: str) -> str:
    return next(each for each in SIZES if each in name.split("_"))


def names_for(rng: random.Random, count: int) -> list[str]:
    """Names of things that can be moved, in any order."""
    return rng.sample([*CUBES, *FOOD], count)


def arrangement(rng: random.Random, names: list[str], *, containers: bool = True, stacked: float = 0.3) -> Scene:
    """Things at rest without overlap: on the desk, stacked on cubes, in the tray and in the bin."""
    cells, tops = rng.sample(CELLS, len(CELLS)), dict[str, Thing]()
    found = [thing(name, *place) for name, place in CONTAINERS.items()] if containers else []
    slots = [(0.45, -0.45), (0.55, -0.45), (0.65, -0.45)] if containers else []
    for name in names:
        if tops and rng.random() < stacked:
            lower = tops.pop(rng.choice(sorted(tops)))
            yaw = lower.yaw if kind_of(name) == "cube" else rng.uniform(-0.2, 0.2)
            made = thing(name, lower.x, lower.y, level=lower.top, yaw=yaw)
        elif slots and rng.random() < 0.15 and kind_of(name) not in ("carrot", "corn"):
            made = thing(name, *slots.pop(), level=0.005)
        else:
            x, y = cells.pop()
            # what is long lies across the robot's view
            turned = 1.57 if kind_of(name) in ("carrot", "corn") else 0.0
            made = thing(
                name, x + rng.uniform(-0.01, 0.01), y + rng.uniform(-0.01, 0.01), yaw=turned + rng.uniform(-0.1, 0.1)
            )
        if kind_of(name) == "cube" and made.top < 5.5 * 0.044:
            tops[name] = made
        found.append(made)
    return scene(*found)


def goal_from(predicates: list[dict[str, Any]]) -> Goal:
    found = read_goal({"all": predicates})
    assert isinstance(found, Goal)
    return found


def target_goal(rng: random.Random, target: Scene) -> Goal:
    """Some of what holds in an arrangement: so it can be reached."""
    found = list[dict[str, Any]]()
    for each in target.things:
        if each.type in ("tray", "bin"):
            continue
        lower = next(
            (
                other
                for other in target.things
                if other.type == "cube"
                and abs(other.top - each.bottom) < 0.001
                and abs(other.x - each.x) + abs(other.y - each.y) < 0.001
            ),
            None,
        )
        if lower is not None:
            found.append({"on": [each.name, lower.name]})
        elif abs(each.bottom - 0.005) < 0.001:
            found.append({"in": [each.name, "tray"]})
        else:
            if rng.random() < 0.5:
                found.append({"at": each.name, "x": round(each.x, 3), "y": round(each.y, 3)})
            if rng.random() < 0.5:
                found.append({"on": [each.name, "desk"]})
    return goal_from(found or [{"on": [target.things[-1].name, "desk"]}])


def goal_of_kind(rng: random.Random, kind: str, names: list[str]) -> Goal:
    """A goal of one kind over all of these things, as far as the kind allows."""
    names = rng.sample(names, len(names))
    cubes = [name for name in names if kind_of(name) == "cube"]
    found: list[dict[str, Any]]
    if kind == "at" or len(names) < 2:
        cells = rng.sample(CELLS, len(names))
        found = [{"at": name, "x": x, "y": y} for name, (x, y) in zip(names[:4], cells, strict=False)]
    elif kind == "left_of":
        found = [{"left_of": list(pair)} for pair in itertools.pairwise(names)]
        if rng.random() < 0.4:
            found = [{"left_of": names[:2], "gap_m": rng.choice([0.03, 0.05, 0.1])}]
    elif kind == "behind":
        found = [{"behind": list(pair)} for pair in zip(names[::2], names[1::2], strict=False)]
        if rng.random() < 0.4:
            found = [{"behind": names[:2], "gap_m": rng.choice([0.03, 0.05, 0.1])}]
    elif kind == "between" and len(names) >= 3:
        found = [{"between": names[:3]}]
    elif kind == "next_to":
        found = [{"next_to": list(pair)} for pair in zip(names[::2], names[1::2], strict=False)]
    elif kind == "tower" and len(cubes) >= 2:
        column = cubes[:6]
        found = [{"on": [column[0], "desk"]}] + [{"on": [b, a]} for a, b in itertools.pairwise(column)]
    else:
        found = [{"grouped": names}]
    return goal_from(found)


def any_goal(rng: random.Random, names: list[str]) -> Goal:
    """Predicates by chance, possible or not."""
    names = [*names, "tray", "bin"]
    found = list[dict[str, Any]]()
    for _ in range(rng.randint(1, 4)):
        kind = rng.choice(["on", "on", "at", "in", "left_of", "behind", "between", "next_to", "grouped", "apart"])
        pair = rng.sample([*names, "lemon"] if rng.random() < 0.1 else names, 2)
        if kind == "at":
            found.append({"at": pair[0], "x": round(rng.uniform(0.1, 1.0), 2), "y": round(rng.uniform(-0.8, 0.8), 2)})
        elif kind == "on" and rng.random() < 0.3:
            found.append({"on": [pair[0], "desk"]})
        elif kind == "in":
            found.append({"in": [pair[0], rng.choice(["tray", "tray", "bin", pair[1]])]})
        elif kind == "between":
            found.append({kind: rng.sample(names, 3)})
        elif kind in ("grouped", "apart"):
            found.append({kind: rng.sample(names[:-2], min(len(names) - 2, rng.randint(2, 4)))})
        else:
            found.append({kind: pair})
    return goal_from(
        [each for each in found if len(set(map(str, next(iter(each.values()))))) > 1 or "at" in each]
        or [{"on": [names[0], "desk"]}]
    )
