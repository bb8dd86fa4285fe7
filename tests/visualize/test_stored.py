# SPDX-License-Identifier: Apache-2.0
"""The pictures as text, against those that were looked at and stored; `make pictures` draws them again."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from benchmarks.bench_draw import chain
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from tests.visualize.changed import changed
from tests.visualize.runs import ROOT, hostile, tractor, tractor_path
from visualize import difference, draw_review, drawn, picture
from visualize.model import Picture

STORED = Path(__file__).parent / "stored"
REWRITE = os.environ.get("REWRITE_PICTURES") == "1"


def shipped() -> list[Path]:
    return [*sorted((ROOT / "missions").glob("*/mission.json")), ROOT / "missions/rosbot/assist.json"]


def pictures() -> dict[str, Picture]:
    found = {f"{path.parent.name}_{path.stem}": picture(_read(path)) for path in shipped()}
    found["tractor_path"] = picture(tractor(), tractor_path())
    found["hostile"] = picture(hostile())
    found["tractor_changed"] = difference(tractor(), changed()).picture
    return found


def _read(path: Path) -> Mission:
    return load(path)


def compare(path: Path, data: bytes) -> None:
    if REWRITE:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
    assert path.exists(), f"{path.name} is not stored; look at the picture and run `make pictures`"
    assert data.decode() == path.read_text(encoding="utf-8"), f"{path.name} has changed; look at it and `make pictures`"


@pytest.mark.parametrize("form", ["dot", "mmd", "md"])
@pytest.mark.parametrize("name", pictures())
def test_a_picture_is_as_it_was_looked_at(name: str, form: str) -> None:
    compare(STORED / f"{name}.{form}", drawn(pictures()[name], form))


def test_the_difference_reads_as_it_was_looked_at() -> None:
    compare(STORED / "tractor_changed.txt", "\n".join((*difference(tractor(), changed()).lines(), "")).encode())


@pytest.mark.parametrize("path", shipped(), ids=lambda path: f"{path.parent.name}_{path.stem}")
def test_a_shipped_mission_has_its_picture_next_to_it(path: Path) -> None:
    """Its places and words, not its coordinates, which each Graphviz lays out a little otherwise."""
    target = path.with_suffix(".svg")
    data = drawn(picture(_read(path)), "svg")
    if REWRITE:
        target.write_bytes(data)
    assert target.exists(), f"{target} is missing; run `make pictures`"
    assert _texts(target.read_bytes()) == _texts(data), f"{target} shows another mission; run `make pictures`"


def _texts(svg: bytes) -> set[str]:
    return {line for line in svg.decode().splitlines() if line.startswith("<title>") or 'id="/' in line}


def test_no_stored_picture_is_left_over() -> None:
    forms = {f"{name}.{form}" for name in pictures() for form in ("dot", "mmd", "md")} | {"tractor_changed.txt"}
    assert {path.name for path in STORED.iterdir()} == forms


def test_the_guide_measured_the_missions_and_pages_of_today(tmp_path: Path) -> None:
    guide = (ROOT / "docs/guide/drawing.md").read_text(encoding="utf-8")
    sizes = re.search(r"^\| the review page \| .*, ([\d.]+) MB \| .*, ([\d.]+) MB \|$", guide, re.MULTILINE)
    assert sizes is not None
    measured = {"tractor, ": load(ROOT / "missions/tractor/mission.json"), "": chain(500)}
    for (name, mission), size in zip(measured.items(), sizes.groups(), strict=True):
        drawing = picture(mission)
        assert f"| {name}{len(drawing.nodes)} states, {len(drawing.edges)} transitions |" in guide
        draw_review(mission, tmp_path / "page.html")
        assert (tmp_path / "page.html").stat().st_size / 1e6 == pytest.approx(float(size), rel=0.1)
