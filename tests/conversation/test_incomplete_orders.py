# SPDX-License-Identifier: Apache-2.0
"""Orders that lack a value, come in two clauses, have their verb last, or are wanted no more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from rai_missions.conversation import Dialogue, Order, Speech, TalkNote, Utterance
from tests.conversation.judged import ordered
from tests.conversation.test_half_sentences import after, arguments
from tests.conversation.test_robots import robot


@pytest.mark.parametrize(("name", "text", "asked", "half", "expected"), [
    ("night_guard", "escort the cleaner", "Which door", "to the loading dock",
     {"task": "escort", "person": "the cleaner", "door": "loading dock"}),
    ("mast_drone", "could you photograph the lamp?", "Which mast", "of the old mast",
     {"task": "photograph", "part": "lamp", "mast": "old"}),
    ("solar_washer", "Wasch Reihe drei", "row_3", "mit 50 Litern", {"task": "wash", "row": "row_3", "litres": 50}),
    ("fruit_sorter", "label boxes", "count", "thirty", {"task": "label", "count": 30}),
    ("poolroboter", "gib Chlor ins Kinderbecken", "grams", "100 Gramm",
     {"task": "chlorine", "grams": 100, "pool": "kids"}),
    ("medikamentenwagen", "mach ein Fach auf", "drawer", "das dritte", {"task": "open", "drawer": 3}),
    ("window_cleaner", "wash the wing", "east wing", "the one in the east", {"task": "wash", "side": "east_wing"}),
    ("pallet_truck", "move P12", "Which bay", "bay two", {"task": "move", "pallet": "P12", "bay": "bay_2"}),
])  # fmt: skip
def test_what_an_order_lacks_is_asked_for_and_half_a_sentence_gives_it(
    name: str, text: str, asked: str, half: str, expected: Mapping[str, Any]
) -> None:
    spoken = " ".join(each.text for each in after(name, text) if isinstance(each, Speech))
    assert asked in spoken
    assert arguments(after(name, text, half)) == expected


@pytest.mark.parametrize("text", ["escort", "escort a rumour", "the cleaner", "watch the cleaner"])
def test_words_that_begin_no_order_with_its_values_lack_nothing(text: str) -> None:
    orders = ordered(after("night_guard", text, "to the loading dock"))
    assert all("person" not in each["arguments"] for each in orders)


@pytest.mark.parametrize(("name", "text", "expected"), [
    ("shelf_robot", "shelf three needs scanning", {"task": "scan", "shelf": "shelf_3"}),
    ("pool_cleaner", "the steps in the big pool need brushing", {"task": "brush", "part": "steps", "pool": "big pool"}),
    ("pool_cleaner", "the hot tub has to be vacuumed", {"task": "vacuum", "pool": "hot tub"}),
    ("fruit_sorter", "the green crate has to be emptied", {"task": "empty", "crate": "green"}),
    ("poolroboter", "könntest du den Filter leeren?", {"task": "filter"}),
    ("kitchen_arm", "give the counter a wipe", {"task": "wipe", "area": "counter"}),
    ("kitchen_arm", "give the counter a good cleaning", {"task": "wipe", "area": "counter"}),
    ("solar_washer", "Die vierte Reihe muss gewaschen werden", {"task": "wash", "row": "row_4"}),
    ("barista", "Die Düse muss mal gereinigt werden", {"task": "clean", "part": "nozzle"}),
])  # fmt: skip
def test_the_verb_of_an_order_may_be_behind_its_thing(name: str, text: str, expected: Mapping[str, Any]) -> None:
    assert arguments(after(name, text)) == expected


@pytest.mark.parametrize(("name", "text", "expected"), [
    ("medikamentenwagen", "öffne bitte das zweite Fach", {"task": "open", "drawer": 2}),
    ("fruit_sorter", "label a dozen boxes", {"task": "label", "count": 12}),
    ("fruit_sorter", "label two dozen boxes", {"task": "label", "count": 24}),
    ("gewaechshaus", "ernte mal den Salat", {"task": "pick", "plant": "lettuce"}),
    ("gewaechshaus", "pflück eine Tomate", {"task": "pick", "plant": "tomato", "count": 1}),
])  # fmt: skip
def test_a_number_has_its_forms_and_an_article_is_none_of_them(
    name: str, text: str, expected: Mapping[str, Any]
) -> None:
    assert arguments(after(name, text)) == expected


@pytest.mark.parametrize(("name", "text", "expected"), [
    ("linen_cart", "dann ab in die Wäschekammer", {"task": "park"}),
    ("sample_courier", "an die Ladestation", {"task": "charge"}),
    ("sample_courier", "rüber zur Notaufnahme", {"task": "drive", "place": "emergency"}),
    ("gate_helper", "over to security, please", {"task": "go", "place": "security"}),
    ("gate_helper", "back to your charger", {"task": "go", "place": "charger"}),
    ("gate_helper", "escort the family to gate 14", {"task": "escort", "passenger": "the family", "gate": 14}),
    ("museum_guide", "zeig uns das Mosaik", {"task": "show", "exhibit": "mosaic"}),
])  # fmt: skip
def test_a_direction_is_an_order_to_go_and_a_name_is_the_same_without_its_article(
    name: str, text: str, expected: Mapping[str, Any]
) -> None:
    assert arguments(after(name, text)) == expected


@pytest.mark.parametrize(("name", "text"), [
    ("gate_helper", "up to now it was quiet"), ("gate_helper", "back to work"),
    ("linen_cart", "zum Glück"), ("linen_cart", "nicht zurück in die Kammer"),
])  # fmt: skip
def test_other_words_of_direction_order_nothing(name: str, text: str) -> None:
    assert ordered(after(name, text)) == []


@pytest.mark.parametrize(("name", "text", "yes"), [
    ("gate_helper", "go to security", ("fine", "perfect", "yes, do", "go for it", "that's fine")),
    ("linen_cart", "desinfizier den Wagen", ("gut", "ja, gern", "alles gut", "perfekt")),
])  # fmt: skip
def test_more_words_confirm_what_was_read_back(name: str, text: str, yes: tuple[str, ...]) -> None:
    for each in yes:
        assert [order.name for order in after(name, text, each) if isinstance(order, Order)] == ["start"], each


def test_what_a_stop_has_dropped_before_a_yes_is_named_once_the_mission_resumes() -> None:
    given = ("go to security", "yes", "go to security, then go to the information desk", "stop")
    assert after("gate_helper", *given)[-1].text.startswith("Stop.")  # type: ignore[union-attr]
    *_, dropped = [each.text for each in after("gate_helper", *given, "resume") if isinstance(each, Speech)]
    assert "because of the stop" in dropped.lower() and "security" in dropped and "information" in dropped
    again = after("gate_helper", *given, "resume", "stop", "resume")
    assert not [each for each in again if isinstance(each, Speech) and "because" in each.text.lower()]


@pytest.mark.parametrize("text", ["my hair needs brushing", "the dog wants feeding", "shelf three needs painting"])
def test_what_needs_another_thing_is_no_order(text: str) -> None:
    assert ordered(after("shelf_robot", text)) == []


@pytest.mark.parametrize(("name", "text", "expected"), [
    ("barista", "Bring ihn an Tisch eins, den Tee", {"task": "serve", "drink": "tea", "table": "table_1"}),
    ("barista", "Die Milch muss geschäumt werden, zehn Sekunden", {"task": "steam", "steam_s": 10}),
    ("night_guard", "watch the yard, for ten minutes", {"task": "watch", "zone": "yard", "watch_min": 10}),
    ("barista", "Mach Jonas einen Tee", {"task": "brew", "drink": "tea", "guest": "Jonas"}),
    ("night_guard", "when you are done there, watch the lobby", {"task": "watch", "zone": "lobby"}),
])  # fmt: skip
def test_a_clause_behind_an_order_gives_what_it_lacks(name: str, text: str, expected: Mapping[str, Any]) -> None:
    assert arguments(after(name, text)) == expected


@pytest.mark.parametrize(("text", "kept"), [
    ("forget the lobby", ["yard"]), ("never mind the yard", ["lobby"]), ("forget the last one", ["yard"]),
    ("drop the first one", ["lobby"]), ("forget that", ["yard"]), ("forget the east wing", ["yard", "lobby"]),
    ("forget the requests", []),
])  # fmt: skip
def test_a_request_is_dropped_by_what_it_is_about(text: str, kept: list[str]) -> None:
    settings, view = robot("night_guard")
    dialogue = Dialogue(settings, view)
    for at, each in enumerate(("watch the yard", "yes", "watch the lobby", "yes", text), start=1):
        found = dialogue.on_utterance(Utterance(each, "operator", "terminal", "Eve", 4.0 * at), view)
    waiting = [each.data["requests"] for each in found if isinstance(each, TalkNote) and each.kind == "waiting"]
    left = waiting[-1] if waiting else ["yard", "lobby"]
    assert [each for each in ("yard", "lobby") if any(each in words for words in left)] == kept


def test_a_request_is_dropped_by_a_role_that_may_order_a_start_alone() -> None:
    settings, view = robot("night_guard")
    dialogue = Dialogue(settings, view)
    turns = (("watch the yard", "operator"), ("yes", "operator"), ("forget the yard", "viewer"))
    for at, (text, role) in enumerate(turns):
        found = dialogue.on_utterance(Utterance(text, role, "terminal", "Eve", 4.0 * at), view)  # type: ignore[arg-type]
    assert any(isinstance(each, TalkNote) and each.kind == "refused" for each in found)
    assert not any(isinstance(each, TalkNote) and each.kind == "dropped" for each in found)


@pytest.mark.parametrize(("text", "expected"), [
    ("the lobby too", {"zone": "lobby", "watch_min": 5}), ("the same for the lobby", {"zone": "lobby", "watch_min": 5}),
    ("no, the lobby", {}), ("the lobby", {}), ("the lobby instead", {}),
])  # fmt: skip
def test_what_another_person_ordered_is_repeated_and_never_corrected(text: str, expected: Mapping[str, Any]) -> None:
    settings, view = robot("night_guard")
    dialogue = Dialogue(settings, view)
    for at, (each, author) in enumerate((("watch the yard for 5 minutes", "Ann"), ("yes", "Ann"), (text, "Bob"))):
        found = dialogue.on_utterance(Utterance(each, "operator", "terminal", author, 4.0 * at), view)
    orders = [each["arguments"] for each in ordered(found) if each["arguments"].get("watch_min")]
    assert orders == ([{"task": "watch", **expected}] if expected else [])


@pytest.mark.parametrize(("name", "text"), [
    ("pool_cleaner", "Grandma used to brush my hair on the steps."), ("solar_washer", "In Reihe zwei war mein Chef."),
])  # fmt: skip
def test_no_order_is_offered_for_what_is_past(name: str, text: str) -> None:
    assert ordered(after(name, text)) == []
