# SPDX-License-Identifier: Apache-2.0
"""Two stores of campaigns: what is better in the first beyond chance, what is noise, and what cannot be compared.

Rule: only cells of the same scene, built from the same data and labelled alike, are a pair.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rai_missions.campaign.report.comparisons import LEVEL, Comparison, Pairing, compared, matched
from rai_missions.campaign.report.figures import CampaignFigures, GroupName, figures_of
from rai_missions.campaign.store import ResultStore
from rai_missions.errors import counted
from rai_missions.plain_data import printable

__all__ = ("StoreComparison", "compare")


class StoreComparison(NamedTuple):
    """What was found between two stores."""

    names: tuple[str, str]
    comparisons: tuple[Comparison, ...]
    only_first: tuple[GroupName, ...]
    """Groups that the second lacks."""
    only_second: tuple[GroupName, ...]
    scenes: int
    """Scenes in which pairs are looked for."""
    changed: int
    """Scenes that have one name in both, but other data or other labels: left out."""

    def text(self) -> str:
        """For a person, one finding a line; what is significant comes first."""
        better = [each for each in self.comparisons if each.is_significant]
        noise = [each for each in self.comparisons if not each.is_significant]
        first, second = self.names
        lines = [
            f"A = {first}, B = {second}: {counted(self.scenes, 'scene')} in both",
            *([f"{counted(self.changed, 'scene')} left out: their data or labels differ"] if self.changed else []),
            f"significant ({len(better)} of {len(self.comparisons)}; paired by scene, clustered by seed, Holm at"
            f" {LEVEL:g}):",
            *(f"  {each.words()}" for each in better),
            f"noise ({len(noise)}):",
            *(f"  {each.words()}" for each in noise),
            *(f"only in A: {printable(each.words())}" for each in self.only_first),
            *(f"only in B: {printable(each.words())}" for each in self.only_second),
        ]
        return "\n".join(lines) + "\n"


def compare(first: Path | str, second: Path | str) -> StoreComparison:
    """Compare the groups (mission, model, embodiment) that two stores share.

    Raises:
        UsageError: One of them is no store of a campaign.
    """
    with ResultStore(first) as a, ResultStore(second) as b:
        return compared_stores((Path(first).name, Path(second).name), figures_of(a), figures_of(b))


def compared_stores(names: tuple[str, str], first: CampaignFigures, second: CampaignFigures) -> StoreComparison:
    """As `compare`, of figures that were read."""
    shared = first.scenes.keys() & second.scenes.keys()
    same = {name for name in shared if _facts(first, name) == _facts(second, name)}
    ours = {group.name for group in first.groups}
    theirs = {group.name for group in second.groups}
    return StoreComparison(
        names,
        compared(_pairings(first, second, same)),
        tuple(sorted(ours - theirs)),
        tuple(sorted(theirs - ours)),
        len(same),
        len(shared) - len(same),
    )


def _pairings(first: CampaignFigures, second: CampaignFigures, scenes: set[str]) -> Iterator[Pairing]:
    others = {group.name: group for group in second.groups}
    for group in first.groups:
        other = others.get(group.name)
        if other is not None:
            ours = {key: answer for key, answer in group.answers.items() if key[0] in scenes}
            words = printable(group.name.words())
            yield Pairing(f"A's {words}", f"B's {words}", tuple(matched(ours, other.answers)))


def _facts(figures: CampaignFigures, scene: str) -> object:
    """What has to be alike for two answers to be a pair."""
    return figures.scenes[scene].spec, figures.scenes[scene].seed, figures.labels.get(scene)
