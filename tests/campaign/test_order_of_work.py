# SPDX-License-Identifier: Apache-2.0
"""A drawn campaign has one table, in whatever order its cells are worked on, by one worker or two, and with stops.

The oracle is one worker that does everything in the order of the plan, in one go.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import SceneTask, TaskRecord, Workplace, WorkSettings
from tests.campaign.choosing import OPTIONS, campaign_data, labels, write_campaign
from tests.campaign.test_run import cells_in, ran

pytestmark = pytest.mark.sim
MODELS = ("rules", "constant:wait", "constant:right", "oracle", "teller", "mute", "liar")
MOST_LIVES = 20


class DrawnPool:
    """Two workers, or one, that take the tasks in an order of their own; and that may be stopped after any cell.

    Args:
        rng: What happens.
        settings: The campaign's.
    """

    def __init__(self, rng: random.Random, settings: WorkSettings) -> None:
        self._rng, self._left = rng, rng.choice([1, 2, 5, 10**9])
        self._places = [Workplace(settings) for _ in range(rng.randint(1, 2))]

    def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
        waiting = self._rng.sample(given := list(tasks), len(given))
        busy: list[Iterator[TaskRecord] | None] = [None] * len(self._places)
        while self._left > 0 and (waiting or any(busy)):
            at = self._rng.randrange(len(busy))
            record = next(busy[at] or iter(()), None)
            if record is None:
                busy[at] = self._places[at].work(waiting.pop()) if waiting else None
            else:
                self._left -= 1
                yield record
        yield None

    def stop(self) -> None:
        self._left = 0
        for each in self._places:
            each.is_over.set()

    def close(self) -> None:
        for each in self._places:
            each.__exit__()


def drawn(rng: random.Random) -> dict[str, Any]:
    """A campaign of one to three scenes, whose scripts answer what is offered, what is not, and nothing."""
    scripts: dict[str, Any] = {
        "teller": {"even": rng.choice(OPTIONS), "*": rng.choice(OPTIONS)},
        "mute": {"*": None},
        "liar": {"*": {"option": "fly", "why": "I can"}},
    }
    models = rng.sample(MODELS, rng.randint(1, len(MODELS)))
    return campaign_data(
        rng.randint(1, 3),
        models=models,
        scripts={name: each for name, each in scripts.items() if name in models},
        arguments={"depth": rng.choice([2, 3, 7])},
        orders=rng.choice([["written"], ["written", "reversed"]]),
    )


def agree(seed: int, folder: Path) -> int:
    """Work on a drawn campaign in a drawn order until nothing is missing; gives how often it was begun."""
    rng = random.Random(seed)
    data = drawn(rng)
    path, is_labelled = write_campaign(folder, data), rng.random() < 0.5
    scenes = [each["scene"] for each in data["scenes"]["given"]]
    for name in ("serial.db", "drawn.db"):
        with ResultStore(folder / name, writes=True) as opened:
            opened.add(labels(scenes) if is_labelled else [])
    ran(path, folder / "serial.db")
    missing = (ran(path, folder / "drawn.db", partial(DrawnPool, rng)).missing for _ in range(MOST_LIVES))
    lives = next(number for number, left in enumerate(missing, start=1) if not left)
    assert cells_in(folder / "drawn.db") == cells_in(folder / "serial.db"), seed
    with ResultStore(folder / "drawn.db") as one, ResultStore(folder / "serial.db") as other:
        assert list(one.questions()) == list(other.questions()), seed
        assert sorted(one.scenes()) == sorted(other.scenes()), seed
    return lives


def test_a_campaign_has_one_table_in_whatever_order_it_is_worked_on(tmp_path: Path) -> None:
    assert agree(3, tmp_path)


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_many_campaigns_have_one_table_in_whatever_order_they_are_worked_on(tmp_path: Path) -> None:
    lives = 0
    for seed in range(300):
        folder = tmp_path / str(seed)
        folder.mkdir()
        lives += agree(seed, folder)
    assert lives > 400
