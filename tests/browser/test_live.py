# SPDX-License-Identifier: Apache-2.0
"""The live page in a browser: a tractor in the simulated orchard is watched, answered and stopped."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.run.live_page import RunPage
from rai_missions.image import Image
from rai_missions.journal import read
from rai_missions.mission.json_reader import parse_json
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.result import Result
from tests.browser.conftest import PATIENCE, Look, until
from tests.browser.test_review import poisoned
from tests.engine.test_goals import mission as stacking
from tests.strategies import SIGHTS
from tests.visualize.live.conftest import OrderBox
from tests.visualize.live.stage import Run
from tests.visualize.page.reading import HOSTILE, answered, journal_of
from tests.visualize.runs import ROOT, tractor
from visualize.live import JournalFeed, LivePage, PageAddress

TRACTOR = ROOT / "missions/tractor"


@pytest.fixture
def run() -> Iterator[Run]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(tractor()) as made:
        made.write("battery", 0.8)
        made.start()
        yield made


def lit(window: Any) -> set[str]:
    return set(window.evaluate("[...document.querySelectorAll('.state.active')].map((each) => each.dataset.state)"))


@pytest.mark.long
def test_the_states_light_up_as_the_run_enters_them_and_the_row_taken_fades(run: Run, look: Look) -> None:
    window = look(run.page, reduced_motion="reduce")
    window.wait_for_selector("[data-state=driving].active", state="attached")
    assert lit(window) == {"working", "driving"}
    run.send("anomaly")
    window.wait_for_selector("[data-state=assessing].active", state="attached")
    assert lit(window) == {"assessing"}
    window.wait_for_selector("#chart .arrow.taken", state="attached")
    moving = "getComputedStyle(document.querySelector('#chart .arrow.taken .line')).animationTimingFunction"
    assert window.evaluate(moving).startswith("steps(1"), "who asks for less motion sees it go at once"
    window.wait_for_selector("#chart .arrow.taken", state="detached")
    key = "getComputedStyle(document.querySelector('#legend .taken .line'))"
    assert [window.evaluate(f"{key}.{word}") for word in ("animationName", "strokeWidth")] == ["none", "5px"], (
        "the legend shows what was taken as it looks at first"
    )
    window.click("#tab-journal")
    assert "anomaly working, driving → assessing" in " ".join(window.inner_text("#steps li:first-child").split())


def test_values_have_ages_that_count_and_grow_stale(run: Run, look: Look) -> None:
    window = look(run.page)
    age = "Number.parseFloat(document.querySelector('[data-key=battery] td:last-child').textContent)"
    until(window, f"{age} >= 0")
    first = window.evaluate(age)
    until(window, f"{age} > {first}")
    run.send("tick", "tick", after_s=20.0)
    until(window, "document.querySelector('[data-key=battery]').className === 'stale'")
    assert "stale" in window.inner_text("[data-key=battery]")


def test_a_named_thing_that_is_opened_stays_open_and_keeps_the_keyboard_as_values_come(look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(stacking()) as run:
        run.write("objects", SIGHTS[0])
        run.start()
        window = look(run.page)
        first = window.locator("[data-key=objects] summary").first
        first.focus()
        window.keyboard.press("Enter")
        known = "document.querySelector('[data-key=objects] [open]').innerText"
        now = [{**each, "looks": 99} for each in SIGHTS[0]["things"]]
        assert "looks 99" not in window.evaluate(known)
        run.write("objects", {**SIGHTS[0], "things": now})
        until(window, f"{known}.includes('looks 99')")
        assert window.evaluate("document.activeElement.tagName") == "SUMMARY"


CUT = """() => {
    window.seen = [];
    const look = () => seen.push(document.querySelector("[data-line]").dataset.line);
    new MutationObserver(look).observe(document.body, { attributes: true, childList: true, subtree: true });
    live.line.cut.abort();
}"""
"""It is back so soon that no one else may have seen it away."""


def test_a_page_that_was_cut_off_comes_back_to_what_is_so(run: Run, look: Look) -> None:
    window = look(run.page)
    window.wait_for_selector("[data-line=live]")
    window.evaluate(CUT)
    until(window, "seen.includes('away')")
    run.send("anomaly")
    window.wait_for_selector("[data-line=live]")
    window.wait_for_selector("[data-state=assessing].active", state="attached")


@contextmanager
def hung(page: LivePage) -> Iterator[None]:
    """The server takes connections and reports nothing, as a stopped process does."""
    resume = threading.Event()
    assert page._loop is not None
    page._loop.call_soon_threadsafe(resume.wait)
    try:
        yield
    finally:
        resume.set()


def test_a_page_that_receives_nothing_states_it_and_its_ages_run_on(run: Run, look: Look) -> None:
    window = look(run.page)
    window.wait_for_selector("[data-line=live]")
    with hung(run.page):
        window.wait_for_selector("body.disconnected [data-line=away]")
        assert window.inner_text("#mode") == "running?"
        assert window.evaluate("document.body.getBoundingClientRect().width") > 1000
        until(window, "/^last message [3-9] s ago$/.test(document.querySelector('#silence').textContent)")
        first = window.evaluate("live.now")
        until(window, f"live.now > {first}")
        shown = window.inner_text("header")
        assert "abort" not in shown.replace("aborted", "") and "fetch" not in shown.lower(), shown
    window.wait_for_selector("body:not(.disconnected) [data-line=live]")
    assert window.inner_text("#mode") == "running"
    assert window.inner_text("#silence") == ""


@pytest.mark.long
def test_an_order_reports_at_once_that_it_is_sent_and_then_what_became_of_it(look: Look) -> None:
    sink = OrderBox()
    with Run(tractor(), sink) as run:
        run.start()
        window = look(run.page)
        window.wait_for_selector("[data-act=pause]:not(:disabled)")
        reported = "document.querySelector('#notice')"
        with hung(run.page):
            assert window.evaluate(f"(live.acts.buttons.stop.click(), {reported}.textContent)") == "e-stop: sent …"
            window.wait_for_selector("#notice.alarm:has-text('e-stop: NO ANSWER')")
            assert "use the robot's own stop" in window.inner_text("#notice")
            window.evaluate("live.acts.order({ command: 'pause' })")
            window.wait_for_selector("#notice.alarm:has-text('pause: NO ANSWER')")
        until(window, f"{reported}.className === 'good' && {reported}.textContent.startsWith('e-stop: done')")
        assert [json.loads(text)["command"] for text in sink.orders if "pause" not in text] == ["e_stop"]
        run.page.stop()
        window.evaluate("live.acts.order({ command: 'e_stop' })")
        window.wait_for_selector("#notice.alarm:has-text('e-stop: not delivered')")


def test_a_state_that_waits_for_control_states_it_and_the_way_out_is_a_button(look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(tractor(), OrderBox()) as run:
        run.write("battery", 0.8)
        run.start()
        window = look(run.page)
        window.wait_for_selector("[data-state=driving].active", state="attached")
        assert window.inner_text("#waits") == "" and window.is_hidden("[data-act=autonomy]")
        run.send("agent", "control")
        reported = "driving waits until control is with the autonomy stack; the mission itself has it."
        until(window, f"document.querySelector('#waits').textContent.startsWith({json.dumps(reported)})")
        assert window.is_visible("[data-act=autonomy]") and window.is_hidden("[data-act=agent]")
        run.send("autonomy", "control")
        until(window, "document.querySelector('#waits').textContent === ''")


def test_an_option_whose_guard_falls_is_greyed_with_its_reason_and_comes_back(look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with Run(tractor(), OrderBox(), {"answers": True}) as run:
        run.write("battery", 0.8)
        run.start()
        run.write("obstacle", {"kind": "branch", "distance_m": 2.0, "height_m": 0.1, "living": False})
        window = look(run.page)
        run.send("anomaly", after_s=0.1)
        asked = run.send("agent", "control", after_s=0.1).question
        assert asked is not None
        asked = run.send("agent", "proposal", asked.number, after_s=0.1, absent="no model").question
        assert asked is not None and asked.asked == "operator"
        button = "[data-question] [data-option=drive_over]"
        shut = f"document.querySelector('{button}')?.getAttribute('aria-disabled')"
        until(window, f"{shut} === 'false'")
        run.closed = {asked.number: {"drive_over": "this is unknown: obstacle.living is false"}}
        run.write("battery", 0.79)
        until(window, f"{shut} === 'true'")
        assert window.inner_text(f"{button} ~ .reason") == "not now, this is unknown: obstacle.living is false"
        assert window.get_attribute("[data-question] [data-option=replan]", "aria-disabled") == "false"
        window.focus(button)
        window.keyboard.press("Enter")
        assert run.sink.orders == [], "the keyboard keeps its place on it, and it does nothing"
        run.closed = {}
        until(window, f"{shut} === 'false'")
        assert window.is_hidden(f"{button} ~ .reason")


def ask(run: Run, asked: str = "operator") -> None:
    """Have the mission ask about a branch, with a picture, what is known being fresh."""
    run.write("camera", Image("/camera@1", 64, 48, "rgb8", bytes(64 * 48 * 3)))
    see(run, "branch", 2.0)
    run.send("anomaly", after_s=0.1)
    question = run.send("agent", "control", after_s=0.1).question
    if asked == "operator":
        assert question is not None
        question = run.send("agent", "proposal", question.number, after_s=0.1, absent="no model").question
    assert question is not None and question.asked == asked


def see(run: Run, kind: str, distance_m: float) -> None:
    seen = {"kind": kind, "distance_m": distance_m, "height_m": 0.1, "living": kind == "dog"}
    run.send("obstacle", "write", after_s=0.1, value=seen)


def test_what_has_changed_since_a_question_was_asked_is_marked_once(run: Run, look: Look) -> None:
    window = look(run.page)
    ask(run, "agent")
    window.wait_for_selector(".evidence [data-field='obstacle.kind']")
    assert "A question to the model" in window.locator(".question").inner_text()
    until(window, "/^[1-9][0-9]* s ago$/.test(document.querySelector('.evidence h2 small').textContent)")
    assert window.locator(".evidence [data-field] mark").count() == 0
    marked = "[...document.querySelectorAll('.evidence [data-field]:has(mark)')].map((each) => each.dataset.field)"
    see(run, "dog", 0.5)
    window.wait_for_selector("[data-field='obstacle.kind'] .present:has-text('dog')")
    changed = window.evaluate(marked)
    assert changed == ["obstacle.kind", "obstacle.distance_m", "obstacle.living"]
    window.evaluate("""() => {
        window.again = 0;
        const count = (records) => {
            for (const each of records) again += [...each.addedNodes].filter((node) => node.nodeName === "MARK").length;
        };
        new MutationObserver(count).observe(document.querySelector(".evidence"), { childList: true, subtree: true });
    }""")
    for distance in (0.4, 0.3, 0.2):
        see(run, "dog", distance)
        window.wait_for_selector(f"[data-field='obstacle.distance_m'] .present:has-text('{distance}')")
    assert window.evaluate("again") == 0 and window.evaluate(marked) == changed


def test_after_the_end_nothing_looks_as_if_it_continued(look: Look) -> None:
    with Run(tractor(), OrderBox()) as run:
        run.write("battery", 0.8)
        run.start()
        window = look(run.page)
        window.wait_for_selector("[data-state=driving].active", state="attached")
        window.click("[data-act=cancel]")
        window.wait_for_selector("[data-act=cancel][data-sure]")
        run.send("kill", "command", by="x")
        window.wait_for_selector("body.over [data-line=over]")
        assert window.inner_text("#line") == "ended"
        assert window.locator("[data-act=cancel][data-sure]").count() == 0
        forms = "[...document.querySelectorAll('.state.active > .form')]"
        assert lit(window)
        assert "none" not in window.evaluate(f"{forms}.map((each) => getComputedStyle(each).strokeDasharray)")


def test_a_run_that_was_cut_short_is_shown_so(look: Look, tmp_path: Path) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    feed = JournalFeed(journal_of(tmp_path / "a.journal", tractor(), answered(tractor())[:3]))
    page = LivePage(PageAddress(port=0))
    page.start(feed.mission, feed)
    try:
        window = look(page)
        window.wait_for_selector("#mode[data-mode=cut]")
        assert window.inner_text("#mode") == "cut short"
        assert window.inner_text("#line") == "ended"
        assert "Cut short" in window.inner_text("#state") and "no process writes" in window.inner_text("#state")
    finally:
        page.stop()


def test_without_the_token_there_is_nothing_to_see_and_with_it_there_is(run: Run, look: Look, browser: Any) -> None:
    context = browser.new_context()
    window = context.new_page()
    window.set_default_timeout(PATIENCE)
    window.goto(run.page.address)
    window.wait_for_selector("#entry:not([hidden])")
    assert "tractor" not in window.inner_text("body")
    assert not any(window.is_visible(part) for part in ("#panel", "#line", "#more")), "nothing seems to be on its way"
    window.fill("#token", run.page.token)
    window.click("#entry button")
    window.wait_for_selector("[data-state=driving].active", state="attached")
    assert run.page.token not in window.url
    context.close()


def test_another_site_can_neither_read_nor_act(run: Run, browser: Any, tmp_path: Path) -> None:
    context = browser.new_context()
    window = context.new_page()
    (tmp_path / "evil.html").write_text("<title>elsewhere</title>")
    window.goto((tmp_path / "evil.html").as_uri())
    tried = """async ([url, token]) => {
      const attempts = [fetch(url + "mission", { headers: { "X-Mission-Token": token } }), fetch(url),
        fetch(url + "orders", { method: "POST", headers: { "X-Mission-Token": token }, body: "{}" })];
      return (await Promise.allSettled(attempts)).map((each) => each.status);
    }"""
    assert window.evaluate(tried, [run.page.address, run.page.token]) == ["rejected"] * 3
    framed = """(url) => new Promise((done) => {
      const frame = document.createElement("iframe");
      frame.onload = () => { try { done(frame.contentDocument ? "seen" : "hidden"); } catch { done("hidden"); } };
      frame.src = url;
      document.body.append(frame);
    })"""
    assert window.evaluate(framed, run.page.address) == "hidden"
    assert len(window.frames[-1].locator("#chart").all()) == 0
    context.close()


def test_nothing_that_a_mission_a_model_or_a_robot_reports_is_run(look: Look) -> None:
    mission: Mission = poisoned()
    with Run(mission) as run:
        run.write("battery", 0.8)
        run.start()
        window = look(run.page)
        seen = {"distance_m": 1.0, "height_m": 0.4, "living": False, "kind": HOSTILE[1], HOSTILE[0]: HOSTILE[5]}
        svg = b"<svg xmlns='http://www.w3.org/2000/svg'><script>window.pwned = 3</script></svg>"
        run.write("obstacle", seen)
        run.write("camera", Image(HOSTILE[0], 4, 3, "png", svg))
        run.send("anomaly", **{HOSTILE[0]: HOSTILE[1]})
        run.send("agent", "control", by=HOSTILE[1])
        window.wait_for_selector(".question")
        for text in HOSTILE[:6]:
            number = run.steps[-1].question.number if run.steps[-1].question else 1
            run.send(text, "proposal", number, option=text, why=text, by=text)
            run.send(text, by=text)
        run.send("kill", "command", by=HOSTILE[0])
        window.wait_for_selector(f"#mode[data-mode={run.mode}]")
        assert run.chart.outcome
        for each in ("details", "journal", "now"):
            window.click(f"#tab-{each}")
        for name in ("assessing", "driving2"):
            window.evaluate(f"live.go('state', '{name}')")
        assert window.evaluate("window.pwned") is None
        assert window.locator("script").count() == 1
        assert window.locator("img, iframe, object, embed").count() == 0
        assert not set("\u202e\u2066\u200f") & set(window.evaluate("document.body.innerText"))
        assert window.evaluate(
            "[...document.querySelectorAll('a')].every((each) => each.getAttribute('href').startsWith('#'))"
        )


class Tractor:
    """A tractor in the simulated orchard, at the wall's pace, with its page."""

    def __init__(self, journal: Path) -> None:
        profile = parse_json((TRACTOR / "robot.sim.json").read_bytes(), "robot.sim.json")
        profile["connector"] |= {"alleys": 1, "obstacles": ["branch"]}
        self.page, self.journal = LivePage(PageAddress(port=0)), journal
        setting = RunConfig(
            TRACTOR / "mission.json", Robot.model_validate(profile), {"alleys": 1}, journal=journal, speed=4.0
        )
        self._watch = RunPage(self.page, setting)
        self._prepared = prepare(self._watch.config)
        self.results: list[Result] = []
        self._thread = threading.Thread(target=self._work)
        self._thread.start()
        while not self.page.serves:
            threading.Event().wait(0.01)

    def _work(self) -> None:
        with self._prepared:
            self.results.append(self._watch.run(self._prepared, lambda runner: runner.run()))
        self.page.stop()

    def end(self) -> None:
        self._prepared.runner.kill("the test")
        self._thread.join(30)


@pytest.mark.sim
def test_an_operator_watches_answers_and_stops_a_tractor(tmp_path: Path, look: Look) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    tractor_ = Tractor(tmp_path / "a.journal")
    try:
        window = look(tractor_.page)
        window.fill("#who", "Anna")
        window.wait_for_selector("[data-state=driving].active", state="attached")
        until(window, "document.querySelector('[data-camera=camera]').width > 0")
        window.wait_for_selector(".question.mine")
        assert "Something blocks the alley" in window.inner_text(".question.mine")
        assert "s left" in window.inner_text(".question.mine")
        window.click(".question.mine [data-option=replan]")
        window.wait_for_selector("#notice.good")
        window.wait_for_selector(".question", state="detached")
        window.click("#tab-journal")
        window.wait_for_selector("#steps li:has-text('operator Anna (page) answers question')")
        window.wait_for_selector("#steps li:has-text('→ replanning')")
        window.click("[data-act=e_stop]")
        window.wait_for_selector("#mode[data-mode=aborted]")
        window.wait_for_selector("#state[data-state=e_stop]")
        assert "E-stop" in window.inner_text("#state")
        assert "by operator Anna (page)" in window.inner_text("#state")
        until(window, "document.querySelector('#line').dataset.line === 'over'")
    finally:
        tractor_.end()
    assert tractor_.results[0].why == "e-stop by operator Anna (page)"
    with read(tractor_.journal) as record:
        did = [(step.event.kind, step.event.data.get("by")) for step in record.steps()]
    assert ("proposal", "operator Anna (page)") in did
    assert ("command", "operator Anna (page)") in did
