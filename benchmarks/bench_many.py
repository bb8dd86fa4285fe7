# SPDX-License-Identifier: Apache-2.0
"""Many missions in a process, over one connector: memory, what waiting costs, and events at a rate.

`python -m benchmarks.bench_many [MISSIONS]`; those with a journal in a process of their own. Every mission waits for an
event that causes a call, as in `bench_runner`; events go to missions drawn at random. The peer of the latency is one
mission at the same rate of events.
"""

from __future__ import annotations

import gc
import os
import random
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import Process
from pathlib import Path
from typing import Any

from benchmarks.bench_runner import ROBOT, mission
from benchmarks.figures import figure
from rai_missions.connectors.local import LocalConnector
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.journal.open_files import OPEN
from rai_missions.mission.files import dump
from rai_missions.runtime.runner import Runner

MISSIONS, PER_S, SECONDS = 1_000, 1_000, 5.0
Latencies = list[float]


def resident_kb() -> int:
    """Memory of this process that is in use, kB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


class Fleet:
    """Runners over one connector, whose calls are taken down by when they came."""

    def __init__(self, folder: Path | None) -> None:
        self.called: list[float] = []
        self._folder = folder
        self._mission = mission(thinks=False)
        self._text = dump(self._mission)
        self._runners: list[Runner] = []
        self._journals: list[Journal] = []
        self._threads: list[threading.Thread] = []
        self._connector = LocalConnector()
        self._connector.serve("/horn", "std_srvs/srv/Trigger", self._horn)
        self._connector.start()

    def _horn(self, _: Any) -> dict[str, Any]:
        self.called.append(time.perf_counter())
        return {"success": True, "message": ""}

    def add(self, count: int) -> None:
        """Start so many more, and wait until all of them wait."""
        for _ in range(count):
            journal = None
            if self._folder is not None:
                journal = Journal.create(self._folder / f"{len(self._runners)}.journal", Header(self._text))
                self._journals.append(journal)
            runner = Runner(self._mission, robot=ROBOT, connector=self._connector, journal=journal)
            self._runners.append(runner)
            self._threads.append(threading.Thread(target=runner.run))
            self._threads[-1].start()
        while any(runner.view.mode == "ready" for runner in self._runners):
            time.sleep(0.01)

    def latencies(self) -> Latencies:
        """Seconds from an event to its call, sorted; calls come in the order of the events but for a few at once."""
        chance, posted, begin = random.Random(1), [], time.perf_counter()
        self.called.clear()
        for number in range(int(PER_S * SECONDS)):
            while (late := begin + number / PER_S - time.perf_counter()) > 0:
                time.sleep(late)
            runner = chance.choice(self._runners)
            posted.append(time.perf_counter())
            runner.post(Event("go", runner.view.now()))
        while len(self.called) < len(posted):
            if not all(thread.is_alive() for thread in self._threads):
                raise SystemExit("a mission has ended before its calls had come: its disk was too slow")
            time.sleep(0.01)
        return sorted(taken - given for given, taken in zip(posted, sorted(self.called), strict=True))

    def end(self) -> None:
        for runner in self._runners:
            runner.post(Event("end", runner.view.now()))
        for thread in self._threads:
            thread.join()
        for journal in self._journals:
            journal.close()
        self._connector.stop()


@contextmanager
def fleet(first: int, *, journaled: bool) -> Iterator[Fleet]:
    with tempfile.TemporaryDirectory(dir=".") as name:
        made = Fleet(Path(name) if journaled else None)
        try:
            made.add(first)
            yield made
        finally:
            made.end()


def at(part: float, sorted_s: Sequence[float]) -> float:
    return 1e3 * sorted_s[int(part * (len(sorted_s) - 1))]


def measure(count: int, *, journaled: bool) -> None:
    how = "journaled" if journaled else "no journal"
    with fleet(1, journaled=journaled) as one:
        alone = one.latencies()
    with fleet(10, journaled=journaled) as many:
        gc.collect()
        memory, spent = resident_kb(), time.process_time()
        many.add(count)
        began_ms = 1e3 * (time.process_time() - spent) / count
        gc.collect()
        begun_kb = (resident_kb() - memory) / count
        while OPEN.count > OPEN.kept:  # those that wait for long enough rest
            time.sleep(0.1)
        time.sleep(0.1)  # what they have freed is given back
        gc.collect()
        each_kb = (resident_kb() - memory) / count
        spent = time.process_time()
        time.sleep(3.0)
        waiting = 1e3 * (time.process_time() - spent) / 3.0
        found = many.latencies()
    print(
        f"{count:,} missions, {how}: {each_kb:.0f} kB (at first {begun_kb:.0f}) and {began_ms:.1f} ms to begin each;"
        f" all wait: {waiting:.1f} ms CPU a second; {PER_S:,} events/s:"
        f" median {at(0.5, found):.2f}, p99 {at(0.99, found):.2f} ms"
        f" (one mission: {at(0.5, alone):.2f}, {at(0.99, alone):.2f})"
    )
    figure(f"{count:,} missions, {how}: memory each", each_kb, "kB", most=100)
    figure(f"{count:,} missions, {how}: memory each, as soon as all have begun", begun_kb, "kB")
    figure(f"{count:,} missions, {how}: waiting, a second", waiting, "ms")
    figure(f"{count:,} missions, {how}: start each", began_ms, "ms")
    peer = ("one mission", at(0.99, alone))
    figure(f"{count:,} missions, {how}: event to call, wall, p99", at(0.99, found), "ms", peer=peer, most=5)


def main() -> None:
    count = int(sys.argv[1]) if sys.argv[1:] else MISSIONS
    for journaled in (False, True):
        each = Process(target=measure, args=(count,), kwargs={"journaled": journaled})
        each.start()  # in one process, the second would take for free what the first has given back
        each.join()
        if each.exitcode:
            sys.exit(1)


if __name__ == "__main__":
    main()
