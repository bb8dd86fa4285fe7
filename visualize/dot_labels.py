# SPDX-License-Identifier: Apache-2.0
"""What is on a state, an option, a transition and the legend, as Graphviz's HTML-like labels.

Rule: every piece of text passes through `text`, which breaks, escapes and measures it; a line is one piece, set to the
left, so that it stays in its box whatever font the reader has.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from rai_missions.errors import counted
from visualize.model import Choice, Picture, PictureEdge, PictureNode, Twig
from visualize.style import INK, LOOKS, MARKS, MUTED, clean, look_of, width, wrapped
from visualize.text import controlled

__all__ = (
    "anywhere_table",
    "cluster_table",
    "decision_table",
    "edge_table",
    "state_table",
    "tab_table",
    "title_table",
    "transition_text",
    "tree_table",
)  # fmt: skip

COLUMN, LINE, LABEL = 150.0, 210.0, 150.0
"""Points: how wide an option, a line of a state and a transition's label may become."""
SIDE_BY_SIDE = 5
"""More options than these are below one another."""
NOTES = 12
"""More notes than these would bury the picture."""


def text(
    given: str, size: float = 10, *, bold: bool = False, color: str = INK, limit: float = LINE, name: str = ""
) -> str:
    """A row with a cell that holds a text, broken into lines of at most `limit` points; `name` is its id in an SVG."""
    broken = wrapped(given, size, limit, bold=bold)
    if not "".join(broken).strip():
        return ""
    parts = [f"<b>{shown(line)}</b>" if bold else shown(line) for line in broken]
    body = '<br align="left"/>'.join(parts) + ('<br align="left"/>' if len(parts) > 1 else "")
    wide = max(width(line, size, bold=bold) for line in broken) + 4
    given_id = f' id="{escape(name)}"' if name else ""
    return (
        f'<tr><td align="left" balign="left" width="{wide:.0f}"{given_id}>'
        f'<font point-size="{size:g}" color="{color}">{body}</font></td></tr>'
    )


def shown(given: str) -> str:
    """A text as a label shows it; a backslash would begin one of Graphviz's own escapes even here."""
    return escape(clean(given)).replace("\\", "\\\\")


def small(given: str, *, bold: bool = False, color: str = MUTED, limit: float = LINE, name: str = "") -> str:
    """A row in small print."""
    return text(given, 9, bold=bold, color=color, limit=limit, name=name)


PLAIN = 'border="0" cellborder="0" cellspacing="0" cellpadding="1"'


def table(rows: Iterable[str], more: str = PLAIN) -> str:
    """An HTML-like label of rows."""
    return f"<{inner_table(rows, more)}>"


def inner_table(rows: Iterable[str], more: str = PLAIN) -> str:
    """A table inside a cell; never without rows, which Graphviz would refuse."""
    return f"<table {more}>{''.join(rows) or '<tr><td></td></tr>'}</table>"


def field_rows(fields: Sequence[str], *, side_by_side: bool) -> str:
    """Cells in one row, or in a row each."""
    return f"<tr>{''.join(fields)}</tr>" if side_by_side else "".join(f"<tr>{field}</tr>" for field in fields)


def marked(mark: str, text: str) -> str:
    return f"{mark} {text}" if mark else text


def transition_text(edge: PictureEdge) -> str:
    """A transition in a line: `on anomaly [guard] / effects`."""
    do = "; ".join(edge.do)
    guard = f" {edge.guard}" if not edge.trigger else f" [{edge.guard}]" if edge.guard else ""
    return marked(edge.mark, f"{'on ' if on_event(edge) else ''}{edge.when}{guard}" + (f" / {do}" if do else ""))


def on_event(edge: PictureEdge) -> bool:
    return bool(edge.trigger) and not edge.trigger.startswith("after ")


def _name(node: PictureNode) -> str:
    was = f" (was {node.was})" if node.was else ""
    return text(f"{marked(node.mark, node.name)}{was}", 12, bold=True)


def _below(node: PictureNode, staying: Sequence[PictureEdge], limit: float = LINE) -> Iterable[str]:
    """What is at the foot of every state: control, the transitions without an arrow, and where the run was."""
    if node.control:
        yield small(controlled(node.control), limit=limit)
    for edge in staying:
        count = f" ({edge.taken.words()})" if edge.taken.times else ""
        where = f"→ {edge.target}" if edge.target else "stays"
        given = f"{where}: {transition_text(edge)}{count}"
        name = f"{edge.place}>{edge.target}" if edge.target else ""
        yield small(given, bold=bool(edge.taken.times), color=INK, limit=limit, name=name)
    if node.entered.times:
        yield small(f"entered {node.entered.words()}", bold=True, color=INK, limit=limit)
    if node.ended_here:
        yield small("the run ended here", bold=True, color=INK, limit=limit)


def _head(node: PictureNode, word: str, staying: Sequence[PictureEdge]) -> list[str]:
    """What is on every state that is drawn as a box: its name, what it runs and all that holds for it."""
    rows = [_name(node), text(node.title or word, 10)]
    return [*rows, *(small(line) for line in (node.about, *node.lines)), *_below(node, staying)]


def state_table(node: PictureNode, staying: Sequence[PictureEdge]) -> str:
    """The label of a state that holds no others."""
    if node.kind == "history":
        return table(
            [text("H*" if node.outcome == "deep" else "H", 12, bold=True), small(marked(node.mark, node.name))]
        )
    return table(_head(node, look_of(node).word, staying))


def _choice(choice: Choice, *, limit: float) -> str:
    rows = [text(marked(choice.mark, choice.name), 10.5, bold=True, limit=limit), small(choice.about, limit=limit)]
    if choice.guard:
        rows.append(text(f"when {choice.guard}", 9, limit=limit))
    elif not choice.fallback:
        rows.append(small("always open", limit=limit))
    if choice.fallback:
        rows.append(small("fallback, always open", bold=True, color=INK, limit=limit))
    if choice.parameters:
        rows.append(small(f"with {', '.join(choice.parameters)}", limit=limit))
    return inner_table(rows)


def decision_table(node: PictureNode, staying: Sequence[PictureEdge] = (), *, bold: bool = False) -> str:
    """The label of a decision: its question on top, an option a field, each with a port."""
    look = LOOKS["decision"]
    side_by_side = len(node.choices) <= SIDE_BY_SIDE
    span = f'colspan="{len(node.choices)}"' if side_by_side else ""
    wide = max(LINE, COLUMN * len(node.choices)) if side_by_side else LINE * 1.6
    head = [
        text(
            f"{marked(node.mark, '?')} {node.name}" + (f" (was {node.was})" if node.was else ""),
            12,
            bold=True,
            limit=wide,
        )
    ]
    head += [text(line, 10 if line.startswith("“") else 9, limit=wide) for line in node.lines]
    head += list(_below(node, staying, wide))
    pen = MARKS[node.mark][0] if node.mark else look.pen
    fields = [_field(choice, node.fallback, COLUMN if side_by_side else LINE * 1.6) for choice in node.choices]
    header = f'<tr><td {span} bgcolor="{look.fill}" sides="b" border="1">{inner_table(head)}</td></tr>'
    more = f'border="{4 if bold else 2}" color="{pen}" bgcolor="#FFFFFF" cellborder="1" cellspacing="0" cellpadding="3"'
    return table([header, field_rows(fields, side_by_side=side_by_side)], more)


def _field(choice: Choice, fallback: str, limit: float) -> str:
    pen = MARKS[choice.mark][0] if choice.mark else LOOKS["decision"].pen
    fill = ' bgcolor="#F2F2F2"' if choice.name == fallback else ""
    return f'<td port="{escape(choice.name)}" color="{pen}" valign="top"{fill}>{_choice(choice, limit=limit)}</td>'


def cluster_table(node: PictureNode, staying: Sequence[PictureEdge]) -> str:
    """The title of a state that holds others."""
    return table(_title(node, staying))


def _title(node: PictureNode, staying: Sequence[PictureEdge]) -> list[str]:
    """The title of a state that holds others, or a tree."""
    word = "region" if node.region else {"states": "", "parallel": "all at once"}.get(node.kind, look_of(node).word)
    return _head(node, word, staying)


def tree_table(node: PictureNode, staying: Sequence[PictureEdge] = (), *, bold: bool = False) -> str:
    """The label of a state that runs a tree: its title, and below it the tree, each node above its children.

    Children are side by side in the order of the file, in one label, which no layout can change.
    """
    below: dict[str | None, list[Twig]] = defaultdict(list)
    for twig in node.twigs:
        below[twig.parent].append(twig)
    look = LOOKS["tree"]
    pen = MARKS[node.mark][0] if node.mark else look.pen
    trees = "".join(f"<tr><td>{_branch(root, below)}</td></tr>" for root in below[None])
    head = f'<tr><td align="left">{inner_table(_title(node, staying))}</td></tr>'
    more = f'border="{4 if bold else 2}" color="{pen}" bgcolor="{look.fill}" cellborder="0" cellspacing="0"'
    return table([head, trees], f'{more} cellpadding="3"')


def _branch(twig: Twig, below: Mapping[str | None, Sequence[Twig]]) -> str:
    """A node of a tree as wide as its children, which are below it from left to right."""
    children = below.get(twig.path, ())
    rows = [f'<tr><td colspan="{max(1, len(children))}" {_twig_look(twig)}>{_twig_text(twig)}</td></tr>']
    if children:
        cells = "".join(f'<td valign="top">{_branch(child, below)}</td>' for child in children)
        rows.append(f"<tr>{cells}</tr>")
    return inner_table(rows, 'border="0" cellborder="0" cellspacing="3" cellpadding="0"')


def _twig_look(twig: Twig) -> str:
    look = LOOKS.get(twig.kind, LOOKS[""]) if twig.leaf else LOOKS["tree"]
    pen, line, _ = MARKS[twig.mark] if twig.mark else (look.pen, "", "")
    styles = ([] if twig.leaf else ["rounded"]) + ([line] if line in ("dashed", "dotted") else [])
    style = f' style="{",".join(styles)}"' if styles else ""
    wide = 2 if twig.mark or twig.kind == "decision" else 1
    return f'border="{wide}" cellpadding="4" color="{pen}" bgcolor="#FFFFFF"{style}'


def _twig_text(twig: Twig) -> str:
    """What is on a node of a tree: the option that leads to it, its number, what it does, what it asks."""
    sign = {"sequence": "→ ", "selector": "? ", "decision": "? "}.get(twig.kind, "")
    rows = [small(f"{twig.branch}:", limit=LABEL)] if twig.branch else []
    rows.append(text(marked(twig.mark, twig.numbered(sign)), 10, bold=not twig.leaf, limit=COLUMN))
    for choice in twig.choices:
        guard = f" when {choice.guard}" if choice.guard else ""
        last = ", fallback" if choice.fallback else ""
        rows.append(small(f"• {marked(choice.mark, choice.name)}{guard}{last}", color=INK, limit=COLUMN))
    return inner_table(rows)


def tab_table(node: PictureNode) -> str:
    """The label of what a state's transitions to something inside itself leave from."""
    return table([small(f"{node.name}, itself")])


def edge_table(edge: PictureEdge, *, short: bool) -> str:
    """The label of a transition; `short` where its words are at its source already; empty where nothing is left."""
    rows: list[str] = []
    if not short and (not edge.option or edge.guard or edge.source == edge.target):
        rows.append(text(marked(edge.mark, edge.when), 10, bold=True, limit=LABEL))
        if edge.guard:
            rows.append(text(f"[{edge.guard}]" if edge.trigger else edge.guard, 9, limit=LABEL))
    elif edge.mark:
        rows.append(text(f"{edge.mark} {MARKS[edge.mark][2]}", 10, bold=True, limit=LABEL))
    if edge.do and not short:
        rows.append(text(f"/ {'; '.join(edge.do)}", 9, limit=LABEL))
    if edge.internal and not short:
        rows.append(small("without leaving", limit=LABEL))
    if edge.taken.times:
        rows.append(text(edge.taken.words(), 9, bold=True, limit=LABEL))
    return table(rows, 'border="0" cellborder="0" cellspacing="0" cellpadding="1" bgcolor="#FFFFFFD0"') if rows else ""


def anywhere_table(rows: Sequence[tuple[str, PictureEdge]]) -> str:
    """The label of the mission's own transitions, a field each: (port, the transition)."""
    side_by_side = len(rows) <= SIDE_BY_SIDE
    limit = COLUMN * 1.6 if side_by_side else LINE * 1.6
    fields = []
    for port, edge in rows:
        inner = [text(transition_text(edge), 9.5, bold=bool(edge.taken.times), limit=limit)]
        inner += [] if edge.target else [small("stays where it is", limit=limit)]
        inner += (
            [small(f"taken {edge.taken.words()}", bold=True, color=INK)] if edge.taken.times and not edge.target else []
        )
        fields.append(f'<td port="{port}">{inner_table(inner)}</td>')
    span = f'colspan="{len(rows)}"' if side_by_side else ""
    title = [text("from every state", 11, bold=True)]
    header = f'<tr><td {span} bgcolor="#EDEDED">{inner_table(title)}</td></tr>'
    return table(
        [header, field_rows(fields, side_by_side=side_by_side)],
        'border="1" cellborder="1" cellspacing="0" cellpadding="3" color="#5A5A5A"',
    )


def title_table(picture: Picture) -> str:
    """The picture's head: what mission, how the run went, what must never be false, and how to read the rest."""
    rows = [text(picture.title, 16, bold=True, limit=640), text(picture.about, 11, limit=640)]
    if picture.steps:
        run = ": ".join(filter(None, (f"a run of {counted(picture.steps, 'step')}, its path in bold", picture.ended)))
        rows.append(text(run, 11, bold=True, limit=640))
    rows += [small(note, limit=640, color=INK, bold=True) for note in picture.notes[:NOTES]]
    if len(picture.notes) > NOTES:
        rows.append(small(f"and {len(picture.notes) - NOTES} more", color=INK, bold=True))
    rows += [small(f"never false: {name}: {guard}", limit=640, color=INK) for name, guard in picture.invariants]
    return table([*rows, f'<tr><td align="left">{_legend(picture)}</td></tr>'])


def _legend(picture: Picture) -> str:
    """A strip with each kind of state that is drawn, its colour next to its word."""
    looks = {
        look_of(node).word: look_of(node) for node in picture.nodes if node.kind not in ("states", "parallel", "each")
    }
    cells = [_swatch(look.word, look.pen, look.fill) for look in looks.values()]
    if picture.compared:
        cells += [_swatch(f"{mark} {word}, {style}", pen, "#FFFFFF") for mark, (pen, style, word) in MARKS.items()]
    return f'<table border="0" cellborder="2" cellspacing="4" cellpadding="2"><tr>{"".join(cells)}</tr></table>'


def _swatch(word: str, pen: str, fill: str) -> str:
    wide = width(word, 9) + 6
    label = shown(word)
    return (
        f'<td color="{pen}" bgcolor="{fill}" width="{wide:.0f}"><font point-size="9" color="{INK}">{label}</font></td>'
    )
