# SPDX-License-Identifier: Apache-2.0
"""What a microstep costs grows with what it leaves and with what waits to be answered, not with their product."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import pytest

from rai_missions.engine import Chart, macrostep
from rai_missions.event import Event
from rai_missions.mission.mission import Mission

Json = dict[str, Any]


def raising(many: int) -> Json:
    """Each region raises an event, and the first of these leaves all regions."""

    def region(n: int) -> Json:
        here: Json = {"transitions": [{"on": "go", "to": f"there{n}", "do": [{"raise": "hint"}]}]}
        return {"initial": f"here{n}", "states": {f"here{n}": here, f"there{n}": {}}}

    return parallel(many, region)


def ending(many: int) -> Json:
    """Each list ends its first round, and the end of the first leaves all."""

    def region(n: int) -> Json:
        here: Json = {"transitions": [{"on": "go", "to": f"there{n}"}]}
        end: Json = {"final": "succeeded" if n else "failed"}
        states = {f"here{n}": here, f"there{n}": end}
        return {"each": "places", "as": f"place{n}", "initial": f"here{n}", "states": states}

    document = parallel(many, region)
    document["states"]["all"]["parallel"]["r0"]["transitions"] = [{"on": "failed", "to": "over"}]
    document["blackboard"] = {"places": {"type": "list", "initial": ["a", "b"]}}
    document["blackboard"] |= {f"place{n}": {"type": "string"} for n in range(many)}
    return document


def parallel(many: int, region: Any) -> Json:
    regions = {f"r{n}": region(n) for n in range(many)}
    return {
        "format": 1, "name": "many", "initial": "all", "events": {"go": {}, "hint": {}},
        "states": {
            "all": {"parallel": regions, "transitions": [{"on": "hint", "to": "over"}]}, "over": {"final": "aborted"},
        },
    }  # fmt: skip


def lines_of(document: Json) -> int:
    """The lines of the module that one event executes."""
    chart, lines = Chart(Mission.model_validate(document)), 0
    chart.start(0.0)

    def traced(frame: FrameType, event: str, argument: object) -> Any:
        nonlocal lines
        lines += event == "line" and frame.f_code.co_filename == macrostep.__file__
        return traced

    before = sys.gettrace()
    sys.settrace(traced)
    try:
        step = chart.send(Event("go", 1.0))
    finally:
        sys.settrace(before)
    assert step.outcome == "aborted"
    return lines


@pytest.mark.parametrize("document", [raising, ending])
def test_leaving_twice_as_many_states_costs_twice_as_much(document: Any) -> None:
    assert lines_of(document(80)) < 2.3 * lines_of(document(40))
