# SPDX-License-Identifier: Apache-2.0
"""XML read element by element, for files that someone else wrote.

Rule: a document type is refused, and with it every entity: none is expanded, and none opens another file.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol
from xml.parsers import expat

__all__ = ("RefusedXml", "XmlListener", "read_xml")

DEEPEST = 100
"""Elements inside each other."""


class RefusedXml(Exception):
    """The document is no such document, or more than is read; the text is the fault."""


class XmlListener(Protocol):
    """Receives the elements of a document, in its order. Any of its methods may raise `RefusedXml`."""

    def begin(self, tag: str, attributes: Mapping[str, str], line: int) -> None:
        """An element begins; with namespaces its tag is `namespace name`."""

    def text(self, text: str) -> None:
        """A piece of text."""

    def end(self, tag: str) -> None:
        """An element ends."""


def read_xml(data: bytes, listener: XmlListener, *, namespaces: bool = False, deepest: int = DEEPEST) -> None:
    """Hand a document's elements to a listener.

    Raises:
        ValueError: It is not well-formed, is nested too deep, brings a document type, or the listener refuses it.
    """
    parser = expat.ParserCreate(namespace_separator=" " if namespaces else None)
    depth = 0

    def begin(tag: str, attributes: Mapping[str, str]) -> None:
        nonlocal depth
        depth += 1
        listener.begin(tag, attributes, parser.CurrentLineNumber)
        if depth > deepest:
            raise RefusedXml(f"is nested more than {deepest} deep")

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        listener.end(tag)

    def refuse(*_: object) -> None:
        raise RefusedXml("brings a document type (<!DOCTYPE …>), which it does not need; remove it")

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = listener.text, refuse
    try:
        parser.Parse(data, True)
    except RefusedXml as refused:
        raise ValueError(str(refused)) from None
    except (expat.ExpatError, LookupError) as error:
        raise ValueError(f"is not well-formed XML: {error}") from None
