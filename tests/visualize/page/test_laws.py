# SPDX-License-Identifier: Apache-2.0
"""Laws of the page's data: it is the mission, all of it, once; what it plays is the run; a lens reports the truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.states import Final
from tests.strategies import EVENTS, missions
from tests.visualize.page.reading import answered, data_of, folded, journal_of
from tests.visualize.runs import ROOT, document, hostile, run, tractor
from visualize.page import review, review_data, run_of_steps
from visualize.page.decision_sites import asked_of
from visualize.page.reachability import Roads

LENSES = ("model", "operator", "stops", "invariants")


@given(missions())
def test_every_state_and_every_transition_is_in_the_data_once(mission: Mission) -> None:
    chart = data_of(review(mission))["chart"]
    transitions = Counter(
        (place, source, target)
        for place, source, written in [
            *((f"{place}/transitions", name, state.transitions) for place, name, state in mission.walk()),
            ("/transitions", "", mission.transitions),
        ]
        for place, source, targets in [
            (f"{place}/{index}", source, transition.to) for index, transition in enumerate(written)
        ]
        for target in targets or ("",)
    )
    assert Counter(state["name"] for state in chart["states"]) == Counter(name for _, name, _ in mission.walk())
    assert (
        Counter(
            (transition["place"], transition.get("source", ""), transition.get("target", ""))
            for transition in chart["transitions"]
        )
        == transitions
    )


@given(missions())
def test_a_states_definition_is_what_is_written_of_it_and_not_of_those_inside(mission: Mission) -> None:
    for state in data_of(review(mission))["chart"]["states"]:
        written = mission.state(state["name"]).written()
        inside = {word: list(written[word]) for word in ("states", "parallel") if isinstance(written.get(word), dict)}
        assert state.get("definition", {}) == plain({**written, **inside})


def active_after(
    mission: Mission, events: list[str]
) -> tuple[list[Step], list[frozenset[str]], list[dict[str, list[Any]]]]:
    chart = Chart(mission, ticker=CompiledTrees())
    steps, active, boards = [], [], []
    happened = [
        each for number, name in enumerate(events, 1) for each in (Event(name, 3.0 * number), Tick(3.0 * number + 1))
    ]
    for event in (None, *happened):
        if steps and steps[-1].outcome:
            break
        steps.append(chart.start(at=0.0) if event is None else chart.send(event))
        active.append(chart.active)
        boards.append({name: [plain(entry.value), entry.at] for name, entry in chart.view.board.items()})
    return steps, active, boards


@given(missions(), st.lists(st.sampled_from(EVENTS), max_size=5))
def test_what_is_played_is_what_the_chart_was_at_every_step(mission: Mission, events: list[str]) -> None:
    steps, active, boards = active_after(mission, events)
    data = data_of(review(mission, runs=[run_of_steps(steps)]))
    played = folded(data["runs"][0], data["chart"]["keys"])
    for (states, board), truly, known, step in zip(played, active, boards, steps, strict=True):
        assert states == truly
        assert {name: entry[0] for name, entry in board.items()} == {name: entry[0] for name, entry in known.items()}
        assert all(known[name][1] <= entry[1] <= step.at for name, entry in board.items())


@given(missions(), st.lists(st.sampled_from(EVENTS), max_size=5))
def test_coverage_counts_each_transition_that_a_journal_took(mission: Mission, events: list[str]) -> None:
    steps = run(mission, events)
    with TemporaryDirectory() as folder:
        path = journal_of(Path(folder) / "a.journal", mission, steps)
        data = data_of(review(mission, [path, path]))
    taken = Counter(place for step in steps for move in step.moves for place in move.taken)
    entered = Counter(name for step in steps for name in step.entered)
    assert data["coverage"] == {
        "transitions": {place: [times, times] for place, times in taken.items()},
        "states": {name: [times, times] for name, times in entered.items()},
    }


@given(missions(), st.lists(st.sampled_from(EVENTS), max_size=5))
def test_a_run_enters_nothing_that_is_out_of_reach(mission: Mission, events: list[str]) -> None:
    roads = Roads(mission)
    entered: list[str] = []
    for step in run(mission, events):
        for move in step.moves:
            if entered:
                reached = roads.onward(entered).states
                around = {above for name in reached for above in roads.above(name)}
                assert set(move.entered) <= reached | around
            entered += move.entered


@given(missions())
@example(tractor())
@example(hostile())
def test_a_lens_names_what_there_is(mission: Mission) -> None:
    data = review_data(mission)
    states = {state["name"] for state in data["chart"]["states"]}
    transitions = {transition["place"] for transition in data["chart"]["transitions"]}
    options = {place for who in ("agent", "operator") for each in asked_of(mission, who) for place in each.options()}
    assert tuple(lens["name"] for lens in data["lenses"]) == LENSES
    for lens in data["lenses"]:
        assert set(lens["states"]) <= states
        assert set(lens["transitions"]) <= transitions
        assert set(lens["options"]) <= options
        items = [item for section in lens["sections"] for item in section["items"]]
        assert {item["state"] for item in items if "state" in item} <= states
        assert {item["transition"] for item in items if "transition" in item} <= transitions


@given(missions())
@example(tractor())
@example(hostile())
def test_the_lens_of_the_model_lights_its_decisions_with_every_option_and_every_bound(mission: Mission) -> None:
    lens = review_data(mission)["lenses"][0]
    reported = " ".join(item["text"] for section in lens["sections"] for item in section["items"])
    for each in asked_of(mission, "agent"):
        assert each.state in lens["states"]
        assert set(each.options()) <= set(lens["options"])
        assert (
            f"at most {each.asked.deadline_s:g} s" in reported if each.asked.deadline_s else "no deadline" in reported
        )
        assert f": {each.asked.fallback or 'failed'} → " in reported
    for name, state in mission.states.items():
        if isinstance(state, Final) and lens["states"]:
            assert f"{name} ({state.final}): " in reported


@pytest.mark.parametrize("mission", [tractor(), hostile()], ids=["tractor", "hostile"])
def test_the_page_is_the_same_bytes_for_the_same_mission(mission: Mission) -> None:
    assert review(mission) == review(mission)


def test_no_answer_of_the_tractors_model_leads_to_success_at_once() -> None:
    lens = review_data(tractor())["lenses"][0]
    ends = next(section for section in lens["sections"] if section["heading"] == "Ends")
    reported = {item["state"]: item["text"] for item in ends["items"] if "state" in item}
    assert "not by an answer alone" in reported["done"]
    assert "and only if alleys_driven ≥ alleys" in reported["done"]
    assert "an answer leads there at once" in reported["aborted"]


def test_an_option_that_ends_the_mission_reports_it_and_one_behind_another_transition_reports_where() -> None:
    lens = review_data(load(ROOT / "missions/tractor/mission.json"))["lenses"][0]
    reported = [item["text"] for section in lens["sections"] for item in section["items"]]
    assert "abort: always open; leads to given_up, which ends the mission" in reported
    assert "given_up (aborted): an answer leads there at once" in reported
    assert "stopped (aborted): an answer leads there at once where the transitions behind it hold already" in reported


def ends_of(change: Callable[[dict[str, Any]], Any]) -> list[str]:
    """What the first lens reports of the ends of the tractor's mission, changed."""
    given = document()
    change(given["states"])
    lens = review_data(Mission.model_validate(given))["lenses"][0]
    return [item["text"] for item in next(each for each in lens["sections"] if each["heading"] == "Ends")["items"]]


def abort_to(states: dict[str, Any], target: str) -> None:
    next(transition for transition in states["assessing"]["transitions"] if transition["on"] == "abort")["to"] = target


def through_a_room(states: dict[str, Any]) -> None:
    abort_to(states, "room")
    states["room"] = {"initial": "end", "states": {"end": {"final": "succeeded"}}}
    states["room"]["transitions"] = [{"on": "succeeded", "to": "done"}]


def through_a_wait(states: dict[str, Any]) -> None:
    abort_to(states, "still")
    states["still"] = {"transitions": [{"when": {"key": "alleys", ">": 0}, "to": "done"}]}


@pytest.mark.parametrize("change", [lambda states: abort_to(states, "done"), through_a_wait, through_a_room])
def test_an_answer_that_may_end_the_mission_as_succeeded_is_reported(change: Callable[[dict[str, Any]], Any]) -> None:
    reported = ends_of(change)
    assert any(each.startswith("done (succeeded): an answer leads there at once") for each in reported)
    assert reported[-1].startswith("where alleys_driven ≥ alleys")
    assert reported[-1].endswith("already holds, the answer ends the mission as succeeded, in 'done'")
    assert not any("none alone" in each for each in reported)


def test_time_that_passes_may_lead_to_an_end() -> None:
    def later(states: dict[str, Any]) -> None:
        abort_to(states, "still")
        states["still"] = {"transitions": [{"after_s": 5, "to": "done"}]}

    reported = ends_of(later)
    assert any(
        each.startswith("done (succeeded): not by an answer alone") and "time that passes" in each for each in reported
    )
    assert "none alone makes a mission succeed" in reported[-1]


@pytest.mark.parametrize(("asked", "message"), [
    ({"ask": ["agent", "operator"]}, "at most 20 s, 10 s of these for the model, 10 s for the operator; an attempt"),
    ({"ask": ["agent"]}, "at most 20 s"),
    ({"ask": ["agent", "operator"], "within_s": 4}, "at most 20 s, 4 s at most for an attempt"),
])  # fmt: skip
def test_how_the_time_of_a_decision_is_split_is_reported(asked: dict[str, Any], message: str) -> None:
    given = document()
    given["states"]["assessing"]["decision"] |= {"deadline_s": 20, **asked}
    texts = [
        item["text"]
        for each in review_data(Mission.model_validate(given))["lenses"][0]["sections"]
        for item in each["items"]
    ]
    assert any(message in text for text in texts if text.startswith("bounded"))


def test_a_question_has_its_evidence_its_picture_its_answers_and_the_verdicts() -> None:
    steps = answered(tractor())
    with TemporaryDirectory() as folder:
        data = data_of(review(tractor(), [journal_of(Path(folder) / "a.journal", tractor(), steps)]))
    first, second, *_ = data["runs"][0]["questions"]
    shown = {each["key"]: each for each in first["evidence"]}
    assert data["images"][shown["camera"]["picture"]]["uri"].startswith("data:image/png;base64,")
    assert shown["obstacle"]["value"]["height_m"] == 0.5
    assert [offer["name"] for offer in first["options"]] == ["replan", "signal", "abort"]
    assert first["proposal"]["option"] == "drive_over"
    assert first["withheld"] == {"drive_over": "false"}
    assert "'drive_over' was not offered" in first["verdict"][0]
    assert "'drive_over' was not offered" in second["refused"][0]


def test_an_option_whose_guard_was_unknown_reports_it() -> None:
    chart = Chart(tractor(), ticker=CompiledTrees())
    chart.write("battery", 0.8, at=0.0)
    steps = [chart.start(at=0.0), chart.send(Event("anomaly", 3.0))]
    steps.append(chart.send(Event("agent", 3.0, {"by": "mission"}, "control")))
    [question] = review_data(tractor(), [run_of_steps(steps)])["runs"][0]["questions"]
    assert question["withheld"] == {"drive_over": "unknown"}
