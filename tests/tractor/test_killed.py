# SPDX-License-Identifier: Apache-2.0
"""The shipped mission over ROS 2, killed with `kill -9` while its tractor continues: it ends as it does without."""

from __future__ import annotations

import itertools
import json
import os
import random
import re
import signal
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.journal import verify
from rai_missions.replay.replay import replay
from tests.replay.deaths import Nursery, wait_until
from tests.replay.instants import Instant
from tests.ros2 import on_ros
from tests.tractor.ros2_processes import TRACTOR, Graph, Process, graph_in

pytestmark = [pytest.mark.sim, on_ros]
BRANCH = {"alleys": 1, "length_m": 14, "obstacles": ["branch"]}
ANIMAL = {**BRANCH, "obstacles": ["animal"]}
ORCHARD = {"alleys": 2, "seed": 3}
"""What the world chooses by its seed: it stops twice for an animal and once for a branch."""
WHY = "'done' was reached, and alleys_driven ≥ alleys"
WORDS = ("state: DRIVING", "state: STOPPED", "passed: True", "state: CHANGING_PATH")
OFTEN = {
    "a step is done again": 40, "the run is resumed": 1, "the robot reports again": 8, "a question is asked again": 1,
    "a step is taken": 300, "a row is written": 25, "effects are performed": 12, "a service is called": 3,
    "a call is sent": 3, "an acceptance comes": 3, "a result comes": 4, "an answer comes": 1,
}  # fmt: skip
"""Instant → how often it comes in a life at the most."""
PATIENT_S = 60
"""A busy machine may take longer to find the world than the shipped mission waits; it would stop the tractor then."""
LIFE_S, ALONE_S = 60.0, 100.0


class Death(NamedTuple):
    """When a life ends, and how long the tractor is alone then."""

    word: str = ""
    """What the world reports."""
    delay_s: float = 0.0
    instant: Instant | None = None
    until: str = ""
    """What the world reports before the next life begins; at once, if nothing."""
    alone_s: float = ALONE_S
    """For so long at the most."""


class Orchard(Graph):
    """A world in one process, and lives of a run in others."""

    nursery: Nursery
    kills = 0
    numbers = itertools.count()

    def drive(self, deaths: list[Death], options: Mapping[str, Any] = BRANCH, speed: str = "1") -> None:
        """One run, killed so, with a world of its own; it must end as if it had not been."""
        world = self.world(speed=speed, **options)
        journal = self.folder / f"{next(self.numbers)}.journal"
        for death in (*deaths, Death()):
            reported = len(world.lines.all)
            self.nursery.begin(self.words(journal, options["alleys"]), death.instant)
            status = self.life(world, death, reported) if death in deaths else self.nursery.ends()
            text = self.nursery.out.read_text(errors="replace")
            assert "Traceback" not in text, text
            if status != -signal.SIGKILL:
                break
            self.kills += 1
            reported = len(world.lines.all)
            wait_until(lambda death=death, reported=reported: reports(world, death.until, reported), death.alone_s)  # type: ignore[misc]
        assert verify(journal) == ()
        again = replay(journal)
        assert again.holds, again.difference
        assert (again.outcome, again.why) == ("succeeded", WHY), (deaths, text, world.text)
        assert "touched_living: True" not in world.text
        world.signal(signal.SIGINT)
        assert world.ends() == 0, world.text

    def words(self, journal: Path, alleys: int) -> list[str]:
        if journal.exists():
            return ["run", "--resume", str(journal), "--no-operator"]
        robot, mission = str(TRACTOR / "robot.ros2.json"), self.mission(ready_s=PATIENT_S)
        return ["run", str(mission), "--robot", robot, "--no-operator", "--set", f"alleys={alleys}",
                "--journal", str(journal)]  # fmt: skip

    def life(self, world: Process, death: Death, reported: int) -> int:
        def is_over() -> bool:
            return self.nursery.status is not None

        if death.word:
            wait_until(lambda: is_over() or reports(world, death.word, reported), LIFE_S)
        wait_until(is_over, death.delay_s)
        if not is_over():
            self.nursery.signal(signal.SIGKILL)
        return self.nursery.ends()


def reports(world: Process, pattern: str, since: int) -> bool:
    return any(re.search(pattern, line) for line in world.lines.all[since:])


@pytest.fixture
def orchard(tmp_path: Path) -> Iterator[Orchard]:
    for graph in graph_in(tmp_path, Orchard):
        graph.nursery = Nursery(tmp_path, graph.environment)
        yield graph
        graph.nursery.close()


ALONE_TO_THE_END = "state: FINISHED"


@pytest.mark.long
@pytest.mark.parametrize(
    "death",
    [
        Death("state: STOPPED", instant=Instant("an acceptance comes", 2, True), delay_s=30.0, until=ALONE_TO_THE_END),
        pytest.param(Death("passed: True", delay_s=0.1, until=ALONE_TO_THE_END), marks=pytest.mark.drill),
    ],
    ids=["as it drives over the branch", "with the branch behind it"],
)
def test_a_tractor_that_finished_its_alley_alone_is_no_failure(orchard: Orchard, death: Death) -> None:
    orchard.drive([death], speed="2")


@pytest.mark.drill
def test_a_start_of_which_no_one_knows_is_looked_after(orchard: Orchard) -> None:
    """Killed as it is asked to drive on, and then as it is asked to drive over the branch."""
    orchard.drive([Death(delay_s=60.0, instant=Instant("a call is sent", number, True)) for number in (1, 2)])


@pytest.mark.drill
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("options", [BRANCH, ANIMAL, ORCHARD], ids=["branch", "animal", "seed 3"])
def test_killed_after_a_row_it_ends_as_if_it_had_not_been(orchard: Orchard, options: Mapping[str, Any]) -> None:
    """`RAI_MISSIONS_ROWS` reports after which rows, as `9,11,12`."""
    for row in (int(each) for each in os.environ.get("RAI_MISSIONS_ROWS", "3,9,11,12,15,20").split(",")):
        orchard.drive([Death(delay_s=60.0, instant=Instant("a row is written", row, True))], options)
        print(f"after row {row}: {orchard.kills} kills", flush=True)  # noqa: T201 - the figure


def chosen(chance: random.Random) -> Death:
    """The next death of a drill."""
    until = chance.choice(("", "", ALONE_TO_THE_END))
    alone_s = chance.uniform(0.0, 20.0) if not until else ALONE_S
    kind = chance.choice(("time", "word", "instant", "instant"))
    if kind == "time":
        return Death(delay_s=chance.uniform(0.0, 40.0), until=until, alone_s=alone_s)
    if kind == "word":
        return Death(chance.choice(WORDS), chance.uniform(0.0, 3.0), until=until or "$^", alone_s=alone_s)
    name = chance.choice(list(OFTEN))
    instant = Instant(name, chance.randint(1, OFTEN[name]), chance.random() < 0.5)
    return Death(delay_s=chance.uniform(20.0, 50.0), instant=instant, until=until or "$^", alone_s=alone_s)


@pytest.mark.drill
@pytest.mark.timeout(14_400)
def test_whenever_it_is_killed_the_tractors_mission_ends_as_if_it_had_not_been(orchard: Orchard) -> None:
    """`RAI_MISSIONS_KILLS` reports how often; `RAI_MISSIONS_SEED` by which chance."""
    most, chance = int(os.environ.get("RAI_MISSIONS_KILLS", "40")), random.Random(os.environ.get("RAI_MISSIONS_SEED"))
    while orchard.kills < most:
        deaths = [chosen(chance) for _ in range(chance.randint(1, 3))]
        orchard.drive(deaths)
        print(f"{orchard.kills} kills: {json.dumps(deaths)}", flush=True)  # noqa: T201 - the figure
