# SPDX-License-Identifier: Apache-2.0
"""The shipped patrol in a simulated house of one's own choice, with a look at what the robot has done."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.trips import Moments, Trip, profile_of, trips

ROSBOT = Path(__file__).parents[2] / "missions" / "rosbot"


class Patrol(Trip):
    """One run of the patrol.

    Args:
        house: What the world takes; no camera unless named here.
        moments: When → what happens then.
        words: Fields of `RunConfig`.
    """

    def __init__(self, house: Mapping[str, Any], moments: Moments, **words: Any) -> None:
        profile = profile_of(ROSBOT)
        profile["connector"] |= {"camera": False, **house}
        super().__init__(ROSBOT, profile, moments, **words)


@pytest.fixture
def patrol() -> Any:
    """Makes patrols, and closes them."""
    yield from trips(Patrol)
