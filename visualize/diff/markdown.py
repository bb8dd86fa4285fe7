# SPDX-License-Identifier: Apache-2.0
"""A difference as Markdown for a pull request's comment: the summary first, the rest folded away.

Rule: what a mission holds is shown as it is and does nothing: no markup, no mention of a person, no link. A comment
that its host would refuse is cut, and states it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from rai_missions.errors import counted
from visualize.diff.as_text import by_topic
from visualize.diff.change import Change
from visualize.diff.difference import Difference
from visualize.mermaid import mermaid
from visualize.model import Mark
from visualize.style import clean

__all__ = ("markdown",)

LONGEST = 60_000
"""Characters; GitHub takes comments of up to 65,536."""
PICTURE_LONGEST, EDGES = 25_000, 250
"""A diagram with more text or arrows than these is not drawn in a comment, or cannot be read."""
WORDS: dict[Mark, str] = {"+": "added", "-": "removed", "~": "changed", "": ""}
CELL = 600
"""Characters of one text."""


def markdown(given: Difference) -> bytes:
    """The file."""
    head = "\n".join(_head(given))
    safety = _table(given.safety, LONGEST - len(head) - 2_000) if given.safety else ""
    left = LONGEST - len(head) - len(safety)
    others = (
        _folded(counted(len(given.others), "other change"), _table(given.others, left - 500)) if given.others else ""
    )
    left -= len(others)
    return "\n\n".join(filter(None, (head, safety, others, _picture(given, left)))).encode("utf-8", "replace") + b"\n"


def _head(given: Difference) -> Iterator[str]:
    before, after = given.versions
    yield f"### Mission {quoted(given.new.name)}: {quoted(before)} → {quoted(after)}"
    yield ""
    if given.safety:
        yield f"⚠ **{given.headline}.** A second pair of eyes must agree to what is in the first table."
    else:
        yield f"{given.headline.capitalize()}."


def _table(changes: Sequence[Change], longest: int) -> str:
    """The rows, as many as there is room for."""
    lines, used, shown = ["| | what | was | is now |", "| --- | --- | --- | --- |"], 0, 0
    for heading, found in by_topic(changes):
        rows = [f"| | **{heading}** | | |", *map(_row, found)]
        for number, row in enumerate(rows):
            used += len(row) + 1
            if used > longest:
                return "\n".join([*lines, f"| | … and {len(changes) - shown} more, for which there is no room | | |"])
            lines.append(row)
            shown += bool(number)
    return "\n".join(lines)


def _row(change: Change) -> str:
    what = f"{inert(change.sentence)}<br><sub>{quoted(change.place or '/')}</sub>"
    return f"| {change.mark} {WORDS[change.mark]} | {what} | {quoted(change.before)} | {quoted(change.after)} |"


def _folded(title: str, body: str) -> str:
    return f"<details><summary>{title}</summary>\n\n{body}\n\n</details>"


def _picture(given: Difference, room: int) -> str:
    if not given.changes:
        return ""
    picture = replace(given.picture, notes=())
    text = mermaid(picture) if len(picture.edges) <= EDGES else ""
    if not text or len(text) > min(PICTURE_LONGEST, room - 400):
        return "The picture of both is too large for a comment; `rai-missions diff … -o diff.html` shows it."
    legend = "`+` added, `-` removed, `~` changed"
    return _folded("Picture of both", f"{legend}\n\n```mermaid\n{text.rstrip()}\n```")


def quoted(given: str) -> str:
    """A text as code, on one line, every character that could mean more written by its number."""
    text = clean(given).replace("\n", " ").strip()
    text = f"{text[:CELL]} …" if len(text) > CELL else text
    return f"<code>{inert(text)}</code>" if text else ""


def inert(given: str) -> str:
    """A text in which every character that could mean more is written by its number."""
    return "".join(map(_inert, given))


def _inert(character: str) -> str:
    return (
        character if character.isalnum() or character in " .,'()/=+" or character > "\x7f" else f"&#{ord(character)};"
    )
