# SPDX-License-Identifier: Apache-2.0
"""Requests are read and planned amid regions, holds, timeouts and histories: a run is repeated and continued as it was.

Rule: a reading follows from the request, what is seen, and what was asked before; all three are in the journal.
"""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import Step
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.profile import robot_facts as terms_of
from rai_missions.replay.migrate import migrate
from rai_missions.replay.resume import resumption
from tests.laws import test_cut_short as cut_short
from tests.laws.drawn import document, happenings
from tests.laws.test_cut_short import NAMED, Written, is_far_by_new_names, profile, remembered
from tests.replay.test_renamed import TWO, otherwise
from tests.rigs.charts import ScriptedRobot
from tests.rigs.journals import assert_whole, cut_after_each
from tests.rigs.turns import sooner_ended

READ = ("goal", "candidates", "reason")
"""What a reading has: it was understood, a question was asked, or it was refused."""
READING = (5, 9, 13, 16)
"""Seeds of runs in which requests are read."""
MOST_CUTS = 30
"""Steps after which one run is cut."""


@sooner_ended()
def agree(folder: Path, seed: int) -> Counter[str]:
    """Cut a run after its steps; each time it is where it was, also in a mission of other names. Counts readings."""
    rng, found = random.Random(seed), Counter[str]()
    mission, script = Mission.model_validate(document(rng, wishes=True)), happenings(rng, wishes=True)
    (now, map_), state = otherwise(mission), rng.getstate()
    robot = profile(rng, mission)
    rng.setstate(state)
    new_robot, answers = profile(rng, now, TWO), ScriptedRobot("agent")
    whole = Chart(mission, robot_facts=terms_of(robot), named=NAMED)
    path, snapshots = folder / "run.journal", dict[int, Any]()
    with Journal.create(path, Header(dump(mission), dump_profile(robot))) as journal:
        written = Written(whole, journal)

        def note(step: Step) -> None:
            answers.follow(step)
            snapshots[step.seq] = whole.snapshot()
            for name, value in step.writes:
                found.update(f"reading {word}" for word in READ if name == "reading" and value.get(word))
                found["plan"] += name == "plan" and bool(value.get("moves"))

        note(written.step(lambda: whole.start(0.0)))
        for happening in script:
            if whole.outcome is None:
                event = answers.event(*happening)
                note(written.step(lambda event=event: whole.send(event)))
    assert_whole(path)
    every = len(snapshots) // MOST_CUTS + 1
    for step, cut in cut_after_each(path, lambda step: step.outcome is None and step.seq % every == 0):
        live = Chart.restore(mission, snapshots[step.seq], robot_facts=terms_of(robot), named=NAMED)
        with read(cut) as record:
            assert remembered(resumption(record, mission, named=NAMED).chart) == remembered(live), (seed, step.seq)
        new, named = folder / f"new-{step.seq}.journal", {"is_far": is_far_by_new_names}
        assert migrate(cut, now, map_, to=new, robot=new_robot, named=named).notes == ()
        with read(new) as record:
            migrated = resumption(record, now, named=named).chart
        live.settle_holds()
        assert remembered(migrated) == remembered(live), (seed, step.seq)
        found["cuts"] += 1
    return found


@pytest.mark.parametrize("seed", READING)
def test_a_run_that_reads_requests_is_where_it_was_after_each_of_its_steps(seed: int, tmp_path: Path) -> None:
    agree(tmp_path, seed)


@sooner_ended()
def continues(folder: Path, seed: int) -> str:
    """Cut a run short at random, and do the rest of what happens; gives whether there was something to compare."""
    return cut_short.agree(folder, seed, is_included=bool(seed % 2), wishes=True)


@pytest.mark.parametrize("seed", READING)
def test_a_run_that_reads_requests_does_what_it_would_have_done(seed: int, tmp_path: Path) -> None:
    assert continues(tmp_path, seed) == "same"


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_many_runs_that_read_requests_are_where_they_were_and_do_what_they_would_have_done(tmp_path: Path) -> None:
    found = Counter[str]()
    for seed in range(2_000):
        for law in (agree, continues):
            folder = tmp_path / f"{law.__name__} {seed}"
            folder.mkdir()
            gained = law(folder, seed)
            found.update([gained] if isinstance(gained, str) else gained)
    assert min(found[each] for each in ("same", "plan", *(f"reading {word}" for word in READ))) > 300, found
