# SPDX-License-Identifier: Apache-2.0
"""Things over looks: which sighting is of which thing, what it is called, and whether it lies still.

Rule: a sighting belongs to the nearest thing, whatever class it got in this look, and among things in one place to that
of its class; a class counts once its looks lead those of every other class by `LEAD`. With one look in ten wrong, a
wrong class leads so far once in 500 000 times (gambler's ruin: (0.1 / 0.9) ** LEAD). No thing is within another.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable, Sequence
from typing import Any

from rai_missions.worlds.desk.catalogue import KINDS, WALL_M, free_name
from rai_missions.worlds.desk.detector import ClassifiedBody
from rai_missions.worlds.desk.look import SeenBody
from rai_missions.worlds.open_set_detector import ObjectClass

__all__ = ("LEAD", "Tracks")

LEAD = 6
LOOKS = 24
"""The newest looks that count for a class."""
SAME_M = 0.12
"""A thing is carried no farther between two looks."""
HERE_M = 0.015
"""Within so far a sighting of another class is in the same place."""
OTHER_M = 0.08
"""By how much farther than it is a sighting of another class counts elsewhere."""
GONE = 3
"""Looks that see what is behind a thing's place, one after the other, after which it is gone."""
GROWTH_M = 0.00002
"""By how much a pose is less exact with each look that shows less of its thing."""
BETTER = 2.0
"""How many times as exact as one look the mean of many is at the most."""
BORNE_M = 0.01
"""Half the play up and down between a thing and what rests on it, as measured."""
STILL_LOOKS, STILL_M, SIGMAS = 4, 0.002, 4.0
"""Still is who was within so far in so many looks, and the noise's share of it."""


class ObjectTrack:
    """One thing.

    Args:
        sighting: The first of it.
        number: Its own.
        since: The look that shows it first.
    """

    def __init__(self, sighting: ClassifiedBody, number: int, since: int) -> None:
        self.number = number
        self.classes: deque[ObjectClass] = deque(maxlen=LOOKS)
        self.poses: deque[SeenBody] = deque(maxlen=STILL_LOOKS)
        self.looks = 0
        self.since = self.shown = since
        """The look that shows it first, and the last one that gave it the class that it counts as."""
        self.seen_through = 0
        self.missed = 0
        self.thing: ObjectClass | None = None
        self.name = ""
        self.add(sighting)

    @property
    def pose(self) -> SeenBody:
        return self.poses[-1]

    @property
    def agreeing(self) -> int:
        """Looks that gave it the class that it counts as."""
        return sum(one == self.thing for one in self.classes)

    @property
    def is_still(self) -> bool:
        if len(self.poses) < STILL_LOOKS:
            return False
        return all(map(self._is_here, self.poses))

    @property
    def has_stopped(self) -> bool:
        """Whether the last two looks agree on where it is."""
        return len(self.poses) > 1 and self._is_here(self.poses[-2])

    def _is_here(self, pose: SeenBody) -> bool:
        """Whether a pose is the last one, as far as can be seen."""
        last = self.pose
        return math.dist(pose[1:4], last[1:4]) <= STILL_M + SIGMAS * math.sqrt(2) * last.sigma_m

    @property
    def kind(self) -> str:
        """What it counts as, or else what it was taken for last."""
        return (self.thing or self.classes[-1]).kind

    def probe(self) -> tuple[float, float, float]:
        """A point within it, above the desk: its middle, or that of a wall where it is hollow."""
        kind, pose = KINDS[self.kind], self.pose
        aside = kind.size[0] / 2 - WALL_M / 2 if kind.is_container else 0.0
        lowest_m = min(kind.size) / 2  # what was measured in the desk is looked for on it
        return pose.x + aside * math.cos(pose.yaw), pose.y + aside * math.sin(pose.yaw), max(pose.z, lowest_m)

    def encloses(self, x: float, y: float, z: float) -> bool:
        """Whether a point is within its body, where no other thing can have its middle; what is hollow can hold one."""
        size, pose = KINDS[self.kind].size, self.pose
        along, aside = math.cos(pose.yaw), math.sin(pose.yaw)
        dx, dy = x - pose.x, y - pose.y
        away = abs(dx * along + dy * aside), abs(dy * along - dx * aside), abs(z - pose.z)
        return not KINDS[self.kind].is_container and all(one <= wide / 2 for one, wide in zip(away, size, strict=True))

    def bears(self, other: ObjectTrack) -> bool:
        """Whether the other one rests on it."""
        mine, its = (KINDS[one.kind].size for one in (self, other))
        away = math.dist(self.pose[1:3], other.pose[1:3])
        gap = other.pose.z - self.pose.z - (mine[2] + its[2]) / 2
        return away < max(mine[:2]) / 2 and abs(gap) < BORNE_M

    def add(self, sighting: ClassifiedBody, growth_m: float = GROWTH_M) -> None:
        """Take in a look that shows it; one that shows it elsewhere is the first of those that it lies still in."""
        self.looks += 1
        self.seen_through = self.missed = 0
        self.classes.append(sighting.thing)
        if self.poses and _is_elsewhere(self.pose, sighting.seen):
            self.poses.clear()
        self.poses.append(_kept(self.pose, sighting.seen, growth_m) if self.poses else sighting.seen)

    def miss(self, *, is_seen_through: bool) -> None:
        self.missed += 1
        self.seen_through = self.seen_through + 1 if is_seen_through else 0

    @property
    def is_lost(self) -> bool:
        """Whether it moved when it was seen last, and has not been seen for a while."""
        return self.missed >= GONE and not self.is_still

    def leading(self) -> ObjectClass | None:
        """The class that leads every other one far enough."""
        (first, count), *rest = Counter(self.classes).most_common(2)
        return first if count - (rest[0][1] if rest else 0) >= LEAD else None


class Tracks:
    """All things that the looks have shown."""

    def __init__(self) -> None:
        self._tracks: list[ObjectTrack] = []
        self._made = 0
        self.looks = 0

    def add(self, sightings: Sequence[ClassifiedBody], is_free: Callable[[float, float, float], bool]) -> None:
        """Take in one look.

        Args:
            sightings: What the detector reports.
            is_free: Whether the look sees what is behind a point.
        """
        self.looks += 1
        pairs = sorted(
            (_distance(track, sighting), track.number, index, track, sighting)
            for track in self._tracks
            for index, sighting in enumerate(sightings)
            if _distance(track, sighting) <= SAME_M
        )
        matched: set[int] = set()
        used: set[int] = set()
        for _, number, index, track, sighting in pairs:
            if number not in matched and index not in used:
                matched.add(number)
                used.add(index)
                track.add(sighting, 0.0 if self._is_held_down(track) else GROWTH_M)
                track.shown = self.looks if sighting.thing == track.thing else track.shown
        for track in self._tracks:
            if track.number not in matched:
                track.miss(is_seen_through=is_free(*track.probe()))
        gone = [track for track in self._tracks if track.seen_through >= GONE]
        self._tracks = [track for track in self._tracks if track.seen_through < GONE]
        for track in gone:
            self._hand_on_name(track, self.looks - track.missed)
        for index, sighting in enumerate(sightings):
            if index not in used:
                self._made += 1
                self._tracks.append(ObjectTrack(sighting, self._made, self.looks))
        self._drop_doubles()
        self._name()

    def things(self) -> list[dict[str, Any]]:
        """The things whose class counts, as the fact `objects` has them, by name."""
        found = (_fact(track, is_at_rest=self._is_at_rest(track)) for track in self._tracks if track.name)
        return sorted(found, key=lambda one: str(one["name"]))

    def unsure(self) -> int:
        """How many things are seen whose class does not count yet."""
        return sum(not track.name for track in self._tracks)

    def _is_at_rest(self, track: ObjectTrack) -> bool:
        """Whether it lies still by its looks; or, hidden after it had stopped, because what rests on it does."""
        is_hidden_still = track.missed > 0 and track.has_stopped and self._is_held_down(track)
        return track.seen_through == 0 and (track.is_still or is_hidden_still)

    def _is_held_down(self, track: ObjectTrack) -> bool:
        """Whether something that lies still rests on it: it cannot have moved unseen."""
        return any(track.bears(other) and other.is_still for other in self._tracks if other is not track)

    def _drop_doubles(self) -> None:
        """What no class counts for yet, and is within a thing that is in sight, is a mistake about that thing."""
        seen = [track for track in self._tracks if track.name and not track.missed]
        self._tracks = [
            track for track in self._tracks if track.name or not any(one.encloses(*track.probe()) for one in seen)
        ]

    def _name(self) -> None:
        for track in self._tracks:
            thing = track.leading() or track.thing
            if thing is not None and thing != track.thing:
                self._hand_on_name(track, track.shown)
                track.thing, track.name, track.shown = thing, "", self.looks
        for track in self._tracks:
            if track.thing is not None and not track.name:
                carried = self._carried(track)
                taken = {each.name for each in self._tracks}
                track.name = carried.name if carried else free_name(*track.thing, taken)
                if carried:
                    self._tracks.remove(carried)
                    break

    def _hand_on_name(self, track: ObjectTrack, last_shown: int) -> None:
        """What has left its place unseen, or gave it to another, is the only thing of its class that appeared since."""
        found = [one for one in self._tracks if one.name and one.thing == track.thing and one.since > last_shown]
        if track.name and len(found) == 1:
            found[0].name = track.name

    def _carried(self, found: ObjectTrack) -> ObjectTrack | None:
        """The thing that this one is: it moved when it was seen last, it is the only such, and of the same class."""
        lost = [one for one in self._tracks if one.thing == found.thing and one.is_lost and one is not found]
        return lost[0] if len(lost) == 1 else None


def _is_elsewhere(before: SeenBody, now: SeenBody) -> bool:
    """Whether a look shows a thing farther from where it was than noise explains."""
    return math.dist(before[1:4], now[1:4]) > SIGMAS * now.sigma_m


def _kept(before: SeenBody, now: SeenBody, growth_m: float) -> SeenBody:
    """The pose that counts after another look, which shows the thing where it was.

    It is the mean of its looks, each weighed by the inverse of its variance. A thing that is hidden by now keeps what
    was measured much better before, trusted less by `growth_m` with each look. What the looks have in common (an edge
    that is hidden in all) no mean takes away: the mean counts as at most `BETTER` times as exact as the look.
    """
    grown = before.sigma_m + growth_m
    if grown < now.sigma_m / BETTER:
        return before._replace(share=now.share, sigma_m=grown)
    old, new = before.sigma_m**-2, now.sigma_m**-2
    x, y, z = ((old * one + new * other) / (old + new) for one, other in zip(before[1:4], now[1:4], strict=True))
    return now._replace(x=x, y=y, z=z, sigma_m=max((old + new) ** -0.5, now.sigma_m / BETTER))


def _distance(track: ObjectTrack, sighting: ClassifiedBody) -> float:
    """How far a sighting is from a thing; farther where it is of another class, and far more elsewhere.

    So a look that takes a thing for another one is still of the thing in that place, what is hidden for a moment is not
    taken for its neighbour, and what lies in the middle of a tray is not taken for the tray.
    """
    away = math.dist(track.pose[1:4], sighting.seen[1:4])
    if sighting.thing == (track.thing or track.classes[-1]):
        return away
    return away + (HERE_M if away <= HERE_M else OTHER_M)


def _fact(track: ObjectTrack, *, is_at_rest: bool) -> dict[str, Any]:
    assert track.thing is not None
    pose, (kind, colour) = track.pose, track.thing
    return {
        "name": track.name,
        "type": kind,
        "colour": colour,
        "x": round(pose.x, 5),
        "y": round(pose.y, 5),
        "z": round(pose.z, 5),
        "yaw": round(_folded(pose.yaw, KINDS[kind].turns), 4),
        "size": list(KINDS[kind].size),
        "sigma_m": round(pose.sigma_m, 5),
        "looks": track.looks,
        "agreeing": track.agreeing,
        "at_rest": is_at_rest,
    }


def _folded(yaw: float, turns: int) -> float:
    """The yaw of what looks the same after a part of a turn, nearest to 0."""
    return math.remainder(yaw, 2 * math.pi / turns) if turns else 0.0
