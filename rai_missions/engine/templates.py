# SPDX-License-Identifier: Apache-2.0
"""Goals, requests, messages and payloads as they are sent, with the values of now.

Rule: a robot is sent nothing with a gap in it: where a part is unknown, there is a sentence instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.guards.template import ValueTemplate
from rai_missions.guards.view import Site, View
from rai_missions.redaction import clipped

__all__ = ("FilledTemplate", "SentTemplate", "unpublished")


class FilledTemplate(NamedTuple):
    """What is to be sent, with the values of now."""

    fields: dict[str, Any]
    """None where a value is unknown."""
    lack: str = ""
    """Why it cannot be sent, in a sentence; empty if it can."""


class SentTemplate:
    """What is to be sent, compiled.

    Args:
        what: What it is: a goal, a request.
        written: An object of fields, or a reference to one.
        site: Where; what is read when it is sent is none of what is watched there.
    """

    def __init__(self, what: str, written: Any, site: Site) -> None:
        self.what = what
        self._template = ValueTemplate(written, Site(site.place, site.keys, site.state))

    def fill(self, view: View) -> FilledTemplate:
        """The template filled with the values of now."""
        value, unknown = self._template.fill(view)
        fields = dict(value) if isinstance(value, Mapping) else {}
        if unknown:
            parts = f"'s {', '.join(unknown)}" if any(unknown) else ""
            return FilledTemplate(fields, f"the {self.what}{parts} is unknown")
        if not isinstance(value, Mapping):
            return FilledTemplate(fields, f"the {self.what} is {clipped(repr(value), 80)}, which has no fields")
        return FilledTemplate(fields)


def unpublished(topic: str, lack: str) -> str:
    """The note of a message that was not published."""
    return f"nothing was published on '{topic}': {lack}"
