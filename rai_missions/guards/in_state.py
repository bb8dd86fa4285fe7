# SPDX-License-Identifier: Apache-2.0
"""Whether a state is active: `{"in": "crossing"}`."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from rai_missions.guards.guard import Guard, Site, Test
from rai_missions.model import Name

__all__ = ("In",)


class In(Guard, word="in"):
    """True while the state is active, by itself or through a state inside it; never unknown."""

    positional: ClassVar = ("state",)

    state: Name = Field(alias="in")

    def compile(self, site: Site) -> Test:
        state = self.state
        site.states.add(state)
        return lambda view: state in view.active

    def words(self) -> str:
        return f"in {self.state}"
