# SPDX-License-Identifier: Apache-2.0
"""Two pictures in one: what is only in the new one is marked `+`, what is gone `-`, what is otherwise `~`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from rai_missions.mission.mission import Mission
from visualize.build import picture
from visualize.diff.align import paired
from visualize.model import Choice, Mark, Picture, PictureEdge, PictureNode, Twig

__all__ = ("merged",)

Edges = Mapping[tuple[str, int | None], Mapping[str, PictureEdge]]
"""(state, number of its transition) → target → edge."""


def merged(old: Mission, new: Mission, renamed: Iterable[tuple[str, str]], version: str) -> Picture:
    """One picture of two missions.

    Args:
        old: With the names of the new one, for what was only renamed.
        new: As it is now.
        renamed: Old and new names of the states that are called otherwise.
        version: The version of the old mission.
    """
    left, right = picture(old), picture(new)
    before = {node.name: node for node in left.nodes}
    after = {node.name for node in right.nodes}
    was = {now: name for name, now in renamed}
    nodes = [_node(before.get(node.name), node, was.get(node.name, "")) for node in right.nodes]
    nodes += [node._replace(mark="-") for node in left.nodes if node.name not in after]
    gone = before.keys() - after
    initials = (*right.initials, *(initial for initial in left.initials if initial.parent in gone))
    edges = tuple(_edges(old, new, _by_transition(left), _by_transition(right)))
    return replace(right, nodes=tuple(nodes), edges=edges, initials=initials, compared=version)


def _node(old: PictureNode | None, new: PictureNode, was: str) -> PictureNode:
    if old is None:
        return new._replace(mark="+")
    left = {choice.name: choice for choice in old.choices}
    choices = [choice._replace(mark=_mark(left.get(choice.name), choice)) for choice in new.choices]
    choices += [
        choice._replace(mark="-") for name, choice in left.items() if name not in {each.name for each in new.choices}
    ]
    same = _lines(old) == _lines(new) and not was
    return new._replace(mark="" if same else "~", was=was, choices=tuple(choices), twigs=_twigs(old, new))


def _lines(node: PictureNode) -> PictureNode:
    """A state as far as it is drawn, wherever it is in the file."""
    twigs = tuple(twig._replace(choices=_placeless(twig.choices)) for twig in node.twigs)
    return node._replace(place="", choices=_placeless(node.choices), twigs=twigs)


def _placeless(choices: Iterable[Choice]) -> tuple[Choice, ...]:
    return tuple(choice._replace(place="") for choice in choices)


def _twigs(old: PictureNode, new: PictureNode) -> tuple[Twig, ...]:
    left, right = {twig.path: twig for twig in old.twigs}, {twig.path: twig for twig in new.twigs}
    found = []
    for path, twig in right.items():
        mark: Mark = (
            "+" if path not in left else "" if left[path]._replace(choices=()) == twig._replace(choices=()) else "~"
        )
        found.append(twig._replace(mark=mark))
    found += [twig._replace(mark="-") for path, twig in left.items() if path not in right]
    return tuple(found)


def _edges(old: Mission, new: Mission, before: Edges, after: Edges) -> Iterator[PictureEdge]:
    """The new edges in their order, each with those that are gone from its state behind it."""
    transitions = {name: state.transitions for _, name, state in old.walk()} | {"": old.transitions}
    now = {name: state.transitions for _, name, state in new.walk()} | {"": new.transitions}
    for name in [*(name for name in now if name), *(name for name in transitions if name not in now), ""]:
        for left, right in paired(transitions.get(name, ()), now.get(name, ())):
            gone = before.get((name, left), {}) if left is not None else {}
            come = after.get((name, right), {}) if right is not None else {}
            yield from (edge._replace(mark=_mark(gone.get(target), edge)) for target, edge in come.items())
            yield from (edge._replace(mark="-") for target, edge in gone.items() if target not in come)


def _mark(old: Choice | PictureEdge | None, new: Choice | PictureEdge) -> Mark:
    if old is None:
        return "+"
    return "" if old._replace(place="") == new._replace(place="") else "~"


def _by_transition(drawn: Picture) -> Edges:
    found: dict[tuple[str, int | None], dict[str, PictureEdge]] = {}
    for edge in drawn.edges:
        number = int(edge.place.rpartition("/")[2])
        found.setdefault((edge.source, number), {})[edge.target] = edge
    return found
