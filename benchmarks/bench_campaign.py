# SPDX-License-Identifier: Apache-2.0
"""What a campaign's pools cost: a task that does nothing, locally and on Ray, and what a second worker gains.

    python -m benchmarks.bench_campaign tasks 300                  # of a local pool of one worker
    python -m benchmarks.bench_campaign tasks 300 --ray            # of Ray, on this machine
    python -m benchmarks.bench_campaign workers FILE --rounds 2    # a campaign with one worker and with two, in turn

Times of a machine with other work are of little worth; CPU times and ratios of one call can be compared.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median

from rai_missions.campaign.load import load_campaign
from rai_missions.campaign.pool import LocalPool, TaskPool
from rai_missions.campaign.ray_pool import RayPool
from rai_missions.campaign.run import run_campaign
from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import SceneTask, WorkSettings

QUICK = Path(__file__).parents[1] / "campaigns" / "quick.json"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    tasks = commands.add_parser("tasks")
    tasks.add_argument("count", type=int)
    tasks.add_argument("--ray", action="store_true")
    workers = commands.add_parser("workers")
    workers.add_argument("file", type=Path, nargs="?", default=QUICK)
    workers.add_argument("--rounds", type=int, default=2)
    words = parser.parse_args()
    if words.command == "tasks":
        time_tasks(words.count, RayPool if words.ray else LocalPool)
    else:
        time_workers(words.file, words.rounds)


def time_tasks(count: int, open_pool: Callable[[WorkSettings], TaskPool]) -> None:
    """What a task costs that has no cell left: what remains is the pool's own."""
    scene = next(load_campaign(QUICK).file.scenes.scenes())
    empty = SceneTask(scene, (), {})
    pool = open_pool(WorkSettings(str(QUICK)))
    try:
        began = time.monotonic()
        list(pool.results([empty]))  # a worker is there
        start_s = time.monotonic() - began
        used, began = cpu_s(descendants=True), time.monotonic()
        list(pool.results([empty] * count))
        wall_s, used = time.monotonic() - began, cpu_s(descendants=True) - used
    finally:
        pool.close()
    ms = f"{1000 * wall_s / count:.2f} ms of wall time and {1000 * used / count:.2f} ms of CPU in all its processes"
    print(f"{count} tasks: {ms}, a task; first task after {start_s:.1f} s")


def time_workers(file: Path, rounds: int) -> None:
    """A campaign with one worker and with two, in turn, each into a store of its own."""
    loaded, seconds = load_campaign(file), dict[int, list[float]]()
    for _ in range(rounds):
        for workers in (1, 2):
            with tempfile.TemporaryDirectory() as folder, ResultStore(Path(folder) / "a.db", writes=True) as store:
                writer, began = cpu_s(), time.monotonic()
                result = run_campaign(loaded, store, WorkSettings(str(file.resolve()), (), workers))
                wall_s = time.monotonic() - began
            seconds.setdefault(workers, []).append(wall_s)
            cells = sum(result.counts.values())
            print(
                f"{workers} workers: {cells} cells in {wall_s:.1f} s; the writer used {cpu_s() - writer:.2f} s of CPU"
            )
    one, two = (median(seconds[workers]) for workers in (1, 2))
    print(f"two workers are {one / two:.2f} times as fast as one")


def cpu_s(*, descendants: bool = False) -> float:
    """CPU time of this process, or of it and all that descends from it and lives."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    own = used.ru_utime + used.ru_stime
    return own + sum(_cpu_of_children(os.getpid(), _processes())) if descendants else own


def _processes() -> dict[int, list[tuple[int, float]]]:
    """Process → its children, each with its CPU time."""
    tick, found = os.sysconf("SC_CLK_TCK"), dict[int, list[tuple[int, float]]]()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended
            fields = stat.read_text().rpartition(")")[2].split()
            found.setdefault(int(fields[1]), []).append(
                (int(stat.parent.name), (int(fields[11]) + int(fields[12])) / tick)
            )
    return found


def _cpu_of_children(parent: int, processes: dict[int, list[tuple[int, float]]]) -> Iterator[float]:
    for child, seconds in processes.get(parent, []):
        yield seconds
        yield from _cpu_of_children(child, processes)


if __name__ == "__main__":
    main()
