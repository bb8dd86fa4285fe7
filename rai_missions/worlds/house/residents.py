# SPDX-License-Identifier: Apache-2.0
"""The people of one house, moved in its simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rai_missions.worlds.house.people import Resident
from rai_missions.worlds.house.scene import person_name

__all__ = ("Residents",)


class Residents:
    """Steps everyone, and puts their bodies where they are.

    Args:
        model: The compiled house.
        data: Its state.
        people: The people, in the order of their bodies.
    """

    def __init__(self, model: Any, data: Any, people: Sequence[Resident]) -> None:
        self._data, self.people = data, tuple(people)
        self._mocap = [model.body_mocapid[model.body(person_name(number)).id] for number in range(len(people))]
        for number in range(len(people)):
            self._put(number)

    def step(
        self, at: float, period_s: float, robot: tuple[float, float], blocked: Sequence[tuple[float, float]]
    ) -> None:
        """Let everyone live on for a period; see `Resident.step`."""
        for number, person in enumerate(self.people):
            others = [(other.x, other.y) for other in self.people if other is not person]
            if person.step(at, period_s, robot, (*blocked, *others)):
                self._put(number)

    def ask(self, at: float, robot: tuple[float, float]) -> None:
        """The robot asks everyone near for help."""
        for person in self.people:
            person.ask(at, robot)

    def helping(self, at: float) -> list[tuple[float, float]]:
        """Where those are who clear the way now."""
        return [(person.x, person.y) for person in self.people if person.begin_to_help(at)]

    def _put(self, number: int) -> None:
        person, half = self.people[number], self.people[number].heading / 2
        self._data.mocap_pos[self._mocap[number], :2] = person.x, person.y
        self._data.mocap_quat[self._mocap[number]] = math.cos(half), 0.0, 0.0, math.sin(half)
