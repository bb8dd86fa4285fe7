# SPDX-License-Identifier: Apache-2.0
"""Where the scenes of a campaign come from: written in its file, seeds of a world, or drawn by the generator."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.campaign.records import SceneRecord, Split
from rai_missions.campaign.scene_spec import scene_spec
from rai_missions.model import LISTED, Integer, Json, MissionModel, Name, Text, fault, refuse

__all__ = ("GivenScene", "ScenesEntry")

MOST = 100_000
"""The largest number of scenes: their plan is held in memory."""


class GivenScene(MissionModel):
    """A scene as it is written in a campaign file."""

    scene: Text
    kind: Text
    """What it shows, for tables: of scenes of one kind a confusion is reported together."""
    seed: Integer
    split: Split = "report"
    options: dict[Text, Json] = Field(default_factory=dict)
    """What the world is built from, over the options of all scenes."""
    later: dict[Name, dict[Name, Name]] = Field(default_factory=dict)
    """Who answers later questions of a rollout in this scene, over `rollouts.later`."""


class ScenesEntry(MissionModel):
    """The scenes of a campaign: exactly one of `given`, `seeds` and `count`."""

    world: Text = "orchard"
    given: Annotated[tuple[GivenScene, ...], LISTED] = ()
    seeds: Annotated[tuple[Integer, ...], LISTED] = ()
    """A scene each: the world that the seed alone decides."""
    count: Annotated[Integer, Field(gt=0, le=MOST)] | None = None
    """How many scenes the generator (`campaign.scenes`) makes, no two alike."""
    first_seed: Annotated[Integer, Field(ge=0)] = 0
    """Where the generator begins."""
    split: Split | None = None
    """Of the scenes by `seeds`, `report` if it is left out; of the generator's, those of this split alone."""
    options: dict[Text, Json] = Field(default_factory=dict)
    """What every scene's world is built from."""

    @model_validator(mode="after")
    def _is_one_source(self) -> ScenesEntry:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[PydanticCustomError]:
        if bool(self.given) + bool(self.seeds) + (self.count is not None) != 1:
            sentence = (
                "scenes are written under 'given', named by 'seeds' or drawn by 'count': give exactly one of them"
            )
            yield fault("scenes", sentence)
        if self.count is not None and self.options:
            yield fault(
                "options", "the generator draws each scene's options; drop 'options' or drop 'count'", at=("options",)
            )
        for name, times in Counter(each.scene for each in self._written()).items():
            if times > 1:
                yield fault("scenes", f"the scene '{name}' is there more than once; give each a name of its own")

    def scenes(self) -> Iterator[SceneRecord]:
        """The scenes, in the order written or drawn.

        Raises:
            UsageError: No scenes are generated for this world.
        """
        return self._written() if self.count is None else iter(_drawn(self, self.count))

    def _written(self) -> Iterator[SceneRecord]:
        for each in self.given:
            options = {**self.options, **each.options}
            yield self._made(each.scene, each.kind, each.seed, each.split, options, each.later)
        for seed in self.seeds:
            yield self._made(f"{self.world}_{seed}", self.world, seed, self.split or "report", self.options)

    def _made(
        self, scene: str, kind: str, seed: int, split: Split, options: Any, later: Mapping[str, Any] | None = None
    ) -> SceneRecord:
        return SceneRecord(scene, self.world, kind, seed, split, scene_spec(self.world, options, later or {}))


def _drawn(entry: ScenesEntry, count: int) -> list[SceneRecord]:
    """The first scenes of the generator that are of the split that is wanted."""
    from rai_missions.campaign.scenes import scenes  # loads the world

    found: list[SceneRecord] = []
    drawn = count
    while len(found) < count:
        found = [each for each in scenes(entry.world, drawn, entry.first_seed) if entry.split in (None, each.split)]
        drawn *= 2
    return found[:count]
