# SPDX-License-Identifier: Apache-2.0
"""Words of arranging are in the goal, or the request is asked back: to lie on the desk is no stack and no row."""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any

import pytest

from rai_missions.planning import feasible
from rai_missions.planning.reading import is_said, read_request, reading_of
from tests.planning.reading.stored import goal
from tests.planning.scenes import scene, thing

SEEN = scene(
    thing("tray", 0.6, 0.3),
    thing("bin", 0.6, -0.3),
    thing("red_cube", 0.4, 0.1, colour="red"),
    thing("blue_cube", 0.4, 0.2, colour="blue"),
    thing("green_cube", 0.4, -0.1, colour="green"),
    thing("carrot", 0.4, 0.0),
    thing("tomato", 0.58, 0.3, level=0.004),
    thing("apple", 0.64, 0.3, level=0.004),
)
CUBES = ("red_cube", "blue_cube", "green_cube")
ARRANGED = {
    "en": (
        ("stack", "pile up", "build a tower of", "heap up", "group", "gather", "sort", "line up", "arrange", "tidy"),
        "the cubes", ("on the desk", "on the tray", "in the tray", "on the table"),
    ),
    "de": (("stapel", "sammle", "sortiere", "ordne"), "die Würfel", ("auf dem Tisch", "auf dem Tablett", "im Eimer")),
}  # fmt: skip


@pytest.mark.parametrize("code", ARRANGED)
def test_no_word_of_arranging_is_lost_before_a_place(code: str) -> None:
    verbs, things, places = ARRANGED[code]
    for verb, place in product(verbs, places):
        request = f"{verb} {things} {place}"
        found = reading_of(request, SEEN).goal
        words = {each.word for each in found.all} if found is not None else {"asked"}
        lies_there = [{"on": [name, "desk"]} for name in CUBES]
        assert found is None or (found != goal(*lies_there) and is_said(found, request, SEEN)), request
        if verb in ("stack", "pile up", "build a tower of", "heap up", "stapel"):
            assert found is not None and sum("on" in each.written() for each in found.all) >= 2, request
        if verb in ("line up", "arrange", "tidy", "ordne"):
            assert words <= {"in", "left_of", "asked"}, request


@pytest.mark.parametrize("joint", [", then", ", and then", ", and", "."])
def test_a_wish_after_a_tower_from_below_is_a_wish_of_its_own(joint: str) -> None:
    found = reading_of(f"from bottom to top: red, blue, green{joint} put the carrot in the bin", SEEN)
    tower = [{"on": [above, below]} for below, above in pairwise(["desk", *CUBES])]
    assert found.goal == goal(*tower, {"in": ["carrot", "bin"]})


@pytest.mark.parametrize(
    ("request_", "base", "names"),
    [
        ("stack the cubes on the desk", {"on": ["red_cube", "desk"]}, CUBES),
        ("stack the cubes on the tray", {"in": ["red_cube", "tray"]}, CUBES),
        ("stack the cubes in the tray", {"in": ["red_cube", "tray"]}, CUBES),
        ("put the cubes on top of each other in the tray", {"in": ["red_cube", "tray"]}, CUBES),
        ("stack red and green on blue", {"on": ["red_cube", "blue_cube"]}, ("red_cube", "green_cube")),
        ("stack the cubes on the red cube", {"on": ["blue_cube", "red_cube"]}, ("blue_cube", "green_cube")),
        ("stack the cubes on the tray with green at the bottom", {"in": ["green_cube", "tray"]},
         ("green_cube", "red_cube", "blue_cube")),
        ("stapel alle Würfel auf dem Tisch", {"on": ["red_cube", "desk"]}, CUBES),
    ],
)  # fmt: skip
def test_a_tower_stands_where_it_is_asked_for(request_: str, base: Any, names: tuple[str, ...]) -> None:
    above = [{"on": [upper, lower]} for lower, upper in pairwise(names)]
    found = reading_of(request_, SEEN).goal
    assert found == goal(base, *above) and is_said(found, request_, SEEN)
    assert feasible(found, SEEN) is None


@pytest.mark.parametrize(
    "request_", ["stack the cubes on the red cube with the red cube at the bottom", "stack the cubes on the red cube"]
)
def test_a_tower_on_the_only_thing_that_could_be_in_it_is_asked_back(request_: str) -> None:
    found = reading_of(request_, scene(thing("red_cube", 0.4, 0.1, colour="red"), thing("tray", 0.6, 0.3)))
    assert found.question.startswith("That takes two things or more, and I see only 'red cube' of them.")


def test_things_in_a_container_are_stacked_there() -> None:
    found = reading_of("put the cubes in the tray and stack them", SEEN).goal
    above = {"on": ["blue_cube", "red_cube"]}, {"on": ["green_cube", "blue_cube"]}
    assert found == goal({"in": ["red_cube", "tray"]}, *above)
    assert feasible(found, SEEN) is None


@pytest.mark.parametrize(
    ("request_", "predicates"),
    [
        ("take the apple off the tray and put it in the bin", [{"in": ["apple", "bin"]}]),
        ("take the apple out of the tray and put it into the bin", [{"in": ["apple", "bin"]}]),
        ("move the apple from the tray to the bin", [{"in": ["apple", "bin"]}]),
        ("move the apple from the tray to x 0.4, y 0.3", [{"at": "apple", "x": 0.4, "y": 0.3}]),
        ("remove the apple from the tray and place it next to the carrot",
         [{"on": ["apple", "desk"]}, {"next_to": ["apple", "carrot"]}]),
        ("take everything off the tray and put it in the bin", [{"in": ["tomato", "bin"]}, {"in": ["apple", "bin"]}]),
        ("move everything from the tray to the bin", [{"in": ["tomato", "bin"]}, {"in": ["apple", "bin"]}]),
        ("nimm den Apfel vom Tablett und leg ihn in den Eimer", [{"in": ["apple", "bin"]}]),
        ("nimm den Apfel vom Tablett", [{"on": ["apple", "desk"]}]),
    ],
)  # fmt: skip
def test_what_is_taken_from_somewhere_is_wanted_where_it_is_then_put(request_: str, predicates: list[Any]) -> None:
    found = reading_of(request_, SEEN).goal
    assert found == goal(*predicates) and is_said(found, request_, SEEN)
    assert feasible(found, SEEN) is None


@pytest.mark.parametrize("request_", ["separate the fruit and the vegetables", "trenne Obst und Gemüse"])
def test_groups_are_separated_and_what_is_in_one_group_is_not(request_: str) -> None:
    assert reading_of(request_, SEEN).goal == goal({"apart": ["apple", "carrot"]}, {"apart": ["apple", "tomato"]})


def test_a_swap_that_is_undone_is_asked_back() -> None:
    assert reading_of("swap red and blue, then swap them back", SEEN).reason == "order"


@pytest.mark.parametrize(
    ("request_", "text"),
    [("empty the bin", "I see nothing in or on 'bin'."), ("leere den Eimer", "In oder auf 'bin' sehe ich nichts.")],
)
def test_an_empty_container_is_named(request_: str, text: str) -> None:
    assert read_request(request_, SEEN)["about"] == text


STACKED = scene(
    thing("tray", 0.6, 0.3),
    thing("bin", 0.6, -0.3),
    thing("blue_cube", 0.4, 0.2, colour="blue"),
    thing("red_cube", 0.4, 0.2, colour="red", level=0.044),
    thing("green_cube", 0.4, -0.1, colour="green"),
    thing("carrot", 0.4, 0.0),
    thing("tomato", 0.58, 0.3, level=0.004),
    thing("apple", 0.64, 0.3, level=0.004),
)
ON_DESK = ({"on": ["tomato", "desk"]}, {"on": ["apple", "desk"]})


@pytest.mark.parametrize(
    ("request_", "wanted"),
    [
        ("take the cubes off each other", [{"on": ["red_cube", "desk"]}]),
        ("unstack the cubes", [{"on": ["red_cube", "desk"]}]),
        ("dismantle the tower", [{"on": ["red_cube", "desk"]}]),
        ("nimm die Würfel voneinander herunter", [{"on": ["red_cube", "desk"]}]),
        ("empty the tray and put the carrot in it", [*ON_DESK, {"in": ["carrot", "tray"]}]),
        ("empty the tray into the bin", [{"in": ["tomato", "bin"]}, {"in": ["apple", "bin"]}]),
        ("räum das Tablett leer", ON_DESK),
        ("räum das Tablett ab", ON_DESK),
        ("clear the tray", ON_DESK),
        ("empty the tray and the bin", ON_DESK),
        ("the apple out of the tray, the carrot into it", [ON_DESK[1], {"in": ["carrot", "tray"]}]),
        ("empty the bin and put the carrot in it", [{"in": ["carrot", "bin"]}]),
    ],
)
def test_what_lies_on_another_thing_comes_off_and_what_is_emptied_takes_new_things(request_: str, wanted: Any) -> None:
    found = reading_of(request_, STACKED).goal
    assert found is not None and found.meaning == goal(*wanted).meaning and is_said(found, request_, STACKED)


def test_what_is_empty_is_refused_where_nothing_else_is_wanted() -> None:
    assert [reading_of(each, SEEN).reason for each in ("empty the bin into the tray", "unstack the cubes")] == [
        "absent",
        "absent",
    ]


def test_several_towers_are_offered_as_towers_of_as_many_things() -> None:
    asked = reading_of("build two towers", SEEN), reading_of("build two towers of red, blue, green and carrot", SEEN)
    assert [each.reason for each in asked] == ["order", "ambiguous"]
    wanted = [{"on": ["red_cube", "desk"]}, {"on": ["blue_cube", "red_cube"]}]
    more = [{"on": ["green_cube", "desk"]}, {"on": ["carrot", "green_cube"]}]
    assert [each.meaning for each in asked[1].candidates] == [goal(*wanted, *more).meaning]


def test_what_is_seen_is_offered_where_another_wish_is_about_what_is_not() -> None:
    asked = reading_of("put the purple cube on the red one and the carrot in the bin", SEEN)
    assert asked.reason == "absent" and asked.candidates == (goal({"in": ["carrot", "bin"]}),)
    assert asked.question.startswith("I do not see 'the purple cube'") and "Did you mean: the carrot" in asked.question
    assert reading_of("put the purple cube in the tray and the carrot on it", SEEN).question == ""
