# SPDX-License-Identifier: Apache-2.0
"""A person in front of the live page: what is asked, what stays in view, what is read aloud, and all of it by keys."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from tests.browser.conftest import Look, assert_accessible, until
from tests.browser.test_live import CUT, ask, see
from tests.visualize.live.conftest import OrderBox
from tests.visualize.live.stage import Run
from tests.visualize.runs import tractor

SCREEN, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
FACTS = {"answers": True}
REACHED = """() => ["[data-act=e_stop]", ".question .left", ...[...document.querySelectorAll(".offer > button")]
    .map((each) => `[data-option=${each.dataset.option}]`)].filter((each) => {
        const box = document.querySelector(each).getBoundingClientRect();
        const over = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
        return !over || !over.closest(each) || box.bottom > innerHeight;
    })"""
"""What of the e-stop, the time left and the answers is not in sight, or has something over it."""
SPOKEN = """() => {
    window.spoken = [];
    for (const host of ["polite", "urgent"].map((id) => document.getElementById(id)))
        new MutationObserver((all) =>
            spoken.push(...all.flatMap((each) => [...each.addedNodes]).map((each) => each.textContent)))
            .observe(host, { childList: true });
}"""
COVERED = """() => ["#bar h1", "#mode", "#control", "#line", "#menu", "#who", "#stop"].filter((each, at, all) => {
    const [here, next] = [each, all.slice(at + 1).find((one) => document.querySelector(one).offsetParent)]
        .map((one) => one && document.querySelector(one).getBoundingClientRect());
    return next && here.width && here.right > next.left;
})"""
"""What of the bar lies under its right neighbour."""
CUT_LINE = """(({ clientHeight, scrollHeight }, line) => scrollHeight > clientHeight && (clientHeight / line) % 1)(
    ...[".question .text"].map((each) => document.querySelector(each))
        .flatMap((each) => [each, parseFloat(getComputedStyle(each).lineHeight)]))"""
"""How much of the last line of a question that is cut is seen."""
AT = "(({ id, dataset, className }) => id || dataset.act || className.baseVal || '')(document.activeElement)"
LEAST = """(({ chart }) => Math.min(...[...document.querySelectorAll('.state > .texts text:first-child')]
    .map((each) => Number(each.getAttribute('font-size')) * chart.gestures.scale)))(live)"""
"""The smallest name of a state, in pixels of the screen."""
SEEN = """(name) => {
    const box = document.querySelector(`[data-state=${name}]`).getBoundingClientRect();
    const chart = document.querySelector("#chart").getBoundingClientRect();
    const [x, y] = [box.x + box.width / 2, box.y + Math.min(box.height, 60) / 2];
    return x > chart.left && x < chart.right && y > chart.top && y < chart.bottom;
}"""


@pytest.fixture
def asked() -> Iterator[Run]:
    """A run whose questions the page may answer."""
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(tractor(), OrderBox(), FACTS) as made:
        made.write("battery", 0.8)
        made.start()
        yield made


@pytest.mark.parametrize(("size", "scheme"), [(SCREEN, "light"), (PHONE, "dark")], ids=["screen", "phone"])
def test_the_time_and_the_answers_of_a_question_stay_in_view(
    size: dict[str, int], scheme: str, asked: Run, look: Look
) -> None:
    window = look(asked.page, viewport=size, color_scheme=scheme)
    bar = "document.querySelector('#bar').getBoundingClientRect().height"
    assert window.evaluate(bar) < 56
    ask(asked)
    window.wait_for_selector(".question.mine")
    until(window, "document.querySelector('.evidence canvas').width > 0")
    until(window, "!document.querySelector('.offer [aria-disabled=true]')")
    assert window.evaluate(REACHED) == []
    window.evaluate("document.querySelectorAll('body *').forEach((each) => each.scrollTo(0, 1e6))")
    assert window.evaluate(REACHED) == []
    picture, panel = (
        window.evaluate(f"document.querySelector('{each}').getBoundingClientRect().width")
        for each in (".evidence canvas", "#panel")
    )
    assert picture > 0.9 * panel
    assert window.evaluate("document.documentElement.scrollWidth") <= size["width"]
    assert window.evaluate(bar) < 56
    assert window.is_visible("#menu") == (size is PHONE)
    for width in (1500, 1241, 761, 400):
        window.set_viewport_size({"width": width, "height": size["height"]})
        assert window.evaluate(COVERED) == [], width
    window.set_viewport_size(size)
    asked.send("pause", "command", after_s=0.1, by="operator Anna (page)")
    window.wait_for_selector("#state[data-state=paused]")
    assert window.evaluate(REACHED) == []
    if size is PHONE:
        half = "document.querySelector('#chart').getBoundingClientRect().height / innerHeight"
        assert window.evaluate(half) >= 0.5
        window.click("#menu")
        assert window.is_visible("[data-act=take]") and window.is_visible("#follow")
        window.click("[data-act=cancel]")
        assert window.is_visible("[data-act=cancel]"), "it is asked twice"
        window.focus("#who")
        window.keyboard.press("Escape")
        assert window.is_hidden("#more") and window.evaluate("document.activeElement.id") == "menu"
    colours = "[...new Set([...document.querySelectorAll('#legend .form')].map((each) => getComputedStyle(each).fill))]"
    assert window.is_visible("#legend") and len(window.evaluate(colours)) >= 5
    assert_accessible(window)


def test_many_long_answers_with_fields_stay_in_view_on_a_phone_and_are_given_by_keys(look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    mission = tractor().written()
    decision = mission["states"]["assessing"]["decision"]
    decision["question"] = "Something blocks the alley, and it is not known what it is. " * 6
    more = ("wait_for_daylight", "call_the_neighbour", "look_again", "turn_around")
    for name in [*decision["options"], *more]:
        decision["options"].setdefault(name, {})["about"] = f"what '{name}' does takes a long sentence to describe " * 4
    schema = {"type": "object", "properties": {"alley": {"type": "integer"}}, "required": ["alley"]}
    decision["options"]["replan"]["parameters"] = schema
    mission["states"]["assessing"]["transitions"] += [{"on": name, "to": "aborted"} for name in more]
    sink = OrderBox()
    with Run(type(tractor()).model_validate(mission), sink, FACTS) as run:
        run.write("battery", 0.8)
        run.start()
        window = look(run.page, viewport=PHONE)
        ask(run)
        window.wait_for_selector(".question.mine")
        assert window.locator(".offer > button").count() == 8
        assert 0.3 < window.evaluate(CUT_LINE) < 0.7, "a touch screen has no scrollbar: half a line shows what follows"
        assert window.evaluate(REACHED) == []
        assert window.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        until(window, "document.querySelector('[data-option=replan]').getAttribute('aria-disabled') === 'false'")
        window.focus("[data-option=replan]")
        window.keyboard.press("Enter")
        assert window.evaluate("document.activeElement.name") == "alley", "its fields open, and the keyboard is in them"
        window.keyboard.press("Enter")
        assert "'alley' is needed" in window.inner_text("#notice")
        window.keyboard.type("4")
        window.keyboard.press("Enter")
        until(window, "document.querySelector('#notice').textContent.includes('done')")
        assert [json.loads(text)["parameters"] for text in sink.orders] == [{"alley": 4}]
        run.send("pause", "command", after_s=0.1, by="operator " + "with a long name " * 6)
        window.keyboard.press("Escape")
        window.focus("[data-option=replan]")
        window.keyboard.press("Enter")
        window.wait_for_selector("#state[data-state=paused]")
        assert window.evaluate(REACHED) == []
        window.click(".meanings summary")
        assert "'turn_around' does takes" in window.inner_text(".meanings")


def test_follow_is_on_and_keeps_what_is_active_in_view_until_the_chart_is_moved(asked: Run, look: Look) -> None:
    window = look(asked.page, viewport=PHONE)
    assert window.get_attribute("#follow", "aria-pressed") == "true"
    until(window, f"({SEEN})('driving')")
    ask(asked)
    until(window, f"({SEEN})('assessing')")
    assert window.evaluate(LEAST) >= 11, "followed, but not as small as all of its details would be"
    box = window.locator("#chart").bounding_box()
    window.mouse.move(box["x"] + 200, box["y"] + 30)
    window.mouse.down()
    window.mouse.move(box["x"] + 200, box["y"] + 400, steps=4)
    window.mouse.up()
    assert window.get_attribute("#follow", "aria-pressed") == "false"
    moved = window.evaluate("[live.chart.gestures.x, live.chart.gestures.y]")
    number = asked.steps[-1].question.number
    asked.send("operator", "proposal", number, after_s=0.1, option="signal", by="operator")
    window.wait_for_selector("[data-state=signalling].active", state="attached")
    assert window.evaluate("[live.chart.gestures.x, live.chart.gestures.y]") == moved
    window.keyboard.press("l")
    until(window, f"({SEEN})('signalling')")
    assert window.get_attribute("#follow", "aria-pressed") == "true"


def test_paused_stopped_and_ended_stay_in_view_with_their_reason_also_for_who_comes_later(
    asked: Run, look: Look
) -> None:
    window = look(asked.page, viewport=SCREEN)
    window.wait_for_selector("[data-state=driving].active", state="attached")
    assert window.is_hidden("#state")
    asked.send("pause", "command", after_s=0.5, by="operator Anna (page)")
    window.wait_for_selector("#state[data-state=paused]")
    late = look(asked.page, viewport=PHONE, color_scheme="dark")
    for each in (window, late):
        each.wait_for_selector("#state[data-state=paused]")
        assert "Paused by operator Anna (page) at 1.5 s" in " ".join(each.inner_text("#state").split())
    window.click("#state [data-act=resume-here]")
    until(window, "document.querySelector('#notice').textContent.startsWith('resume: done')")
    assert [json.loads(text)["command"] for text in asked.sink.orders] == ["resume"]
    asked.send("resume", "command", after_s=0.5)
    window.wait_for_selector("#state", state="hidden")
    asked.send("kill", "command", after_s=0.5, by="operator Anna (page)")
    window.wait_for_selector("#state[data-state=e_stop]")
    for each in (window, late):
        until(each, "document.querySelector('#state').dataset.state === 'e_stop'")
        words = " ".join(each.inner_text("#state").split())
        assert words.startswith("■ E-stop by operator Anna (page) at 2.5 s: the mission ended aborted")
        assert each.inner_text("[data-act=e_stop]") == "E-STOP"
    window.click("#tab-journal")
    assert "e-stop by operator Anna (page)" in window.inner_text("#steps li:first-child")
    assert "kill" not in window.inner_text("body")
    assert_accessible(late)


def test_questions_and_ends_are_read_aloud_once_and_answered_by_keys_alone(asked: Run, look: Look) -> None:
    window = look(asked.page)
    window.evaluate(SPOKEN)
    ask(asked)
    window.wait_for_selector(".question.mine")
    until(window, "!document.querySelector('.offer [aria-disabled=true]')")
    see(asked, "dog", 1.0)
    window.evaluate(CUT)
    until(window, "seen.includes('away')")
    window.wait_for_selector("[data-line=live]")
    counts = "document.querySelector('.left').closest('[aria-live]:not([aria-live=off]), [role=status], [role=alert]')"
    assert window.evaluate(f"{counts} === null"), "the time left is in no region that is read aloud"
    window.keyboard.press("q")
    assert window.evaluate("document.activeElement.dataset.option") == "drive_over", "the first that may be given"
    window.keyboard.press("Tab")
    window.keyboard.press("Enter")
    until(window, "document.querySelector('#notice').textContent.startsWith('answer')")
    order = json.loads(asked.sink.orders[0])
    assert (order["command"], order["option"]) == ("answer", "replan")
    asked.send("operator", "proposal", order["question"], after_s=0.1, option="replan", by="operator")
    window.wait_for_selector(".question", state="detached")
    assert window.evaluate("document.activeElement.id") == "asked", "the keyboard keeps its place"
    asked.send("kill", "command", after_s=0.1, by="operator")
    window.wait_for_selector("#state[data-state=e_stop]")
    spoken = window.evaluate("spoken")
    questions = [each for each in spoken if each.startswith("You are asked: Something blocks the alley")]
    assert len(questions) == 1 and "Answers: drive_over, replan, signal, abort" in questions[0], spoken
    assert len([each for each in spoken if each.startswith("E-stop by operator")]) == 1, spoken
    assert not [each for each in spoken if "s ago" in each]


def test_a_person_who_listens_is_reminded_once_and_an_end_by_rule_states_its_rule(look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    mission = tractor().written()
    mission["states"]["assessing"]["decision"]["deadline_s"] = 90
    with Run(type(tractor()).model_validate(mission), OrderBox(), FACTS) as run:
        run.write("battery", 0.8)
        run.start()
        window = look(run.page)
        window.evaluate(SPOKEN)
        ask(run)
        window.wait_for_selector(".question.mine")
        question = run.steps[-1].question
        assert question is not None
        while question.until - run.chart.at > 9.0:
            run.send("battery", "write", after_s=4.0, value=0.8)
        until(window, "spoken.some((each) => each.includes('10 s left'))")
        window.evaluate("live.tick(), live.tick()")
        assert len([each for each in window.evaluate("spoken") if "10 s left" in each]) == 1
        assert "short" in (window.get_attribute(".question .left", "class") or "")
        run.send("cancel", "command", after_s=0.1, by="operator")
        window.wait_for_selector("#state[data-state=canceled]")
        assert "Ended: canceled" in window.inner_text("#state")
        assert "canceled by operator" in window.inner_text("#state")


def test_every_part_of_the_page_is_reached_by_keys(asked: Run, look: Look) -> None:
    window = look(asked.page, viewport=SCREEN)
    window.wait_for_selector("[data-state=driving].active", state="attached")
    reached = set()
    for _ in range(60):
        window.keyboard.press("Tab")
        reached.add(window.evaluate(AT))
    wanted = {"who", "pause", "cancel", "take", "e_stop", "follow", "fit", "help", "chart", "legend", "tab-now"}
    assert wanted <= reached
    asked.send("operator", "control", after_s=0.1, by="operator", role="operator")
    window.wait_for_selector("[data-act=autonomy]")
    assert window.inner_text("#control") == "operator" and window.inner_text("[data-act=agent]") == "give to mission"
    assert window.evaluate("document.querySelector('#bar').getBoundingClientRect().height") < 56
    assert (
        window.evaluate("(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)(document.querySelector('#bar'))")
        == 0
    )
    window.focus("#tab-now")
    window.keyboard.press("ArrowRight")
    assert window.is_visible("#journal") and window.evaluate("document.activeElement.id") == "tab-journal"
    window.focus("svg.chart")
    window.keyboard.press("n")
    window.keyboard.press("n")
    assert window.locator(".state.selected").get_attribute("data-state") == "driving"
    scale = window.evaluate("live.chart.gestures.scale")
    window.keyboard.press("+")
    assert window.evaluate("live.chart.gestures.scale") > scale
    window.keyboard.press("?")
    assert window.is_visible("#keys")
    assert_accessible(window)
    window.keyboard.press("Escape")
    assert window.is_hidden("#keys")
    assert asked.sink.orders == [], "no key orders anything"


@pytest.mark.parametrize("holder", ["autonomy", "operator"])
def test_the_bar_cuts_neither_the_mission_s_name_nor_the_state_of_the_connection(
    holder: str, asked: Run, look: Look
) -> None:
    window = look(asked.page, viewport=SCREEN)
    asked.send(holder, "control", after_s=0.1, by="operator", role="operator")
    window.wait_for_selector(f"[data-control={holder}]")
    window.wait_for_selector("[data-line=live]")
    for width in (1280, 1366, 1440, 1600):
        window.set_viewport_size({"width": width, "height": 720})
        until(window, f"innerWidth === {width}")
        cut = "['h1', '#line'].filter((each) => (({ scrollWidth, clientWidth }) => scrollWidth > clientWidth)("
        assert window.evaluate(f"{cut}document.querySelector(each)))") == [], width


def test_a_run_that_follows_asks_another_question_under_the_same_number(asked: Run, look: Look) -> None:
    asked.run_id, second = "first", Run(asked.mission)
    second.write("battery", 0.8)
    second.start()
    ask(asked)
    ask(second)
    window = look(asked.page)
    window.wait_for_selector(".question [data-option]")
    number = window.evaluate(
        "(({ dataset }) => { dataset.first = 'yes'; return dataset.question; })($('.question'))".replace(
            "$(", "document.querySelector("
        )
    )
    asked.chart, asked.run_id = second.chart, "second"
    asked.feed.renew()
    until(window, "!document.querySelector('[data-first]') && document.querySelector('.question')")
    until(window, "!document.querySelector('[data-option=replan]').matches('[aria-disabled=true]')")
    window.click("[data-option=replan]")
    until(window, "document.body.textContent.includes('done')")
    order = json.loads(asked.sink.orders[-1])
    assert (str(order["question"]), order["run"], order["option"]) == (number, "second", "replan")
