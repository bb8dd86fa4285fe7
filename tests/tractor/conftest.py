# SPDX-License-Identifier: Apache-2.0
"""The shipped mission in a simulated orchard of one's own choice, with a look at what the tractor has done."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.trips import Moments, Trip, profile_of, trips

TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"


class Drive(Trip):
    """One run of the tractor's mission.

    Args:
        orchard: What the world takes; no camera, but the detector, unless named here.
        moments: When → what happens then.
        events_of: The profile whose anomaly is listened for.
        words: Fields of `RunConfig`.
    """

    def __init__(
        self, orchard: Mapping[str, Any], moments: Moments, *, events_of: str = "robot.sim.json", **words: Any
    ) -> None:
        profile = profile_of(TRACTOR)
        profile["connector"] |= orchard
        profile["events"]["anomaly"] = profile_of(TRACTOR, events_of)["events"]["anomaly"]
        alleys = {"alleys": orchard["alleys"]} if "alleys" in orchard else {}
        super().__init__(TRACTOR, profile, moments, **{"arguments": alleys, **words})


@pytest.fixture
def drive() -> Any:
    """Makes drives, and closes them."""
    yield from trips(Drive)
