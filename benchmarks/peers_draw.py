# SPDX-License-Identifier: Apache-2.0
"""A mission's states and rows as `transitions` would have them, drawn by its own GraphMachine.

Rule: the peer gets all that its own notation has: nested states, triggers, guards, targets. What it has no word for
(options, deadlines, fallbacks, trees, a row from every state, what counts as achieved) is left out, not imitated.
"""

from __future__ import annotations

from typing import Any

import graphviz
from graphviz.backend import dot_command
from transitions.extensions import HierarchicalGraphMachine

from rai_missions.mission.mission import Mission
from visualize import Picture, picture
from visualize.graphviz import layout_program

__all__ = ("by_transitions", "machine_of")


def machine_of(mission: Mission) -> Any:
    """The machine; its guards are names that are never called."""
    drawn = picture(mission)
    inside: dict[str, list[Any]] = {"": []}
    full: dict[str, str] = {}
    for node in drawn.nodes:
        full[node.name] = f"{full[node.parent]}.{node.name}" if node.parent else node.name
        inside[node.name] = []
        state: dict[str, Any] = {"name": node.name, "children": inside[node.name]}
        inside[node.parent].append(state)
    HierarchicalGraphMachine.state_cls.separator = "."
    start = next(initial.target for initial in drawn.initials if not initial.parent)
    return HierarchicalGraphMachine(
        model=_Model(drawn),
        states=_states(inside[""]),
        transitions=_transitions(drawn, full),
        initial=full[start],
        auto_transitions=False,
        show_conditions=True,
        title=mission.name,
        graph_engine="graphviz",
    )


class _Model:
    """What a machine moves; every guard in words is one of its attributes."""

    def __init__(self, drawn: Picture) -> None:
        for edge in drawn.edges:
            setattr(self, edge.guard, True)


def _states(given: list[Any]) -> list[Any]:
    return [{**each, "children": _states(each["children"])} if each["children"] else each["name"] for each in given]


def _transitions(drawn: Picture, full: dict[str, str]) -> list[dict[str, Any]]:
    """Every row as a transition; those of the mission itself as one from all its states."""
    return [
        {
            "trigger": edge.when.replace(" ", "_"),
            "source": full[edge.source] if edge.source else "*",
            "dest": full[edge.target] if edge.target else None,
            "conditions": [edge.guard] if edge.guard else None,
        }
        for edge in drawn.edges
    ]


def by_transitions(mission: Mission, form: str) -> bytes:
    """The bytes of its picture, laid out by the same Graphviz as ours."""
    dot_command.DOT_BINARY = layout_program()
    graph = machine_of(mission).get_graph()
    source = str(graph.source if hasattr(graph, "source") else graph)
    if form == "dot":
        return source.encode()
    data: bytes = graphviz.Source(source).pipe(format=form, quiet=True)
    return data
