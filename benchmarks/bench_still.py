# SPDX-License-Identifier: Apache-2.0
"""From a stop to a robot that is still, in the simulated house at the pace of the wall: `python -m
benchmarks.bench_still [TRIALS]`.

The robot drives to the kitchen by the shipped mission `assist`, at up to 0.5 m/s, with its lidar and its journal. After
1.5 to 6 s (by the trial's number) another thread commands stop, cancel or kill, in turn. Still is below 0.01 m/s at
the first of the world's periods (50 ms) from which it stays so; the base slows down by 1 m/s². How long the same takes
in simulated seconds shows what the physics take, and the rest is ours and the machine's.
"""

from __future__ import annotations

import os
import random
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.mission.json_reader import parse_json
from rai_missions.profile import Robot

ROSBOT = Path(__file__).parents[1] / "missions" / "rosbot"
STILL_MPS, GIVEN_UP_S = 0.01, 10.0
COMMANDS: dict[str, Callable[[Any], None]] = {
    "stop": lambda runner: runner.stop(),
    "cancel": lambda runner: runner.cancel(),
    "kill": lambda runner: runner.kill(),
}


class Stop(NamedTuple):
    """One stop."""

    command: str
    speed_mps: float
    """When it was commanded."""
    wall_s: float
    simulated_s: float


def main() -> None:
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 120
    stops = [one for number in range(trials) if (one := trial(number, list(COMMANDS)[number % len(COMMANDS)]))]
    print(f"{len(stops)} stops of {trials} trials, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    for name in (*COMMANDS, "all"):
        chosen = [one for one in stops if name in ("all", one.command)]
        if chosen:
            print(f"{name:7} {len(chosen):4} stops: {row(chosen)}")


def trial(number: int, command: str) -> Stop | None:
    """One run that is stopped; None where the robot does not move at that moment (it turns on the spot)."""
    profile = parse_json((ROSBOT / "robot.sim.json").read_bytes(), "robot.sim.json")
    profile["connector"] |= {"camera": False, "seed": number}
    with tempfile.TemporaryDirectory() as folder:
        arguments = {"task": "go", "place": "kitchen"}
        config = RunConfig(
            ROSBOT / "assist.json",
            Robot.model_validate(profile),
            arguments=arguments,
            speed=1.0,
            journal=Path(folder) / "run.journal",
        )
        with prepare(config) as prepared:
            return stopped(prepared, command, random.Random(number).uniform(1.5, 6.0))


def stopped(prepared: Any, command: str, after_s: float) -> Stop | None:
    world, runner = prepared.world, prepared.runner
    run = threading.Thread(target=runner.run)
    run.start()
    begun = time.monotonic()
    while world.at < after_s and time.monotonic() - begun < GIVEN_UP_S:
        time.sleep(0.002)
    speed, at, commanded = abs(world.pose.speed), world.at, time.monotonic()
    COMMANDS[command](runner)
    still_at, still_wall = at, commanded
    while run.is_alive() and time.monotonic() - commanded < 1.5:
        if abs(world.pose.speed) >= STILL_MPS:
            still_at, still_wall = world.at, time.monotonic()
        time.sleep(0.002)
    if run.is_alive():
        runner.kill()
    run.join()
    while abs(world.pose.speed) >= STILL_MPS:  # the run is over, the base slows down still
        world.step()
        still_at, still_wall = world.at, still_wall + world.period_s
    return Stop(command, speed, still_wall - commanded, still_at - at) if speed >= 0.1 else None


def row(stops: list[Stop]) -> str:
    walls, simulated = (sorted(values) for values in ([s.wall_s for s in stops], [s.simulated_s for s in stops]))
    speed = statistics.median(one.speed_mps for one in stops)
    return (
        f"median {statistics.median(walls):.2f} s, p95 {share(walls, 0.95):.2f} s, longest {walls[-1]:.2f} s; "
        f"simulated median {statistics.median(simulated):.2f} s, p95 {share(simulated, 0.95):.2f} s; "
        f"from {speed:.2f} m/s"
    )


def share(values: list[float], part: float) -> float:
    return values[min(len(values) - 1, round(part * (len(values) - 1)))]


if __name__ == "__main__":
    main()
