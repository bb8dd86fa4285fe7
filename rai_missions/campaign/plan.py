# SPDX-License-Identifier: Apache-2.0
"""What a campaign consists of: scenes, cells and the labels that there are; and what of it is left to do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rai_missions.campaign.cells import Cell, cells_of, code_digest, digest
from rai_missions.campaign.embodiments import embodiment_digest
from rai_missions.campaign.load import LoadedCampaign
from rai_missions.campaign.models import model_digest
from rai_missions.campaign.records import SceneRecord
from rai_missions.campaign.tasks import SceneTask

__all__ = ("CampaignPlan", "plan_of")


class CampaignPlan(NamedTuple):
    """What a campaign consists of."""

    scenes: tuple[SceneRecord, ...]
    cells: Mapping[str, Cell]
    """Key → cell, in the order in which they are asked."""
    labels: Mapping[str, Mapping[str, str]]
    """Scene → option → verdict of physics."""
    code: str
    """Digest of the code by which it is asked."""
    embodiments: Mapping[str, str]
    """Name → digest of the files that it shows."""

    def tasks(self, done: set[str], shown: set[tuple[str, str]], *, rates: bool = False) -> Iterator[SceneTask]:
        """What is left to do, a scene at a time.

        Args:
            done: Keys of cells that have their record.
            shown: Scene and embodiment of the questions that are stored.
            rates: Labels are wanted, where there are none.
        """
        left: dict[str, list[tuple[str, Cell]]] = {}
        for key, cell in self.cells.items():
            if key not in done:
                left.setdefault(cell.scene, []).append((key, cell))
        for scene in self.scenes:
            cells, labels = left.get(scene.scene, []), self.labels.get(scene.scene, {})
            shows = any((scene.scene, cell.embodiment) not in shown for _, cell in cells)
            if cells or (rates and not labels):
                yield SceneTask(scene, tuple(cells), labels, shows, rates and not labels)

    def label_tasks(self) -> Iterator[SceneTask]:
        """The scenes that have no labels yet, without their cells."""
        for scene in self.scenes:
            if not self.labels.get(scene.scene):
                yield SceneTask(scene, (), {}, shows=False, rates=True)


def plan_of(loaded: LoadedCampaign) -> CampaignPlan:
    """Every cell of a campaign under its key; no scene has labels yet."""
    file, robot = loaded.file, loaded.subject.robot
    scenes = tuple(file.scenes.scenes())
    digests = {each.scene: digest([each.world, each.spec, each.seed]) for each in scenes}
    kinds = {each.scene: each.kind for each in scenes}
    code = code_digest()
    common = {"mission": loaded.digest, "code": code}
    models = {model: model_digest(model, file, robot) for model in file.models}
    bodies = {name: embodiment_digest(name, loaded.subject.identity) for name in file.embodiments}
    cells: dict[str, Cell] = {}
    names = [(each.scene, each.seed) for each in scenes]
    for cell in cells_of(loaded.subject.mission.name, names, file.models, file.embodiments, file.orders):
        inputs = {**common, "scene": digests[cell.scene], "model": models[cell.model]}
        inputs["embodiment"] = bodies[cell.embodiment]
        if cell.model in file.scripts:
            inputs["kind"] = kinds[cell.scene]  # by which a script answers
        cells[cell.key(inputs)] = cell
    return CampaignPlan(scenes, cells, {}, code, bodies)
