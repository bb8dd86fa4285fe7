# SPDX-License-Identifier: Apache-2.0
"""A guard that has been true for a while: `{"held": guard, "for_s": 2}`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from rai_missions.guards.guard import Guard, Site, Test, Truth, View
from rai_missions.model import OneOf, Seconds

__all__ = ("Held",)


class Held(Guard, word="held"):
    """True once the inner guard has been true for so long without a break; unknown while the inner one is.

    The time counts while the guard is watched: from the entry of the state whose row it is, at the earliest.
    """

    positional: ClassVar = ("held", "for_s")

    held: OneOf[Guard]
    for_s: Seconds

    def compile(self, site: Site) -> Test:
        inner = self.held.compile(site)
        memory = f"{site.place}#{len(site.holds)}"
        site.holds[memory] = inner
        for_s = self.for_s
        site.instants.append(lambda view: view.held.get(memory, math.inf) + for_s)

        def test(view: View) -> Truth:
            now = inner(view)
            if now is not True:
                return now
            since = view.held.get(memory)
            return view.at >= since + for_s if since is not None else for_s == 0

        return test

    def inner(self) -> Iterator[Guard]:
        yield self.held

    def words(self) -> str:
        return f"{self.held.words()}, for {self.for_s:g} s"
