# SPDX-License-Identifier: Apache-2.0
"""Who a robot is: a folder with a description, pictures of it, its build and further documents.

Rule: nothing outside the folder is read, whatever its files or links name, and nothing without a bound.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from rai_missions.embodiment.urdf import Body, read_body
from rai_missions.errors import DefinitionError, Fault, irregular
from rai_missions.image import Image

__all__ = ("Identity",)

T = TypeVar("T")

DESCRIPTION = "description.md"
PICTURES = (".jpeg", ".jpg", ".png")
LARGEST = {".md": 200_000, ".urdf": 5_000_000, **dict.fromkeys(PICTURES, 10_000_000)}
"""Bytes of a file, by its ending; files that end otherwise are left alone."""
MOST = 50
"""Files of an identity."""


@dataclass(frozen=True)
class Identity:
    """A robot as it knows itself."""

    description: str
    """The text of `description.md`."""
    images: tuple[Image, ...] = ()
    """Its pictures in the order of their names, one called `portrait` first."""
    body: Body | None = None
    """Its links and joints, where a URDF has them."""
    documents: Mapping[str, str] = field(default_factory=dict)
    """Its other documents: file name → text."""

    @property
    def portrait(self) -> Image | None:
        """The picture by which it is shown, if it has one."""
        return self.images[0] if self.images else None

    def words(self) -> str:
        """The description and the build, for anyone who thinks for this robot."""
        parts = (self.description.strip(), self.body.words() if self.body else "")
        return "\n\n".join(part for part in parts if part)

    @classmethod
    def read(cls, folder: Path) -> Identity:
        """The identity in a folder.

        Raises:
            DefinitionError: Every file that is missing, too large, unreadable or elsewhere; each place names its file.
        """
        reader = Reader(folder)
        texts = reader.each((".md",), _text)
        pictures = reader.each(PICTURES, lambda name, data: Image.of_file(f"identity/{name}", data))
        bodies = reader.each((".urdf",), read_body)
        if len(bodies) > 1:
            reader.fault("", f"{' and '.join(bodies)} both describe the build; keep one")
        if DESCRIPTION not in reader.files:
            reader.fault(DESCRIPTION, "is missing; write in it who the robot is")
        if reader.faults:
            raise DefinitionError(reader.faults, str(folder))
        images = tuple(pictures[name] for name in sorted(pictures, key=_portrait_first))
        return cls(texts.pop(DESCRIPTION), images, next(iter(bodies.values()), None), texts)


class Reader:
    """Reads the files of a folder, collecting the faults.

    Args:
        folder: The identity's folder.

    Raises:
        DefinitionError: It is no folder, cannot be listed, or holds too many files.
    """

    def __init__(self, folder: Path) -> None:
        self.root = _resolved(folder)
        self.faults: list[Fault] = []
        try:
            paths = sorted(path for path in self.root.iterdir() if path.suffix.lower() in LARGEST)
        except OSError as error:
            why = f"the identity's folder cannot be read ({error.strerror}); it is one with a {DESCRIPTION}"
            raise DefinitionError([Fault("", why)], str(folder)) from None
        if len(paths) > MOST:
            raise DefinitionError([Fault("", f"has {len(paths)} files; at most {MOST} are read")], str(folder))
        self.files = {path.name: path for path in paths}

    def fault(self, name: str, sentence: str) -> None:
        self.faults.append(Fault(f"/{name.replace('~', '~0').replace('/', '~1')}" if name else "", sentence))

    def each(self, endings: tuple[str, ...], read: Callable[[str, bytes], T]) -> dict[str, T]:
        """What each file with such an ending holds, by its name; what cannot be read is a fault."""
        found: dict[str, T] = {}
        for name, path in self.files.items():
            if path.suffix.lower() in endings:
                try:
                    found[name] = read(name, self.data(path))
                except ValueError as error:
                    self.fault(name, str(error))
        return found

    def data(self, path: Path) -> bytes:
        """The bytes of a file in the folder.

        Raises:
            ValueError: It leads elsewhere, is no file, cannot be read, or is too large.
        """
        target = _resolved(path)
        if not target.is_relative_to(self.root):
            raise ValueError("leads out of the identity's folder; copy the file into it")
        if sort := irregular(target):  # a pipe would never end
            raise ValueError(f"is {sort}, no file")
        if not target.is_file():
            raise ValueError("is no file")
        largest = LARGEST[path.suffix.lower()]
        try:
            with target.open("rb") as opened:
                data = opened.read(largest + 1)
        except OSError as error:
            raise ValueError(f"cannot be read: {error.strerror}") from None
        if len(data) > largest:
            raise ValueError(f"is larger than {largest} bytes")
        return data


def _resolved(path: Path) -> Path:
    """The path without links; a link that leads to itself stays, where `Path.resolve` would raise."""
    return Path(os.path.realpath(path))


def _text(name: str, data: bytes) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"is not UTF-8 at byte {error.start}; save it as UTF-8") from None
    if name == DESCRIPTION and not text.strip():
        raise ValueError("is empty; write in it who the robot is")
    return text


def _portrait_first(name: str) -> tuple[bool, str]:
    return Path(name).stem.lower() != "portrait", name
