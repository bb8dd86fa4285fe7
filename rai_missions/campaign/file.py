# SPDX-License-Identifier: Apache-2.0
"""The campaign file: which mission is asked which questions, of whom, and how much that may cost.

Rule: a file names things; nothing in it is executed. Paths are read from the file's own folder.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from rai_missions.campaign.cells import ORDERS
from rai_missions.campaign.embodiments import EMBODIMENTS
from rai_missions.campaign.rollout import LONGEST_S
from rai_missions.campaign.scene_sources import ScenesEntry
from rai_missions.errors import suggestion
from rai_missions.mission.schema import schema_of
from rai_missions.model import LISTED, Format, Integer, Json, MissionModel, Name, Number, Text, fault, refuse
from rai_missions.redaction import shown

__all__ = (
    "BASE", "BudgetEntry", "CampaignFile", "PriceEntry", "RateEntry", "RolloutEntry", "campaign_schema", "with_models",
)  # fmt: skip

CONSTANT, OWN = "constant:", ("rules", "oracle")
"""What begins the name of an answerer that always gives one answer; the other answerers that are no model."""
ANY_KIND = "*"
ABOUT_MODELS = ("prices", "scripts")
"""Fields with an entry a model."""
BASE = "base"
"""The word by which a campaign names another, whose fields it takes unless it has them itself."""


Names = Annotated[tuple[Text, ...], Field(min_length=1), LISTED]
Orders = Annotated[tuple[Literal[ORDERS], ...], Field(min_length=1), LISTED]  # type: ignore[valid-type]
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

    format: Format = 1
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

    @field_validator("models", "embodiments", "orders")
    @classmethod
    def _names_each_once(cls, names: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        refuse(_list_faults(str(info.field_name), names))
        return names

    @field_validator(*ABOUT_MODELS, "rates")
    @classmethod
    def _is_about_its_models(cls, table: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        refuse(_table_faults(str(info.field_name), table, info.data.get("models")))
        return table

    @field_validator("budget")
    @classmethod
    def _knows_all_prices(cls, budget: BudgetEntry, info: ValidationInfo) -> BudgetEntry:
        if budget.money is not None and {"models", "scripts", "prices"} <= info.data.keys():
            refuse(_price_faults(info.data["models"], info.data["scripts"], info.data["prices"]))
        return budget

    def replaced(self, models: Iterable[str]) -> CampaignFile:
        """This campaign with other models."""
        return CampaignFile.model_validate(with_models(self.written(), list(models)))


def campaign_schema() -> dict[str, Any]:
    """The JSON Schema of a campaign file; what one needs, one over a base may leave to it."""
    schema = schema_of(CampaignFile, "A campaign of rai_missions")
    about = "Another campaign's file: its fields are this one's, unless they are here. It has no base of its own."
    words = {"$schema": {"type": "string"}, BASE: {"type": "string", "minLength": 1, "description": about}}
    needed = {"required": schema.pop("required")}
    return {**schema, "properties": {**words, **schema["properties"]}, "anyOf": [{"required": [BASE]}, needed]}


def with_models(data: Mapping[str, Any], models: list[Any]) -> dict[str, Any]:
    """A campaign's fields with other models, and with what is about these alone."""
    providers = {str(each).partition(":")[0] for each in models}
    known = {**dict.fromkeys(ABOUT_MODELS, models), "rates": providers}
    only = {
        word: {name: each for name, each in data[word].items() if name in names}
        for word, names in known.items()
        if isinstance(data.get(word), Mapping)
    }
    return {**data, **only, "models": models}


def _list_faults(field: str, names: tuple[str, ...]) -> Iterator[PydanticCustomError]:
    for name, times in Counter(names).items():
        if field == "embodiments" and name not in EMBODIMENTS:
            why = f"no embodiment {shown(name)}{suggestion(name, EMBODIMENTS)}"
            yield fault("embodiment", why, at=(names.index(name),))
        if times > 1:
            yield fault(field, f"'{field}' names {shown(name)} more than once; keep one")


def _table_faults(field: str, table: Iterable[str], models: Iterable[str] | None) -> Iterator[PydanticCustomError]:
    """What a table of models, or of their providers, is about and 'models' has not; nothing where that is at fault."""
    is_rates = field == "rates"
    known = {name.partition(":")[0] if is_rates else name: None for name in models or ()}
    lacks = "of which 'models' has none" if is_rates else "which 'models' has not"
    for unknown in (name for name in table if models is not None and name not in known):
        yield fault(field, f"'{field}' is about {shown(unknown)}, {lacks}{suggestion(unknown, known)}", at=(unknown,))


def _price_faults(
    models: Iterable[str], scripts: Collection[str], prices: Collection[str]
) -> Iterator[PydanticCustomError]:
    """The models of a provider, but for those on this machine, that have no price."""
    for name in models:
        if ":" in name and name not in scripts and name not in prices and not name.startswith((CONSTANT, "local:")):
            yield fault(
                "prices",
                f"'budget' bounds money, and 'prices' has no price of {shown(name)}, which would count as free; "
                "add it, or {} where it costs nothing",
                at=("money",),
            )
