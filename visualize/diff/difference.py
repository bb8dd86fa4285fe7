# SPDX-License-Identifier: Apache-2.0
"""What a change to a mission changed, by meaning: as sentences, what loosens first, and as one picture of both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from rai_missions.mission import Mission
from visualize.diff.aligned import renamed, with_names
from visualize.diff.changes import Change, changes
from visualize.diff.merged import merged
from visualize.picture import picture
from visualize.shapes import Picture

__all__ = ("Change", "Difference", "difference")


@dataclass(frozen=True)
class Difference:
    """How two missions differ."""

    old: Mission
    """With the names of the new one, where a state was only renamed."""
    new: Mission
    renamed: tuple[tuple[str, str], ...]
    """Old and new names of the states that are called otherwise and are the same in all else."""
    changes: tuple[Change, ...]
    """What loosens first, else in the order of the new mission."""
    versions: tuple[str, str] = ("", "")

    @property
    def empty(self) -> bool:
        """Both mean the same; name and version do not count."""
        return not (self.changes or self.renamed)

    @property
    def loosening(self) -> tuple[Change, ...]:
        """The changes a reviewer must agree to."""
        return tuple(change for change in self.changes if change.loosens)

    def lines(self) -> tuple[str, ...]:
        """As a reader at a terminal wants it: a line a change, marked `+`, `-` or `~`."""
        head = f"{self.new.name}: {self.versions[0]} → {self.versions[1]}"
        if self.empty:
            return (f"{head}: no difference in meaning",)
        rest = [change for change in self.changes if not change.loosens]
        others = len(rest) + len(self.renamed)
        lines = [f"{head}: {len(self.loosening)} changes that may loosen what protects, {others} others"]
        lines += ["", "May loosen what protects:"] if self.loosening else []
        lines += [f"  {change}  ({change.place or '/'})" for change in self.loosening]
        lines += ["", "Others:"] if rest or self.renamed else []
        lines += [f"  ~ state '{before}' renamed to '{after}'" for before, after in self.renamed]
        lines += [f"  {change}  ({change.place or '/'})" for change in rest]
        return tuple(lines)

    @cached_property
    def picture(self) -> Picture:
        """Both in one: what was added, removed and changed is marked."""
        both = merged(picture(self.old), picture(self.new), self)
        return both._replace(notes=tuple(f"may loosen: {change}" for change in self.loosening))


def difference(old: Mission, new: Mission) -> Difference:
    """Compare two missions by what they mean.

    Args:
        old: As it was reviewed.
        new: As it is now.
    """
    names = renamed(old, new)
    before = with_names(old, names)
    found = sorted(changes(before, new), key=lambda change: not change.loosens)
    return Difference(before, new, tuple(names.items()), tuple(found), (old.version, new.version))
