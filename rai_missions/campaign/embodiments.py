# SPDX-License-Identifier: Apache-2.0
"""Embodiments: what a model is shown of the robot that it decides for, each more than the one before.

Source: the paper "RAI: Flexible Agent Framework for Embodied AI", section on the tractor, compares such prompts.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from rai_missions.embodiment import Identity
from rai_missions.embodiment.folder import DESCRIPTION, PICTURES, IdentityFolder
from rai_missions.embodiment.identity import LARGEST, MOST
from rai_missions.embodiment.index.build import MOST_DOCUMENTS
from rai_missions.embodiment.readers import FORMATS
from rai_missions.errors import UsageError, suggestion
from rai_missions.redaction import shown

__all__ = ("EMBODIMENTS", "RobotView", "embodied", "embodiment_digest")

DOCUMENTS = {ending: each.largest for ending, each in FORMATS.items()}
EMBODIMENTS = ("none", "description", "documents", "pictures")
"""Nothing; who it is; what its build and its documents state on the question; its picture and the camera's as well."""


class RobotView(NamedTuple):
    """A robot as a question shows it."""

    identity: Identity | None = None
    """Description, build and portrait, as far as they are shown."""
    documents: tuple[str, ...] = ()
    """Quotations from its documents, each with its source."""
    pictures: bool = False
    """Whether the pictures of the question are shown."""


def embodiment_digest(name: str, identity_folder: Path | None) -> str:
    """The digest of the files that an embodiment shows; empty where it shows none.

    Args:
        name: One of `EMBODIMENTS`.
        identity_folder: The robot's.

    Raises:
        DefinitionError: The folder cannot be read.
    """
    if name == EMBODIMENTS[0] or identity_folder is None:
        return ""
    found = hashlib.sha256()
    for files in (
        IdentityFolder(identity_folder, LARGEST, most=MOST),
        IdentityFolder(identity_folder, DOCUMENTS, most=MOST_DOCUMENTS, inner=True),
    ):
        for file in files.files:
            is_picture = file.lower().endswith(PICTURES)
            if file == DESCRIPTION or (name != "description" and (name == "pictures" or not is_picture)):
                found.update(f"{file}\0".encode() + _content(files, file))
    return found.hexdigest()


def _content(files: IdentityFolder, file: str) -> bytes:
    """The digest of a file; of one that cannot be read, why."""
    try:
        return hashlib.sha256(files.data(file)).digest()
    except ValueError as why:
        return str(why).encode()


def embodied(name: str, identity_folder: Path | None, about: str = "") -> RobotView:
    """The embodiment of that name.

    Args:
        name: One of `EMBODIMENTS`.
        identity_folder: The robot's.
        about: The question on which its documents are searched.

    Raises:
        UsageError: No such embodiment, or the robot has no identity and the embodiment needs one.
        DefinitionError: The folder cannot be read.
    """
    if name not in EMBODIMENTS:
        raise UsageError(f"no embodiment {shown(name)}{suggestion(name, EMBODIMENTS)}")
    if name == "none":
        return RobotView()
    if identity_folder is None:
        raise UsageError(f"the embodiment '{name}' shows the robot's identity, and its profile names none")
    identity = Identity.read(identity_folder)
    if name == "description":
        return RobotView(replace(identity, images=(), body=None))
    passages = identity.recall(about).passages if about else ()
    quotes = tuple(f"{each.source}: {each.text}" for each in passages)
    if name == "documents":
        return RobotView(replace(identity, images=()), quotes)
    return RobotView(identity, quotes, pictures=True)
