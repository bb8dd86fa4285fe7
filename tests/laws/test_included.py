# SPDX-License-Identifier: Apache-2.0
"""A mission that is included does what it does alone, under its private names."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions import load
from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import DefinitionError
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.laws.drawn import EVENTS, KEYS, DrawnEvent, document, happenings, is_far, robot_facts
from tests.rigs.charts import ScriptedRobot

Json = dict[str, Any]
AFTER_S = 5.0
SHARED = ("given", "fact", "count", "clear")
"""Keys of the outer mission that the inner one shares: what answers, predicates and profiles know by these names."""


def including(rng: random.Random) -> Json:
    """A mission that does nothing but include `inner.json`, with time of its own for what a final requires."""
    keys = [*SHARED, *(name for name in KEYS if name not in SHARED and rng.random() < 0.3)]
    events = [name for name in EVENTS if rng.random() < 0.3]
    mapped = {name: {"from": name} for name in keys} | {name: name for name in events}
    part = {"mission": "inner.json", "with": mapped, "transitions": [{"on": "succeeded", "to": "over"}]}
    return {
        "name": "outer",
        "blackboard": {name: KEYS[name] for name in keys},
        "events": events,
        "initial": "part",
        "states": {"part": part, "over": {"final": "succeeded"}},
        "settle_s": rng.choice([0.0, 1.0]),
        "cancel_s": 2.0,
    }


def seen(step: Step) -> tuple[object, ...]:
    """What a step did, but for the names of what an inclusion made private and the places of what it moved."""
    moved = [(name for name in names if name != "part") for names in (step.entered, step.exited)]
    verdicts = [  # at the top a final that waits gives another reason
        each._replace(why="") if each.kind == "stale" else each for each in step.verdicts
    ]
    done = (*map(list, moved), step.writes, step.effects, verdicts, step.wake_at, step.mode, step.holder)
    return tuple(repr(each).replace("part/", "") for each in done)


def agree(seed: int, folder: Path) -> bool:
    """Whether the two can be compared: some missions cannot be included, and a circle ends where a step began."""
    rng = random.Random(seed)
    inner, script, robot, outer = document(rng), happenings(rng), robot_facts(rng), including(rng)
    inner.pop("on_cancel", None)  # that of the outermost mission counts
    for name, made in (("inner", inner), ("outer", outer)):
        (folder / f"{name}.json").write_text(json.dumps({"format": 1, **made}))
    try:
        missions = [Mission.model_validate(inner), load(folder / "outer.json")]
    except DefinitionError:
        return False
    charts = [Chart(each, CompiledTrees(), robot_facts=robot, named={"is_far": is_far}) for each in missions]
    robots = [ScriptedRobot("agent") for _ in charts]
    private = {*KEYS, *EVENTS} - outer["states"]["part"]["with"].keys()
    for happening in [None, *script, DrawnEvent(("tick",), script[-1].at + AFTER_S)]:
        steps = []
        for chart, each in zip(charts, robots, strict=True):
            event = Event("start", 0.0, {}, "command") if happening is None else each.event(*happening)
            if chart is charts[1] and event.kind in ("event", "write") and event.name in private:
                event = event._replace(name=f"part/{event.name}")
            steps.append(each.follow(chart.start(0.0) if happening is None else chart.send(event)))
        if "cycle" in (charts[0].cause, charts[1].cause):
            return False
        assert (charts[0].outcome is None) is (charts[1].outcome is None), f"{seed}: {happening}"
        if charts[0].outcome is not None:
            return True
        assert seen(steps[0]) == seen(steps[1]), f"{seed}: {happening}"
    return True


@given(seed=st.integers(0, 2**32))
@settings(max_examples=40)
def test_a_mission_that_is_included_does_what_it_does_alone(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assume(agree(seed, tmp_path_factory.mktemp("included")))


@pytest.mark.drill
def test_three_thousand_included_missions_do_what_they_do_alone(tmp_path: Path) -> None:
    assert sum(agree(seed, tmp_path) for seed in range(3_000)) > 2_400


@pytest.mark.parametrize(("own", "counts"), [
    ({}, [1, 2, 3]),
    ({"with": {"tries": {"from": "tries"}}, "entry": [{"set": "tries", "value": 0}]}, [1, 1, 1]),
])  # fmt: skip
def test_the_keys_of_an_inclusion_are_kept_until_it_is_entered_again_unless_they_are_set(
    tmp_path: Path, own: Json, counts: list[int]
) -> None:
    tries = {"type": "integer", "initial": 0}
    inner: Json = {
        "name": "inner", "blackboard": {"tries": tries}, "initial": "x",
        "states": {"x": {"entry": [{"set": "tries", "add": 1}], "transitions": [{"after_s": 1, "to": "y"}]},
                   "y": {"final": "succeeded"}},
    }  # fmt: skip
    part: Json = {"mission": "inner.json", "transitions": [{"on": "succeeded", "to": "round"}], **own}
    rounds = {
        "each": "stops",
        "as": "item",
        "initial": "part",
        "states": {"part": part, "round": {"final": "succeeded"}},
    }
    outer: Json = {
        "name": "outer", "initial": "rounds", "states": {"rounds": rounds},
        "blackboard": {
            "stops": {"type": "list", "source": "argument", "initial": ["a", "b", "c"]},
            "item": {"type": "string", "initial": ""}, **({"tries": tries} if own else {}),
        },
    }  # fmt: skip
    for name, made in (("inner", inner), ("outer", outer)):
        (tmp_path / f"{name}.json").write_text(json.dumps({"format": 1, **made}))
    chart = Chart(load(tmp_path / "outer.json"))
    chart.start(0.0)
    found = []
    for at in (1.0, 2.0, 3.0):
        found.append(chart.view.board["tries" if own else "part/tries"].value)
        chart.send(Tick(at))
    assert found == counts


def test_what_entry_raises_later_comes_before_the_timers_of_the_mission_alone_and_included(tmp_path: Path) -> None:
    inner: Json = {
        "name": "inner", "events": ["rang"], "initial": "waiting", "transitions": [{"after_s": 1, "to": "timer"}],
        "states": {
            "waiting": {"entry": [{"raise": "rang", "after_s": 1}], "transitions": [{"on": "rang", "to": "raised"}]},
            "raised": {"final": "succeeded"}, "timer": {"final": "failed"},
        },
    }  # fmt: skip
    part = {
        "mission": "inner.json",
        "transitions": [{"on": "succeeded", "to": "raised"}, {"on": "failed", "to": "timer"}],
    }
    states = {"part": part, "raised": {"final": "succeeded"}, "timer": {"final": "failed"}}
    for name, made in (("inner", inner), ("outer", {"name": "outer", "initial": "part", "states": states})):
        (tmp_path / f"{name}.json").write_text(json.dumps({"format": 1, **made}))
    charts = [Chart(load(tmp_path / f"{name}.json")) for name in ("inner", "outer")]
    for chart in charts:
        chart.start(0.0)
        chart.send(Tick(1.0))
    assert [chart.outcome for chart in charts] == ["succeeded", "succeeded"]
