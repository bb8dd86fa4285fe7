# SPDX-License-Identifier: Apache-2.0
"""Surroundings that misbehave, on a simulated time: servers, services and topics, and what a connector puts off.

Rule: what they do follows from their seed.
"""

from __future__ import annotations

import heapq
import itertools
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Any

from rai_missions.connectors.connector import Connector, Report
from rai_missions.engine.decision import Question
from rai_missions.event import Event
from rai_missions.profile import Robot
from rai_missions.runtime.clock import Steppable
from rai_missions.runtime.runner import Runner
from tests.strategies import SIGHTS

__all__ = ("ANY_ROBOT", "AnyAnswers", "Field", "PostponingWorld", "quick_folder", "quick_tempers")

TRIGGER = "std_srvs/srv/Trigger"
ANY_ROBOT = Robot.model_validate(
    {
        "name": "any",
        "blackboard": {
            "battery": {"topic": "/battery", "type": "sensor_msgs/msg/BatteryState", "field": "percentage"},
            "clear": {"topic": "/clear", "type": "std_msgs/msg/Bool"},
            "pose": {"topic": "/pose", "type": "geometry_msgs/msg/PoseStamped"},
            "obstacle": {"topic": "/obstacle", "type": "std_msgs/msg/String", "json": True},
            "objects": {"topic": "/objects", "type": "std_msgs/msg/String", "json": True},
        },
        "events": {name: {"posted": True} for name in ("anomaly", "halt", "poke", "hint")},
        "actions": {
            name: {"action": f"/{name}", "type": "x/action/X", "uses": ["base"]}
            for name in ("drive", "cross", "go_home")
        },
        "services": {"horn": {"service": "/horn", "type": TRIGGER}, "replan": {"service": "/replan", "type": TRIGGER}},
        "topics": {"lamp": {"topic": "/lamp", "type": "x/msg/Lamp"}},
    }
)
"""The profile of what the generated missions name."""


MEMORY = Path("/dev/shm")
ROOM_BYTES = 500_000_000
MOST_STEPS = 3000
"""Those of a generated mission whose answers lead round and round."""


@contextmanager
def quick_folder() -> Iterator[Path]:
    """A folder that is gone at the end, in memory where there is room: most of a short run's time goes to the disk."""
    has_room = os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > ROOM_BYTES
    with tempfile.TemporaryDirectory(prefix="drill-", dir=MEMORY if has_room else None) as folder:
        yield Path(folder)


class PostponingWorld:
    """A world whose steps bring what was put off, when its time has come.

    Args:
        world: Stepped as ever.
    """

    def __init__(self, world: Steppable) -> None:
        self.world, self.period_s = world, world.period_s
        self._put_off: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()

    @property
    def at(self) -> float:
        return self.world.at

    def later(self, seconds: float, do: Callable[[], None]) -> None:
        heapq.heappush(self._put_off, (self.at + seconds, next(self._order), do))

    def step(self) -> None:
        self.world.step()
        while self._put_off and self._put_off[0][0] <= self.at:
            heapq.heappop(self._put_off)[2]()


class Field:
    """A robot of which nothing is certain.

    Args:
        connector: Where it is reached, without what chaos adds.
        seed: All that it does follows from it.
        ends_s: When a person stops the run, so that it ends whatever the mission is; sooner if it goes round and round.
    """

    period_s = 0.5

    def __init__(self, connector: Connector, seed: object, ends_s: float) -> None:
        self.random, self._connector, self._ends_s = Random(f"field {seed}"), connector, ends_s
        self._ticks = 0
        self._is_stopped = False
        self.runner: Runner | None = None
        self.goals: dict[str, Callable[[Report], None]] = {}
        """The goals that run now."""
        self._plans: list[tuple[float, Callable[[], None]]] = []
        self._closes: dict[str, Callable[[], None]] = {}
        for name in ("drive", "cross", "go_home"):
            self._closes[name] = connector.offer(f"/{name}", "x/action/X", self)
        for name in ("horn", "replan"):
            connector.serve(f"/{name}", TRIGGER, self._serve)

    @property
    def at(self) -> float:
        return self._ticks * self.period_s

    def step(self) -> None:
        self._ticks += 1
        due, self._plans = (
            [do for at, do in self._plans if at <= self.at],
            [plan for plan in self._plans if plan[0] > self.at],
        )
        for do in due:
            do()
        self._say()
        self._happen()

    def _say(self) -> None:
        random, publish = self.random, self._connector.publish
        publish("/battery", "sensor_msgs/msg/BatteryState", {"percentage": random.choice([0.05, 0.3, 0.9])})
        position = {"position": {"x": random.uniform(-1, 1), "y": 0.0, "z": 0.0}, "orientation": {"w": 1.0}}
        publish("/pose", "geometry_msgs/msg/PoseStamped", {"header": {"frame_id": "map"}, "pose": position})
        if random.random() < 0.5:
            publish("/clear", "std_msgs/msg/Bool", {"data": random.random() < 0.5})
            text = random.choice(['{"kind": "log", "height_m": 0.1, "living": false}', '{"living": true}', "{", "[]"])
            publish("/obstacle", "std_msgs/msg/String", {"data": text})
            seen = random.choice([*map(json.dumps, SIGHTS), "{", '{"things": 1}'])
            publish("/objects", "std_msgs/msg/String", {"data": seen})

    def _happen(self) -> None:
        assert self.runner is not None
        if self.random.random() < 0.1:
            name = self.random.choice(["anomaly", "halt", "poke", "unheard_of"])
            self.runner.post(Event(name, self.at))
        goes_round = self.runner.view.seq > MOST_STEPS
        if self.at == self._ends_s or (goes_round and not self._is_stopped):
            self._is_stopped = True
            self.runner.cancel()
        if self.at >= self._ends_s + 30.0:
            self.runner.kill()

    def _serve(self, request: Mapping[str, Any]) -> Mapping[str, Any]:
        if self.random.random() < 0.2:
            raise RuntimeError("the service is out of order")
        return self.random.choice([{"success": True, "message": ""}, {"success": False, "message": "no"}, {}])

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        """What becomes of a goal is settled as it comes."""
        random = self.random
        words = random.choice([
            (), ("rejected",), ("accepted",), ("accepted", "succeeded"), ("accepted", "failed", "succeeded"),
            ("succeeded",), ("accepted", "succeeded", "succeeded"), ("accepted", "feedback", "exploded"),
            ("accepted", "lost"), ("accepted", "accepted", "canceled"),
        ])  # fmt: skip
        self.goals[goal_id] = report
        after_s = 0.0
        for word in words:
            self._plan(after_s, lambda word=word: self._report(goal_id, word))
            after_s += random.choice([0.0, 0.5, 2.0, 40.0])
        if random.random() < 0.05:
            self.goals.pop(goal_id, None)
            raise RuntimeError("the server dies of this goal")

    def cancel(self, goal_id: str) -> None:
        word = self.random.choice(["canceled", "canceled", "canceled", "cancel_rejected", "succeeded", ""])
        if word:
            self._plan(self.random.choice([0.0, 0.5, 3.0]), lambda: self._report(goal_id, word))

    def _plan(self, after_s: float, do: Callable[[], None]) -> None:
        if after_s:
            self._plans.append((self.at + after_s, do))
        else:
            do()

    def _report(self, goal_id: str, status: str) -> None:
        report = self.goals.get(goal_id)
        if status in ("rejected", "succeeded", "failed", "canceled", "lost"):
            self.goals.pop(goal_id, None)
        if report is not None:
            report(Report(goal_id, status, {}))  # type: ignore[arg-type]


class AnyAnswers:
    """Answers each question at once, and perhaps again, with any of its options, or with nothing that is one.

    Never with silence: while someone thinks, simulated time goes no faster than the wall's.

    Args:
        random: Which.
    """

    def __init__(self, random: Random) -> None:
        self._random = random

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        names = [offer.name for offer in question.options]
        reported = {"option": self._random.choice([*names, *names, "fly"])}
        answer(self._random.choice([reported, reported, reported, {"absent": "not here"}, {"failed": "no idea"}]))
        if self._random.random() < 0.2:
            answer(reported)

    def withdraw(self, number: int) -> None:
        pass


def quick_tempers(random: Random) -> Mapping[str, AnyAnswers]:
    """Someone for each name in `ask`."""
    return {name: AnyAnswers(random) for name in ("agent", "operator", "rules")}
