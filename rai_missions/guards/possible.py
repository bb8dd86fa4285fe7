# SPDX-License-Identifier: Apache-2.0
"""True for true and for unknown: `{"possible": guard}`, for rows that protect."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from rai_missions.guards.guard import Guard, Site, Test
from rai_missions.model import OneOf

__all__ = ("Possible",)


class Possible(Guard, word="possible"):
    """True where the guard is true or unknown; never unknown itself."""

    positional: ClassVar = ("possible",)

    possible: OneOf[Guard]

    def compile(self, site: Site) -> Test:
        inner = self.possible.compile(site)
        return lambda view: inner(view) is not False

    def inner(self) -> Iterator[Guard]:
        yield self.possible

    def words(self) -> str:
        return f"possibly {self.possible.words()}"
