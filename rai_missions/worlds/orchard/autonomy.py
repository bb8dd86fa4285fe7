# SPDX-License-Identifier: Apache-2.0
"""The rule-based autonomy stack: drives the alleys one after the other, and hands over when something is in the way.

Rule: it knows the pose and the range to the nearest thing ahead, and nothing else. It does not decide what to do about
an obstacle; the controller that it handed over to does, by `proceed`, `replan` or `cross`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

from rai_missions.worlds.orchard.path_follower import Follower
from rai_missions.worlds.orchard.planner import Lattice, LatticePlace, PathSegment, straight
from rai_missions.worlds.orchard.tractor import NOSE_M, TractorPose

__all__ = ("STOP_AT_M", "Autonomy", "Word")

Word = Literal["STOPPED", "DRIVING", "REVERSING", "CHANGING_PATH", "FINISHED"]
"""The states of the upstream demo."""
Starts = list[tuple[tuple[PathSegment, ...], LatticePlace]]
Way = tuple[float, tuple[PathSegment, ...]]
STOP_AT_M, WAIT_AT_M = 5.0, 1.5
"""In an alley it hands over for what is nearer than the first; on a headland it waits while something is nearer than
the second."""
LOST_M = 2.0
"""So far off its way, it does not trust itself."""
ACCEPTED_BEYOND_M = 2.5
"""What is driven over may lie so far beyond where it was first seen: it has a length, and it rolls."""
CROSSING_MPS = 1.2
LOOKS_AGAIN_S = 0.6
"""Asked to drive on, it looks for so long whether the way is still blocked."""
ENTERED_M = 3.0


class AcceptedStretch(NamedTuple):
    """What is driven over: whatever lies up to a line across the tractor's way."""

    along: tuple[float, float]
    """The way that the tractor was going, a unit vector."""
    until_m: float
    """Where the line is along it, from the origin."""


class Autonomy:
    """The state of the drive.

    Args:
        lattice: The ways of the orchard.
        attempts: How often an alley is tried before it is given up.
        handed_over: Sent the distance (m) to what is in the way, each time the tractor stops for something.
        stop_at_m: What is nearer, in an alley, is handed over for.
    """

    def __init__(
        self, lattice: Lattice, *, attempts: int, handed_over: Callable[[float], None], stop_at_m: float = STOP_AT_M
    ) -> None:
        self._stop_at_m = stop_at_m
        self._lattice, self._attempts, self._handed_over = lattice, attempts, handed_over
        self._follower = Follower()
        self._here: LatticePlace = lattice.nearest(*lattice.layout.home[:2])
        self._tries = [0] * lattice.layout.alleys
        self._from_east = [False] * lattice.layout.alleys
        self._undone = set(range(lattice.layout.alleys))
        self._blocked: set[int | None] = set()
        self._rough: set[int | None] = set()
        self._is_parked = True
        self._is_homing = False
        self._accepted: AcceptedStretch | None = None
        self._looks_s = 0.0
        self.word: Word = "CHANGING_PATH"
        self.pose = TractorPose(*lattice.layout.home, 0.0)
        self.range_m: float | None = None

    @property
    def watches(self) -> bool:
        """Whether the range ahead matters now: in alleys, not while turning between trees."""
        move = self._follower.move
        return move is not None and move.alley is not None and move.ahead > 0

    @property
    def is_driving(self) -> bool:
        return self.word in ("DRIVING", "REVERSING", "CHANGING_PATH") and not self._is_parked

    @property
    def left_m(self) -> float:
        """How much of the planned way is left."""
        return self._follower.distance_m

    @property
    def is_homing(self) -> bool:
        """Whether it drives to a place instead of working the alleys."""
        return self._is_homing

    @property
    def is_crossing(self) -> bool:
        return self._accepted is not None

    def proceed(self, *, over: bool) -> bool:
        """Drive on.

        Args:
            over: What is in the way now is accepted: the tractor drives over it. Otherwise it looks again, and hands
                over again if something is still there.
        """
        if self._is_homing or (self.word == "FINISHED" and not self._undone):
            return False
        if self.is_driving:
            return True
        self._looks_s = LOOKS_AGAIN_S
        if over and self.word == "STOPPED":
            self._accept()
        if self.word == "FINISHED":
            self._tries = [0] * len(self._tries)
        self._is_parked = False
        if not self._follower.moves:
            self._plan_next()
        self._publish()
        return True

    def stop(self) -> None:
        """Stop until commanded otherwise; a way home is given up."""
        self._is_parked = True
        if self._is_homing:
            self._forget_home()
        if self.word != "FINISHED":
            self.word = "STOPPED"
        self._accepted = None

    def replan(self) -> bool:
        """Back out of this alley and take the next; this one is tried again later, from its other end."""
        move = self._follower.move
        if self._is_homing or self.word == "FINISHED" or move is None or move.alley is None or move.ahead < 0:
            return False
        self._tries[move.alley] += 1
        self._blocked.add(move.alley)
        self._from_east[move.alley] = move.end.is_west
        self._accepted, self._is_parked = None, False
        self._plan_next()
        self._publish()
        return True

    def go_to(self, goal: LatticePlace) -> bool:
        """Leave the alleys for a place on a headland, whatever the heading there."""
        found = self._lattice.way(self._starts(), lambda place: place[:2] == goal[:2], self._is_passable)
        if found is None:
            return False
        self._follower.take(found[1])
        self._is_homing, self._is_parked, self._accepted = True, False, None
        self._publish()
        return True

    def step(self, pose: TractorPose, range_m: float | None, period_s: float) -> tuple[float, float]:
        """The speed (m/s) and curvature (1/m) to command now."""
        self.pose, self.range_m = pose, range_m
        if self._is_parked:
            return 0.0, 0.0
        if self._is_in_the_way():
            self._looks_s -= period_s
            return (0.0, 0.0) if self._looks_s > 0 else self._hand_over()
        self._looks_s = 0.0
        if self._waits() or self._is_lost():
            return 0.0, 0.0
        before, last = self._follower.move, self._follower.moves[-1:]
        speed, bend = self._follower.step(pose)
        self._note_progress(before)
        if last and not self._follower.moves:
            self._here = last[0].end
        self._publish()
        return (min(speed, CROSSING_MPS) if self.is_crossing else speed), bend

    def _note_progress(self, before: PathSegment | None) -> None:
        after = self._follower.move
        if before is not None and before is not after:
            self._here = before.end
            mouth_m = self._lattice.position(before.end)[0]
            if before.alley is not None and before.ahead > 0 and abs(self.pose.x - mouth_m) < 1.0:
                self._undone.discard(before.alley)
                self._blocked.discard(before.alley)
        if self._accepted is not None and self._is_beyond(self._accepted):
            self._accepted = None
        if self._is_homing and after is None:
            self._arrive()
        elif not self._is_homing and (after is None or (len(self._follower.moves) == 1 and self._nears_an_end(after))):
            self._plan_next()

    def _nears_an_end(self, move: PathSegment) -> bool:
        return move.alley is not None and move.ahead > 0 and self._follower.left_m < ENTERED_M

    def _plan_next(self) -> None:
        """Continue to the nearest alley that is left: first those not tried yet."""
        move = self._follower.move
        leaving = move if move is not None and move.alley not in self._blocked and move.ahead > 0 else None
        starts: Starts = self._starts() if leaving is None else [((), leaving.end)]
        left = self._undone - ({leaving.alley} if leaving is not None else set())
        for tries in range(self._attempts):
            found = self._nearest_of([alley for alley in sorted(left) if self._tries[alley] == tries], starts)
            if found is not None:
                _, moves = found
                self._blocked.discard(moves[-1].alley)
                (self._follower.extend if leaving is not None else self._follower.take)(moves)
                return
        if leaving is None:
            self._is_parked, self.word = True, "FINISHED"

    def _nearest_of(self, alleys: Iterable[int], starts: Starts) -> Way | None:
        """The cheapest way into any of these; of several that cost the same the first."""
        best: Way | None = None
        for alley in alleys:
            best = self._way_into(alley, starts, math.inf if best is None else best[0]) or best
        return best

    def _way_into(self, alley: int, starts: Starts, below: float) -> Way | None:
        """To one of an alley's mouths – after a failed attempt the other one – and through it, if it costs less."""
        ends = (not self._from_east[alley],) if self._tries[alley] else (True, False)
        mouths = {self._lattice.mouth(alley, east=east, heading=2 if east else 0) for east in ends}
        found = self._lattice.way(
            starts,
            lambda place: place in mouths,
            lambda other: other != alley and self._is_passable(other),
            below,
        )
        if found is None:
            return None
        cost, moves = found
        start = moves[-1].end if moves else starts[0][1]
        return cost, (*moves, self._lattice.through(alley, start))

    def _is_passable(self, alley: int) -> bool:
        """Whether to pass through on the way to somewhere else: not where something was in the way."""
        return alley not in self._blocked and alley not in self._rough

    def _starts(self) -> Starts:
        """Where a new way can begin: at the end of the present move, or behind, out of an alley backwards."""
        move = self._follower.move
        if move is None:
            return [((), self._here)]
        rest = self._follower.rest_of_move()
        starts: Starts = []
        if rest is not None and not (move.ahead > 0 and move.alley in self._blocked):
            starts.append(((rest,), rest.end))
        if move.alley is not None and move.ahead > 0:
            back = move.end.across()
            x, y = self._lattice.position(back)
            points = straight(self.pose.x, y, x, y, back.heading * math.pi / 2)
            starts.append(((PathSegment(points, -1, back, move.alley),), back))
        return starts

    def _is_in_the_way(self) -> bool:
        if not self.watches or self.range_m is None or self.range_m >= self._stop_at_m:
            return False
        return self._accepted is None or self._hit_m(self._accepted.along) > self._accepted.until_m

    def _waits(self) -> bool:
        """Whether someone is in the way where nothing should be: on a headland."""
        move = self._follower.move
        on_headland = move is not None and move.alley is None and move.ahead > 0
        return on_headland and self.range_m is not None and self.range_m < WAIT_AT_M

    def _is_lost(self) -> bool:
        if self._follower.off_m(self.pose) > LOST_M:
            self.stop()
        return self._is_parked

    def _hit_m(self, along: tuple[float, float]) -> float:
        """Where the nearest thing ahead is, along a way."""
        return self.pose.x * along[0] + self.pose.y * along[1] + NOSE_M + (self.range_m or 0.0)

    def _hand_over(self) -> tuple[float, float]:
        distance, move = self.range_m or 0.0, self._follower.move
        assert move is not None and move.alley is not None
        self._rough.add(move.alley)
        if self._is_homing:
            self._blocked.add(move.alley)
            goal = self._follower.moves[-1].end
            if not self.go_to(goal):
                self.stop()
            return 0.0, 0.0
        self._is_parked, self.word, self._accepted = True, "STOPPED", None
        self._handed_over(distance)
        return 0.0, 0.0

    def _accept(self) -> None:
        if self.watches and self.range_m is not None and self.range_m < self._stop_at_m + 1.0:
            along = (math.cos(self.pose.heading), math.sin(self.pose.heading))
            self._accepted = AcceptedStretch(along, self._hit_m(along) + ACCEPTED_BEYOND_M)

    def _is_beyond(self, accepted: AcceptedStretch) -> bool:
        return self.pose.x * accepted.along[0] + self.pose.y * accepted.along[1] - 1.0 > accepted.until_m

    def _arrive(self) -> None:
        self._forget_home()
        self._is_parked, self.word = True, "FINISHED"

    def _forget_home(self) -> None:
        """What is left of the move under the wheels stays; the rest is planned again when it is needed."""
        rest = self._follower.rest_of_move()
        self._follower.take([rest] if rest is not None else [])
        self._is_homing = False

    def _publish(self) -> None:
        move = self._follower.move
        if self._is_parked or move is None:
            return
        if move.alley is not None:
            self.word = "DRIVING" if move.ahead > 0 else "REVERSING"
        else:
            self.word = "CHANGING_PATH"
