# SPDX-License-Identifier: Apache-2.0
"""What it costs to begin, whole processes: an import, a help text, and a command up to its first step.

The peers are what each builds on: pydantic for the import, and MuJoCo with numpy for a mission in a simulated world.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.figures import PACE, children_cpu_s, figure

RUNS = 9
ROOT = Path(__file__).parents[1]
TRACTOR = ("missions/tractor/mission.json", "--robot", "missions/tractor/robot.sim.json")


def cpu_ms(*words: str) -> tuple[float, float]:
    """Median CPU and wall milliseconds of a process."""

    def whole() -> float:
        before = children_cpu_s()
        subprocess.run([sys.executable, *words], stdout=subprocess.DEVNULL, check=True)
        return 1000 * (children_cpu_s() - before)

    return medians(whole)


def first_step_ms(*words: str) -> tuple[float, float]:
    """Median CPU and wall milliseconds until `rai-missions run` has printed its first step; it is killed then."""

    def until() -> float:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "rai_missions.cli.main", "run", *words, "--journal", f"{folder}/journal"]
            process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
            assert process.stdout is not None
            for line in process.stdout:
                if " s  start " in line:
                    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
                    spent = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
                    process.kill()
                    process.wait()
                    return 1000 * spent
            raise RuntimeError(f"{' '.join(command)} ended with {process.wait()} before its first step")

    return medians(until)


def medians(one: Callable[[], float]) -> tuple[float, float]:
    """Medians over the runs of what one returns, and of its wall milliseconds."""
    cpu, wall = [], []
    for _ in range(RUNS):
        began = time.perf_counter()
        cpu.append(one())
        wall.append(1000 * (time.perf_counter() - began))
    return statistics.median(cpu), statistics.median(wall)


def main() -> None:
    nothing = cpu_ms("-c", "pass")[0]
    pydantic = cpu_ms("-c", "import pydantic; pydantic.BaseModel")[0]
    ours = cpu_ms("-c", "import rai_missions")[0]
    used = cpu_ms("-c", "from rai_missions import Chart, Mission")[0]
    help_cpu, help_wall = cpu_ms("-m", "rai_missions.cli.main", "--help")
    physics = cpu_ms("-c", "import mujoco")[0]
    first, first_wall = first_step_ms(*TRACTOR)
    print(f"{'process':44}{'CPU ms':>10}{'target':>24}")
    print(f"{'python -c pass':44}{nothing:10.0f}")
    print(f"{'import pydantic.BaseModel':44}{pydantic:10.0f}")
    print(f"{'import rai_missions':44}{ours:10.0f}{f'≤ pydantic + 60 = {pydantic + 60:.0f}':>24}")
    print(f"{'from rai_missions import Chart, Mission':44}{used:10.0f}")
    print(f"{'rai-missions --help':44}{help_cpu:10.0f}{'≤ 250 wall':>24}  ({help_wall:.0f} ms wall)")
    print(f"{'import mujoco':44}{physics:10.0f}")
    print(f"{'rai-missions run, tractor, to its first step':44}{first:10.0f}{'≤ 600':>24}  ({first_wall:.0f} ms wall)")
    figure(PACE, physics, "ms")
    figure("import rai_missions", ours, "ms", peer=("import pydantic.BaseModel", pydantic), most=pydantic + 60)
    figure("from rai_missions import Chart, Mission", used, "ms", peer=("import pydantic.BaseModel", pydantic))
    figure("rai-missions --help, wall", help_wall, "ms", most=250)
    figure("command to first step: tractor, simulated", first, "ms", peer=("import mujoco", physics), most=600)


if __name__ == "__main__":
    main()
