# SPDX-License-Identifier: Apache-2.0
"""What a recording costs a run that is flooded with events: `python -m benchmarks.bench_record`.

The peer is the same flood without a recording, in turn with it in the same run. A rate is that of the run, from the
first event to the last step: what waits then is written afterwards. Nothing may be lost: what found no room is printed.
Each flood begins after a full search for garbage: one is due every few floods, and in turn it always met the same one.
"""

from __future__ import annotations

import gc
import statistics
import tempfile
import threading
import time
from pathlib import Path
from typing import NamedTuple

from benchmarks.bench_runner import ROBOT, mission
from benchmarks.figures import figure
from rai_missions.connectors.local import LocalConnector
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.recording import Recording, recorded
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

EVENTS, ROUNDS = 20_000, 3


class Flood(NamedTuple):
    """One flooded run."""

    rate: float
    """Events a second of wall time, to the last step."""
    cpu_us: float
    """Of the process, an event, to the last step."""
    after_s: float
    """CPU time of what was written afterwards."""
    size: int = 0
    lost: int = 0


def flood(folder: Path, *, is_recorded: bool, is_journaled: bool) -> Flood:
    made, connector = mission(thinks=False), LocalConnector()
    connector.serve("/horn", "std_srvs/srv/Trigger", lambda _: {"success": True, "message": ""})
    recording = None
    if is_recorded:
        recording = Recording.create(folder / "run.mcap", mission=made, about={}, now=time.monotonic)
    journal = None
    if is_journaled:
        witness = recording.rows if recording is not None else None
        journal = Journal.create(folder / "run.journal", Header(dump(made)), witness=witness)
    runner = Runner(
        made,
        robot=ROBOT,
        connector=recorded(connector, recording) if recording is not None else connector,
        journal=journal,
        observer=RunObserver(recording.step, recording.status) if recording is not None else RunObserver(),
    )
    thread = threading.Thread(target=runner.run)
    for _ in range(EVENTS):
        runner.post(Event("go", 0.0))
    runner.post(Event("end", 0.0))
    gc.collect()
    begin, spent = time.perf_counter(), time.process_time()
    thread.start()
    thread.join()
    took, cpu = time.perf_counter() - begin, time.process_time() - spent
    spent = time.process_time()
    if journal is not None:
        journal.close()
    if recording is None:
        return Flood(EVENTS / took, 1e6 * cpu / EVENTS, 0.0)
    summary = recording.close(journal.path if journal is not None else None)
    return Flood(
        EVENTS / took, 1e6 * cpu / EVENTS, time.process_time() - spent, summary.size, sum(summary.dropped.values())
    )


def main() -> None:
    print(f"a flood of {EVENTS:,} events, each a call{'':<12}{'events/s':>10}{'CPU µs':>10}{'after, s':>10}{'lost':>8}")
    for is_journaled in (False, True):
        rounds: dict[bool, list[Flood]] = {False: [], True: []}
        for _ in range(ROUNDS):
            for is_recorded, found in rounds.items():
                with tempfile.TemporaryDirectory(dir=".") as name:
                    found.append(flood(Path(name), is_recorded=is_recorded, is_journaled=is_journaled))
        how = "journaled" if is_journaled else "no journal"
        rates = {is_recorded: statistics.median(each.rate for each in found) for is_recorded, found in rounds.items()}
        for is_recorded, found in rounds.items():
            cpu = statistics.median(each.cpu_us for each in found)
            after = statistics.median(each.after_s for each in found)
            name = f"{how}, {'recorded' if is_recorded else 'unrecorded'}"
            lost = max(each.lost for each in found)
            print(f"{name:<46}{rates[is_recorded]:>10,.0f}{cpu:>10.1f}{after:>10.2f}{lost:>8}")
            figure(f"a flood of events: CPU an event, {name}", cpu, "µs")
        print(f"    with a recording: {100 * rates[True] / rates[False]:.0f} % of the rate without")
        figure(
            f"a recorded flood, wall: {how}",
            rates[True],
            "events/s",
            peer=("unrecorded", rates[False]),
            most=0.9 * rates[False],
            larger_is_better=True,
        )


if __name__ == "__main__":
    main()
