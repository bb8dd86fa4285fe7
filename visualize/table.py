# SPDX-License-Identifier: Apache-2.0
"""A picture as a Markdown table: every transition of the mission, in the order in which they are tried."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping

from rai_missions.errors import counted
from visualize.model import Picture, PictureEdge
from visualize.style import clean

__all__ = ("table",)

SPECIAL = re.compile(r"([\\`*_\[\]<>|~#!&])")
"""What Markdown, or HTML within it, would read as more than text."""


def table(picture: Picture) -> str:
    """The Markdown of a picture; a transition with several targets is one line."""
    return "\n".join([*_lines(picture), ""])


def _lines(picture: Picture) -> Iterator[str]:
    yield f"# {escaped(picture.title)}"
    if picture.about:
        yield from ("", escaped(picture.about))
    if picture.steps:
        run = ": ".join(filter(None, (f"A run of {counted(picture.steps, 'step')}", picture.ended)))
        yield from ("", f"{escaped(run)}.")
    if picture.notes:
        yield from ("", *(f"- {escaped(note)}" for note in picture.notes))
    yield from ("", _line(*_head(picture)), _line(*("---" for _ in _head(picture))))
    for edges in _transitions(picture).values():
        yield _line(*_cells(picture, edges))
    decisions = [node for node in picture.nodes if node.choices]
    if decisions:
        yield from ("", _line("decision", "option", "offered when", "means"), _line("---", "---", "---", "---"))
    for node in decisions:
        for choice in node.choices:
            name = f"{choice.name} (fallback)" if choice.fallback else choice.name
            yield _line(escaped(node.name), escaped(name), escaped(choice.guard or "always"), escaped(choice.about))
    if picture.invariants:
        yield from ("", "Never false:", "")
    for name, guard in picture.invariants:
        yield f"- {escaped(name)}: {escaped(guard)}"


def _transitions(picture: Picture) -> Mapping[tuple[str, str], list[PictureEdge]]:
    found: dict[tuple[str, str], list[PictureEdge]] = defaultdict(list)
    for edge in picture.edges:
        found[edge.mark, edge.place].append(edge)
    return found


def _head(picture: Picture) -> tuple[str, ...]:
    change = ("",) if picture.compared else ()
    return (*change, "state", "trigger", "guard", "to", "do", *(("taken",) if picture.steps else ()))


def _cells(picture: Picture, edges: list[PictureEdge]) -> Iterator[str]:
    edge = edges[0]
    if picture.compared:
        yield f"**{escaped(edge.mark)}**" if edge.mark else ""
    yield escaped(edge.source) or "*every state*"
    yield escaped(edge.when)
    yield escaped(edge.guard)
    yield " and ".join(escaped(each.target) for each in edges if each.target) or "*stays*"
    yield escaped("; ".join(edge.do))
    if picture.steps:
        yield f"**{escaped(edge.taken.words())}**" if edge.taken.times else ""


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def escaped(given: str) -> str:
    """A text as Markdown shows it, on one line."""
    return SPECIAL.sub(r"\\\1", clean(given)).replace("\n", " ")
