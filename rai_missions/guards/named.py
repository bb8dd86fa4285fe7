# SPDX-License-Identifier: Apache-2.0
"""A predicate of the user's program, by its name: `{"named": "is_crossable", "with": {…}}`."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from rai_missions.guards.guard import Guard, Site, Test
from rai_missions.written import Json, Name

__all__ = ("Named",)


class Named(Guard, word="named"):
    """What a pure function of the user's program says of the blackboard; a mission can name it, never bring it."""

    positional: ClassVar = ("named", "with_")

    named: Name
    with_: dict[str, Json] = Field(default_factory=dict, alias="with")

    def compile(self, site: Site) -> Test:
        name, arguments = self.named, dict(self.with_)
        site.named.add(name)
        site.reads.add("*")
        return lambda view: view.named(name, arguments)

    def words(self) -> str:
        arguments: Any = ", ".join(f"{key} {value}" for key, value in self.with_.items())
        return f"{self.named}({arguments})"
