# SPDX-License-Identifier: Apache-2.0
"""Desks on which things touch, crowd, lie far or near, rest on each other or lean; goals of every kind on them."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from tests.desk.episodes import ArrangeTrip, judged
from tests.desk.plain_judge import unmet
from tests.desk.scenes import COLOURS, ROUND

__all__ = ("DESKS", "GOALS", "HardCase", "HardEnd", "combined_faults", "hard_case", "played_hard")

CUBE = 0.044
TALL = {"cube": CUBE, "apple": 0.064, "tomato": 0.054, "carrot": 0.04, "corn": 0.044, "tray": 0.03, "bin": 0.1}
RADIUS = {
    "cube": 0.0312, "apple": 0.034, "tomato": 0.032, "carrot": 0.073, "corn": 0.083, "tray": 0.181, "bin": 0.128
}  # fmt: skip
Plain = dict[str, Any]


class HardCase(NamedTuple):
    """One request at one desk, and what it means there."""

    seed: int
    desk: str
    kind: str
    request: str
    goal: Sequence[Mapping[str, Any]]
    """Over the scene's names; a swap over the poses of the scene that has come to rest."""
    world: Mapping[str, Any]


class HardDesk:
    """A desk that is laid thing by thing.

    Args:
        rng: What everything is drawn from.
    """

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.objects: list[Plain] = []
        self.circles: list[tuple[float, float, float]] = []
        self.colours = rng.sample((*COLOURS, "white", "black"), 8)

    def lay(self, kind: str, at: tuple[float, float] | None = None, z: float | None = None, **limits: float) -> str:
        """Lay a thing at a place, or somewhere with `gap_m` round it, between `least_m` and `most_m` from the base."""
        colour = self.colours.pop() if kind == "cube" else ""
        name = f"{colour}_cube" if colour else kind
        x, y = at or self.free(RADIUS[kind], **limits)
        pose = {"x": round(x, 4), "y": round(y, 4), "yaw": round(self.rng.uniform(-3, 3), 3)}
        if z is not None:
            pose |= {"z": z, "yaw": 0.2}
        self.objects.append({"name": name, "type": kind, **({"colour": colour} if colour else {}), "pose": pose})
        self.circles.append((x, y, RADIUS[kind]))
        return name

    def free(
        self, radius: float, gap_m: float = 0.03, least_m: float = 0.34, most_m: float = 0.7
    ) -> tuple[float, float]:
        for _ in range(3000):
            far, turn = self.rng.uniform(least_m, most_m), self.rng.uniform(-1.0, 1.0)
            x, y = far * math.cos(turn), far * math.sin(turn)
            if all(math.dist((x, y), (u, v)) > radius + other + gap_m for u, v, other in self.circles):
                return x, y
        raise ValueError("no room")

    def names(self, *kinds: str) -> list[str]:
        return [one["name"] for one in self.objects if one["type"] in kinds]


# -- desks -------------------------------------------------------------------------------------------------------------


def touching(desk: HardDesk) -> None:
    """A block of cubes that touch, turned as one."""
    turn, count = desk.rng.uniform(-1.5, 1.5), desk.rng.randint(2, 4)
    x, y = desk.rng.uniform(0.42, 0.55), desk.rng.uniform(-0.2, 0.2)
    step = CUBE + desk.rng.choice((0.0, 0.001, 0.004))
    for number in range(count):
        u, v = step * (number % 2), step * (number // 2)
        place = x + u * math.cos(turn) - v * math.sin(turn), y + u * math.sin(turn) + v * math.cos(turn)
        desk.lay("cube", place)
        desk.objects[-1]["pose"]["yaw"] = round(turn, 3)
    for kind in desk.rng.sample(ROUND, desk.rng.randint(0, 2)):
        desk.lay(kind)


def crowded(desk: HardDesk) -> None:
    """Seven to nine things, some of them with no room between."""
    for _ in range(desk.rng.randint(3, 5)):
        desk.lay("cube", gap_m=desk.rng.choice((0.0, 0.005, 0.015, 0.03)), least_m=0.36, most_m=0.6)
    for kind in ROUND:
        desk.lay(kind, gap_m=desk.rng.choice((0.002, 0.01, 0.02)), least_m=0.36, most_m=0.66)


def far(desk: HardDesk) -> None:
    for _ in range(desk.rng.randint(1, 3)):
        desk.lay("cube", gap_m=0.04, least_m=0.72, most_m=0.8)
    desk.lay("cube")
    desk.lay(desk.rng.choice(ROUND), gap_m=0.04, most_m=0.75)


def near(desk: HardDesk) -> None:
    for _ in range(desk.rng.randint(1, 3)):
        desk.lay("cube", gap_m=0.04, least_m=0.29, most_m=0.34)
    desk.lay("cube")
    desk.lay(desk.rng.choice(ROUND), gap_m=0.04, least_m=0.32, most_m=0.5)


def tall(desk: HardDesk) -> None:
    """A tower is built already, and cubes around it."""
    x, y = desk.rng.uniform(0.4, 0.6), desk.rng.uniform(-0.25, 0.25)
    for level in range(desk.rng.randint(2, 4)):
        desk.lay("cube", (x + desk.rng.uniform(-0.004, 0.004), y), z=CUBE * (level + 0.5) + 0.001)
    for _ in range(desk.rng.randint(1, 2)):
        desk.lay("cube")


def leaning(desk: HardDesk) -> None:
    """A thing that was let fall with half of it over another."""
    lower = desk.lay("cube")
    x, y, _ = desk.circles[-1]
    kind = desk.rng.choice(("cube", "carrot", "corn"))
    desk.lay(kind, (x + desk.rng.choice((-1, 1)) * desk.rng.uniform(0.026, 0.04), y), z=CUBE + TALL[kind] / 2 + 0.002)
    assert lower
    for _ in range(2):
        desk.lay("cube", gap_m=0.05)


def on_tray(desk: HardDesk) -> None:
    """Things that lie on a tray or in a bin at first."""
    holder = desk.rng.choice(("tray", "tray", "bin"))
    desk.lay(holder, least_m=0.45, most_m=0.6)
    x, y, _ = desk.circles[-1]
    yaw = desk.objects[-1]["pose"]["yaw"]
    for side in (-1, 1) if holder == "tray" else (0,):
        along = side * 0.07
        desk.lay("cube", (x + along * math.cos(yaw), y + along * math.sin(yaw)), z=CUBE / 2 + 0.01)
    for _ in range(2):
        desk.lay("cube")
    desk.lay(desk.rng.choice(("apple", "tomato")))


def under(desk: HardDesk) -> None:
    """What is wanted is under another thing."""
    for _ in range(2):
        desk.lay("cube", gap_m=0.05)
        x, y, _ = desk.circles[-1]
        desk.lay(desk.rng.choice(("cube", "cube", "carrot")) if not desk.names("carrot") else "cube", (x, y), z=0.0665)
    desk.lay(desk.rng.choice(("apple", "tomato", "corn")))


DESKS: Mapping[str, Callable[[HardDesk], None]] = {
    each.__name__: each for each in (touching, crowded, far, near, tall, leaning, on_tray, under)
}


# -- goals -------------------------------------------------------------------------------------------------------------


def spoken(name: str) -> str:
    return "the " + name.replace("_", " ")


def listed(names: Sequence[str]) -> str:
    return ", ".join(spoken(name) for name in names[:-1]) + " and " + spoken(names[-1])


def _cubes(desk: HardDesk, number: int) -> list[str]:
    return desk.rng.sample(desk.names("cube"), number)


def at(desk: HardDesk) -> tuple[str, list[Plain]]:
    (name,) = _cubes(desk, 1)
    x, y = desk.free(RADIUS["cube"], gap_m=0.04, least_m=0.38, most_m=0.66)
    x, y = round(x, 2), round(y, 2)
    return f"put {spoken(name)} at x {x} y {y}", [{"at": name, "x": x, "y": y}]


def left(desk: HardDesk) -> tuple[str, list[Plain]]:
    one, other = desk.rng.sample(desk.names("cube", *ROUND), 2)
    return f"{spoken(one)} should be to the left of {spoken(other)}", [{"left_of": [one, other]}]


def close(desk: HardDesk) -> tuple[str, list[Plain]]:
    one, other = desk.rng.sample(desk.names("cube", *ROUND), 2)
    return f"move {spoken(one)} next to {spoken(other)}", [{"next_to": [one, other]}]


def tower(desk: HardDesk) -> tuple[str, list[Plain]]:
    names = _cubes(desk, min(len(desk.names("cube")), desk.rng.randint(2, 4)))
    request = "from bottom to top: " + ", ".join(spoken(name) for name in names)
    return request, [
        {"on": [names[0], "desk"]},
        *({"on": [up, low]} for low, up in pairwise(names)),
    ]


def grouped(desk: HardDesk) -> tuple[str, list[Plain]]:
    names = desk.names("cube")
    return "gather the cubes", [{"grouped": names}]


def apart(desk: HardDesk) -> tuple[str, list[Plain]]:
    names = _cubes(desk, 2)
    return f"move {listed(names)} apart from each other", [{"apart": names}]


def on(desk: HardDesk) -> tuple[str, list[Plain]]:
    one, other = _cubes(desk, 2)
    return f"place {spoken(one)} on {spoken(other)}", [{"on": [one, other]}]


def inside(desk: HardDesk) -> tuple[str, list[Plain]]:
    holders = desk.names("tray", "bin") or [desk.lay("tray", gap_m=0.005, least_m=0.45, most_m=0.62)]
    names = desk.rng.sample(desk.names("cube", *ROUND), desk.rng.randint(1, 2) if holders == ["tray"] else 1)
    request = f"put {listed(names) if len(names) > 1 else spoken(names[0])} in {spoken(holders[0])}"
    return request, [{"in": [name, holders[0]]} for name in names]


def swapped(desk: HardDesk) -> tuple[str, list[Plain]]:
    one, other = _cubes(desk, 2)
    return f"swap {spoken(one)} and {spoken(other)}", [{"swapped": [one, other]}]


GOALS: Mapping[str, Callable[[HardDesk], tuple[str, list[Plain]]]] = {
    each.__name__: each for each in (at, left, close, tower, grouped, apart, on, inside, swapped)
}


def hard_case(seed: int, **world: Any) -> HardCase:
    """The case of a seed: each desk with each goal in turn."""
    desks, goals = [*DESKS], [*GOALS]
    lay, kind = desks[seed % len(desks)], goals[seed // len(desks) % len(goals)]
    for again in range(200):
        desk = HardDesk(random.Random(f"outside {seed} {again}"))
        try:
            DESKS[lay](desk)
            request, goal = GOALS[kind](desk)
        except ValueError:
            continue
        return HardCase(seed, lay, kind, request, goal, {"seed": seed, "scene": {"objects": desk.objects}, **world})
    raise ValueError(f"no desk for seed {seed}")


def combined_faults(seed: int) -> dict[str, Any]:
    """Faults that come together: the world's options for a seed."""
    rng = random.Random(f"combined {seed}")
    wrong = {
        "slip": rng.choice((0, 0.3, 0.6)), "drop": rng.choice((0, 0.3, 0.6)), "push": rng.choice((0, 3, 8)),
        "move": rng.choice((0, 2, 4)), "take": rng.choice((0, 0.5, 1)), "lie": rng.choice((0, 0.3, 0.7, 1.0)),
    }  # fmt: skip
    looks = {"miss": rng.choice((0, 0.1)), "swap": rng.choice((0, 0.1))}
    return {"faults": {name: rate for name, rate in wrong.items() if rate}, "detector": looks}


class HardEnd(NamedTuple):
    """How a case ended, by two judges."""

    case: HardCase
    outcome: str
    state: str
    unmet: tuple[str, ...]
    """What is not so of what was asked for, by the plain judge."""
    is_so: bool | None
    """By the judge of the goal as it was read."""
    moves: int
    cpu_s: float
    why: str

    @property
    def is_false_success(self) -> bool:
        return self.outcome == "succeeded" and bool(self.unmet or not self.is_so)

    @property
    def is_false_failure(self) -> bool:
        return self.outcome != "succeeded" and not self.unmet


def played_hard(case: HardCase) -> HardEnd:
    """Run a case to its end, and judge it."""
    begun = time.process_time()
    one = ArrangeTrip(case.world, arguments={"request": case.request}, speed=None)
    try:
        result = one.run()
        spent = time.process_time() - begun
        missing: tuple[str, ...] = ("nothing was read",)
        if one.first is not None and one.truth is not None:
            missing = tuple(unmet([*_without_swaps(case.goal, one)], one.truth))
        return HardEnd(
            case,
            result.outcome,
            "/".join(result.state),
            missing,
            judged(one),
            one.entered.count("moving"),
            spent,
            one.report or result.why,
        )
    finally:
        one.prepared.close()


def _without_swaps(goal: Sequence[Mapping[str, Any]], one: ArrangeTrip) -> Iterator[Mapping[str, Any]]:
    """The goal, a swap as the places that the two truly had when it was read."""
    assert one.first is not None
    _, truth = one.first
    for each in goal:
        if "swapped" not in each:
            yield each
            continue
        for name, place in zip(each["swapped"], reversed(each["swapped"]), strict=True):
            yield {"at": name, "x": truth.things[place].x, "y": truth.things[place].y}
