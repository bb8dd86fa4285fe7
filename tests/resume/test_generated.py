# SPDX-License-Identifier: Apache-2.0
"""Whatever mission it is, and whenever its processes die: nothing is lost, done twice or left over."""

from __future__ import annotations

import logging
import random
import time
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from rai_missions.journal import read
from rai_missions.mission import Mission
from rai_missions.step import CallService, PublishMessage, StartGoal
from tests.resume.farm import ACTIONS, FARMER, Farm
from tests.resume.mortal import Choosing, Fate, Wish, live
from tests.resume.test_kills import holds, lived
from tests.resume.test_kinds import is_mode, post
from tests.strategies import EVENTS, missions

ENDS_AT_S = 20.0
MOST_KILLS = 1000
Deaths = list[tuple[int, bool]]


def wishes(seed: int) -> list[Wish]:
    """Events, a pause or not, and at last a cancel: every run ends."""
    chance = random.Random(seed)
    said: set[int] = set()

    def once(number: int, name: str) -> Wish:
        def say(runner: object) -> None:
            said.add(number)
            post(name)(runner)

        return Wish(chance.uniform(1, ENDS_AT_S), say, lambda _: number in said)

    wanted = [once(number, chance.choice(EVENTS)) for number in range(chance.randint(0, 4))]
    if chance.random() < 0.4:
        at = chance.uniform(1, ENDS_AT_S - 5)
        wanted += [Wish(at, lambda runner: runner.pause(), is_mode("paused")),
                   Wish(at + 3, lambda runner: runner.resume(), is_mode("running"))]  # fmt: skip
    wanted.sort(key=lambda wish: wish.at)
    return [*wanted, Wish(ENDS_AT_S, lambda runner: runner.cancel(), lambda runner: runner.chart.outcome is not None)]


def there(seed: int) -> Farm:
    chance = random.Random(seed)
    lasts_s = {action: chance.choice([0.5, 2.0, 6.0, 40.0]) for action in ACTIONS}
    ends = {action: chance.choice(["succeeded", "succeeded", "failed"]) for action in ACTIONS}
    return Farm(wishes(seed), lasts_s, ends)


def answerers(seed: int) -> dict[str, Choosing]:
    chance = random.Random(seed)
    names = ("drive_over", "replan", "wait", "give_up", "nonsense")
    return {who: Choosing(chance.choice(names)) for who in ("agent", "operator", "rules") if chance.random() < 0.8}


def killed(path: Path, mission: Mission, deaths: Deaths, seed: int, dead_s: float) -> int:
    """Live as often as that, and look at what is left; gives how many deaths there were."""
    farm = there(seed)
    fates = [Fate(at, is_done=is_done) for at, is_done in deaths]
    ended = lived(path, farm, fates, mission, FARMER, dead_s, answerers(seed))
    assert ended.outcome is not None
    holds(path, farm, mission)
    with read(path) as record:
        effects = {step.seq: step.effects for step in record.steps()}
        confirmed = record.confirmations()
    wanted = Counter(each.service for some in effects.values() for each in some if isinstance(each, CallService))
    sure = Counter(
        each.service for seq, how in confirmed.items() if how == "performed" for each in effects[seq]
        if isinstance(each, CallService)
    )  # fmt: skip
    assert sure["replan"] <= farm.called["/replan"] <= wanted["replan"], (
        "what may not be repeated was done once at most"
    )
    assert sure["horn"] <= farm.called["/horn"] <= wanted["horn"] + len(deaths) * max(1, wanted["horn"])
    goals = [each for some in effects.values() for each in some if isinstance(each, StartGoal)]
    assert len(farm.started) <= len(goals)
    lamps = [each for some in effects.values() for each in some if isinstance(each, PublishMessage)]
    assert farm.heard["/once_topic"] <= len(lamps)
    return sum(fate.is_dead for fate in fates)


@settings(deadline=None, max_examples=25)
@given(
    missions(), st.lists(st.tuples(st.integers(0, 40), st.booleans()), min_size=1, max_size=5),
    st.integers(0, 1000), st.sampled_from([0.0, 3.0]),
)  # fmt: skip
def test_whatever_mission_is_killed_whenever_nothing_is_lost_and_nothing_done_twice(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, deaths: Deaths, seed: int, dead_s: float
) -> None:
    killed(tmp_path_factory.mktemp("any") / "run.journal", mission, deaths, seed, dead_s)


@given(missions(), st.integers(0, 1000))
def test_a_process_that_lives_is_one_run(tmp_path_factory: pytest.TempPathFactory, mission: Mission, seed: int) -> None:
    path, farm = tmp_path_factory.mktemp("one") / "run.journal", there(seed)
    assert live(path, farm, mission, FARMER, answerers(seed), Fate()) is not None
    holds(path, farm, mission)


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_a_thousand_kills(tmp_path_factory: pytest.TempPathFactory) -> None:
    logging.disable(logging.CRITICAL)
    began, count = time.monotonic(), 0

    @settings(max_examples=100_000, deadline=None, database=None, phases=[Phase.generate])
    @given(
        missions(), st.lists(st.tuples(st.integers(0, 120), st.booleans()), min_size=3, max_size=8),
        st.integers(0, 1000), st.sampled_from([0.0, 3.0]),
    )  # fmt: skip
    def die(mission: Mission, deaths: Deaths, seed: int, dead_s: float) -> None:
        nonlocal count
        if count < MOST_KILLS:
            count += killed(tmp_path_factory.mktemp("many") / "run.journal", mission, deaths, seed, dead_s)

    try:
        die()
    finally:
        logging.disable(logging.NOTSET)
    print(f"{count} kills in {time.monotonic() - began:.0f} s")  # noqa: T201 - the figure that the drill is for
    assert count >= MOST_KILLS
