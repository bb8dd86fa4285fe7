# SPDX-License-Identifier: Apache-2.0
"""The campaign file: which mission is asked which questions, of whom, and how much that may cost.

Rule: a file names things; nothing in it is executed. Paths are read from the file's own folder.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from rai_missions.campaign.cells import ORDERS, digest
from rai_missions.campaign.embodiments import EMBODIMENTS
from rai_missions.campaign.questions import CampaignSubject
from rai_missions.campaign.rollout import LONGEST_S
from rai_missions.campaign.scene_sources import ScenesEntry
from rai_missions.check import check
from rai_missions.check import faults_of as mission_faults
from rai_missions.errors import DefinitionError, Fault, pointer, suggestion
from rai_missions.mission.file_kinds import mistaken
from rai_missions.mission.json_reader import read_json
from rai_missions.mission.schema import schema_of
from rai_missions.model import Integer, Json, MissionModel, Name, Number, Text, fault
from rai_missions.redaction import shown
from rai_missions.validation_errors import faults_of

__all__ = (
    "BudgetEntry", "CampaignFile", "LoadedCampaign", "PriceEntry", "RateEntry", "RolloutEntry", "campaign_schema",
    "load_campaign",
)  # fmt: skip

CONSTANT, OWN = "constant:", ("rules", "oracle")
"""What begins the name of an answerer that always gives one answer; the other answerers that are no model."""
ANY_KIND = "*"


def _listed(given: Any) -> Any:
    return tuple(given) if isinstance(given, list) else given


Names = Annotated[tuple[Text, ...], Field(min_length=1), BeforeValidator(_listed)]
Orders = Annotated[tuple[Literal[ORDERS], ...], Field(min_length=1), BeforeValidator(_listed)]  # type: ignore[valid-type]
Above0 = Annotated[Number, Field(gt=0)]


class PriceEntry(MissionModel):
    """What a model's tokens cost, in the currency of the campaign, for a million of them."""

    prompt: Annotated[Number, Field(ge=0)] = 0
    completion: Annotated[Number, Field(ge=0)] = 0


class RateEntry(MissionModel):
    """How fast a provider may be asked, by all workers together."""

    calls_per_minute: Above0 | None = None
    tokens_per_minute: Above0 | None = None
    """In and out together."""


class BudgetEntry(MissionModel):
    """How much a campaign may use, runs before this one included but for the time; left out, without bound."""

    calls: Annotated[Integer, Field(gt=0)] | None = None
    tokens: Annotated[Integer, Field(gt=0)] | None = None
    """In and out together."""
    money: Above0 | None = None
    """In the currency of the prices."""
    seconds: Above0 | None = None
    """Wall time of this run."""


class RolloutEntry(MissionModel):
    """How `"labels": "rollouts"` tries an option."""

    longest_s: Above0 = LONGEST_S
    """Simulated seconds of each."""
    parameters: dict[Name, dict[Text, Json]] = Field(default_factory=dict)
    """Option → the parameters with which it is tried; an answer with others has no label."""
    later: dict[Name, dict[Name, Name]] = Field(default_factory=dict)
    """Who answers later questions of a rollout, by the names in `ask`: the state that asks → the option. Left out, a
    rollout ends where someone is asked again."""


class CampaignFile(MissionModel):
    """A campaign: scenes × models × embodiments × orders of options, over one decision of one mission."""

    format: Literal[1] = 1
    name: Name
    about: Text = ""
    mission: Text
    """The mission's JSON file."""
    robot: Text
    """The robot profile's JSON file; its connector is replaced by each scene's world."""
    decision: Name
    """The state whose question is asked."""
    arguments: dict[Name, Json] = Field(default_factory=dict)
    """The mission's arguments."""
    scenes: ScenesEntry
    labels: Literal["trials", "rollouts", "none"] = "none"
    """Where a scene's labels come from, unless the store has them. `trials` has physics alone try each option, whatever
    the mission's guards; `rollouts` has the mission try it on a branch of the world, until it ends, harm is done or
    someone is asked again."""
    rollouts: RolloutEntry = RolloutEntry()
    models: Names
    """`rules`, `oracle`, `constant:OPTION`, a name in `scripts`, `PROVIDER:NAME`, `local` or `local:FILE.gguf`."""
    embodiments: Names = ("none",)
    orders: Orders = ("written",)
    """Orders in which the options are shown."""
    scripts: dict[Text, dict[Text, Json]] = Field(default_factory=dict)
    """Name → kind of scene, or `*` for any → the answer: an option, or an answer with `option`, `why`, `failed`."""
    prices: dict[Text, PriceEntry] = Field(default_factory=dict)
    """Model → what it costs."""
    currency: Text = "USD"
    rates: dict[Text, RateEntry] = Field(default_factory=dict)
    """Provider, the part of a model's name before the colon → how fast it may be asked."""
    retries: Annotated[Integer, Field(ge=0, le=10)] = 2
    """How often a question is put again to a model that could not be asked; after 1, 2, 4 … seconds."""
    answer_s: Above0 | None = None
    """Seconds for an answer; left out, the mission's own time for its first answerer."""
    budget: BudgetEntry = BudgetEntry()

    @model_validator(mode="after")
    def _names_what_there_is(self) -> CampaignFile:
        for name in self.embodiments:
            if name not in EMBODIMENTS:
                raise fault("embodiment", f"no embodiment {shown(name)}{suggestion(name, EMBODIMENTS)}")
        for field in ("models", "embodiments", "orders"):
            if twice := _repeated(getattr(self, field)):
                raise fault(field, f"'{field}' names {shown(twice)} more than once; keep one")
        for word, table in (("prices", self.prices), ("scripts", self.scripts)):
            if unknown := next((name for name in table if name not in self.models), None):
                raise fault(
                    word,
                    f"'{word}' is about {shown(unknown)}, which 'models' has not{suggestion(unknown, self.models)}",
                )
        return self

    def replaced(self, models: Iterable[str]) -> CampaignFile:
        """The same campaign with other models."""
        kept = tuple(models)
        only = {
            word: {name: each for name, each in self.written().get(word, {}).items() if name in kept}
            for word in ("prices", "scripts")
        }
        return CampaignFile.model_validate({**self.written(), **only, "models": list(kept)})


class LoadedCampaign(NamedTuple):
    """A campaign file with what it names."""

    file: CampaignFile
    folder: Path
    """The file's own."""
    subject: CampaignSubject

    @property
    def digest(self) -> str:
        """Of what the answers depend on beyond scene, model, embodiment and code: mission, profile and arguments."""
        mission, robot = self.subject.mission.written(), self.subject.robot.written()
        return digest({
            "mission": mission, "robot": robot, "arguments": dict(self.file.arguments), "answer_s": self.file.answer_s,
            "rollouts": self.file.rollouts.written(),
        })  # fmt: skip


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
    data = read_json(source)
    if not isinstance(data, Mapping):
        raise DefinitionError([Fault("", f"a campaign is a JSON object, not {shown(data)}")], str(source))
    if found := tuple(mistaken(data, "campaign")):
        raise DefinitionError(found, str(source))
    try:
        file = CampaignFile.model_validate({key: item for key, item in data.items() if key != "$schema"})
        file = file.replaced(models) if (models := tuple(models)) else file
    except ValidationError as error:
        raise DefinitionError(faults_of(error, CampaignFile, data), str(source)) from None
    folder = source.resolve().parent
    subject = CampaignSubject.read(folder / file.mission, folder / file.robot, file.decision, file.arguments)
    if found := tuple(mission_faults(check(subject.mission))):
        raise DefinitionError(found, file.mission)
    if found := tuple(_faults(file, subject)):
        raise DefinitionError(found, str(source))
    return LoadedCampaign(file, folder, subject)


def campaign_schema() -> dict[str, Any]:
    """The JSON Schema of a campaign file."""
    schema = schema_of(CampaignFile, "A campaign of rai_missions")
    return {**schema, "properties": {"$schema": {"type": "string"}, **schema["properties"]}}


def _faults(file: CampaignFile, subject: CampaignSubject) -> Iterator[Fault]:
    """What only mission and profile show."""
    states = [name for _, name, _ in subject.mission.walk()]
    if not subject.asked:
        known = suggestion(file.decision, states) if file.decision not in states else "; name a decision"
        yield Fault("/decision", f"'{file.decision}' is no decision of the mission{known}")
        return
    for at, model in enumerate(file.models):
        if why := _unfit(model, file, subject):
            yield Fault(pointer(("models", at)), why)
    for tried in file.rollouts.parameters:
        if tried not in subject.options:
            yield Fault(
                pointer(("rollouts", "parameters", tried)), f"no option '{tried}'{suggestion(tried, subject.options)}"
            )
    for name, script in file.scripts.items():
        for kind, line in script.items():
            option = line.get("option") if isinstance(line, Mapping) else line
            if not isinstance(option, str | None):
                yield Fault(
                    pointer(("scripts", name, kind)), f"an answer is an option's name or an object, not {shown(line)}"
                )


def _unfit(model: str, file: CampaignFile, subject: CampaignSubject) -> str:
    """Why a model cannot be asked, as far as its name shows; empty where it may."""
    if model in OWN or model in file.scripts or model == "local":
        return ""
    if model.startswith(CONSTANT):
        option = model.removeprefix(CONSTANT)
        return "" if option in subject.options else f"no option '{option}'{suggestion(option, subject.options)}"
    provider, _, name = model.partition(":")
    if provider and name:
        return ""
    near = suggestion(model, (*OWN, *file.scripts))
    return f"'{model}' names no model: rules, oracle, constant:OPTION, local, a script, or PROVIDER:NAME{near}"


def _repeated(names: Iterable[str]) -> str:
    seen = set[str]()
    return next((name for name in names if name in seen or seen.add(name)), "")  # type: ignore[func-returns-value]
