# SPDX-License-Identifier: Apache-2.0
"""Sentences of strangers, who had not seen the grammar: how many are read right, and what harmless ones do.

Every other sentence was read while the rules were written, the first of each two; the rest was only counted.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rai_missions.agents.talk.settings import settings_of
from rai_missions.conversation import (
    Dialogue,
    KeyView,
    MissionView,
    Output,
    Speech,
    StatusView,
    Utterance,
)
from rai_missions.engine.decision import Offer, Question
from rai_missions.profile import load_profile
from tests.conversation.judged import is_meant, ordered
from tests.conversation.stored import read
from tests.sampled import sampled

SETS = read("strangers.json")
SPOTS = ("kitchen", "living room", "bedroom", "office", "hall", "table", "shelf", "sofa", "desk", "counter")
GERMAN = (
    "Küche", "Wohnzimmer", "Schlafzimmer", "Büro", "Flur", "Tisch", "Regal", "Sofa", "Schreibtisch", "Theke",
)  # fmt: skip
NAMES = {"en": {each: each for each in SPOTS}, "de": dict(zip(GERMAN, SPOTS, strict=True))}
OWN = settings_of(load_profile("missions/rosbot/robot.sim.json").conversation)
PHRASES = {
    "en": {**OWN.phrases, "[do|make] [a|your] patrol": {"task": "patrol"}},
    "de": {
        "(such|suche|finde) {object}": {"task": "find"},
        "(such|suche|finde) {object} in {place}": {"task": "find"},
        "(wo|wohin) (ist|sind) {object} [jetzt|denn|bloß|hin]": {"task": "find"},
        "(fahr|geh) (in|zu) {place}": {"task": "go"},
        "(schau|sieh) [dich] um [in|auf] {place}": {"task": "look"},
        "(schau|sieh) [nach] (in|auf) {place}": {"task": "look"},
        "was (ist|liegt|steht) (in|auf) {place}": {"task": "look"},
        "sieh dich um": {"task": "look", "place": "here"},
        "warte {wait_s}": {"task": "wait"},
        "warte {wait_s} in {place}": {"task": "wait"},
        "komm zurück": {"task": "come_back"},
        "(patrouilliere|mach [eine|deine] patrouille|fahr patrouille)": {"task": "patrol"},
    },
}
ARGUMENTS = (
    *(KeyView(name, "string", "argument") for name in ("task", "object", "place")),
    KeyView("wait_s", "integer", "argument", minimum=1, maximum=3600),
)
KEYS = {
    "things": KeyView(
        "things", "string", "argument", value="ball, book, bottle, bowl, chair, cup, lamp, person, plant"
    ),
    "battery": KeyView("battery", "number", value=0.8),
    "report": KeyView("report", "string", value=""),
}
VIEW = StatusView(
    run="r1", mode="running", mission="assist", robot="rob", missions=(MissionView("assist", "", ARGUMENTS),), keys=KEYS
)
OPTIONS = (
    Offer("wait", "wait for the way to be free"),
    Offer("skip", "skip this room"),
    Offer("call", "call a person"),
)
ALLEY = (
    Offer("replan", "plan another way around it"),
    Offer("signal", "sound the horn and drive on"),
    Offer("continue", "drive on"),
    Offer("wait", "wait for a person"),
)
VIEWS = {
    "answers": VIEW._replace(
        questions=(Question(1, "deciding", "operator", "Shall I wait or skip the room?", OPTIONS),)
    ),
    "tractor": VIEW._replace(
        mission="tractor",
        missions=(),
        questions=(Question(1, "assessing", "operator", "Something is in the way. What shall I do?", ALLEY),),
    ),
}
"""The run in which sentences of a kind were written; the other kinds have `VIEW`."""
NONE = ("nothing", "no stop")
LEAST = {
    ("first", "house", "en"): (25, 18, 10, 9), ("first", "house", "de"): (15, 12, 5, 5),
    ("first", "stop", "en"): (18, 12, 12, 13), ("first", "stop", "de"): (10, 9, 9, 9),
    ("first", "answers", "en"): (13, 12, 6, 6), ("first", "answers", "de"): (5, 8, 4, 3),
    ("first", "state", "en"): (16, 13, 0, 0),
    ("second", "house", "en"): (18, 18, 6, 9), ("second", "house", "de"): (10, 11, 7, 3),
    ("second", "stop", "en"): (10, 15, 14, 8), ("second", "stop", "de"): (12, 8, 8, 10),
    ("second", "answers", "en"): (11, 9, 7, 5),
    ("second", "tractor", "en"): (15, 9, 3, 9), ("second", "tractor", "de"): (8, 9, 5, 2),
    ("second", "state", "en"): (20, 15, 0, 0), ("second", "state", "de"): (12, 10, 0, 0),
}  # fmt: skip
"""Those that mean something and are read right, of the half that was read and of the other; then the harmless ones."""


def outputs(code: str, texts: list[str], view: StatusView) -> Iterator[tuple[Output, ...]]:
    """What each sentence of one conversation has for an answer; long after the one before."""
    names = {"place": NAMES[code]}
    settings = OWN._replace(language=code, phrases=PHRASES[code], names=names, spoken={}, places={}, questions={})
    dialogue = Dialogue(settings, view)
    for at, text in enumerate(texts, start=1):
        yield dialogue.on_utterance(Utterance(text, "operator", "terminal", "Eve", 1_000.0 * at), view)


def rights(who: str, kind: str, code: str) -> Iterator[bool]:
    """Whether each sentence of a set is read right."""
    view, (texts, expected) = VIEWS.get(kind, VIEW), zip(*SETS[who][kind][code], strict=True)
    for text, meant, found in zip(texts, expected, outputs(code, list(texts), view), strict=True):
        yield is_meant(text, meant, found, view, code)


def halves(who: str, kind: str, code: str) -> list[int]:
    """How many are read right of each half, as `LEAST` has them."""
    expected = [name for _, name in SETS[who][kind][code]]
    rows = [(is_right, name in NONE) for is_right, name in zip(rights(who, kind, code), expected, strict=True)]
    return [
        sum(is_right for is_right, none in rows[at::2] if none == is_none) for is_none in (False, True) for at in (0, 1)
    ]


@pytest.mark.parametrize(("who", "kind", "code"), sampled(LEAST, 4))
def test_as_many_sentences_of_a_stranger_are_read_right_as_before(who: str, kind: str, code: str) -> None:
    found = halves(who, kind, code)
    assert all(each >= least for each, least in zip(found, LEAST[who, kind, code], strict=True)), found


@pytest.mark.parametrize(("text", "order"), [
    ("Not the book, the bottle, go and find the bottle.", "start"), ("hang on a sec", "pause"),
    ("don't go to the kitchen", ""),
])  # fmt: skip
def test_an_order_is_no_other_order_by_a_part_of_its_words(text: str, order: str) -> None:
    (found,) = outputs("en", [text], VIEW)
    assert [each["order"] for each in ordered(found)] == [order] * bool(order)
    assert not any("no value" in each.text for each in found if isinstance(each, Speech))
