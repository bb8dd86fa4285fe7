# SPDX-License-Identifier: Apache-2.0
"""A picture as Mermaid's `stateDiagram-v2`, which GitHub and many editors draw.

Rule: no name that Mermaid could misread reaches it: a state is `s1`, `s2`, … with its name and words as a description.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path

from visualize.dot_labels import transition_text
from visualize.model import Picture, PictureEdge, PictureNode
from visualize.style import clean, look_of, wrapped
from visualize.text import controlled

__all__ = ("MOST", "mermaid", "oversize")

LIMIT = 260.0
"""Points: how wide a line of a label may become."""
ANYWHERE = "every_state"
MOST = 50_000
"""Characters: what Mermaid (its `maxTextSize`), and with it GitHub, draws at most.

Its `maxEdges` is of flowcharts alone."""
ENDINGS = (".mmd", ".mermaid")
PLAIN = re.compile(
    r"(?<!direction) +|(?<=[^\W_])_(?=[^\W_])|[^\W_]|[.,+()=/×•·←→≤≥“”–'?!…-]|[^\x00-\x7f\s\ufeff]|\u00a0",
    re.IGNORECASE,
)
"""Characters that represent themselves. Any line with `direction LR` in it turns the diagram; `_` is emphasis
outside of words."""
MARKDOWN = re.compile(r"[\\`*~[]|(?<![^\W_])_|_(?![^\W_])")
"""What begins emphasis, code or a link."""
SPECIAL = re.compile(r"\$(?=\$)|:(?=fa-)", re.IGNORECASE)


def mermaid(picture: Picture) -> str:
    """The Mermaid text of a picture.

    Transitions that do not leave their state share an arrow. Of a run's path, states have a thick border and
    transitions their count in the label, for Mermaid cannot style the lines of this diagram.
    """
    text = "\n".join([*_lines(picture), ""])
    if len(text) <= MOST:
        return text
    first, _, rest = text.partition("\n")
    return f"{first}\n    %% {_too_long(text)}\n{rest}"


def oversize(path: Path) -> str:
    """What to know of a file that was drawn: that Mermaid will not draw it; empty for any other."""
    if path.suffix.lower() not in ENDINGS:
        return ""
    text = path.read_text(encoding="utf-8")
    return f"{path}: {_too_long(text)}; .svg and .html have no such limit" if len(text) > MOST else ""


def _too_long(text: str) -> str:
    return f"{len(text)} characters, and Mermaid draws {MOST} unless `maxTextSize` is raised; GitHub draws no more"


def _lines(picture: Picture) -> Iterator[str]:
    ids = {node.name: f"s{number}" for number, node in enumerate(picture.nodes, start=1)}
    yield "stateDiagram-v2"
    yield f"    accTitle: {escaped(f'{picture.name} {picture.version}')}"
    if picture.about.strip():
        yield f"    accDescr: {escaped(picture.about)}"
    yield from _classes(picture)
    yield from _states("", "    ", picture, ids)
    if any(not edge.source for edge in picture.edges):
        yield f'    state "from every state" as {ANYWHERE}'
    yield from (f"    {_arrow(edges, ids)}" for edges in _arrows(picture))
    for node in picture.nodes:
        if not picture.children[node.name]:
            looks = (_class(node), "taken") if node.entered.times else (_class(node),)
            yield from (f"    class {ids[node.name]} {look}" for look in looks)


def _classes(picture: Picture) -> Iterator[str]:
    looks = {_class(node): look_of(node) for node in picture.nodes}
    for name, look in looks.items():
        line = ",stroke-dasharray:6 3" if name == "decision" else ""
        yield f"    classDef {name} fill:{look.fill},stroke:{look.pen},stroke-width:1.5px,color:#1A1A1A{line}"
    if picture.steps:
        yield "    classDef taken stroke-width:4px,font-weight:bold"


def _class(node: PictureNode) -> str:
    return (
        node.outcome if node.kind == "final" else f"is_{node.kind or 'wait'}" if node.kind != "decision" else "decision"
    )


def _states(parent: str, indent: str, picture: Picture, ids: Mapping[str, str]) -> Iterator[str]:
    for initial in picture.begins[parent]:
        if initial.target in ids:  # a mission that no check has passed may name any
            yield f"{indent}[*] --> {ids[initial.target]}"
    for index, node in enumerate(picture.children[parent]):
        if index and node.region:
            yield f"{indent}--"
        holder = bool(picture.children[node.name])
        yield f'{indent}state "{_description(node, holder)}" as {ids[node.name]}' + (" {" if holder else "")
        if holder:
            yield from _states(node.name, f"{indent}    ", picture, ids)
            yield f"{indent}}}"


def _description(node: PictureNode, holder: bool) -> str:
    word = {"states": "", "decision": "decision", "tree": "tree", "parallel": "all at once"}.get(node.kind, node.title)
    lines = [f"{node.mark} {node.name}".strip(), word, *node.lines]
    lines += [controlled(node.control)] if node.control else []
    for choice in node.choices:
        guard = f" when {choice.guard}" if choice.guard else ""
        lines.append(f"• {choice.name}{guard}" + (" (fallback)" if choice.fallback else ""))
    depth = {"": 0}
    for twig in node.twigs:
        depth[twig.path] = depth.get(twig.parent or "", 0) + 1
        lines.append("· " * depth[twig.path] + twig.numbered())
    lines += [f"entered {node.entered.words()}"] if node.entered.times else []
    shown = escaped if holder else described
    return "<br/>".join(shown(part) for line in lines if line for part in wrapped(line, 10, LIMIT))


def _arrows(picture: Picture) -> Iterator[list[PictureEdge]]:
    """The transitions of each arrow: of several from a state to itself, Mermaid 11 would draw the last alone."""
    loops: dict[str, list[PictureEdge]] = defaultdict(list)
    for edge in picture.edges:
        if edge.target not in ("", edge.source):
            yield [edge]
        else:
            loops[edge.source].append(edge)
    yield from loops.values()


def _arrow(edges: list[PictureEdge], ids: dict[str, str]) -> str:
    source, target = ids.get(edges[0].source, ANYWHERE), edges[0].target
    text = "<br/>".join(
        escaped(part)
        for edge in edges
        for line in (transition_text(edge) + ("" if edge.target else " (stays)"), edge.taken.words())
        if line
        for part in wrapped(line, 10, LIMIT)
    )
    return f"{source} --> {ids.get(target, source)}: {text}"


def escaped(given: str) -> str:
    """A text as Mermaid shows it: what its grammar or HTML could read as more than text is written by its number."""
    text = clean(given).replace("\n", " ")
    plain = {at for found in PLAIN.finditer(text) for at in range(*found.span())}
    return "".join(each if at in plain else f"#{ord(each)};" for at, each in enumerate(text))


def described(given: str) -> str:
    """The text of a state with nothing inside, which Mermaid reads as Markdown once its numbers are characters again.

    No backslash helps against a formula (`$$`) or an icon (`:fa-`); a word joiner does, which no one sees.
    """
    return escaped(MARKDOWN.sub(r"\\\g<0>", SPECIAL.sub("\\g<0>\u2060", clean(given))))
