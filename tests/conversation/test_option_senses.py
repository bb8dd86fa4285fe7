# SPDX-License-Identifier: Apache-2.0
"""Answers in words of a person's own: which option they ask for, and what is none."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pytest

from rai_missions.conversation import Dialogue, Order, Output, Settings, Speech, StatusView, TalkNote, Utterance
from rai_missions.engine.decision import Offer, Question
from tests.conversation.stored import SENTENCES, read, read_back
from tests.sampled import sampled

STORED = read("answers.json")
CODES = tuple(STORED)
ANSWERS = [
    (code, option, text) for code in CODES for option, texts in STORED[code]["answers"].items() for text in texts
]
CLAUSES = [(code, option, text) for code, option, text in ANSWERS if not re.search(r"[,.] \w", text)]
FACTS = {
    "en": ("That is only a branch", "The gate is open now", "It should be free by now", "I have the keys"),
    "de": ("Das ist bloß Laub", "Die Tür ist jetzt offen", "Ich habe den Schlüssel"),
}
OF_OTHERS = {
    "en": ("My brother always has it: {}", 'She thinks "{}" is best', "Old Tom mumbled '{}' all day"),
    "de": ("Mein Bruder sagte: {}", 'Er findet "{}" am besten', "Opa murmelte '{}' vor sich hin"),
}
MOST_READ_BACK = 0.02
"""The share of other talk that may be read back as an answer."""


def asking(options: Mapping[str, str]) -> StatusView:
    """A run with an open question."""
    offers = tuple(Offer(name, about) for name, about in options.items())
    return StatusView(
        run="r1",
        mode="running",
        mission="rows",
        robot="rob",
        questions=(Question(1, "assessing", "operator", "What now?", offers),),
    )


def outputs(code: str, *sentences: str, options: str = "") -> tuple[Output, ...]:
    """What goes out at the last of some typed sentences, while a question is open, with options of a language."""
    view, found = asking(STORED[options or code]["options"]), tuple[Output, ...]()
    dialogue = Dialogue(Settings(language=code), view)
    for at, text in enumerate(sentences, start=1):
        found = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=float(at)), view)
    return found


@pytest.mark.parametrize(("code", "option", "text"), ANSWERS)
def test_an_answer_in_own_words_is_read_back_and_counts_by_a_yes(code: str, option: str, text: str) -> None:
    assert not any(isinstance(each, Order) for each in outputs(code, text)), "it was given out at once"
    orders = [each for each in outputs(code, text, {"en": "yes", "de": "ja"}[code]) if isinstance(each, Order)]
    assert [(each.name, each.option) for each in orders] == [("answer", option)]


@pytest.mark.parametrize(("code", "before"), [("en", "if he moves,"), ("en", "do not"), ("de", "wenn er geht,")])
def test_nothing_is_an_answer_behind_a_condition_or_a_negation(code: str, before: str) -> None:
    clauses = (text for own, _, text in ANSWERS if own == code and not re.search(r"[,.] \w", text))
    for text in clauses:
        options = [each.data["order"].get("option") for each in outputs(code, f"{before} {text}") if is_read_back(each)]
        assert not options, text


@pytest.mark.parametrize("text", ["Nicht hupen", "Hup nicht", "Kein Hupen", "Bloß nicht hupen", "Nie wieder warten"])
def test_a_negation_before_or_behind_a_german_verb_leaves_no_answer(text: str) -> None:
    assert not any(map(is_read_back, outputs("de", text))), text


@pytest.mark.parametrize(("code", "form"), [
    ("en", "anything but {}"), ("en", "anything except {}"), ("en", "everything but {}"), ("en", "without {}"),
    ("en", "no {}ing"), ("en", "rather than {}"), ("en", "not {}"),
    ("de", "ohne zu {}"), ("de", "alles außer {}"), ("de", "alles, nur nicht {}"), ("de", "statt zu {}"),
])  # fmt: skip
def test_an_option_that_is_only_excepted_is_neither_read_back_nor_offered(code: str, form: str) -> None:
    for option in {"en": ("honk", "wait", "drive on", "horn"), "de": ("hupen", "warten", "umfahren")}[code]:
        found = outputs(code, form.format(option))
        assert not [each for each in found if isinstance(each, TalkNote) and each.kind == "read_back"], option
        assert not any(isinstance(each, Order) for each in found), option


@pytest.mark.parametrize("text", ["no horn", "No horn!", "no noise", "no signal please"])
def test_a_no_without_a_sign_behind_it_refuses_what_it_names(text: str) -> None:
    assert answered(outputs("en", text)) == []


@pytest.mark.parametrize(("code", "text", "place"), [
    ("en", "drive around it without honking", 1), ("en", "no, honk", 2),
    ("en", "honk... no, wait for it actually", 0), ("de", "umfahren ohne zu hupen", 1),
])  # fmt: skip
def test_what_an_exception_is_made_of_is_the_answer(code: str, text: str, place: int) -> None:
    assert answered(outputs(code, text)) == [list(STORED[code]["options"])[place]]


@pytest.mark.parametrize(("code", "text"), [
    ("en", "either wait or honk"), ("en", "honk or drive around it, you decide"), ("en", "wait or honk"),
    ("de", "entweder hupen oder umfahren"), ("de", "warten oder hupen, eins von beiden"),
])  # fmt: skip
def test_of_two_options_with_an_or_none_is_read_back(code: str, text: str) -> None:
    found = outputs(code, text)
    assert answered(found) == []
    assert any("option" in each.text or "Möglichkeit" in each.text for each in found if isinstance(each, Speech))


@pytest.mark.parametrize("text", ["wait", "Wait!", "wait please", "I would wait", "uh, wait I guess?"])
def test_the_name_of_an_option_that_is_an_order_to_pause_as_well_is_read_back_as_the_answer(text: str) -> None:
    assert answered(outputs("en", text)) == ["wait"]


@pytest.mark.parametrize("text", ["keep driving, it is only grass", "keep going", "just carry on mate", "proceed"])
def test_what_would_resume_a_run_that_is_not_paused_answers_a_question_that_offers_it(text: str) -> None:
    view = asking({"signal": "sound the horn", "cross": "drive on, over it", "skip_it": "take the next one"})
    found = Dialogue(Settings(), view).on_utterance(Utterance(text, "operator", "terminal", at=1.0), view)
    assert answered(found) == ["cross"]


@pytest.mark.parametrize(("text", "options"), [
    ("just drive on, it is grass", ["cross"]), ("honk and drive on", ["signal"]), ("honk", ["signal"]),
    ("wait", ["wait"]),
])  # fmt: skip
def test_an_option_with_all_that_is_asked_for_comes_before_one_with_a_part(text: str, options: list[str]) -> None:
    view = asking({"signal": "sound the horn and drive on", "cross": "drive on", "wait": "wait for a person"})
    found = Dialogue(Settings(), view).on_utterance(Utterance(text, "operator", "terminal", at=1.0), view)
    assert answered(found) == options


@pytest.mark.parametrize("text", ["How long would you have to wait?", "Why would you honk?", "When could you wait?"])
def test_a_question_about_an_option_does_not_ask_for_it(text: str) -> None:
    assert answered(outputs("en", text)) == []


@pytest.mark.parametrize("text", ["first second", "second first", "First the second", "1 2", "first... second"])
def test_two_places_of_options_without_a_joint_are_no_answer_until_it_is_confirmed(text: str) -> None:
    assert not any(isinstance(each, Order) for each in outputs("en", text)), "it was given out at once"


@pytest.mark.parametrize("joint", [", ", "? ", ". ", "... ", " and ", ", and then ", " then "])
@pytest.mark.parametrize("names", [("the first", "the second"), ("2", "1"), ("second", "first", "third")])
def test_two_options_for_one_question_are_no_answer_until_one_is_chosen(joint: str, names: tuple[str, ...]) -> None:
    sentence = joint.join(names)
    assert not any(isinstance(each, Order) for each in outputs("en", sentence)), "it was given out at once"
    assert not any(isinstance(each, Order) for each in outputs("en", sentence, "yes")), "a yes chose one of them"
    assert [each.name for each in outputs("en", f"stop, {sentence}") if isinstance(each, Order)] == ["stop"]


@pytest.mark.parametrize(("code", "option", "text"), sampled(CLAUSES, 4))
def test_a_fact_next_to_an_answer_leaves_it_one(code: str, option: str, text: str) -> None:
    for fact in FACTS[code]:
        for sentence in (f"{fact}, {text}", f"{text.rstrip('.!')}, {fact}."):
            assert answered(outputs(code, sentence)) == [option], sentence


@pytest.mark.parametrize(("code", "option", "text"), CLAUSES)
def test_the_words_of_others_are_no_answer(code: str, option: str, text: str) -> None:
    for form in OF_OTHERS[code]:
        assert answered(outputs(code, form.format(text))) == [], form


@pytest.mark.parametrize(("code", "option", "text"), ANSWERS)
def test_an_answer_may_be_in_another_language_than_the_options(code: str, option: str, text: str) -> None:
    place = list(STORED[code]["options"]).index(option)
    for other in set(CODES) - {code}:
        assert answered(outputs(code, text, options=other)) == [list(STORED[other]["options"])[place]]


def answered(outputs: tuple[Output, ...]) -> list[str]:
    """The options that are read back; none may be given out."""
    assert not any(isinstance(each, Order) for each in outputs)
    return [each.data["order"].get("option") for each in outputs if is_read_back(each)]  # type: ignore[union-attr]


def is_read_back(output: Output) -> bool:
    return isinstance(output, TalkNote) and output.kind == "read_back" and output.data["mapper"] == "grammar"


@pytest.mark.parametrize("code", CODES)
def test_other_talk_is_no_answer(code: str) -> None:
    talk = SENTENCES["talk"][code]
    found = [(text, each) for text in talk for each in outputs(code, text) if is_read_back(each)]
    answers = [text for text, each in found if each.data["order"]["order"] == "answer"]
    assert len(answers) <= MOST_READ_BACK * len(talk), answers


@pytest.mark.parametrize("code", CODES)
def test_without_a_question_nothing_is_an_answer(code: str) -> None:
    view = StatusView(run="r1", mode="running", mission="rows", robot="rob")
    for _, _, text in (each for each in ANSWERS if each[0] == code):
        found = Dialogue(Settings(language=code), view).on_utterance(
            Utterance(text, "operator", "terminal", at=1.0), view
        )
        assert not any(each.name == "answer" for each in found if isinstance(each, Order)), text
        assert all("option" not in (each or {}) for each in read_back(found)), text


DRONE = {
    "continue_inspection": "fly on to the next pole", "go_home": "fly back to the station",
    "land_now": "land here at once",
}  # fmt: skip
MEANT = {
    "en": {
        "carry on": "continue_inspection", "keep going": "continue_inspection",
        "continue but be careful": "continue_inspection", "bring it down": "land_now", "come down now": "land_now",
        "we should come home": "go_home", "just turn back": "go_home", "I would get it on the ground": "land_now",
    },
    "de": {
        "mach ruhig weiter": "continue_inspection", "flieg weiter zum nächsten": "continue_inspection",
        "komm sofort runter": "land_now", "am besten landen": "land_now", "dreh lieber um": "go_home",
        "du solltest zurückfliegen": "go_home",
    },
}  # fmt: skip


@pytest.mark.parametrize(("code", "text"), [(code, text) for code, texts in MEANT.items() for text in texts])
def test_to_continue_to_return_and_to_land_are_options_of_any_robot(code: str, text: str) -> None:
    dialogue, view = Dialogue(Settings(language=code)), asking(DRONE)
    found = dialogue.on_utterance(Utterance(text, "operator", "terminal", at=1.0), view)
    notes = [each.data["order"] for each in found if isinstance(each, TalkNote) and each.kind == "read_back"]
    assert not any(isinstance(each, Order) for each in found)
    assert [order.get("option") for order in notes] == [MEANT[code][text]]
