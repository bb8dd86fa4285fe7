# SPDX-License-Identifier: Apache-2.0
"""What a browser reads of a page, and runs and journals that the tests of pages show."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Header, Journal
from rai_missions.mission.mission import Mission

__all__ = ("HOSTILE", "answered", "data_of", "folded", "journal_of", "picture_bytes")

DATA = re.compile(rb'<script id="data" type="application/json">(.*?)</script>', re.DOTALL)
HOSTILE = (
    "</script><script>window.pwned = 1</script>",
    "<img src=x onerror='window.pwned = 2'>",
    "\u202ereversed\u2066 \u200f marks",
    "<!-- ]]> --> &lt;b&gt; \" ' ` ${1} \\u003c",
    "👩‍👩‍👧‍👦🏳️‍🌈 e\u0301 漢字 العربية",
    "javascript:alert(1)",
    "long " * 2000,
)
"""Texts that do their best to be read as something else."""


def data_of(page: bytes) -> dict[str, Any]:
    """The data as the browser's parser finds it: up to the first end of a script element."""
    found = DATA.search(page)
    assert found is not None
    read: dict[str, Any] = json.loads(found[1])
    return read


def folded(run: dict[str, Any], keys: dict[str, Any]) -> list[tuple[set[str], dict[str, list[Any]]]]:
    """What was active and what was known after each step, from what each step changed."""
    active: set[str] = set()
    board = {name: [key["initial"], run["steps"][0][1]] for name, key in keys.items() if key.get("initial") is not None}
    found = []
    for _, _, _, moves, _, writes, _ in run["steps"]:
        for _, exited, entered, _ in run["pool"][moves]:
            active = active - set(exited) | set(entered)
        for key, value, stamp in run["pool"][writes]:
            board[key] = [value, stamp]
        board = {key: entry for key, entry in board.items() if entry[0] is not None}
        found.append((set(active), dict(board)))
    return found


def picture_bytes(shade: int) -> bytes:
    return bytes([shade, 40, 90]) * (16 * 12)


def answered(mission: Mission) -> list[Step]:
    """A run of the tractor's design in which a question is refused once, answered, and aborted."""
    chart = Chart(mission, ticker=CompiledTrees())
    chart.write("battery", 0.8, at=0.0)
    steps = [chart.start(at=0.0)]
    seen = {"kind": "log", "distance_m": 4.0, "height_m": 0.5, "living": False}
    events = [
        Event("obstacle", 2.9, {"value": seen}, "write"),
        Event("camera", 2.95, {"value": Image("camera@2.95", 16, 12, "rgb8", picture_bytes(7))}, "write"),
        Event("anomaly", 3.0, {}),
        Event("agent", 3.0, {"by": "mission"}, "control"),
    ]
    steps += [chart.send(event) for event in events]
    while (question := steps[-1].question) is not None:
        answer = {"option": "drive_over" if len(steps) < 7 else "abort", "why": HOSTILE[0], "parameters": {}}
        steps.append(chart.send(Event(question.asked, steps[-1].at + 0.5, answer, "proposal", question.number)))
    return steps


def journal_of(path: Path, mission: Mission, steps: Sequence[Step]) -> Path:
    """A journal that holds these steps."""
    with Journal.create(path, Header(json.dumps(mission.written()))) as journal:
        before = 0.0
        for step in steps:
            journal.write(step, since=before)
            before = step.at
    return path
