# SPDX-License-Identifier: Apache-2.0
"""Laws of the picture: it is the mission, all of it, and the path is the run."""

from __future__ import annotations

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from tests.strategies import EVENTS, missions
from tests.visualize.runs import run, tractor, tractor_path
from visualize.build import picture


def transitions(mission: Mission) -> Counter[tuple[str, str, str]]:
    """(pointer, source, target) of each transition and target, read from the written mission alone."""
    found: Counter[tuple[str, str, str]] = Counter()

    def add(place: str, source: str, state: dict[str, object]) -> None:
        for index, transition in enumerate(state.get("transitions", [])):  # type: ignore[var-annotated, arg-type]
            to = transition.get("to", "")
            for target in to if isinstance(to, list) else [to]:
                found[f"{place}/transitions/{index}", source, target] += 1
        for word in ("states", "parallel"):
            inner = state.get(word)
            for name, child in inner.items() if isinstance(inner, dict) else ():
                add(f"{place}/{word}/{name}", name, child)

    add("", "", mission.written())
    return found


@given(missions())
def test_the_edges_are_exactly_the_rows_once_for_each_target(mission: Mission) -> None:
    drawn = Counter((edge.place, edge.source, edge.target) for edge in picture(mission).edges)
    assert drawn == transitions(mission)


@given(missions())
def test_the_nodes_are_exactly_the_states_where_they_are(mission: Mission) -> None:
    drawn = picture(mission)
    assert [(node.place, node.name) for node in drawn.nodes] == [(place, name) for place, name, _ in mission.walk()]
    for node in drawn.nodes:
        assert node.place.split("/")[-1] == node.name
        assert (node.parent or "states") in node.place.split("/")


@given(missions(), st.lists(st.sampled_from(EVENTS), max_size=5))
def test_the_path_is_what_the_steps_moved_through(mission: Mission, events: list[str]) -> None:
    steps = run(mission, events)
    drawn = picture(mission, steps)
    taken = Counter(place for step in steps for move in step.moves for place in move.taken)
    entered = Counter(name for step in steps for name in step.entered)
    assert {edge.place: edge.taken.times for edge in drawn.edges if edge.taken.times} == taken
    assert {node.name: node.entered.times for node in drawn.nodes if node.entered.times} == entered
    assert all(list(edge.taken.steps) == sorted(edge.taken.steps) for edge in drawn.edges)


@given(missions())
def test_a_picture_is_a_value_in_which_nothing_is_taken_without_steps(mission: Mission) -> None:
    drawn = picture(mission)
    assert drawn == picture(mission)
    assert hash(drawn) == hash(picture(mission))
    assert not any(each.taken.times for each in (*drawn.edges, *drawn.initials))
    assert not any(node.entered.times or node.ended_here for node in drawn.nodes)


def test_a_decision_shows_its_options_in_words() -> None:
    assessing = picture(tractor()).by_name["assessing"]
    assert [(choice.name, choice.guard, choice.fallback) for choice in assessing.choices] == [
        ("drive_over", "obstacle.living is false and obstacle.height_m < 0.25", False),
        ("replan", "", False),
        ("signal", "signals < 3", False),
        ("abort", "", True),
    ]
    assert "at most 20 s" in assessing.lines
    assert assessing.choices[0].place == "/states/assessing/decision/options/drive_over"


def test_a_tree_hangs_in_its_state() -> None:
    twigs = picture(tractor()).by_name["signalling"].twigs
    assert [(twig.path, twig.parent, twig.text) for twig in twigs] == [
        ("", None, "sequence"),
        ("sequence/0", "", "call horn; at most 2 s"),
        ("sequence/1", "", "wait 5 s"),
    ]


def test_the_path_reports_how_often_and_when() -> None:
    drawn = picture(tractor(), tractor_path())
    anomaly = next(edge for edge in drawn.edges if edge.trigger == "anomaly")
    assert anomaly.taken.words() == "2× in steps 2, 5"
    assert drawn.by_name["driving"].entered.steps == (1, 4)
    assert drawn.by_name["aborted"].ended_here
    assert (drawn.outcome, drawn.why, drawn.steps) == ("aborted", "'aborted' was reached", 6)


def test_a_state_reached_through_its_history_did_not_begin_there() -> None:
    begins = {initial.parent: initial.taken.steps for initial in picture(tractor(), tractor_path()).initials}
    assert begins == {"": (1,), "working": (1,)}
