# SPDX-License-Identifier: Apache-2.0
"""An answerer that takes the option with the fewest words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.decision import Question

__all__ = ("Cautious",)


class Cautious:
    """Answers at once."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Answer before returning."""
        shortest = min(question.options, key=lambda offer: len(offer.about))
        answer({"option": shortest.name, "parameters": {}, "why": "it has the fewest words"})

    def withdraw(self, number: int) -> None:
        """Nothing is ever under way."""
