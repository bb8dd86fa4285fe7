# SPDX-License-Identifier: Apache-2.0
"""The page of a difference in a browser: what matters is reported first, leads to its place, and nothing of it runs."""

from __future__ import annotations

from typing import Any

import pytest

from tests.browser.conftest import Open, assert_accessible
from tests.browser.test_opening import OUTSIDE, PHONE, SCREEN, VIEW
from tests.visualize.changed import changed
from tests.visualize.diff.test_outputs import EVIL, evil
from tests.visualize.runs import tractor
from visualize import difference
from visualize.diff.page import page


@pytest.fixture
def window(opened: Open) -> Any:
    return opened(page(difference(tractor(), changed())))


def test_what_is_safety_relevant_is_reported_first_and_above(window: Any) -> None:
    found = difference(tractor(), changed())
    assert window.inner_text("#banner") == "⚠ 6 safety-relevant changes, 5 others"
    assert window.inner_text("#version") == "1.0.0 → 1.1.0"
    items = window.locator("#changes li")
    assert items.count() == len(found.changes)
    assert [items.nth(number).get_attribute("data-place") for number in range(6)] == [
        each.place for each in found.safety
    ]


def test_a_change_leads_to_its_place_and_its_place_reports_the_change(window: Any) -> None:
    window.click("#changes >> text=guard weakened")
    assert window.locator(".state.selected").get_attribute("data-state") == "assessing"
    assert "What changed here" in window.inner_text("#details")
    assert "obstacle.height_m < 0.25" in window.inner_text("#details .was >> nth=0")
    window.click("#tab-changes")
    assert window.is_visible("#changes")
    assert not window.is_visible("#details")
    window.click("#changes >> text=transition 'as soon as'")
    assert "/transitions/0/when" in window.inner_text("#details")


def test_what_changed_is_marked_without_colour(window: Any) -> None:
    window.click("#open-all")
    report = {mark: window.locator(f".state.{mark}").count() for mark in ("added", "removed", "changed")}
    assert report == {"added": 1, "removed": 1, "changed": 3}
    assert window.text_content("[data-state=reversing] .texts").startswith("+ ")
    dashes = "getComputedStyle(document.querySelector('.state.removed .form')).strokeDasharray"
    assert window.evaluate(dashes) != "none"


def test_a_switch_dims_all_that_is_not_for_review(window: Any) -> None:
    window.keyboard.press("s")
    lit = window.evaluate("[...document.querySelectorAll('.state.lit')].map((each) => each.dataset.state).sort()")
    assert lit == ["assessing", "driving", "returning", "working"]
    window.keyboard.press("d")
    assert "reversing" in window.evaluate("[...document.querySelectorAll('.state.lit')].map((e) => e.dataset.state)")


def test_a_transition_that_is_gone_has_its_own_definition(window: Any) -> None:
    window.evaluate("review.go('transition', 'was:/states/signalling/transitions/0')")
    assert '"fresh": "obstacle"' in window.inner_text("#details pre")


def test_texts_of_a_hostile_mission_are_texts(opened: Open) -> None:
    window = opened(page(difference(tractor(), evil())))
    assert EVIL in window.inner_text("#changes")
    assert window.locator("#changes a[href^=http], #changes img, #changes script").count() == 0


def test_an_address_leads_to_a_state_with_what_changed_there(opened: Open) -> None:
    window = opened(page(difference(tractor(), changed())), at="#state=driving")
    assert window.is_visible("#details")
    assert "'timeout_s' grew" in window.inner_text("#details")


@pytest.mark.parametrize("size", [SCREEN, PHONE], ids=["screen", "phone"])
def test_a_switch_moves_to_what_it_shows_below_a_legend_of_the_marks(size: dict[str, int], opened: Open) -> None:
    window = opened(page(difference(tractor(), changed())), viewport=size)
    assert window.evaluate("document.querySelector('#chart').getBoundingClientRect().height / innerHeight") >= 0.5
    words = " ".join(window.inner_text("#legend").split())
    assert words.startswith("+ added − removed ~ changed decision")
    strokes = "[...document.querySelectorAll('#legend .form')].slice(0, 3).map((each) => getComputedStyle(each).stroke)"
    assert len(set(window.evaluate(strokes))) == 3
    before = window.evaluate(VIEW)
    window.keyboard.press("s")
    assert window.evaluate(VIEW) != before
    assert window.evaluate(OUTSIDE, ["assessing", "driving"]) == []
    if size is SCREEN:
        sign, chart = (window.locator(each).bounding_box() for each in (".sign.any", "#chart"))
        assert sign["y"] >= chart["y"] and sign["x"] >= chart["x"], "a transition that changed leads away from it"
    window.keyboard.press("s")
    assert window.evaluate(VIEW) == before
    assert_accessible(window)
