# SPDX-License-Identifier: Apache-2.0
"""One table of modes: the chart refuses by it, the lifecycle follows it, and the diagram is drawn from it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.modes import ALIVE, MODE_TABLE, MODES, diagram, next_mode, refusal
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Lifecycle

DOCUMENT = Path(__file__).parents[2] / "docs" / "decisions"
MISSION = Mission.model_validate({
    "name": "modes", "initial": "here", "on_cancel": "leaving", "cancel_s": 3,
    "events": {"done": {}, "fail": {}},
    "blackboard": {"safe": {"type": "boolean", "source": "robot", "optional": True}},
    "invariants": {"is_safe": {"not": {"key": "safe", "==": False}}},
    "states": {
        "here": {"transitions": [{"on": "done", "to": "over"}, {"on": "fail", "to": "failed"}]},
        "leaving": {}, "over": {"final": "aborted"}, "failed": {"final": "failed"},
    },
})  # fmt: skip
COMMANDS = ("pause", "stop", "resume", "cancel", "kill")
TO_REACH = {"running": (), "paused": ("pause",), "canceling": ("cancel",), "aborted": ("kill",)}


def mode_of(chart: Chart) -> str:
    return chart.outcome if chart.outcome is not None else chart.mode


def sent(chart: Chart, name: str) -> Step:
    kind = "command" if name in COMMANDS else "event"
    return chart.send(Event(name, chart.at, {}, kind))


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("mode", TO_REACH)
def test_the_chart_refuses_what_the_table_does_not_have(mode: str, command: str) -> None:
    chart = Chart(MISSION)
    chart.start()
    for each in TO_REACH[mode]:
        sent(chart, each)
    assert mode_of(chart) == mode
    step = sent(chart, command)
    if why := refusal(mode, command):
        assert step.why == why and not (step.moves or step.effects) and mode_of(chart) == mode
    else:
        assert mode_of(chart) == next_mode(mode, command)


HAPPENINGS = (*COMMANDS, "done", "fail", "unsafe", "safe", "later")


@given(st.lists(st.sampled_from(("pause", "stop", "resume", "cancel", "safe")), max_size=4),
       st.lists(st.sampled_from(HAPPENINGS), max_size=8))  # fmt: skip
def test_whatever_happens_the_modes_go_the_ways_of_the_table(early: list[str], script: list[str]) -> None:
    chart, life = Chart(MISSION), Lifecycle()

    def seen(step: Step) -> None:
        life.observe(step, chart)
        assert life.mode == mode_of(chart)

    for each in (*early, *(("start",) if not early else ("resume", "start")), *script):
        before = mode_of(chart)
        if each == "start":
            if chart.mode == "ready":
                seen(chart.start())
            continue
        if each == "later":
            seen(chart.send(Tick(chart.at + 2)))
        elif each in ("safe", "unsafe"):
            seen(chart.write("safe", each == "safe"))
        else:
            seen(sent(chart, each))
        after = mode_of(chart)
        through = {next_mode(before, transition.trigger) for transition in MODE_TABLE}
        assert after == before or after in through | {next_mode(str(mode), after) for mode in through}
        assert chart.unstarted == (after in ("ready", "paused") and not chart.active)


@pytest.mark.parametrize("command", ["pause", "stop"])
def test_a_mission_that_is_paused_before_its_start_is_not_started(command: str) -> None:
    chart = Chart(MISSION)
    assert sent(chart, command).notes == ("paused before the start",)
    with pytest.raises(UsageError, match="the mission is paused before its start; resume it first"):
        chart.start()
    assert sent(chart, "pause").why == "only a running mission can be paused; it is paused"
    sent(chart, "resume")
    assert chart.start().entered == ("here",)
    with pytest.raises(UsageError, match="the mission was started before; it is running"):
        chart.start()


def test_a_run_that_goes_where_no_transition_leads_is_refused() -> None:
    paused, canceling, life = Chart(MISSION), Chart(MISSION), Lifecycle()
    started = paused.start()
    canceling.start()
    sent(paused, "pause")
    sent(canceling, "cancel")
    life.observe(started, paused)
    with pytest.raises(UsageError, match="a run cannot go from 'paused' to 'canceling'"):
        life.observe(started, canceling)


def test_every_mode_is_reached_and_only_outcomes_are_left_by_nothing() -> None:
    assert {transition.target for transition in MODE_TABLE} | {"ready"} == set(MODES)
    assert {mode for transition in MODE_TABLE for mode in transition.sources} == set(ALIVE)


def test_the_diagram_in_the_documents_is_the_table() -> None:
    assert any("\n".join(diagram()) in path.read_text(encoding="utf-8") for path in DOCUMENT.glob("*.md"))
