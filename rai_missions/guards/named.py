# SPDX-License-Identifier: Apache-2.0
"""A predicate of the user's program, by its name: `{"named": "is_crossable", "with": {…}}`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from rai_missions.guards.analysis import Distinctions, Sources
from rai_missions.guards.guard import Guard
from rai_missions.guards.template import ValueTemplate
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import Json, Name, Value
from rai_missions.model.references import TEMPLATE, Refers, template_words

__all__ = ("Named",)


class Named(Guard, word="named"):
    """The value of a pure function of the user's program over the blackboard; a mission can name it, never bring it."""

    fades: ClassVar = False

    named: Annotated[Name, Refers("predicate")]
    """The name under which the program has registered the predicate."""
    with_: Annotated[dict[str, Json], TEMPLATE] = Field(default_factory=dict, alias="with")
    """Its arguments: values, or references to keys."""

    def __init__(self, named: str, with_: Mapping[str, Value] = {}) -> None: ...

    def compile(self, site: Site) -> Test:
        name, arguments = self.named, ValueTemplate(self.with_, site)
        site.named.add(name)
        anything = Site(site.place, site.keys)  # it may look at any key, and is not shown one that is stale
        for key in site.keys:
            Operand(key, anything)
        site.instants += anything.instants
        site.reads.add("*")

        def test(view: View) -> Truth:
            given, unknown = arguments.fill(view)
            return None if unknown or not isinstance(given, Mapping) else view.named(name, given)

        return test

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return any(sources.is_robots(path) for path in self.paths())

    def distinguish(self, by: Distinctions) -> None:
        """A proof takes any value of it that its keys allow, whatever they are."""

    def words(self) -> str:
        return f"{self.named}({template_words(self.with_)})"
