# SPDX-License-Identifier: Apache-2.0
"""Whatever mission it is, and whenever its processes die: nothing is lost, done twice or left over."""

from __future__ import annotations

import itertools
import logging
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from tests.replay.coroner import INSTANTS
from tests.replay.trial import ReceivedEvent, part_within_an_instant, tried, worth_a_trial
from tests.strategies import missions

KILLS = 10_000
TRIALS_EACH = 3
"""Of one mission, each with surroundings and deaths of its own."""


@settings(deadline=None, max_examples=6)
@given(missions(), st.integers(0, 10_000))
def test_whatever_mission_is_killed_whenever_it_continues_as_if_it_had_not_been(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, seed: int
) -> None:
    tried(tmp_path_factory.mktemp("any"), mission, seed)


def trials() -> Iterator[tuple[int, Mission]]:
    """Missions, each with a seed of its own, from which the rest of a trial follows."""
    for batch in itertools.count(1):
        for number, mission in enumerate(worth_a_trial(batch, 100)):
            for trial in range(TRIALS_EACH):
                yield batch * 1000 + number * TRIALS_EACH + trial, mission


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_ten_thousand_kills_at_instants_of_every_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    began, count, runs = time.monotonic(), 0, 0
    kinds, compared = Counter[str](), Counter[str]()
    logging.disable(logging.CRITICAL)
    try:
        for seed, mission in trials():
            folder = tmp_path / str(seed)
            folder.mkdir()
            try:
                found = tried(folder, mission, seed)
            except BaseException as error:
                error.add_note(f"seed {seed}; its journals are in {folder}")
                raise
            shutil.rmtree(folder)
            count, runs = count + found.deaths, runs + 1
            kinds.update(found.kills)
            compared[found.compared] += 1
            if runs % 100 == 0 or count >= KILLS:
                with capsys.disabled():
                    print(  # noqa: T201
                        f"\n{count} kills of {runs} runs in {time.monotonic() - began:.0f} s; "
                        f"{dict(compared)}; {dict(kinds.most_common())}",
                        flush=True,
                    )
            if count >= KILLS:
                break
    finally:
        logging.disable(logging.NOTSET)
    assert all(kinds[each] >= KILLS / 100 for each in INSTANTS), kinds
    assert compared["same"] >= runs / 3
    assert compared["two things at one instant"] <= runs / 50


A, B, C = (ReceivedEvent(2.0, "event", name, 0, "[]") for name in "abc")
LATER = ReceivedEvent(3.0, "event", "a", 0, "[]")


@pytest.mark.parametrize(
    ("whole", "run", "is_so"),
    [
        ([A, B], [B, A], True),
        ([A, B], [A], True),  # the other ended before it looked at the second
        ([A], [B, C], True),
        ([A, B], [A, B], False),
        ([A, LATER], [A], False),
        ([A, LATER], [A, B], False),
        ([LATER, A], [B, LATER], False),
        ([A], [], False),
    ],
)
def test_runs_that_part_within_an_instant_are_those_that_took_its_things_in_another_order(
    whole: list[ReceivedEvent], run: list[ReceivedEvent], is_so: bool
) -> None:
    assert part_within_an_instant(whole, run) is is_so
    assert part_within_an_instant(run, whole) is is_so
