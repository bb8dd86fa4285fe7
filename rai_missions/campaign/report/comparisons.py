# SPDX-License-Identifier: Apache-2.0
"""What in one store, or between two, is better beyond chance: paired in the same scenes, corrected for their number.

Rule: a difference is significant only by its corrected p value; all tests of one call are one family.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Literal, NamedTuple

from rai_missions.campaign.report.figures import CellAnswer, GroupFigures, GroupName
from rai_missions.campaign.statistics import PairedTest, holm, paired_test
from rai_missions.errors import counted

__all__ = ("LEVEL", "Comparison", "Measure", "compared", "within")

LEVEL = 0.05
"""The chance of one false alarm or more among all comparisons of a call."""
RULES, NONE = "rules", "none"
Measure = Literal["best", "harm"]
Key = tuple[str, str]


class Comparison(NamedTuple):
    """One test of a family."""

    first: str
    second: str
    measure: Measure
    test: PairedTest
    adjusted: float
    """Holm's p value."""

    @property
    def is_significant(self) -> bool:
        return self.adjusted < LEVEL

    def words(self) -> str:
        """The finding in one sentence."""
        what = "names the best option" if self.measure == "best" else "names an option that harms"
        figures = (
            f"{100 * self.test.difference:+.1f} points [{100 * self.test.low:+.1f}, {100 * self.test.high:+.1f}],"
            f" p {self.adjusted:.2g} after correction, {counted(self.test.pairs, 'pair')} in"
            f" {counted(self.test.clusters, 'seed')}"
        )
        if not self.is_significant:
            return f"{self.first} and {self.second}: how often each {what} differs within noise ({figures})"
        return (
            f"{self.first} {what} {'more' if self.test.difference > 0 else 'less'} often than {self.second} ({figures})"
        )


class Pairing(NamedTuple):
    """Two answerers and their answers in the same cells."""

    first: str
    second: str
    answers: tuple[tuple[CellAnswer, CellAnswer], ...]


def compared(pairings: Iterable[Pairing]) -> tuple[Comparison, ...]:
    """A test of `best` and one of `harm` for each pairing that has pairs, corrected together."""
    tests = [
        (pairing, measure, _tested(pairing, measure))
        for pairing in pairings
        if pairing.answers
        for measure in ("best", "harm")
    ]
    adjusted = holm([test.p for _, _, test in tests])
    return tuple(
        Comparison(pairing.first, pairing.second, "best" if measure == "best" else "harm", test, p)
        for (pairing, measure, test), p in zip(tests, adjusted, strict=True)
    )


def within(groups: Iterable[GroupFigures]) -> tuple[Comparison, ...]:
    """Inside one store: each model with the rules of its mission, and each embodiment with none, the model the same."""
    return compared(_pairings({group.name: group for group in groups}))


def _pairings(groups: Mapping[GroupName, GroupFigures]) -> Iterator[Pairing]:
    for name, group in groups.items():
        rules = next((groups[each] for each in groups if each.mission == name.mission and each.model == RULES), None)
        if rules is not None and name.model != RULES:
            yield _paired(group, rules)
        bare = groups.get(name._replace(embodiment=NONE))
        if bare is not None and name.embodiment != NONE:
            yield _paired(group, bare)


def _paired(first: GroupFigures, second: GroupFigures) -> Pairing:
    return Pairing(first.name.words(), second.name.words(), tuple(matched(first.answers, second.answers)))


def matched(
    first: Mapping[Key, CellAnswer], second: Mapping[Key, CellAnswer]
) -> Iterator[tuple[CellAnswer, CellAnswer]]:
    """The answers to the same scene in the same order of options.

    Where the second has one order only (rules, which read no order), it is compared in each order of the first.
    """
    orders = {order for _, order in second}
    only = next(iter(orders)) if len(orders) == 1 else None
    for (scene, order), answer in first.items():
        other = second.get((scene, order)) or (second.get((scene, only)) if only is not None else None)
        if other is not None:
            yield answer, other


def _tested(pairing: Pairing, measure: str) -> PairedTest:
    if measure == "best":
        return paired_test((one.seed, one.is_best, other.is_best) for one, other in pairing.answers)
    return paired_test((one.seed, one.is_harm, other.is_harm) for one, other in pairing.answers)
