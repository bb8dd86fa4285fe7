# SPDX-License-Identifier: Apache-2.0
"""Whether a state is active: `{"in": "crossing"}`."""

from __future__ import annotations

from collections.abc import Callable

from pydantic import Field

from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Test, Truth
from rai_missions.model import StateName

__all__ = ("In",)


class In(Guard, word="in"):
    """True while the state is active, by itself or through a state inside it; never unknown."""

    state: StateName = Field(alias="in")
    """The state that must be active."""

    def __init__(self, state: str) -> None: ...

    def compile(self, site: Site) -> Test:
        state = self.state
        site.states.add(state)
        return lambda view: state in view.active

    def form(self, wanted: bool, depth: int) -> Form:
        return Atom("in", self.state, "" if wanted else "not", None)

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        return active(self.state)

    def words(self) -> str:
        return f"in {self.state}"
