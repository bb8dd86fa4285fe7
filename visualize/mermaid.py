# SPDX-License-Identifier: Apache-2.0
"""A picture as Mermaid's `stateDiagram-v2`, which GitHub and many editors draw.

Rule: no name that Mermaid could misread reaches it: a state is `s1`, `s2`, … with its name and words as a description.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

from visualize.labels import row_text
from visualize.shapes import Edge, Node, Picture
from visualize.style import LOOKS, OUTCOMES, clean, wrapped

__all__ = ("mermaid",)

LIMIT = 260.0
"""Points: how wide a line of a label may become."""
ANYWHERE = "every_state"


def mermaid(picture: Picture) -> str:
    """The Mermaid text of a picture.

    Rows are numbered per label, not drawn apart, where Mermaid would lay them on one another. A run's path is bold: its
    states by a thick border, its rows by their count in the label, for Mermaid cannot style the lines of this diagram.
    """
    return "\n".join([*_lines(picture), ""])


def _lines(picture: Picture) -> Iterator[str]:
    outline = _outline(picture)
    ids, children, _ = outline
    yield "stateDiagram-v2"
    yield f"    accTitle: {escaped(f'{picture.name} {picture.version}')}"
    if picture.about:
        yield f"    accDescr: {escaped(picture.about)}"
    yield from _classes(picture)
    yield from _states("", "    ", outline)
    own = [edge for edge in picture.edges if not edge.source]
    if own:
        yield f'    state "from every state" as {ANYWHERE}'
    for edge in picture.edges:
        yield f"    {_edge(edge, ids)}"
    for node in picture.nodes:
        if not children[node.name]:
            yield f"    class {ids[node.name]} {_class(node)}"
        if node.entered.times and not children[node.name]:
            yield f"    class {ids[node.name]} taken"


def _classes(picture: Picture) -> Iterator[str]:
    looks = {
        _class(node): OUTCOMES[node.outcome] if node.kind == "final" else LOOKS[node.kind] for node in picture.nodes
    }
    for name, look in looks.items():
        line = ",stroke-dasharray:6 3" if name == "decision" else ""
        yield f"    classDef {name} fill:{look.fill},stroke:{look.pen},stroke-width:1.5px,color:#1A1A1A{line}"
    if picture.steps:
        yield "    classDef taken stroke-width:4px,font-weight:bold"


def _class(node: Node) -> str:
    return (
        node.outcome if node.kind == "final" else f"is_{node.kind or 'wait'}" if node.kind != "decision" else "decision"
    )


class _Outline(NamedTuple):
    """The states by their parents."""

    ids: dict[str, str]
    children: dict[str, list[Node]]
    initials: dict[str, list[str]]


def _outline(picture: Picture) -> _Outline:
    children: dict[str, list[Node]] = defaultdict(list)
    initials: dict[str, list[str]] = defaultdict(list)
    for node in picture.nodes:
        children[node.parent].append(node)
    for initial in picture.initials:
        initials[initial.parent].append(initial.target)
    ids = {node.name: f"s{number}" for number, node in enumerate(picture.nodes, start=1)}
    return _Outline(ids, children, initials)


def _states(parent: str, indent: str, outline: _Outline) -> Iterator[str]:
    ids, children, initials = outline
    for target in initials[parent]:
        if target in ids:  # a mission that no check has passed may name any
            yield f"{indent}[*] --> {ids[target]}"
    for index, node in enumerate(children[parent]):
        if index and node.region:
            yield f"{indent}--"
        yield f'{indent}state "{_description(node)}" as {ids[node.name]}' + (" {" if children[node.name] else "")
        if children[node.name]:
            yield from _states(node.name, f"{indent}    ", outline)
            yield f"{indent}}}"


def _description(node: Node) -> str:
    word = {"states": "", "decision": "decision", "tree": "tree", "parallel": "all at once"}.get(node.kind, node.title)
    lines = [f"{node.mark} {node.name}".strip(), word, *node.lines]
    lines += [f"control: {node.control}"] if node.control else []
    for choice in node.choices:
        guard = f" when {choice.guard}" if choice.guard else ""
        lines.append(f"• {choice.name}{guard}" + (" (fallback)" if choice.fallback else ""))
    depth = {"": 0}
    for twig in node.twigs:
        depth[twig.path] = depth.get(twig.parent or "", 0) + 1
        lines.append("· " * depth[twig.path] + twig.text)
    lines += [f"entered {node.entered.words()}"] if node.entered.times else []
    return "<br/>".join(escaped(part) for line in lines if line for part in wrapped(line, 10, LIMIT))


def _edge(edge: Edge, ids: dict[str, str]) -> str:
    source = ids.get(edge.source, ANYWHERE)
    said = [row_text(edge) + ("" if edge.target else " (stays)")]
    said += [edge.taken.words()] if edge.taken.times else []
    text = "<br/>".join(escaped(part) for line in said for part in wrapped(line, 10, LIMIT))
    return f"{source} --> {ids.get(edge.target, source)}: {text}"


def escaped(given: str) -> str:
    """A text as Mermaid shows it: what its grammar or HTML could read as more than text is written by its number."""
    said = clean(given).replace("\n", " ")
    return "".join(character if _harmless(character) else f"#{ord(character)};" for character in said)


def _harmless(character: str) -> bool:
    return character.isalnum() or character in " .,_-+()=/×•·←→≤≥“”–'?!…" or character > "\x7f"
