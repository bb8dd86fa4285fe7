# SPDX-License-Identifier: Apache-2.0
"""Half sentences: values, and words without a meaning of their own, which make another order of the last one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from rai_missions.conversation import Dialogue, Order, Output, Utterance
from tests.conversation.judged import ordered
from tests.conversation.test_robots import MODES, robot


def after(name: str, *texts: str) -> tuple[Output, ...]:
    """What the last of some sentences leads to, with a robot that is ready."""
    settings, view = robot(name)
    view = view._replace(mode="ready", awaits_start=True)
    dialogue, found = Dialogue(settings, view), tuple[Output, ...]()
    for at, text in enumerate(texts, start=1):
        found = dialogue.on_utterance(Utterance(text, "operator", "terminal", "Eve", 5.0 * at), view)
        if any(isinstance(each, Order) for each in found):
            modes = [MODES[each.name] for each in found if isinstance(each, Order) and each.name in MODES]
            view = view._replace(mode=modes[-1] if modes else "running", awaits_start=False)
            dialogue.on_status(view, 5.0 * at + 0.5)
    return found


def arguments(found: tuple[Output, ...]) -> Mapping[str, Any]:
    (order,) = ordered(found)
    return order["arguments"]  # type: ignore[no-any-return]


@pytest.mark.parametrize("half", [
    "the lobby", "no, the lobby", "not the yard, the lobby", "lobby instead", "the lobby, not the yard",
    "rather the lobby", "sorry, the lobby I meant", "make it the lobby", "actually the lobby, please",
    "wait, the other one, the lobby", "yes, but the lobby",
])  # fmt: skip
def test_a_half_sentence_replaces_the_value_of_its_argument(half: str) -> None:
    found = after("night_guard", "patrol the yard three times", half)
    assert arguments(found) == {"task": "patrol", "zone": "lobby", "laps": 3}


@pytest.mark.parametrize("half", [
    "now the lobby", "and the lobby", "the lobby too", "the lobby as well", "same again for the lobby",
    "then the lobby, please", "do the same for the lobby afterwards", "and also the lobby",
])  # fmt: skip
def test_a_half_sentence_behind_an_order_that_counts_is_the_order_with_another_value(half: str) -> None:
    found = after("night_guard", "patrol the yard three times", "yes", half)
    assert arguments(found) == {"task": "patrol", "zone": "lobby", "laps": 3}


@pytest.mark.parametrize(("name", "order", "half", "expected"), [
    ("fruit_sorter", "set the belt to 80 percent", "slower, 50", {"speed_percent": 50}),
    ("window_cleaner", "fill 25 litres", "hmm, better 35", {"litres": 35}),
    ("aquarium_guide", "feed the sharks", "with two kilos", {"tank": "sharks", "grams": 2000}),
    ("medikamentenwagen", "öffne Fach drei", "ach, lieber das vierte", {"drawer": 4}),
    ("poolroboter", "gib 100 Gramm Chlor ins Kinderbecken", "mach 150 draus", {"pool": "kids", "grams": 150}),
    ("night_guard", "watch the yard", "for twenty minutes", {"zone": "yard", "watch_min": 20}),
    ("pool_cleaner", "heat the big pool to 28 degrees", "no, the hot tub, to 37", {"pool": "hot tub", "degrees": 37}),
    ("shelf_robot", "fetch the score", "no, the atlas, to the front desk", {"book": "atlas", "desk": "front"}),
    ("barista", "Mach einen Tee", "für Jonas, aber groß", {"drink": "tea", "guest": "Jonas", "size": "large"}),
    ("solar_washer", "Wasch Reihe eins", "nein, Reihe zwei mit 70 Litern", {"row": "row_2", "litres": 70}),
    ("solar_washer", "Prüf Reihe eins", "nicht Reihe eins, Reihe zwei", {"row": "row_2"}),
])  # fmt: skip
def test_a_half_sentence_gives_each_argument_that_the_phrases_of_the_order_have(
    name: str, order: str, half: str, expected: Mapping[str, Any]
) -> None:
    assert {**arguments(after(name, order, half)), "task": ""} == {**expected, "task": ""}


@pytest.mark.parametrize("other", [
    "the lobby smells of paint", "is the lobby nice", "Anna likes the lobby", "the yard and the lobby are mine",
    "the lobby was dark, not the yard",
])  # fmt: skip
def test_a_sentence_with_a_word_of_its_own_is_no_half_sentence(other: str) -> None:
    found = ordered(after("night_guard", "patrol the yard three times", "yes", other))
    assert all(each["arguments"].get("laps") != 3 for each in found)


def test_what_is_but_refused_is_no_value() -> None:
    assert ordered(after("night_guard", "patrol the yard", "yes", "not the lobby")) == []


@pytest.mark.parametrize("half", ["no, stop, the lobby", "the lobby, stop", "stop! the lobby too"])
def test_a_half_sentence_with_a_stop_stops(half: str) -> None:
    given = [each for each in after("night_guard", "patrol the yard", "yes", half) if isinstance(each, Order)]
    assert [each.name for each in given] == ["stop"]


@pytest.mark.parametrize(("text", "expected"), [
    ("vacuum the hot tub", {"task": "vacuum", "pool": "hot tub"}),
    ("clean the hot tub", {"task": "clean", "pool": "hot tub"}),
    ("hoover the hot tub", {"task": "clean", "pool": "hot tub"}),
])  # fmt: skip
def test_of_two_phrases_whose_verbs_have_one_sense_that_counts_which_has_the_verb(
    text: str, expected: Mapping[str, Any]
) -> None:
    assert arguments(after("pool_cleaner", text)) == expected


def test_a_phrase_with_a_value_for_each_word_comes_before_a_longer_one_that_lacks_one() -> None:
    assert arguments(after("barista", "Mach einen Tee")) == {"task": "brew", "drink": "tea"}
