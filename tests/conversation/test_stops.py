# SPDX-License-Identifier: Apache-2.0
"""A stop in alarm: letters drawn out, slips, and words that follow without a sign; other sentences stop nothing."""

from __future__ import annotations

from itertools import product

import pytest

from rai_missions.conversation import Dialogue, Order, Speech, Utterance
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import STOP
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from tests.conversation.stored import ASSISTING, PATROLLING, settings_in
from tests.conversation.test_robots import robot

STOPPING = {"en": ("stop", "halt", "freeze"), "de": ("stopp", "stop", "anhalten")}
ALARMS = {
    "en": ("you're gonna crash", "you will fall down the stairs", "there is a kid", "you will hit the cat"),
    "de": ("du fährst gleich dagegen", "da ist ein Kind", "sonst krachts"),
}
CRIES = {
    "en": (
        "you moron", "not there", "look out", "a child", "don't", "the kid's right there", "wrong room", "rob stop",
        "right there mister", "what the hell are you doing", "all of it", "my dog is behind you",
    ),
    "de": (
        "du Idiot", "falsche Richtung", "nicht dahin", "verdammt nochmal", "ein Kind", "was soll das", "Rob stopp",
        "mein Hund ist hinter dir",
    ),
}  # fmt: skip
JOINTS = {
    "en": ("", " so", " but", ", therefore", " but you have to", " so please"),
    "de": ("", " also", " aber", ", deshalb"),
}
BEHIND_TALK = {
    "en": (
        "that is cool but stop now", "wrong way stop", "my cat is in there stop", "it's going to fall stop please",
        "I like it but you have to stop", "the kitchen is nice but stop there", "it is getting dark stop the robot",
    ),
    "de": ("das ist toll aber stopp jetzt", "falsche Richtung stopp", "schön, aber halt an"),
}  # fmt: skip
NO_ORDER = {
    "en": (
        "I live near the bus stop", "we made a short stop", "the rain will stop", "it never seems to stop",
        "don't worry but don't stop", "the kids never stop", "I love music non stop", "is that a pit stop",
        "he is nice but stop signs annoy him", "if you see the cup come back but stop at the door",
        "where is the next stop", "you are so slow but don't stop", "what happens if I type stop",
        "freeze dried coffee",
    ),
    "de": (
        "wir machen einen kurzen Stopp", "ich fahre ohne Stopp", "das ist halt so", "ich bin halt müde",
        "der nächste Stopp", "ich mag das, aber hör nicht auf", "was passiert wenn ich Stopp schreibe",
    ),
}  # fmt: skip
OTHERWISE = {
    "en": (
        "at the kitchen", "by the shop on your way", "when you reach the dock", "talking", "being silly", "for lunch",
        "signs are red", "motion films are great", "is a word", "means stop", "every five minutes", "me if you know it",
        "he shouted", "or go?", "the world", "the rain from falling",
    ),
    "de": (
        "an der Tür", "neben dem Tisch", "wenn du den Becher siehst", "heißt anhalten", "Schilder sind rot",
        "erst in der Küche", "die Zeit", "mir die Welt",
    ),
}  # fmt: skip
HARM = {
    "en": (
        "you're on my foot", "you're crushing my toe!", "it's about to fall down the stairs", "it is about to fall",
        "stop now the nurse is in the way", "ouch my foot",
        "the cat!!",
        "the robot is going to hit the vase", "you'll hit it", "mind the baby!", "get off the rug", "back off",
        "that's enough", "switch it off", "shut it off, it's going crazy",
        "everybody freeze",
        "why won't you stop", "what are you doing, stop that thing", "I yelled stop, are you deaf?",
        "stop for goodness sake it's burning", "you stop", "watch where you're going", "stay right where you are",
        "it's going to run over the dog, someone halt that thing", "freeze for a bit",
        "Whoa this is a pretty narrow door, stop!", "Whoa, you are going to hit that beautiful vase",
        "whoa you almost hit my lovely vase", "whoa that is pretty close", "I mean stop again!", "stop again",
        "she is not looking, stop", "they were my mother's, she was like that, and STOP",
    ),
    "de": (
        "du stehst auf meinem Fuß", "du rammst gleich den Schrank", "gleich kippt die Vase um", "Aua, mein Fuß!",
        "das Kind!!", "weg von dem Kind", "aufhören", "schalt das ab", "stoppt das Ding",
        "rühr dich nicht", "Rühr dich nicht vom Fleck", "stoppt", "Not-Halt!", "Arm anhalten, mein Finger!",
        "Brr, steh!", "bitte nicht mehr bewegen", "sie guckt nicht, stopp",
        "kann den mal jemand anhalten", "du stehen bleiben", "Ich sagte stopp, hörst du nicht?",
        "Bleib mal kurz stehen", "Wow, stopp!", "Hui, das ist schön, halt an!", "Boah, du überfährst die Katze!",
    ),
}  # fmt: skip
"""Alarms without the word to stop at their beginning, and stops for a while: to stop is the safe reading of both."""
NO_HARM = {
    "en": (
        "it is going to rain", "you are killing me with these jokes", "you are on my list", "it will fall into place",
        "they will hit the road at nine", "Ouch, that was a bad joke", "that's enough sugar for me",
        "turn it down a bit",
        "why won't the rain stop?", "someone stop the music", "Whoa, that is a nice robot", "whoa this is cool",
        "Whoa, you look really great", "whoa what a pretty nice garden", "whoa, I like it", "whoa nice",
        "no, no, I like it", "my foot hurts today", "The cat is so cute!", "I shouted that we should stop at the shop",
        "he wanted to go but stopped", "it was fun but it has stopped", "she replied, stop", "they all yelled: stop",
        "it is about to fall asleep", "you are going to fall in love with it",
        "he is going to crash at my place tonight", "it is falling asleep", "switch off the tv please",
    ),
    "de": (
        "es wird regnen", "der Preis fällt", "Das Kind ist süß!", "ich habe genug Brot", "mach das Licht aus",
        "weg damit",
        "du bist auf dem richtigen Weg", "nein nein, ist gut", "ich sagte gestern, wir sollten anhalten",
        "kann jemand die Musik anhalten", "Autsch, der Witz war schlecht", "das bricht alle Rekorde",
    ),
}  # fmt: skip


def drawn_out(word: str) -> list[str]:
    """A word with each of its letters drawn out, in capitals, and cried thrice without a space."""
    longer = [word[:at] + word[at] * times + word[at + 1 :] for at in range(len(word)) for times in (3, 6)]
    return [*longer, *map(str.upper, longer), word * 3]


@pytest.mark.parametrize("code", languages())
def test_a_stop_that_is_drawn_out_is_the_stop_whatever_follows(code: str) -> None:
    grammar = Grammar(language(code))
    for stop, alarm in product(STOPPING[code], ("", *ALARMS[code])):
        cries = [f"{each} {alarm}".strip() for each in drawn_out(stop)]
        assert [each for each in cries if grammar.senses(each, ASSISTING) != (STOP,)] == []


@pytest.mark.parametrize("code", languages())
def test_a_stop_that_is_stuttered_is_the_stop(code: str) -> None:
    grammar = Grammar(language(code))
    begun = [f"{stop[:size]}-" for stop in STOPPING[code] for size in (1, 2, 3)]
    cries = [each + end for each in begun for end in STOPPING[code] if end.startswith(each[:-1])]
    cries += [f"{each[0]}-{each}!" for each in cries] + [each.replace("-", "- ").capitalize() for each in cries]
    assert [each for each in cries if grammar.senses(each, ASSISTING) != (STOP,)] == []
    assert STOP not in grammar.senses({"en": "non-stop", "de": "ha-ha"}[code], ASSISTING)


@pytest.mark.parametrize("code", languages())
def test_what_is_typed_and_begins_with_a_stop_stops(code: str) -> None:
    grammar, stop = Grammar(language(code)), STOPPING[code][0]
    cries = [f"{each} {cry}" for each in (stop, stop.upper(), stop[1] + stop[0] + stop[2:]) for cry in CRIES[code]]
    assert [each for each in cries if grammar.senses(each, ASSISTING) != (STOP,)] == []


@pytest.mark.parametrize("code", languages())
def test_what_is_typed_and_comes_to_a_stop_stops(code: str) -> None:
    grammar = Grammar(language(code))
    ends = [f"{alarm}{joint} {STOPPING[code][0]}" for alarm in ALARMS[code] for joint in JOINTS[code]]
    assert [each for each in (*ends, *BEHIND_TALK[code]) if STOP not in grammar.senses(each, ASSISTING)] == []
    assert [each for each in NO_ORDER[code] if STOP in grammar.senses(each, ASSISTING)] == []


@pytest.mark.parametrize("code", languages())
def test_a_stop_at_a_place_a_time_or_in_a_name_stops_nothing_now(code: str) -> None:
    grammar = Grammar(language(code))
    others = [f"{each} {rest}" for each in STOPPING[code][:1] for rest in OTHERWISE[code]]
    others += [f"{each.upper()} {rest}" for each in STOPPING[code][:1] for rest in OTHERWISE[code]]
    assert [each for each in others if STOP in grammar.senses(each, ASSISTING)] == []


@pytest.mark.parametrize("code", languages())
def test_an_alarm_that_is_typed_stops_and_talk_of_harm_stops_nothing(code: str) -> None:
    grammar = Grammar(language(code))
    assert [each for each in HARM[code] if STOP not in grammar.senses(each, ASSISTING)] == []
    assert [each for each in NO_HARM[code] if STOP in grammar.senses(each, ASSISTING)] == []


@pytest.mark.parametrize("text", [
    "because the floor is wet you should stop", "p-pause", "st-stop", "sto stop", "stop stop it's a child!!",
])  # fmt: skip
def test_a_stop_or_a_pause_that_is_typed_counts_at_once_and_nothing_of_it_is_named_as_left_out(text: str) -> None:
    found = Dialogue(settings_in("en", {}, {}), view=PATROLLING).on_utterance(
        Utterance(text, "operator", "terminal", "Eve", 1.0), PATROLLING
    )
    assert [each.name for each in found if isinstance(each, Order)] == ["pause" if "pause" in text else "stop"]
    assert not [each.text for each in found if isinstance(each, Speech) and "else" in each.text]


@pytest.mark.parametrize("channel", ["terminal", "page", "voice"])
def test_words_behind_a_stop_count_where_they_are_typed_alone(channel: str) -> None:
    """What is spoken may be read from a page, `stop viewer may`, or be for others; a stop of its own counts there."""
    for text, is_stop in {
        "stop you moron": channel != "voice",
        "you're on my foot": channel != "voice",
        "stop": True,
        "stop, you moron": True,
    }.items():
        dialogue = Dialogue(settings_in("en", {}, {}), view=PATROLLING)
        readings = (text, text) if channel == "voice" else ()
        sentence = Utterance(text, "operator", channel, "Eve", 1.0, readings=readings)
        outputs = dialogue.on_utterance(sentence, PATROLLING)
        assert [each.name for each in outputs if isinstance(each, Order)] == ["stop"] * is_stop, text


@pytest.mark.parametrize("code", languages())
def test_a_no_that_is_cried_again_and_again_stops_where_it_answers_nothing(code: str) -> None:
    no, order = {"en": ("no", "cancel the mission"), "de": ("nein", "brich die Mission ab")}[code]
    for before, times, name in (((), 3, ["stop"]), ((), 2, []), ((order,), 3, [])):
        dialogue = Dialogue(settings_in(code, {}, {}), view=PATROLLING)
        for at, text in enumerate((*before, " ".join([no] * times)), start=1):
            outputs = dialogue.on_utterance(Utterance(text, "operator", "terminal", "Eve", float(at)), PATROLLING)
        assert [each.name for each in outputs if isinstance(each, Order)] == name


def test_a_word_with_many_letters_of_a_kind_stays_where_no_known_word_is_in_it() -> None:
    grammar = Grammar(language("en"))
    for text in ("xxxx", "stoppppable", "www", "the busss"):
        assert STOP not in grammar.senses(text, ASSISTING), text


@pytest.mark.parametrize(("name", "text", "is_stop"), [
    ("brick_arm", "stop laying bricks", True), ("brick_arm", "please stop mixing", True),
    ("ice_groomer", "stop grooming the rink", True), ("brick_arm", "stop laughing", False),
    ("brick_arm", "stop worrying about the wall", False), ("brick_arm", "he will stop laying bricks soon", False),
])  # fmt: skip
def test_to_stop_what_the_robot_has_phrases_for_is_a_stop(name: str, text: str, is_stop: bool) -> None:
    settings, view = robot(name)
    found = Dialogue(settings, view).on_utterance(Utterance(text, "person", "terminal", at=1.0), view)
    assert ("stop" in [each.name for each in found if isinstance(each, Order)]) == is_stop


@pytest.mark.parametrize(("text", "is_typed", "stops"), [
    ("look out for the cup", True, False), ("look out for the red cup", True, False),
    ("look out for the cup!", True, True), ("look out for the cup", False, True),
    ("look out for the dog", True, True), ("watch out for the cup", True, True),
])  # fmt: skip
def test_an_order_to_look_for_what_is_listed_is_no_warning(text: str, is_typed: bool, stops: bool) -> None:
    settings = settings_in("en", {"find [the] {place}": {"task": "find"}}, {"cup": "cup"})
    grammar = Grammar(language("en"), StartPhrases(settings.phrases, settings.names, language("en")))
    assert (STOP in grammar.senses(text, ASSISTING, is_typed=is_typed)) == stops
