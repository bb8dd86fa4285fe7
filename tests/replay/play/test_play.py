# SPDX-License-Identifier: Apache-2.0
"""A mission that is played: what is offered is what can happen, and what was undone never happened."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.activities.action import GOAL_ENDS
from rai_missions.engine.activities.call import REPLIES, replies_to
from rai_missions.engine.state import TABLE
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import KINDS, Event, Tick
from rai_missions.keys import Key
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.replay.play import Play, PlayChoice
from rai_missions.replay.play.choice import Passage
from rai_missions.replay.play.offers import inside, settled
from rai_missions.runtime.arguments import accepted
from rai_missions.states.control import HOLDERS
from tests.engine.test_goals import mission as stacking
from tests.strategies import EVENTS, missions

ROOT = Path(__file__).parents[3]
FEW = settings(suppress_health_check=list(HealthCheck), max_examples=3)
MANY = settings(suppress_health_check=list(HealthCheck), max_examples=250)
UNCHANGED = ("past", "passing", "number", "payload")


def values_of(choice: PlayChoice, chance: random.Random) -> dict[str, Any]:
    """Values that a person might give."""
    given_values: dict[str, Any] = {}
    for field in choice.fields:
        if field.among and chance.random() < 0.5:
            given_values[field.name] = chance.choice(field.among)
        elif field.name == "seconds":
            given_values[field.name] = chance.choice([0.5, 1, 3.0, 12])
        elif field.examples and chance.random() < 0.5:
            given_values[field.name] = chance.choice(field.examples)
    return given_values


def wandering(mission: Mission, seed: int, clicks: int = 14) -> Iterator[Play]:
    """A play that goes where chance leads; given before each choice, and at its end."""
    chance, play = random.Random(seed), Play(mission)
    for _ in range(clicks):
        yield play
        choices = play.choices()
        if not choices:
            return
        kinds = sorted({choice.kind for choice in choices} - ({"command"} if chance.random() < 0.7 else set()))
        begins = [choice for choice in choices if choice.kind == "start"]
        kind = chance.choice(kinds)
        choice = begins[0] if begins else chance.choice([each for each in choices if each.kind == kind] or choices)
        play.do(choice.name, values_of(choice, chance))
    yield play


def content(chart: Chart) -> dict[str, Any]:
    """What a run remembers that not every step changes."""
    return {name: getattr(chart.state, name) for name, _, holds in TABLE if holds not in UNCHANGED}


def raw_events(chart: Chart, mission: Mission) -> Iterator[Event]:
    """Everything that could be sent to a chart, sense or nonsense."""
    last = chart.state.number
    numbers = sorted(chart.awaited | {0, 1, last - 1, last, last + 1})
    by = {"by": "operator"}
    yield from (Event(name, chart.at) for name in (*EVENTS, "nonsense"))
    for kind in KINDS:
        if kind in ("accepted", "refused", "lost", "contested", "over"):
            yield from (Event("drive", chart.at, {}, kind, number) for number in numbers)
    yield from (Event(name, chart.at, {}, "result", n) for n in numbers for name in {*GOAL_ENDS, *REPLIES})
    for number in numbers:
        yield from (Event("x", chart.at, {"option": each}, "proposal", number) for each in ("?", "wait", "replan"))
        yield Event("x", chart.at, {"absent": "x"}, "proposal", number)
    yield from (Event(name, chart.at, by, "command") for name in ("pause", "resume", "cancel", "kill"))
    yield from (Event(name, chart.at, {"by": "operator", "role": "operator"}, "control") for name in HOLDERS)
    yield Event("uncertain", chart.at, {}, "doubt")


PHASES = {
    "refused": ("canceling", "orphaned"), "over": ("canceling", "orphaned"),
    "lost": ("sent", "running", "canceling"), "contested": ("sent", "running", "canceling"),
}  # fmt: skip
"""What a server may report outside a goal's course → in which of its phases, if it is not lost or refused already."""


def is_offered(event: Event, play: Play) -> bool:
    """Whether a play offers an event, by its name or under the number that it carries."""
    names = [choice.name for choice in play.choices()]
    if event.kind in ("accepted", "result", *PHASES):
        word = event.name if event.kind == "result" else event.kind
        return any(name.endswith(f" {event.number} {word}") for name in names)
    if event.kind == "proposal":
        option = event.data.get("option", "absent")
        return f"answer {event.number} {'invalid' if option == '?' else option}" in names
    prefix = {"event": "event", "command": "command", "control": "control", "doubt": "event"}[event.kind]
    return f"{prefix} {event.name}" in names


def takes_each_choice(mission: Mission, seed: int) -> None:
    for play in wandering(mission, seed, clicks=6):
        for choice in play.choices():
            chart = play.chart.branch()
            inputs = choice.inputs(chart, {})
            if not all(isinstance(each, Event) for each in inputs):
                assert choice.kind in ("time", "stale")
                continue
            steps = [
                chart.start(each.at) if each.name == "start" else chart.send(each)
                for each in inputs
                if isinstance(each, Event)
            ]
            assert [step.refusal for step in steps] == [""] * len(steps), choice.name
            if choice.kind not in ("key", "stale", "time", "start") and not (choice.kind == "event" and choice.fields):
                is_noted = not all(step.ignored for step in steps)
                assert is_noted or content(chart) != content(play.chart), choice.name


def makes_sense(event: Event, chart: Chart) -> bool:
    """Whether anyone could send an event to a run: it is about something that is there, in words of its kind."""
    goal = chart.state.goals.get(event.number)
    question = next((each for each in chart.questions if each.number == event.number), None)
    if event.kind in PHASES:
        is_marked = goal is None or goal.is_lost or goal.is_refused
        return goal is not None and not is_marked and goal.phase in PHASES[event.kind]
    if event.kind == "accepted":
        return goal is not None and goal.phase in ("sent", "withdrawn")
    if event.kind == "result":
        is_awaited = goal is not None or (question is None and event.number in chart.awaited)  # a pause keeps any
        machines = {number: each.machine for each in inside(chart) for number in each.machine.awaits(each.state)}
        return is_awaited and event.name in (GOAL_ENDS if goal is not None else replies_to(machines.get(event.number)))
    if event.kind == "proposal":
        offered = {offer.name for offer in question.options} | {"?"} if question is not None else set()
        return event.data.get("option", "?") in offered
    if event.kind == "control":
        has_control = any(state.control is not None for _, _, state in chart.mission.walk())
        return has_control and event.name != chart.holder and chart.outcome is None
    return event.kind != "doubt"  # no transition of these missions names it


def lacks_nothing(mission: Mission, seed: int) -> None:
    for play in wandering(mission, seed, clicks=8):
        chart = settled(play.chart)
        for event in raw_events(chart, mission):
            probe = chart.branch()
            step = probe.send(event)
            is_taken = not step.refusal and not (step.ignored and content(probe) == content(chart))
            if is_taken and makes_sense(event, chart):
                assert is_offered(event, play), (event, [choice.name for choice in play.choices()])


def undoes_exactly(mission: Mission, seed: int) -> None:
    seen = []
    play = Play(mission)
    for play in wandering(mission, seed, clicks=8):
        seen.append((play.chart.snapshot(), [choice.name for choice in play.choices()]))
    while play.path:
        assert (play.chart.snapshot(), [choice.name for choice in play.choices()]) == seen.pop()
        play.undo()
    assert (play.chart.snapshot(), [choice.name for choice in play.choices()]) == seen.pop()
    with pytest.raises(UsageError, match="nothing to undo"):
        play.undo()


def is_one_run(mission: Mission, seed: int) -> None:
    for play in wandering(mission, seed, clicks=10):  # noqa: B007 - the last one is meant
        pass
    chart = Play(mission).chart
    for step in play.steps:
        again = chart.start(step.event.at) if step.event.name == "start" else chart.send(step.event)
        assert again == step
    found, played = chart.snapshot(), play.chart.snapshot()
    assert [word for _, word, holds in TABLE if holds != "passing" and found[word] != played[word]] == []


LAWS = (takes_each_choice, lacks_nothing, undoes_exactly, is_one_run)
"""What is offered is taken, nothing that would be taken is missing, undo restores, and a play is a run of a chart."""


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@FEW
@given(mission=missions(), seed=st.integers(0, 10_000))
def test_a_law_of_plays(law: Callable[[Mission, int], None], mission: Mission, seed: int) -> None:
    law(mission, seed)


@pytest.mark.drill
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@MANY
@given(mission=missions(), seed=st.integers(0, 10_000))
def test_a_law_of_plays_holds_for_many(law: Callable[[Mission, int], None], mission: Mission, seed: int) -> None:
    law(mission, seed)


# -- examples ---------------------------------------------------------------------------------------------------------


def errand(**more: Any) -> Mission:
    return Mission.model_validate({
        "format": 1, "name": "errand", "initial": "going",
        "blackboard": {
            "battery": {"type": "number", "source": "robot", "max_age_s": 2},
            "load": {"type": "integer", "source": "robot", "optional": True},
        },
        "events": {"halt": {}},
        "states": {
            "going": {"action": "go",
                      "transitions": [{"on": "succeeded", "to": "done"}, {"on": "halt", "to": "asking"}]},
            "asking": {
                "decision": {
                    "question": "And now?", "ask": ["operator"], "fallback": "stop",
                    "options": {"go_on": {"parameters": {"type": "object", "properties": {"speed": {"type": "number"}},
                                                         "required": ["speed"]}},
                                "stop": {}},
                },
                "transitions": [{"on": "go_on", "to": "going"}, {"on": "stop", "to": "stopped"}],
            },
            "low": {"final": "failed"}, "done": {"final": "succeeded"}, "stopped": {"final": "aborted"},
        },
        "transitions": [{"when": {"any": [{"key": "battery", "<": 0.2}, {"not": {"fresh": "battery"}}]}, "to": "low"}],
        **more,
    })  # fmt: skip


def started() -> Play:
    play = Play(errand())
    play.do("readings")
    play.do("start")
    return play


def names(play: Play) -> list[str]:
    return [choice.name for choice in play.choices()]


def test_the_start_waits_for_the_arguments_without_which_a_run_is_refused() -> None:
    mission = errand()
    there = {
        name: Key("string", source="argument", **more)
        for name, more in {"where": {}, "whence": {"initial": "home"}, "whom": {"optional": True}}.items()
    }
    mission = mission.model_copy(update={"blackboard": {**mission.blackboard, **there}})
    play = Play(mission)
    play.do("readings")
    assert "arguments" in names(play) and "start" not in names(play)
    with pytest.raises(DefinitionError, match="needs the argument 'where'"):
        accepted(mission, {})
    play.do("arguments", {"where": "kitchen"})
    assert "arguments" not in names(play)
    play.do("start")
    assert play.chart.view.board["where"].value == "kitchen"
    assert accepted(mission, {"where": "kitchen"})


def test_the_start_waits_for_the_robots_facts() -> None:
    play = Play(errand())
    assert "readings" in names(play)
    assert "start" not in names(play)
    play.do("readings", {"battery": 0.9})
    assert "start" in names(play)


def test_an_event_is_offered_only_where_it_is_taken() -> None:
    play = started()
    assert "event halt" in names(play)
    play.do("event halt")
    assert "event halt" not in names(play)


def test_facts_stay_fresh_while_time_passes_and_go_stale_when_they_are_let() -> None:
    play = started()
    play.do("time", {"seconds": 60})
    assert play.chart.active == {"going"}
    assert play.chart.at == 60
    play.do("stale battery")
    assert play.chart.outcome == "failed"


def test_time_that_passes_with_a_stale_fact_keeps_it_stale() -> None:
    play = Play(errand(transitions=[]))
    play.do("readings")
    play.do("start")
    play.do("stale battery")
    play.do("time", {"seconds": 5})
    assert "stale battery" not in names(play)
    play.do("key battery", {"battery": 0.5})
    assert "stale battery" in names(play)


def test_the_next_change_is_a_timer_and_no_fact_that_would_go_stale() -> None:
    timed = {"states": {"going": {"action": "go", "timeout_s": 30}}, "transitions": []}
    play = Play(errand(**timed))
    play.do("readings")
    play.do("start")
    play.do("next")
    assert play.chart.at == 30
    assert play.chart.why == "going: timed_out (30 s have passed)"


def test_values_that_do_not_fit_change_nothing() -> None:
    play = started()
    before = play.chart.snapshot()
    for name, given_values, why in (
        ("key battery", {"battery": "full"}, "is not of type 'number'"),
        ("key battery", {"batery": 1.0}, "did you mean 'battery'"),
        ("time", {"seconds": -1}, "above 0"),
        ("time", {"seconds": 1e8}, "let less time pass"),
        ("event holt", {}, "did you mean 'event halt'"),
        ("answer 1 stop", {}, "cannot happen now"),
    ):
        with pytest.raises(UsageError, match=why):
            play.do(name, given_values)
    assert play.chart.snapshot() == before
    assert len(play.path) == 2


def test_an_answer_takes_its_parameters() -> None:
    play = started()
    play.do("event halt")
    answer = next(choice for choice in play.choices() if choice.name.endswith("go_on"))
    assert [(field.name, field.type, field.is_required) for field in answer.fields] == [("speed", "number", True)]
    play.do(answer.name, {"speed": 0.5})
    assert play.chart.active == {"going"}


def test_an_answer_that_the_rules_would_refuse_is_offered_with_the_reason() -> None:
    data = json.loads(json.dumps(errand().written()))
    data["states"]["asking"]["decision"]["options"]["go_on"] = {"when": {"key": "battery", ">": 0.5}}
    play = Play(Mission.model_validate(data))
    play.do("readings")
    play.do("start")
    play.do("event halt")
    play.do("key battery", {"battery": 0.4})
    refused = {choice.name.rpartition(" ")[2]: choice.refused for choice in play.choices() if choice.kind == "answer"}
    assert "no longer holds" in refused.pop("go_on")
    assert set(refused.values()) == {""}


def test_a_mission_with_trees_images_and_control_is_played_to_its_end() -> None:
    play = Play(load(ROOT / "missions/tractor/mission.json"))
    play.do("readings")
    play.do("start")
    play.do("event anomaly")
    play.do("control agent")
    answer = next(choice for choice in play.choices() if choice.name.endswith(" signal"))
    play.do(answer.name)
    call = next(choice for choice in play.choices() if choice.kind == "call" and choice.name.endswith("succeeded"))
    play.do(call.name)
    play.do("next")  # nothing is there that blocks the way: after 2 s it drives on
    assert "driving" in play.chart.active
    play.do("event e_stop")
    assert play.chart.outcome == "aborted"


def test_what_seldom_happens_to_a_goal_is_offered_last_and_only_where_it_can() -> None:
    play = started()
    assert [choice.name for choice in play.choices() if choice.is_rare] == ["goal 1 lost", "goal 1 contested"]
    assert [choice.is_rare for choice in play.choices()][-2:] == [True, True]
    play.do("goal 1 accepted")
    play.do("command pause")  # the goal is canceled
    rare = [choice.name for choice in play.choices() if choice.is_rare]
    assert rare == ["goal 1 lost", "goal 1 contested", "goal 1 refused", "goal 1 over"]
    play.do("goal 1 refused")
    assert "goal 1 refused" not in names(play)
    play.do("goal 1 lost")
    assert "goal 1 lost" not in names(play)


def test_nothing_can_happen_any_more_once_the_mission_and_its_goals_have_ended() -> None:
    play = started()
    play.do("command kill")
    assert {choice.kind for choice in play.choices()} == {"goal", "time"}
    play.do("goal 1 canceled")
    assert [choice.name for choice in play.choices()] == ["goal 1 stray"]


def test_the_inputs_of_time_are_one_passage() -> None:
    click = started().do("time", {"seconds": 3})
    assert click.inputs == (Passage(3.0),)
    assert click.steps[-1].event == Tick(3.0)


def test_what_is_seen_and_wanted_is_suggested_so_that_a_goal_can_be_reached() -> None:
    play = Play(stacking())
    fields = {field.name: field for choice in play.choices() for field in choice.fields}
    apart, stacked, *_ = fields["objects"].examples
    assert fields["objects"].suggested == apart and len(fields["objects"].examples) == 5
    play.do("key objects", {"objects": apart})
    play.do("start")
    assert play.chart.active == {"moving"}
    play.do("key objects", {"objects": stacked})
    assert play.chart.outcome == "succeeded"
