# SPDX-License-Identifier: Apache-2.0
"""The files of an identity's folder: which there are, and their bytes.

Rule: nothing outside the folder is read, whatever its files or links name, and nothing without a bound.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from rai_missions.errors import DefinitionError, Fault, file_text, irregular, pointer

__all__ = ("DESCRIPTION", "PICTURES", "IdentityFolder")

T = TypeVar("T")

DESCRIPTION = "description.md"
PICTURES = (".jpeg", ".jpg", ".png")
DEEPEST_FOLDER = 4
"""Folders inside each other."""
MOST_SEEN = 5_000
"""Entries of any kind that are looked at, in all folders together."""


class IdentityFolder:
    """Reads the files of a folder, collecting the faults.

    Args:
        folder: The identity's folder.
        largest: Ending → bytes of the largest file that is read; files that end otherwise are left alone.
        most: Files in all.
        inner: Whether folders inside are looked into; one whose name begins with a dot is not.

    Raises:
        DefinitionError: It is no folder, cannot be listed, or holds too many files.
    """

    def __init__(self, folder: Path, largest: Mapping[str, int], *, most: int, inner: bool = False) -> None:
        self.root, self._shown = resolved(folder), str(folder)
        self.largest, self.faults, self._others = largest, list[Fault](), list[Path]()
        try:
            paths = self._listed(self.root, DEEPEST_FOLDER if inner else 0)
        except OSError as error:
            why = f"the identity's folder cannot be read ({error.strerror}); it is one with a {DESCRIPTION}"
            raise DefinitionError([Fault("", why)], self._shown) from None
        if len(paths) > most:
            raise DefinitionError([Fault("", f"has {len(paths)} files; at most {most} are read")], self._shown)
        self.files = {file_text(path.relative_to(self.root)): path for path in paths}
        self.others = tuple(sorted(file_text(path.relative_to(self.root)) for path in self._others))
        """Files that end otherwise."""

    def fault(self, name: str, sentence: str) -> None:
        """Keep what is wrong with a file, or with the folder where the name is empty."""
        self.faults.append(Fault(pointer([name]) if name else "", sentence))

    def each(self, endings: tuple[str, ...], read: Callable[[str, bytes], T]) -> dict[str, T]:
        """What each file holds whose name is or ends like that, by its name; what cannot be read is a fault."""
        found: dict[str, T] = {}
        for name, path in self.files.items():
            if path.suffix.lower() in endings or name in endings:
                try:
                    found[name] = read(name, self.data(name))
                except ValueError as error:
                    self.fault(name, str(error))
        return found

    def data(self, name: str) -> bytes:
        """The bytes of a file of the folder.

        Raises:
            ValueError: It leads elsewhere, is no file, cannot be read, or is too large.
        """
        path = self.files[name]
        target = resolved(path)
        if not target.is_relative_to(self.root):
            raise ValueError("leads out of the identity's folder; copy the file into it")
        if sort := irregular(target):  # a pipe would never end
            raise ValueError(f"is {sort}, no file")
        if not target.is_file():
            raise ValueError("is no file")
        largest = self.largest[path.suffix.lower()]
        try:
            with target.open("rb") as opened:
                data = opened.read(largest + 1)
        except OSError as error:
            raise ValueError(f"cannot be read: {error.strerror}") from None
        if len(data) > largest:
            raise ValueError(f"is larger than {largest} bytes; split it, or leave out what is not needed")
        return data

    def _listed(self, folder: Path, deeper: int) -> list[Path]:
        """The files in a folder and in those inside it; a link to a folder is not entered."""
        found, seen, open_folders = list[Path](), 0, [(folder, deeper)]
        while open_folders:
            place, left = open_folders.pop()
            for path in sorted(place.iterdir()):
                seen += 1
                if seen > MOST_SEEN:
                    why = f"holds more than {MOST_SEEN} entries; keep only the robot's own documents in it"
                    raise DefinitionError([Fault("", why)], self._shown)
                if left and path.is_dir() and not path.is_symlink() and not path.name.startswith("."):
                    open_folders.append((path, left - 1))
                elif not path.name.startswith("."):
                    if path.suffix.lower() in self.largest:
                        found.append(path)
                    elif path.is_file():
                        self._others.append(path)
        return sorted(found)


def resolved(path: Path) -> Path:
    """The path without links; a link that leads to itself stays, where `Path.resolve` would raise."""
    return Path(os.path.realpath(path))
