# SPDX-License-Identifier: Apache-2.0
"""Markup as a tree of values: whatever a store holds can only become a text or an attribute's value.

Rule: no text is put together with markup by hand; the standard library writes the tree and escapes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple
from xml.etree.ElementTree import TreeBuilder, tostring

from visualize.style import clean

__all__ = ("Child", "Markup", "node", "written")


class Markup(NamedTuple):
    """An element."""

    tag: str
    attributes: dict[str, str]
    children: tuple[Child, ...]


Child = Markup | str | None | Iterable["Child"]


def node(tag: str, attributes: dict[str, object] | None = None, *children: Child) -> Markup:
    """An element. Attributes that are None or False are left out, True is an empty one."""
    kept = {name: value for name, value in (attributes or {}).items() if value is not None and value is not False}
    return Markup(tag, {name: "" if value is True else str(value) for name, value in kept.items()}, children)


def written(nodes: Iterable[Markup]) -> str:
    """As HTML."""
    return "\n".join(map(_written, nodes))


def _written(given: Markup) -> str:
    builder = TreeBuilder()
    _build(builder, given)
    return tostring(builder.close(), encoding="unicode", method="html")


def _build(builder: TreeBuilder, given: Child) -> None:
    if isinstance(given, Markup):
        builder.start(given.tag, {name: clean(value) for name, value in given.attributes.items()})
        _build(builder, given.children)
        builder.end(given.tag)
    elif isinstance(given, str):
        builder.data(clean(given))
    elif given is not None:
        for child in given:
            _build(builder, child)
