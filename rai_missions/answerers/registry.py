# SPDX-License-Identifier: Apache-2.0
"""Answerers of other packages, which they offer by entry points.

Rule: one is loaded when a run begins whose mission asks it, never by reading a mission, a profile or a journal.
"""

from __future__ import annotations

from rai_missions.engine.decision import Answerer
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
    with offer.opening():
        answerer: Answerer = offer.keeping(Answerer, make())
    return answerer
