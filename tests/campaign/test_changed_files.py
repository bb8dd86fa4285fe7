# SPDX-License-Identifier: Apache-2.0
"""A store whose campaign was changed and killed again and again holds what a new store gets from the file as it is."""

from __future__ import annotations

import copy
import random
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.campaign.load import load_campaign
from rai_missions.campaign.run import CampaignPlan, plan_of
from rai_missions.campaign.store import ResultStore
from rai_missions.campaign.tasks import SceneTask, TaskRecord, WorkSettings
from tests.campaign.choosing import campaign_data, table, write_campaign
from tests.campaign.test_run import SerialPool, ran

pytestmark = pytest.mark.sim

Json = dict[str, Any]
MODELS = ("rules", "oracle", "constant:wait", "constant:left", "constant:right", "teller")
ANSWERS: tuple[Any, ...] = ("left", "right", "wait", "fly", None, {"failed": "out of reach"})


class Killed(BaseException):
    """What ends a campaign in the midst of its work."""


def changed(rng: random.Random, data: Json) -> Json:
    """The content of a campaign's file with one thing changed, of the same mission and profile."""
    data = copy.deepcopy(data)
    scenes: list[Json] = data["scenes"]["given"]
    scene = rng.choice(scenes)
    what = rng.choice(["seed", "kind", "name", "add", "drop", "order", "world", "models", "script", "orders", "labels"])
    if what == "seed":
        scene["seed"] = rng.randint(0, 9)
    elif what == "kind":
        scene["kind"] = rng.choice(["even", "odd", "other"])
    elif what == "name":
        scene["scene"] = f"n{rng.randint(0, 99)}"
    elif what == "add":
        scenes.insert(0, {"scene": f"n{rng.randint(0, 99)}", "kind": "odd", "seed": rng.randint(0, 9)})
    elif what == "drop" and len(scenes) > 1:
        scenes.remove(scene)
    elif what == "order":
        rng.shuffle(scenes)
    elif what == "world":
        data["scenes"]["options"] |= {"length_m": rng.choice([12.0, 14.0])}
    elif what == "models":
        data["models"] = rng.sample(MODELS, rng.randint(1, 4))
    elif what == "script":
        data["scripts"] = {"teller": {scene["kind"]: rng.choice(ANSWERS), "*": rng.choice(ANSWERS)}}
    elif what == "orders":
        data["orders"] = rng.sample(["written", "reversed"], rng.randint(1, 2))
    elif what == "labels":
        data["labels"] = "rollouts"  # once there are labels in a store, they count with "none", too
    return fitting(data) if len({each["scene"] for each in scenes}) == len(scenes) else changed(rng, data)


def fitting(data: Json) -> Json:
    """The file with a script for whom it asks, and none that no scene has a use for."""
    kinds = {"*", *(each["kind"] for each in data["scenes"]["given"])}
    script = data["scripts"].get("teller", {"*": "right"})
    known = {kind: answer for kind, answer in script.items() if kind in kinds}
    return data | {"scripts": {"teller": known} if "teller" in data["models"] else {}}


def ran_until(path: Path, store: Path, most: int) -> None:
    """Run a campaign that is killed once so many records have come."""

    class Mortal(SerialPool):
        def __init__(self, settings: WorkSettings) -> None:
            super().__init__(settings)
            self._left = most

        def results(self, tasks: Iterable[SceneTask]) -> Iterator[TaskRecord | None]:
            for record in super().results(tasks):
                if not self._left:
                    raise Killed
                self._left -= 1
                yield record

    try:
        ran(path, store, Mortal)
    except Killed:
        return


def content(store: Path, plan: CampaignPlan) -> list[Any]:
    """What a store has of a plan; answers of earlier files to other questions are left out."""
    names = {each.scene for each in plan.scenes}
    asked = {(each.scene, each.model, each.embodiment, each.option_order) for each in plan.cells.values()}
    with ResultStore(store) as opened:
        found = [each for each in opened.cells() if each.scene in names]
        cells = table(each for each in found if (each.scene, each.model, each.embodiment, each.option_order) in asked)
        scenes = [each for each in opened.scenes() if each.scene in names]
        labels = {name: each for name, each in opened.labels().items() if name in names}
    return [sorted(cells, key=lambda each: each.cell), sorted(scenes), labels]


def agree(seed: int, folder: Path) -> None:
    rng = random.Random(seed)
    data = campaign_data(rng.randint(1, 3), labels=rng.choice(["none", "rollouts"]))
    for _ in range(rng.randint(2, 4)):
        path = write_campaign(folder, data)
        ran_until(path, folder / "store.db", rng.choice([10**6, rng.randint(0, 15)]))
        for _ in range(rng.randint(0, 2)):
            data = changed(rng, data)
    path = write_campaign(folder, data)
    for store in ("store.db", "new.db"):
        ran(path, folder / store)
    plan = plan_of(load_campaign(path))
    kept, new = (content(folder / each, plan) for each in ("store.db", "new.db"))
    assert kept == new, seed


def test_a_store_of_changed_and_killed_campaigns_holds_what_a_new_one_gets(tmp_path: Path) -> None:
    for seed in (2, 5):
        (folder := tmp_path / str(seed)).mkdir()
        agree(seed, folder)


@pytest.mark.drill
@pytest.mark.timeout(3600)
def test_many_stores_of_changed_and_killed_campaigns_hold_what_a_new_one_gets(tmp_path: Path) -> None:
    for seed in range(400):
        (folder := tmp_path / str(seed)).mkdir()
        agree(seed, folder)
