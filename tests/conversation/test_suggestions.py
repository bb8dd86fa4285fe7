# SPDX-License-Identifier: Apache-2.0
"""What one clause of other talk orders is read back, what it asks is answered, and nothing of it is done."""

from __future__ import annotations

from itertools import product

import pytest

from rai_missions.conversation import (
    Dialogue,
    Output,
    Speech,
    TalkNote,
    Utterance,
)
from rai_missions.conversation.language.language import language, languages
from rai_missions.engine.modes import Mode
from rai_missions.event import Role
from tests.conversation.stored import ASSISTING, SENTENCES, read_back, settings_in

PHRASES = {
    "en": {
        "(find|look for) {object}": {"task": "find"}, "go to {place}": {"task": "go"}, "go home": {"task": "back"},
    },
    "de": {
        "(finde|suche) {object}": {"task": "find"}, "fahre in {place}": {"task": "go"}, "fahre heim": {"task": "back"},
    },
}  # fmt: skip
PLACES = {"en": {"kitchen": "kitchen", "study": "study"}, "de": {"küche": "kitchen", "diele": "study"}}
TALK = {
    "en": ("I am hungry", "The weather is lovely today", "You were great", "My phone is over there"),
    "de": ("Ich habe Hunger", "Das Wetter ist heute schön", "Du warst toll", "Mein Telefon liegt dort"),
}
ORDERS = {
    "en": {
        "go to the kitchen": {"task": "go", "place": "kitchen"}, "could you go home": {"task": "back"},
        "please find the cup": {"task": "find", "object": "cup"}, "cancel the mission": {},
    },
    "de": {
        "fahr in die Küche": {"task": "go", "place": "kitchen"}, "kannst du bitte heimfahren": {"task": "back"},
        "such bitte die Tasse": {"task": "find", "object": "tasse"}, "brich die Mission ab": {},
    },
}  # fmt: skip
JOINED = {
    "en": ("{talk}, {order}.", "{talk}. {order}!", "{talk}, so {order}", "{order}. {talk}", "{order} because {talk}"),
    "de": ("{talk}, {order}.", "{talk}. {order}!", "{talk}, also {order}", "{order}. {talk}"),
}
LOST = {
    "en": (
        ("The ball is gone.", "Find it!", "ball"), ("My red cup has vanished,", "could you look for it?", "red cup"),
        ("I do not know where I left my book,", "so find it", "book"),
        ("The dog's ball is missing,", "look for it please", "dog's ball"), ("Where is my cup?", "Find it!", "cup"),
        ("The dog is going crazy, he wants his ball,", "can you look for it?", "ball"),
        ("My keys were not in the hall, so find them.", "", "keys"),
    ),
    "de": (
        ("Der Ball ist weg.", "Such ihn!", "ball"), ("Mein roter Becher ist verschwunden,", "such ihn", "roter becher"),
        ("Ich weiß nicht, wo mein Buch liegt,", "also such es", "buch"), ("Wo ist mein Ball?", "Such ihn!", "ball"),
        ("Im Keller war sie nicht, also muss die Lampe in der Wohnung sein.", "Such sie bitte.", "lampe"),
    ),
}  # fmt: skip
CONDITIONS = {"en": ("When {talk}, {order}", "{talk}, if so, {order}"), "de": ("Wenn {talk}, {order}",)}


def dialogue_in(code: str, *, has_model: bool = False) -> Dialogue:
    return Dialogue(settings_in(code, PHRASES[code], PLACES[code], has_model=has_model), ASSISTING)


def replies(text: str, code: str, *, role: Role = "operator", has_model: bool = False) -> tuple[Output, ...]:
    """What a dialogue makes of a typed sentence."""
    return dialogue_in(code, has_model=has_model).on_utterance(Utterance(text, role, "terminal"), ASSISTING)


@pytest.mark.parametrize("code", languages())
def test_an_order_between_other_talk_is_read_back_and_not_given_out(code: str) -> None:
    wrong = list[str]()
    for joined, talk, (order, arguments) in product(JOINED[code], TALK[code], ORDERS[code].items()):
        text = joined.format(talk=talk, order=order)
        if read_back(replies(text, code)) != [arguments]:
            wrong.append(text)
    assert wrong == []


def test_whom_an_order_bids_may_come_first() -> None:
    assert read_back(replies("That is all, you go home now", "en")) == [{"task": "back"}]
    assert read_back(replies("Robot, please you go to the kitchen", "en")) == [{"task": "go", "place": "kitchen"}]
    assert read_back(replies("You go home?", "en")) == []


@pytest.mark.parametrize(
    ("code", "text"), [("en", "I am hungry, take a break"), ("de", "Ich habe Hunger, mach eine Pause")]
)
def test_a_pause_is_read_back_where_it_is_suggested(code: str, text: str) -> None:
    assert read_back(replies(text, code)) == [{}]


@pytest.mark.parametrize("code", languages())
def test_a_pronoun_is_the_thing_that_was_named_before(code: str) -> None:
    meant = {f"{talk} {order}": {"task": "find", "object": thing} for talk, order, thing in LOST[code]}
    assert {text: read_back(replies(text, code)) for text in meant} == {text: [each] for text, each in meant.items()}


@pytest.mark.parametrize("code", languages())
def test_nothing_is_suggested_after_a_condition_to_who_may_not_order_aloud_or_next_to_a_model(code: str) -> None:
    order, talk = next(iter(ORDERS[code])), TALK[code][0]
    for form in CONDITIONS[code]:
        assert read_back(replies(form.format(talk=talk, order=order), code)) == []
    text = f"{talk}, {order}"
    assert read_back(replies(text, code, role="viewer")) == []
    assert read_back(replies(text, code, has_model=True)) == []
    spoken = Utterance(text, "operator", "voice", readings=(text, text))
    assert read_back(dialogue_in(code).on_utterance(spoken, ASSISTING)) == []


@pytest.mark.parametrize("code", languages())
def test_what_was_read_back_before_remains(code: str) -> None:
    (first, arguments), (second, _) = list(ORDERS[code].items())[:2]
    dialogue = dialogue_in(code)
    assert read_back(dialogue.on_utterance(Utterance(first, "operator", "terminal"), ASSISTING)) == [arguments]
    talk = Utterance(f"{TALK[code][0]}, {second}", "operator", "terminal")
    assert read_back(dialogue.on_utterance(talk, ASSISTING)) == []


@pytest.mark.parametrize(
    ("code", "text"), [("en", "You look tired. What are you doing?"), ("de", "Du siehst müde aus. Was machst du?")]
)
def test_a_question_between_other_talk_is_answered(code: str, text: str) -> None:
    question = text.split(". ")[1]
    answers = [[each.text for each in replies(each, code) if isinstance(each, Speech)] for each in (text, question)]
    assert answers[0] == answers[1] != []


RESUMED = {"en": ("carry on", "off you go", "get on with it", "back to work"), "de": ("mach weiter", "weiter geht es")}


@pytest.mark.parametrize(("mode", "is_possible"), [("running", False), ("paused", True)])
@pytest.mark.parametrize("code", languages())
def test_an_order_next_to_a_fact_that_is_not_possible_now_is_answered_with_why(
    code: str, mode: Mode, is_possible: bool
) -> None:
    view = ASSISTING._replace(mode=mode)
    for talk, order in product(TALK[code], RESUMED[code]):
        outputs = dialogue_in(code).on_utterance(Utterance(f"{talk}, {order}.", "operator", "terminal"), view)
        notes = [(each.kind, each.data.get("order")) for each in outputs if isinstance(each, TalkNote)]
        expected = ("read_back", {"order": "resume"}) if is_possible else ("refused", "resume")
        assert expected in notes, (talk, order)


@pytest.mark.parametrize("code", languages())
def test_an_order_in_quotation_marks_is_none(code: str) -> None:
    for talk, order in product(TALK[code], ORDERS[code]):
        for form in ('{talk}, "{order}"', "{talk}, '{order}.'", "{talk}. „{order}“"):
            text = form.format(talk=talk, order=order)
            assert read_back(replies(text, code)) == [], text


@pytest.mark.parametrize("code", languages())
def test_talk_without_an_order_in_it_has_none_suggested(code: str) -> None:
    assert [each for each in SENTENCES["talk"][code] if read_back(replies(each, code))] == []


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize(
    "name",
    [
        "clause_joints",
        "thing_pronouns",
        "thing_ends",
        "asking",
        "fillers",
        "addressed",
        "articles",
        "addressing",
        "no_order_after",
        "requesting",
        "owners",
    ],
)
def test_a_list_of_words_has_words_alone(name: str, code: str) -> None:
    words = language(code).data[name]
    assert words and [each for each in words if len(language(code).normaliser.words(each)) != 1] == []
