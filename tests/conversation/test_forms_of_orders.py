# SPDX-License-Identifier: Apache-2.0
"""An order in another form is the order: asked politely, corrected in the same sentence, or a value alone."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import pytest

from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import STOP, Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from rai_missions.engine.decision import Offer, Question
from tests.conversation.stored import ASSISTING

PHRASES = {
    "en": {
        "(find|look for) {object}": {"task": "find"}, "go (to|in) {place}": {"task": "go"},
        "go back to your dock": {"task": "back"}, "[off] [to|in] {place} [with you]": {"task": "go"},
    },
    "de": {
        "(finde|suche) {object}": {"task": "find"}, "fahre in {place}": {"task": "go"},
        "fahre nach hause": {"task": "back"}, "[ab] [in|ins] {place}": {"task": "go"},
    },
}  # fmt: skip
PLACES = {
    "en": {"place": {"kitchen": "kitchen", "study": "study"}},
    "de": {"place": {"küche": "kitchen", "diele": "hall"}},
}


INDIRECT = {
    "en": {
        "Could you show me where you are?": "where", "I wonder what you are doing": "doing",
        "Do you know how far you are?": "progress", "I'm wondering what you're doing.": "doing",
        "I wonder what this is about": "",
    },
    "de": {
        "Kannst du mir sagen, wo du bist?": "where", "Ich wüsste gern, wo du bist": "where",
        "Weißt du, wie weit du bist?": "progress", "Ich wüsste gern, was das für ein Lied ist": "",
    },
}  # fmt: skip


STOPS = {
    "en": ("stop", "stop it now", "Halt", "please stop", "freeze", "stop the robot"),
    "de": ("stopp", "halt an", "bleib stehen", "anhalten"),
}
REASONS = {
    "en": (
        "or you'll crash", "because there is a cat", "before you hit it", "since the gate is shut", "so I can pass",
        "you're too close", "there's a child on the floor", "while I move the chair", "until I am back",
    ),
    "de": (
        "sonst krachts", "weil da ein Hund ist", "bevor du dagegen fährst", "oder du fährst dagegen", "da liegt was",
        "du fährst gleich dagegen", "bis ich vorbei bin",
    ),
}  # fmt: skip
AHEAD = {
    "en": ("", "all clear,", "There is a child.", "it is late,", "I am in front of you,"),
    "de": ("", "alles klar,", "Da ist ein Kind.", "es ist spät,", "ich bin vor dir,"),
}
LATER = {
    "en": ("when you get to the gate", "if you see a dog", "signs are red", "by the shop on the way"),
    "de": ("wenn du am Tor bist", "falls du einen Hund siehst"),
}


class Form(NamedTuple):
    """An order, and its verb in the forms that a polite sentence has."""

    order: str
    noun: str
    """English: the form with -ing; German: the infinitive."""
    finite: str
    """English: the past; German: of the second person."""


ORDERS = {
    "en": (
        Form("go to the kitchen", "going to the kitchen", "went to the kitchen"),
        Form("look for the cup", "looking for the cup", "looked for the cup"),
        Form("go back to your dock", "going back to your dock", "went back to your dock"),
        Form("stop", "stopping", "stopped"), Form("wait", "waiting", "waited"),
    ),
    "de": (
        Form("fahre in die Küche", "in die Küche fahren", "in die Küche fährst"),
        Form("suche die Tasse", "die Tasse suchen", "die Tasse suchst"),
        Form("fahre nach Hause", "nach Hause fahren", "nach Hause fährst"),
        Form("halte an", "anhalten", "anhältst"), Form("mache weiter", "weitermachen", "weitermachst"),
    ),
}  # fmt: skip
POLITE = {
    "en": (
        "Would you mind {noun}?", "Rob, do you mind {noun} now, please?", "Mind {noun}?", "It's time you {finite}.",
        "I'd be glad if you'd {order}.", "Hey, I was hoping you could {order}", "Any chance you could {order}?",
        "When you have a minute, {order}", "Forget it, {order}!", "It would be lovely if you {finite}",
        "{order} and show me what you see", "{order} and report back, please", "Right mate, {order}",
        "Do {order}, dear.",
        "It would put my mind at rest if you {finite}", "What I'd like is for you to {order}",
        "If it isn't a bother, might you {order}?",
    ),
    "de": (
        "Könntest du bitte {noun}?", "Rob, kannst du mal {noun}", "Du kannst jetzt {noun}.",
        "Ich möchte, dass du {finite}.", "Wenn du Zeit hast, {order}", "Vergiss es, {order}!",
        "Wären Sie so freundlich und {order}?", "{order} und sag mir, was du siehst", "{order} und berichte.",
        "{order}, ja?",
        "Mich würde es freuen, wenn du {finite}",
    ),
}  # fmt: skip
MARKS = {
    "en": ("no", "no wait", "sorry", "sorry, I meant", "I mean", "actually"),
    "de": ("nein", "äh nein", "ach Quatsch", "nein, ich meine", "doch lieber"),
}
CORRECTED = {
    "en": (("go to the kitchen", "the study", "go to the study"), ("find the cup", "the book", "find the book"),
           ("go to the attic", "the study", "go to the study")),
    "de": (("fahre in die Küche", "in die Diele", "fahre in die Diele"), ("suche die Tasse", "das Buch", "suche Buch")),
}  # fmt: skip
VALUES = {
    "en": {"Rob, kitchen please": "kitchen", "Off to the study with you!": "study", "erm, the kitchen": "kitchen"},
    "de": {"Rob, in die Küche bitte": "kitchen", "Ab in die Diele!": "hall", "die Küche": "kitchen"},
}
NO_ORDERS = {
    "en": ("Mum, would you mind going to the kitchen?", "Mum, could you look for the cup?", "I am off to the kitchen",
           "would you mind not looking for the cup?", "do not look for the cup", "look for no cup", "off to the office",
           "the kitchen is dirty", "it is time you stopped smoking", "would you mind if I went to the kitchen?"),
    "de": ("Mama, kannst du in die Küche fahren?", "Mama, könntest du die Tasse suchen?", "ich fahre in die Küche",
           "könntest du nicht die Tasse suchen", "suche nicht die Tasse", "suche keine Tasse", "ab ins Büro",
           "die Küche ist schmutzig", "ich möchte in die Küche fahren", "Rote Bete färbt Hände"),
}  # fmt: skip


ABOUT_IT = {
    "en": (("find the cup", "and", "bring it to me"), ("look for my keys", "and then", "give them to anna"),
           ("find the red one", "then", "clean it")),
    "de": (("suche den Becher", "und", "bring ihn mir"), ("finde das Buch", "und dann", "lies es mir vor")),
}  # fmt: skip


def grammar_of(code: str) -> Grammar:
    words = language(code)
    return Grammar(words, StartPhrases(PHRASES[code], PLACES[code], words))


def ordered(senses: tuple[Sense, ...]) -> list[tuple[str, dict[str, object]]]:
    return [(each.name, dict(each.arguments)) for each in senses if each.kind == "order"]


def polite() -> Iterator[tuple[str, str, str]]:
    for code, frames in POLITE.items():
        for frame in frames:
            for form in ORDERS[code]:
                yield code, frame.format(**form._asdict()), form.order


@pytest.mark.parametrize(("code", "sentence", "order"), [*polite()])
def test_a_polite_sentence_is_the_order_in_it(code: str, sentence: str, order: str) -> None:
    grammar = grammar_of(code)
    assert ordered(grammar.senses(sentence, ASSISTING)) == ordered(grammar.senses(order, ASSISTING)) != []


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize("sign", [", ", " ", " – ", "... "])
def test_a_correction_in_the_same_sentence_is_the_order_of_both(code: str, sign: str) -> None:
    grammar = grammar_of(code)
    for order, instead, meant in CORRECTED[code]:
        for mark in MARKS[code]:
            sentence = f"{order}{sign}{mark} {instead}"
            assert ordered(grammar.senses(sentence, ASSISTING)) == ordered(grammar.senses(meant, ASSISTING)) != [], (
                sentence
            )


@pytest.mark.parametrize("code", languages())
def test_a_clause_about_the_thing_that_is_looked_for_is_no_part_of_its_name(code: str) -> None:
    grammar = grammar_of(code)
    for order, joint, then in ABOUT_IT[code]:
        found = grammar.senses(f"{order} {joint} {then}", ASSISTING)
        assert ordered(found) == ordered(grammar.senses(order, ASSISTING)) != [], then
        assert [each.rest for each in found] == [then]
    both = {"en": "find the salt and pepper", "de": "finde Salz und Pfeffer"}[code]
    assert [(each.rest, each.then) for each in grammar.senses(both, ASSISTING)] == [("", ())], "two words are a name"
    both = {"en": "find the cup and the plant", "de": "finde die Tasse und die Kanne"}[code]
    each = {"en": ("find the cup", "find the plant"), "de": ("finde die Tasse", "finde die Kanne")}[code]
    (found,) = grammar.senses(both, ASSISTING)
    assert ordered(found.each) == [order for one in each for order in ordered(grammar.senses(one, ASSISTING))]


@pytest.mark.parametrize("code", languages())
def test_a_value_alone_is_the_start_that_takes_it_unless_a_text_is_asked_for(code: str) -> None:
    grammar = grammar_of(code)
    text = Offer("answer", "", {"properties": {"text": {"type": "string"}}, "required": ["text"]})
    asked = ASSISTING._replace(questions=(Question(1, "s", "operator", "?", (text,)),))
    for sentence, place in VALUES[code].items():
        assert ordered(grammar.senses(sentence, ASSISTING)) == [("start", {"task": "go", "place": place})], sentence
        assert all(name != "start" for name, _ in ordered(grammar.senses(sentence, asked))), sentence


@pytest.mark.parametrize("code", languages())
def test_what_is_asked_of_another_or_negated_orders_nothing(code: str) -> None:
    grammar = grammar_of(code)
    assert {each: found for each in NO_ORDERS[code] if (found := ordered(grammar.senses(each, ASSISTING)))} == {}


@pytest.mark.parametrize("code", languages())
def test_an_indirect_question_is_the_question_in_it(code: str) -> None:
    grammar = Grammar(language(code))
    read = {each: [sense.name for sense in grammar.senses(each, ASSISTING)] for each in INDIRECT[code]}
    assert read == {each: [name] if name else [] for each, name in INDIRECT[code].items()}


@pytest.mark.parametrize("code", languages())
def test_a_stop_counts_with_its_reason_behind_it_and_no_comma_whatever_is_ahead(code: str) -> None:
    grammar = Grammar(language(code))
    for ahead, stop in product(AHEAD[code], STOPS[code]):
        cried = f"{ahead} {stop}".strip()
        missed = [why for why in REASONS[code] if grammar.senses(f"{cried} {why}", ASSISTING) != (STOP,)]
        assert missed == [], cried
        now = [when for when in LATER[code] if STOP in grammar.senses(f"{cried} {when}", ASSISTING)]
        assert now == [], cried


@pytest.mark.parametrize(("text", "given"), [
    ("fahr in die Kueche", {"task": "go", "place": "kitchen"}), ("geh ins Kueche", {"task": "go", "place": "kitchen"}),
    ("komm zurueck", {"task": "back"}), ("fahr zur Diele", {"task": "go", "place": "hall"}),
])  # fmt: skip
def test_german_is_read_without_its_own_letters_and_with_each_form_of_a_preposition(
    text: str, given: dict[str, str]
) -> None:
    phrases = {"(fahr|geh) (in|zu) {place}": {"task": "go"}, "komm zurück": {"task": "back"}}
    german = language("de")
    found = Grammar(german, StartPhrases(phrases, PLACES["de"], german)).senses(text, ASSISTING)
    assert [dict(each.arguments) for each in found] == [given]


@pytest.mark.parametrize(("text", "name"), [
    ("cancel, I mean pause", "pause"), ("resume, I mean cancel", "cancel"), ("cancel, sorry, pause", "pause"),
])  # fmt: skip
def test_an_order_that_corrects_another_in_its_sentence_is_read_back_alone(text: str, name: str) -> None:
    (found,) = Grammar(language("en")).senses(text, ASSISTING)
    assert (found.name, found.then, found.is_partial) == (name, (), True)
