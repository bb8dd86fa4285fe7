# SPDX-License-Identifier: Apache-2.0
"""Reads a campaign file with all that it names: its base, its scenes' files, its mission and its profile.

Rule: a campaign that is loaded has no fault that a check finds before a world is built.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from rai_missions.campaign.cells import digest
from rai_missions.campaign.checks import faults_in
from rai_missions.campaign.file import BASE, CampaignFile, with_models
from rai_missions.campaign.questions import CampaignSubject
from rai_missions.check import check
from rai_missions.check import faults_of as mission_faults
from rai_missions.errors import DefinitionError, Fault, pointer
from rai_missions.mission.file_kinds import object_of
from rai_missions.mission.json_reader import read_json
from rai_missions.model.validation_errors import faults_of
from rai_missions.redaction import shown
from rai_missions.worlds.scene_files import with_scene_read

__all__ = ("LoadedCampaign", "load_campaign")


class LoadedCampaign(NamedTuple):
    """A campaign file with what it names."""

    file: CampaignFile
    folder: Path
    """The file's own."""
    subject: CampaignSubject

    @property
    def digest(self) -> str:
        """The digest of what else answers depend on: mission, profile and arguments."""
        mission, robot = self.subject.mission.written(), self.subject.robot.written()
        return digest(
            {
                "mission": mission,
                "robot": robot,
                "arguments": dict(self.file.arguments),
                "answer_s": self.file.answer_s,
                "rollouts": self.file.rollouts.written(),
            }
        )


def load_campaign(path: str | os.PathLike[str], *, models: Iterable[str] = ()) -> LoadedCampaign:
    """The campaign in a JSON file, and the mission and profile that it names.

    Args:
        path: The file.
        models: Instead of those of the file, if there are any.

    Raises:
        DefinitionError: The file, or one that it names, is at fault; every fault of a file at once.
        UsageError: A file is not there.
    """
    source = Path(path)
    data = _over_its_base(_read(source), source)
    try:
        file = CampaignFile.model_validate(data)
        file = file.replaced(models) if (models := tuple(models)) else file
    except ValidationError as error:
        raise DefinitionError(faults_of(error, CampaignFile, data), str(source)) from None
    folder = source.resolve().parent
    subject = CampaignSubject.read(
        folder / file.mission, folder / file.robot, file.decision, file.arguments, source=str(source)
    )
    if found := tuple(mission_faults(check(subject.mission))):
        raise DefinitionError(found, file.mission)
    if found := tuple(faults_in(file, subject)):
        raise DefinitionError(found, str(source))
    return LoadedCampaign(file, folder, subject)


def _read(source: Path) -> dict[str, Any]:
    """A campaign file's content, which is an object.

    Raises:
        DefinitionError: It is none.
        UsageError: It is not there.
    """
    data = object_of("campaign", read_json(source), str(source))
    return _with_scene_files({key: item for key, item in data.items() if key != "$schema"}, source.parent)


def _with_scene_files(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The fields of a campaign with the content of the files that its scenes name, so that a scene is its data.

    Raises:
        UsageError: A file is not there, or is no JSON.
    """
    scenes = data.get("scenes")
    if not isinstance(scenes, Mapping):
        return data
    given = scenes.get("given")
    written = (
        {**scenes, "given": [_with_scene_file(each, folder) for each in given]} if isinstance(given, list) else scenes
    )
    return {**data, "scenes": _with_scene_file(written, folder)}


def _with_scene_file(entry: Any, folder: Path) -> Any:
    options = entry.get("options") if isinstance(entry, Mapping) else None
    return {**entry, "options": with_scene_read(options, folder)} if isinstance(options, Mapping) else entry


def _over_its_base(data: dict[str, Any], source: Path) -> dict[str, Any]:
    """The fields of a campaign with those of its base that it has not itself.

    Raises:
        DefinitionError: Its base is no campaign's file, or has a base, too.
        UsageError: Its base is not there.
    """
    base = data.pop(BASE, "")
    if not isinstance(base, str):
        raise DefinitionError([Fault(pointer((BASE,)), f"a base is a file's name, not {shown(base)}")], str(source))
    if not base:
        return data
    below = _read(source.parent / base)
    if BASE in below:
        sentence = f"the base {shown(base)} has a base, too; name {shown(below[BASE])}, or write out what differs"
        raise DefinitionError([Fault(pointer((BASE,)), sentence)], str(source))
    for word in ("mission", "robot"):
        if isinstance(path := below.get(word), str):
            below[word] = os.path.join(os.path.dirname(base), path)
    models = data.get("models")
    return {**(with_models(below, models) if isinstance(models, list) else below), **data}
