# SPDX-License-Identifier: Apache-2.0
"""An inspection: `{"inspect": "bell", "settle_s": 2}` strikes, waits, and asks whether that was enough."""

from __future__ import annotations

from typing import ClassVar

from rai_missions.model import Seconds, ServiceName
from rai_missions.states.decision import DecisionSpec, Option
from rai_missions.states.state import State
from rai_missions.states.tree import Call, Decision, Sequence, TreeNode, Wait

__all__ = ("Inspect",)


class Inspect(State, word="inspect"):
    """Runs a tree of the format's own nodes, which it makes of its fields."""

    positional: ClassVar = ("inspect",)

    inspect: ServiceName
    settle_s: Seconds = 1.0

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed"}

    def activity(self) -> str:
        return f"inspect with {self.inspect}"

    def made(self) -> TreeNode:
        options = {"enough": Option("the bell was loud enough"), "again": Option("strike once more")}
        asked = DecisionSpec("Was that enough?", options=options, ask=("someone",), deadline_s=10.0, fallback="again")
        strike = Call(self.inspect, timeout_s=5.0)
        return Sequence([strike, Wait(self.settle_s), Decision(decision=asked, then={"again": strike})])
