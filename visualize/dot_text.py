# SPDX-License-Identifier: Apache-2.0
"""A picture as DOT: states that hold others are clusters, options are fields that transitions leave from.

Rule: the text is the same for the same picture, to the byte; every transition is in it once for each target. A
behaviour tree is one node: Graphviz keeps no order among the nodes of a cluster, and a tree's order is its meaning.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator

from visualize.dot_labels import (
    anywhere_table,
    cluster_table,
    decision_table,
    edge_table,
    state_table,
    tab_table,
    title_table,
    transition_text,
    tree_table,
)
from visualize.model import Initial, Path, Picture, PictureEdge, PictureNode
from visualize.style import FONT, INK, MARKS, MUTED, clean, look_of

__all__ = ("dot_text", "quoted")

ANYWHERE, START = "#anywhere", "#start"
"""No state has such a name."""
SMALL = 60
"""Up to so many edges the layout may take its time: transitions lead down the page even out of clusters. The time
grows with the cube of the size, so larger missions are laid out cluster by cluster, with fewer passes."""
HUB = 8
"""In larger missions, transitions to a state that more than these lead to are written in the states that they leave:
as arrows they would cross all others, and take most of the time."""
HOLDERS = ("states", "parallel", "each")


def quoted(given: str) -> str:
    """A string of DOT that reads as given, in names and in texts with escapes alike."""
    escaped = clean(given).replace("\\", "\\\\").replace('"', '\\"').replace("&", "&amp;").replace("\n", "\\n")
    return f'"{escaped}"'


def attributes(**given: str | float | None) -> str:
    """`[a=…, b=…]`; a label in angle brackets is as it is."""
    texts = {
        name: value if isinstance(value, str) else f"{value:g}"
        for name, value in given.items()
        if value not in (None, "")
    }
    parts = (f"{name}={text if text.startswith('<<table') else quoted(text)}" for name, text in texts.items())
    return f"[{', '.join(parts)}]"


def dot_text(picture: Picture, *, dpi: int | None = None) -> str:
    """The DOT of a picture."""
    return "\n".join([*_Sheet(picture).lines(dpi), ""])


class _Sheet:
    """A picture with its states found by their parents, and the ends of its edges."""

    def __init__(self, picture: Picture) -> None:
        self.picture, self.children, self.begins = picture, picture.children, picture.begins
        self.depth = _depths(picture)
        self.small = len(picture.edges) <= SMALL
        into = Counter(edge.target for edge in picture.edges)
        hubs = set() if self.small else {target for target, count in into.items() if count > HUB}
        self.staying: dict[str, list[PictureEdge]] = defaultdict(list)
        """The transitions that are written in their source, for they keep it active or lead to a hub."""
        self.arrows: list[PictureEdge] = []
        for edge in picture.edges:
            is_written = not edge.target or (edge.target in hubs and not edge.option)
            if edge.source and is_written:
                self.staying[edge.source].append(edge)
            elif edge.target:
                self.arrows.append(edge)
        self.tabs = {edge.source for edge in self.arrows if self._from_tab(edge)}
        """The holders with transitions to something inside themselves: those leave from a tab, not from the border."""
        self.exits = {edge.source for edge in self.arrows if self.small and self._from_exit(edge)}
        """The holders with transitions that lead on from their border: those leave from below all that is inside."""
        self.own = {(edge.mark, edge.place): edge for edge in picture.edges if not edge.source}
        """The mission's own transitions, each once however many targets it has."""
        self.ports = {key: f"r{index}" for index, key in enumerate(self.own)}

    def lines(self, dpi: int | None) -> Iterator[str]:
        run, small = bool(self.picture.steps), self.small
        graph = attributes(
            rankdir="TB",
            compound="true",
            newrank="true" if small else None,
            fontname=FONT,
            nodesep=0.35,
            ranksep=0.55,
            pad=0.3,
            labelloc="t",
            labeljust="l",
            label=title_table(self.picture),
            bgcolor="#FFFFFF",
            dpi=dpi,
            outputorder="edgesfirst",
            splines=None if small else "polyline",
            nslimit=None if small else 2,
            nslimit1=None if small else 2,
            mclimit=None if small else 0.2,
        )
        yield f"digraph {quoted(self.picture.name)} {{"
        yield f"  graph {graph};"
        yield f"  node {attributes(fontname=FONT, fontsize=10, color=MUTED, fontcolor=INK, margin='0.08,0.05')};"
        yield f"  edge {attributes(fontname=FONT, fontsize=9, color='#8A8A8A' if run else INK, arrowsize=0.8)};"
        yield f"  {quoted(START)} {attributes(shape='point', width=0.16, color=INK, tooltip='the start')};"
        yield from self._states("", "  ")
        if self.own:
            ports = [(self.ports[transition], edge) for transition, edge in self.own.items()]
            own = attributes(shape="plain", label=anywhere_table(ports), tooltip="the mission's own transitions")
            yield f"  {quoted(ANYWHERE)} {own};"
        yield from (f"  {self._begin(initial)};" for initials in self.begins.values() for initial in initials)
        yield from (f"  {self._edge(edge)};" for edge in self.arrows)
        yield "}"

    def _states(self, parent: str, indent: str) -> Iterator[str]:
        for node in self.children[parent]:
            if node.kind in HOLDERS:
                yield from self._cluster(node, indent)
            else:
                yield f"{indent}{quoted(node.name)} {self._state(node)};"

    def _cluster(self, node: PictureNode, indent: str) -> Iterator[str]:
        look = look_of(node)
        line = MARKS[node.mark][1] if node.mark else "dashed" if node.region else ""
        given = attributes(
            label=cluster_table(node, self.staying[node.name]),
            labeljust="l",
            labelloc="t",
            margin=10,
            fillcolor=look.fill,
            style=f"rounded,filled,{line}" if line else "rounded,filled",
            color=MARKS[node.mark][0] if node.mark else look.pen,
            penwidth=_pen(node.entered, node.mark, 1.2),
            id=node.place,
            tooltip=_tip(node),
        )
        yield f"{indent}subgraph {quoted('cluster_' + node.name)} {{"
        yield f"{indent}  graph {given};"
        if self.begins[node.name] or (node.kind == "parallel" and not self.children[node.name]):
            yield f"{indent}  {quoted(node.name + '#begin')} {attributes(shape='point', width=0.11, color=INK)};"
        if node.name in self.tabs:
            tab = attributes(shape="box", style="rounded", label=tab_table(node), height=0.2)
            yield f"{indent}  {quoted(node.name + '#tab')} {tab};"
        for child in self.children[node.name]:
            if child.kind == "history" and self.begins[node.name]:
                yield f"{indent}  {quoted(node.name + '#begin')} -> {quoted(child.name)} {attributes(style='invis')};"
        yield from self._states(node.name, f"{indent}  ")
        if node.name in self.exits:
            yield f"{indent}  {quoted(node.name + '#exit')} {attributes(shape='point', width=0.01, style='invis')};"
            below = f"{quoted(node.name + '#exit')} {attributes(style='invis', weight=0)}"
            yield from (f"{indent}  {quoted(last)} -> {below};" for last in self._lasts(node.name))
        yield f"{indent}}}"

    def _state(self, node: PictureNode) -> str:
        look, staying = look_of(node), self.staying[node.name]
        if node.choices or node.twigs:
            table = decision_table if node.choices else tree_table
            label = table(node, staying, bold=bool(node.entered.times))
            return attributes(shape="plain", label=label, id=node.place, tooltip=_tip(node))
        style = "filled,rounded" if look.rounded and look.shape == "box" else "filled"
        return attributes(
            shape=look.shape,
            style=f"{style},{MARKS[node.mark][1]}" if node.mark else style,
            fillcolor=look.fill,
            color=MARKS[node.mark][0] if node.mark else look.pen,
            penwidth=_pen(node.entered, node.mark, 1.4),
            peripheries=2 if node.kind == "final" else None,
            label=state_table(node, staying),
            id=node.place,
            tooltip=_tip(node),
            margin="0.02" if node.kind in ("history", "final") else None,
        )

    def _begin(self, initial: Initial) -> str:
        source = f"{initial.parent}#begin" if initial.parent else START
        tip = f"{initial.parent or self.picture.name} begins with {initial.target}"
        given = attributes(
            lhead=self._border(initial.target),
            weight=3,
            tooltip=tip,
            color=INK,
            penwidth=_pen(initial.taken, "", 1.0),
            arrowhead="vee",
        )
        return f"{quoted(source)} -> {quoted(self._inlet(initial.target))} {given}"

    def _edge(self, edge: PictureEdge) -> str:
        tail, ltail = self._tail(edge)
        bold = edge.taken.times > 0
        pen, style, _ = MARKS[edge.mark] if edge.mark else (INK if bold else "", "", "")
        given = attributes(
            label=edge_table(edge, short=not edge.source),
            ltail=ltail,
            lhead=None if self._nested(edge) else self._border(edge.target),
            color=pen,
            style=style,
            penwidth=_pen(edge.taken, edge.mark, 1.0),
            arrowsize=1.0 if bold else None,
            tooltip=_edge_tip(edge),
            id=f"{edge.place}>{edge.target}",
            constraint="false" if self._is_history(edge.target) else None,
        )
        return f"{tail} -> {quoted(self._inlet(edge.target))} {given}"

    def _tail(self, edge: PictureEdge) -> tuple[str, str | None]:
        """Where an edge leaves: the name with its port, and the cluster whose border it leaves."""
        if not edge.source:
            return f"{quoted(ANYWHERE)}:{self.ports[edge.mark, edge.place]}", None
        if self._from_tab(edge):
            return quoted(f"{edge.source}#tab"), None
        if edge.option:
            return f"{quoted(edge.source)}:{quoted(edge.option)}", None
        if edge.source in self.exits and self._from_exit(edge):
            return quoted(f"{edge.source}#exit"), self._border(edge.source)
        inner = self._inlet(edge.source) if self._leads_back(edge) else self._outlet(edge.source)
        return quoted(inner), self._border(edge.source)

    def _leads_back(self, edge: PictureEdge) -> bool:
        return self.depth.get(edge.target, 0) <= self.depth.get(edge.source, 0)

    def _from_exit(self, edge: PictureEdge) -> bool:
        """Whether an edge leaves a holder downwards, by its border."""
        return self._holds(edge.source) and not self._nested(edge) and not self._leads_back(edge)

    def _lasts(self, name: str) -> Iterator[str]:
        """The nodes inside a holder below which its exit is."""
        for child in self.children[name]:
            if child.name in self.exits:
                yield f"{child.name}#exit"
            elif self._holds(child.name):
                yield from self._lasts(child.name)
            else:
                yield child.name

    def _holds(self, name: str) -> bool:
        """Whether a state holds others, and so is a cluster."""
        return name in self.picture.by_name and self.picture.by_name[name].kind in HOLDERS

    def _is_history(self, name: str) -> bool:
        """A way back: it is where its siblings begin, however late it is taken."""
        return name in self.picture.by_name and self.picture.by_name[name].kind == "history"

    def _from_tab(self, edge: PictureEdge) -> bool:
        return bool(edge.target) and self._holds(edge.source) and self._nested(edge)

    def _nested(self, edge: PictureEdge) -> bool:
        """Whether one end of an edge is the other, or is inside it."""
        return self.picture.within(edge.target, edge.source) or self.picture.within(edge.source, edge.target)

    def _border(self, name: str) -> str | None:
        return f"cluster_{name}" if self._holds(name) else None

    def _inlet(self, name: str) -> str:
        """The node by which an edge reaches a state: of a holder the first thing inside."""
        if not self._holds(name):
            return name
        return f"{name}#begin" if self.begins[name] else self._inlet(self.children[name][0].name)

    def _outlet(self, name: str) -> str:
        """The node by which an edge leaves a state: of a holder the last thing inside."""
        inner = [child.name for child in self.children[name] if child.kind not in ("history", "final")]
        return self._outlet(inner[-1]) if self._holds(name) and inner else self._inlet(name)


def _pen(path: Path, mark: str, plain: float) -> float:
    """How wide a line is."""
    return 3.4 if path.times else 2.2 if mark else plain


def _depths(picture: Picture) -> dict[str, int]:
    """How many transitions away from the start each state is, so that transitions which lead back can be reported."""
    onward: dict[str, list[str]] = defaultdict(list)
    pairs = [(initial.parent, initial.target) for initial in picture.initials]
    pairs += [(node.parent, node.name) for node in picture.nodes if node.region or node.kind == "history"]
    for source, target in [*pairs, *((edge.source, edge.target) for edge in picture.edges if edge.source)]:
        onward[source].append(target)
    depths, wave = {"": 0}, [""]
    for here in wave:
        for name in onward[here]:
            if name not in depths:
                depths[name] = depths[here] + 1
                wave.append(name)
    return depths


def _tip(node: PictureNode) -> str:
    return "\n".join(filter(None, (f"{node.name}: {node.title or look_of(node).word}", node.about, *node.lines)))


def _edge_tip(edge: PictureEdge) -> str:
    return "\n".join(
        filter(None, (f"{edge.source or 'every state'} → {edge.target}: {transition_text(edge)}", edge.about))
    )
