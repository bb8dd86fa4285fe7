# SPDX-License-Identifier: Apache-2.0
"""How large the review page is, how long it takes to write, to open and to scrub: `python -m benchmarks.bench_page`.

500 states are to take at most 2 MB, written in 3 s and open in 2 s; a journal of 10,000 steps is to scrub without lag,
which is a frame of 16 ms or little more. Opening and scrubbing are measured where a browser is.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.bench_draw import ROOT, chain
from benchmarks.browser import find_browser
from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.trees import PyTrees
from visualize.page import review, run_of_steps

STEPS = 10_000
SCRUB = """async (times) => {
  const spent = [], frame = () => new Promise(requestAnimationFrame);
  for (let time = 0; time < times; time += 1) {
    const begin = performance.now();
    review.player.index = Math.floor((time * 7919) % review.player.replay.length);
    review.player.draw();
    document.body.getBoundingClientRect();
    spent.push(performance.now() - begin);
    await frame();
  }
  return spent.sort((a, b) => a - b);
}"""


def long_run(mission: Mission) -> Iterator[Step]:
    """Steps of the tractor's mission in which something is always written, and anomalies come and are answered."""
    chart = Chart(mission, ticker=PyTrees())
    chart.write("battery", 0.9, at=0.0)
    yield chart.start(at=0.0)
    number = 0
    for index in range(STEPS - 1):
        at = 0.1 * index
        step = chart.write(("battery", "alleys_driven")[index % 2], (0.9, 1)[index % 2], at=at)
        if index % 200 == 100:
            step = chart.send(Event("anomaly", at))
        elif chart.active == {"assessing"}:
            number = step.question.number if step.question else number
            answer = {"option": "replan", "why": "it is high", "parameters": {}}
            step = chart.send(Event("agent", at, answer, "proposal", number))
        yield step


def browser_times(page: bytes, *, scrub: bool) -> str:
    """What a browser takes to open a page, and to show steps of its run."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return "no browser"
    found = find_browser()
    if found is None:
        return "no browser"
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as running:
        path = Path(folder) / "page.html"
        path.write_bytes(page)
        browser = running.chromium.launch(executable_path=found, args=["--no-sandbox"])
        window = browser.new_page(viewport={"width": 1600, "height": 1000})
        begin = time.perf_counter()
        window.goto(path.as_uri())
        window.wait_for_selector("html[data-ready]", state="attached")
        timing = f"opens in {time.perf_counter() - begin:.2f} s"
        if scrub:
            spent = window.evaluate(SCRUB, 200)
            timing += f", a step is shown in {spent[100]:.1f} ms (median), {spent[197]:.1f} ms (99 %)"
        browser.close()
    return timing


def main() -> None:
    tractor = Mission.model_validate(json.loads((ROOT / "missions/tractor/mission.json").read_text(encoding="utf-8")))
    run = run_of_steps(long_run(tractor))
    cases = (("tractor", tractor, ()), ("500 states", chain(500), ()), (f"{STEPS} steps", tractor, (run,)))
    for name, mission, runs in cases:
        begin = time.perf_counter()
        page = review(mission, runs=runs)
        spent = time.perf_counter() - begin
        size = len(page) / 1e6
        print(f"{name:<14} written in {spent:5.2f} s, {size:5.2f} MB; {browser_times(page, scrub=bool(runs))}")


if __name__ == "__main__":
    main()
