# SPDX-License-Identifier: Apache-2.0
"""Who a robot is: a folder with a description, pictures of it, its build and documents.

Rule: a model is shown the description as its own; the build and the documents are data, which are quoted.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rai_missions.embodiment.folder import DESCRIPTION, PICTURES, IdentityFolder
from rai_missions.embodiment.library import COUNT, Library
from rai_missions.embodiment.passage import FoundPassages
from rai_missions.embodiment.readers.plain import decoded
from rai_missions.embodiment.urdf import Body, read_body
from rai_missions.errors import DefinitionError
from rai_missions.image import Image
from rai_missions.redaction import redacted

__all__ = ("Identity",)

LARGEST = {".md": 1_000_000, ".urdf": 5_000_000, **dict.fromkeys(PICTURES, 10_000_000)}
"""Bytes of a file, by its ending."""
LARGEST_DESCRIPTION = 200_000
MOST = 200
"""Files of these kinds."""


@dataclass(frozen=True)
class Identity:
    """A robot as it knows itself."""

    description: str
    """The text of `description.md`, without secrets."""
    images: tuple[Image, ...] = ()
    """Its pictures in the order of their names, one called `portrait` first."""
    body: Body | None = None
    """Its links and joints, where a URDF has them."""
    library: Library | None = field(default=None, compare=False)
    """What it can look up: the documents of its folder."""

    @property
    def portrait(self) -> Image | None:
        """The picture by which it is shown, if it has one."""
        return self.images[0] if self.images else None

    @property
    def first_sentence(self) -> str:
        """What the description begins with, its headings aside; empty where there is no text."""
        lines = [line for line in self.description.splitlines() if not line.lstrip().startswith("#")]
        text = " ".join(" ".join(lines).split())
        return f"{text.split('. ')[0].rstrip('.')}." if text else ""

    def words(self) -> str:
        """The description and the build, for a person."""
        parts = (self.description.strip(), self.body.words() if self.body else "")
        return "\n\n".join(part for part in parts if part)

    def recall(self, question: str, count: int = COUNT) -> FoundPassages:
        """What its documents have on a question: passages with their sources, or none.

        Args:
            question: In free words, in the language of the documents: English or German.
            count: Passages at most; 1 to 20.

        Raises:
            DefinitionError: The folder cannot be read.
            UsageError: The index cannot be written, or is damaged.
        """
        return self.library.recall(question, count) if self.library is not None else FoundPassages(())

    @classmethod
    def read(cls, folder: Path, index: Path | None = None) -> Identity:
        """The identity in a folder; its other documents are read when something is looked up.

        Args:
            folder: The identity's folder.
            index: The index of its documents; left out: in the user's cache.

        Raises:
            DefinitionError: Every file that is missing, too large, unreadable or elsewhere; each place names its file.
        """
        files = IdentityFolder(folder, LARGEST, most=MOST)
        texts = files.each((DESCRIPTION,), _description)
        pictures = files.each(PICTURES, lambda name, data: Image.of_file(f"identity/{name}", data))
        bodies = files.each((".urdf",), read_body)
        if len(bodies) > 1:
            files.fault("", f"{' and '.join(bodies)} both describe the build; keep one")
        if DESCRIPTION not in files.files:
            files.fault(DESCRIPTION, "is missing; write in it who the robot is")
        if files.faults:
            raise DefinitionError(files.faults, str(folder))
        names = sorted(pictures, key=lambda name: (Path(name).stem.lower() != "portrait", name))
        images = tuple(pictures[name] for name in names)
        return cls(texts[DESCRIPTION], images, next(iter(bodies.values()), None), Library(folder, index))


def _description(_name: str, data: bytes) -> str:
    if len(data) > LARGEST_DESCRIPTION:
        raise ValueError(f"is larger than {LARGEST_DESCRIPTION} bytes; move what is not the description elsewhere")
    text = decoded(data)
    if not text.strip():
        raise ValueError("is empty; write in it who the robot is")
    return redacted(text)
