# SPDX-License-Identifier: Apache-2.0
"""What a wait and a timeout of a compiled tree share: an instant at which time alone changes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.engine.trees.node import RUNNING, CompiledNode
from rai_missions.engine.trees.tick import Tick

__all__ = ("DeadlineNode",)


class DeadlineNode(CompiledNode):
    """A node that remembers its deadline while it runs."""

    __slots__ = ("until",)
    role = "waits"

    def __init__(self, children: Sequence[Any] = ()) -> None:
        super().__init__(children)
        self.until = 0.0
        """The instant of the deadline, seconds on the run's clock."""

    def begin(self, until: float, now: Tick) -> None:
        """Have a deadline from now on."""
        self.until = until
        now.waits.append(self)

    def memory(self) -> Mapping[str, Any] | None:
        return {"status": RUNNING, "until": self.until} if self.status is RUNNING else super().memory()

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.until = memory.get("until", 0.0)

    def deadline(self) -> float:
        return self.until
