# SPDX-License-Identifier: Apache-2.0
"""Markup as a tree of elements: whatever a store holds can only become a text or an attribute's value.

Rule: no text is put together with markup by hand; the standard library writes the tree and escapes.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, tostring

from visualize.style import clean

__all__ = ("Child", "Element", "node", "written")

Child = Element | str | None | Iterable["Child"]


def node(tag: str, attributes: dict[str, object] | None = None, *children: Child) -> Element:
    """An element. Attributes that are None or False are left out, True is an empty one."""
    made = Element(tag)
    for name, value in (attributes or {}).items():
        if value is not None and value is not False:
            made.set(name, "" if value is True else clean(str(value)))
    _fill(made, children)
    return made


def written(nodes: Iterable[Element]) -> str:
    """As HTML."""
    return "\n".join(tostring(each, encoding="unicode", method="html") for each in nodes)


def _fill(parent: Element, children: Iterable[Child]) -> None:
    for child in children:
        if isinstance(child, Element):
            parent.append(child)
        elif isinstance(child, str):
            _text(parent, clean(child))
        elif child is not None:
            _fill(parent, child)


def _text(parent: Element, text: str) -> None:
    if len(parent):
        parent[-1].tail = (parent[-1].tail or "") + text
    else:
        parent.text = (parent.text or "") + text
