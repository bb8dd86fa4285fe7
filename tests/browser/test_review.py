# SPDX-License-Identifier: Apache-2.0
"""The review page in a browser: details, switches, runs, and texts that would be read as something else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.engine import Chart
from rai_missions.engine.decision import Verdict
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.browser.conftest import Open, assert_accessible, until
from tests.engine.test_goals import mission as stacking
from tests.strategies import SIGHTS
from tests.visualize.page.reading import HOSTILE, answered, data_of, folded, journal_of
from tests.visualize.page.test_bad_input import broken
from tests.visualize.runs import ROOT, document, tractor
from visualize.page import review, run_of_steps

LENSES = {lens["name"]: lens for lens in data_of(review(tractor()))["lenses"]}

VERDICT = Verdict(False, "it is away", "absent", by="agent", note=0)


def lit(window: Any, what: str = ".state", word: str = "state") -> set[str]:
    found: list[str] = window.evaluate(
        f"[...document.querySelectorAll('{what}.lit')].map((each) => each.dataset.{word})"
    )
    return set(found)


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    return journal_of(tmp_path / "a.journal", tractor(), answered(tractor()))


def poisoned() -> Mission:
    """The tractor's mission with a hostile text wherever a text may be."""
    given = document()
    given["about"] = " ".join(HOSTILE[:5])
    texts = iter(HOSTILE * 40)

    def poison(value: Any) -> None:
        for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
            poison(each)
        if isinstance(value, dict) and "to" not in value and ("transitions" in value or "about" in value):
            value["about"] = next(texts)
        if isinstance(value, dict) and "question" in value:
            value["question"] = next(texts)

    poison(given["states"])
    given["states"]["driving2"] = {"entry": [{"say": text} for text in HOSTILE]}
    return Mission.model_validate(given)


def test_a_click_reports_all_of_a_state_and_the_address_names_it(opened: Open) -> None:
    window = opened(review(tractor()))
    window.click("[data-state=crossing] .form", position={"x": 5, "y": 5})
    reported = window.inner_text("#details")
    for words in (
        "/states/crossing",
        "action cross",
        "at most 30 s",
        "passed is true",
        "obstacle.living is true",
        "timeout_s 30 s",
    ):
        assert words in reported
    shown = json.loads(window.text_content("#details pre"))
    assert shown == document()["states"]["crossing"]
    assert window.evaluate("location.hash") == "#state=crossing"
    window.click("#details a:has-text('assessing') >> nth=0")
    assert window.evaluate("location.hash") == "#state=assessing"
    assert window.locator("#details .crumbs").count() == 0, "nothing is around it"
    window.evaluate("review.go('state', 'driving')")
    assert window.inner_text("#details .crumbs") == "working › driving"


def test_a_click_reports_all_of_a_row(opened: Open) -> None:
    window = opened(review(tractor()))
    window.locator("[data-transitions='/states/assessing/transitions/0'] .grip").dispatch_event("click")
    reported = window.inner_text("#details")
    for words in (
        "drive_over",
        "from assessing",
        "to crossing",
        "option drive_over: offered when",
        "obstacle.height_m < 0.25",
    ):
        assert words in reported
    assert json.loads(window.text_content("#details pre")) == document()["states"]["assessing"]["transitions"][0]
    again = opened(review(tractor()), at=window.evaluate("location.hash"))
    assert "from assessing" in again.inner_text("#details")


@pytest.mark.parametrize(("name", "key"), [(name, lens["key"]) for name, lens in LENSES.items()])
def test_a_switch_lights_what_answers_it_and_dims_all_else(name: str, key: str, opened: Open) -> None:
    window = opened(review(tractor()))
    parents = {state["name"]: state.get("parent", "") for state in data_of(review(tractor()))["chart"]["states"]}
    expected = set(LENSES[name]["states"]) | {parents[state] for state in LENSES[name]["states"]} - {""}
    window.click(f"[data-lens={name}]")
    assert lit(window) == expected
    transitions = {
        transition for transitions in lit(window, ".arrow", "transitions") for transition in transitions.split()
    }
    drawn = window.evaluate(
        "[...document.querySelectorAll('.arrow')].flatMap((each) => each.dataset.transitions.split(' '))"
    )
    assert transitions == set(LENSES[name]["transitions"]) & set(drawn)
    assert lit(window, ".cell", "option") == set(LENSES[name]["options"])
    for section in LENSES[name]["sections"]:
        assert section["heading"] in window.inner_text("#lens")
    dimmed = window.evaluate(
        "[...document.querySelectorAll('.state:not(.lit) > .texts')].map((each) => getComputedStyle(each).opacity)"
    )
    assert all(float(opacity) < 0.5 for opacity in dimmed)
    assert f"lens={name}" in window.evaluate("location.hash")
    window.keyboard.press(key)
    assert lit(window) == set()
    assert not window.is_visible("#lens")


def test_help_reports_the_keys(opened: Open) -> None:
    window = opened(review(tractor()))
    window.keyboard.press("?")
    assert window.is_visible("#keys")
    for lens in LENSES.values():
        assert lens["title"].lower()[:20] in window.inner_text("#keys").lower()
    window.click("#keys-close")
    assert not window.is_visible("#keys")


def test_a_run_is_scrubbed_to_any_step_and_shows_what_was_so_then(journal: Path, opened: Open) -> None:
    page = review(tractor(), [journal])
    data = data_of(page)
    window = opened(page)
    for index, (active, board) in enumerate(folded(data["runs"][0], data["chart"]["keys"])):
        window.locator("#player input").evaluate(
            "(slider, at) => { slider.value = at; slider.dispatchEvent(new Event('input')); }", index
        )
        until(window, f"document.querySelector('#player output').dataset.index === '{index}'")
        shown = window.evaluate("[...document.querySelectorAll('.state.active')].map((each) => each.dataset.state)")
        assert set(shown) == active
        known = window.evaluate("[...document.querySelectorAll('[data-key]')].map((each) => each.dataset.key)")
        assert set(known) >= set(board)
    assert "the mission ended aborted" in window.inner_text("#step")


def test_a_question_is_shown_as_it_was_asked_with_its_picture_its_answer_and_the_verdict(
    journal: Path, opened: Open
) -> None:
    page = review(tractor(), [journal])
    [first, *_] = data_of(page)["runs"][0]["questions"]
    window = opened(page, at=f"#step={first['answered']}")
    until(window, "document.querySelector('.question img')?.naturalWidth === 16")
    reported = window.inner_text(".question >> nth=0")
    for words in (
        "Question 2 to the model",
        "height_m 0.5",
        "✗ not offered drive_over",
        "which was false",
        "✓ offered replan",
        HOSTILE[0],
        "was not offered",
    ):
        assert words in reported


def test_the_path_of_a_run_has_each_change_with_its_time_and_answer_and_leads_to_its_step(
    journal: Path, opened: Open
) -> None:
    page = review(tractor(), [journal])
    [run] = data_of(page)["runs"]
    pool = run["pool"]
    changed = [
        index for index, row in enumerate(run["steps"]) if pool[row[3]] or {"asks", "outcome"} & set(pool[row[6]])
    ]
    window = opened(page)
    window.click("#tab-path")
    assert (
        window.evaluate("[...document.querySelectorAll('#path [data-step]')].map((li) => Number(li.dataset.step))")
        == changed
    )
    times = window.locator("#path li > a").all_inner_texts()
    assert times == [f"{run['steps'][index][1]:.2f} s" for index in changed]
    reported = window.inner_text("#path")
    for words in (
        run["why"],
        "s there",
        HOSTILE[0],
        "was not offered",
        "the operator answered",
        "command start",
        "ask the model (question 2)",
    ):
        assert words in reported, words
    assert_accessible(window)
    window.click("#path li:last-child > a")
    until(window, f"document.querySelector('#path [aria-current=step]').dataset.step === '{changed[-1]}'")
    assert window.get_attribute("#player output", "data-index") == str(changed[-1])
    window.keyboard.press("<")
    until(window, f"document.querySelector('#path [aria-current=step]').dataset.step === '{changed[-2]}'")
    assert window.is_visible("#path")


def test_one_who_cannot_answer_is_named_with_the_reason_once(opened: Open) -> None:
    asked = next(step for step in answered(tractor()) if step.question)
    assert asked.question is not None
    absent = Event(asked.question.asked, asked.at, {"absent": "it is away"}, "proposal", asked.question.number)
    silent = Step(
        asked.seq + 1, asked.at, absent, verdicts=(VERDICT._replace(number=absent.number),), notes=("absent",)
    )
    window = opened(review(tractor(), runs=[run_of_steps([asked, silent])]), "#run=0&step=1")
    assert window.inner_text(".verdict") == "no answer: question 2: the model cannot answer: it is away"


def test_steps_go_by_keys_and_jump_from_change_to_change(journal: Path, opened: Open) -> None:
    window = opened(review(tractor(), [journal]))
    now = "document.querySelector('#player output').dataset.index"
    window.keyboard.press(".")
    until(window, f"{now} === '1'")
    window.keyboard.press(">")
    until(window, f"{now} !== '1'")
    assert window.locator(".state.active").count()
    window.keyboard.press("<")
    until(window, f"{now} === '0'")


def test_coverage_reports_which_rows_were_never_taken_and_is_sorted_by_a_click(journal: Path, opened: Open) -> None:
    page = review(tractor(), [journal, journal])
    taken = data_of(page)["coverage"]["transitions"]
    window = opened(page)
    window.click("#tab-transitions")
    window.click("[data-sort=taken]")
    numbers = window.locator("#transitions tbody tr .number:nth-last-child(2)").all_text_contents()
    counts = [0 if number == "never" else int(number) for number in numbers]
    assert counts == sorted(counts, reverse=True)
    assert [count for count in counts if count] == sorted((sum(each) for each in taken.values()), reverse=True)
    window.click("[data-sort=taken]")
    assert window.inner_text("#transitions tbody tr:first-child .number >> nth=0") == "never"


def test_a_history_which_is_never_active_is_not_among_the_states_never_entered(opened: Open) -> None:
    mission = load(ROOT / "missions/rosbot/mission.json")
    chart = Chart(mission, ticker=CompiledTrees())
    window = opened(review(mission, runs=[run_of_steps([chart.start(0.0)])]))
    window.click("#tab-transitions")
    never = window.evaluate("[...document.querySelectorAll('#transitions li')].map((each) => each.textContent)")
    assert "deciding" in never
    assert "resume" not in never
    assert f"of {sum(1 for _ in mission.walk()) - 1} states entered" in window.inner_text("#transitions")


def test_no_text_of_a_mission_a_model_or_a_robot_is_run_or_read_as_markup(journal: Path, opened: Open) -> None:
    window = opened(review(poisoned(), runs=[run_of_steps(answered(tractor()))]))
    window.click("#open-all")
    for name in ("assessing", "driving2", "crossing"):
        window.evaluate(f"review.go('state', '{name}')")
    for lens in LENSES:
        window.click(f"[data-lens={lens}]")
    for index in range(len(answered(tractor()))):
        window.evaluate(f"review.player.seek({index})")
        until(window, f"document.querySelector('#player output').dataset.index === '{index}'")
    for tab in ("details", "step", "transitions"):
        window.click(f"#tab-{tab}")
    assert window.evaluate("window.pwned") is None
    assert window.locator("script").count() == 2
    assert window.evaluate("[...document.images].every((each) => each.src.startsWith('data:image/'))")
    assert window.evaluate(
        "[...document.querySelectorAll('a')].every((each) => each.getAttribute('href').startsWith('#'))"
    )
    assert not set("\u202e\u2066\u200f") & set(window.evaluate("document.body.innerText"))


def test_the_policy_stops_a_script_that_got_in_all_the_same(opened: Open) -> None:
    window = opened(review(tractor()))
    ways = [
        "document.body.innerHTML = '<b>'",
        "document.body.setAttribute('onclick', 'window.pwned = 1')",
        "document.body.append(Object.assign(document.createElement('script'), { text: 'window.pwned = 2' }))",
    ]
    for way in ways:
        refused = window.evaluate(f"(() => {{ try {{ {way}; return ''; }} catch (error) {{ return error.name; }} }})()")
        assert refused == "TypeError", way
    assert window.evaluate("window.pwned") is None


def test_what_a_check_found_and_what_is_wrong_with_a_journal_is_on_the_page(tmp_path: Path, opened: Open) -> None:
    given = document()
    given["states"]["crossing"]["transitions"][1]["to"] = "nowhere"
    mission = Mission.model_validate(given)
    journal = broken(journal_of(tmp_path / "a.journal", tractor(), answered(tractor())))
    window = opened(review(mission, [journal], check(mission)))
    banner = window.inner_text("#banner")
    assert "nowhere" in banner
    assert "drawn on" in banner
    assert window.locator("[data-state=crossing] .badge").count() == 1
    window.click("[data-state=crossing] .form", position={"x": 5, "y": 5})
    assert "nowhere" in window.inner_text("#details .fault >> nth=0")
    assert "altered after the run" in window.evaluate("review.data.runs[0].faults.join()")


def test_named_things_are_a_line_each_and_open_by_a_key(opened: Open) -> None:
    chart = Chart(stacking())
    steps = [chart.start(0.0), chart.write("objects", SIGHTS[0], 1.0)]
    window = opened(review(chart.mission, runs=[run_of_steps(steps)]), "#run=0&step=1")
    things = SIGHTS[0]["things"]
    lines = window.locator("[data-key=objects] ul.named summary")
    assert lines.locator("b").all_inner_texts() == [each["name"] for each in things]
    assert max(line.bounding_box()["height"] for line in lines.all()) < 24
    lines.first.focus()
    window.keyboard.press("Enter")
    known = window.inner_text("[data-key=objects] ul.named [open]")
    assert all(field in known for field in {*things[0]} - {"name"})


def test_a_plan_is_a_list_of_its_moves_with_what_each_assumes(opened: Open) -> None:
    chart = Chart(stacking())
    steps = [chart.start(0.0), chart.write("objects", SIGHTS[0], 1.0)]
    window = opened(review(chart.mission, runs=[run_of_steps(steps)]), "#run=0&step=1")
    (plan,) = (value for key, value in steps[1].writes if key == "plan")
    (move,) = plan["moves"]
    shown = window.inner_text("[data-key=plan] ol.plan > li")
    assert shown.startswith("red_cube onto blue_cube, at 0.6, 0 m")
    assert window.locator("[data-key=plan] ul.assumes li").all_inner_texts() == move["assumes"]
