# SPDX-License-Identifier: Apache-2.0
"""Answerers of other packages, which they offer by entry points.

Rule: one is loaded when a run begins whose mission asks it, never by reading a mission, a profile or a journal.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rai_missions.engine.decision import Answerer
from rai_missions.errors import UsageError, in_words
from rai_missions.kinds import PackageOffer

__all__ = ("open_answerer",)


def open_answerer(offer: PackageOffer) -> Answerer:
    """An answerer of another package: what its entry point leads to, called without arguments.

    Args:
        offer: As `Mission.answerers` has it.

    Raises:
        UsageError: It does not load, raises, or gives something that answers no questions; with name and package.
    """
    make = offer.load()
    if not callable(make):
        raise UsageError(f"{offer} leads to {type(make).__name__}, not to a class or function that makes one")
    try:
        made = make()
    except Exception as error:
        raise UsageError(f"{offer} cannot be opened ({type(error).__name__}: {in_words(error)})") from error
    if lacks := _lacks(made, ("ask", "withdraw")):
        raise UsageError(
            f"{offer} is a {type(made).__name__} without '{lacks}'; see Answerer in the guide on decisions"
        )
    answerer: Answerer = made
    return answerer


def _lacks(made: Any, methods: Iterable[str]) -> str:
    """The first method that something does not have; empty if it has all."""
    return next((name for name in methods if not callable(getattr(made, name, None))), "")
