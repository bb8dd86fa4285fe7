# SPDX-License-Identifier: Apache-2.0
"""Whether a key has been received lately: `{"fresh": "obstacle"}`."""

from __future__ import annotations

from typing import ClassVar

from rai_missions.guards.analysis import Distinctions
from rai_missions.guards.form import Atom, Form
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import KeyPath, Path

__all__ = ("Fresh",)


class Fresh(Guard, word="fresh"):
    """True where the key was received and is not older than its `max_age_s`; never unknown."""

    fades: ClassVar = False

    fresh: Path
    """The key that must have been received, and be younger than its `max_age_s`."""

    def __init__(self, fresh: KeyPath) -> None: ...

    def compile(self, site: Site) -> Test:
        operand = Operand(self.fresh, site)

        def test(view: View) -> Truth:
            return operand.read(view) is not None

        return test

    def form(self, wanted: bool, depth: int) -> Form:
        return Atom("fresh", self.fresh, "" if wanted else "not", None)

    def noticed(self, *, wanted: bool = True) -> frozenset[str]:
        return frozenset() if wanted else frozenset({self.fresh.partition(".")[0]})

    def distinguish(self, by: Distinctions) -> None:
        by.ask(self.fresh)

    def words(self) -> str:
        return f"{self.fresh} is fresh"
