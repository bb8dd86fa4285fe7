# SPDX-License-Identifier: Apache-2.0
"""Mermaid and Markdown: every transition is there, and no text of an author is read as more than text."""

from __future__ import annotations

import html
import re

from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from rai_missions.mission.mission import Mission
from rai_missions.states import Compound
from rai_missions.states import Tree as TreeState
from tests.strategies import missions
from tests.visualize import grammar
from tests.visualize.runs import hostile, tractor, tractor_path
from visualize import mermaid as mermaids
from visualize import picture
from visualize import table as tables
from visualize.dot_text import dot_text
from visualize.mermaid import mermaid
from visualize.page import review
from visualize.style import clean
from visualize.table import table


@given(missions())
def test_every_transition_is_an_arrow_of_the_diagram(mission: Mission) -> None:
    drawn = picture(mission)
    read = grammar.read(mermaid(drawn))
    name = dict(zip(read.states, [node.name for node in drawn.nodes], strict=False)) | {"every_state": ""}
    arrows = [(name[source], name[target]) for source, target, _ in read.arrows if source != "[*]"]
    transitions = [(edge.source, edge.target or edge.source) for edge in drawn.edges]
    assert arrows == [
        *(ends for ends in transitions if len({*ends}) > 1),
        *dict.fromkeys(e for e in transitions if len({*e}) == 1),
    ]
    begins = sorted(name[target] for source, target, _ in read.arrows if source == "[*]")
    assert begins == sorted(initial.target for initial in drawn.initials)


def test_a_diagram_of_hostile_texts_can_be_read() -> None:
    read = grammar.read(mermaid(picture(hostile())))
    shown = html.unescape(" ".join(read.states.values()).replace("#", "&#").replace("<br/>", " "))
    assert "<img src=x onerror=alert(1)>" in shown  # as text
    assert "<img" not in mermaid(picture(hostile()))


@given(st.text(max_size=60))
def test_mermaid_shows_a_text_as_it_is(text: str) -> None:
    written = mermaids.escaped(text)
    assert not set(written) & set('<>"`{}[]|%&\\:\n')
    assert re.sub(r"#(\d+);", lambda found: chr(int(found[1])), written) == clean(text).replace("\n", " ")


def test_a_diagram_that_mermaid_refuses_for_its_size_states_it() -> None:
    texts = [f"{number} " + "long " * 100 for number in range(120)]
    states = {f"s{number}": {"entry": [{"say": text}]} for number, text in enumerate(texts)}
    large = Mission.model_validate({"format": 1, "name": "large", "initial": "s0", "states": states})
    text = mermaid(picture(large))
    assert re.search(r"^    %% \d+ characters, and Mermaid draws 50000 unless", text, re.MULTILINE)
    assert "%%" not in mermaid(picture(tractor()))
    assert len(grammar.read(text).states) == 120


@given(st.text("ab*_`<>|\\[]()~#&!$ 漢\n", max_size=40))
def test_markdown_shows_a_text_as_it_is(text: str) -> None:
    rendered = MarkdownIt("gfm-like", {"linkify": False}).render(f"| a |\n| --- |\n| x{tables.escaped(text)}x |\n")
    cell = re.search(r"<td>(.*)</td>", rendered, re.DOTALL)
    assert cell is not None
    assert "<" not in cell[1]
    assert html.unescape(cell[1]) == "x" + text.replace("\n", " ") + "x"


@given(missions())
def test_the_table_has_a_line_a_row(mission: Mission) -> None:
    rendered = MarkdownIt("gfm-like", {"linkify": False}).render(table(picture(mission)))
    first = rendered.partition("</table>")[0]
    transitions = [
        *mission.transitions,
        *(transition for _, _, state in mission.walk() for transition in state.transitions),
    ]
    assert first.count("<tr>") == len(transitions) + 1


def test_the_table_counts_what_was_taken() -> None:
    text = table(picture(tractor(), tractor_path()))
    assert "| state | trigger | guard | to | do | taken |" in text
    assert "| driving | anomaly |  | assessing | signals := 0 | **2× in steps 2, 5** |" in text
    assert "| driving | succeeded |  | done |  |  |" in text
    assert "A run of 6 steps: aborted, 'aborted' was reached." in text


def test_a_behaviour_in_python_is_drawn_by_the_name_of_its_factory() -> None:
    def spray() -> None: ...

    around = Compound(initial="t", states={"t": TreeState(spray, tick_s=0.5)})
    mission = Mission("m", initial="around", states={"around": around})
    [twig] = picture(mission).by_name["t"].twigs
    assert twig.text.endswith("spray; ticked every 0.5 s")
    assert "spray" in dot_text(picture(mission))
    assert b"spray" in review(mission)
