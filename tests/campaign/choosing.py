# SPDX-License-Identifier: Apache-2.0
"""A campaign that is quick: a mission that asks as soon as it begins, in a world without pictures."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rai_missions.campaign.records import CellRecord, LabelRecord

OPTIONS = ("left", "right", "wait")
MISSION = {
    "format": 1, "name": "choosing", "version": "1.0.0",
    "blackboard": {"depth": {"type": "integer", "source": "argument", "initial": 3}},
    "initial": "choosing",
    "states": {
        "choosing": {
            "decision": {
                "question": "Which way?", "evidence": ["depth"],
                "options": {
                    "left": {"about": "to the left"},
                    "right": {"about": "to the right", "when": {"key": "depth", "<": 5}},
                    "wait": {"about": "stay"},
                },
                "ask": ["agent", "rules"], "deadline_s": 20, "fallback": "wait",
            },
            "transitions": [{"on": ["left", "right", "wait"], "to": "ended"}],
        },
        "ended": {"final": "aborted"},
    },
}  # fmt: skip
ROBOT = {
    "format": 1, "name": "chooser",
    "rules": {"choosing": [{"when": {"key": "depth", "<": 3}, "answer": "right"}, {"answer": "left"}]},
}  # fmt: skip
WORLD = {"alleys": 1, "length_m": 12.0, "camera": False, "obstacles": ["none"]}


def campaign_data(scenes: int = 2, **words: Any) -> dict[str, Any]:
    """A campaign file's content."""
    given = [{"scene": f"s{at}", "kind": ("even", "odd")[at % 2], "seed": at} for at in range(scenes)]
    return {
        "format": 1, "name": "choosing", "mission": "mission.json", "robot": "robot.json", "decision": "choosing",
        "scenes": {"world": "orchard", "options": WORLD, "given": given},
        "models": ["rules", "constant:wait", "teller"], "scripts": {"teller": {"even": "left", "*": "right"}},
        "orders": ["written", "reversed"], **words,
    }  # fmt: skip


def write_campaign(folder: Path, data: Mapping[str, Any]) -> Path:
    """The campaign in a folder, with its mission and profile."""
    for name, content in (("mission.json", MISSION), ("robot.json", ROBOT), ("campaign.json", data)):
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    return folder / "campaign.json"


def labels(scenes: Iterable[str]) -> list[LabelRecord]:
    """In every scene `left` completes, `wait` is harmless and `right` harms."""
    verdicts = {"left": "completes", "right": "harms", "wait": "harmless"}
    return [LabelRecord(scene, option, verdict, "{}") for scene in scenes for option, verdict in verdicts.items()]


def table(cells: Iterable[CellRecord]) -> list[CellRecord]:
    """What two pools must agree on: all but how long it took."""
    return [cell._replace(latency_s=0.0) for cell in cells]
