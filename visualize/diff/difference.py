# SPDX-License-Identifier: Apache-2.0
"""What a change to a mission changed, by meaning: what a reviewer must not miss first, and as one picture of both."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

from rai_missions.errors import counted
from rai_missions.mission.mission import Mission, given_mission
from visualize.diff.align import NameChange, aligned
from visualize.diff.as_text import lines
from visualize.diff.change import Change, weight
from visualize.diff.compare import changes
from visualize.diff.fields import severity_if
from visualize.diff.merged_picture import merged
from visualize.diff.originals import AS_THEY_ARE, Originals
from visualize.model import Picture
from visualize.text import child_pointer

__all__ = ("Difference", "difference")

NOTHING = "nothing that diff weighs as safety-relevant"


@dataclass(frozen=True)
class Difference:
    """How two missions differ."""

    old: Mission
    """With the names of the new one, for what was only renamed."""
    new: Mission
    names: tuple[NameChange, ...]
    """What is called otherwise: states, keys, events and options."""
    changes: tuple[Change, ...]
    """What is for a reviewer to judge first, by what it is about, else in the order of the new mission."""
    versions: tuple[str, str] = ("", "")
    originals: Originals = field(default=AS_THEY_ARE, compare=False)
    """Of the old mission, what its things and places were before they took the new names."""

    @property
    def renamed(self) -> tuple[tuple[str, str], ...]:
        """Old and new names of the states that are called otherwise."""
        return tuple((each.old, each.new) for each in self.names if each.sort == "state")

    @property
    def empty(self) -> bool:
        """Both mean the same; the version does not count."""
        return not self.changes

    @property
    def safety(self) -> tuple[Change, ...]:
        """The changes that a reviewer must agree to."""
        return tuple(change for change in self.changes if change.safety)

    @property
    def others(self) -> tuple[Change, ...]:
        """The rest."""
        return tuple(change for change in self.changes if not change.safety)

    @property
    def headline(self) -> str:
        """How many changes of either sort, in a line."""
        if self.empty:
            return "no difference in meaning"
        safety = counted(len(self.safety), "safety-relevant change") if self.safety else NOTHING
        return f"{safety}, {counted(len(self.others), 'other')}"

    def lines(self) -> tuple[str, ...]:
        """As a reader at a terminal wants it: what is to be judged first."""
        head = f"{self.new.name}: {' → '.join(self.versions)}: {self.headline}"
        return lines(head, {"SAFETY-RELEVANT": self.safety, "OTHERS": self.others})

    @cached_property
    def picture(self) -> Picture:
        """Both in one: what was added, removed and changed is marked."""
        both = merged(self.old, self.new, self.renamed, self.versions[0])
        return replace(both, notes=tuple(f"for review: {change}" for change in self.safety))


def difference(old: Mission, new: Mission) -> Difference:
    """Compare two missions by what they mean.

    Args:
        old: As it was reviewed.
        new: As it is now.

    Raises:
        UsageError: One of them is no mission.
    """
    for each in (old, new):
        given_mission(each, "difference")
    before, names = aligned(old, new)
    own = Originals(before, old)
    found = [*_renames(names, old, new), *(_as_written(each, own) for each in changes(before, new, own))]
    return Difference(before, new, names, tuple(sorted(found, key=weight)), (old.version, new.version), own)


def _renames(names: Iterable[NameChange], old: Mission, new: Mission) -> Iterator[Change]:
    places = [{name: place for place, name, _ in each.walk()} for each in (old, new)]
    around = {each.new: each.old for each in names if each.sort == "state"}
    for each in names:
        subject = ""
        if each.sort == "state":
            was, now, subject = places[0][each.old], places[1][each.new], each.new
        elif each.sort == "option":
            subject = each.where
            was = child_pointer(places[0][around.get(subject, subject)], "decision", "options", each.old)
            now = child_pointer(places[1][subject], "decision", "options", each.new)
        else:
            word = "blackboard" if each.sort == "key" else "events"
            was, now = child_pointer("", word, each.old), child_pointer("", word, each.new)
        alike = "" if each.score == 1 else f", {each.score:.0%} alike"
        whose = f"{subject}: " if each.sort == "option" else ""
        sentence = f"{whose}{each.sort} '{each.old}' renamed to '{each.new}'{alike}"
        outside = _known_outside(each, old, new)
        yield Change("~", "name", sentence, was, now, outside, "", severity_if(bool(outside)), subject)


def _known_outside(each: NameChange, old: Mission, new: Mission) -> str:
    """Who else knows a thing by its old name, in words; empty for no one.

    A person reads an option's name next to its other words; any other answerer goes by the name.
    """
    if each.sort == "option":
        question = new.state(each.where).question()
        asked = [who for who in question.ask if who != "operator"] if question is not None else []
        return f"'{each.old}'; {', '.join(asked)} choose{'s' * (len(asked) == 1)} by this name" if asked else ""
    if each.sort == "event" or (each.sort == "key" and old.blackboard[each.old].source != "mission"):
        return f"'{each.old}'; profiles and other systems know it by this name"
    return ""


def _as_written(change: Change, own: Originals) -> Change:
    """A change whose old place is that of the mission as it was given."""
    return change if change.old_place is None else change._replace(old_place=own.place(change.old_place))
