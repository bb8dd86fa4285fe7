# SPDX-License-Identifier: Apache-2.0
"""Mermaid itself draws our diagrams, and shows every text as it was written.

Needs the npm package `@mermaid-js/tiny`, which is Mermaid with the diagrams that GitHub draws in state diagrams;
`make oracles` installs it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.strategies import missions
from tests.visualize.runs import ROOT, hostile, tractor, tractor_path
from visualize import Picture, picture
from visualize.mermaid import MOST, mermaid
from visualize.style import clean

SCRIPT = ROOT / "tests/oracles/node_modules/@mermaid-js/tiny/dist/mermaid.tiny.js"
RENDER = """async (texts) => {
  const drawn = [];
  for (const text of texts) {
    const { svg } = await mermaid.render(`d${Math.random().toString(36).slice(2)}`, text);
    const box = document.body.appendChild(document.createElement("div"));
    box.innerHTML = svg;
    const all = (what) => [...box.querySelectorAll(what)];
    drawn.push({
      texts: all(".nodeLabel, span.edgeLabel, desc").map((each) => each.innerText ?? each.textContent),
      tags: [...new Set(all(".nodeLabel *, span.edgeLabel *").map((each) => each.tagName.toLowerCase()))],
      arrows: all("path.transition").length,
    });
    box.remove();
  }
  return drawn;
}"""
TEXTS = (
    "_a_ __init__ a_b", "*x* **y** ~~z~~", "1. a\n2. b", "x\n- b\n# c\n> d\n---\n===", "`code` ```x```", "$$x^2$$",
    "#9829; &amp; &lt; <b>x</b> <br/>", "<img src=x onerror=alert(1)>", "%% c %%{init: {}}%%", "end", "}", "{",
    "[*] --> s1", "direction LR", "note left of s1", ":::x", "a\\nb \\\\ \\_", "\" ' ; | /", "[a](http://b.c) ![a](b)",
    "fa:fa-car fas:fa-x", "日本語の質問", "العربية שלום", "हिन्दी ไทย", "😀 é e\u0301", "a\u00a0b \ufeff \u2003 \u200b",
    "classDef x", "state s9 {",
)  # fmt: skip
MEAN = st.text("_*-+#`~[](){}<>|:;&%$@!?.,=/\\\"'^1 0ab\nع漢😀", min_size=1, max_size=30).filter(str.strip)
Draws = Callable[..., list[dict[str, Any]]]

pytestmark = pytest.mark.skipif(not SCRIPT.exists(), reason="Mermaid is not installed: make oracles")


@pytest.fixture(scope="module")
def draws(browser: Any) -> Iterator[Draws]:
    """What Mermaid shows of diagrams; one page for all of them, without a network."""
    context = browser.new_context(offline=True)
    page = context.new_page()
    page.add_script_tag(path=SCRIPT)
    page.evaluate("mermaid.initialize({ startOnLoad: false })")
    yield lambda *texts: page.evaluate(RENDER, list(texts))
    context.close()


def speaking(text: str) -> Mission:
    """A mission with a text wherever a diagram shows one."""
    transitions = [{"on": "go", "to": "e"}]
    options = {"a": {"about": text}, "b": {}}
    return Mission.model_validate({
        "format": 1, "name": "m", "about": text, "events": {"go": {}}, "initial": "q",
        "states": {
            "q": {
                "decision": {"question": text, "options": options, "deadline_s": 5, "fallback": "b"},
                "transitions": [{"on": "a", "to": "w", "do": [{"say": text}]}, {"on": "b", "to": "e"}],
            },
            "w": {"initial": "i", "entry": [{"log": text}], "states": {"i": {"transitions": transitions}}},
            "e": {"final": "succeeded"},
        },
    })  # fmt: skip


def bare(text: str) -> str:
    """Without what breaks lines, which is Mermaid's affair."""
    return re.sub(r"[\s\u2060\ufeff]+", "", clean(text))


def shown_as_written(text: str, results: dict[str, Any]) -> None:
    reported = [bare(each) for each in results["texts"]]
    assert set(results["tags"]) <= {"p", "br", "span"}, text
    for wanted in (f"q decision “{text}”", *(f"{effect} “{text}”" for effect in ("say", "log"))):
        assert any(bare(wanted) in each for each in reported), (text, wanted, results["texts"])
    assert bare(text) in reported or not bare(text)


def arrows(drawn: Picture) -> int:
    """Of a diagram, where the transitions from a state to itself share one."""
    ends = [(edge.source, edge.target or edge.source) for edge in drawn.edges]
    onward = [pair for pair in ends if pair[0] != pair[1]]
    return len(onward) + len({*ends} - {*onward}) + len(drawn.initials)


def shipped() -> list[Path]:
    return sorted((ROOT / "missions").glob("*/mission.json"))


@pytest.mark.parametrize("path", shipped(), ids=lambda path: path.parent.name)
def test_a_shipped_mission_is_drawn_with_all_its_arrows(draws: Draws, path: Path) -> None:
    drawn = picture(load(path))
    [reported] = draws(mermaid(drawn))
    assert reported["arrows"] == arrows(drawn)


def test_a_run_and_hostile_texts_are_drawn(draws: Draws) -> None:
    run, bad = draws(mermaid(picture(tractor(), tractor_path())), mermaid(picture(hostile())))
    assert any("2× in steps 2, 5" in each for each in run["texts"])
    assert any("<script>alert(1)</script>" in each for each in bad["texts"])


def test_a_text_is_shown_as_it_was_written(draws: Draws) -> None:
    for text, reported in zip(TEXTS, draws(*(mermaid(picture(speaking(text))) for text in TEXTS)), strict=True):
        shown_as_written(text, reported)


@settings(max_examples=6, suppress_health_check=list(HealthCheck), phases=[Phase.explicit, Phase.generate])
@given(st.lists(MEAN, min_size=5, max_size=5))
def test_any_text_is_shown_as_it_was_written(draws: Draws, texts: list[str]) -> None:
    for text, reported in zip(texts, draws(*(mermaid(picture(speaking(text))) for text in texts)), strict=True):
        shown_as_written(text, reported)


@settings(max_examples=10, suppress_health_check=list(HealthCheck), phases=[Phase.explicit, Phase.generate])
@given(missions())
def test_a_generated_mission_is_drawn_with_all_its_arrows(draws: Draws, mission: Mission) -> None:
    drawn = picture(mission)
    [reported] = draws(mermaid(drawn))
    assert reported["arrows"] == arrows(drawn)


@pytest.mark.long
def test_a_mission_of_more_rows_than_a_flowchart_may_have_edges_is_drawn(draws: Draws) -> None:
    count = 520
    states: dict[str, Any] = {f"s{n}": {"transitions": [{"on": "go", "to": f"s{n + 1}"}]} for n in range(count)}
    given = Mission.model_validate(
        {"name": "long", "events": {"go": {}}, "initial": "s0", "states": states | {f"s{count}": {"final": "aborted"}}}
    )
    text = mermaid(picture(given))
    assert text.count("-->") == count + 1 and len(text) < MOST
    (reported,) = draws(text)
    assert reported["arrows"] == count + 1
