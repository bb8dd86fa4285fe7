# SPDX-License-Identifier: Apache-2.0
"""An order in a clause without a comma is read back where it addresses the robot; so is a question no fact answers."""

from __future__ import annotations

from itertools import product

import pytest

from rai_missions.conversation import (
    Dialogue,
    KeyView,
    MissionView,
    Order,
    Output,
    Settings,
    Speech,
    Utterance,
)
from rai_missions.conversation.language.language import language, languages
from rai_missions.planning.text.normalise import NEAREST as LEAST_MENDED
from tests.conversation.stored import ARGUMENTS, ASSISTING, read_back, settings_in

WAIT_S = KeyView("wait_s", "integer", "argument", minimum=1, maximum=3600)
REPORT = KeyView("report", "string", "robot", value="cup in the kitchen", age_s=0.1)
BATTERY = KeyView("battery", "number", "robot", value=0.7, age_s=0.1)
MISSIONS, FACTS = (MissionView("assist", "", (*ARGUMENTS, WAIT_S)),), {"report": REPORT, "battery": BATTERY}
VIEW = ASSISTING._replace(missions=MISSIONS, keys=FACTS)
PHRASES = {
    "en": {
        "(find|look for) {object}": {"task": "find"}, "go to {place}": {"task": "go"}, "go back to the dock": {},
        "wait {wait_s}": {"task": "wait"}, "where is {object}": {"task": "find"},
    },
    "de": {
        "(finde|suche) {object}": {"task": "find"}, "(gehe|fahre) in {place}": {"task": "go"}, "fahre heim": {},
        "warte {wait_s}": {"task": "wait"}, "wo ist {object}": {"task": "find"},
    },
}  # fmt: skip
PLACES = {
    "en": {"kitchen": "kitchen", "living room": "living"}, "de": {"küche": "kitchen", "hintere diele": "living"},
}  # fmt: skip
AHEAD = {
    "en": ("ok that is it for today", "dinner is nearly ready so robot", "I am home early today you may"),
    "de": ("gut das war es für heute", "das essen ist gleich fertig also roboter", "ich bin heute früh daheim"),
}
BEHIND = {"en": ("", "your battery is nearly empty", "you have time"), "de": ("", "dein akku ist fast leer")}
ORDERS = {
    "en": {"please go to the kitchen": {"task": "go", "place": "kitchen"}},
    "de": {"bitte fahr in die Küche": {"task": "go", "place": "kitchen"}},
}
OTHERS = {
    "en": (
        "I always go to the kitchen for your coffee", "the cat does not go to the kitchen please",
        "did you go to the kitchen already or not please", "you and I go to the kitchen before we eat your cake",
        "they go to the kitchen when you ask", "your sister wants to go to the kitchen later",
    ),
    "de": (
        "ich gehe in die Küche und du schläfst", "die Katze soll nicht mehr bitte gehe in die Küche",
        "wo warst du gehe ich in die Küche", "oma und ich gehe in die Küche wenn du kochst",
    ),
}  # fmt: skip


def replies(text: str, code: str) -> tuple[Output, ...]:
    """What a dialogue makes of a typed sentence."""
    return Dialogue(settings_in(code, PHRASES[code], PLACES[code]), VIEW).on_utterance(
        Utterance(text, "operator", "terminal"), VIEW
    )


def spoken(outputs: tuple[Output, ...]) -> str:
    """All that is spoken."""
    return " ".join(each.text for each in outputs if isinstance(each, Speech))


@pytest.mark.parametrize("code", languages())
def test_an_order_without_a_comma_before_it_is_read_back_and_not_given_out(code: str) -> None:
    wrong = dict[str, object]()
    for ahead, behind, (order, arguments) in product(AHEAD[code], BEHIND[code], ORDERS[code].items()):
        text = " ".join(filter(None, (ahead, order, behind)))
        if (found := read_back(replies(text, code))) != [arguments]:
            wrong[text] = found
    assert wrong == {}


@pytest.mark.parametrize("code", languages())
def test_what_is_stated_asked_negated_or_has_a_condition_is_no_order(code: str) -> None:
    assert {text: found for text in OTHERS[code] if (found := read_back(replies(text, code)))} == {}


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("en", "ok robot wait a thousand hours"),
        ("en", "please wait 5 minutes or 6 for your friend"),
        ("de", "gut du warte tausend Stunden"),
    ],
)
def test_a_number_is_never_cut_short(code: str, text: str) -> None:
    assert read_back(replies(text, code)) == []


@pytest.mark.parametrize(
    ("code", "text", "thing"),
    [
        ("en", "I put my cup down this morning, dear. Find it!", "cup"),
        ("en", "My ball is gone, find it first", "ball"), ("en", "lamp? find it", "lamp"),
        ("en", "the twins lost their ball. Find it!", "ball"),
        ("de", "Mein Ball ist weg, such ihn schnell", "ball"), ("de", "Lampe? Such die", "lampe"),
    ],
)  # fmt: skip
def test_a_pronoun_is_a_thing_that_a_fact_names_or_else_the_last(code: str, text: str, thing: str) -> None:
    assert read_back(replies(text, code)) == [{"task": "find", "object": thing}]


@pytest.mark.parametrize("text", ["find it anyway", "find it first please", "look for them now"])
def test_a_pronoun_with_more_words_is_no_thing(text: str) -> None:
    found = replies(text, "en")
    assert read_back(found) == [] and text.split()[-1] not in spoken(found)


@pytest.mark.parametrize(("code", "asked"), [("en", "where is my {thing}?"), ("de", "Wo ist mein {thing}?")])
def test_a_question_that_no_fact_answers_is_the_order_to_look_and_is_read_back(code: str, asked: str) -> None:
    assert read_back(replies(asked.format(thing="ball"), code)) == [{"task": "find", "object": "ball"}]
    known = replies(asked.format(thing="cup"), code)
    assert read_back(known) == [] and REPORT.value in spoken(known)


def test_where_the_robot_is_remains_a_question() -> None:
    bare = Dialogue(Settings(), VIEW).on_utterance(Utterance("where are you?", "operator", "terminal"), VIEW)
    own = Dialogue(Settings(phrases=PHRASES["en"]), VIEW).on_utterance(
        Utterance("where are you?", "operator", "terminal"), VIEW
    )
    assert spoken(own) == spoken(bare) != ""


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("en", "stop stop you are going to hit the cat"),
        ("en", "halt halt halt there is a child"),
        ("de", "stopp stopp da ist die Katze"),
    ],
)
def test_a_stop_that_is_cried_again_needs_no_comma(code: str, text: str) -> None:
    assert [each.name for each in replies(text, code) if isinstance(each, Order)] == ["stop"]


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("en", "Do you know where my ball is?"),
        ("en", "Could you show me where my ball is?"),
        ("de", "Weißt du, wo mein Ball ist?"),
    ],
)
def test_a_question_inside_another_is_the_order_to_look_as_well(code: str, text: str) -> None:
    assert read_back(replies(text, code)) == [{"task": "find", "object": "ball"}]


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("en", "It would be nice, if you went to the kitchen"),
        ("en", "you are needed, go to mum in the kitchen"),
        ("de", "Es wäre schön, wenn du in die Küche fahren könntest, da brauche ich dich"),
        ("de", "fahr in unsere gute Küche"),
    ],
)
def test_an_order_in_two_clauses_and_a_place_that_is_described_are_read_back(code: str, text: str) -> None:
    assert read_back(replies(text, code)) == [{"task": "go", "place": "kitchen"}]


@pytest.mark.parametrize(
    "text",
    [
        "go to the office next to the kitchen",
        "go to the living room or the kitchen",
        "It would be nice, if it went to the kitchen",
        "It would be nice, if you never went to the kitchen",
    ],
)
def test_a_place_of_which_another_may_be_meant_is_not_read_back(text: str) -> None:
    assert read_back(replies(text, "en")) == []


@pytest.mark.parametrize(
    ("code", "text", "wait_s"),
    [
        ("de", "warte eine Minute", 60),
        ("de", "Warte eine Minute, ich muss noch die Tür aufmachen", 60),
        ("en", "wait 2 minutes I am on the phone", 120),
    ],
)
def test_a_number_may_be_an_article_and_ends_where_another_subject_follows(code: str, text: str, wait_s: int) -> None:
    assert read_back(replies(text, code)) == [{"task": "wait", "wait_s": wait_s}]


def test_what_is_no_thing_corrects_none() -> None:
    assert read_back(replies("Find the book. No hurry.", "en")) == [{"task": "find", "object": "book"}]


@pytest.mark.parametrize(("code", "text"), [("en", "go to the livingroom"), ("de", "fahr in die hinterediele")])
def test_a_value_of_two_words_may_be_written_as_one(code: str, text: str) -> None:
    started = [each.arguments for each in replies(text, code) if isinstance(each, Order)]
    assert [*started, *read_back(replies(text, code))][0] == {"task": "go", "place": "living"}


@pytest.mark.parametrize(
    ("code", "text"), [("en", "is your battery enough for another round"), ("de", "wie lange reicht die battery noch")]
)
def test_a_question_that_no_rule_reads_gets_the_fact_that_it_names(code: str, text: str) -> None:
    assert "0.7" in spoken(replies(text, code)).replace(",", ".")


@pytest.mark.parametrize("code", languages())
def test_an_infinitive_at_the_end_is_an_order_where_the_language_has_such(code: str) -> None:
    text = {"en": "to the kitchen going", "de": "Bitte in die Küche fahren."}[code]
    found = read_back(replies(text, code))
    assert bool(found) == language(code).data["infinitive_orders"]


PLACED = {
    "en": ("come here", "please come over here", "can you come to me", "join us there"),
    "de": ("komm her", "komm bitte hierher", "kannst du dahin fahren"),
}
NAMING = {
    "en": ("we are all in the kitchen", "I cook in the kitchen today"),
    "de": ("wir sind alle in der Küche", "heute koche ich in der Küche"),
}
NAMELESS = {"en": ("we are all here", "I cook today"), "de": ("wir sind alle hier", "heute koche ich")}
UNSEEN = {"en": ("my ball is gone", "I lost my ball"), "de": ("mein ball ist weg", "ich habe meinen ball verloren")}
FOUND = {"en": ("find it", "look for it"), "de": ("suche ihn", "finde ihn")}


def found(text: str, code: str) -> list[dict[str, str] | None]:
    """The arguments of what is read back; None for what is given out."""
    return read_back(replies(text, code))


@pytest.mark.parametrize("code", languages())
def test_here_is_the_place_that_was_named_and_nothing_without_one(code: str) -> None:
    for order in PLACED[code]:
        kitchen = [found(f"{naming}{joint}{order}", code) for naming in NAMING[code] for joint in (", ", ". ")]
        assert kitchen == [[{"task": "go", "place": "kitchen"}]] * len(kitchen), order
        assert not any(found(f"{each}, {order}", code) for each in NAMELESS[code]), order


@pytest.mark.parametrize("code", languages())
def test_a_pronoun_at_the_end_is_what_its_clause_has_named(code: str) -> None:
    for statement, order in product(UNSEEN[code], FOUND[code]):
        (arguments,) = found(f"{statement} {order}", code)
        assert arguments is not None and "ball" in arguments["object"], (statement, order)


@pytest.mark.parametrize("code", languages())
def test_a_start_behind_a_statement_is_read_back_and_a_plural_subject_orders_nothing(code: str) -> None:
    statement, order = {
        "en": ("the kids are asleep", "go to the kitchen"),
        "de": ("der tisch ist gedeckt", "fahre in die küche"),
    }[code]
    assert found(f"{statement} {order}", code) == [{"task": "go", "place": "kitchen"}]
    assert not found({"en": "my kids go to the kitchen", "de": "wir fahren in die küche"}[code], code)


@pytest.mark.parametrize("code", languages())
def test_a_word_that_makes_a_number_less_exact_changes_no_value(code: str) -> None:
    wait = {"en": "wait {} ten seconds", "de": "warte {} zehn sekunden"}[code]
    for word in ("", *language(code).data["approximating"]):
        assert found(wait.format(word), code) == [{"task": "wait", "wait_s": 10}], word


@pytest.mark.parametrize("code", languages())
def test_a_listed_value_that_lacks_a_letter_is_that_value(code: str) -> None:
    go = {"en": "go to the {}", "de": "fahre in die {}"}[code]
    for name, value in PLACES[code].items():
        for at in range(1, len(name)) if len(name) > LEAST_MENDED else ():
            slip = name[:at] + name[at + 1 :]
            assert found(go.format(slip), code) == [{"task": "go", "place": value}] or slip == name, slip


WITHIN = {
    "en": {
        "it is getting dark {} the robot": ("pause", "cancel"),
        "dinner is ready please {} the mission": ("pause", "cancel"),
        "{} the mission we are done": ("pause", "cancel"),
    },
    "de": {
        "es ist schon dunkel {} bitte die mission": ("pausiere", "beende"),
        "das essen ist fertig also {}": ("pausiere",),
    },
}  # fmt: skip
QUOTED = {"en": "he shouted you should {}", "de": "er hat gesagt du sollst bitte {}"}


@pytest.mark.parametrize("code", languages())
def test_an_order_of_the_language_within_a_clause_is_read_back_and_one_of_others_is_none(code: str) -> None:
    for form, verbs in WITHIN[code].items():
        for verb in verbs:
            outputs = replies(form.format(verb), code)
            assert not any(isinstance(each, Order) for each in outputs), (form, verb)
            assert len(read_back(outputs)) == 1, (form, verb)
            quoted = replies(QUOTED[code].format(verb), code)
            assert not read_back(quoted), (form, verb)


RELAYED = {
    "en": {
        "go to the kitchen": (
            "Mila wants me to ask you to go to the kitchen", "my mum asks if you'd mind going to the kitchen",
        ),
        "pause": ("Dad would like you to pause", "Anna wants to know whether you could pause, please"),
    },
    "de": {
        "fahre in die Küche": (
            "Oma lässt fragen, ob du in die Küche fahren könntest", "Mila will, dass du in die Küche fährst",
        ),
        "pausiere": ("Henrik möchte, dass du pausierst", "Anna fragt, ob du pausieren kannst"),
    },
}  # fmt: skip


@pytest.mark.parametrize("code", languages())
def test_an_order_that_is_passed_on_is_read_back(code: str) -> None:
    for sentence, order in ((each, order) for order, sentences in RELAYED[code].items() for each in sentences):
        outputs = replies(sentence, code)
        assert not any(isinstance(each, Order) for each in outputs), sentence
        meant = [each or {} for each in read_back(replies(order, code))]
        assert read_back(outputs) == meant, sentence


RELAYED_STOPS = {
    "en": ("Mila wants you to stop", "my mum would like you to stop, please", "Dad wants me to get you to stop now"),
    "de": ("Mila will, dass du anhältst", "Oma möchte, dass du stehen bleibst"),
}
UNSTOPPED = {
    "en": ("no person wants you to stop", "who wants you to stop", "Mila wants you to stop by the kitchen"),
    "de": ("niemand will, dass du anhältst", "wer will, dass du anhältst"),
}


@pytest.mark.parametrize("code", languages())
def test_a_stop_that_is_passed_on_stops_at_once(code: str) -> None:
    ordered = {
        text: [each.name for each in replies(text, code) if isinstance(each, Order)]
        for text in (*RELAYED_STOPS[code], *UNSTOPPED[code])
    }
    assert ordered == {text: ["stop"] if text in RELAYED_STOPS[code] else [] for text in ordered}


REASONED = {
    "en": {
        "go to the kitchen{}": ("because the kettle boils", "so that we know it's quiet", "while my tea is hot"),
        "wait 60 seconds{}, then go back to the dock": ("since we are tired", "so I can rest", ", because it's late"),
        "look for the cup{}": ("because I want it", "cos my tea is cold"),
    },
    "de": {
        "fahre in die Küche{}": (", weil das Wasser kocht", "während wir essen", ", denn es ist spät"),
        "warte 60 Sekunden{}, dann fahre heim": (", damit ich ruhen kann", ", weil mir kalt ist"),
        "warte 60 Sekunden{}": ("während der Kessel kocht", "damit wir essen", "während meine Suppe kocht"),
    },
}  # fmt: skip
REASONED_ORDERS = {
    "en": ("go to the kitchen because you should find the cup", "cup"),
    "de": ("fahre in die Küche, weil ich will, dass du die Tasse suchst", "tasse"),
}


@pytest.mark.parametrize("code", languages())
def test_an_order_with_its_reason_is_the_order(code: str) -> None:
    for form, reasons in REASONED[code].items():
        meant = read_back(replies(form.format(""), code))
        assert meant and None not in meant, form
        for reason in reasons:
            sentence = form.format(reason if reason[0] == "," else f" {reason}")
            assert read_back(replies(sentence, code)) == meant, sentence


@pytest.mark.parametrize("code", languages())
def test_an_order_in_a_reason_is_not_lost(code: str) -> None:
    sentence, thing = REASONED_ORDERS[code]
    assert thing in " ".join(each.text for each in replies(sentence, code) if isinstance(each, Speech))
