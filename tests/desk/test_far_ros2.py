# SPDX-License-Identifier: Apache-2.0
"""The mission over ROS 2, its process killed with SIGKILL at drawn instants, the desk alive in this one."""

from __future__ import annotations

import os
import random
import signal
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import pytest

from rai_missions.connectors.ros2 import open_connector
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.worlds.bridge import PublishedWorld, TrackedConnector
from rai_missions.worlds.desk.world import Desk
from tests.desk.episodes import DESK_MISSIONS
from tests.desk.onlooker import DeskVerdict, Onlooker
from tests.desk.outside import HardCase, hard_case
from tests.replay.deaths import Nursery, has_begun
from tests.replay.instants import Instant
from tests.ros2 import load_quietly, on_ros, with_messages
from tests.tractor.ros2_processes import ros_domain

MISSION, PROFILE = str(DESK_MISSIONS / "arrange.json"), str(DESK_MISSIONS / "robot.ros2.json")
SPEED = 4.0
LONGEST_S = 600.0
"""Simulated; a life that takes longer does not end."""
OFTEN = {
    "a step is done again": 12, "the run is resumed": 1, "the robot reports again": 3, "a step is taken": 40,
    "a row is written": 40, "effects are performed": 8, "a goal is given to the connector": 4, "a goal is sent": 4,
    "a goal is looked for": 1, "an acceptance comes": 3, "a result comes": 3,
}  # fmt: skip
"""Instant → how often it comes in a life at the most."""

pytestmark = [
    pytest.mark.drill,
    pytest.mark.sim,
    on_ros,
    with_messages("rai_missions_msgs"),
]


class Death(NamedTuple):
    """When a life ends: so long after its start, or after a thing came into the hand; or at an instant of its own."""

    kind: str
    later_s: float
    instant: Instant | None
    alone_s: float
    """Simulated seconds, as `later_s`."""


def drawn(rng: random.Random) -> Death:
    kind, alone_s = rng.choice(("time", "hand", "hand", "instant", "instant")), rng.choice((0.0, 0.0, 2.0, 8.0, 40.0))
    if kind != "instant":
        return Death(kind, rng.uniform(0.0, 40.0 if kind == "time" else 4.0), None, alone_s)
    name = rng.choice(list(OFTEN))
    return Death(kind, 60.0, Instant(name, rng.randint(1, OFTEN[name]), rng.random() < 0.5), alone_s)


class RosDesk:
    """A desk on ROS that this process steps, and lives of one run in others.

    Args:
        case: What is asked for, and at which desk.
        nursery: Where lives come from.
        journal: The journal of the run.
    """

    def __init__(self, case: HardCase, nursery: Nursery, journal: Path) -> None:
        self._case, self._nursery, self._journal = case, nursery, journal
        self.onlooker = Onlooker(Desk(**{"camera": False, **case.world}))
        self._connector = open_connector({})
        self._connector.start()
        front = TrackedConnector(self._connector)
        stage = PublishedWorld(self.onlooker, front)  # type: ignore[arg-type]
        self.onlooker.world.open(self.onlooker.front(front))
        assert not front.left_out, front.left_out
        self._stage, self._clock, self._mailbox = stage, SimulatedClock(stage, SPEED), Mailbox()
        self.killed: Counter[str] = Counter()
        self.held = 0

    def run(self, deaths: list[Death]) -> DeskVerdict:
        """One run, killed so, and then left alone to its end."""
        for death in (*deaths, None):
            self._nursery.begin(self._words(), death.instant if death is not None else None)
            status = self._life(death)
            text = self._nursery.out.read_text(errors="replace")
            assert "Traceback" not in text, text
            if status != -signal.SIGKILL:
                assert status in (0, 1) or "has ended" in text, (status, text)
                break
            assert death is not None
            self.killed[death.kind] += 1
            self.held += bool(self.onlooker.truth.held)
            self._go(death.alone_s, is_alone=True)
        return self.onlooker.verdict(self._journal, self._case.goal)

    def close(self) -> None:
        self._connector.stop()
        self.onlooker.world.close()

    def _words(self) -> list[str]:
        journal = self._journal
        if has_begun(journal):
            return ["run", "--resume", str(journal), "--no-operator"]
        for left in (journal, journal.with_name(f"{journal.name}-wal")):
            left.unlink(missing_ok=True)
        return ["run", MISSION, "--robot", PROFILE, "--no-operator", "--set", f"request={self._case.request}",
                "--journal", str(journal)]  # fmt: skip

    def _life(self, death: Death | None) -> int:
        """Let the world pass until a life has ended, by itself or as it was to; how it ended."""
        begun = self._stage.at
        due = begun + death.later_s if death is not None and death.kind != "hand" else None
        while self._nursery.status is None:
            assert self._stage.at - begun < LONGEST_S, self._nursery.out.read_text(errors="replace")
            self._go(self._stage.period_s)
            if death is not None and due is None and self.onlooker.truth.held:
                due = self._stage.at + death.later_s
            if due is not None and self._stage.at >= due and self._nursery.status is None:
                self._nursery.signal(signal.SIGKILL)
                return self._nursery.ends()
        return self._nursery.ends()

    def _go(self, seconds: float, *, is_alone: bool = False) -> None:
        self.onlooker.is_alone = is_alone
        until = self._stage.at + seconds - 1e-6
        self._clock.wait(self._mailbox, until, paced=False)


@pytest.fixture
def nursery(tmp_path: Path) -> Iterator[Nursery]:
    load_quietly()
    with ros_domain(tmp_path / "ros-log") as environment, pytest.MonkeyPatch.context() as patch:
        for name, value in environment.items():
            patch.setenv(name, value)
        with closing(Nursery(tmp_path, environment)) as made:
            yield made


@pytest.mark.timeout(7200)
def test_over_ros_whenever_it_is_killed_the_run_claims_what_is_so(nursery: Nursery, tmp_path: Path) -> None:
    """`RAI_MISSIONS_KILLED_RUNS` runs from `RAI_MISSIONS_SEED` on, each killed up to three times."""
    first = int(os.environ.get("RAI_MISSIONS_SEED", "0"))
    count = int(os.environ.get("RAI_MISSIONS_KILLED_RUNS", "10"))
    wrong, killed, held, ends = [], Counter[str](), 0, Counter[str | None]()
    for seed in range(first, first + count):
        rng = random.Random(f"far on ROS {seed}")
        deaths = [drawn(rng) for _ in range(rng.randint(1, 3))]
        with closing(RosDesk(hard_case(rng.randrange(72) + 72 * seed), nursery, tmp_path / f"{seed}.journal")) as desk:
            verdict = desk.run(deaths)
        killed, held = killed + desk.killed, held + desk.held
        ends[verdict.outcome] += 1
        missed = verdict.outcome == "failed" and not verdict.unmet
        wrong += [f"{seed}: {each}" for each in (*verdict.faults, *(["it is so, and failed"] if missed else []))]
        print(f"{seed}: {verdict.outcome}; {dict(killed)}, {held} with a thing held; {wrong}", flush=True)  # noqa: T201
    print(dict(ends), dict(killed))  # noqa: T201
    assert wrong == []
