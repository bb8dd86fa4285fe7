# SPDX-License-Identifier: Apache-2.0
"""From an event to the call that it causes, and what waiting costs: `python -m benchmarks.bench_runner`.

Events are posted from another thread, on the wall clock. The peers are the least there could be, a bare queue between
two threads, and what is often done, a loop that looks 50 times a second.
"""

from __future__ import annotations

import queue
import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.figures import figure
from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.connectors.local import LocalConnector
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.runner import Runner
from rai_missions.testing import HangingModel

EVENTS = 1000
GAP_S = 0.003
WANTED_MS = (0.5, 5.0)
ROBOT = Robot.model_validate(
    {
        "name": "bench",
        "events": {"go": {"posted": True}, "end": {"posted": True}},
        "services": {"horn": {"service": "/horn"}},
    }
)
WORK = {"transitions": [{"on": "go", "do": [{"call": "horn"}]}, {"on": "end", "to": "over"}]}
THINK = {
    "decision": {"question": "?", "options": {"stay": {}}, "ask": ["agent"], "deadline_s": 600, "fallback": "stay"},
    "transitions": [{"on": "stay", "to": "thought"}],
}


def mission(*, thinks: bool) -> Mission:
    busy: dict[str, Any] = {"work": WORK}
    if thinks:
        regions = {
            "acts": {"initial": "work", "states": {"work": WORK}},
            "thinks": {"initial": "asks", "states": {"asks": THINK, "thought": {}}},
        }
        busy = {"both": {"parallel": regions}}
    states = {**busy, "over": {"final": "aborted"}}
    return Mission.model_validate(
        {"name": "bench", "initial": next(iter(busy)), "events": ["go", "end"], "states": states}
    )


def posted(post: Callable[[], None], called: threading.Event, at: list[float]) -> list[float]:
    """Seconds from each post to its call."""
    spent = []
    for _ in range(EVENTS):
        called.clear()
        time.sleep(GAP_S)  # so that each finds the other side waiting
        begin = time.perf_counter()
        post()
        called.wait()
        spent.append(at[-1] - begin)
    return sorted(spent)


def print_times(name: str, spent: list[float]) -> None:
    median, last = statistics.median(spent), spent[int(len(spent) * 0.99)]
    print(f"{name:<46}{1e3 * median:>10.3f}{1e3 * last:>10.3f}{1e3 * spent[-1]:>10.3f}")
    figure(f"event to call, wall, median: {name}", 1e3 * median, "ms")
    figure(f"event to call, wall, 99th of 100: {name}", 1e3 * last, "ms")


def runner_latency(name: str, *, thinks: bool, folder: Path | None) -> None:
    at: list[float] = []
    called = threading.Event()

    def horn(_: Any) -> dict[str, Any]:
        at.append(time.perf_counter())
        called.set()
        return {"success": True, "message": ""}

    made, model = mission(thinks=thinks), HangingModel()
    agent, connector = DecisionAgent(model), LocalConnector()
    connector.serve("/horn", "std_srvs/srv/Trigger", horn)
    journal = Journal.create(folder / name.replace(" ", "_"), Header(dump(made))) if folder is not None else None
    runner = Runner(made, robot=ROBOT, connector=connector, answerers={"agent": agent}, journal=journal)
    thread = threading.Thread(target=runner.run)
    thread.start()
    if thinks:
        model.hangs.wait()
    print_times(name, posted(lambda: runner.post(Event("go", runner.view.now())), called, at))
    runner.post(Event("end", runner.view.now()))
    thread.join()
    model.release()
    agent.stop()
    if journal is not None:
        journal.close()


def queue_latency(name: str, look: Callable[[queue.SimpleQueue[int]], int]) -> None:
    at: list[float] = []
    called, waiting = threading.Event(), queue.SimpleQueue[int]()

    def work() -> None:
        while look(waiting):
            at.append(time.perf_counter())
            called.set()

    thread = threading.Thread(target=work)
    thread.start()
    print_times(name, posted(lambda: waiting.put(1), called, at))
    waiting.put(0)
    thread.join()


def polled(waiting: queue.SimpleQueue[int]) -> int:
    while waiting.empty():
        time.sleep(0.02)
    return waiting.get()


def idle() -> None:
    """Processor time of a run that waits, in both ways of waiting: for an event, and for a timer in an hour."""
    for name, transitions in (("for an event", []), ("for an event or a timer", [{"after_s": 3600, "to": "over"}])):
        work = {"transitions": [*WORK["transitions"], *transitions]}
        states = {"work": work, "over": {"final": "aborted"}}
        made = Mission.model_validate({"name": "idle", "initial": "work", "events": ["go", "end"], "states": states})
        connector = LocalConnector()
        connector.serve("/horn", "std_srvs/srv/Trigger", lambda _: {})
        runner = Runner(made, robot=ROBOT, connector=connector)
        thread = threading.Thread(target=runner.run)
        thread.start()
        time.sleep(0.5)
        before = time.process_time()
        time.sleep(3.0)
        print(f"3 s of waiting {name}: {1e3 * (time.process_time() - before):.1f} ms of the processor")
        runner.post(Event("end", runner.view.now()))
        thread.join()


def ten_hours() -> None:
    states = {
        "work": {"transitions": [{"after_s": 1, "to": "work", "do": [{"call": "horn"}]}, {"on": "end", "to": "over"}]},
        "over": {"final": "aborted"},
    }
    made = Mission.model_validate(
        {
            "name": "hours",
            "initial": "work",
            "events": ["go", "end"],
            "states": states,
            "transitions": [{"after_s": 36_000, "to": "over"}],
        }
    )
    clock, connector = SimulatedClock(), LocalConnector()
    runner = Runner(made, robot=ROBOT, connector=connector, clock=clock)
    connector.serve("/horn", "std_srvs/srv/Trigger", lambda _: {})
    begin = time.process_time()
    steps = runner.run().steps
    print(f"ten hours on the simulated clock, a call a second ({steps:,} steps): {time.process_time() - begin:.1f} s")


def main() -> None:
    print(f"{'from an event to its call, ms':<46}{'median':>10}{'p99':>10}{'longest':>10}")
    queue_latency("peer: a bare queue between two threads", lambda waiting: waiting.get())
    queue_latency("peer: a loop that looks 50 times a second", polled)
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        runner_latency("idle, no journal", thinks=False, folder=None)
        runner_latency("idle, journaled", thinks=False, folder=folder)
        runner_latency("while a model hangs, no journal", thinks=True, folder=None)
        runner_latency("while a model hangs, journaled", thinks=True, folder=folder)
    print(f"wanted: median < {WANTED_MS[0]}, p99 < {WANTED_MS[1]}")
    idle()
    ten_hours()


if __name__ == "__main__":
    main()
