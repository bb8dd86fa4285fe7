# SPDX-License-Identifier: Apache-2.0
"""Parameters of which `make test` tries some, and the long tests all others."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

__all__ = ("sampled",)


def sampled(values: Iterable[Any], every: int) -> list[Any]:
    """Each value as a parameter; `make test` has the first of each so many.

    Args:
        values: What the test takes: a tuple where it takes several arguments.
        every: One of how many is quick.
    """
    rows = (each if isinstance(each, tuple) else (each,) for each in values)
    return [pytest.param(*row, marks=[pytest.mark.long] * (at % every != 0)) for at, row in enumerate(rows)]
