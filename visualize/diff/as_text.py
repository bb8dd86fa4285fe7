# SPDX-License-Identifier: Apache-2.0
"""A difference as text for a terminal: what is for a reviewer to judge first, under headings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Protocol

from rai_missions.errors import counted
from rai_missions.mission.mission import Mission
from visualize.diff.change import Change, heading
from visualize.style import clean

__all__ = ("TextReport", "by_topic", "headline", "lines")


NOTHING = "nothing that diff weighs as safety-relevant"


class TextReport(Protocol):
    """What there is to report."""

    @property
    def new(self) -> Mission: ...
    @property
    def versions(self) -> tuple[str, str]: ...
    @property
    def changes(self) -> tuple[Change, ...]: ...
    @property
    def safety(self) -> tuple[Change, ...]: ...
    @property
    def others(self) -> tuple[Change, ...]: ...


def headline(given: TextReport) -> str:
    """How many changes of either sort, in a line."""
    if not given.changes:
        return "no difference in meaning"
    safety = counted(len(given.safety), "safety-relevant change") if given.safety else NOTHING
    return f"{safety}, {counted(len(given.others), 'other')}"


def by_topic(changes: Sequence[Change]) -> Iterator[tuple[str, list[Change]]]:
    """Heading → what is below it."""
    for title, found in groupby(changes, key=heading):
        yield title, list(found)


def lines(given: TextReport) -> tuple[str, ...]:
    """A few lines a change, each marked `+`, `-` or `~`."""
    before, after = given.versions
    return tuple(map(_one_line, _lines(f"{given.new.name}: {before} → {after}: {headline(given)}", given)))


def _one_line(text: str) -> str:
    return clean(text).replace("\n", " ")


def _lines(head: str, given: TextReport) -> Iterator[str]:
    yield head
    for title, changes in (("SAFETY-RELEVANT", given.safety), ("OTHERS", given.others)):
        if changes:
            yield from ("", title)
        for topic, found in by_topic(changes):
            yield f"  {topic}"
            yield from _change_lines(found)


def _change_lines(changes: Iterable[Change]) -> Iterator[str]:
    for change in changes:
        yield f"    {change.mark} {change.sentence}"
        if change.before:
            yield f"        was  {change.before}"
        if change.after:
            yield f"        {'now ' if change.before or change.mark == '~' else '    '} {change.after}"
        yield f"        at   {change.place or '/'}"
