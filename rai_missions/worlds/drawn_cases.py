# SPDX-License-Identifier: Apache-2.0
"""Which of some weighted cases a seed draws.

Rule: cases are taken by the golden ratio's multiples, so that any run of seeds holds each case in about its share.
"""

from __future__ import annotations

import random
from bisect import bisect
from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import Any

__all__ = ("DrawnCase", "drawn_case")

GOLDEN = 0.6180339887498949

DrawnCase = tuple[float, str, Callable[[random.Random], dict[str, Any]]]
"""Weight, kind, and what is drawn for it."""


def drawn_case(seed: int, cases: Sequence[DrawnCase]) -> DrawnCase:
    """The case of a seed.

    Args:
        seed: At least 0.
        cases: At least one; neighbours are drawn by the same seeds where their weights change a little.
    """
    totals = list(accumulate(weight for weight, _, _ in cases))
    return cases[bisect(totals, (seed * GOLDEN % 1.0) * totals[-1])]
