# SPDX-License-Identifier: Apache-2.0
"""What a sentence leaves to the ones before it: `it`, `there`, `the same again`; and what a verb has two of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from rai_missions.conversation import Dialogue, KeyView, MissionView, Order, Settings, StatusView, Utterance
from tests.conversation.stored import read_back

ARGUMENTS = (
    *(KeyView(name, "string", "argument") for name in ("task", "object", "place", "person", "tool")),
    KeyView("litres", "number", "argument"),
)
VIEW = StatusView(run="r1", mode="running", mission="help", robot="rob", missions=(MissionView("help", "", ARGUMENTS),))
NAMES = {
    "place": {"kitchen": "kitchen", "office": "office", "bed three": "bed_3"},
    "person": {"Ida": "ida", "doctor meyer": "meyer"},
    "tool": {"whisk": "whisk", "ladle": "ladle"},
}
PHRASES = {
    "go to {place}": {"task": "go"},
    "look around in {place}": {"task": "look"},
    "look around": {"task": "look", "place": "here"},
    "find {object} in {place}": {"task": "find"},
    "deliver {object} to {person}": {"task": "deliver"},
    "fetch {tool}": {"task": "fetch"},
    "hand {tool} to {person}": {"task": "hand"},
    "clean {place}": {"task": "clean"},
    "water {place} with {litres}": {"task": "water"},
    "follow {person}": {"task": "follow"},
}


def talked(*sentences: str, names: Mapping[str, Mapping[str, Any]] = NAMES) -> Sequence[Mapping[str, Any]]:
    """What the last of some sentences of one person has read back: the arguments of each order of it."""
    dialogue = Dialogue(Settings(phrases=PHRASES, names=names), VIEW)
    found: list[Mapping[str, Any]] = []
    for at, text in enumerate(sentences, start=1):
        outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", "Eve", 5.0 * at), VIEW)
        assert not any(isinstance(each, Order) and each.name == "start" for each in outputs)
        found = [each for each in read_back(outputs) if each is not None]
    return found


@pytest.mark.parametrize(("sentences", "last"), [
    (("go to the kitchen", "look around there"), {"task": "look", "place": "kitchen"}),
    (("go to the kitchen", "yes", "look around there"), {"task": "look", "place": "kitchen"}),
    (("go to the kitchen", "no", "find the book there"), {"task": "find", "object": "book", "place": "kitchen"}),
    (("fetch the whisk", "yes", "give it to Ida"), {"task": "hand", "tool": "whisk", "person": "ida"}),
    (("fetch the whisk", "yes", "hand it to her"), None),
    (("follow Ida", "yes", "fetch the whisk", "yes", "hand it to her"),
     {"task": "hand", "tool": "whisk", "person": "ida"}),
    (("find the cup in the kitchen", "yes", "again, but in the office"),
     {"task": "find", "object": "cup", "place": "office"}),
    (("find the cup in the kitchen", "yes", "do the same in the office"),
     {"task": "find", "object": "cup", "place": "office"}),
    (("find the cup in the kitchen", "yes", "the bottle as well"),
     {"task": "find", "object": "bottle", "place": "kitchen"}),
    (("water bed three with two litres", "with six"), {"task": "water", "place": "bed_3", "litres": 6}),
    (("find the cup in the kitchen", "no, in the office"), {"task": "find", "object": "cup", "place": "office"}),
])  # fmt: skip
def test_what_was_named_before_is_meant(sentences: Sequence[str], last: Mapping[str, Any] | None) -> None:
    assert talked(*sentences) == ([] if last is None else [last])


@pytest.mark.parametrize("sentences", [
    ("look around there",), ("hand it to Ida",),
])  # fmt: skip
def test_what_was_not_named_is_not_guessed(sentences: Sequence[str]) -> None:
    assert [each for each in talked(*sentences) if each.get("place", "here") != "here"] == []


def test_what_another_person_named_is_not_meant() -> None:
    dialogue = Dialogue(Settings(phrases=PHRASES, names=NAMES), VIEW)
    dialogue.on_utterance(Utterance("go to the kitchen", "operator", "page", "Bob", 1.0), VIEW)
    outputs = dialogue.on_utterance(Utterance("clean it", "operator", "terminal", "Eve", 2.0), VIEW)
    assert read_back(outputs) == []


@pytest.mark.parametrize(("text", "value"), [
    ("bring Ida the letter", {"task": "deliver", "person": "ida", "object": "letter"}),
    ("could you give doctor Meyer my keys, please?", {"task": "deliver", "person": "meyer", "object": "keys"}),
    ("pass Ida the ladle", {"task": "hand", "person": "ida", "tool": "ladle"}),
    ("fetch the whisk and hand it to Ida", {"task": "fetch", "tool": "whisk"}),
    ("the kitchen is dirty, clean it", {"task": "clean", "place": "kitchen"}),
    ("give the kitchen a quick clean", {"task": "clean", "place": "kitchen"}),
    ("clean the office for the visitors", {"task": "clean", "place": "office"}),
    ("clean the kitchen, no, I mean the office", {"task": "clean", "place": "office"}),
])  # fmt: skip
def test_an_order_is_read_whatever_the_order_of_its_words(text: str, value: Mapping[str, Any]) -> None:
    assert talked(text)[:1] == [value]


@pytest.mark.parametrize(("text", "person"), [("bring Anna the letter", "anna"), ("bring me the letter", "")])
def test_without_a_list_of_persons_a_thing_with_an_article_is_behind_the_person(text: str, person: str) -> None:
    found = talked(text, names={})
    assert [each.get("person", "") for each in found] == (
        [person] if person else [each.get("person") for each in found]
    )
    assert all(each["object"] == "letter" for each in found)


def test_a_person_who_speaks_is_a_person() -> None:
    assert talked("follow me", names={}) == [{"task": "follow", "person": "me"}]
    assert talked("follow me") == []  # `me` is none of the persons that are listed
