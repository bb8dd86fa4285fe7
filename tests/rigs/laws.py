# SPDX-License-Identifier: Apache-2.0
"""A law that the suite tries a little, tried much in `make drill`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings

__all__ = ("drill",)


def drill(law: Callable[..., object], *strategies: Any, tried: settings) -> Any:
    """A law as a drill; the name that it is given in a module is that of its test.

    Args:
        law: What must hold of all that is drawn; it has no parameter with a default.
        strategies: For what it takes, in order.
        tried: How often, and with which checks.
    """
    test: Any = given(*strategies)(law)
    return pytest.mark.drill(tried(test))
