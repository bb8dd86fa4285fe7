# SPDX-License-Identifier: Apache-2.0
"""A guard that has been true for a while: `{"held": guard, "for_s": 2}`."""

from __future__ import annotations

import math
from collections.abc import Callable

from rai_missions.guards.analysis import Sources
from rai_missions.guards.form import Atom, Form, Junction
from rai_missions.guards.guard import Guard, GuardOrKey, form_of, text_of
from rai_missions.guards.view import Site, Test, Truth, View
from rai_missions.model import AnyOf, Seconds

__all__ = ("Held",)


class Held(Guard, word="held"):
    """True once the inner guard has been true for so long without a break; unknown while the inner one is.

    The time counts while the guard is watched: from the entry of the state whose transition it is, at the earliest.
    """

    held: AnyOf[Guard]
    """The guard that must have been true without a break."""
    for_s: Seconds
    """For how many seconds."""

    def __init__(self, held: GuardOrKey, for_s: float) -> None: ...

    def compile(self, site: Site) -> Test:
        inner = self.held.compiled(site)
        memory = f"{site.place}#{len(site.held_guards)}"
        site.held_guards[memory] = inner
        for_s = self.for_s
        site.instants.append(lambda view: view.true_since.get(memory, math.inf) + for_s)

        def test(view: View) -> Truth:
            now = inner(view)
            if now is not True:
                return now
            since = view.true_since.get(memory)
            return view.at >= since + for_s if since is not None else for_s == 0

        return test

    @property
    def held_s(self) -> float:  # type: ignore[override]
        return self.for_s

    def form(self, wanted: bool, depth: int) -> Form:
        """The inner guard is true now, and has been for so long: in Kleene's logic the same as the guard itself."""
        long = Atom("compare", f"<held {text_of(self.held)}>", ">=" if wanted else "<", self.for_s)
        return Junction("all" if wanted else "any", (long, form_of(self.held, wanted, depth)))

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return self.held.rests(sources, wanted=wanted)

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        return self.held.noticed(wanted=wanted)

    def after_jump(self, active: Callable[[str], Truth], *, restarted: bool) -> Truth:
        return False if restarted and self.for_s > 0 else None

    def words(self) -> str:
        return f"{self.held.words()}, for {self.for_s:g} s"
