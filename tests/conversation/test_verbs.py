# SPDX-License-Identifier: Apache-2.0
"""In the phrases of a profile a verb that a language lists is any verb of its sense."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import KeyView, MissionView, StatusView
from rai_missions.conversation.grammar.sentence_grammar import SentenceGrammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from rai_missions.conversation.language.phrases import AROUND, Phrases
from tests.sampled import sampled

VIEW = StatusView(missions=(MissionView("assist", "", (KeyView("object", "string", "argument"),)),))
VERBS = [(code, verb) for code in languages() for verb in language(code).data["verbs"]]
AROUND_OBJECTS = [
    (code, verb, *form.split(AROUND))
    for code, verb in VERBS
    for form in language(code).data["verbs"][verb]
    if AROUND in form
]
"""The forms of verbs that are around their object, `tidy … up`, in two pieces."""
WHOLE = ("come back", "komme zurück")
"""Verbs that are an order by themselves."""
HEADS: Mapping[str, Mapping[str, str]] = {
    "en": {
        "head over to": "go to", "pop round": "go", "have a quick look for": "find", "take a look about": "look around",
        "sit tight for": "wait", "drive back to your charging station": "come back", "be in": "go to",
        "drop off": "deliver", "go and pick up": "fetch", "get me the": "fetch", "mop the floor in": "clean",
        "tag along with": "follow", "take a closer look at": "inspect", "check on": "examine", "top up": "charge",
        "do a headcount of": "count", "escort": "guide", "take a quick picture of": "photograph", "unlock": "open",
    },
    "de": {
        "roll zurück": "fahre", "begib dich ins": "fahre in", "halte Ausschau nach": "finde",
        "guck rum": "schau dich um", "bleib hier stehen": "warte", "ab an deine Ladestation": "komme zurück",
        "sei im": "fahre in", "trag": "liefere", "besorg mir": "hole", "wisch bitte": "reinige", "geh mit": "folge",
        "überprüfe": "prüfe", "mach uns ein Foto vom": "fotografiere", "begleite": "führe", "bewässere": "gieße",
    },
}  # fmt: skip


def starts(code: str, phrase: str) -> StartPhrases:
    return StartPhrases({phrase: {}}, {}, language(code))


def object_of(code: str, phrase: str, words: list[str]) -> object:
    """The object that a start by the phrase has; None where the words are no such start."""
    found = next(starts(code, phrase).senses(words, VIEW.missions), None)
    return None if found is None else found.arguments.get("object")


@pytest.mark.parametrize(("code", "verb"), sampled(VERBS, 4))
@settings(max_examples=30)
@given(data=st.data())
def test_a_phrase_with_a_listed_verb_is_read_with_each_verb_of_its_sense(
    code: str, verb: str, data: st.DataObject
) -> None:
    parts = language(code).parts
    pattern = Phrases([parts[verb.replace(" ", "_")]], parts).pattern
    words = data.draw(st.from_regex(re.compile(pattern), fullmatch=True)).split()
    assert language(code).order_phrases([f"please {verb} now"]).fits(["please", *words, "now"])
    if verb not in WHOLE:  # the value begins where the verb ends
        assert object_of(code, f"{verb} {{object}}", [*words, "xylophone"]) == "xylophone"


@pytest.mark.parametrize(("code", "verb", "begin", "end"), AROUND_OBJECTS)
@pytest.mark.parametrize("more", ["", " [from here]"])
@settings(max_examples=5)
@given(data=st.data())
def test_a_verb_around_its_object_is_read_with_the_object_in_it(
    code: str, verb: str, begin: str, end: str, more: str, data: st.DataObject
) -> None:
    pieces = [re.compile(Phrases([piece], language(code).parts).pattern) for piece in (begin, end)]
    words = [data.draw(st.from_regex(piece, fullmatch=True)).split() for piece in pieces]
    assert object_of(code, f"{verb} {{object}}{more}", [*words[0], "red", "xylophone", *words[1]]) == "red xylophone"


@pytest.mark.parametrize(
    ("code", "sentence", "phrase", "thing"),
    [
        ("en", "clean the hall up", "clean {object}", "hall"),
        ("en", "give the plants a little water", "water {object}", "plants"),
        ("en", "pick the parcel up from reception", "fetch {object} [from reception]", "parcel"),
        ("de", "räum bitte das Büro auf", "reinige {object}", "büro"),
        ("de", "kannst du die Küche sauber machen", "reinige {object}", "küche"),
        ("de", "geh die Handtücher holen", "hole {object}", "handtücher"),
        ("de", "lauf hinter Tom her", "folge {object}", "tom"),
        ("de", "prüf die Pumpe", "prüfe {object}", "pumpe"),
    ],
)
def test_an_order_has_the_object_that_its_verb_is_around(code: str, sentence: str, phrase: str, thing: str) -> None:
    grammar = SentenceGrammar(language(code), starts(code, phrase), {})
    read = [each.arguments.get("object") for each in grammar.senses(language(code).normaliser.words(sentence), VIEW)]
    assert read == [thing]


@pytest.mark.parametrize("code", languages())
def test_the_verbs_that_people_use_are_of_the_sense_that_they_have(code: str) -> None:
    read = {
        text: object_of(code, f"{verb} {{object}}", language(code).normaliser.words(f"{text} Xylophon"))
        for text, verb in HEADS[code].items()
    }
    assert read == dict.fromkeys(HEADS[code], "xylophon")


@pytest.mark.parametrize(
    ("code", "phrase", "other"), [("en", "smash {object}", "find"), ("de", "wirf {object}", "suche")]
)
def test_a_phrase_with_another_verb_is_read_with_that_verb_alone(code: str, phrase: str, other: str) -> None:
    assert object_of(code, phrase, [phrase.split()[0], "xylophone"]) == "xylophone"
    assert object_of(code, phrase, [other, "xylophone"]) is None


def test_the_name_of_a_slot_is_no_verb() -> None:
    assert starts("en", "smash {go}").words == starts("en", "smash {object}").words
