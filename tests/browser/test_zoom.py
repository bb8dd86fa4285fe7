# SPDX-License-Identifier: Apache-2.0
"""The chart at every zoom: names that are read at fit, more the nearer, folds, and the progress of large ones."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.bench_draw import chain
from rai_missions.engine import Chart
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.testing import let_time_pass
from tests.browser.conftest import Open, until
from tests.browser.test_chart import MEETING, NEARER, SPILLED
from tests.visualize.runs import ROOT, tractor, tractor_path
from visualize.page import review, run_of_steps

SCREEN, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
LEAST_PX = 11
NAMES = """(() => {
  const chart = document.querySelector('svg.chart').getBoundingClientRect();
  const shown = [...document.querySelectorAll('.state')].map((each) => {
    const form = each.querySelector('.form').getBoundingClientRect(), name = each.querySelector(':scope > .texts text');
    const inside = form.left >= chart.left - 1 && form.top >= chart.top - 1 && form.right <= chart.right + 1
      && form.bottom <= chart.bottom + 1;
    return [Number(name.getAttribute('font-size')) * review.chart.gestures.scale, inside];
  });
  return { least: Math.min(...shown.map(([px]) => px)), inside: shown.every(([, inside]) => inside),
    detail: review.chart.svg.dataset.detail, labels: document.querySelectorAll('.label').length,
    cells: document.querySelectorAll('.cell').length };
})()"""
CROSSED = """(() => {
  const points = [...document.querySelectorAll('svg.chart .arrow .line')].flatMap((path) => {
    const to = path.getScreenCTM(), length = path.getTotalLength();
    return Array.from({ length: Math.ceil(length / 5) }, (_, at) => path.getPointAtLength(5 * at).matrixTransform(to));
  });
  const texts = [...document.querySelectorAll('.label text, .state > .texts text, .count')];
  return texts.filter((text) => {
    const { left, right, top, bottom } = text.getBoundingClientRect();
    const hit = ({ x, y }) => x > left + 1 && x < right - 1 && y > top + 3 && y < bottom - 3;
    return text.textContent && points.some(hit);
  }).map((text) => text.textContent);
})()"""
HELD = """(name) => {
  const { chart } = review, { left, right, top, bottom } = chart.gestures.edges(chart.place(name));
  const { width, height } = chart.svg.getBoundingClientRect();
  return left >= 0 && top >= 0 && (right <= width || right - left > width - 16)
    && (bottom <= height || bottom - top > height - 16);
}"""
"""Whether a state is in the window, or from its beginning on where it is larger."""
WRITTEN = """[...document.querySelectorAll('.state > .texts')].map((each) =>
  [...each.querySelectorAll('text')].map((line) => line.textContent).join(' '))"""
COVERED = """(() => {
  const box = (each) => each.getBoundingClientRect(), texts = [...document.querySelectorAll('.texts text')];
  const meet = (a, b) =>
    a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 3 && b.top < a.bottom - 3;
  const over = [...document.querySelectorAll('.count, .badge, .knob')];
  return over.filter((each) => each.textContent || each.dataset.knob).flatMap((each) =>
    texts.filter((text) => meet(box(each), box(text))).map((text) => [each.textContent, text.textContent]));
})()"""
FORM = "document.querySelector('[data-state=NAME] .form').getBoundingClientRect()"
ENDS = """(() => {
  const { left, right, top, bottom } = FORM;
  const into = review.chart.view.bundles.filter((each) => each.to.name === 'NAME' && !each.start);
  return into.map((each) => {
    const places = each.transitions.map(({ place }) => place).join(' ');
    const line = document.querySelector(`.arrow[data-transitions="${places}"] .line`);
    const { x, y } = line.getPointAtLength(line.getTotalLength()).matrixTransform(line.getScreenCTM());
    return Math.max(0, left - x, x - right, top - y, y - bottom);
  });
})()""".replace("FORM", FORM)
"""How far the end of each arrow into a state is from its form."""


def flat(count: int, name: str = "s") -> Mission:
    """So many states on one level, one after the other, each with a way out into the same end."""
    states: dict[str, Any] = {
        f"{name}{number}": {
            "action": "navigate",
            "timeout_s": 60,
            "about": "drives to the next place of the round",
            "transitions": [
                {"on": "succeeded", "to": f"{name}{number + 1}" if number < count - 3 else "done"},
                {"on": ["failed", "timed_out", "rejected"], "to": "lost"},
            ],
        }
        for number in range(count - 2)
    }
    ends = {"done": {"final": "aborted"}, "lost": {"final": "failed"}}
    document = {"format": 1, "name": "flat", "initial": f"{name}0", "states": {**states, **ends}}
    return Mission.model_validate(document)


MISSIONS = {
    "tractor": load(ROOT / "missions/tractor/mission.json"),
    "rosbot": load(ROOT / "missions/rosbot/mission.json"),
    "62": flat(62),
    "300": flat(300, "waypoint_"),
    "300 in groups": chain(300),
}


@pytest.mark.parametrize("name", MISSIONS)
def test_at_fit_all_names_are_read(name: str, opened: Open) -> None:
    window = opened(review(MISSIONS[name]), viewport=SCREEN)
    window.keyboard.press("f")
    seen = window.evaluate(NAMES)
    assert seen["least"] >= LEAST_PX
    assert seen["inside"]
    assert window.evaluate(SPILLED) == []
    assert window.evaluate(MEETING) == []


LONG = "a_very_long_name_of_a_state_that_its_author_from_the_warehouse_wrote_in_full"


@pytest.mark.parametrize("name", [LONG + "_{}", LONG + "_{}_with_the_thermal_camera_of_the_northern_greenhouse"])
def test_names_that_begin_alike_differ_at_every_level(opened: Open, name: str) -> None:
    states: dict[str, Any] = {
        name.format(number): {"action": "go", "timeout_s": 1, "transitions": [{"on": "succeeded", "to": "done"}]}
        for number in range(9)
    }
    states["done"] = {"final": "aborted"}
    document = {"format": 1, "name": "alike", "initial": name.format(0), "states": states}
    window = opened(review(Mission.model_validate(document)), viewport={"width": 1000, "height": 640})
    drawn = """[...document.querySelectorAll('.state > .texts')].map((each) =>
      [...each.querySelectorAll('text')].map((line) => line.lastChild.data || line.firstChild.data).join(' '))"""
    seen = set()
    for _ in range(60):
        seen.add(window.evaluate("review.chart.svg.dataset.detail"))
        written = window.evaluate(drawn)
        assert len(written) == len(set(written)) == 10, written
        assert window.evaluate(SPILLED) == []
        window.keyboard.press("+")
    assert {"triggers", "all"} <= seen


def test_where_arrows_are_left_out_their_target_has_a_tip_that_counts_them(opened: Open) -> None:
    window = opened(review(flat(200)), viewport={"width": 1000, "height": 640})
    assert window.evaluate("review.chart.view.signs") is False
    tips = """[...document.querySelectorAll('.state > .unseen')].map((tip) =>
      [tip.parentNode.dataset.state, tip.textContent])"""
    assert window.evaluate(tips) == [["lost", "198 more transitions lead to lost; zoom in"]]
    assert window.is_visible("#legend .unseen")
    window.set_viewport_size(SCREEN)
    until(window, "review.chart.view.signs")
    assert window.evaluate(tips) == [] and not window.is_visible("#legend .unseen")


def test_the_nearer_the_more_is_drawn_and_no_label_is_crossed_or_covered(opened: Open) -> None:
    run = run_of_steps(tractor_path())
    window = opened(review(tractor(), runs=[run]), viewport=SCREEN)
    window.keyboard.press("f")
    fitted: Any = window.evaluate(NAMES)
    found: dict[str, Any] = {}
    for _ in range(60):
        found.setdefault(window.evaluate("review.chart.svg.dataset.detail"), window.evaluate(NAMES))
        if "all" in found:
            break
        window.keyboard.press("+")
    assert fitted["labels"] == fitted["cells"] == 0
    assert list(found) == ["names", "triggers", "all"]
    assert found["triggers"]["labels"] > 5
    assert found["triggers"]["cells"] == found["all"]["cells"] == 4
    assert "when signals < 3" in window.text_content("svg.chart")
    assert window.evaluate(CROSSED) == []
    assert window.evaluate(COVERED) == []
    for _ in range(60):
        window.keyboard.press("-")
    assert window.evaluate(NAMES)["detail"] != "all"
    window.keyboard.press("f")
    assert window.evaluate(NAMES) == fitted


@pytest.mark.parametrize("size", [(1440, 900), (1366, 768), (1280, 720)])
def test_at_first_each_name_of_a_shipped_mission_is_whole(size: tuple[int, int], opened: Open) -> None:
    for name in ("tractor/mission", "rosbot/mission", "rosbot/assist", "desk/arrange", "desk/stack"):
        page = review(load(ROOT / f"missions/{name}.json"))
        window = opened(page, viewport=dict(zip(("width", "height"), size, strict=True)))
        assert [each for each in window.evaluate(WRITTEN) if "…" in each] == [], name
        assert window.evaluate(NAMES)["least"] >= LEAST_PX, name


def test_a_chart_that_was_fitted_is_fitted_again_when_its_window_is_resized(opened: Open) -> None:
    window = opened(review(tractor()), viewport=SCREEN)
    for width, height in ((1000, 640), (1600, 700)):
        window.set_viewport_size({"width": width, "height": height})
        until(window, f"innerWidth === {width} && {NAMES}.inside")
        assert window.evaluate(NAMES)["least"] >= LEAST_PX
    for key in ("+", "ArrowLeft"):
        window.keyboard.press(key)
    moved = window.evaluate("review.chart.gestures.at")
    window.set_viewport_size(SCREEN)
    until(window, f"innerWidth === {SCREEN['width']}")
    window.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert window.evaluate("review.chart.gestures.at") == moved, "what was moved by hand stays where it is"


def test_what_is_under_the_pointer_stays_when_more_is_drawn(opened: Open) -> None:
    window = opened(review(tractor()), viewport=SCREEN)
    form = FORM.replace("NAME", "returning")
    middle = f"(({{ left, right, top, bottom }}) => [(left + right) / 2, (top + bottom) / 2])({form})"
    x, y = window.evaluate(middle)
    window.mouse.move(x, y)
    for _ in range(12):
        window.mouse.wheel(0, -200)
    until(window, "review.chart.svg.dataset.detail === 'all'")
    now = window.evaluate(middle)
    assert abs(now[0] - x) < 8
    assert abs(now[1] - y) < 8


def test_a_state_folds_by_the_keyboard_and_arrows_end_at_its_border(opened: Open) -> None:
    window = opened(review(tractor()), viewport=SCREEN)
    window.focus("[data-knob=working]")
    window.keyboard.press("Enter")
    assert window.locator("[data-state=driving]").count() == 0
    assert window.evaluate("document.activeElement.dataset.knob") == "working"
    assert window.get_attribute("[data-knob=working]", "aria-expanded") == "false"
    ends = window.evaluate(ENDS.replace("NAME", "working"))
    assert ends
    assert max(ends) <= 1
    window.keyboard.press("Space")
    assert window.locator("[data-state=driving]").count() == 1


def test_on_a_phone_the_top_level_is_read_and_what_is_active_is_opened(opened: Open) -> None:
    window = opened(review(tractor()), viewport=PHONE)
    window.keyboard.press("f")
    seen = window.evaluate(NAMES)
    assert seen["least"] >= LEAST_PX
    assert seen["inside"]
    assert window.locator("[data-state=driving]").count() == 0
    played = opened(review(tractor(), runs=[run_of_steps(tractor_path())]), viewport=PHONE)
    active = played.evaluate("[...review.chart.state.active]")
    assert all(played.locator(f"[data-state={name}]").count() for name in active)


@pytest.mark.parametrize("regions", range(2, 9))
def test_on_a_phone_what_is_active_is_in_view_however_many_regions_are_opened(opened: Open, regions: int) -> None:
    names = [f"region{number}" for number in range(regions)]
    mission = Mission.model_validate(
        {
            "name": "regions",
            "initial": "both",
            "states": {
                "both": {
                    "parallel": {
                        name: {
                            "initial": f"{name}_a",
                            "states": {
                                f"{name}_a": {"transitions": [{"after_s": 1, "to": f"{name}_b"}]},
                                f"{name}_b": {"transitions": [{"after_s": 1, "to": f"{name}_a"}]},
                            },
                        }
                        for name in names
                    },
                    "transitions": [{"after_s": 9, "to": "over"}],
                },
                "over": {"final": "aborted"},
            },
        }
    )
    chart = Chart(mission)
    steps = [chart.start(0.0), *let_time_pass(chart, 2.0)]
    window = opened(review(mission, runs=[run_of_steps(steps)]), viewport=PHONE)
    for _ in steps:
        seen = window.evaluate("[...review.chart.state.active].filter((name) => review.chart.isSeen(name))")
        assert {*seen} & {f"{name}_{end}" for name in names for end in "ab"}
        window.keyboard.press(".")


@pytest.mark.parametrize(
    ("name", "least_px", "some"),
    [
        ("tractor/mission", 10, {"setting_ out", "replanning", "unfinished_ home"}),
        ("rosbot/assist", 10, {"low_ battery", "not_ found", "coming_ back"}),
        ("desk/arrange", 8.99, {"not_ understood", "asking_ model", "done"}),
    ],
)
def test_on_a_phone_the_names_of_a_shipped_mission_are_whole_and_all_are_seen(
    name: str, least_px: float, some: set[str], opened: Open
) -> None:
    window = opened(review(load(ROOT / f"missions/{name}.json")), viewport=PHONE)
    for fitted in (False, True):
        if fitted:
            window.keyboard.press("f")
        seen, written = window.evaluate(NAMES), window.evaluate(WRITTEN)
        assert seen["least"] >= least_px
        assert seen["inside"]
        assert [each for each in written if "…" in each] == []
        assert some <= set(written)
        assert window.evaluate(SPILLED) == []


def test_a_zoom_by_key_keeps_the_chosen_state_else_the_active_one_in_view(opened: Open) -> None:
    window = opened(review(tractor(), runs=[run_of_steps(tractor_path())]), viewport=PHONE)
    for chosen in ("", "signalling"):
        if chosen:
            window.locator(f"[data-state={chosen}] .form").dispatch_event("click")
        kept = chosen or window.evaluate("[...review.chart.state.active].at(-1)")
        for _ in range(12):
            window.keyboard.press("+")
            assert window.evaluate(HELD, kept), kept
        window.keyboard.press("f")


def test_a_group_whose_head_is_out_of_the_window_is_named_at_its_edge(opened: Open) -> None:
    window = opened(review(tractor()), viewport=SCREEN)
    crumb = "document.querySelector('.crumb').textContent"
    assert window.evaluate(crumb) == ""
    window.evaluate("review.go('state', 'driving')")
    for _ in range(14):
        window.keyboard.press("+")
    assert window.evaluate(crumb) == "working"
    window.keyboard.press("f")
    assert window.evaluate(crumb) == ""


def test_the_legend_explains_the_dots_of_arrows_that_end_elsewhere(opened: Open) -> None:
    dots = "getComputedStyle(document.querySelector('#legend .dots')).visibility"
    many = opened(review(MISSIONS["62"]), viewport=SCREEN)
    assert many.locator("svg.chart .sign.stub").count() > 0
    assert many.evaluate(dots) == "visible"
    few = opened(review(tractor()), viewport=SCREEN)
    assert few.locator("svg.chart .sign.stub").count() == 0
    assert few.evaluate(dots) == "hidden"


def test_regions_are_side_by_side_whatever_enters_and_leaves_them(opened: Open) -> None:
    window = opened(review(load(ROOT / "docs/tutorial/5_proof/mission.json")), viewport=SCREEN)
    route, lamp = (
        window.evaluate(f"(({{ top, left, right }}) => [top, left, right])({FORM.replace('NAME', each)})")
        for each in ("route", "lamp")
    )
    assert abs(route[0] - lamp[0]) < 1
    assert route[2] < lamp[1] or lamp[2] < route[1]


@pytest.mark.long
def test_a_very_large_chart_shows_its_progress_while_the_page_is_used(opened: Open) -> None:
    window = opened(review(flat(3000)), viewport=SCREEN)
    while_drawing = """(() => {
      review.chart.change(() => {});
      review.search('s1500');
      const words = (selector) => document.querySelector(selector)?.textContent;
      return [words('#chart .drawing'), Boolean(document.querySelector('#chart progress')), words('#hits')];
    })()"""
    assert window.evaluate(while_drawing) == ["drawing 3000 states", True, "1 found"]
    until(window, "!document.querySelector('#chart progress')")
    assert window.locator(".state").count() == 3000
    assert window.locator(".state.found").get_attribute("data-state") == "s1500"


ENTERED = {
    "format": 1, "name": "entered", "initial": "first", "events": {"go": {}}, "states": {
        "first": {"transitions": [{"on": "go", "to": "b"}]},
        "a_state_with_a_rather_long_name_and_words": {
            "initial": "a", "about": "a long text on what is done inside, which fills the line of the head",
            "states": {"a": {}, "b": {"transitions": [{"on": "go", "to": "a"}]}},
        },
    },
}  # fmt: skip
"""An arrow that leads from above to a state inside another, through its border."""


@pytest.mark.parametrize("name", ["rosbot", "entered"])
def test_no_label_is_crossed_or_covered(name: str, opened: Open) -> None:
    mission = MISSIONS.get(name) or Mission.model_validate(ENTERED)
    window = opened(review(mission), viewport=SCREEN, color_scheme="dark")
    window.evaluate(NEARER)
    assert window.evaluate(CROSSED) == []
    assert window.evaluate(COVERED) == []


THROUGH = """[...document.querySelectorAll('.state.final')].flatMap((state) => {
  const form = state.querySelector('.second'), texts = [...state.querySelectorAll(':scope > .texts text')];
  return texts.filter((text) => {
    const { x, width } = text.getBBox();
    const [y, size] = ['y', 'font-size'].map((each) => Number(text.getAttribute(each)));
    const [, dx, dy] = text.parentNode.getAttribute('transform').match(/([-0-9.]+),([-0-9.]+)/).map(Number);
    const inside = (atX, atY) => form.isPointInFill(new DOMPoint(atX + dx, atY + dy));
    return [x + 0.5, x + width - 0.5].some((at) => ![y - 0.7 * size, y].every((atY) => inside(at, atY)));
  }).map((text) => text.textContent);
})"""
"""Names of ends through which a line of the end's own form goes."""


@pytest.mark.parametrize("size", [SCREEN, PHONE], ids=["screen", "phone"])
@pytest.mark.parametrize("name", ["missions/tractor/mission", "missions/rosbot/assist", "missions/desk/arrange"])
def test_no_line_of_an_end_runs_through_its_name_and_no_part_of_a_name_is_broken(
    name: str, size: dict[str, int], opened: Open
) -> None:
    mission = load(ROOT / f"{name}.json")
    window = opened(review(mission), viewport=size)
    assert window.evaluate(THROUGH) == []
    written = {name: {part.strip() for part in name.replace("_", "_ ").split()} for _, name, _ in mission.walk()}
    for state, parts in written.items():
        lines = window.locator(f"[data-state={state}] > .texts text").all_text_contents()
        for line in lines if "".join(lines) == state else []:
            assert any(line.startswith(part) for part in parts) and any(line.endswith(part) for part in parts), lines
