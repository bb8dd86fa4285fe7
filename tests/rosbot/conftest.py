# SPDX-License-Identifier: Apache-2.0
"""The shipped patrol in a simulated house of one's own choice, with a look at what the robot has done."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.runtime.result import Result
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


class BlockedPatrol(NamedTuple):
    """A patrol of which one door stays blocked, run to its end, and its journal."""

    one: Patrol
    result: Result
    journal: Path


@pytest.fixture(scope="module")
def blocked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BlockedPatrol]:
    journal = tmp_path_factory.mktemp("blocked") / "one.journal"
    for make in trips(Patrol):
        one = make(words={"journal": journal}, blocked=["study_pantry"])
        yield BlockedPatrol(one, one.run(), journal)


@pytest.fixture
def patrol() -> Any:
    """Makes patrols, and closes them."""
    yield from trips(Patrol)
