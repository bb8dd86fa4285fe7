# SPDX-License-Identifier: Apache-2.0
"""A wish in another form is the wish: a verb in two parts, a correction, an exception, what nothing is to lie on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from rai_missions.planning import Scene
from rai_missions.planning.reading import is_said, reading_of
from tests.planning.scenes import scene, thing

FLAT = scene(
    thing("tray", 0.6, 0.3),
    thing("bin", 0.6, -0.3),
    thing("red_cube", 0.4, 0.1, colour="red"),
    thing("blue_cube", 0.4, 0.2, colour="blue"),
    thing("green_cube", 0.4, -0.1, colour="green"),
    thing("apple", 0.3, 0.3),
    thing("carrot", 0.3, -0.3),
)
SIDE_M = next(each.size[2] for each in FLAT.things if each.name == "red_cube")
TOWER = scene(
    thing("tray", 0.6, 0.3),
    thing("bin", 0.6, -0.3),
    thing("red_cube", 0.4, 0.1, colour="red"),
    thing("blue_cube", 0.4, 0.1, colour="blue", level=SIDE_M),
    thing("green_cube", 0.4, -0.1, colour="green"),
    thing("apple", 0.62, -0.3, level=0.01),
)
SAME: Mapping[str, tuple[Scene, tuple[str, ...]]] = {
    "unstack the cubes": (TOWER, ("Take the whole tower apart.", "take the tower apart, please", "dismantle the tower",
                                  "Bau den Turm wieder ab.", "baue bitte den Turm ab")),
    "put the blue cube on the desk": (TOWER, (
        "take the blue cube down", "get the blue one down, please", "remove the blue cube from the red one",
        "take the blue cube down and put it on the desk", "make sure nothing is on top of the red cube",
        "Nothing on the red cube, please", "Nimm den blauen Würfel runter", "hol den blauen Würfel herunter",
        "Sorge dafür, dass nichts mehr auf dem roten Würfel liegt")),
    "put the green cube on the blue cube": (TOWER, (
        "put the green cube on the tower", "the green cube goes onto the tower", "Stell den grünen Würfel auf den Turm",
        "can the green cube go onto the blue one?", "kann der grüne Würfel auf den blauen?")),
    "put the apple in the tray": (TOWER, (
        "put the apple in the bin, no wait, in the tray", "put the apple in the bin – sorry, in the tray",
        "the carrot, sorry, put the apple in the tray", "put the apple in the tray instead of the bin",
        "put the apple in the tray rather than in the bin", "move whatever is in the bin over to the tray",
        "leg den Apfel in den Eimer, nein, aufs Tablett", "leg den Apfel aufs Tablett statt in den Eimer")),
    "put the green cube in the tray": (FLAT, (
        "red cube in the tray - sorry, I meant the green cube", "put the red cube in the tray, no wait, the green one",
        "den roten Würfel aufs Tablett, nein, den grünen")),
    "put the cubes in the tray, put the apple in the bin": (FLAT, (
        "tidy by kind: cubes in the tray, the apple in the bin", "clear the cubes away into the tray, apple in the bin",
        "all cubes in the tray, any order you like, and the apple in the bin")),
    "put the blue cube and the green cube in the tray": (FLAT, (
        "put the cubes except the red one in the tray", "put the cubes, except the red one, in the tray",
        "put all cubes in the tray, but not the red one", "put the cubes in the tray, except for the red one, please",
        "the cubes, excluding the red one, should go in the tray",
        "leg die Würfel aufs Tablett, aber nicht den roten", "alle Würfel, außer dem roten, aufs Tablett")),
    "put the blue cube, the green cube and the apple in the tray": (FLAT, (
        "put the cubes except the red one and the apple in the tray",
        "put the cubes, but not the red one, and the apple in the tray",
        "leg die Würfel außer dem roten und den Apfel aufs Tablett")),
    "put the blue cube and the green cube in the tray and the apple in the bin": (FLAT, (
        "put the cubes in the tray, except the red one, and the apple in the bin",)),
    "put the cubes and the carrot in the tray": (FLAT, (
        "put everything in the tray but the apple, please", "everything but the apple in the tray now")),
}  # fmt: skip
"""A plain wish → the scene, and other forms of it."""
ASKED: Mapping[str, Scene] = {
    "You put the apple in the tray?": FLAT, "du legst den Apfel in den Eimer?": FLAT, "leg den Apfel ab": FLAT,
    "nothing is on the red cube": TOWER, "put nothing on the red cube": TOWER, "the cubes stacked on the tray": FLAT,
    "auf dem roten Würfel liegt nichts": TOWER, "Kann der Turm stehen?": TOWER, "kann der Turm umfallen?": TOWER,
    "Kann der Turm auf dem Tisch stehen?": TOWER, "can the cubes be stacked?": FLAT,
    "can the red cube be on the blue cube?": FLAT, "put the green cube on the tower": FLAT,
    "put the red cube on the blue one, I mean the green cube": FLAT,
    "put the red cube on the blue cube, sorry, the green cube": FLAT,
    "put the cubes in the tray but the red one first": FLAT, "put the cubes in the tray but the red one too": FLAT,
    "put the cubes in the tray, but the red one": FLAT, "put the cubes in the tray, but the red one carefully": FLAT,
    "put everything in the tray but please the apple": FLAT, "put the cubes but the apple in the tray": FLAT,
    "put everything in the bin but the cubes on the tray": FLAT,
    "leg die Würfel aufs Tablett, aber nicht den roten zuerst": FLAT,
}  # fmt: skip
"""What asks, reports, or is open to two readings."""


@pytest.mark.parametrize(("form", "plain"), [(form, plain) for plain, (_, forms) in SAME.items() for form in forms])
def test_another_form_of_a_wish_has_its_goal(form: str, plain: str) -> None:
    seen = SAME[plain][0]
    found, wanted = reading_of(form, seen).goal, reading_of(plain, seen).goal
    assert found is not None and wanted is not None
    assert meanings(found) == meanings(wanted) and is_said(found, form, seen)


@pytest.mark.parametrize("text", ASKED)
def test_what_asks_or_reports_or_is_open_moves_nothing(text: str) -> None:
    assert reading_of(text, ASKED[text]).goal is None


def meanings(goal: Any) -> set[Any]:
    return {each.meaning for each in goal.all}
