# SPDX-License-Identifier: Apache-2.0
"""Time since the state was entered: `{"elapsed_s": 5}`."""

from __future__ import annotations

import math
from collections.abc import Callable

from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Test, Truth, View
from rai_missions.model import Seconds

__all__ = ("Elapsed",)


class Elapsed(Guard, word="elapsed_s"):
    """True once the state whose rule this is has been active for so long; never unknown."""

    elapsed_s: Seconds
    """Seconds since the state was entered."""

    def __init__(self, elapsed_s: float) -> None: ...

    def compile(self, site: Site) -> Test:
        state, elapsed_s = site.state, self.elapsed_s
        site.clocked.add(state)

        def due(view: View) -> float:
            return view.entered.get(state, math.inf) + elapsed_s

        def test(view: View) -> Truth:
            return view.at >= due(view)

        site.instants.append(due)
        return test

    @property
    def age_s(self) -> float:  # type: ignore[override]
        return self.elapsed_s

    def form(self, wanted: bool, depth: int) -> Form:
        return Atom("compare", "<elapsed>", ">=" if wanted else "<", self.elapsed_s)  # no key is called so

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        return False if restarted and self.elapsed_s > 0 else None

    def words(self) -> str:
        return f"{self.elapsed_s:g} s have passed"
