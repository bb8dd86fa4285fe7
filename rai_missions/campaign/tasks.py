# SPDX-License-Identifier: Apache-2.0
"""The work of a campaign, a scene at a time: its question, and the cells that are asked in it.

Rule: what a task yields depends on the task and the campaign alone, whichever pool has it done.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from rai_missions.campaign.asking import CellAsker, question_record
from rai_missions.campaign.budget import CallPace
from rai_missions.campaign.cells import Cell
from rai_missions.campaign.embodiments import embodied
from rai_missions.campaign.load import load_campaign
from rai_missions.campaign.models import CampaignModels
from rai_missions.campaign.questions import AskedScene, NoQuestion, ask_in
from rai_missions.campaign.records import (
    CellRecord,
    LabelRecord,
    PictureRecord,
    QuestionRecord,
    SceneRecord,
    UnlabelledScene,
)
from rai_missions.campaign.rollout import ROLLOUT_NEEDS, answers_of, rollouts
from rai_missions.campaign.scene_spec import later_of
from rai_missions.campaign.store import ResultStore
from rai_missions.errors import MissionError, UsageError, raised_text
from rai_missions.redaction import cut, first_line, redacted
from rai_missions.worlds.world import load_world

__all__ = ("SceneTask", "TaskRecord", "WorkSettings", "Workplace")

TaskRecord = QuestionRecord | PictureRecord | LabelRecord | UnlabelledScene | CellRecord
SMALL = 9
"""zlib's level for pictures in the store: each is written once."""


class SceneTask(NamedTuple):
    """What is to be asked in one scene."""

    scene: SceneRecord
    cells: tuple[tuple[str, Cell], ...]
    """Key and cell."""
    labels: Mapping[str, str]
    """Option → verdict of physics."""
    shows: bool = True
    """Whether its questions and pictures are wanted, too."""
    rates: bool = False
    """Whether its labels are wanted, too."""

    def without(self, keys: set[str]) -> SceneTask:
        """This task without the cells that are done."""
        return self._replace(cells=tuple(each for each in self.cells if each[0] not in keys))


class WorkSettings(NamedTuple):
    """What every worker of a campaign knows."""

    campaign: str
    """The campaign's file."""
    models: tuple[str, ...] = ()
    """Instead of those of the file, if there are any."""
    workers: int = 1
    """How many share the rates of the providers."""
    recorded: str = ""
    """A store whose answers are used instead of asking; empty: models are asked."""


class Workplace:
    """One worker's campaign: its mission and its open models; a context manager.

    Args:
        settings: What every worker knows.
        is_over: Set from another thread when no further call may be begun.

    Raises:
        DefinitionError: The campaign's file is at fault.
        UsageError: Something named is not there, or does not load, as the scenes' world may.
    """

    def __init__(self, settings: WorkSettings, is_over: threading.Event | None = None) -> None:
        loaded = load_campaign(settings.campaign, models=settings.models)
        file, subject = loaded.file, loaded.subject
        load_world(file.scenes.world)
        self._subject, self.is_over = subject, is_over or threading.Event()
        self._closing = ExitStack()
        models = self._closing.enter_context(CampaignModels(file, subject.robot, subject.mission.blackboard))
        bodies = {name: embodied(name, subject.identity, subject.text) for name in file.embodiments}
        paces = {name: CallPace(rate, settings.workers) for name, rate in file.rates.items()}
        recorded = _recorded(Path(settings.recorded)).get if settings.recorded else None
        self._asker = CellAsker(file, models, paces, bodies, self.is_over, recorded)

    def __enter__(self) -> Workplace:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()

    def work(self, task: SceneTask) -> Iterator[TaskRecord]:
        """Ask what a task wants, and yield each record as soon as there is it."""
        if self.is_over.is_set() or not (task.cells or task.rates):
            return
        labels = dict(task.labels)
        if task.rates and self._asker.file.labels == "trials":
            tried = _tried(task.scene)
            labels.update({each.option: each.verdict for each in tried if isinstance(each, LabelRecord)})
            yield from tried
        if task.cells or self._asker.file.labels == "rollouts":
            yield from self._in_scene(task, labels)

    def _in_scene(self, task: SceneTask, labels: dict[str, str]) -> Iterator[TaskRecord]:
        """The question of a scene, and its answers."""
        try:
            asked = ask_in(task.scene, self._subject)
        except NoQuestion as none:
            yield from _failed(task, str(none))
            return
        except Exception as error:  # noqa: BLE001 - one scene that cannot be built ends no campaign
            what = str(error) if isinstance(error, MissionError) else first_line(raised_text(error))
            yield from _failed(task, f"the scene cannot be run: {what}")
            return
        if task.shows:
            yield from self._shown(asked, task)
        for label in self._rolled_out(asked) if task.rates else ():
            if isinstance(label, LabelRecord):
                labels[label.option] = label.verdict
            yield label
        if asked.decision is not None:
            asked.decision.world.close()
        for key, cell in task.cells:
            record = self._asker.ask(key, cell, asked, labels)
            if record is None:
                return
            yield record

    def _rolled_out(self, asked: AskedScene) -> Iterator[LabelRecord | UnlabelledScene]:
        """The labels of a scene's options, where the campaign wants them; why they lack where one cannot be tried."""
        if self._asker.file.labels != "rollouts":
            return
        if asked.decision is None:
            why = f"nothing is rolled out in the world '{asked.scene.world}': that needs {ROLLOUT_NEEDS}"
            yield UnlabelledScene(asked.scene.scene, why)
            return
        wanted = self._asker.file.rollouts
        later = {**wanted.later, **later_of(asked.scene.spec)}
        try:
            found = rollouts(
                asked.decision,
                self._subject.options,
                later=answers_of(later, self._subject.mission),
                parameters=wanted.parameters,
                longest_s=wanted.longest_s,
            )
        except UsageError as error:  # an option cannot be tried here, so none has a label
            yield UnlabelledScene(asked.scene.scene, str(error))
            return
        for option, each in found.items():
            details = redacted(json.dumps(each.data(), default=str))
            yield LabelRecord(asked.scene.scene, option, each.verdict, details)

    def _shown(self, asked: AskedScene, task: SceneTask) -> Iterator[TaskRecord]:
        for name, body in self._asker.bodies.items():
            yield question_record(asked, name, body)
        for name, image in asked.pictures.items():
            file = image.file(level=SMALL)
            if file.kind == "png":
                yield PictureRecord(task.scene.scene, name, file.data)


def _tried(scene: SceneRecord) -> list[LabelRecord] | list[UnlabelledScene]:
    """The labels that physics alone gives, without the mission; why there is none where nothing asks for a decision."""
    from rai_missions.campaign.labels import label  # loads the world

    try:
        found = label(scene)
    except UsageError as error:
        return [UnlabelledScene(scene.scene, str(error))]
    return [
        LabelRecord(scene.scene, option, each.verdict, json.dumps(each.details, default=str))
        for option, each in found.items()
    ]


def _failed(task: SceneTask, error: str) -> Iterator[CellRecord | UnlabelledScene]:
    for key, cell in task.cells:
        yield CellRecord(key, *cell, status="failed", error=cut(error, 1000))
    if task.rates:
        yield UnlabelledScene(task.scene.scene, cut(error, 1000))


def _recorded(path: Path) -> Mapping[Cell, CellRecord]:
    """The cells of a store that were answered."""
    with ResultStore(path) as store:
        return {Cell(*each[1:7]): each for each in store.cells() if each.status != "failed" and each.raw}
