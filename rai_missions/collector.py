# SPDX-License-Identifier: Apache-2.0
"""Python's search for cyclic garbage, left out where there is none to be found."""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

__all__ = ("uncollected",)

Given = ParamSpec("Given")
Made = TypeVar("Made")


def uncollected(function: Callable[Given, Made]) -> Callable[Given, Made]:
    """A function during which the collector does not run, in the whole process.

    For what makes a large structure at one go, all of which is still in use when it ends: each search would look at
    what has been made so far and find nothing. Counting references frees the rest as ever. Afterwards the collector is
    as it was before, whatever was raised.

    Args:
        function: Ends within about a second, and waits for nothing.
    """

    @wraps(function)
    def without(*given: Given.args, **words: Given.kwargs) -> Made:
        if not gc.isenabled():
            return function(*given, **words)
        gc.disable()
        try:
            return function(*given, **words)
        finally:
            gc.enable()

    return without
