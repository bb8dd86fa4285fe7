# SPDX-License-Identifier: Apache-2.0
"""A shipped mission in its simulated world, which lives on while the runs that drive it die after a row."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.answerers.rules import RulesAnswerer
from rai_missions.connectors.connector import Close, Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.runner import Runner
from rai_missions.worlds.world import World, open_world
from tests.replay.mortal import Fate, Land, live
from tests.rigs.journals import assert_whole, steps_of
from tests.trips import profile_of

__all__ = ("AfterRow", "KilledRun", "ShippedLand")

ROWS = ("write", "confirm", "note")


class AfterRow(Fate):
    """A process dies once it has written so many rows behind the first.

    Args:
        row: How many, from 1.
    """

    def __init__(self, row: int) -> None:
        super().__init__(is_done=True)
        self._rows = row

    def _is_next(self, what: str) -> bool:
        self._rows -= what in ROWS
        return self._rows == 0 and what in ROWS


class KilledRun(NamedTuple):
    """How a run ended that was killed."""

    outcome: str | None
    why: str
    is_led_by_doubt: bool
    """A transition was taken because an effect may have been carried out or not, or because a goal was orphaned."""


class Late(LocalConnector):
    """Delivers topics from an instant on."""

    from_s = 0.0

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Message], None]) -> Close:
        return super().subscribe(
            topic, type_name, lambda message: on_message(message) if self._now() >= self.from_s else None
        )


class ShippedLand(Land):
    """The world of a shipped mission; what runs in it may die.

    Args:
        folder: The folder of the mission.
        options: What the world takes, instead of what the profile has.
        arguments: The arguments of the mission.
        file: The mission in the folder.
    """

    def __init__(
        self, folder: Path, options: Mapping[str, Any], arguments: Mapping[str, Any], file: str = "mission.json"
    ) -> None:
        profile = profile_of(folder)
        taken = {**profile["connector"], **options}
        taken.pop("kind")
        self.robot = Robot.model_validate(profile)
        self.mission = given(load(folder / file), arguments)
        self.world: World = open_world(taken.pop("world"), **taken)
        self.period_s = self.world.period_s
        self.runner: Runner | None = None
        self.also: list[Callable[[], None]] = []
        self.late = self.connector = Late(now=lambda: self.world.at)
        self.connector.start()
        self.world.open(self.connector)
        rules = {state: [(rule.when, rule.answer) for rule in rows] for state, rows in self.robot.rules.items()}
        self.answerers = {"rules": RulesAnswerer(rules, keys=self.mission.blackboard)}

    @property
    def at(self) -> float:
        return self.world.at

    def step(self) -> None:
        self.world.step()

    def look(self, step: Step) -> None:
        """Shipped missions end by themselves."""

    def drive(self, path: Path, fates: list[Fate], dead_s: float = 0.0, deaf_s: float = 0.0) -> KilledRun:
        """Die as often as there are fates, then live to the end.

        Args:
            path: The journal.
            fates: How each process but the last one dies.
            dead_s: For so long the world is alone between two lives.
            deaf_s: For so long no topic reaches a process that resumes: a middleware has yet to find it.
        """
        for fate in (*fates, Fate()):
            if live(path, self, self.mission, self.robot, self.answerers, fate) is not None:
                break
            for _ in range(round(dead_s / self.period_s)):
                self.world.step()
            self.late.from_s = self.world.at + deaf_s
        return ended(path)

    def close(self) -> None:
        self.connector.stop()
        self.world.close()


def ended(path: Path) -> KilledRun:
    """How a run ended, as its journal has it."""
    again = assert_whole(path)
    doubts = (
        move.trigger in ("uncertain", "orphaned") and move.taken for step in steps_of(path) for move in step.moves
    )
    return KilledRun(again.outcome, again.why, any(doubts))


def given(mission: Mission, arguments: Mapping[str, Any]) -> Mission:
    """A mission whose arguments are these if nothing else is given."""
    keys = mission.blackboard
    changed = {name: keys[name].model_copy(update={"initial": value}) for name, value in arguments.items()}
    return mission.model_copy(update={"blackboard": {**keys, **changed}})
