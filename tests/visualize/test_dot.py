# SPDX-License-Identifier: Apache-2.0
"""DOT that Graphviz reads, with every transition in it, and text that stays text and stays in its box."""

from __future__ import annotations

import io
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from html import unescape
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.bench_draw import chain
from rai_missions.errors import UsageError, install_command
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.strategies import missions
from tests.visualize.runs import document, hostile, tractor, tractor_path
from visualize import graphviz as dot
from visualize.build import picture
from visualize.dot_text import dot_text, quoted
from visualize.graphviz import KNOWN, layout_program, render
from visualize.rasterize import can_raster, raster
from visualize.style import clean, width, wrapped

MISSIONS = Path(__file__).parents[2] / "missions"
SVG = "{http://www.w3.org/2000/svg}"
LACKED = "\u07ff\ue123"
"""Characters that no font has, of two and of three bytes, which place their box differently."""
TRANSITION = re.compile(r'id="([^"]*/transitions/\d+)>([a-z0-9_/]*)"')


def svg(mission: Mission) -> ElementTree.Element:
    return ElementTree.fromstring(render(picture(mission), "svg"))


@given(missions())
def test_every_transition_is_an_arrow_for_each_target_or_is_in_its_state(mission: Mission) -> None:
    drawn = picture(mission)
    text = dot_text(drawn)
    assert Counter(TRANSITION.findall(unescape(text))) == Counter(
        (edge.place, edge.target) for edge in drawn.edges if edge.target
    )
    staying = {edge.place for edge in drawn.edges if not edge.target}
    assert text.count("stays: ") + text.count("stays where it is") == len(staying)


def test_in_a_large_picture_transitions_into_a_hub_are_written_in_their_states() -> None:
    drawn = picture(chain(100))
    text = dot_text(drawn)
    wanted = Counter((edge.place, edge.target) for edge in drawn.edges if edge.target)
    assert Counter(TRANSITION.findall(unescape(text))) == wanted
    assert '-> "done" ' not in text
    assert text.count("→ done: on halt") >= 90
    assert '-> "done" ' in dot_text(picture(chain(20)))


@settings(max_examples=10)
@given(missions())
def test_graphviz_reads_what_is_written_and_draws_every_state(mission: Mission) -> None:
    drawn = svg(mission)
    ids = {element.get("id") for element in drawn.iter(f"{SVG}g")}
    assert {place for place, _, _ in mission.walk()} <= ids


def test_the_same_picture_gives_the_same_bytes() -> None:
    assert dot_text(picture(tractor())) == dot_text(picture(tractor()))
    assert render(picture(tractor()), "svg") == render(picture(tractor()), "svg")


def test_hostile_text_is_shown_as_it_is_and_is_nothing_else() -> None:
    drawn = svg(hostile())
    shown = "".join("".join(element.itertext()) for element in drawn.iter(f"{SVG}text")).replace("\u00a0", " ")
    assert {element.tag.removeprefix(SVG) for element in drawn.iter()} <= {
        "svg",
        "g",
        "a",
        "title",
        "text",
        "path",
        "polygon",
        "ellipse",
        "polyline",
    }
    assert r"""<script>alert(1)</script> " ' \N \E \l & &amp; ]]> --> | `x` """ in shown
    assert "漢字" in shown
    assert "العربية" in shown
    assert "😀" in shown


@given(st.text(st.characters(codec="utf-8", exclude_characters="\n\r"), max_size=60))
def test_a_quoted_text_reads_as_given(text: str) -> None:
    inner = quoted(text)[1:-1]
    assert '"' not in inner.replace('\\"', "")
    back = inner.replace("&amp;", "&").replace('\\"', '"').replace("\\\\", "\\")
    assert back == clean(text)


@given(st.text(max_size=80), st.sampled_from([40.0, 100.0, 210.0]))
def test_a_line_is_never_wider_than_asked_unless_it_is_one_character(text: str, limit: float) -> None:
    for line in wrapped(text, 10, limit, lines=1000):
        assert width(line, 10) <= limit or len(line.strip()) <= 1


@pytest.mark.parametrize(
    ("text", "ems", "bold_ems"),
    [
        ("achieved when alleys_driven ≥ alleys", 18.8, 20.97),
        ("MAXIMUM WIDTH WARNING", 13.92, 15.7),
        ("Überprüfung läuft für Straße", 14.22, 16.29),
        ("Что делать с препятствием?", 15.13, 16.4),
        ("Τι να κάνει το όχημα;", 10.79, 12.05),
        ("ماذا تفعل الجرارة الآن", 9.19, 10.96),
        ("/ signals := 0; crossings += 1", 14.84, 16.47),
    ],
)
def test_a_text_is_reckoned_as_wide_as_the_widest_font_sets_it(text: str, ems: float, bold_ems: float) -> None:
    """DejaVu Sans, measured; and not more than twice that, or pictures would be empty boxes."""
    assert ems <= width(text, 1) <= 2 * ems
    assert bold_ems <= width(text, 1, bold=True) <= 2 * bold_ems


@given(st.text("ab_漢 é.", max_size=80))
def test_wrapping_loses_nothing(text: str) -> None:
    assert "".join("".join(wrapped(text, 10, 60, lines=1000)).split()) == "".join(text.split())


def test_no_label_in_a_box_is_wider_or_higher_than_the_box() -> None:
    """In the reader's font, which may be the widest of them, not in the one that the layout knew."""
    for group in svg(hostile()).iter(f"{SVG}g"):
        shapes = [*group.iter(f"{SVG}polygon"), *group.iter(f"{SVG}path"), *group.iter(f"{SVG}ellipse")]
        if group.get("class") != "node" or not shapes:
            continue
        right = max(_right(shape) for shape in shapes)
        top, bottom = min(_height(shape)[0] for shape in shapes), max(_height(shape)[1] for shape in shapes)
        for text in group.iter(f"{SVG}text"):
            size = float(text.get("font-size", "10"))
            wide = width("".join(text.itertext()), size, bold=text.get("font-weight") == "bold")
            assert float(text.get("x", "0")) + wide <= right + 6, "".join(text.itertext())
            assert top <= float(text.get("y", "0")) - 0.76 * size, "".join(text.itertext())
            assert bottom >= float(text.get("y", "0")) + 0.24 * size, "".join(text.itertext())


def _height(shape: ElementTree.Element) -> tuple[float, float]:
    if shape.tag == f"{SVG}ellipse":
        middle, radius = float(shape.get("cy", "0")), float(shape.get("ry", "0"))
        return middle - radius, middle + radius
    found = re.findall(r"-?[\d.]+,(-?[\d.]+)", shape.get("points") or shape.get("d") or "")
    return min(map(float, found)), max(map(float, found))


def _right(shape: ElementTree.Element) -> float:
    if shape.tag == f"{SVG}ellipse":
        return float(shape.get("cx", "0")) + float(shape.get("rx", "0"))
    return max(float(x) for x, _ in re.findall(r"(-?[\d.]+),(-?[\d.]+)", shape.get("points") or shape.get("d") or ""))


LIFT = Mission.model_validate({
    "name": "lift", "initial": "working", "events": ["gate"],
    "blackboard": {"height": {"type": "number", "source": "robot", "max_age_s": 1}},
    "states": {
        "working": {
            "parallel": {
                "moving": {"initial": "lifting", "states": {
                    "lifting": {"action": "lift", "timeout_s": 20, "transitions": [
                        {"on": "succeeded", "to": "putting"}, {"on": "failed", "to": "stuck"}]},
                    "putting": {"action": "put", "timeout_s": 9, "transitions": [{"on": "succeeded", "to": "placed"}]},
                    "placed": {"final": "succeeded"},
                }},
                "looking": {"initial": "seen", "states": {"seen": {"final": "succeeded"}}},
            },
            "transitions": [
                {"on": "succeeded", "to": "done"}, {"on": "gate", "to": "stuck"},
                {"when": {"not": {"fresh": "height"}}, "to": "stuck"},
            ],
        },
        "done": {"final": "succeeded", "requires": {"key": "height", ">=": 3}},
        "stuck": {"final": "aborted"},
    },
})  # fmt: skip


@pytest.mark.parametrize("mission", [LIFT, load(MISSIONS / "rosbot" / "mission.json")], ids=lambda each: each.name)
def test_what_leaves_a_group_by_its_border_is_labelled_outside(mission: Mission) -> None:
    drawn = picture(mission)
    groups = {group.get("id"): group for group in svg(mission).iter(f"{SVG}g")}
    borders = {name: groups[node.place] for name, node in drawn.by_name.items() if drawn.children[name]}
    leaving = [edge for edge in drawn.edges if edge.source in borders and not drawn.within(edge.target, edge.source)]
    assert leaving
    for edge in leaving:
        bottom = max(_height(shape)[1] for shape in borders[edge.source].iter(f"{SVG}path"))
        for text in groups[f"{edge.place}>{edge.target}"].iter(f"{SVG}text"):
            top = float(text.get("y", "0")) - 0.76 * float(text.get("font-size", "10"))
            assert top >= bottom, "".join(text.itertext())


@pytest.mark.timeout(60)
def test_a_mission_of_a_hundred_states_is_laid_out_in_time() -> None:
    """With the ranks of small pictures this takes half a minute, and one of five hundred states hours."""
    transitions = [{"on": "succeeded", "to": "done"}, {"on": "failed", "to": "g0a0"}]
    states = {
        f"g{group}": {
            "initial": f"g{group}a0",
            "states": {
                f"g{group}a{n}": {"action": "go", "timeout_s": 1, "transitions": transitions} for n in range(10)
            },
            "transitions": [{"on": "halt", "to": f"g{(group + 1) % 10}"}],
        }
        for group in range(10)
    }
    given = {"format": 1, "name": "large", "initial": "g0", "events": {"halt": {}}}
    mission = Mission.model_validate({**given, "states": {**states, "done": {"final": "aborted"}}})
    assert "newrank" not in dot_text(picture(mission))
    assert "newrank" in dot_text(picture(tractor()))
    assert svg(mission) is not None


def test_the_path_is_bold_and_counted() -> None:
    text = dot_text(picture(tractor(), tractor_path()))
    anomaly = next(line for line in text.splitlines() if "driving/transitions/0>assessing" in line)
    assert 'penwidth="3.4"' in anomaly
    assert "2× in steps 2, 5" in anomaly
    untaken = next(line for line in text.splitlines() if "driving/transitions/1>done" in line)
    assert 'penwidth="1"' in untaken


def test_fonts_are_portable_and_the_drawing_program_is_not_reported() -> None:
    text = render(picture(tractor()), "svg").decode()
    assert set(re.findall(r'font-family="([^"]*)"', text)) == {
        "Helvetica,Arial,Liberation Sans,DejaVu Sans,Noto Sans,sans-serif"
    }
    assert "Generated by" not in text


def test_a_png_is_one_with_and_without_resvg(monkeypatch: pytest.MonkeyPatch) -> None:
    assert render(picture(tractor()), "png").startswith(b"\x89PNG\r\n")
    monkeypatch.setitem(sys.modules, "resvg_py", None)
    assert not can_raster()
    assert render(picture(tractor()), "png").startswith(b"\x89PNG\r\n")


def test_a_png_reports_of_characters_that_no_font_has(caplog: pytest.LogCaptureFixture) -> None:
    pytest.importorskip("resvg_py")
    given = document()
    given["about"] = "\U0010fffd and \U000f1234"  # of no one, for private use
    render(picture(Mission.model_validate(given)), "png")
    assert "has 2 of the characters" in caplog.text and "\U0010fffd \U000f1234; install a font" in caplog.text
    caplog.clear()
    render(picture(tractor()), "png")
    assert not caplog.records


def test_graphviz_has_letters_for_the_characters_of_which_it_draws_a_png() -> None:
    """Each in a cell of its own, next to some that no font has; only spaces and hyphens may be as empty or as plain."""
    image = pytest.importorskip("PIL.Image")
    shown = [char for char in map(chr, range(0x21, 0x3000)) if KNOWN.fullmatch(char) and char not in "\u00a0\u00ad"]
    cells = [f"&#{ord(char)};" for char in [*shown, *LACKED]]
    rows = [
        "".join(f'<td width="30" height="30" fixedsize="true">{cell}</td>' for cell in cells[at : at + 20])
        for at in range(0, len(cells), 20)
    ]
    table = f'<table border="0" cellborder="0" cellspacing="0">{"".join(f"<tr>{row}</tr>" for row in rows)}</table>'
    source = f"graph {{ graph [margin=0, pad=0]; a [shape=plain, fontname=Helvetica, fontsize=12, label=<{table}>] }}"
    made = subprocess.run(
        [layout_program(), "-Tpng", "-Gdpi=72"], input=source.encode(), capture_output=True, check=True
    )
    picture_ = image.open(io.BytesIO(made.stdout)).convert("L")
    edge = picture_.width // 20

    def cell(index: int) -> bytes:
        left, top = index % 20 * edge, index // 20 * edge
        found: bytes = picture_.crop((left, top, left + edge, top + edge)).tobytes()
        return found

    lacking = {cell(len(shown) + index) for index in range(len(LACKED))}
    assert all(min(each) < 200 for each in lacking)
    assert [char for index, char in enumerate(shown) if cell(index) in lacking or min(cell(index)) > 200] == []


def test_an_svg_is_as_large_as_its_viewer_at_most() -> None:
    root = svg(tractor())
    assert root.get("viewBox") and root.get("width") and root.get("height")
    assert root.get("style") == "max-width:100%;max-height:100vh"


def test_what_is_no_svg_gives_no_png() -> None:
    assert raster(b"<nothing", 96) is None


def test_a_dot_of_the_user_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("graphviz-pure", "dot"):
        program = tmp_path / name
        program.write_text("#!/bin/sh\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))
        assert layout_program() == program


def test_without_graphviz_the_error_states_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(UsageError, match=f"neither `dot` nor `graphviz-pure`.*{re.escape(install_command('draw'))}"):
        render(picture(tractor()), "svg")


def test_what_graphviz_refuses_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "dot"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho no memory >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(UsageError, match=r"could not draw 'tractor_orchard': no memory"):
        dot.render(picture(tractor()), "svg")
