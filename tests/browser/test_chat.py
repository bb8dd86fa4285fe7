# SPDX-License-Identifier: Apache-2.0
"""The conversation on the live page: read, written in and steered by keys, on a desk and on a phone; never markup."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.browser.conftest import Look, assert_accessible, until
from tests.visualize.live.test_talk import MARKUP, TalkedRun, line
from tests.visualize.page.reading import HOSTILE
from tests.visualize.runs import tractor

PHONE = {"viewport": {"width": 390, "height": 780}, "has_touch": True, "is_mobile": True}


@pytest.fixture
def run() -> Iterator[TalkedRun]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with TalkedRun(tractor()) as made:
        made.start()
        yield made


def shown(window: Any) -> list[list[str]]:
    return window.evaluate(  # type: ignore[no-any-return]
        "[...document.querySelectorAll('#talk-lines .line')].map((each) => [each.querySelector('.who').innerText,"
        " each.querySelector('.text').innerText])"
    )


def test_each_line_shows_whose_it_is_and_by_which_way(run: TalkedRun, look: Look) -> None:
    window = look(run.page)
    run.feed.talk({"number": 1, "by": "operator", "author": "Anna", "channel": "page", "text": "what are you doing?"})
    run.feed.talk(line(2, "I drive alley 2 of 6."))
    run.feed.talk(line(3, "The weather is fine.", way="model"))
    run.feed.talk(line(4, "The mission has ended: succeeded.", priority="end", spoken="failed"))
    window.keyboard.press("c")
    until(window, "document.querySelectorAll('#talk-lines .line').length === 4")
    assert shown(window) == [
        ["operator Anna page", "what are you doing?"],
        ["robot by rule", "I drive alley 2 of 6."],
        ["robot the model thinks, unchecked", "The weather is fine."],
        ["robot by rule, not spoken: no one could be reached", "The mission has ended: succeeded."],
    ]
    assert_accessible(window)


def test_a_sentence_is_written_and_sent_by_keys_alone(run: TalkedRun, look: Look) -> None:
    window = look(run.page)
    window.keyboard.press("c")
    window.keyboard.type("stop")
    window.keyboard.press("Enter")
    until(window, "document.querySelector('#talk-text').value === ''")
    assert run.ear.received == [("stop", "")]
    window.keyboard.press("Escape")
    window.keyboard.press("c")
    assert window.evaluate("document.activeElement.id") == "talk-text"


def test_what_is_refused_is_reported_and_stays_in_the_field(run: TalkedRun, look: Look) -> None:
    run.ear.why = "64 sentences wait already"
    window = look(run.page)
    window.keyboard.press("c")
    window.keyboard.type("hello")
    window.keyboard.press("Enter")
    until(window, "document.querySelector('#notice').textContent.includes('64 sentences wait already')")
    assert window.input_value("#talk-text") == "hello"


def test_once_the_page_is_closed_no_sentence_is_taken_and_the_conversation_stays(run: TalkedRun, look: Look) -> None:
    window = look(run.page)
    run.feed.talk(line(1, "The mission has ended: succeeded."))
    window.keyboard.press("c")
    until(window, "document.querySelectorAll('#talk-lines .line').length === 1")
    run.page.stop()
    until(window, "document.querySelector('#talk-form').hidden")
    assert window.inner_text("#talk-none") == "This page is closed: it takes no more sentences."
    assert shown(window) == [["robot by rule", "The mission has ended: succeeded."]]
    window.keyboard.press("c")
    assert window.evaluate("document.activeElement.id") == "talk-lines"


@pytest.mark.parametrize("text", [MARKUP, *HOSTILE])
def test_no_line_is_markup(run: TalkedRun, look: Look, text: str) -> None:
    window = look(run.page)
    run.feed.talk({"number": 1, "by": "person", "author": text, "channel": text, "text": text})
    run.feed.talk(line(2, text, way=text, spoken=text))
    window.keyboard.press("c")
    until(window, "document.querySelectorAll('#talk-lines .line').length === 2")
    inside = "[...document.querySelectorAll('#talk-lines *')].map((each) => each.localName)"
    assert set(window.evaluate(inside)) <= {"div", "p", "b", "small"}


def test_a_line_that_is_not_seen_is_counted_on_the_tab(run: TalkedRun, look: Look) -> None:
    window = look(run.page)
    run.feed.talk(line(1, "I have begun."))
    until(window, "document.querySelector('#tab-talk').textContent === 'Talk (1)'")
    window.click("#tab-talk")
    until(window, "document.querySelector('#tab-talk').textContent === 'Talk'")


def test_in_a_window_made_smaller_the_newest_line_stays_in_view(run: TalkedRun, look: Look) -> None:
    window = look(run.page)
    for number in range(1, 40):
        run.feed.talk(line(number, f"line {number}, which is long enough to take two rows on a telephone's screen"))
    window.click("#tab-talk")
    until(window, "document.querySelectorAll('#talk-lines .line').length === 39")
    bottom = "(({scrollHeight, scrollTop, clientHeight}) => scrollHeight - scrollTop - clientHeight < 2)"
    at_end = f"document.querySelector('#talk-lines').scrollTop > 0 && {bottom}(document.querySelector('#talk-lines'))"
    until(window, at_end)
    window.set_viewport_size({"width": 420, "height": 700})
    until(window, f"innerWidth === 420 && {at_end}")
    window.evaluate("document.querySelector('#talk-lines').scrollTop = 100")
    window.set_viewport_size({"width": 900, "height": 500})
    until(window, "innerWidth === 900")
    assert not window.evaluate(at_end)  # who reads earlier lines stays there


def test_on_a_phone_the_field_and_the_newest_line_are_in_view(run: TalkedRun, look: Look) -> None:
    window = look(run.page, **PHONE)
    for number in range(1, 30):
        run.feed.talk(line(number, f"line {number}, which is long enough to take two rows on a telephone's screen"))
    window.tap("#tab-talk")
    until(window, "document.querySelectorAll('#talk-lines .line').length === 29")
    box = window.locator("#talk-text").bounding_box()
    until(window, "document.querySelector('#talk-lines').scrollTop > 100")
    last = window.locator("#talk-lines > :last-child").bounding_box()
    assert box["y"] + box["height"] <= 780 and box["height"] >= 40 and box["x"] + box["width"] <= 390
    assert last["y"] + last["height"] <= box["y"] + 1
    assert window.evaluate("document.documentElement.scrollWidth") <= 390
    assert_accessible(window)
