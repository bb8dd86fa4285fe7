# SPDX-License-Identifier: Apache-2.0
"""Colours that readers with any colour blindness can distinguish, and that never are alone."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import pytest

import visualize
from tests.visualize.colours import BLINDNESSES, distance
from visualize.style import LOOKS, MARKS, OUTCOMES

CSS = (Path(visualize.__file__).parent / "page/assets/page.css").read_text(encoding="utf-8")
COLOURS = re.findall(r"--([a-z-]+): light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\);", CSS)
THEMES = {"light": {name: light for name, light, _ in COLOURS}, "dark": {name: dark for name, _, dark in COLOURS}}


def nearest(colours: set[str], blindness: str) -> float:
    return min(distance(one, other, blindness) for one, other in combinations(colours, 2))


@pytest.mark.parametrize("blindness", BLINDNESSES)
def test_what_changed_can_be_reported_from_what_came_and_went(blindness: str) -> None:
    assert nearest({pen for pen, _, _ in MARKS.values()}, blindness) > 20


@pytest.mark.parametrize("blindness", BLINDNESSES)
def test_the_kinds_of_states_can_be_distinguished(blindness: str) -> None:
    assert nearest({look.pen for look in (*LOOKS.values(), *OUTCOMES.values())}, blindness) > 10


@pytest.mark.parametrize("blindness", BLINDNESSES)
@pytest.mark.parametrize("theme", THEMES)
def test_the_lines_of_the_page_can_be_distinguished_and_read(theme: str, blindness: str) -> None:
    """Twice what an eye can just report; which kind it is is in words on each."""
    colours = THEMES[theme]
    lines = {colours[name] for name in ("blue", "sky", "orange", "green", "purple", "red", "group-line")}
    assert len(lines) == 7
    assert nearest(lines, blindness) > 4.6
    assert min(distance(line, colours["paper"], blindness) for line in lines) > 30


def luminance(colour: str) -> float:
    """The relative luminance of WCAG 2.2, from 0 to 1."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in parts]
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("theme", THEMES)
def test_every_colour_of_text_can_be_read_on_the_page(theme: str) -> None:
    """A contrast of 4.5, which WCAG 2.2 asks of text (1.4.3)."""
    colours = THEMES[theme]
    sheets = "".join(each.read_text(encoding="utf-8") for each in Path(visualize.__file__).parent.rglob("*.css"))
    texts = set(re.findall(r"(?<![-\w])color: var\(--([a-z-]+)\)", sheets)) - {"paper", "ground"}
    assert len(texts) >= 5
    for text in texts:
        for ground in ("paper", "ground"):
            one, other = sorted(luminance(colours[name]) for name in (text, ground))
            assert (other + 0.05) / (one + 0.05) >= 4.5, (text, ground)


def test_the_page_has_a_light_and_a_dark_theme() -> None:
    assert luminance(THEMES["light"]["paper"]) > 0.9
    assert luminance(THEMES["dark"]["paper"]) < 0.1
    assert CSS.count("light-dark(") == len(COLOURS)


def test_nothing_is_reported_by_colour_alone() -> None:
    looks = [*LOOKS.values(), *OUTCOMES.values()]
    assert len({look.word for look in looks}) == len(looks)
    assert len({style for _, style, _ in MARKS.values()}) == len(MARKS) == len({word for _, _, word in MARKS.values()})


def test_a_simulated_reader_sees_what_the_model_reports() -> None:
    """Black and white stay, and the pure red and green that a deuteranope confuses come close together."""
    for blindness in BLINDNESSES:
        assert distance("#000000", "#ffffff", blindness) == pytest.approx(100, abs=0.5)
    assert distance("#8a7a00", "#b06a00", "none") > 3 * distance("#8a7a00", "#b06a00", "deuteranopia")
