# SPDX-License-Identifier: Apache-2.0
"""What a campaign may use, and how fast a provider may be asked.

Rule: a campaign whose budget is spent begins no further call; what is under way is finished and stored.
"""

from __future__ import annotations

from collections.abc import Iterable

from rai_missions.campaign.file import BudgetEntry, RateEntry
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.store import DroppedUse

__all__ = ("CallPace", "Spending", "with_use_of")


class Spending:
    """What a campaign has used, over all its runs but for the time.

    Args:
        limits: How much it may use.
        before: What its store holds already.
        dropped: What was used by cells that it does not hold any more.
    """

    def __init__(
        self, limits: BudgetEntry, before: Iterable[CellRecord] = (), dropped: DroppedUse | None = None
    ) -> None:
        self._limits = limits
        self.calls, self.tokens, self.money = dropped or DroppedUse()
        for record in before:
            self.add(record)

    def add(self, record: CellRecord) -> None:
        """Count a cell."""
        self.calls += record.calls
        self.tokens += record.prompt_tokens + record.completion_tokens
        self.money += record.cost

    def spent(self, seconds: float) -> str:
        """Which part of the budget is spent, in words; empty while none is.

        Args:
            seconds: Wall time of this run.
        """
        used = {"calls": self.calls, "tokens": self.tokens, "money": self.money, "seconds": seconds}
        for word, amount in used.items():
            limit = getattr(self._limits, word)
            if limit is not None and amount >= limit:
                return f"the budget of {limit:g} {word} is spent"
        return ""


def with_use_of(record: CellRecord, earlier: CellRecord) -> CellRecord:
    """A cell that was asked again, with what was used when it failed: no budget forgets that.

    Args:
        record: The cell as it is now.
        earlier: The same cell, which had failed.
    """
    return record._replace(
        calls=record.calls + earlier.calls,
        prompt_tokens=record.prompt_tokens + earlier.prompt_tokens,
        completion_tokens=record.completion_tokens + earlier.completion_tokens,
        cost=record.cost + earlier.cost,
    )


class CallPace:
    """How fast one worker may ask a provider: its share of what all workers together may.

    Args:
        rate: The rate of all workers together.
        workers: How many there are.
    """

    def __init__(self, rate: RateEntry, workers: int) -> None:
        self._call_s = 60.0 * workers / rate.calls_per_minute if rate.calls_per_minute else 0.0
        self._token_s = 60.0 * workers / rate.tokens_per_minute if rate.tokens_per_minute else 0.0
        self._next_at = 0.0

    def delay_s(self, now: float) -> float:
        """How long the next call must wait, 0 or more.

        Args:
            now: Seconds, of a clock that only moves forward.
        """
        return max(0.0, self._next_at - now)

    def spend(self, now: float, calls: int, tokens: int) -> None:
        """Count what was used until now."""
        self._next_at = max(now, self._next_at) + max(calls * self._call_s, tokens * self._token_s)
