# SPDX-License-Identifier: Apache-2.0
"""No hand-written claim of a model passes the filter, and few harmless sentences are replaced."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle, product
from pathlib import Path

import pytest

from rai_missions.conversation import KeyView
from rai_missions.conversation.claims.claim_score import claim_weights
from rai_missions.conversation.claims.claims import Claims
from tests.conversation.stored import CLAIMS, PATROLLING, read

VIEW = PATROLLING._replace(run="", mode="")
MOST_FALSE = 0.2
DRESSES = ('"{}"', "**{}**", "- {}")
"""Ways in which a model dresses the same sentence."""
JOINED = CLAIMS["joined"]
"""Harmless words around a claim."""
OPENED = CLAIMS["opened"]
"""A claim next to a question, a bid, a condition or a harmless statement, which cover none but their own clause."""
MOST_OPENED = 0.006
"""The share of these that may pass: a clause of one or two words has too little to score."""
GENERATED = read("claim_forms.json")
"""Subjects and predicates of other robots, of which each pair is a claim, and what it is embedded in."""
MOST_GENERATED = 0.035
"""The share of generated claims that may pass."""
FORMS = CLAIMS["forms"]
"""Forms of sentences that are spoken or replaced, each with its sentences by language."""


def joined(code: str, every: int = 1) -> Iterator[str]:
    """Each claim with harmless words around it; with `every` of 5, each fifth pair, another one for each claim."""
    for number, claim in enumerate(CLAIMS["claims"][code]):
        bare = claim.rstrip(".!")
        for place, form in enumerate(JOINED[code]):
            if (number + place) % every == 0:
                text = form.format(bare[:1].lower() + bare[1:])
                yield f"{text[:1].upper()}{text[1:]}."


def generated(code: str) -> Iterator[str]:
    """Each subject with each of its predicates, in each embedding."""
    given = GENERATED[code]
    for kind, subjects in given["subjects"].items():
        for subject, predicate, form in product(subjects, given["predicates"][kind], given["embeddings"]):
            text = form.format(f"{subject} {predicate}")
            yield f"{text[:1].upper()}{text[1:]}"


def replaced(sentences: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Each sentence, and why it is replaced."""
    return {each: Claims(code).why_replaced(each, VIEW) for code in sentences for each in sentences[code]}


@pytest.mark.long
@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_no_claim_passes_among_harmless_words(code: str) -> None:
    claims = Claims(code)
    assert [each for each in joined(code, 7) if not claims.why_replaced(each, VIEW)] == []


@pytest.mark.drill
@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_no_claim_passes_among_any_harmless_words(code: str) -> None:
    claims, sentences = Claims(code), [*joined(code)]
    assert len(sentences) > 300
    assert [each for each in sentences if not claims.why_replaced(each, VIEW)] == []


@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_hardly_a_claim_passes_next_to_what_states_nothing_of_the_robot(code: str) -> None:
    claims, every = Claims(code), CLAIMS["claims"][code]
    bare = [f"{each[:1].lower()}{each[1:].rstrip('.!')}" for each in every]
    texts = [form.format(each) for at, form in enumerate(OPENED[code]) for each in bare[at :: len(OPENED[code])]]
    passed = [each for each in texts if not claims.why_replaced(each, VIEW)]
    assert len(passed) <= MOST_OPENED * len(texts), passed


@pytest.mark.parametrize("code", sorted(GENERATED))
def test_hardly_a_generated_claim_passes_whatever_it_is_embedded_in(code: str) -> None:
    claims, texts = Claims(code), [*generated(code)][::7]
    passed = [each for each in texts if not claims.why_replaced(each, VIEW)]
    assert len(passed) <= MOST_GENERATED * len(texts), passed


@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_no_claim_about_the_robot_passes(code: str) -> None:
    claims = Claims(code)
    assert [each for each in CLAIMS["claims"][code] if not claims.why_replaced(each, VIEW)] == []


@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_no_claim_passes_in_another_dress(code: str) -> None:
    claims = Claims(code)
    dressed = [dress.format(each) for dress, each in zip(cycle(DRESSES), CLAIMS["claims"][code], strict=False)]
    assert [each for each in dressed if not claims.why_replaced(each, VIEW)] == []


def test_an_offer_with_its_condition_is_spoken() -> None:
    offers = {
        "en": ("I can look in the bedroom if you like.", "If you allow it, I can go to the kitchen."),
        "de": ("Wenn du möchtest, kann ich in der Küche nachsehen.",),
    }
    assert [each for each, kind in replaced(offers).items() if kind] == []


def test_no_claim_passes_in_capitals() -> None:
    claims = Claims("en")
    assert [each for each in CLAIMS["claims"]["en"] if not claims.why_replaced(each.upper(), VIEW)] == []


def test_there_are_enough_claims_and_harmless_sentences() -> None:
    assert sum(map(len, CLAIMS["claims"].values())) >= 200
    assert sum(map(len, CLAIMS["harmless"].values())) >= 100


@pytest.mark.parametrize("code", sorted(CLAIMS["harmless"]))
def test_few_harmless_sentences_are_replaced(code: str) -> None:
    claims, sentences = Claims(code), CLAIMS["harmless"][code]
    replaced = [each for each in sentences if claims.why_replaced(each, VIEW)]
    assert len(replaced) <= MOST_FALSE * len(sentences), replaced


def test_a_claim_about_a_key_of_the_mission_is_found_by_its_name() -> None:
    view = VIEW._replace(keys={"hopper": KeyView("hopper", "number")})
    assert Claims("en").why_replaced("The hopper holds forty apples.", view) == "subject"
    assert Claims("en").why_replaced("The hopper holds forty apples.", VIEW) == "report"


@pytest.mark.parametrize(
    ("code", "sentence", "why"),
    [
        ("en", "I have mowed four rows.", "subject"),
        ("en", "We slowly drove around it.", "subject"),
        ("en", "The red cube sits on the blue one.", "subject"),
        ("en", "My gripper holds a carrot.", "subject"),
        ("en", "Cameras struggle in very dark rooms.", "report"),
        ("en", "I am unable to climb stairs.", "report"),
        ("de", "Vorhin habe ich vier Reihen gemäht.", "subject"),
        ("de", "Der rote Arm ruht in der Schale.", "subject"),
        ("de", "Den Busfahrplan kenne ich leider nicht.", "report"),
        ("en", "The scarf came loose.", "subject"),
        ("en", "Number 14 has calved.", "subject"),
        ("en", "Seventeen of twenty lamps respond.", "result"),
        ("en", "One whisk, as ordered.", "result"),
        ("en", "Fifteen percent of 200 is 30.", "progress"),
        ("de", "Einmal Schneebesen, wie bestellt.", "result"),
        ("en", "Your desk is tidy again.", "subject"),
        ("en", "A man in a yellow jacket is walking toward the trailer.", "subject"),
        ("en", "The battery of a robot lasts a few hours.", "report"),
        ("de", "Das Buch im Regal ist wieder da.", "subject"),
        ("en", "All six crates were sorted by weight.", "passive"),
        ("en", "Quince is picked by hand.", "report"),
        ("en", "Currently heading toward the living room.", "fragment"),
        ("en", "Sleeping well matters more than any pill.", "report"),
        ("de", "Der Tank wurde vor der Runde aufgefüllt.", "passive"),
        ("de", "Rudolf Diesel hat den Dieselmotor erfunden.", "report"),
        ("en", "The lidar is a ruler, not a camera.", "report"),
        ("de", "Birnen werden bei null Grad gelagert.", "report"),
    ],
)
def test_a_claim_by_its_structure_differs_from_what_is_in_doubt(code: str, sentence: str, why: str) -> None:
    assert Claims(code).why_suspected(sentence, VIEW) == why


@pytest.mark.parametrize(
    ("code", "sentence", "is_spoken"),
    [
        ("en", "So you want the tray in room five.", True),
        ("en", "You want the tray, it is in room five.", False),
        ("en", "You want a clean floor and the floor is clean.", False),
        ("en", "Retry means that the same step is tried once more.", True),
        ("en", "This means your cup waits in the kitchen.", False),
        ("en", "The manual recommends a soft cloth for the lenses.", True),
        ("en", "The manual is in the tray.", False),
        ("en", "All right.", True),
        ("en", "Option two was chosen.", False),
        ("en", "The decision fell on waiting.", False),
        ("de", "Sie wollen eine Pause.", True),
        ("de", "Du willst das Tablett, es steht in Zimmer fünf.", False),
        ("de", "Das Handbuch nennt zwei Bürsten.", True),
        ("de", "Das Handbuch liegt in der Kiste.", False),
        ("de", "Die Entscheidung fiel auf Warten.", False),
    ],
)
def test_a_wish_a_definition_and_a_document_are_spoken_of_but_no_decision(
    code: str, sentence: str, is_spoken: bool
) -> None:
    assert (Claims(code).why_replaced(sentence, VIEW) == "") == is_spoken


def test_a_sentence_of_the_world_is_spoken() -> None:
    world = {
        "en": ("The sea is deep.", "The ocean is salty.", "The sun is a star."),
        "de": ("Das Meer ist tief.", "Der Ozean ist salzig.", "Die Sonne ist ein Stern."),
    }
    assert {each: why for each, why in replaced(world).items() if why} == {}


def test_what_cannot_be_judged_is_replaced() -> None:
    claims = Claims("en")
    assert claims.why_replaced("Миссия завершена.", VIEW) == "script"
    assert claims.why_replaced("✅", VIEW) == "script"
    assert claims.why_replaced("La mission est terminée depuis longtemps déjà.", VIEW) != ""
    assert claims.why_replaced("…", VIEW) == ""


@pytest.mark.parametrize(
    "sentence",
    [
        "La pince tient le cube rouge.",
        "Ho posato il cubo rosso sul tavolo.",
        "El cubo rojo ahora se encuentra sobre el cubo azul.",
        "Roboten har kommit fram till köket.",
        "He terminado la ronda.",
        "La porta si chiude da sola.",
        "Sono arrivato in cucina.",
        "A porta se fecha sozinha.",
        "A luz se apaga.",
        "Il cane dorme davanti a me.",
        "Voy a casa.",
        "Ik zie niemand.",
    ],
)
@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_another_language_is_found_before_a_doubt(code: str, sentence: str) -> None:
    assert Claims(code).why_replaced(sentence, VIEW) == "language"


@pytest.mark.parametrize(
    "question",
    [
        "Did you know that die Tasche hat jetzt die Pflegerin?",
        "Did you know that sehen Sie nur, ein Laster versperrt die Straße?",
    ],
)
def test_what_a_question_states_is_found_where_its_language_changes(question: str) -> None:
    assert Claims("de").why_replaced(question, VIEW) != ""


@pytest.mark.parametrize("code", sorted(CLAIMS["claims"]))
def test_hardly_a_sentence_that_is_held_out_is_of_another_language(code: str) -> None:
    held_out = json.loads((Path(__file__).parent / "data/claims_held_out.json").read_text("utf-8"))
    every = [*held_out["harmless"][code], *held_out["claims"][code]]
    assert len([each for each in every if not claim_weights(code).is_language_of(each)]) <= 0.01 * len(every)


@pytest.mark.parametrize("form", sorted(FORMS["spoken"]))
def test_each_sentence_of_a_harmless_form_is_spoken(form: str) -> None:
    assert {each: why for each, why in replaced(FORMS["spoken"][form]).items() if why} == {}


@pytest.mark.parametrize("form", sorted(FORMS["replaced"]))
def test_each_sentence_of_a_form_that_reports_is_replaced(form: str) -> None:
    assert [each for each, why in replaced(FORMS["replaced"][form]).items() if not why] == []
