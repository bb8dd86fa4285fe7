# SPDX-License-Identifier: Apache-2.0
"""What goes wrong at the desk: things slip, are dropped, pushed, moved and taken, and servers lie.

Rule: what happens, when and to which thing follows from the seed and from what the robot holds; nothing that is
published reports it.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from rai_missions.errors import UsageError, suggestion
from rai_missions.plain_data import is_number
from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.scene import object_name, put_free
from rai_missions.worlds.desk.scene_file import DESK, MIDDLE, DeskObject
from rai_missions.worlds.options import check_names, check_number

__all__ = ("DeskFaults", "FaultEvent", "FaultInjector")

EVENTS = ("push", "move", "take")
"""What a person does to a thing."""
PUSH_M_S = 0.5
"""How fast a pushed thing starts."""
SMOOTH = 0.004
"""Share of its friction that a slipping thing has: the fingers do not hold it."""
SLIP_S, DROP_S = 0.05, 1.0
"""How long; in the shorter time it sinks by about a centimetre, and the fingers hold it again."""
SHORTEST_S, LONGEST_S = 0.3, 2.5
"""When, after a grasp, it slips or drops."""
AWAY_M = (-0.1, -0.5, -0.7)
"""Where a person puts what they take: under the desk, where no camera sees it."""
AWAY_STEP_M = 0.32
"""Between two things there."""


class FaultEvent(NamedTuple):
    """One thing that a person does."""

    at_s: float
    """Since the start."""
    event: str
    thing: str
    """The scene's name."""
    x: float = 0.0
    """Where a moved thing goes; the direction of a push."""
    y: float = 0.0


@dataclass(frozen=True)
class DeskFaults:
    """How often what goes wrong."""

    slip: float = 0.0
    """How often a grasp slips a little, 0 to 1."""
    drop: float = 0.0
    """How often a grasp loses its thing, 0 to 1."""
    push: float = 0.0
    """How often a minute some thing is pushed."""
    move: float = 0.0
    """How often a minute a person puts some thing elsewhere on the desk."""
    take: float = 0.0
    """How often a minute a person takes some thing away."""
    lie: float = 0.0
    """How often a server reports the opposite of how a goal ended, 0 to 1."""
    plan: tuple[FaultEvent, ...] = ()
    """What happens at given times, in any order."""
    seed: int | None = None
    """Of when and to what; None: the world's."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | None, names: Sequence[str]) -> DeskFaults:
        """From plain data.

        Args:
            options: The fields; `plan` is a list of objects with the fields of `FaultEvent`.
            names: The scene's things.

        Raises:
            UsageError: A field or a thing does not exist, or a value is out of range.
        """
        given = dict(options or {})
        known = [field.name for field in fields(cls)]
        check_names("faults", given, known, called="option")
        for name, value in given.items():
            if name not in ("plan", "seed"):
                check_number(f"faults: {name}", value, 0, 60 if name in EVENTS else 1)
            if name == "seed" and not isinstance(value, int):
                raise UsageError(f"faults: seed takes a whole number, not {value!r}")
        plan = given.get("plan", ())
        if not isinstance(plan, Sequence) or isinstance(plan, str):
            raise UsageError(f"faults: plan takes a list of events, not {plan!r}")
        given["plan"] = tuple(_event(one, f"faults: /plan/{number}", names) for number, one in enumerate(plan))
        return cls(**given)


def _event(given: Any, place: str, names: Sequence[str]) -> FaultEvent:
    if not isinstance(given, Mapping):
        raise UsageError(f"{place}: {given!r} is no object with {', '.join(FaultEvent._fields)}")
    for word in given:
        if word not in FaultEvent._fields:
            raise UsageError(f"{place}/{word}: no such field{suggestion(str(word), FaultEvent._fields)}")
    if given.get("event") not in EVENTS:
        raise UsageError(f"{place}/event: no event {given.get('event')!r}; there are: {', '.join(EVENTS)}")
    if given.get("thing") not in names:
        raise UsageError(f"{place}/thing: no thing {given.get('thing')!r}{suggestion(str(given.get('thing')), names)}")
    for word in ("at_s", "x", "y"):
        value = given.get(word, 0.0)
        if not is_number(value):
            raise UsageError(f"{place}/{word}: {value!r} is no finite number")
    event = FaultEvent(**{"at_s": 0.0, **given})
    if event.event == "move" and not (DESK[0] <= event.x <= DESK[2] and DESK[1] <= event.y <= DESK[3]):
        raise UsageError(f"{place}: ({event.x:g}, {event.y:g}) is off the desk")
    return event


class FaultInjector:
    """Lets things go wrong in one simulation.

    Args:
        model, data: The simulation; friction is changed for a while in the model, and poses in the data.
        objects: The things, in the order of their bodies.
        faults: What goes wrong.
        seed: Used where the faults have none.
    """

    def __init__(self, model: Any, data: Any, objects: Sequence[DeskObject], faults: DeskFaults, seed: int) -> None:
        self._model, self._data, self._objects, self._faults = model, data, objects, faults
        self._rng = random.Random(f"faults {seed if faults.seed is None else faults.seed}")
        self._plan = sorted(faults.plan)
        self._gone: set[int] = set()
        self._held: int | None = None
        self._slippery: tuple[float, float, int] | None = None
        """From and until when, and which thing."""
        self._friction = np.array(model.geom_friction)

    def step(self, since_s: float, period_s: float, held: str) -> None:
        """Let happen what happens in a period.

        Args:
            since_s: Simulated seconds since the start.
            period_s: How long the period is.
            held: The thing that both fingers touch; else empty.
        """
        while self._plan and self._plan[0].at_s <= since_s:
            self._do(self._plan.pop(0), held)
        for event in EVENTS:
            rate = getattr(self._faults, event)
            if rate and self._rng.random() < rate * period_s / 60:
                self._do(self._drawn(event, since_s), held)
        self._grasp(since_s, held)

    def lies(self) -> bool:
        """Whether the server lies about the goal that ends now."""
        return bool(self._faults.lie) and self._rng.random() < self._faults.lie

    def _drawn(self, event: str, since_s: float) -> FaultEvent:
        there = [one.name for number, one in enumerate(self._objects) if number not in self._gone]
        thing = self._rng.choice(there) if there else ""
        if event == "push":
            turn = self._rng.uniform(-math.pi, math.pi)
            return FaultEvent(since_s, event, thing, math.cos(turn), math.sin(turn))
        west, east, south, north = MIDDLE
        return FaultEvent(since_s, event, thing, self._rng.uniform(west, east), self._rng.uniform(south, north))

    def _do(self, event: FaultEvent, held: str) -> None:
        if not event.thing or (event.thing == held and event.event == "push"):
            return  # the fingers hold it against a push; a person takes it out of them
        number = next(number for number, one in enumerate(self._objects) if one.name == event.thing)
        if event.event == "take":
            self._gone.add(number)
            x, y, z = AWAY_M
            place = x + AWAY_STEP_M / 2 * (number // 4), y + AWAY_STEP_M * (number % 4), z
            put_free(self._model, self._data, number, place, 0.0)
        elif event.event == "move":
            self._gone.discard(number)
            z = KINDS[self._objects[number].kind].size[2] / 2
            put_free(self._model, self._data, number, (event.x, event.y, z), self._rng.uniform(-math.pi, math.pi))
        else:
            long = math.hypot(event.x, event.y) or 1.0
            joint = self._data.joint(object_name(number))
            joint.qvel[:2] = [PUSH_M_S * event.x / long, PUSH_M_S * event.y / long]

    def _grasp(self, since_s: float, held: str) -> None:
        """Make a grasped thing slippery for a while, by chance."""
        number = next((number for number, one in enumerate(self._objects) if one.name == held), None)
        if number != self._held:
            self._held = number
            if number is not None and self._slippery is None:
                self._slippery = self._chance(since_s, number)
        if self._slippery is None:
            return
        begins, ends, slipping = self._slippery
        is_lost = since_s > begins and number != slipping
        if since_s >= ends or is_lost:
            self._slippery = None
        self._set_friction(slipping, SMOOTH if begins <= since_s < ends and not is_lost else 1.0)

    def _chance(self, since_s: float, number: int) -> tuple[float, float, int] | None:
        draw = self._rng.random()
        begins = since_s + self._rng.uniform(SHORTEST_S, LONGEST_S)
        if draw < self._faults.drop:
            return begins, begins + DROP_S, number
        if draw < self._faults.drop + self._faults.slip:
            return begins, begins + SLIP_S, number
        return None

    def _set_friction(self, number: int, factor: float) -> None:
        body = int(self._model.body(object_name(number)).id)
        geoms = np.flatnonzero(np.asarray(self._model.geom_bodyid) == body)
        self._model.geom_friction[geoms] = self._friction[geoms] * [factor, 1.0, 1.0]
        self._model.geom_priority[geoms] = int(factor < 1)  # else the larger friction of the two counts
