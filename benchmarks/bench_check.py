# SPDX-License-Identifier: Apache-2.0
"""How long it takes to load and to check a mission, by its size: `python -m benchmarks.bench_check`.

The charts are generated, the same for a seed: compound states three levels deep, with actions, decisions, guarded rows,
protective rows and parallel regions. A second chart of each size is full of faults, for messages cost time too. The
peer is jsonschema with the shipped schema, which sees the form alone.
"""

from __future__ import annotations

import json
import random
import time
from typing import Any

from jsonschema import Draft202012Validator

from benchmarks.figures import figure
from rai_missions.check import check
from rai_missions.mission.mission import Mission
from rai_missions.mission.schema import mission_schema

SIZES = (10, 100, 1_000, 10_000)


def chart(size: int, seed: int = 7) -> dict[str, Any]:
    """A mission of about so many states, as JSON has it, in which `check` finds nothing."""
    chance = random.Random(seed)
    wings = max(1, size // 10)
    states: dict[str, Any] = {f"wing_{number}": wing(number, wings, chance) for number in range(wings)}
    states["done"] = {"final": "succeeded", "requires": {"key": "passed", "==": True}}
    states["aborted"] = {"final": "aborted"}
    return {
        "format": 1,
        "name": "generated",
        "blackboard": {
            "passed": {"type": "boolean", "source": "robot", "max_age_s": 5},
            "battery": {"type": "number", "source": "robot", "max_age_s": 5},
            "tries": {"type": "integer", "initial": 0},
        },
        "events": {"anomaly": {}, "go": {}},
        "initial": "wing_0",
        "states": states,
        "transitions": [
            {
                "when": {"all": [{"any": [{"key": "battery", "<": 0.1}, {"not": {"fresh": "battery"}}]}]},
                "to": "aborted",
            }
        ],
    }


def wing(number: int, wings: int, chance: random.Random) -> dict[str, Any]:
    """A compound of about ten states."""
    name = f"s{number}"
    onward = f"wing_{number + 1}" if number + 1 < wings else "done"
    work = {"action": "work", "timeout_s": 60, "achieved": {"key": "passed", "==": True}}
    regions = {
        f"{name}_{side}": {
            "initial": f"{name}_{side}_on",
            "states": {
                f"{name}_{side}_on": {"transitions": [{"on": "go", "to": f"{name}_{side}_off"}]},
                f"{name}_{side}_off": {"final": "succeeded"},
            },
        }
        for side in ("left", "right")
    }
    question = {"question": "What now?", "options": {"again": {}, "stop": {}}, "deadline_s": 10, "fallback": "stop"}
    transitions = [
        {"on": "succeeded", "when": {"key": "tries", ">": 2}, "to": f"{name}_both"},
        {"on": "succeeded", "to": onward},
        {"on": "anomaly", "to": f"{name}_ask"},
    ]
    return {
        "initial": f"{name}_work",
        "states": {
            f"{name}_work": {**work, "transitions": chance.sample(transitions[:1], 1) + transitions[1:]},
            f"{name}_ask": {
                "decision": question,
                "transitions": [{"on": "again", "to": f"{name}_work"}, {"on": "stop", "to": "aborted"}],
            },
            f"{name}_both": {"parallel": regions, "transitions": [{"on": "succeeded", "to": onward}]},
        },
    }


def faulty(data: dict[str, Any]) -> dict[str, Any]:
    """The same mission with a fault in most of its states: targets, keys and events misspelled, timeouts lost."""
    text = json.dumps(data)
    spoilt = (
        text.replace('_work"}', '_wrk"}').replace('"key": "tries"', '"key": "trys"').replace('"timeout_s": 60, ', "")
    )
    result: dict[str, Any] = json.loads(spoilt.replace('"on": "anomaly"', '"on": "anomly"'))
    return result


def measure(data: dict[str, Any]) -> tuple[int, float, float, int]:
    """States, CPU seconds to load, CPU seconds to check, findings."""
    begun = time.process_time()
    mission = Mission.model_validate(data)
    loaded = time.process_time()
    findings = check(mission)
    return sum(1 for _ in mission.walk()), loaded - begun, time.process_time() - loaded, len(findings)


def main() -> None:
    """Print a row for each size."""
    schema = Draft202012Validator(mission_schema())
    print(
        "| states | jsonschema, CPU s | load, CPU s | check, CPU s | findings | with faults: check, CPU s | findings |"
    )
    print("|---|---|---|---|---|---|---|")
    for size in SIZES:
        data = chart(size)
        states, load_s, check_s, findings = measure(data)
        _, _, faulty_s, faults = measure(faulty(data))
        begun = time.process_time()
        checked = sum(1 for _ in schema.iter_errors(data))
        peer_s = time.process_time() - begun
        assert not checked, "the chart is no mission by the schema"
        figure(f"load and check {size:,} states", load_s + check_s, "s", peer=("jsonschema, form alone", peer_s))
        print(
            f"| {states:,} | {peer_s:.2f} | {load_s:.2f} | {check_s:.2f} | {findings} | {faulty_s:.2f} | {faults:,} |"
        )


if __name__ == "__main__":
    main()
