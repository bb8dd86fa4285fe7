# SPDX-License-Identifier: Apache-2.0
"""The chart in a browser: all of the mission is there, nothing leaves its box, and it opens, closes and is searched."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from benchmarks.bench_draw import chain
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.browser.conftest import Open, until
from tests.strategies import missions
from tests.visualize.runs import ROOT, hostile, tractor
from tests.visualize.tree_documents import Json, crowded, named, numbers, walk, written_trees
from visualize.page import review

STATES = "[...document.querySelectorAll('.state')].map((each) => each.dataset.state)"
SPILLED = """[...document.querySelectorAll('.state, .cell, .twig, .sign')].flatMap((box) => {
  const form = (box.querySelector('.form') ?? box.querySelector('rect')).getBoundingClientRect();
  return [...box.querySelectorAll(':scope > .texts text')].filter((text) => {
    const is = text.getBoundingClientRect();
    return is.left < form.left - 1 || is.right > form.right + 1 || is.bottom > form.bottom + 2;
  }).map((text) => text.textContent);
})"""
MEETING = """(() => {
  const form = (each) => (each.querySelector('.form') ?? each.querySelector('rect')).getBoundingClientRect();
  const all = [...document.querySelectorAll('.state:not(.open), .sign')];
  const boxes = all.map((each) => [each.dataset.state, form(each)]);
  const meet = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  return boxes.flatMap(([name, a], index) =>
    boxes.slice(index + 1).filter(([, b]) => meet(a, b)).map(([other]) => [name, other]));
})()"""
TWIGS = """[...document.querySelectorAll('.twig')].map((twig) => {
  const { left, right, top, bottom } = twig.querySelector('rect').getBoundingClientRect();
  const lines = [...twig.querySelectorAll('text')].map((each) => each.textContent);
  return [twig.querySelector('title').textContent, lines, left, right, top, bottom];
})"""
ON_PAPER = """(() => {
  const paper = document.querySelector('#chart').getBoundingClientRect();
  const outside = [...document.querySelectorAll('.state')].filter((each) => {
    const { left, right, top, bottom } = each.getBoundingClientRect();
    return left < paper.left || right > paper.right || top < paper.top || bottom > paper.bottom;
  }).map((each) => each.dataset.state);
  return [outside, paper.height / innerHeight];
})()"""
"""Which states are outside of the printed chart, and how much of a page's height it takes."""
NEARER = """(() => {
  const { gestures, svg } = review.chart;
  for (let step = 0; step < 60 && svg.dataset.detail !== 'all'; step += 1) gestures.zoom(1.25);
})()"""
UNTOLD = """(() => {
  const arrows = [...document.querySelectorAll('.arrow')];
  const drawn = new Set(arrows.flatMap((each) => each.dataset.transitions.split(' ')));
  const { model, chart } = review;
  const isShown = (transition) => drawn.has(transition.place) || chart.staying(transition.source).includes(transition);
  return model.data.transitions.filter((each) => each.source && !isShown(each)).map((each) => each.place);
})()"""


def names(mission: Mission) -> set[str]:
    return {name for _, name, _ in mission.walk()}


def missing(window: Any) -> list[str]:
    """Transitions that are neither on an arrow nor reported by a box of the open chart."""
    found: list[str] = window.evaluate(UNTOLD)
    return found


def assert_whole(window: Any, mission: Mission) -> None:
    """Every state and transition is there once all are open, and no text leaves its box."""
    window.click("#open-all")
    assert sorted(window.evaluate(STATES)) == sorted(names(mission))
    assert missing(window) == []
    assert window.evaluate(SPILLED) == []
    assert window.evaluate(MEETING) == []


@pytest.mark.parametrize("mission", [tractor(), hostile()], ids=["tractor", "hostile"])
def test_every_state_and_transition_is_there_and_no_text_leaves_its_box(mission: Mission, opened: Open) -> None:
    window = opened(review(mission))
    assert_whole(window, mission)


@settings(max_examples=5, suppress_health_check=list(HealthCheck))
@given(mission=missions())
def test_any_mission_is_drawn_whole(mission: Mission, opened: Open) -> None:
    window = opened(review(mission))
    assert_whole(window, mission)
    window.context.close()


@settings(max_examples=4, suppress_health_check=list(HealthCheck))
@given(document=crowded())
def test_the_children_of_a_trees_node_lie_in_the_order_of_the_file_and_are_numbered(
    document: Json, opened: Open
) -> None:
    names = numbers()
    trees = [named(tree, names) for tree in written_trees(document)]
    window = opened(review(Mission.model_validate(document)))
    window.click("#open-all")
    window.evaluate(NEARER)
    placed = {title.partition(":")[0]: rest for title, *rest in window.evaluate(TWIGS)}
    for node in (each for tree in trees for each in walk(tree)):
        below = [placed[child.name] for child in node.below]
        assert all(one[2] <= other[1] for one, other in itertools.pairwise(below)), below
        assert all(child[3] >= placed[node.name][4] for child in below), below
        assert all(
            any(line.startswith(f"{child.number}. {child.name}:" if child.number else child.name) for line in at[0])
            for child, at in zip(node.below, below, strict=True)
        ), below
    window.context.close()


def test_a_large_mission_is_closed_at_first_and_every_state_is_found_in_it(opened: Open) -> None:
    mission = chain(500)
    window = opened(review(mission))
    assert len(window.evaluate(STATES)) < 60
    window.fill("#search", "a31_4")
    window.press("#search", "Enter")
    assert window.locator(".state.selected").get_attribute("data-state") == "a31_4"
    assert window.inner_text("#hits") == "1 found"
    window.click("#open-all")
    assert sorted(window.evaluate(STATES)) == sorted(names(mission))
    assert window.evaluate(MEETING) == []


def test_a_state_opens_and_closes_by_its_knob_by_a_double_click_and_by_keys(opened: Open) -> None:
    window = opened(review(tractor()))
    assert window.locator("[data-state=driving]").count() == 1
    window.click("[data-knob=working]")
    assert window.locator("[data-state=driving]").count() == 0
    assert "2 states inside" in window.locator("[data-state=working]").text_content()
    window.dblclick("[data-state=working] .form:not(.under)")
    assert window.locator("[data-state=driving]").count() == 1
    window.keyboard.press("c")
    assert window.locator("[data-state=driving]").count() == 0
    window.keyboard.press("a")
    assert window.locator("[data-state=driving]").count() == 1


def test_a_search_marks_what_it_finds_and_goes_from_one_to_the_next(opened: Open) -> None:
    window = opened(review(tractor()))
    window.keyboard.press("/")
    window.keyboard.type("obstacle")
    found = window.locator(".state.found")
    assert found.count() >= 2
    window.keyboard.press("Enter")
    first = window.locator(".state.selected").get_attribute("data-state")
    window.keyboard.press("Enter")
    assert window.locator(".state.selected").get_attribute("data-state") != first
    window.keyboard.press("Escape")
    assert found.count() == 0


SEEN = """(() => {
  const chart = document.querySelector('svg.chart').getBoundingClientRect();
  const first = document.querySelector(`.state[data-state="${review.chart.first()}"] .form`).getBoundingClientRect();
  const inside = first.left >= chart.left && first.top >= chart.top && first.right <= chart.right;
  return inside && first.bottom <= chart.bottom;
})()"""


@pytest.mark.parametrize(
    "mission", [tractor(), load(ROOT / "missions/rosbot/mission.json"), chain(40)], ids=["tractor", "rosbot", "chain"]
)
def test_a_page_opens_with_where_the_mission_begins_in_view(mission: Mission, opened: Open) -> None:
    window = opened(review(mission))
    assert window.evaluate(SEEN)


def test_all_of_a_very_large_chart_fits(opened: Open) -> None:
    window = opened(review(chain(500)))
    window.click("#open-all")
    window.set_viewport_size({"width": 900, "height": 280})
    window.keyboard.press("f")
    outside = """(() => {
      const chart = document.querySelector('svg.chart').getBoundingClientRect();
      const all = [...document.querySelectorAll('.state .form')].map((each) => each.getBoundingClientRect());
      const out = (each) => each.left < chart.left || each.top < chart.top || each.right > chart.right
        || each.bottom > chart.bottom;
      return all.filter(out).length;
    })()"""
    assert window.evaluate(outside) == 0
    assert window.evaluate("review.chart.gestures.scale") < 0.25


def test_the_chart_is_moved_zoomed_and_fitted(opened: Open) -> None:
    window = opened(review(tractor()))
    view = "(({ x, y, scale }) => [x, y, scale])(review.chart.gestures)"
    window.keyboard.press("f")
    fitted = window.evaluate(view)
    window.mouse.move(300, 500)
    window.mouse.wheel(0, -300)
    until(window, f"review.chart.gestures.scale > {fitted[2]}")
    window.mouse.down()
    window.mouse.move(380, 560, steps=4)
    window.mouse.up()
    assert window.evaluate(view)[:2] != fitted[:2]
    window.keyboard.press("ArrowLeft")
    window.click("#fit")
    assert window.evaluate(view) == fitted


def test_a_link_leads_to_a_state_inside_closed_ones(opened: Open) -> None:
    window = opened(review(chain(500)), at="#state=a42_3")
    assert window.locator(".state.selected").get_attribute("data-state") == "a42_3"
    assert "a42_3" in window.inner_text("#details h2")
    box = window.locator("[data-state=a42_3] .form").bounding_box()
    assert 0 < box["x"] < 1400
    assert 0 < box["y"] < 900


def test_the_page_is_light_or_dark_as_the_reader_has_it_and_by_a_key(opened: Open) -> None:
    paper = "getComputedStyle(document.querySelector('#chart')).backgroundColor"
    light, dark = (opened(review(tractor()), color_scheme=scheme) for scheme in ("light", "dark"))
    assert light.evaluate(paper) == "rgb(255, 255, 255)"
    shade = dark.evaluate(paper)
    assert shade != "rgb(255, 255, 255)"
    light.keyboard.press("t")
    assert light.evaluate(paper) == shade


def test_it_prints_without_its_tools_on_white(opened: Open) -> None:
    window = opened(review(tractor()), color_scheme="dark")
    window.emulate_media(media="print", color_scheme="dark")
    assert not window.is_visible(".tools")
    assert not window.is_visible("#lenses")
    assert window.is_visible("[data-state=assessing]")
    assert window.evaluate("getComputedStyle(document.querySelector('#chart')).backgroundColor") == "rgb(255, 255, 255)"
    assert window.is_visible("#legend"), "paper has no tooltips"
    assert window.pdf().startswith(b"%PDF")


@pytest.mark.parametrize("size", [(1400, 900), (390, 844)], ids=["screen", "phone"])
def test_all_of_its_chart_is_on_the_paper(opened: Open, size: tuple[int, int]) -> None:
    window = opened(review(tractor()), viewport=dict(zip(("width", "height"), size, strict=True)))
    window.evaluate("dispatchEvent(new Event('beforeprint'))")
    window.emulate_media(media="print")
    for paper in ({"width": 794, "height": 1123}, {"width": 1123, "height": 794}):
        window.set_viewport_size(paper)
        outside, share = window.evaluate(ON_PAPER)
        assert outside == [] and share > 0.55
    window.evaluate("dispatchEvent(new Event('afterprint'))")
    assert window.get_attribute("svg.chart", "viewBox") is None
