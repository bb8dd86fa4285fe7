# SPDX-License-Identifier: Apache-2.0
"""Runs of the shipped missions, recorded: in several worlds, to every end, with answers of every kind, and resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.answerers.script import ScriptAnswerer
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.profile import Robot
from rai_missions.testing import ChatteringAnswerer, LateAnswerer
from tests.recorded.small import Run
from tests.replay.mortal import live
from tests.replay.shipped import AfterRow, ShippedLand
from tests.rosbot.conftest import ROSBOT, Patrol
from tests.tractor.conftest import TRACTOR, Drive
from tests.trips import Moments, Trip

__all__ = ("shipped",)

FREE = {"alleys": 1, "length_m": 12, "obstacles": ["none"]}
"""An orchard whose runs are short; no question is asked, so that no picture is kept."""
BLOCKED = {"blocked": ["study_pantry"], "recoveries": 0}
"""A house in which the way to one waypoint is shut."""
NEAR = {"waypoints": [{"x": 1.8, "y": 6.9, "yaw": 1.57, "frame": "map"}]}
BEHIND_THE_DOOR = {"waypoints": [{"x": 8.7, "y": 3.2, "yaw": 0.0, "frame": "map"}]}


def shipped() -> Iterator[Run]:
    """All of them."""
    for name, make in (("tractor", tractor), ("patrol", patrol)):
        for run, record in (*make(), *resumed(name)):
            yield f"{name}/{run}", record


def tractor() -> Iterator[Run]:
    yield "whole", trip(Drive, seed=1, **FREE)
    moments: Mapping[str, Moments] = {
        "paused": {4.0: lambda one: one.runner.pause(), 8.0: lambda one: one.runner.resume()},
        "canceled": {4.0: lambda one: one.runner.cancel("a person")},
        "killed": {4.0: lambda one: one.runner.kill("the button")},
        "stopped-by-an-event": {4.0: lambda one: one.post("e_stop")},
        "operator-and-back": {
            4.0: lambda one: one.runner.control("operator"),
            9.0: lambda one: one.runner.control("autonomy"),
        },
    }
    for number, (name, each) in enumerate(moments.items(), start=2):
        yield name, trip(Drive, each, seed=number, **FREE)
    yield "low-battery", trip(Drive, battery={"charge": 0.152, "capacity_wh": 400}, **FREE)
    yield "nothing-to-do", trip(Drive, words={"arguments": {"alleys": 0}}, **FREE)
    for obstacle in ("branch", "log", "person"):
        yield f"{obstacle}-by-rules", trip(Drive, **{**FREE, "obstacles": [obstacle]})
    liar = ChatteringAnswerer([{"option": "drive_over"}, "nonsense", None])
    yield "person-and-a-liar", trip(Drive, words={"answerers": {"agent": liar}}, **{**FREE, "obstacles": ["person"]})
    states = ScriptedModel(['{"option": "abort", "why": "a person must look"}'])
    yield "log-by-a-model", trip(Drive, words={"model": states}, **{**FREE, "obstacles": ["log"]})


def patrol() -> Iterator[Run]:
    yield "whole", trip(Patrol, words={"arguments": NEAR})
    moments: Mapping[str, Moments] = {
        "canceled": {6.0: lambda one: one.runner.cancel("a person")},
        "killed": {6.0: lambda one: one.runner.kill("the button")},
        "operator-and-back": {
            6.0: lambda one: one.runner.control("operator"),
            12.0: lambda one: one.runner.control("autonomy"),
        },
    }
    for name, each in moments.items():
        yield name, trip(Patrol, each, {"arguments": NEAR})
    scripts: Mapping[str, Mapping[str, Any]] = {
        "abort": {"agent": ScriptAnswerer({"deciding": ["abort"]})},
        "asks-an-operator": {
            "agent": ScriptAnswerer({"deciding": ["ask", "skip"]}),
            "operator": ScriptAnswerer({"asking": ["go_on"]}),
        },
        "refused": {"agent": ScriptAnswerer({"deciding": ["dance", {"option": 7}, {"why": "?"}, "dance", "skip"]})},
    }
    for name, who in scripts.items():
        yield f"agent-{name}", trip(Patrol, words={"answerers": who, "arguments": BEHIND_THE_DOOR}, **BLOCKED)
    yield "agent-late", late
    states = ['{"option": "dance"}', '{"option": "skip", "why": "the door is shut"}']
    yield "model", trip(Patrol, words={"model": ScriptedModel(states), "arguments": BEHIND_THE_DOOR}, **BLOCKED)


def trip(
    kind: Callable[..., Trip], moments: Moments | None = None, words: Mapping[str, Any] | None = None, **world: Any
) -> Callable[[Path], object]:
    """Records one run from its beginning to its end."""

    def record(path: Path) -> None:
        one = kind(world, moments or {}, journal=path, **(words or {}))
        try:
            one.run()
        finally:
            one.prepared.close()

    return record


def late(path: Path) -> None:
    """An answer to a question that was withdrawn, because its time was over, and then another to the next."""
    agent = LateAnswerer()

    def answer(one: Any) -> None:
        for number in agent.withdrawn:
            agent.answer(number, {"option": "abort"})

    moments = {float(at): answer for at in range(60, 200, 20)}
    trip(Patrol, moments, {"answerers": {"agent": agent}, "arguments": BEHIND_THE_DOOR}, **BLOCKED)(path)


def resumed(name: str) -> Iterator[Run]:
    """Killed after a row and resumed, in the world that lives on or in one that starts again."""

    def there() -> ShippedLand:
        if name == "tractor":
            return ShippedLand(TRACTOR, FREE, {"alleys": 1})
        return ShippedLand(ROSBOT, {"camera": False}, NEAR)

    def lived(*rows: int, **words: float) -> Callable[[Path], object]:
        def record(path: Path) -> None:
            with closing(there()) as world:
                world.drive(path, [AfterRow(row) for row in rows], **words)

        return record

    def again(path: Path) -> None:
        with closing(there()) as world:
            profile, options = world.robot.written(), FREE if name == "tractor" else {"camera": False}
            world.robot = Robot.model_validate({**profile, "connector": {**profile["connector"], **options}})
            live(path, world, world.mission, world.robot, world.answerers, AfterRow(8))
        with prepare(RunConfig(None, resume=path)) as prepared:
            prepared.runner.run()

    yield "resumed-twice", lived(9, 5)
    yield "resumed-in-another-world", again
    if name == "tractor":
        yield "resumed-late", lived(8, dead_s=60.0, deaf_s=1.0)
        for row in (4, 7):
            yield f"resumed-after-row-{row}", lived(row, dead_s=2.0)
