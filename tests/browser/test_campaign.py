# SPDX-License-Identifier: Apache-2.0
"""The report of a campaign in a browser: filtered, sorted, opened, read on a phone; nothing of a store runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.campaign_report import write_report
from tests.browser.conftest import Open, assert_accessible
from tests.campaign.results import HOSTILE, SORTS, Sort, make_results

PHONE = {"viewport": {"width": 390, "height": 800}}
EVIL = (*SORTS[:2], Sort(HOSTILE[0], 0.2), Sort(HOSTILE[2], 0.2, "pictures"))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("report")
    store = make_results(folder / "a.db", scenes=60, sorts=EVIL, texts=HOSTILE, prompt=HOSTILE[1])
    return write_report(store, folder / "a.html")[0].read_bytes()


@pytest.fixture
def window(opened: Open, page: bytes) -> Any:
    return opened(page)


def cards(window: Any) -> list[str]:
    return [each.inner_text() for each in window.query_selector_all(".answer > summary")]


def test_nothing_of_a_store_runs_and_its_words_are_text(window: Any) -> None:
    assert window.title() == "campaign made"
    for card in window.query_selector_all(".answer > summary")[:3]:
        card.click()
    window.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    window.wait_for_selector(".answer .body")
    assert window.title() == "campaign made"
    assert HOSTILE[0] in window.inner_text("#accuracy")
    assert window.locator("#report script, #report iframe, #report a").count() == 0
    assert window.locator("#report img:not([src^='data:image/png;base64,'])").count() == 0


def test_the_first_figures_are_on_the_first_screen_of_a_phone(page: bytes, opened: Open) -> None:
    window = opened(page, **PHONE)
    first = window.evaluate("document.querySelector('#accuracy svg').getBoundingClientRect().bottom")
    assert first < PHONE["viewport"]["height"]
    assert "Wilson" not in window.inner_text("#overview")
    window.click("#overview summary")
    assert "Wilson" in window.inner_text("#overview")


def test_filters_leave_what_they_name_and_the_count_follows(window: Any) -> None:
    whole = window.inner_text("#found")
    window.select_option("#filter-model", f"={HOSTILE[0]}")
    window.select_option("#filter-kind", "=branch")
    found = cards(window)
    assert found and all("branch" in each and HOSTILE[0] in each for each in found)
    assert window.inner_text("#found") != whole and window.inner_text("#found").startswith(f"{len(found)} of ")
    window.fill("#filter-text", "no such words")
    assert cards(window) == [] and window.inner_text("#found").startswith("0 of ")


def test_the_order_is_the_one_that_is_chosen(window: Any) -> None:
    assert "harms, permitted by the rules" in cards(window)[0]
    window.select_option("#sort", "kind")
    kinds = [each.split()[0] for each in cards(window)]
    assert kinds == sorted(kinds)
    window.select_option("#sort", "slowest first")
    window.click(".answer > summary >> nth=0")
    slowest = float(window.inner_text(".answer .body p.muted >> nth=1").split("; ")[1].split(" s")[0])
    window.select_option("#sort", "most tokens first")
    assert slowest > 1.5, "of some hundred exponential times, the longest"


def test_more_are_shown_on_demand(window: Any) -> None:
    before = len(cards(window))
    window.click("#more")
    assert len(cards(window)) > before


def test_a_wrong_answer_opens_with_its_picture_facts_prompt_and_rollout(window: Any) -> None:
    window.click(".answer > summary >> nth=0")
    body = window.wait_for_selector(".answer .body")
    text = body.inner_text()
    assert "What physics finds of each option" in text and "force_n" in text and "(named)" in text
    assert "Facts" in text and "height_m 0.3" in text
    window.click(".answer .body summary >> text=Prompt")
    assert HOSTILE[1] in window.inner_text(".answer .body pre >> nth=0")
    assert window.evaluate("document.querySelector('.answer img').naturalWidth") == 24


def test_the_plots_show_the_shares_that_the_table_has(window: Any) -> None:
    labels = window.evaluate(
        "[...document.querySelectorAll('#accuracy tbody tr')].map((line) =>"
        " [line.querySelector('circle').getAttribute('cx'), line.cells[4].textContent])"
    )
    assert len(labels) == len(EVIL) + 4
    for place, share in labels:
        assert float(place[:-1]) == pytest.approx(1.5 + 0.97 * float(share.split()[0]), abs=0.1)


@pytest.mark.long
@pytest.mark.parametrize("more", [{}, PHONE], ids=["wide", "phone"])
def test_the_report_is_accessible_and_fits_its_window(opened: Open, page: bytes, more: dict[str, Any]) -> None:
    window = opened(page, **more)
    window.click(".answer > summary >> nth=0")
    assert window.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert_accessible(window)


def test_what_words_mean_has_the_width_of_a_phone(opened: Open, page: bytes) -> None:
    window = opened(page, **PHONE)
    window.click("#overview summary")
    widths = [each.bounding_box()["width"] for each in window.query_selector_all("dl.words dd") if each.is_visible()]
    assert widths and min(widths) > 300


@pytest.mark.parametrize("width", [1000, 1400])
def test_every_table_fits_its_card(opened: Open, tmp_path: Path, width: int) -> None:
    store = make_results(tmp_path / "a.db", scenes=20, sorts=SORTS)
    window = opened(write_report(store, tmp_path / "a.html")[0].read_bytes(), viewport={"width": width, "height": 900})
    boxes = "[...document.querySelectorAll('.scroll')].map((each) => [each.scrollWidth, each.clientWidth])"
    wide = window.evaluate(boxes)
    assert len(wide) > 3 and all(content <= box for content, box in wide)


def test_a_phone_shows_every_word_of_a_table_whole(opened: Open, tmp_path: Path) -> None:
    sorts = (Sort("constant:drive_over", 0.3), Sort("rules", 0.9), Sort("constant:drive_over", 0.3, "description"))
    store = make_results(tmp_path / "a.db", scenes=40, sorts=sorts)
    window = opened(write_report(store, tmp_path / "a.html")[0].read_bytes(), **PHONE)
    lines = """[...document.querySelectorAll('.scroll td')].flatMap((cell) => [...cell.childNodes]
        .filter((node) => node.nodeType === 3).flatMap((node) => [...node.data.matchAll(/\\S+/g)].map((word) => {
            const range = document.createRange();
            range.setStart(node, word.index);
            range.setEnd(node, word.index + word[0].length);
            return [word[0], new Set([...range.getClientRects()].map((box) => Math.round(box.top))).size];
        })))"""
    words = window.evaluate(lines)
    assert "constant:drive_over" in {word for word, _ in words}
    assert [word for word, lines in words if lines > 1] == []


def test_the_figures_are_there_without_a_script(browser: Any, page: bytes, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_bytes(page)
    context = browser.new_context(java_script_enabled=False, offline=True)
    window = context.new_page()
    window.goto(path.as_uri())
    assert window.locator("#accuracy circle").count() == len(EVIL) + 4
    context.close()
