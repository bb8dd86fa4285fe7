# SPDX-License-Identifier: Apache-2.0
"""From a goal and what is seen to a plan: which things move, where to, and in which order.

Few things move: first those that must, then one or two more, then as many as it takes. Foreign things in a tower and in
a named place are put away; everything else stays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from rai_missions.errors import UsageError
from rai_missions.planning.candidates import LEAST_M
from rai_missions.planning.feasibility import FLOOR_M, refused_by_rule
from rai_missions.planning.fingers import PALM_UP_M, least_crowding
from rai_missions.planning.geometry import gap
from rai_missions.planning.goal import FIRST_SEEN, AtPlace, Goal, Grouped, InContainer, LeftOf, OnTop, Refusal
from rai_missions.planning.ordering import Ordering, free_spot
from rai_missions.planning.placement import Placement
from rai_missions.planning.plan import AvoidedPlace, Plan, PlannedMove, Pose
from rai_missions.planning.relations import at_first_poses, columns, downward, holds, support
from rai_missions.planning.scene import CONTAINERS, DESK, Scene, Thing
from rai_missions.planning.sentences import ENGLISH, refusal_sentence
from rai_missions.planning.tolerances import contact
from rai_missions.planning.workspace import Workspace

__all__ = ("feasible", "planned")

CLEARANCES_M = (0.03, 0.018, LEAST_M)
"""Free distances for the fingers, the best first: open on both sides, just so, and for fingers turned the other way."""
LEANING_M = 0.01
"""What is so near below a thing that rests on nothing carries it: a thing that leans is measured only so well."""
TRIED = 16
"""Sets of things to move that are tried."""
BUDGET = 120
"""Places that are tried for one set of things to move."""
BUDGET_OF_LAST = 2_000
"""Places that are tried where everything may move."""
BUDGET_OF_ALL = 9_000
"""Places that are tried for a question: so its answer takes a bounded time, whatever is asked."""


def feasible(goal: Goal, scene: Scene, workspace: Workspace | None = None) -> Refusal | None:
    """Why a goal cannot be reached; None where there is a plan. Swaps and shifts count from the poses that are seen.

    Args:
        goal: What is wanted.
        scene: What is seen.
        workspace: Where the arm works.
    """
    if any(True for _ in goal.of_kind(*FIRST_SEEN)) and all(scene.get(name) is not None for name in goal.things()):
        try:
            goal = at_first_poses(goal, scene)
        except UsageError:
            return Refusal("no_room", refusal_sentence("swap_absent"))
    found = planned(goal, scene, workspace)
    return found if isinstance(found, Refusal) else None


def planned(
    goal: Goal,
    scene: Scene,
    workspace: Workspace | None = None,
    *,
    language: str = ENGLISH,
    avoided: Sequence[AvoidedPlace] = (),
) -> Plan | Refusal:
    """The moves that reach a goal, or why it is refused. The same question has the same answer.

    What moves is taken as at rest where it was seen, and the gripper as empty; each move states so.

    Args:
        goal: What is wanted, its swaps and shifts rewritten.
        scene: What is seen.
        workspace: Where the arm works.
        language: The language of the sentence of a refusal.
        avoided: Places that the arm refused; where no plan does without them, they are tried again, and `about` of the
            plan names the last of them.
    """
    workspace = workspace or Workspace()
    if (refusal := refused_by_rule(goal, scene, workspace, language)) is not None:
        return refusal
    things = tuple(thing.model_copy(update={"at_rest": True}) for thing in scene.things)
    rest = scene.model_copy(update={"things": things, "gripper": "empty"})
    found = _Planner(goal, rest, workspace, avoided).plan()
    if found is None and avoided:
        again = refusal_sentence("refused_place", (avoided[-1].object,), language=language)
        found = _Planner(goal, rest, workspace).plan()
        found = replace(found, about=again) if found is not None else None
    return found if found is not None else Refusal("no_room", refusal_sentence("no_room", language=language))


class _Planner:
    """One question: a goal that no rule refuses, over a scene at rest."""

    def __init__(self, goal: Goal, scene: Scene, workspace: Workspace, avoided: Sequence[AvoidedPlace] = ()) -> None:
        self.goal, self.scene, self.workspace, self.avoided = goal, scene, workspace, avoided
        self.present = {thing.name: thing for thing in scene.things if thing.bottom >= FLOOR_M}
        self.below = {name: support(name, scene) or self._leant_on(name) for name in self.present}
        self.left = BUDGET_OF_ALL
        self.movable = [
            name for name, thing in self.present.items() if thing.type not in CONTAINERS and not self._is_sunk(thing)
        ]

    def _leant_on(self, name: str) -> str | None:
        """What a thing leans on that rests on nothing: the nearest of those that it may touch and that are below it."""
        thing = self.present[name]
        near = [
            (gap(thing.footprint, other.footprint), other.name)
            for other in self.present.values()
            if other.name != name and other.type not in CONTAINERS and other.z < thing.z
        ]
        away, found = min(near, default=(LEANING_M, ""))
        return found if away < LEANING_M and thing.bottom > contact(thing) else None

    def _is_sunk(self, thing: Thing) -> bool:
        """Whether it lies so deep in a bin that the palm meets the rim before the fingers have it."""
        holders = (self.present[each] for each in downward(thing.name, self.below) if each in self.present)
        return any(each.type == "bin" and each.top > thing.z + PALM_UP_M for each in holders)

    def plan(self) -> Plan | None:
        for clearances in (CLEARANCES_M[:2], CLEARANCES_M[2:]):
            for movers, lined_up in self._choices():
                found = [
                    moves for each in clearances if (moves := self._moves(movers, each, lined_up=lined_up)) is not None
                ]
                if found:
                    return Plan(self._with_spare(min(found, key=len)))
        return None

    def _with_spare(self, moves: tuple[PlannedMove, ...]) -> tuple[PlannedMove, ...]:
        """The moves, the next with a place where its thing may lie if the arm can set it down nowhere else."""
        if not moves:
            return moves
        first, *rest = moves
        there = {move.object: self.present[move.object].moved(*move.place) for move in reversed(moves)}
        others = [*(each for name, each in self.present.items() if name != first.object), *there.values()]
        spot = free_spot(self.present[first.object], others, self.workspace, LEAST_M, self.avoided)
        return (replace(first, spare=Pose.of(spot) if spot is not None else None), *rest)

    # -- which things move ---------------------------------------------------------------------------------------------

    def _choices(self) -> Iterator[tuple[tuple[str, ...], bool]]:
        """Sets of things to move, the smallest first: those that must, with some of those that might.

        At last everything of the goal, what is left of another in a line, and everything that there is.
        """
        must, might = self._must_move(), self._might_move()
        tried = set[tuple[str, ...]]()
        for more in self._additions([name for name in might if name not in must]):
            movers = self._with_riders({*must, *more})
            if movers not in tried and len(tried) < TRIED:
                tried.add(movers)
                yield movers, False
        wanted = self._with_riders({name for name in self.goal.things() if name in self.movable})
        if any(True for _ in self.goal.of_kind(LeftOf)):
            yield wanted, True
        yield wanted, False
        if len(wanted) < len(self.movable):
            yield tuple(self.movable), False

    def _additions(self, might: list[str]) -> Iterator[tuple[str, ...]]:
        sizes = range(len(might) + 1) if len(might) <= 4 else (0, 1)
        choices = [each for size in sizes for each in combinations(might, size)]
        for each in self.goal.of_kind(Grouped):
            choices.append(tuple(name for name in might if name not in self._largest_cluster(each.grouped)))
        if len(might) > 4:
            choices += combinations(might, len(might) - 1)
        return iter(sorted(choices, key=len))

    def _largest_cluster(self, names: tuple[str, ...]) -> set[str]:
        """The largest part of a group that is together already."""
        clusters = list[set[str]]()
        for name in names:
            near = [each for each in clusters if any(holds(Grouped((name, other)), self.scene) for other in each)]
            clusters = [each for each in clusters if each not in near] + [{name}.union(*near)]
        return max(clusters, key=len)

    def _must_move(self) -> set[str]:
        """What no plan can leave where it is."""
        found = set[str]()
        for each in self.goal.all:
            if isinstance(each, OnTop | AtPlace | InContainer) and holds(each, self.scene) is not True:
                found.add(each.things()[0])
        for column in columns(self.goal):
            members = [name for name in column if name != DESK]
            found.update(upper for upper, lower in self.below.items() if lower in members and upper not in members)
            carrier = self.below.get(members[0])
            if carrier is None or (carrier != DESK and self.present[carrier].type not in CONTAINERS):
                found.add(members[0])
        return found.intersection(self.movable)

    def _might_move(self) -> list[str]:
        """The movable things of the relations that do not hold, and what they are to carry."""
        names = [name for each in self.goal.all if holds(each, self.scene) is not True for name in each.things()]
        return [name for name in dict.fromkeys(names) if name in self.movable]

    def _with_riders(self, names: set[str]) -> tuple[str, ...]:
        """With everything that rests on them, and what is to be on them, in the order seen."""
        found = set(names)
        while True:
            more = {upper for upper, lower in self.below.items() if lower in found}
            more |= {each.on[0] for each in self.goal.of_kind(OnTop) if each.on[1] in found}
            if more <= found:
                return tuple(name for name in self.movable if name in found)
            found |= more

    # -- one set -------------------------------------------------------------------------------------------------------

    def _moves(self, movers: tuple[str, ...], clearance: float, *, lined_up: bool) -> tuple[PlannedMove, ...] | None:
        """The moves where just these may move, and what is in the way of a named place; None where there are none.

        What leaves a mover's fingers no room moves too, if it can; else the arm may push it free.
        """
        crowded: tuple[PlannedMove, ...] | None = None
        leaving = frozenset[str]()
        for _ in range(len(self.movable) + 1):
            budget = BUDGET_OF_LAST if lined_up or len(movers) == len(self.movable) else BUDGET
            budget = min(budget, self.left)
            placement = Placement(
                self.goal,
                self.scene,
                self.workspace,
                below=self.below,
                movers=movers,
                clearance=clearance,
                budget=budget,
                lined_up=lined_up,
                leaving=leaving,
                avoided=self.avoided,
            )
            is_found = placement.found()
            self.left -= budget - max(0, placement.left)
            if is_found:
                moves = self._ordered(placement, clearance)
                if crowded is not None or moves is None:
                    return moves if moves is not None else crowded
                leaving = frozenset(self._crowding(tuple(move.object for move in moves))) - {*movers}
                if not leaving:
                    return moves
                crowded, movers = moves, self._with_riders({*movers, *leaving})
                continue
            wider = self._with_riders({*movers, *(each for each in placement.blockers if each in self.movable)})
            if wider == movers:
                return crowded
            movers = wider
        return crowded

    def _ordered(self, placement: Placement, clearance: float) -> tuple[PlannedMove, ...] | None:
        orders = (
            Ordering(
                self.present,
                self.below,
                placement.final,
                placement.below,
                names=self._first(placement.order),
                reasons=self._reasons(placement),
                workspace=self.workspace,
                clearance=each,
                careful=careful,
                avoided=self.avoided,
            ).moves()
            for careful in (True, False)
            for each in (clearance, LEAST_M)
        )
        return next((moves for moves in orders if moves is not None), None)

    def _crowding(self, movers: tuple[str, ...]) -> Iterator[str]:
        """Movable things that leave the fingers no room at one of the movers, which can be taken in no direction."""
        around = [*self.present.values()]
        for name in movers:
            found = [other.name for other in least_crowding(self.present[name], around)]
            if all(each in self.movable for each in found):
                yield from found

    def _first(self, order: list[str]) -> list[str]:
        """What only makes room comes first, then all in the order placed."""
        wanted = self.goal.things()
        return sorted(order, key=lambda name: name in wanted)

    def _reasons(self, placement: Placement) -> dict[str, str]:
        """Name → what its move is for."""
        found = {name: f"{name} makes room: it is in the way" for name in placement.order}
        words = {"on": "on {}", "in": "in {}", "at": "at its place", "left_of": "to a side of {}",
                 "behind": "to a side of {}", "between": "in line with {}", "next_to": "next to {}",
                 "grouped": "close to {}", "apart": "away from {}"}  # fmt: skip
        for each in reversed(self.goal.all):
            for name in each.things():
                others = [other for other in each.things() if other != name]
                is_mover = name == each.things()[0] or not isinstance(each, OnTop | InContainer)
                if name in found and is_mover:
                    found[name] = f"{name} is wanted {words[each.word].format(' and '.join(others))}"
        return found
