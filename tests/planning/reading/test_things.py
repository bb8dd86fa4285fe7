# SPDX-License-Identifier: Apache-2.0
"""What phrases mean where the camera does not name the colour of a thing, and where words leave a number open."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.planning.reading import is_said, read_request, reading_of
from tests.planning.reading.stored import SCENES, goal
from tests.planning.scenes import scene
from tests.planning.scenes import thing as placed

SEEN = SCENES["uncoloured"]
CUBES = ("red_cube", "blue_cube", "green_cube")


@pytest.mark.parametrize(
    ("request_", "predicate"),
    [
        ("red on blue", {"on": ["red_cube", "blue_cube"]}),
        ("swap red and green", {"swapped": ["red_cube", "green_cube"]}),
        ("put the red apple in the bin", {"in": ["apple", "bin"]}),
        ("the orange one in the tray", {"in": ["carrot", "tray"]}),
        ("put the blue cube under the red cube", {"on": ["red_cube", "blue_cube"]}),
        ("apple -> bin", {"in": ["apple", "bin"]}),
        ("load the tray with the corn", {"in": ["corn", "tray"]}),
    ],
)
def test_a_colour_alone_is_that_of_a_cube(request_: str, predicate: Any) -> None:
    assert reading_of(request_, SEEN).goal == goal(predicate)


def test_one_of_a_colour_may_be_a_thing_whose_colour_is_not_seen() -> None:
    found = reading_of("the green ones in the bin", SEEN)
    cube, apple = {"in": ["green_cube", "bin"]}, {"in": ["apple", "bin"]}
    assert found.goal is None and found.candidates == (goal(cube), goal(cube, apple))


def test_a_thing_is_not_taken_for_one_of_a_colour_that_its_kind_never_has() -> None:
    assert reading_of("put the blue apple in the bin", SEEN).outcome == "refused"


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ("put an apple next to an apple", [{"next_to": ["apple", "apple_2"]}]),
        (
            "swap an apple and the other apple",
            [{"at": "apple", "x": 0.6, "y": 0.0}, {"at": "apple_2", "x": 0.6, "y": 0.2}],
        ),
        ("keep one apple and the other apple apart", [{"apart": ["apple", "apple_2"]}]),
    ],
)
def test_two_ways_to_write_one_goal_are_read_as_one(request_: str, words: list[Any]) -> None:
    found = read_request(request_, scene(placed("apple", 0.6, 0.2), placed("apple_2", 0.6, 0.0)))
    assert found["goal"] == {"all": words} and found["candidates"] == []


@pytest.mark.parametrize(
    ("request_", "candidates"),
    [
        ("one apple in the tray, the other in the bin", [("apple", "tray", "apple_2", "bin")]),
        ("put a tomato in the bin, and the other one in the tray", [("tomato", "bin", "tomato_2", "tray")]),
        ("put an apple in the tray and an apple in the bin", [("apple", "tray", "apple_2", "bin")]),
        ("einen Apfel aufs Tablett, den anderen in den Eimer", [("apple", "tray", "apple_2", "bin")]),
    ],
)
def test_the_other_one_is_no_thing_that_was_chosen_before(request_: str, candidates: list[Any]) -> None:
    wanted = {
        goal({"in": [one, place]}, {"in": [two, elsewhere]})
        for first, place, second, elsewhere in candidates
        for one, two in ((first, second), (second, first))
    }
    assert set(reading_of(request_, SCENES["market"]).candidates) == wanted


@pytest.mark.parametrize(
    ("request_", "chosen", "others"),
    [
        ("put an apple in the tray, everything else in the bin", ("apple", "apple_2"), 5),
        ("ein Apfel aufs Tablett, den Rest in den Eimer", ("apple", "apple_2"), 5),
        ("put the apple or the corn in the tray, and the other one in the bin", None, 1),
    ],
)
def test_the_rest_is_what_was_not_chosen_before(request_: str, chosen: Any, others: int) -> None:
    for each in reading_of(request_, SCENES["market"]).candidates:
        (in_tray,) = [name for name, place in (one.in_ for one in each.all) if place == "tray"]
        in_bin = {name for name, place in (one.in_ for one in each.all) if place == "bin"}
        assert in_tray not in in_bin and len(in_bin) == others
        assert chosen is None or in_tray in chosen


def test_the_other_one_after_a_container_may_be_a_container() -> None:
    request = "put the carrot in the tray and the apple in the other one"
    found = reading_of(request, SCENES["full"]).goal
    assert found == goal({"in": ["carrot", "tray"]}, {"in": ["apple", "bin"]})
    assert is_said(found, request, SCENES["full"])


def test_of_two_things_to_choose_from_either_may_be_the_other_one() -> None:
    found = reading_of("put the apple or the carrot in the tray and the other in the bin", SCENES["full"])
    assert found.candidates == tuple(
        goal({"in": [one, "tray"]}, {"in": [other, "bin"]}) for one, other in (("apple", "carrot"), ("carrot", "apple"))
    )


@pytest.mark.parametrize("request_", ["make two towers", "build towers of the cubes", "stack the cubes in two towers"])
def test_of_several_towers_it_is_asked_what_each_is_made_of(request_: str) -> None:
    assert reading_of(request_, SEEN).outcome == "unclear"


def test_a_bottom_a_middle_and_a_top_are_a_whole_tower() -> None:
    found = reading_of("a tower with red at the bottom, yellow in the middle and green on top", SEEN).goal
    wanted = {"on": ["red_cube", "desk"]}, {"on": ["yellow_cube", "red_cube"]}, {"on": ["green_cube", "yellow_cube"]}
    assert found == goal(*wanted)


@pytest.mark.parametrize("request_", ["get rid of the corn", "throw the corn out", "dispose of the corn"])
def test_what_is_thrown_away_is_asked_back_as_into_the_bin(request_: str) -> None:
    assert reading_of(request_, SEEN).candidates == (goal({"in": ["corn", "bin"]}),)


@pytest.mark.parametrize(
    "request_",
    [
        "take the red cube under the blue cube and put it in the tray", "grab the red cube under the blue cube",
        "take the red cube on the blue cube and put it in the tray", "take the apple right from the tray",
        "pick up the red cube near the tray", "take the apple next to the tray and put it in the bin",
        "move the red cube 30 cm forward and 10 cm left", "push the apple 30 cm ahead and 10 cm to the right",
        "slide the tray under the apple", "put all red in the bin",
    ],
)  # fmt: skip
def test_what_may_as_well_mean_where_something_is_now_is_asked_back(request_: str) -> None:
    found = reading_of(request_, SEEN)
    assert found.outcome == "unclear"


@pytest.mark.parametrize(
    ("request_", "predicates"),
    [
        ("take the red cube off the blue cube and put it in the tray", [{"in": ["red_cube", "tray"]}]),
        ("get the apple in the bin and the carrot next to the corn",
         [{"in": ["apple", "bin"]}, {"next_to": ["carrot", "corn"]}]),
        ("move the red cube to 30 cm ahead and 10 cm left", [{"at": "red_cube", "x": 0.3, "y": 0.1}]),
        ("take the red cube and move it left of the blue cube", [{"left_of": ["red_cube", "blue_cube"]}]),
    ],
)  # fmt: skip
def test_a_wish_after_a_verb_of_grasping_is_read(request_: str, predicates: list[Any]) -> None:
    assert reading_of(request_, SEEN).goal == goal(*predicates)


@pytest.mark.parametrize(
    "request_",
    [
        "stack the cubes, red first", "stack all the cubes, the leftmost first", "stack red, blue and red",
        "two towers: the cubes and red", "line up the cubes, red first", "put the cubes and the red cube in a row",
        "stapel die Würfel, rot zuerst", "stapel die Würfel, den roten zuerst",
    ],
)  # fmt: skip
def test_a_thing_that_a_tower_or_a_row_has_twice_is_about_its_order(request_: str) -> None:
    found = reading_of(request_, SEEN)
    assert (found.outcome, found.reason, found.goal) == ("unclear", "order", None)


@pytest.mark.parametrize(
    "request_",
    [
        "stack red, then blue, then green", "stack red then blue then green", "a tower: red, then blue and then green",
        "stack the red cube first, then the blue one, then the green one", "stapel rot, dann blau, dann grün",
        "staple zuerst den roten, dann den blauen, dann den grünen Würfel",
    ],
)  # fmt: skip
def test_a_tower_whose_things_are_named_in_turn_is_read_from_below(request_: str) -> None:
    found = reading_of(request_, SEEN).goal
    assert found == goal(
        {"on": ["red_cube", "desk"]}, {"on": ["blue_cube", "red_cube"]}, {"on": ["green_cube", "blue_cube"]}
    )


@pytest.mark.parametrize(
    ("tower", "more", "predicates"),
    [
        ("stack red and blue", "then put the apple in the tray", [{"in": ["apple", "tray"]}]),
        ("stack red and blue", "then the apple in the tray", [{"in": ["apple", "tray"]}]),
        ("stack red, then blue", "then swap the green and the yellow cube", None),
    ],
)
def test_what_is_wished_after_a_tower_is_no_part_of_it(tower: str, more: str, predicates: list[Any] | None) -> None:
    found = reading_of(f"{tower}, {more}", SEEN).goal
    assert found is not None
    below = goal({"on": ["red_cube", "desk"]}, {"on": ["blue_cube", "red_cube"]}).all
    assert found.all[:2] == below
    assert predicates is None or found.all[2:] == goal(*predicates).all


MOVES = {
    "en": (
        "put {0} on the yellow cube",
        "put {0} in the tray",
        "put {0} at x 0.5, y 0.1",
        "swap {0} and the yellow cube",
    ),
    "de": ("leg {0} auf den gelben Würfel", "leg {0} in die Schale", "tausche {0} und den gelben Würfel"),
}
SWAPS = {
    "en": ("swap {0} and {1}", "the red cube", "the green cube", " and "),
    "de": ("tausche {0} und {1}", "den roten Würfel", "den grünen Würfel", " und "),
}


@pytest.mark.parametrize(("code", "move"), [(code, move) for code, moves in MOVES.items() for move in moves])
def test_a_thing_that_is_swapped_and_moved_otherwise_is_asked_back(code: str, move: str) -> None:
    """Where it comes to depends on which of both is first, in whatever order they are written."""
    swap, red, green, then = SWAPS[code]
    for thing in (red, green):
        wishes = [move.format(thing), swap.format(red, green)]
        for each in (wishes, wishes[::-1]):
            found = reading_of(then.join(each), SEEN)
            assert (found.outcome, found.reason, found.goal) == ("unclear", "order", None), each
    alone = reading_of(
        then.join([move.format("the blue cube" if code == "en" else "den blauen Würfel"), swap.format(red, green)]),
        SEEN,
    )
    assert alone.goal is not None and len(alone.goal.all) == 2


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        ("group the carrots", "That takes two things or more, and I see only 'carrot' of them."),
        ("stack the red cube", "That takes two things or more, and I see only 'red cube' of them."),
        ("gruppiere die Karotten", "Dazu gehören mindestens zwei Dinge, und davon sehe ich nur 'carrot'."),
        ("swap the cubes", "That takes two things, and there are 'red cube', 'blue cube' and 'green cube'."),
    ],
)
def test_a_wish_about_too_few_or_too_many_things_is_asked_back_with_the_reason(request_: str, reason: str) -> None:
    three = scene(*(placed(name, 0.4 + n / 10, 0.1) for n, name in enumerate(("carrot", *CUBES))))
    found = reading_of(request_, three)
    assert found.goal is None and found.question.startswith(reason)


@pytest.mark.parametrize(
    ("bare", "written"),
    [
        ("from left to right red blue green", "from left to right: red, blue, green"),
        ("line up the cubes from left to right red blue green yellow", "from left to right: red, blue, green, yellow"),
        ("stack red blue green", "stack red, blue, green"), ("swap red green", "swap red and green"),
        ("put the red the blue and the green cube in the tray", "put the red, the blue and the green cube in the tray"),
        ("put the apple in the tray the carrot in the bin", "put the apple in the tray, the carrot in the bin"),
        ("put the apple in the tray put the carrot in the bin", "the apple in the tray. put the carrot in the bin"),
        ("leg den Apfel in die Schale die Tomate in den Eimer", "leg den Apfel in die Schale, die Tomate in den Eimer"),
    ],
)  # fmt: skip
def test_a_list_is_read_without_its_commas(bare: str, written: str) -> None:
    assert reading_of(bare, SEEN).goal == reading_of(written, SEEN).goal is not None


@pytest.mark.parametrize(
    "request_",
    [
        "put the cube the apple is on in the tray", "put the cube the apple lies on on the red cube", "apple tray",
        "put the red cube the blue cube is on in the tray", "put the carrot in the tray the apple", "red green blue",
        "the apple in the tray put in the bin", "put the red apple cube in the tray", "move the apple the tray",
    ],
)  # fmt: skip
def test_things_that_follow_each_other_are_no_list_where_words_are_left(request_: str) -> None:
    assert reading_of(request_, SEEN).goal is None


FILLED = scene(
    placed("tray", 0.6, 0.3),
    placed("bin", 0.6, -0.3),
    placed("red_cube", 0.4, 0.1, colour="red"),
    placed("yellow_cube", 0.4, 0.1, level=0.044, colour="yellow"),
    placed("blue_cube", 0.6, 0.3, level=0.004, colour="blue"),
    placed("tomato", 0.62, 0.3, level=0.004),
    placed("green_cube", 0.4, -0.1, colour="green"),
    placed("carrot", 0.4, 0.0),
    placed("apple", 0.58, -0.3, level=0.004),
    placed("apple_2", 0.4, -0.3),
)


@pytest.mark.parametrize(
    ("request_", "names"),
    [
        ("take everything out of the bin", ["apple"]), ("empty the bin", ["apple"]), ("leere die Kiste", ["apple"]),
        ("take everything out of the tray", ["blue_cube", "tomato"]), ("empty the tray", ["blue_cube", "tomato"]),
        ("take the cubes out of the tray", ["blue_cube"]), ("nimm alles aus der Schale", ["blue_cube", "tomato"]),
        ("take everything except the tomato out of the tray", ["blue_cube"]),
        ("take everything off the red cube", ["yellow_cube"]), ("take the apple out of the bin", ["apple"]),
        ("take the carrot out of the tray", ["carrot"]),
    ],
)  # fmt: skip
def test_what_is_taken_out_is_what_lies_there(request_: str, names: list[str]) -> None:
    assert reading_of(request_, FILLED).goal == goal(*({"on": [name, "desk"]} for name in names))


@pytest.mark.parametrize("request_", ["take the vegetables out of the bin", "take all cubes out of the bin"])
def test_nothing_is_taken_out_where_nothing_of_it_lies(request_: str) -> None:
    found = reading_of(request_, FILLED)
    assert (found.outcome, found.reason) == ("refused", "absent") and "in or on 'bin'" in found.about
