# SPDX-License-Identifier: Apache-2.0
"""Changes as text for a terminal, under headings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby

from visualize.diff.change import Change, heading
from visualize.style import clean

__all__ = ("by_topic", "lines")


def by_topic(changes: Sequence[Change]) -> Iterator[tuple[str, list[Change]]]:
    """Heading → what is below it."""
    for title, found in groupby(changes, key=heading):
        yield title, list(found)


def lines(head: str, parts: Mapping[str, Sequence[Change]]) -> tuple[str, ...]:
    """The head, and the changes of each part by their title, a few lines each, marked `+`, `-` or `~`."""
    return tuple(clean(line).replace("\n", " ") for line in (head, *_lines(parts)))


def _lines(parts: Mapping[str, Sequence[Change]]) -> Iterator[str]:
    for title, changes in parts.items():
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
