# SPDX-License-Identifier: Apache-2.0
"""What it costs to begin: `import rai_missions` above `import pydantic`, and `rai-missions --help`, whole processes."""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time

RUNS = 9


def cpu_ms(*words: str) -> tuple[float, float]:
    """Median CPU and wall milliseconds of a process."""
    cpu, wall = [], []
    for _ in range(RUNS):
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run([sys.executable, *words], stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu.append(1000 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime))
        wall.append(1000 * (time.perf_counter() - began))
    return statistics.median(cpu), statistics.median(wall)


def main() -> None:
    nothing = cpu_ms("-c", "pass")[0]
    pydantic = cpu_ms("-c", "import pydantic; pydantic.BaseModel")[0]
    ours = cpu_ms("-c", "import rai_missions")[0]
    used = cpu_ms("-c", "from rai_missions import Chart, Mission")[0]
    help_cpu, help_wall = cpu_ms("-m", "rai_missions.cli.main", "--help")
    print(f"{'process':44}{'CPU ms':>10}{'target':>24}")
    print(f"{'python -c pass':44}{nothing:10.0f}")
    print(f"{'import pydantic.BaseModel':44}{pydantic:10.0f}")
    print(f"{'import rai_missions':44}{ours:10.0f}{f'≤ pydantic + 60 = {pydantic + 60:.0f}':>24}")
    print(f"{'from rai_missions import Chart, Mission':44}{used:10.0f}")
    print(f"{'rai-missions --help':44}{help_cpu:10.0f}{'≤ 250 wall':>24}  ({help_wall:.0f} ms wall)")


if __name__ == "__main__":
    main()
