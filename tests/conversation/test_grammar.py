# SPDX-License-Identifier: Apache-2.0
"""The grammar reads whole sentences, their numbers and small errors, and nothing inside other talk."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import KeyView, MissionView, StatusView
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.names import option_named
from rai_missions.conversation.grammar.senses import STOP, Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from rai_missions.conversation.language.phrases import Phrases, example_of
from rai_missions.engine.decision import Offer, Question
from rai_missions.errors import UsageError
from tests.conversation.stored import ARGUMENTS, SENTENCES

LAPS = KeyView("laps", "integer", "argument")
VIEW = StatusView(mode="running", mission="patrol", robot="rob", missions=(MissionView("patrol", "", (LAPS,)),))
ENGLISH = Grammar(language("en"))


@pytest.mark.parametrize("code", languages())
def test_each_sentence_that_stops_stops(code: str) -> None:
    grammar = Grammar(language(code))
    assert [each for each in SENTENCES["stops"][code] if grammar.senses(each, VIEW) != (STOP,)] == []


@pytest.mark.parametrize(
    ("robot", "sentence"),
    [("tractor1", "Stop, please, tractor"), ("tractor1", "tractor, stop!"), ("ROSbot XL, simulated", "rosbot stop"),
     ("ROSbot XL, simulated", "Stop, ROSbot XL")],
)  # fmt: skip
def test_a_robot_stops_by_each_name_that_people_call_it(robot: str, sentence: str) -> None:
    assert ENGLISH.senses(sentence, VIEW._replace(robot=robot)) == (STOP,)


@pytest.mark.parametrize("code", languages())
def test_an_order_inside_other_talk_is_none(code: str) -> None:
    grammar, asked = Grammar(language(code)), Question(1, "s", "operator", "?", (Offer("wait", "wait here"),))
    read = {
        each: grammar.senses(each, view)
        for each in SENTENCES["talk"][code]
        for view in (VIEW, VIEW._replace(questions=(asked,)))
    }
    orders = {each: senses for each, senses in read.items() if any(sense.kind == "order" for sense in senses)}
    assert orders == {}


@pytest.mark.parametrize("code", languages())
def test_each_question_and_order_is_read_as_what_it_means(code: str) -> None:
    grammar, view = Grammar(language(code)), VIEW._replace(keys={"battery": KeyView("battery", "number")})
    meant = {each: name for name, sentences in SENTENCES["meant"][code].items() for each in sentences}
    read = {each: [sense.name or sense.kind for sense in grammar.senses(each, view)] for each in meant}
    assert {each: names for each, names in read.items() if names != [meant[each]]} == {}


def slips(sentence: str) -> Iterator[str]:
    """The sentence with a slip of the keyboard in a short word: two letters exchanged, or one written twice."""
    words = sentence.lower().split()
    for at, word in enumerate(words):
        wrong = [word[:cut] + word[cut : cut + 2][::-1] + word[cut + 2 :] for cut in range(1, len(word) - 1)]
        wrong += [word[:cut] + word[cut - 1 :] for cut in range(1, len(word) + 1)] if len(word) == 3 else []
        if len(word) in (3, 4) and word.isalpha():
            yield from (" ".join([*words[:at], each, *words[at + 1 :]]) for each in wrong if each != word)


@pytest.mark.parametrize("code", languages())
def test_most_sentences_with_a_slip_in_a_short_word_mean_the_same_and_none_another_order(code: str) -> None:
    grammar, sentences = (
        Grammar(language(code)),
        [each for group in SENTENCES["meant"][code].values() for each in group],
    )
    meant = [(slip, grammar.senses(each, VIEW)) for each in sentences for slip in list(slips(each))[::7]]
    read = [(slip, senses, grammar.senses(slip, VIEW)) for slip, senses in meant]
    assert sum(senses == found for _, senses, found in read) >= 0.8 * len(read), len(read)
    orders = {slip: found for slip, senses, found in read if senses != found and found[:1] and found[0].kind == "order"}
    assert orders == {}


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize("words", ["drive over", "find another way around", "honk"])
def test_an_option_before_a_pronoun_is_that_option(code: str, words: str) -> None:
    """`Drive over it`: what the question is about; never another option, nor one that is not offered."""
    offers = (Offer("drive_over", "drive on, over the branch"), Offer("replan", "find another way around the branch"),
              Offer("signal", "honk and wait"))  # fmt: skip
    for pronoun in language(code).data["thing_pronouns"]:
        read = language(code).normaliser.words(words)
        meant = option_named(read, offers, language(code))
        named = option_named([*read, pronoun], offers, language(code))
        assert meant is not None and named is not None and named.offer == meant.offer
        assert named.is_partial or pronoun in language(code).articles
        assert option_named(["fly", pronoun], offers, language(code)) is None


@pytest.mark.parametrize(
    "sentence", ["stop the patrol", "pause the patrol", "cancel my patrol", "is the patrol running?"]
)
def test_the_name_of_the_running_mission_means_the_mission(sentence: str) -> None:
    (sense,) = ENGLISH.senses(sentence, VIEW)
    assert ENGLISH.senses(sentence.replace("patrol", "mission"), VIEW) == (sense,)
    others = VIEW._replace(mission="survey", missions=(*VIEW.missions, MissionView("survey")))
    assert ENGLISH.senses(sentence, others) == ()


@pytest.mark.parametrize("sentence", ["start the patrol again", "run the mission again"])
def test_a_mission_is_started_again_as_it_is_started(sentence: str) -> None:
    assert ENGLISH.senses(sentence, VIEW) == ENGLISH.senses("start the mission", VIEW)


@given(st.text(max_size=300))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_no_text_breaks_the_grammar_or_keeps_it_long(text: str) -> None:
    began = time.process_time()
    for each in (text, text * 20):
        ENGLISH.senses(each, VIEW)
    assert time.process_time() - began < 0.5


def test_a_faulty_phrase_is_refused_with_its_text() -> None:
    for phrase, why in {
        "(stop": "is not closed: '(' lacks its ')'",
        "stop (now]": "is not closed: ']' closes what is not open there",
        "stop]": "is not closed: ']' closes what is not open there",
        "find [the {object]": "is not closed: ']' closes what is not open there",
        "find {object": "is not closed: '{' lacks its '}'",
        "find {my object}": "has '{my object}', which is no name; it is one word of letters, digits",
        "find {2nd}": "has '{2nd}', which is no name; it is one word of letters, digits and '_' that begins",
        "find {object} or {object}": "has {object} twice; keep one",
    }.items():
        with pytest.raises(UsageError, match=re.escape(f"the phrase '{phrase}' {why}")):
            Phrases([phrase], {})
    with pytest.raises(UsageError, match="the phrase 'stop <it>' names no part: '<it>'; there is: robot"):
        Phrases(["stop <it>"], {"robot": "it"})


def test_no_phrases_fit_nothing_and_a_sign_ends_one() -> None:
    none, end = Phrases([], {}), Phrases(["the end $"], {})
    assert not any(test(words) for words in ([], ["stop"]) for test in (none.begin, none.within, none.fits))
    assert end.within(["at", "the", "end"]) and end.begin(["the", "end"])
    assert not end.within(["the", "end", "of", "it"]) and not end.begin(["the", "end", "of"])


@pytest.mark.parametrize(
    ("phrase", "example"),
    [
        ("(find|look for) {object} (in|at) {place}", "find … in …"), ("[please] put {rest}", "put …"),
        ("(go|drive) [and] (charge|[back] to (the|your) dock)", "go charge"), ("dock", "dock"),
        ("([back] to (the|your) dock|home)", "to the dock"), ("wait [here] [for <long>] * $", "wait …"),
    ],
)  # fmt: skip
def test_the_example_of_a_phrase_is_its_first_words(phrase: str, example: str) -> None:
    assert example_of(phrase) == example
    if "{" not in phrase and "<" not in phrase:
        assert Phrases([phrase], {}).fits(example.split())


def test_a_language_without_a_file_is_refused_with_those_that_have_one() -> None:
    with pytest.raises(UsageError, match="no language 'fr'; there is: de, en"):
        language("fr")


def test_every_language_has_the_same_tables_and_templates() -> None:
    first, *others = (language(code).data for code in languages())
    for other in others:
        assert other.keys() == first.keys()
        for table in ("texts", "questions", "orders", "modes", "claims", "happenings", "commands", "order_names"):
            assert other[table].keys() == first[table].keys(), table
        for name, text in first["texts"].items():
            if isinstance(text, str):
                assert set(_slots(other["texts"][name])) <= {*_slots(text), "name", "why"}, name


def _slots(text: str) -> list[str]:
    return [part.partition("}")[0] for part in text.split("{")[1:]]


HOUSE: dict[str, dict[str, str]] = {
    "(find|look for) {object}": {"task": "find", "place": "house"},
    "(find|look for) {object} in {place}": {"task": "find"},
    "wait [for] {wait_s} seconds": {"task": "wait"},
    "find {treasure} at sea": {},
}
PLACES = {"place": {"kitchen": "kitchen", "living room": "living_room"}}
ASSIST = MissionView("assist", "", (*ARGUMENTS, KeyView("wait_s", "integer", "argument")))
CALLED = {
    "Now find the cup, please.": {"task": "find", "place": "house", "object": "cup"},
    "can you look for the red cup in the living room": {"task": "find", "object": "red cup", "place": "living_room"},
    "wait for ten seconds": {"task": "wait", "wait_s": 10},
    "find the gold at sea": {"task": "find", "place": "house", "object": "gold at sea"},
}


@pytest.mark.parametrize("sentence", CALLED)
def test_a_sentence_of_the_robots_own_is_a_start_with_its_arguments(sentence: str) -> None:
    english = language("en")
    grammar = Grammar(english, StartPhrases(HOUSE, PLACES, english))
    [sense] = grammar.senses(sentence, VIEW._replace(missions=(ASSIST,)))
    assert (sense.name, sense.mission, sense.arguments) == ("start", "assist", CALLED[sentence])


def test_what_may_name_no_thing_is_no_value_of_a_text() -> None:
    english = language("en")
    grammar, view = Grammar(english, StartPhrases(HOUSE, PLACES, english)), VIEW._replace(missions=(ASSIST,))
    assert [grammar.senses(each, view) for each in ("Find out what the time is", "find where the cup is")] == [(), ()]


def test_an_order_that_is_corrected_at_once_is_the_order_of_both_sentences() -> None:
    english = language("en")
    grammar = Grammar(english, StartPhrases(HOUSE, PLACES, english))
    [sense] = grammar.senses("Find the cup in the kitchen. No, the living room!", VIEW._replace(missions=(ASSIST,)))
    assert (sense.kind, sense.arguments) == ("order", {"task": "find", "object": "cup", "place": "living_room"})


def test_a_value_that_an_argument_has_not_is_a_fault_and_no_other_sentence_is_tried() -> None:
    english = language("en")
    grammar = Grammar(english, StartPhrases(HOUSE, PLACES, english))
    view = VIEW._replace(missions=(ASSIST,))
    [sense] = grammar.senses("find the cup in the attic", view)
    assert sense.fault == "'attic' is no value for place: it must be kitchen or living room."
    assert grammar.senses("wait some seconds", view)[0].kind == "fault"
    assert [each.name for each in grammar.senses("wait, some seconds are missing", view)] == ["pause"]
    assert grammar.senses("find the cup in the attic", VIEW) == (), "of a mission that takes no such argument"
    assert [grammar.senses(each, view) for each in SENTENCES["stops"]["en"]] == [(STOP,)] * len(
        SENTENCES["stops"]["en"]
    )


INDIRECT = {
    "en": ("where are you", "where you are", "pause the mission"),
    "de": ("wo bist du", "wo du bist", "pausiere die mission"),
}


@pytest.mark.parametrize("code", languages())
def test_a_question_in_another_or_with_a_tag_is_that_question_and_nothing_else_is_one(code: str) -> None:
    direct, clause, other = INDIRECT[code]
    grammar, forms = Grammar(language(code)), language(code).data["indirect"]
    asked = {
        form: grammar.senses(example_of(form.replace("{question}", direct).replace("{clause}", clause)), VIEW)
        for form in forms
    }
    none = {
        form: grammar.senses(example_of(form.replace("{clause}", other)), VIEW) for form in forms if "{clause}" in form
    }
    assert {form: senses for form, senses in asked.items() if senses != (Sense("question", "where"),)} == {}
    assert {form: senses for form, senses in none.items() if any(each.kind == "order" for each in senses)} == {}


@pytest.mark.parametrize(
    ("code", "about", "question", "other"),
    [
        ("en", "how humid the air is", "how humid is the air?", "how humid is the cellar?"),
        ("en", "how wet the soil is, and how warm", "how warm is the soil", "how cold is the soil's owner"),
        ("de", "wie feucht die Luft ist", "wie feucht ist die Luft?", "wie feucht ist der Keller?"),
    ],
)
def test_a_key_is_asked_for_by_two_words_of_its_about_and_by_one_of_them_it_is_not(
    code: str, about: str, question: str, other: str
) -> None:
    view = VIEW._replace(keys={"measured": KeyView("measured", "number", "robot", about=about)})
    grammar = Grammar(language(code))
    assert grammar.senses(question, view)[0].key == "measured"
    assert all(each.key != "measured" for each in grammar.senses(other, view))
