# SPDX-License-Identifier: Apache-2.0
"""A mission played in a browser: clicked, answered, taken back, saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rai_missions.cli.play.page import ShownPlay
from rai_missions.cli.play.session import PlayFiles, PlaySession
from rai_missions.journal import read
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.replay.play import PlaySource
from tests.browser.conftest import assert_accessible, until
from visualize.live import JournalFeed, LivePage, PageAddress
from visualize.page import review

ROOT = Path(__file__).parents[2]
TRACTOR = ROOT / "missions/tractor/mission.json"
Look = Callable[..., Any]
WITHIN_S = 1.0


@contextmanager
def served(session: PlaySession) -> Iterator[LivePage]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    page = LivePage(PageAddress(port=0))
    page.start_play(session.play.mission, ShownPlay(session))
    try:
        yield page
    finally:
        page.stop()


def revision(window: Any, number: int) -> None:
    """Waits until the page shows what came of an order."""
    until(window, f"document.documentElement.dataset.revision === '{number}'")


def choose(window: Any, name: str) -> None:
    """Clicks a choice, and waits until the page shows what came of it."""
    before = int(window.evaluate("document.documentElement.dataset.revision"))
    window.click(f'[data-choice="{name}"]')
    revision(window, before + 1)


def names(window: Any) -> list[str]:
    return list(window.eval_on_selector_all("[data-choice]", "all => all.map(each => each.dataset.choice)"))


def lit(window: Any) -> list[str]:
    return sorted(window.eval_on_selector_all("g.state.active", "all => all.map(each => each.dataset.state)"))


def test_an_event_is_clicked_a_question_answered_a_choice_undone_and_the_play_saved(look: Look, tmp_path: Path) -> None:
    files = PlayFiles(PlaySource(TRACTOR), tmp_path / "p.journal", tmp_path / "test_p.py")
    session = PlaySession(load(TRACTOR), files)
    with served(session) as page:
        window = look(page)
        assert "start" not in names(window)
        window.fill('form:has([data-choice="readings"]) [data-field="battery"]', "0.8")
        choose(window, "readings")
        window.keyboard.press("1")  # the first choice: the start
        revision(window, 2)
        assert lit(window) == ["driving", "working"]
        assert "0.8, 0 s old" in window.inner_text('[data-key="battery"]')
        choose(window, "event anomaly")
        assert lit(window) == ["assessing"]
        choose(window, "control agent")
        assert "Something blocks the alley" in window.inner_text("[data-question]")
        assert_accessible(window)
        assert sorted(names(window)) == sorted({choice.name for choice in session.play.choices()})
        window.fill('[data-key="obstacle"] [data-field="obstacle.height_m"]', "0.1")
        choose(window, "answer 2 replan")
        assert lit(window) == ["replanning"]
        assert window.input_value('[data-key="obstacle"] [data-field="obstacle.height_m"]') == "0.1"
        window.click('[data-key="battery"] [data-choice="key battery"]')
        revision(window, 6)
        window.fill('[data-key="battery"] [data-field="battery"]', "full")
        window.click('[data-choice="key battery"]')
        until(window, "document.getElementById('notice').textContent.includes('is a number')")
        window.click("h1")
        window.keyboard.press("u")
        revision(window, 7)
        window.keyboard.press("u")
        revision(window, 8)
        assert lit(window) == ["assessing"]
        choose(window, "answer 2 abort")
        until(window, "document.getElementById('tab-path').textContent === 'Path (5)'")
        window.click("#save")
        revision(window, 10)
        assert "saved" in window.inner_text("#notice")
        other = look(page, viewport={"width": 390, "height": 844})
        assert other.evaluate("document.querySelector('header').getBoundingClientRect().height") < 80, "two lines"
        choose(other, "next")
        window.click('[data-choice="next"]')
        until(window, "document.getElementById('notice').textContent.includes('in another window')")
        revision(window, 11)
        window.click("#tab-path")
        window.click("#clicks li:nth-child(3) button")
        revision(window, 12)
        assert lit(window) == ["driving", "working"]
    (tmp_path / "p.html").write_bytes(review(load(TRACTOR), [tmp_path / "p.journal"]))
    played = look(SimpleNamespace(url=(tmp_path / "p.html").as_uri(), address=""))
    assert "played, no evidence" in played.inner_text("#player")
    assert played.inner_text("#player option").startswith("p.journal – played")
    with read(tmp_path / "p.journal") as record:
        assert record.header.played
        assert [step.event.name for step in record.steps()][:4] == ["start", "anomaly", "agent", "agent"]
    assert 'chart.propose(2, "abort", at=0.0)' in (tmp_path / "test_p.py").read_text(encoding="utf-8")


PLACE = "(({ top, height }) => [top, height])(document.querySelector('svg.chart').getBoundingClientRect())"
QUESTION_TOP = """(({ top }, frame) => top - frame.getBoundingClientRect().top)(
  document.querySelector("[data-question]").getBoundingClientRect(), document.querySelector("aside"))"""
MOVED = "document.querySelector('svg.chart > g').getAttribute('transform')"


@pytest.mark.parametrize("size", [(1440, 900), (1000, 700), (390, 844)])
def test_the_chart_stays_where_it_is_through_clicks_and_has_a_legend(size: tuple[int, int], look: Look) -> None:
    with served(PlaySession(load(TRACTOR))) as page:
        window = look(page, viewport=dict(zip(("width", "height"), size, strict=True)))
        assert "decision" in window.inner_text("#legend")
        before, moved = window.evaluate(PLACE), window.evaluate(MOVED)
        assert before[1] > 0.35 * size[1]
        for name in ("readings", "start", "event anomaly", "control agent", "answer 2 replan"):
            choose(window, name)
            assert window.evaluate(PLACE) == before, name
            if size[0] > 1400:
                assert window.evaluate(MOVED) == moved, "what is active was in view"
        assert window.evaluate("scrollY") == 0


def test_a_question_is_in_view_however_far_below_it_the_last_choice_was(look: Look) -> None:
    with served(PlaySession(load(TRACTOR))) as page:
        window = look(page, viewport={"width": 375, "height": 700})
        for name in ("readings", "start", "event anomaly"):
            choose(window, name)
        window.evaluate("document.querySelector('aside').scrollTo(0, 9999)")
        window.eval_on_selector('[data-choice="control agent"]', "each => each.click()")
        until(window, "document.querySelector('[data-question]')")
        assert window.evaluate(QUESTION_TOP) >= 0


def test_a_played_journal_is_shown_as_played_by_watch(look: Look, tmp_path: Path) -> None:
    session = PlaySession(load(TRACTOR), PlayFiles(journal=tmp_path / "p.journal"))
    for name in ("readings", "start"):
        session.play.do(name, {})
    session.save()
    feed = JournalFeed(tmp_path / "p.journal")
    page = LivePage(PageAddress(port=0))
    page.start(feed.mission, feed, None, {"played": feed.header.played})
    try:
        window = look(page)
        window.wait_for_selector("#mode[data-mode=cut]")
        assert window.inner_text("#mode") == "played"
        assert "Played" in window.inner_text("#state") and "no evidence" in window.inner_text("#state")
    finally:
        page.stop()


def large(states: int) -> Mission:
    """A mission in groups of 25 states, each with an action, and a way from each to the next."""
    groups: dict[str, Any] = {}
    for group in range(states // 25):
        inside: dict[str, Any] = {}
        for number in range(25):
            onward = f"s{group}_{number + 1}" if number < 24 else f"g{(group + 1) % (states // 25)}"
            inside[f"s{group}_{number}"] = {
                "action": "work",
                "timeout_s": 60,
                "transitions": [
                    {"on": "succeeded", "to": onward},
                    {"on": ["failed", "timed_out"], "to": f"s{group}_0"},
                ],
            }
        groups[f"g{group}"] = {"initial": f"s{group}_0", "states": inside}
    facts = {
        f"fact_{number}": {"type": "number", "source": "robot", "max_age_s": 2, "optional": True}
        for number in range(10)
    }
    return Mission.model_validate({
        "format": 1, "name": "large", "initial": "g0", "blackboard": facts, "events": {"stop": {}},
        "states": {**groups, "stopped": {"final": "aborted"}}, "transitions": [{"on": "stop", "to": "stopped"}],
    })  # fmt: skip


def test_a_click_is_drawn_within_a_second_among_500_states(look: Look) -> None:
    with served(PlaySession(large(500))) as page:
        window = look(page)
        choose(window, "start")
        longest = 0.0
        for number in range(1, 6):
            longest = max(longest, float(window.evaluate(CLICKED, f"goal {number} succeeded")))
        assert lit(window) == ["g0", "s0_5"]
        assert longest / 1000 < WITHIN_S


CLICKED = """name => new Promise((done) => {
  const before = document.documentElement.dataset.revision, since = performance.now();
  const look = () => document.documentElement.dataset.revision !== before
    ? requestAnimationFrame(() => done(performance.now() - since)) : setTimeout(look, 1);
  document.querySelector(`[data-choice="${name}"]`).click();
  look();
})"""
"""How long from a click until its frame is drawn, in milliseconds."""
