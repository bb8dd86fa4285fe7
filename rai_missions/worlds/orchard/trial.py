# SPDX-License-Identifier: Apache-2.0
"""What each option of the tractor's decision leads to, tried in a world of its own: driven to the obstacle, then on.

Rule: what is reported is what the judge of the physics measured. A thing is tried through the services that a mission
calls, with a detector that errs in nothing, and nothing is rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.worlds.options import check_names
from rai_missions.worlds.orchard.world import Orchard

__all__ = ("OPTIONS", "Trial", "decision_world", "try_branch", "try_options")

ARRIVES_S, CROSSES_S, RETURNS_S, DRIVES_S = 60.0, 40.0, 150.0, 60.0
SIGNALS, SIGNAL_S, HALTS_S = 3, 5.0, 2.0
"""A mission signals three times at most, waits after each, and looks again."""


@dataclass(frozen=True)
class Trial:
    """What an option led to."""

    driven: bool
    """The alley of the obstacle was driven from end to end."""
    harmed: str
    """`living`, `thing` or `tractor`; empty: nothing took harm."""
    why: str
    """What the judge found, in words; empty where there is nothing to report."""
    seconds: float
    """Simulated, from the decision on."""
    contact_n: float
    """The strongest force between the tractor and the obstacle while it crossed it, N."""
    chassis_n: float
    """The strongest force between the obstacle and anything but the tyres, N."""
    broke_n: float
    """The strongest force on a thing that broke, N."""
    pitch_deg: float
    roll_deg: float
    moved_m: float
    """How far the obstacle was moved."""


def decision_world(options: Mapping[str, Any], listen: Callable[[Orchard], None] = lambda world: None) -> Orchard:
    """An orchard whose tractor has stopped for its obstacle and hands over.

    Args:
        options: Keywords of `Orchard`.
        listen: Is given the orchard before it begins, to receive what it reports on the way.

    Raises:
        UsageError: Nothing stopped the tractor.
    """
    world = Orchard(**options)
    listen(world)
    world.call("continue")
    if not _run(world, lambda: world.autonomy.word == "STOPPED", ARRIVES_S):
        raise UsageError("nothing stopped the tractor: there is no decision in this scene")
    _run(world, lambda: abs(world.pose.speed) < 0.02, 5.0)
    return world


def try_options(options: Mapping[str, Any], tried: Iterable[str] | None = None) -> dict[str, Trial]:
    """Roll options out, each on a branch of the world in which they are open.

    Args:
        options: Keywords of `Orchard`; the detector and the camera in them are replaced.
        tried: Some of `OPTIONS`; None: all.

    Raises:
        UsageError: No such option, or there is no decision in the scene.
    """
    tried = tuple(OPTIONS if tried is None else tried)
    check_names("the decision at the obstacle", tried, OPTIONS, called="option")
    world = decision_world({**options, "camera": False, "sight": "geometry", "detector": {"noise": 0.0}})
    return {option: try_branch(world, option) for option in tried}


def try_branch(decided: Orchard, option: str) -> Trial:
    """Roll an option out on a branch of a world in which it is open; that world stays as it is."""
    world = decided.branch()
    begun = world.at
    OPTIONS[option](world)
    return _trial(world, world.at - begun)


def _drive_over(world: Orchard) -> None:
    world.call("drive_over")
    _run(world, lambda: _is_over(world) or _crossed(world) == "failed", CROSSES_S)


def _replan(world: Orchard) -> None:
    world.call("replan")
    world.step()
    _run(world, lambda: _is_over(world) or world.autonomy.word in ("STOPPED", "FINISHED"), RETURNS_S)


def _signal(world: Orchard) -> None:
    """As often as a mission may, until the way is free; then on."""
    for _ in range(SIGNALS):
        world.call("flash")
        _run(world, lambda: world.is_way_free or _is_over(world), SIGNAL_S)
        if world.is_way_free:
            world.call("continue")
            _run(world, lambda: _is_over(world) or world.autonomy.word == "STOPPED", DRIVES_S)
            return


def _halt(world: Orchard) -> None:
    world.call("stop")
    _run(world, lambda: False, HALTS_S)


OPTIONS: Mapping[str, Callable[[Orchard], None]] = {
    "drive_over": _drive_over,
    "replan": _replan,
    "signal": _signal,
    "abort": _halt,
}


def _is_over(world: Orchard) -> bool:
    return bool(world.judge.touched or world.judge.broken) or _alley(world) in world.counter.alleys


def _alley(world: Orchard) -> int:
    return world.obstacles[0].alley


def _crossed(world: Orchard) -> str:
    return world.judge.crossing.outcome if world.judge.crossing is not None else ""


def _trial(world: Orchard, seconds: float) -> Trial:
    judge, crossing = world.judge, world.judge.crossing
    assert crossing is not None
    harmed = "living" if judge.touched else "thing" if judge.broken else crossing.harmed
    why = crossing.why or ("touched something alive" if judge.touched else "broke it" if judge.broken else "")
    return Trial(
        driven=_alley(world) in world.counter.alleys,
        harmed=harmed,
        why=why,
        seconds=round(seconds, 2),
        contact_n=round(crossing.contact_n, 1),
        chassis_n=round(crossing.chassis_n, 1),
        broke_n=round(max(judge.broken.values(), default=0.0), 1),
        pitch_deg=round(crossing.pitch_deg, 1),
        roll_deg=round(crossing.roll_deg, 1),
        moved_m=round(crossing.moved_m, 2),
    )


def _run(world: Orchard, until: Callable[[], bool], within_s: float) -> bool:
    """Step until something is so; whether it came about in time."""
    end = world.at + within_s
    while world.at < end:
        world.step()
        if until():
            return True
    return False
