# SPDX-License-Identifier: Apache-2.0
"""What cannot be, by rule: each refusal has a code and a sentence, before anything moves.

Rule: a rule refuses only what no arrangement could meet. Whether there is room is found out by the planner.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from typing import Any

from rai_missions.planning.geometry import gap
from rai_missions.planning.goal import (
    Apart,
    AtPlace,
    Behind,
    Between,
    Goal,
    Grouped,
    InContainer,
    LeftOf,
    NextTo,
    OnTop,
    Refusal,
    Shifted,
    Swapped,
)
from rai_missions.planning.relations import downward, holds, inner
from rai_missions.planning.scene import CONTAINERS, DESK, ROUND, Scene, Thing
from rai_missions.planning.sentences import ENGLISH, refusal_sentence
from rai_missions.planning.tolerances import AT, JUDGE, contact
from rai_missions.planning.workspace import Workspace

__all__ = ("REASONS", "column_of", "refused_by_rule")

HIGHEST = 6
"""Things on each other at the most."""
FLOOR_M = -0.05
"""What is lower is not on the desk."""

REASONS: Mapping[str, str] = {
    "absent": "a thing that is not seen",
    "unclear": "a thing that was not looked at often or closely enough",
    "swap": "a swap or a shift that was not rewritten to the poses first seen",
    "fallen": "a thing that lies on the floor",
    "no_container": "'in' something that holds nothing inside",
    "round": "on something that rolls",
    "no_support": "on something on which nothing is put",
    "not_moved": "a tray or a bin elsewhere",
    "too_big": "in something into which it does not fit",
    "too_wide": "wider than the gripper opens",
    "off_desk": "coordinates off the desk",
    "out_of_reach": "coordinates, or a thing, that the arm does not reach",
    "two_places": "one thing at two places",
    "same_place": "two things at one place",
    "contradiction": "relations that exclude each other",
    "cycle": "a circle of 'on', of 'left of' or of 'behind'",
    "too_many": "more things on or in one than fit",
    "too_high": "a stack of more than six",
    "no_room": "no arrangement found that leaves room for the fingers",
}
"""The code of each refusal → what it refuses."""


def refused_by_rule(goal: Goal, scene: Scene, workspace: Workspace, language: str = ENGLISH) -> Refusal | None:
    """Why a goal cannot be met, whatever is moved; None where no rule is against it."""
    for rule in RULES:
        for code, sentence, *values in rule(goal, scene, workspace):
            return Refusal(code, refusal_sentence(sentence, tuple(values), language=language))
    return None


Found = Iterator[tuple[Any, ...]]
"""The code of a refusal, the name of its sentence, and what fills that in."""


def column_of(goal: Goal, name: str) -> tuple[str, ...]:
    """The things below one by what is wanted, itself first, the desk not counted; it ends where a circle closes."""
    return tuple(downward(name, {each.on[0]: each.on[1] for each in goal.of_kind(OnTop) if each.on[1] != DESK}))


def _seen(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for name in goal.things():
        thing = scene.get(name)
        if thing is None:
            yield "absent", "absent", name
        elif thing.bottom < FLOOR_M:
            yield "fallen", "fallen", name
        elif not thing.is_certain or 3 * thing.sigma_m > contact(thing):
            yield "unclear", "unclear", name
    for swap in goal.of_kind(Swapped):
        yield "swap", "swap", *swap.swapped
    for shift in goal.of_kind(Shifted):
        yield "swap", "shift", shift.shifted


def _containers(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for each in goal.of_kind(InContainer):
        name, holder = each.in_
        thing, container = scene.thing(name), scene.thing(holder)
        if container.type not in CONTAINERS:
            yield "no_container", "no_container", holder
        elif thing.type in CONTAINERS:
            yield "not_moved", thing.type, name
        else:
            space = sorted(inner(container).size[:2])
            if any(side > room for side, room in zip(sorted(thing.size[:2]), space, strict=True)):
                yield "too_big", "too_big", name, holder


def _supports(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for each in goal.of_kind(OnTop):
        upper, lower = scene.thing(each.on[0]), scene.get(each.on[1])
        if lower is None:
            continue
        if lower.type in ROUND:
            yield "round", f"tower_{lower.type}" if upper.type == lower.type else "round", lower.name
        elif lower.type in CONTAINERS:
            yield "no_support", "no_support", lower.name
        elif upper.type in CONTAINERS:
            yield "not_moved", upper.type, upper.name


def _immovable(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for each in goal.all:
        things = [scene.thing(name) for name in each.things() if name != DESK]
        if all(thing.type in CONTAINERS for thing in things) and not holds(each, _still(scene)):
            yield "not_moved", things[0].type, things[0].name


def _still(scene: Scene) -> Scene:
    things = tuple(thing.model_copy(update={"at_rest": True}) for thing in scene.things)
    return scene.model_copy(update={"things": things})


def _places(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for each in goal.of_kind(AtPlace):
        thing = scene.thing(each.at)
        if not workspace.carries(thing.moved(each.x, each.y, thing.z).footprint):
            yield "off_desk", "off_desk", each.at, each.x, each.y
        elif not workspace.reaches(each.x, each.y):
            yield "out_of_reach", "place_out_of_reach", each.at, each.x, each.y


def _graspable(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    """Things that must move, since a relation that only they can meet does not hold."""
    still = _still(scene)
    for each in goal.all:
        if isinstance(each, OnTop | AtPlace | InContainer) and not holds(each, still):
            thing = scene.thing(each.things()[0])
            if not workspace.reaches(thing.x, thing.y):
                yield "out_of_reach", "out_of_reach", thing.name
            elif min(thing.size[:2]) > workspace.opening_m:
                yield "too_wide", "too_wide", thing.name


def _two_places(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    carriers: dict[str, str] = {}
    for each in goal.of_kind(OnTop, InContainer):
        name, below = each.things()
        if carriers.setdefault(name, below) != below:
            yield "two_places", "two_carriers", name, carriers[name], below
    for one, other in combinations(goal.of_kind(AtPlace), 2):
        off = math.dist((one.x, one.y), (other.x, other.y))
        if one.at == other.at and off > AT:
            yield "two_places", "two_places", one.at, one.x, one.y, other.x, other.y
        elif one.at != other.at and _in_one_column(goal, one.at, other.at):
            if off > AT:
                yield "two_places", "column_at_two_places", one.at, other.at
        elif one.at != other.at and gap(_there(one, scene).footprint, _there(other, scene).footprint) < -AT:
            yield "same_place", "same_place", one.at, other.at


def _there(each: AtPlace, scene: Scene) -> Thing:
    thing = scene.thing(each.at)
    return thing.moved(each.x, each.y, thing.size[2] / 2)


def _in_one_column(goal: Goal, one: str, other: str) -> bool:
    return one in column_of(goal, other) or other in column_of(goal, one)


def _contradictions(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    close = [each.next_to for each in goal.of_kind(NextTo)]
    close += [pair for each in goal.of_kind(Grouped) if len(pair := each.grouped) == 2]
    for each in goal.of_kind(Apart):
        for pair in combinations(each.apart, 2):
            if any(set(pair) == set(other) for other in close):
                yield "contradiction", "close_and_apart", *pair
            elif _in_one_column(goal, *pair):
                yield "contradiction", "column_and_apart", *pair
    raised = {each.things()[0] for each in goal.of_kind(OnTop, InContainer) if each.things()[1] != DESK}
    places = {each.at: _there(each, scene) for each in goal.of_kind(AtPlace) if each.at not in raised}
    there = _still(scene.model_copy(update={"things": tuple(places.get(each.name, each) for each in scene.things)}))
    for relation in goal.of_kind(LeftOf, Behind, Between, NextTo, Apart, Grouped):
        if all(name in places for name in relation.things()) and holds(relation, there, JUDGE) is False:
            yield "contradiction", f"not_{relation.word}", ", ".join(relation.things())
    for side in goal.of_kind(LeftOf, Behind, Between, NextTo):
        for pair in combinations(side.things(), 2):
            if _in_one_column(goal, *pair):
                yield "contradiction", "on_and_next_to", *pair


def _cycles(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    edges = {
        "cycle_on": [each.on for each in goal.of_kind(OnTop)],
        "cycle_left_of": [each.left_of for each in goal.of_kind(LeftOf)],
        "cycle_behind": [each.behind for each in goal.of_kind(Behind)],
    }
    for sentence, pairs in edges.items():
        for start, _ in pairs:
            reachable, found = {start}, set[str]()
            while reachable:
                reachable = {after for before, after in pairs if before in reachable} - found
                found |= reachable
            if start in found:
                yield "cycle", sentence, start


def _crowded(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    uppers: dict[str, list[str]] = {}
    for each in goal.of_kind(OnTop):
        if each.on[1] != DESK and each.on[0] not in (known := uppers.setdefault(each.on[1], [])):
            known.append(each.on[0])
    for lower, names in uppers.items():
        if len(names) > 1:
            yield "too_many", "one_fits", lower, len(names)
    holders: dict[str, set[str]] = {}
    for each in goal.of_kind(InContainer):
        holders.setdefault(each.in_[1], set()).add(column_of(goal, each.in_[0])[-1])
    for holder, inside in holders.items():
        room = math.prod(inner(scene.thing(holder)).size[:2])
        if sum(math.prod(scene.thing(name).size[:2]) for name in inside) > room:
            yield "too_many", "too_many", holder, len(inside)


def _heights(goal: Goal, scene: Scene, workspace: Workspace) -> Found:
    for each in goal.of_kind(OnTop):
        if len(column_of(goal, each.on[0])) > HIGHEST:
            yield "too_high", "too_high", HIGHEST


Rule = Callable[[Goal, Scene, Workspace], Found]
RULES: tuple[Rule, ...] = (
    _seen,
    _containers,
    _supports,
    _cycles,
    _two_places,
    _crowded,
    _heights,
    _contradictions,
    _places,
    _immovable,
    _graspable,
)
"""In this order, so that each may rely on those before it."""
