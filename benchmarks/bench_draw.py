# SPDX-License-Identifier: Apache-2.0
"""How long pictures take: `python -m benchmarks.bench_draw`.

The tractor's mission as DOT is to take at most 10 ms and as SVG at most 100 ms; a mission of 500 states some seconds.
Next to it what `transitions` takes for the same states and rows, laid out by the same Graphviz. YASMIN's viewer draws
in a browser what a running ROS 2 node publishes, and comes with ROS alone: it is not measured here.
"""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Callable
from pathlib import Path

from rai_missions.mission.mission import Mission
from visualize import difference, drawn, picture

ROOT = Path(__file__).parents[1]

ROWS = ("dot", "svg", "png", "mmd", "md")


def chain(states: int) -> Mission:
    """Actions one after the other in groups of ten, each with a way back and a way out."""
    groups = {}
    for group in range(states // 10):
        inside = {}
        for number in range(9):
            name, onward = f"a{group}_{number}", f"a{group}_{number + 1}" if number < 8 else f"end{group}"
            transitions = [
                {"on": "succeeded", "to": onward},
                {"on": "failed", "to": f"a{group}_0"},
                {"on": "halt", "to": "done"},
            ]
            inside[name] = {"action": "go", "timeout_s": 30, "transitions": transitions}
        inside[f"end{group}"] = {"final": "succeeded"}
        to = f"g{group + 1}" if (group + 1) * 10 < states else "done"
        groups[f"g{group}"] = {
            "initial": f"a{group}_0",
            "states": inside,
            "transitions": [{"on": "succeeded", "to": to}],
        }
    document = {"format": 1, "name": "chain", "events": {"halt": {}}, "initial": "g0", "states": groups}
    return Mission.model_validate({**document, "states": {**groups, "done": {"final": "aborted"}}})


def timed(work: Callable[[], object], times: int) -> float:
    """Milliseconds by the clock, the least of several."""
    spent = []
    for _ in range(times):
        begin = time.perf_counter()
        work()
        spent.append((time.perf_counter() - begin) * 1e3)
    return min(spent)


def main() -> None:
    tractor = Mission.model_validate(json.loads((ROOT / "missions/tractor/mission.json").read_text(encoding="utf-8")))
    large = chain(500)
    for mission, times in ((tractor, 20), (large, 1)):
        count = sum(1 for _ in mission.walk())
        print(f"{mission.name}, {count} states, {len(picture(mission).edges)} edges:")
        for form in ROWS:
            if form == "png" and count > 100:
                continue  # a picture of many metres is read as SVG
            print(f"  {form:<11}{timed(lambda m=mission, f=form: drawn(picture(m), f), times):9.1f} ms")  # type: ignore[misc]
        if importlib.util.find_spec("transitions"):
            from benchmarks.peers_draw import by_transitions

            for form in ("dot", "svg") if count <= 100 else ("dot",):
                print(f"  transitions {form:<4}{timed(lambda m=mission, f=form: by_transitions(m, f), times):6.1f} ms")  # type: ignore[misc]
        print(f"  {'difference':<11}{timed(lambda m=mission: difference(m, m), times):9.1f} ms")  # type: ignore[misc]


if __name__ == "__main__":
    main()
