# SPDX-License-Identifier: Apache-2.0
"""The moves from where things are to where they are to be: one after the other, none onto or out from under another.

Where two wait for each other's place, one is put aside for a while.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Iterator, Sequence

from rai_missions.planning.candidates import LEAST_M
from rai_missions.planning.fingers import can_take, crowding
from rai_missions.planning.placement import Arrangement, is_in_the_way
from rai_missions.planning.plan import AvoidedPlace, PlannedMove, Pose, is_avoided
from rai_missions.planning.relations import downward
from rai_missions.planning.scene import CONTAINERS, DESK, Scene, Thing
from rai_missions.planning.workspace import Workspace

__all__ = ("Ordering", "free_spot", "place_for_the_hand")

WIDE_M = (0.085, 0.045)
"""Free distances around what is put aside, the best first: for a hand with its palm next to it, and for fingers."""


class Ordering:
    """Moves things one by one, as values.

    Args:
        present: Name → where each thing is now, those on the floor left out.
        below: Name → what each rests on now.
        final: Name → where each is to be.
        carriers: Name → what each is to rest on.
        names: The things that are wanted, in the order in which they were placed.
        reasons: Name → why it moves, for people.
        workspace: Where a thing may be put aside.
        clearance: Metres that the fingers need.
        careful: Put aside first what leaves another's fingers no room, as long as that helps; then the arm may push.
        avoided: Places at which the arm did not set things down; nothing is put aside there.
    """

    def __init__(
        self,
        present: Arrangement,
        below: dict[str, str | None],
        final: Arrangement,
        carriers: dict[str, str | None],
        *,
        names: Sequence[str],
        reasons: dict[str, str],
        workspace: Workspace,
        clearance: float,
        careful: bool = False,
        avoided: Collection[AvoidedPlace] = (),
    ) -> None:
        self.now, self.below = dict(present), dict(below)
        self.final, self.carriers, self.reasons = final, carriers, reasons
        self.workspace, self.clearance, self.careful = workspace, clearance, careful
        self.waiting = [name for name in names if final[name] != present[name]]
        self._aside: set[str] = set()
        self._avoided = avoided

    def moves(self) -> tuple[PlannedMove, ...] | None:
        """The moves in their order; None where there is no room to put a thing aside."""
        found = list[PlannedMove]()
        while self.waiting:
            name = next((each for each in self.waiting if self._is_ready(each)), None)
            if name is not None:
                found.append(self._move(name, self.final[name], self.carriers[name] or DESK, self.reasons[name]))
                self.waiting.remove(name)
                continue
            aside = self._put_aside()
            if aside is not None:
                found.append(aside)
            elif self.careful:
                self.careful = False
            else:
                return None
        return tuple(found)

    def _is_clear(self, name: str) -> bool:
        """Whether nothing rests on a thing."""
        return name not in self.below.values()

    def _is_ready(self, name: str) -> bool:
        """Whether a thing can go where it is to be: it is clear, what will carry it is there, the place is free."""
        carrier = self.carriers[name] or DESK
        if not self._is_clear(name) or carrier in self.waiting or not self._is_takeable(name):
            return False
        return not any(True for _ in self._in_its_way(name))

    def _is_takeable(self, name: str) -> bool:
        """Whether the fingers have room around it, where that counts."""
        return not self.careful or can_take(self.now[name], self.now.values())

    def _crowding(self, name: str) -> Iterator[str]:
        """What leaves the fingers no room around a thing that can be taken in no direction."""
        if not self._is_takeable(name):
            yield from (other.name for other in crowding(self.now[name], self.now.values()))

    def _in_its_way(self, name: str) -> Iterator[str]:
        there, chain = self.final[name], {*downward(name, ChainMap(self.carriers, self.below))}
        for other, thing in self.now.items():
            if other not in chain and other in self.waiting and is_in_the_way(there, thing, self.clearance):
                yield other

    def _move(self, name: str, to: Thing, onto: str, why: str) -> PlannedMove:
        pick = Pose.of(self.now[name])
        assumes = [f"{name} is at rest where it was seen", f"nothing stands on {name}", "the gripper is empty"]
        assumes.append("the place on the desk is free" if onto == DESK else f"{onto} is at rest where it was seen")
        if onto != DESK and self.now[onto].type not in CONTAINERS:
            assumes.append(f"nothing stands on {onto}")
        self.now[name], self.below[name] = to, onto
        return PlannedMove(name, pick, Pose.of(to), onto, tuple(assumes), why)

    def _put_aside(self) -> PlannedMove | None:
        """Move a clear thing out of the way: the one that most others wait for."""
        waited_for = [
            other
            for name in self.waiting
            for other in (*self._in_its_way(name), *self._on(name), *self._crowding(name))
        ]
        clear = [
            name
            for name in self.waiting
            if self._is_clear(name) and self._is_takeable(name) and name not in self._aside
        ]
        if self.careful:
            clear = [name for name in clear if name in waited_for]
        for name in sorted(clear, key=lambda each: -waited_for.count(each)):
            spot = self._free_spot(name)
            if spot is not None:
                self._aside.add(name)
                return self._move(name, spot, DESK, f"{name} is put aside for a while: it is in the way")
        return None

    def _on(self, name: str) -> Iterator[str]:
        """What rests on a thing, or on what is to carry it."""
        lower = {name, self.carriers[name]} - {DESK}
        return (upper for upper, below in self.below.items() if below in lower)

    def _free_spot(self, name: str) -> Thing | None:
        """The nearest place that is free now and that no other is to have."""
        taken = [other for each, other in self.now.items() if each != name]
        taken += [self.final[each] for each in self.waiting if each != name]
        return free_spot(self.now[name], taken, self.workspace, self.clearance, self._avoided)


def free_spot(
    thing: Thing, taken: Sequence[Thing], workspace: Workspace, least: float, avoided: Collection[AvoidedPlace] = ()
) -> Thing | None:
    """The nearest place on the desk that is free, with room for the whole hand if there is any; None where none is.

    Args:
        thing: Where it is.
        taken: All else that is to be kept clear of.
        workspace: Where it may be.
        least: Metres that the fingers need.
        avoided: Places that it must not be.
    """
    points = workspace.places((thing.x, thing.y))
    for clearance in (*(each for each in WIDE_M if each > least), least):
        for point in points:
            spot = thing.moved(*point, thing.size[2] / 2)
            is_free = workspace.carries(spot.footprint) and not is_avoided(spot, avoided)
            if is_free and not any(is_in_the_way(spot, other, clearance) for other in taken):
                return spot
    return None


def place_for_the_hand(scene: Scene) -> Pose | None:
    """Where the gripper may set down what it holds, whatever that is: as much room as the longest thing needs.

    None where the gripper is not known to hold anything, and where nothing that it may hold is seen.
    """
    things = [thing for thing in scene.things if thing.type not in CONTAINERS]
    if scene.gripper != "holding" or not things:
        return None
    longest = max(things, key=lambda thing: max(thing.size))
    spot = free_spot(longest, scene.things, Workspace(), LEAST_M)
    return Pose.of(spot) if spot is not None else None
