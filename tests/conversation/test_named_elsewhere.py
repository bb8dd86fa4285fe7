# SPDX-License-Identifier: Apache-2.0
"""A place in a clause about a thing is where it is looked for, and a place alone in a list takes the verb ahead."""

from __future__ import annotations

from itertools import permutations, product

import pytest

from rai_missions.conversation import Dialogue, TalkNote, Utterance
from rai_missions.conversation.language.language import languages
from tests.conversation.stored import ASSISTING, read_back, settings_in

PHRASES = {
    "en": {
        "find {object}": {"task": "find", "place": "house"}, "find {object} in {place}": {"task": "find"},
        "look (in|into) {place}": {"task": "look"}, "go to {place}": {"task": "go"},
        "[in|into|to] {place}": {"task": "go"},
        "wait around": {"task": "wait"},
    },
    "de": {
        "finde {object}": {"task": "find", "place": "house"}, "finde {object} (in|im) {place}": {"task": "find"},
        "schau (in|ins) {place}": {"task": "look"}, "fahre (in|ins) {place}": {"task": "go"},
        "[in|ins] {place}": {"task": "go"}, "warte herum": {"task": "wait"},
    },
}  # fmt: skip
PLACES = {
    "en": {"kitchen": "kitchen", "study": "study", "living room": "living"},
    "de": {"küche": "kitchen", "büro": "study"},
}
FIND = {"en": ("find the cup", "please find my cup"), "de": ("finde die Tasse", "finde bitte meine Tasse")}
THING = {"en": "cup", "de": "tasse"}
ABOUT = {
    "en": ("it's in the {}", "it must be in the {} somewhere", "I think it is in the {}", "the kids have it in the {}"),
    "de": ("sie ist in der {}", "die muss in der {} sein", "ich glaube, sie liegt in der {}"),
}
ELSEWHERE = {
    "en": (
        "I am in the {}", "it is not in the {}", "it is in the {} or outside", "the cat is in the {}",
        "it was never in the {}",
    ),
    "de": ("ich bin in der {}", "sie ist nicht in der {}", "sie ist in der {} oder draußen", "Oma ist in der {}"),
}  # fmt: skip
LOOKS = {"en": ("look in the {}", ", then the {}"), "de": ("schau in die {}", ", dann in die {}")}
GOES = {"en": ("go to the {}", ", then the {}"), "de": ("fahr in die {}", ", dann in die {}")}
WAITS = {"en": ("wait around", ", then the {}"), "de": ("warte herum", ", dann in die {}")}


def found(text: str, code: str) -> list[dict[str, str]]:
    """The arguments of each start that is read back, of a list as well."""
    dialogue = Dialogue(settings_in(code, PHRASES[code], PLACES[code]), ASSISTING)
    outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal"), ASSISTING)
    assert None not in read_back(outputs)
    orders = (each.data["order"] for each in outputs if isinstance(each, TalkNote) and each.kind == "read_back")
    return [each.get("arguments", {}) for order in orders for each in (order, *order.get("then", ()))]


@pytest.mark.parametrize("code", languages())
def test_a_place_in_a_clause_about_the_thing_is_where_it_is_looked_for(code: str) -> None:
    for order, about, (name, place) in product(FIND[code], ABOUT[code], PLACES[code].items()):
        for joint in (", ", ". "):
            text = order + joint + about.format(name)
            assert found(text, code) == [{"task": "find", "object": THING[code], "place": place}], text


@pytest.mark.parametrize("code", languages())
def test_a_place_of_something_else_or_one_that_is_denied_is_not_taken(code: str) -> None:
    for order, other, name in product(FIND[code], ELSEWHERE[code], PLACES[code]):
        text = f"{order}, {other.format(name)}"
        assert all(each["place"] == "house" for each in found(text, code)), text


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize(("forms", "task"), [(LOOKS, "look"), (GOES, "go")])
def test_a_place_alone_in_a_list_takes_the_verb_ahead_of_it(
    forms: dict[str, tuple[str, str]], task: str, code: str
) -> None:
    first, later = forms[code]
    for names in permutations(PLACES[code]):
        text = first.format(names[0]) + "".join(later.format(each) for each in names[1:])
        assert found(text, code) == [{"task": task, "place": PLACES[code][each]} for each in names], text


@pytest.mark.parametrize("code", languages())
def test_a_place_alone_behind_what_has_no_place_is_gone_to(code: str) -> None:
    first, later = WAITS[code]
    for name, place in PLACES[code].items():
        assert found(first + later.format(name), code) == [{"task": "wait"}, {"task": "go", "place": place}]
