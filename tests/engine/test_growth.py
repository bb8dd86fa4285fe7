# SPDX-License-Identifier: Apache-2.0
"""What a microstep costs grows with what it leaves, enters and has to answer, not with their product."""

from __future__ import annotations

import sys
from types import FrameType, ModuleType
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.compiled import configuration, graph
from rai_missions.engine.semantics import hold, macrostep, running, timing
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


def moving(many: int) -> Json:
    """Each region moves on, and remembers where it was."""

    def region(n: int) -> Json:
        here: Json = {"transitions": [{"on": "go", "to": f"near{n}"}]}
        inner = {"initial": f"here{n}", "states": {f"here{n}": here, f"was{n}": {"history": "deep"}}}
        return {"initial": f"in{n}", "states": {f"in{n}": inner, f"near{n}": {}}}

    return parallel(many, region)


def leaving(many: int) -> Json:
    """Each region would leave all of them."""
    return parallel(many, lambda n: {"initial": f"here{n}", "states": {f"here{n}": {"transitions": [OVER]}}})


def finishing(many: int) -> Json:
    """Each region ends, and with the last one all do."""

    def region(n: int) -> Json:
        here: Json = {"transitions": [{"on": "go", "to": f"end{n}"}]}
        return {"initial": f"here{n}", "states": {f"here{n}": here, f"end{n}": {"final": "succeeded"}}}

    document = parallel(many, region)
    document["states"]["all"]["transitions"].append({"on": "succeeded", "to": "over"})
    return document


def ringing(many: int) -> Json:
    """Each region waits for the same instant, and in every second one an action runs until then."""

    def region(n: int) -> Json:
        after: Json = {"transitions": [{"after_s": 0.5, "to": f"there{n}"}]}
        until: Json = {"action": "go", "timeout_s": 0.5, "transitions": [{"on": "timed_out", "to": f"there{n}"}]}
        here = until if n % 2 else after
        return {"initial": f"here{n}", "states": {f"here{n}": here, f"there{n}": {"final": "succeeded"}}}

    document = finishing(many)
    document["states"]["all"]["parallel"] = {f"r{n}": region(n) for n in range(many)}
    return document


LINES_A_REGION = 100
OVER: Json = {"on": "go", "to": "over"}


def lines_of(document: Json, module: ModuleType) -> int:
    """The lines of a module that are executed as a mission starts and one event happens."""
    chart, lines = Chart(Mission.model_validate(document)), 0

    def traced(frame: FrameType, event: str, argument: object) -> Any:
        nonlocal lines
        lines += event == "line" and frame.f_code.co_filename == module.__file__
        return traced

    before = sys.gettrace()
    sys.settrace(traced)
    try:
        chart.start(0.0)
        step = chart.send(Event("go", 1.0))
    finally:
        sys.settrace(before)
    assert step.moves
    return lines


@pytest.mark.parametrize(
    ("document", "module"),
    [
        (raising, macrostep),
        (ending, macrostep),
        (moving, graph),
        (leaving, graph),
        (finishing, graph),
        (finishing, configuration),
        (ringing, configuration),
        (ringing, hold),
        (ringing, macrostep),
        (ringing, running),
        (ringing, timing),
        (ringing, graph),
    ],
)
def test_twice_as_many_regions_cost_twice_as_much(document: Any, module: ModuleType) -> None:
    assert lines_of(document(80), module) < 2.3 * lines_of(document(40), module)


def test_an_event_that_moves_all_regions_finds_what_is_active_at_once() -> None:
    assert lines_of(moving(80), configuration) < 80 * LINES_A_REGION
