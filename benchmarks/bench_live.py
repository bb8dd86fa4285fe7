# SPDX-License-Identifier: Apache-2.0
"""What the live page costs a run, and how soon a browser sees a step: `python -m benchmarks.bench_live`.

A run is flooded with events: without a page, with a page that no one looks at, and with viewers in processes of their
own. The processor time of the engine's own thread shows what the page costs it, whatever else the machine does. Then a
run makes a transition now and then, and a browser reports when the state was lit. Wanted: 100 ms (median).
"""

from __future__ import annotations

import http.client
import multiprocessing
import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from benchmarks.browser import find_browser
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.run.live_page import RunPage
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from visualize.live import LivePage, PageAddress

EVENTS = 20_000
TRANSITIONS = 200
GAP_S = 0.1
ROBOT = Robot.model_validate({"name": "bench", "events": {"go": {"posted": True}, "end": {"posted": True}}})
STATES = {
    name: {"transitions": [{"on": "go", "to": other}, {"on": "end", "to": "over"}]}
    for name, other in (("here", "there"), ("there", "here"))
}
MISSION = Mission.model_validate(
    {"name": "bench", "initial": "here", "events": ["go", "end"], "states": {**STATES, "over": {"final": "aborted"}}}
)
WATCH_LIT = """() => {
  window.lit = [];
  const look = () => {
    const now = [...document.querySelectorAll('.state.active')].map((each) => each.dataset.state).join();
    if (now !== window.was) window.lit.push([Date.now(), window.was = now]);
    requestAnimationFrame(look);
  };
  look();
}"""


def view(port: int, token: str, ready: Any) -> None:
    """A viewer that reads what comes until the end."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    line.request("GET", "/events", headers={"X-Mission-Token": token})
    answer = line.getresponse()
    answer.readline()
    ready.release()
    with suppress(OSError, http.client.HTTPException):
        while answer.read1(65_536):
            pass


class Flood:
    """One run, with a page or without."""

    def __init__(self, folder: Path, *, paged: bool) -> None:
        self.at: list[tuple[float, float]] = []
        setting = RunConfig(
            MISSION, ROBOT, connector=LocalConnector(), journal=folder / f"{time.time_ns()}.journal", on_step=self._see
        )
        self.page = LivePage(PageAddress(port=0)) if paged else None
        self.watch = RunPage(self.page, setting) if self.page is not None else None
        self.prepared = prepare(self.watch.config if self.watch else setting)
        self.thread = threading.Thread(target=self._work)
        self.thread.start()
        while self.prepared.runner.view.mode != "running" or (self.page is not None and not self.page.serves):
            time.sleep(0.01)

    def _see(self, step: Step) -> None:
        self.at.append((time.perf_counter(), time.thread_time()))

    def _work(self) -> None:
        runner = self.prepared.runner
        if self.watch is not None:
            self.watch.run(self.prepared, lambda each: each.run())
        else:
            runner.run()

    def post(self, name: str) -> None:
        self.prepared.runner.post(Event(name, self.prepared.runner.view.now()))

    def end(self) -> None:
        self.post("end")
        self.thread.join()
        if self.page is not None:
            self.page.stop()
        self.prepared.close()


def flooded(name: str, folder: Path, *, paged: bool, viewers: int = 0) -> None:
    flood = Flood(folder, paged=paged)
    fork = multiprocessing.get_context("spawn")
    ready = fork.Semaphore(0)
    watching = []
    if flood.page is not None:
        arguments = (flood.page.port, flood.page.token, ready)
        watching = [fork.Process(target=view, args=arguments, daemon=True) for _ in range(viewers)]
    for each in watching:
        each.start()
    for _ in watching:
        ready.acquire()
    before = len(flood.at)
    for _ in range(EVENTS):
        flood.post("go")
    while len(flood.at) < before + EVENTS:
        time.sleep(0.01)
    (wall, own), (wall_end, own_end) = flood.at[before], flood.at[before + EVENTS - 1]
    rate, each_us = (EVENTS - 1) / (wall_end - wall), 1e6 * (own_end - own) / (EVENTS - 1)
    print(f"{name:<34}{rate:>12,.0f}{each_us:>22.1f}")
    flood.end()
    for process in watching:
        process.join(5)


def seen_in_browser(folder: Path, viewers: int) -> None:
    """From the moment at which a step was made to the frame in which a browser shows its state."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        print("no browser")
        return
    found = find_browser()
    if found is None:
        print("no browser")
        return
    made: list[float] = []
    flood = Flood(folder, paged=True)
    keep: Callable[[Step], None] = flood._see

    def seen(step: Step) -> None:
        made.append(time.time())
        keep(step)

    flood.watch._step = seen  # type: ignore[union-attr]
    with sync_playwright() as running:
        browser = running.chromium.launch(executable_path=found, args=["--no-sandbox"])
        windows = [browser.new_page() for _ in range(viewers)]
        for window in windows:
            window.goto(flood.page.url)  # type: ignore[union-attr]
            window.wait_for_selector("html[data-ready=yes]", state="attached")
        windows[0].bring_to_front()
        windows[0].evaluate(WATCH_LIT)
        windows[0].wait_for_timeout(1000)
        made.clear()
        for _ in range(TRANSITIONS):
            flood.post("go")
            time.sleep(GAP_S)
        windows[0].wait_for_timeout(1000)
        lit = [at / 1000 for at, _ in windows[0].evaluate("window.lit")][1:]
        browser.close()
    flood.end()
    spent = sorted(1000 * (shown - max(step for step in made if step <= shown + 0.001)) for shown in lit)
    words = f"{len(lit)} of {TRANSITIONS} seen with {viewers} window(s)"
    print(f"{words:<34}{statistics.median(spent):>12.1f}{spent[int(len(spent) * 0.99)]:>22.1f}")


def main() -> None:
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        print(f"{'flooded':<34}{'events/s':>12}{'engine thread, µs/step':>24}")
        for _ in range(2):
            flooded("without a page", folder, paged=False)
            flooded("a page, no one looks", folder, paged=True)
            flooded("1 viewer", folder, paged=True, viewers=1)
            flooded("10 viewers", folder, paged=True, viewers=10)
        print(f"{'from a step to the browser, ms':<34}{'median':>12}{'p99':>22}")
        seen_in_browser(folder, 1)
        seen_in_browser(folder, 3)


if __name__ == "__main__":
    main()
