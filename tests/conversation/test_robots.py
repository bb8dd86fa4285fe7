# SPDX-License-Identifier: Apache-2.0
"""Sentences for robots that were made from the guides, five or six by each author, and dialogues with them.

The first are a drone, an arm, a truck, a courier and a gardener; the second, for a library, a watch, a bar, a pool and
a solar farm, were written before their author had read the grammar. So were the third, for a rink, linen, a museum,
bricks, samples and an airport, whose options take values, and the fourth, for windows, fruit, an aquarium, medicines, a
greenhouse and a pool. Two of the second talk German, and three of the third and of the fourth.

Every other sentence was read while the rules were written, the first of each two; the rest was only counted.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache, partial
from typing import Any

import pytest

from rai_missions.conversation import (
    Dialogue,
    KeyView,
    MissionView,
    Order,
    Settings,
    Speech,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.engine.decision import Offer, Question
from tests.conversation.judged import is_meant, ordered
from tests.conversation.stored import read

SETS: Mapping[str, Mapping[str, Any]] = {
    "first": read("robots.json"),
    "second": read("robots_second.json"),
    "third": read("robots_third.json"),
    "fourth": read("robots_fourth.json"),
}
ROBOTS: Mapping[str, Any] = {name: given for each in SETS.values() for name, given in each.items()}
KINDS = ("orders", "questions", "answers", "stops", "harmless")


def value_of(at: int, kind: str) -> Any:
    """A value that no other key of the robot has."""
    return {"string": f"zebra{at}", "boolean": True, "integer": 700 + at, "number": 700 + at}[kind]


@cache
def robot(name: str) -> tuple[Settings, StatusView]:
    """How a robot is talked with, and the run of its mission, which works."""
    given = ROBOTS[name]
    each = [
        KeyView(key, kind, source, about, minimum=least, maximum=most)
        for key, kind, source, about, least, most in given["keys"]
    ]
    facts = {key.name: key._replace(value=value_of(at, key.type), age_s=0.1) for at, key in enumerate(each)}
    view = StatusView(
        run="r1",
        mode="running",
        mission=name,
        robot=name,
        active=("working",),
        states={"working": "it works"},
        missions=(MissionView(name, "", tuple(key for key in each if key.source == "argument")),),
        keys={key: fact for key, fact in facts.items() if fact.source != "argument"},
    )
    code = given.get("language", "en")
    settings = Settings(language=code, phrases=given["phrases"], names=given["names"], questions=given["questions"])
    return settings, view


def asking(name: str) -> StatusView:
    """The run whose question is open."""
    given = ROBOTS[name]
    texts = {name: [each] if isinstance(each, str) else each for name, each in given["options"].items()}
    options = tuple(Offer(name, *each) for name, each in texts.items())
    question = Question(1, "asking", "operator", given["question"], options)
    return robot(name)[1]._replace(questions=(question,), confirm=frozenset((1, each) for each in given["confirm"]))


def is_answered(name: str, key: str, spoken: str) -> bool:
    """Whether the value of a key was spoken, and of what is true or false its name, or no other fact."""
    at, kind = next((at, each[1]) for at, each in enumerate(ROBOTS[name]["keys"]) if each[0] == key)
    if kind == "boolean":
        return not {"Yes.", "Ja."}.isdisjoint(spoken.split()) or key.partition("_")[0] in spoken.lower()
    return str(value_of(at, kind)) in spoken.lower()


def rights(name: str, kind: str) -> Iterator[bool]:
    """Whether each sentence of a set is read right; long after the one before."""
    settings, working = robot(name)
    for text, expected in ROBOTS[name]["sets"][kind]:
        view = asking(name) if kind == "answers" else working
        view = view._replace(mode="paused") if expected == "resume" else view
        found = Dialogue(settings, view).on_utterance(Utterance(text, "operator", "terminal", "Eve", 9.0), view)
        yield is_meant(text, expected, found, view, settings.language, partial(is_answered, name))


MODES = {"start": "running", "resume": "running", "stop": "paused", "pause": "paused"}
LEAST = {
    ("first", "orders"): (60, 47), ("first", "questions"): (37, 32), ("first", "answers"): (25, 24),
    ("first", "stops"): (20, 20), ("first", "harmless"): (38, 33), ("first", "dialogues"): (40, 35),
    ("second", "orders"): (46, 37), ("second", "questions"): (37, 32), ("second", "answers"): (28, 25),
    ("second", "stops"): (20, 20), ("second", "harmless"): (29, 28), ("second", "dialogues"): (72, 58),
    ("third", "orders"): (25, 26), ("third", "questions"): (22, 23), ("third", "answers"): (50, 42),
    ("third", "stops"): (18, 18), ("third", "harmless"): (30, 28), ("third", "dialogues"): (50, 47),
    ("fourth", "orders"): (46, 38), ("fourth", "questions"): (48, 40), ("fourth", "answers"): (28, 24),
    ("fourth", "stops"): (18, 12), ("fourth", "harmless"): (28, 28), ("fourth", "dialogues"): (114, 107),
}  # fmt: skip
"""Those that are read right, of the half that was read and of the other."""


def turns(dialogue: Mapping[str, Any]) -> Iterator[bool]:
    """Whether each turn of a dialogue with a robot that is ready comes to what was meant."""
    settings, view = robot(dialogue["robot"])
    view = view._replace(mode="ready", awaits_start=True)
    talk = Dialogue(settings, view)
    for at, (text, expected, *author) in enumerate(dialogue["turns"], start=1):
        by = author[0] if author else "Eve"
        found = talk.on_utterance(Utterance(text, "operator", "terminal", by, 6.0 * at), view)
        notes = {each.kind for each in found if isinstance(each, TalkNote)}
        given = [each.name for each in found if isinstance(each, Order)]
        is_taken = bool(given) or "queued" in notes
        come_to = {"confirmed": is_taken, "unconfirmed": not is_taken, "dropped": bool({"dropped", "void"} & notes)}
        come_to["what was"] = "read_back" not in notes
        answers = partial(is_answered, dialogue["robot"])
        yield any(
            come_to[each] if each in come_to else is_meant(text, each, found, view, settings.language, answers)
            for each in expected.partition(",")[0].partition(" (")[0].split(" or ")
        )
        if given and given[-1] in MODES:
            view = view._replace(mode=MODES[given[-1]], awaits_start=False)
            talk.on_status(view, 6.0 * at + 0.5)


def halves(who: str, kind: str) -> tuple[int, int]:
    """How many are read right of each half."""
    if kind == "dialogues":
        each = [list(turns(dialogue)) for dialogue in SETS[who]["dialogues"]]
        return sum(map(sum, each[::2])), sum(map(sum, each[1::2]))
    found = [list(rights(name, kind)) for name in SETS[who] if name != "dialogues"]
    return sum(sum(one[::2]) for one in found), sum(sum(one[1::2]) for one in found)


QUICK = frozenset({("fourth", "orders"), ("fourth", "answers"), *((who, "stops") for who in SETS)})
"""The sets that are read in `make test`."""


@pytest.mark.parametrize(
    ("who", "kind"),
    [pytest.param(*each, marks=[pytest.mark.long] * (each not in QUICK)) for each in LEAST],
)
def test_as_many_sentences_for_the_robots_are_read_right_as_before(who: str, kind: str) -> None:
    found = halves(who, kind)
    assert all(each >= least for each, least in zip(found, LEAST[who, kind], strict=True)), found


@pytest.mark.parametrize(("name", "text", "key"), [
    ("poolroboter", "läuft die Pumpe?", "pump_on"), ("poolroboter", "wie viele Leute schwimmen gerade?", "swimmers"),
    ("medikamentenwagen", "wessen Ausweis wurde zuletzt gelesen?", "last_scan"),
    ("gewaechshaus", "wie viele Früchte hast du geerntet?", "picked"),
    ("window_cleaner", "how many panes have you done?", "panes_done"),
    ("window_cleaner", "how many panes are dirty?", ""), ("poolroboter", "wann läuft die Pumpe?", ""),
])  # fmt: skip
def test_a_question_in_the_words_of_an_about_is_of_its_key(name: str, text: str, key: str) -> None:
    settings, view = robot(name)
    found = Dialogue(settings, view).on_utterance(Utterance(text, "operator", "terminal", "Eve", 9.0), view)
    spoken = " ".join(each.text for each in found if isinstance(each, Speech))
    assert [each for each in view.keys if is_answered(name, each, spoken)] == [key] * bool(key)


@pytest.mark.parametrize(("text", "options"), [
    ("take the one in the east wing", ["other_lift"]), ("the one in the east wing", ["other_lift"]),
    ("take the one in the west wing", []), ("take the one in the east wing or wait", []),
])  # fmt: skip
def test_the_option_with_each_word_of_a_clause_is_meant(text: str, options: list[str]) -> None:
    settings, view = robot("ward_courier")[0], asking("ward_courier")
    found = ordered(Dialogue(settings, view).on_utterance(Utterance(text, "operator", "terminal", "Eve", 9.0), view))
    assert [each["option"] for each in found if each["order"] == "answer"] == options


@pytest.mark.parametrize(("text", "is_offered"), [
    ("how hot is the hob", False), ("could you see to the hob?", True),
])  # fmt: skip
def test_a_question_that_facts_answer_offers_no_order(text: str, is_offered: bool) -> None:
    settings, view = robot("kitchen_arm")
    found = Dialogue(settings, view).on_utterance(Utterance(text, "operator", "terminal", "Eve", 9.0), view)
    assert bool(ordered(found)) == is_offered
