# SPDX-License-Identifier: Apache-2.0
"""What a reader sees of the review page at first, on a screen and on a phone: a summary, all of the chart, its legend.

Rule: a page is opened once for each size and kind, and asked for all that is promised of it.
"""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.engine.trees import CompiledTrees
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.browser.conftest import Open, assert_accessible, until
from tests.browser.test_chart import NEARER
from tests.visualize.changed import changed
from tests.visualize.page.reading import answered
from tests.visualize.runs import ROOT, tractor
from visualize import difference
from visualize.diff.page import page as difference_page
from visualize.page import review, run_of_steps

SCREEN, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
OUTSIDE = """(names) => {
  const chart = document.querySelector('#chart').getBoundingClientRect();
  return names.filter((name) => {
    const box = document.querySelector(`.state[data-state="${name}"] .form`)?.getBoundingClientRect();
    return !box || box.left < chart.left || box.top < chart.top || box.right > chart.right || box.bottom > chart.bottom;
  });
}"""
"""Which states are not whole in the chart's window."""
BROKEN = """[...document.querySelectorAll('aside table')].flatMap((table) => {
  const words = document.createTreeWalker(table, NodeFilter.SHOW_TEXT), found = [];
  for (let text = words.nextNode(); text; text = words.nextNode()) {
    for (const { 0: word, index } of text.data.matchAll(/[^\\s-]+/g)) {
      const range = document.createRange();
      range.setStart(text, index);
      range.setEnd(text, index + word.length);
      if (new Set([...range.getClientRects()].map((each) => Math.round(each.top))).size > 1) found.push(word);
    }
  }
  return found;
})"""
"""Words in tables that are not on one line."""
CUT = "(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)(document.querySelector('aside'))"
"""How much of the panel is cut at its edge."""
SCROLLED = "document.querySelector('aside').scrollTop"
BAR = "document.querySelector('#bar').getBoundingClientRect().height"
SHARE = "document.querySelector('#chart').getBoundingClientRect().height / innerHeight"
VIEW = "(({ level, x, y, scale }) => [level, scale, x, y])(review.chart.viewpoint)"
"""How much is drawn, how large, and where."""


@pytest.fixture
def run_page() -> bytes:
    """The tractor's mission with a run whose first step does nothing but write."""
    first = Chart(tractor(), ticker=CompiledTrees()).write("battery", 0.8, at=0.0)
    return review(tractor(), runs=[run_of_steps([first, *answered(tractor())])])


def important(mission: Mission) -> list[str]:
    """The decisions and the ends."""
    return [name for _, name, state in mission.walk() if state.question()] + [
        name for name, state in mission.states.items() if state.word == "final"
    ]


@pytest.mark.parametrize("name", ["tractor", "rosbot"])
def test_a_page_opens_with_the_summary_all_of_the_chart_and_its_legend_in_one_screen(name: str, opened: Open) -> None:
    mission = load(ROOT / f"missions/{name}/mission.json")
    window = opened(review(mission), viewport=SCREEN)
    assert window.evaluate(OUTSIDE, important(mission)) == []
    assert window.get_attribute("#tab-summary", "aria-selected") == "true"
    summary = window.inner_text("#summary")
    assert summary.startswith(mission.about)
    order = [
        "What must never be false",
        "Where a model is asked",
        "no valid answer within",
        "How it may end",
        "proved by",
    ]
    assert [summary.index(words) for words in order] == sorted(summary.index(words) for words in order)
    proof = window.locator("#summary .end.succeeded p:has-text('proved by')").first.bounding_box()
    assert proof["y"] + proof["height"] <= SCREEN["height"]
    assert window.locator("#summary .end").count() == sum(state.word == "final" for state in mission.states.values())
    assert "control: agent" not in window.text_content("body")
    assert window.evaluate(BAR) < 50
    assert window.is_visible("#lenses")
    assert not window.is_visible("#menu")
    colours = window.evaluate(
        "[...document.querySelectorAll('#legend .form')].map((each) => getComputedStyle(each).stroke)"
    )
    assert len(set(colours)) >= 5
    assert "decision" in window.inner_text("#legend")
    window.click("#summary .end a >> nth=0")
    assert window.get_attribute("#tab-details", "aria-selected") == "true"
    window.press("#tab-details", "ArrowLeft")
    assert window.is_visible("#summary")
    assert_accessible(window)
    window.evaluate(NEARER)
    assert "controlled by the mission itself" in window.text_content("#chart")
    assert "asks the model, then" in window.text_content("#chart")


def test_a_switch_moves_to_what_it_shows_and_back(opened: Open) -> None:
    window = opened(review(load(ROOT / "missions/tractor/mission.json")), viewport=SCREEN)
    before = window.evaluate(VIEW)
    for key, states in (("m", ["assessing", "crossing", "given_up"]), ("o", ["assessing"]), ("i", ["crossing"])):
        window.keyboard.press(key)
        assert window.evaluate(OUTSIDE, states) == []
        assert window.evaluate(VIEW) > before, key
    window.keyboard.press("i")
    assert window.evaluate(VIEW) == before
    window.keyboard.press("m")
    assert window.inner_text("#lens h3 >> nth=0").startswith("assessing")
    assert_accessible(window)


def test_on_a_phone_the_chart_has_half_of_the_screen_and_the_bar_is_a_line_with_a_menu(
    run_page: bytes, opened: Open
) -> None:
    window = opened(run_page, viewport=PHONE)
    assert window.evaluate(BAR) < 50
    assert window.evaluate(SHARE) >= 0.5
    assert not window.is_visible("#lenses")
    assert window.evaluate(OUTSIDE, important(tractor())) == []
    for leave in (lambda: window.keyboard.press("Escape"), lambda: window.mouse.click(195, 800)):
        window.click("#menu")
        assert window.is_visible("#lenses")
        leave()
        assert not window.is_visible("#lenses")
    window.click("#menu")
    assert window.get_attribute("#menu", "aria-expanded") == "true"
    window.click("[data-lens=model]")
    assert not window.is_visible("#lenses")
    assert window.evaluate(OUTSIDE, ["assessing"]) == []
    assert window.evaluate(SHARE) >= 0.5
    for tab in ("summary", "details", "step", "transitions"):
        window.click(f"#tab-{tab}")
        assert window.evaluate(BROKEN) == []
        assert window.evaluate(CUT) <= 0, tab
        assert window.evaluate(SCROLLED) == 0, "another tab begins at its top"
        window.evaluate("document.querySelector('aside').scrollTo(0, 9999)")
    window.evaluate("review.go('state', 'assessing')")
    assert window.evaluate(SCROLLED) == 0, "and so does what is chosen"
    assert window.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert window.is_visible("#legend")
    assert_accessible(window)


def test_a_run_opens_at_the_first_step_that_did_something_and_is_played_in_a_tab_of_its_own(
    run_page: bytes, opened: Open
) -> None:
    window = opened(run_page, viewport=SCREEN, color_scheme="dark")
    until(window, "document.querySelector('.state.active')")
    assert window.get_attribute("#player output", "data-index") == "1"
    assert window.is_visible("#summary")
    assert "Runs" in window.inner_text("#summary")
    window.keyboard.press(">")
    assert window.is_visible("#step")
    until(window, "document.querySelector('#step table')")
    assert window.evaluate(BROKEN) == []
    assert_accessible(window)
    window.click("#tab-transitions")
    assert window.evaluate(BROKEN) == []
    assert window.evaluate(CUT) <= 0
    window.evaluate("review.go('state', 'assessing')")
    assert window.evaluate(BROKEN) == []
    assert_accessible(window)


@pytest.mark.parametrize("size", [SCREEN, PHONE], ids=["screen", "phone"])
def test_the_page_of_a_difference_has_the_same_bar_and_chart(size: dict[str, int], opened: Open) -> None:
    window = opened(difference_page(difference(tractor(), changed())), viewport=size)
    assert window.evaluate(BAR) < 50
    assert window.evaluate(SHARE) >= 0.5
    assert not window.is_visible("#tab-summary")
    assert_accessible(window)


def test_on_a_phone_a_long_name_leaves_the_search_and_the_menu_apart(opened: Open) -> None:
    mission = Mission.model_validate(
        tractor().written() | {"name": "inspection_of_the_whole_greenhouse_by_row", "about": ""}
    )
    window = opened(review(mission), viewport=PHONE)
    search, menu = (
        window.evaluate(f"(({{ left, right }}) => [left, right])({each}.getBoundingClientRect())")
        for each in ("document.querySelector('#search')", "document.querySelector('#menu')")
    )
    assert search[1] < menu[0]
    assert menu[1] <= PHONE["width"]
    assert window.inner_text(".purpose").startswith("What this mission is for is not written")
    assert window.text_content(".any .texts") == "From every state", "not cut"


def test_findings_beyond_a_few_are_folded_with_errors_before_warnings(opened: Open) -> None:
    states: dict[str, Any] = {
        f"s{number}": {"action": "go", "timeout_s": 1, "transitions": [{"on": "succeeded", "to": f"s{number + 1}"}]}
        for number in range(8)
    }
    states["s8"] = {"transitions": [{"after_s": 1, "to": "nowhere"}, {"after_s": 2, "to": "done"}]}
    document = {"format": 1, "name": "wrong", "initial": "s0", "states": states | {"done": {"final": "aborted"}}}
    mission = Mission.model_validate(document)
    window = opened(review(mission, findings=check(mission)), viewport=SCREEN)
    found = window.locator("#summary section:has(h3:text('Found by the check'))")
    assert "no state 'nowhere'" in found.locator("li").first.inner_text()
    seen, more = found.locator("> ul > li"), found.locator("details li")
    assert seen.count() == 5 and found.locator("summary").inner_text() == f"and {more.count()} more"
    assert not more.first.is_visible()
    found.locator("summary").click()
    assert more.last.is_visible()


def test_the_legend_explains_the_fallback_where_a_decision_has_one(opened: Open) -> None:
    window = opened(review(load(ROOT / "missions/tractor/mission.json")), viewport=SCREEN)
    key = window.locator("#legend li:has-text('fallback: without an answer') .form")
    fill = "(form) => getComputedStyle(form).fill"
    window.evaluate(NEARER)
    assert key.evaluate(fill) == window.locator(".cell.fallback rect").first.evaluate(fill)


@pytest.mark.parametrize(("mission", "has_it"), [("tractor/mission", True), ("rosbot/assist", False)])
def test_the_legend_explains_a_history_where_there_is_one(mission: str, has_it: bool, opened: Open) -> None:
    window = opened(review(load(ROOT / f"missions/{mission}.json")), viewport=SCREEN)
    assert ("H* back to where it left" in " ".join(window.inner_text("#legend").split())) is has_it
