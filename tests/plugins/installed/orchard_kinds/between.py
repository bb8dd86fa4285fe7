# SPDX-License-Identifier: Apache-2.0
"""A number within two bounds: `{"between": "humidity", "low": 0.2, "high": 0.6}`."""

from __future__ import annotations

from typing import ClassVar

from rai_missions.guards.analysis import Distinctions, Sources
from rai_missions.guards.form import Atom, Form, Junction
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Operand, Site, Test, Truth, View
from rai_missions.model import Number, Path

__all__ = ("Between",)


class Between(Guard, word="between"):
    """True where a number lies within two bounds, both included; unknown where there is none."""

    positional: ClassVar = ("between", "low", "high")

    between: Path
    low: Number
    high: Number

    def compile(self, site: Site) -> Test:
        operand, low, high = Operand(self.between, site), self.low, self.high

        def test(view: View) -> Truth:
            value = operand.read(view)
            return None if value is None else bool(low <= value <= high)

        return test

    def words(self) -> str:
        return f"{self.between} from {self.low:g} to {self.high:g}"

    def form(self, wanted: bool, depth: int) -> Form:
        low = Atom("compare", self.between, ">=" if wanted else "<", self.low)
        high = Atom("compare", self.between, "<=" if wanted else ">", self.high)
        return Junction("all" if wanted else "any", (low, high))

    def rests(self, sources: Sources, *, wanted: bool = True) -> bool:
        return sources.is_robots(self.between)

    def distinguish(self, by: Distinctions) -> None:
        by.compare(self.between, ">=", self.low)
        by.compare(self.between, "<=", self.high)
