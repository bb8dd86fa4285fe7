# SPDX-License-Identifier: Apache-2.0
"""Every end of the shipped missions does what its texts promise: it halts where it states it, and calls whom it
names."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import CallService, SayAloud
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.mission.files import load
from rai_missions.states import Decision, Final, effects
from rai_missions.states.effects import Call

MISSIONS = Path(__file__).parents[2] / "missions"
CALLS, STOPS = ("a person is called", "call a person"), ("stop here for good", "stopped in")


@pytest.mark.parametrize("name", ["tractor", "rosbot"])
def test_an_option_and_its_end_do_what_they_state(name: str) -> None:
    mission = load(MISSIONS / name / "mission.json")
    promised = {state: end.about for _, state, end in mission.walk() if isinstance(end, Final)}
    for _, _, state in mission.walk():
        if isinstance(state, Decision):
            for option, words in state.options.items():
                targets = [to for transition in state.transitions if option in transition.on for to in transition.to]
                for to in targets:
                    if to in promised:
                        promised[to] += f"; {words.about}"
    for end, words in promised.items():
        entry = mission.state(end).entry
        if any(each in words for each in CALLS):
            assert any(isinstance(effect, effects.Say) for effect in entry), (end, words)
        if any(each in words for each in STOPS):
            assert any(isinstance(effect, Call) and effect.call == "halt" for effect in entry), (end, words)


@pytest.mark.parametrize("name", ["tractor/mission", "rosbot/mission", "rosbot/assist", "desk/arrange"])
def test_an_end_is_put_down_to_a_person_only_where_an_event_alone_leads_to_it(name: str) -> None:
    mission = load(MISSIONS / f"{name}.json")
    ways = [*mission.transitions, *(each for _, _, state in mission.walk() for each in state.transitions)]
    ends = {state: end.about for _, state, end in mission.walk() if isinstance(end, Final)}
    for state in (state for state, about in ends.items() if "someone wanted" in about):
        assert all(each.on for each in ways if state in each.to), state


def test_a_tractor_that_gives_up_halts_and_calls_a_person() -> None:
    chart = Chart(load(MISSIONS / "tractor" / "mission.json"), CompiledTrees())
    facts = {"alleys_driven": 0, "at_home": True, "autonomy_state": "WAITING", "battery": 0.9, "touched_living": False}
    for key, value in facts.items():
        chart.write(key, value, at=0.0)
    chart.start()
    chart.send(Event("anomaly", 0.1))
    (question,) = [*chart.send(Event("agent", 0.2, {}, "control")).effects][-1:]
    step = chart.send(Event("agent", 0.3, {"option": "abort"}, "proposal", question.question.number))
    assert (step.outcome, chart.active) == ("aborted", frozenset({"given_up"}))
    assert any(isinstance(effect, CallService) and effect.service == "halt" for effect in step.effects)
    assert any(isinstance(effect, SayAloud) for effect in step.effects)
