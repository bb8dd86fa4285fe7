# SPDX-License-Identifier: Apache-2.0
"""What a URDF holds of a robot's build: the names of its links and joints.

Source: the URDF XML specification (`robot`, `link`, `joint` and its `type`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple
from xml.parsers import expat

from rai_missions.redaction import cut

__all__ = ("Body", "read_body")

MOST = 2_000
"""Links or joints that are read."""
LONGEST_NAME = 100
SHOWN = 40
DEEPEST = 100


class Body(NamedTuple):
    """A robot's build."""

    name: str
    links: tuple[str, ...]
    joints: tuple[tuple[str, str], ...]
    """Name and type (`revolute`, `fixed`, …) of each."""

    def words(self) -> str:
        """The build in a few lines; fixed joints, which do not move, are left out."""
        moving = [f"{name} ({kind})" for name, kind in self.joints if kind != "fixed"]
        return f"Build of '{self.name}'. Links: {_listed(self.links)}. Moving joints: {_listed(moving)}."


def _listed(names: tuple[str, ...] | list[str]) -> str:
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return (", ".join(names[:SHOWN]) or "none") + more


class RefusedDocument(Exception):
    """The document is more than a robot's description."""


class _Listener:
    """Receives the elements of a URDF."""

    def __init__(self) -> None:
        self.path: list[str] = []
        self.name = ""
        self.links: list[str] = []
        self.joints: list[tuple[str, str]] = []

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        if not self.path and tag != "robot":
            raise RefusedDocument(f"is no URDF: it begins with <{cut(tag, LONGEST_NAME)}> instead of <robot>")
        name = cut(attributes.get("name", ""), LONGEST_NAME)
        if not self.path:
            self.name = name
        elif self.path == ["robot"] and tag == "link":
            self.links.append(name)
        elif self.path == ["robot"] and tag == "joint":
            self.joints.append((name, cut(attributes.get("type", ""), LONGEST_NAME)))
        self.path.append(tag)
        if max(len(self.links), len(self.joints)) > MOST:
            raise RefusedDocument(f"has more than {MOST} links or joints")
        if len(self.path) > DEEPEST:
            raise RefusedDocument(f"is nested more than {DEEPEST} deep")

    def end(self, _tag: str) -> None:
        self.path.pop()


def read_body(_name: str, data: bytes) -> Body:
    """The build that a URDF describes.

    Raises:
        ValueError: It is no well-formed XML, no URDF, or brings a document type, by which XML can read other files.
    """
    listener, parser = _Listener(), expat.ParserCreate()

    def refuse(*_: object) -> None:
        raise RefusedDocument("brings a document type (<!DOCTYPE …>), which a URDF does not need; remove it")

    parser.StartElementHandler, parser.EndElementHandler = listener.begin, listener.end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(data, True)
    except RefusedDocument as refused:
        raise ValueError(str(refused)) from None
    except expat.ExpatError as error:
        raise ValueError(f"is not well-formed XML: {error}") from None
    except LookupError as error:
        raise ValueError(f"is not well-formed XML: {error}") from None
    return Body(listener.name, tuple(listener.links), tuple(listener.joints))
