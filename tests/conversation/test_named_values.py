# SPDX-License-Identifier: Apache-2.0
"""Values in orders: numbers with any unit of what they measure, names with a number in words, in digits, by place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.conversation import KeyView, MissionView, StatusView
from rai_missions.conversation.grammar.arguments import BadValue, key_value
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from rai_missions.planning.text.numbers import number, numbered

ARGUMENTS = (
    *(KeyView(name, "string", "argument") for name in ("task", "item", "ward", "person", "bed")),
    KeyView("water_l", "number", "argument", minimum=0.1, maximum=10),
)
VIEW = StatusView(missions=(MissionView("help", "", ARGUMENTS),))
PHRASES = {
    "deliver {item} to {ward}": {"task": "deliver"},
    "deliver {item} to {person}": {"task": "hand"},
    "fetch {item} from {ward}": {"task": "fetch"},
    "water {bed} with {water_l}": {"task": "water"},
    "water {bed}": {"task": "water", "water_l": 1},
}
NAMES = {
    "ward": {"lab": "lab", "ward three": "w3", "ward_12": "w12"},
    "person": {"Anna": "anna"},
    "bed": {"bed three": 3, "bed four": 4},
}


def senses(text: str) -> Sequence[Sense]:
    words = language("en")
    return Grammar(words, StartPhrases(PHRASES, NAMES, words)).senses(text, VIEW)


def arguments(text: str) -> Mapping[str, object]:
    """What a sentence starts with; empty where it is no start."""
    return next((sense.arguments for sense in senses(text) if sense.kind == "order"), {})


@pytest.mark.parametrize("code", languages())
def test_a_number_is_read_in_each_unit_of_what_its_key_measures(code: str) -> None:
    words = language(code)
    wrong = []
    for suffix, shown in words.data["units"].items():
        key = KeyView(f"level_{suffix}", "number", "argument")
        spoken_units = {unit: size for unit, size in words.factors(shown).items() if unit.replace(" ", "").isalpha()}
        for unit, size in spoken_units.items():
            if key_value(["4", *unit.lower().split()], key, words) != pytest.approx(4 * size):
                wrong.append((key.name, unit))
    assert wrong == []


@pytest.mark.parametrize(("name", "kind", "text", "value"), [
    ("amount_ml", "integer", "half a litre", 500), ("amount_ml", "integer", "0.25 l", 250),
    ("opening_percent", "integer", "50 percent", 50), ("height_m", "number", "twenty meters", 20),
    ("height_m", "number", "150 centimetres", 1.5), ("hold_minutes", "integer", "five minutes", 5),
    ("hold_minutes", "integer", "an hour", 60), ("laps", "integer", "three laps", 3), ("laps", "integer", "a lap", 1),
])  # fmt: skip
def test_a_number_with_its_unit_is_the_value(name: str, kind: str, text: str, value: float) -> None:
    found = key_value(text.split(), KeyView(name, kind, "argument"), language("en"))
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(("about", "text", "value"), [
    ("how many minutes to wait", "two hours", 120), ("charge in percent", "50 percent", 50), ("a level", "7", 7),
])  # fmt: skip
def test_a_number_whose_name_has_no_unit_has_that_of_its_about(about: str, text: str, value: int) -> None:
    assert key_value(text.split(), KeyView("level", "integer", "argument", about), language("en")) == value


@pytest.mark.parametrize(("name", "text"), [
    ("height_m", "five minutes"), ("opening_percent", "50 litres"), ("laps", "three metres"), ("height_m", "metres"),
])  # fmt: skip
def test_a_number_of_another_unit_is_no_value(name: str, text: str) -> None:
    with pytest.raises(BadValue):
        key_value(text.split(), KeyView(name, "number", "argument"), language("en"))


@pytest.mark.parametrize("code", languages())
@given(value=st.integers(1, 99))
def test_a_name_with_a_number_is_called_in_words_and_in_digits(code: str, value: int) -> None:
    data = language(code).data
    ways = set(numbered(["bay", str(value)], data))
    in_words = {way for way in ways if way[0] == "bay" and not way[-1].isdigit()}
    assert ("bay", str(value)) in ways
    assert in_words
    assert {number([each for each in way[1:] if each != data["number_word"]], data) for way in in_words} == {value}
    assert all(set(numbered(way, data)) == ways for way in ways if way[0] == "bay" and data["number_word"] not in way)


@pytest.mark.parametrize(("text", "ward"), [
    ("ward 3", "w3"), ("ward three", "w3"), ("the third ward", "w3"), ("ward number three", "w3"), ("ward 12", "w12"),
    ("ward twelve", "w12"), ("Ward 3, please", "w3"), ("the 3rd ward", "w3"),
])  # fmt: skip
def test_a_listed_name_is_read_with_its_number_in_each_form(text: str, ward: str) -> None:
    assert arguments(f"take the samples to {text}").get("ward") == ward


@pytest.mark.parametrize("text", ["water bed 5", "water bed 2", "water bed 34", "take it to ward 13"])
def test_another_number_is_no_slip_for_the_listed_one(text: str) -> None:
    assert arguments(text) == {}


def test_of_phrases_with_one_verb_that_counts_whose_values_fit() -> None:
    assert arguments("bring the letter to Anna") == {"task": "hand", "item": "letter", "person": "anna"}
    assert arguments("bring the letter to the lab") == {"task": "deliver", "item": "letter", "ward": "lab"}


def test_a_number_out_of_range_is_asked_for_and_no_other_takes_its_place() -> None:
    (sense,) = senses("water bed four with 20 litres")
    assert (sense.kind, sense.lacks) == ("fault", ("water_l",))


def test_a_listed_value_at_the_end_of_other_words_is_none_behind_another() -> None:
    assert arguments("fetch the samples from the lab and bring them to ward three").get("ward") == "lab"
