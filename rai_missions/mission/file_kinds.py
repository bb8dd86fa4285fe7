# SPDX-License-Identifier: Apache-2.0
"""The kinds of JSON files that authors write, distinguished by their words: one given in place of another is named."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from rai_missions.errors import DefinitionError, Fault
from rai_missions.redaction import shown

__all__ = ("FileKind", "object_of")

FileKind = Literal["mission", "profile", "campaign"]
NAMES: Mapping[FileKind, str] = {"mission": "a mission", "profile": "a robot profile", "campaign": "a campaign"}
WORDS: Mapping[FileKind, tuple[str, ...]] = {
    "mission": ("states", "initial"), "profile": ("connector",), "campaign": ("scenes", "models"),
}  # fmt: skip
"""What only a file of the kind has."""
HINTS: Mapping[tuple[FileKind, FileKind], str] = {
    ("mission", "profile"): "this is a robot's profile; name a mission, and give this file with --robot",
    ("mission", "campaign"): "this is a campaign; rai-missions campaign runs it",
    ("profile", "mission"): "this is a mission; --robot takes a robot's profile, or its program in Python",
    ("profile", "campaign"): "this is a campaign; --robot takes a robot's profile, or its program in Python",
    ("campaign", "mission"): "this is a mission; a campaign names one as its 'mission'",
    ("campaign", "profile"): "this is a robot's profile; a campaign names one as its 'robot'",
}
"""Kind that is wanted, kind that is there → what the author reads."""


def object_of(wanted: FileKind, data: Any, source: str) -> Mapping[str, Any]:
    """What a file of a kind holds: an object, which is not plainly one of another kind.

    Args:
        wanted: The kind.
        data: The file's content.
        source: Where it was found, for the error.

    Raises:
        DefinitionError: It is none.
    """
    if not isinstance(data, Mapping):
        raise DefinitionError([Fault("", f"{NAMES[wanted]} is a JSON object, not {shown(data)}")], source)
    if not any(word in data for word in WORDS[wanted]):
        found = [kind for kind, words in WORDS.items() if all(word in data for word in words)]
        if len(found) == 1:
            raise DefinitionError([Fault("", HINTS[wanted, found[0]])], source)
    return data
