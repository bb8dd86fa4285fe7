# SPDX-License-Identifier: Apache-2.0
"""The values of each key that a mission's guards can distinguish, a few for all.

Rule: two values that every guard treats alike represent one another; unknown is a value wherever it can come about.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from itertools import chain, islice, pairwise, product
from typing import Any

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.guards.compare import OPERATORS, truth
from rai_missions.guards.near import distance
from rai_missions.guards.view import Truth
from rai_missions.image import Image
from rai_missions.keys import Key, type_error
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import is_number
from rai_missions.planning.examples import GOALS
from rai_missions.prove.analysis.comparisons import NUMBERS, Comparisons
from rai_missions.prove.analysis.goals import NO_GOAL, first_of_each, requests, sights
from rai_missions.prove.analysis.parts import parts
from rai_missions.prove.analysis.spots import Spots
from rai_missions.states.effects import Raise, references

__all__ = ("SCALARS", "Values")

OTHER = "something else"
FAR_M = 1e6
PICTURE = Image("any", 1, 1, "rgb8", b"\0\0\0")
SAMPLES = range(4)
MOST_MIXTURES = 1_000
"""An object that can be more is asked field by field."""
SCALARS = ("boolean", "number", "integer", "string")


class Values:
    """What a key may hold, in an event's payload, in an answer.

    Args:
        mission: Whose guards distinguish values.
        terms: The guards of a robot's composed actions count too.
    """

    def __init__(self, mission: Mission, terms: RobotFacts) -> None:
        self._keys = mission.blackboard
        self.learned = Comparisons(mission, terms)
        self._known: dict[str, tuple[Any, ...]] = {}

    # -- what is asked --------------------------------------------------------------------------------------------

    def of(self, key: str) -> tuple[Any, ...]:
        """The values that represent all that a key can hold; None, unknown, comes first where it can be."""
        if key not in self._known:
            known = tuple(self._made(key, self._keys[key].type))
            self._known[key] = (None, *known) if self.can_lack(key) else known
        return self._known[key]

    def can_lack(self, key: str) -> bool:
        """Whether a key can be unknown."""
        written = self._keys[key]
        robot = written.source == "robot" and not written.optional
        given = written.source == "argument" and (written.initial is not None or not written.optional)
        return written.max_age_s is not None or not (robot or given)

    def narrow(self, key: str, is_possible: Callable[[Any], bool]) -> None:
        """Leave values of a key out."""
        self._known[key] = tuple(value for value in self.of(key) if is_possible(value)) or self.of(key)

    def field(self, path: str, kind: str = "") -> tuple[Any, ...]:
        """The values of an event's field or an answer's parameter: `event.kind`, `answer.speed`; None first."""
        place = f"?{kind}{path}"
        if place not in self._known:
            deep = "pose" if self.learned.is_pose(path) else "object" if self.learned.within(path) else ""
            kinds = [deep or kind] if deep or kind else self.learned.kinds_of(path)
            self._known[place] = (None, *(value for each in kinds for value in self._made(path, each)))
        return self._known[place]

    def fields(self, root: str) -> tuple[str, ...]:
        """The fields of events (`event`) or answers (`answer`) that guards and effects look at."""
        return tuple(self.learned.within(root))

    def shape(self, key: str) -> tuple[str, ...]:
        """The fields of an object that guards look at, one by one; none for what is looked at as a whole."""
        learned = self.learned
        if self._keys[key].type != "object" or learned.atoms.get(key):
            return ()
        if learned.is_goal(key) or learned.asked_of_goals(key):
            return ()
        fields = learned.within(key)
        return () if any(learned.within(f"{key}.{field}") for field in fields) else tuple(fields)

    def is_sight(self, key: str) -> bool:
        """Whether guards look at its fields, or judge goals by it, and nothing else is done with it as a whole."""
        learned = self.learned
        is_alone = len(learned.kin_of(key)) == 1 and not learned.atoms.get(key)
        if self.shape(key):
            return is_alone and len(self.of(key)) <= MOST_MIXTURES
        if self._keys[key].type != "object" or not learned.asked_of_goals(key) or learned.is_goal(key):
            return False
        fields = learned.within(key)
        return is_alone and "things" not in fields and not any(learned.within(f"{key}.{each}") for each in fields)

    def part(self, key: str, field: str) -> tuple[Any, ...]:
        """The values of an object's field; None first: it may be left out."""
        return self.field(f"{key}.{field}", (self._keys[key].fields or {}).get(field, ""))

    def item(self, path: str) -> tuple[Any, ...]:
        """The values of an item of a list, for all who go over it or a copy of it."""
        if (place := f"[]{path}") in self._known:
            return self._known[place]
        learned, found = self.learned, list[Any]()
        for kin in sorted(learned.kin_of(path)):
            for item in learned.items.get(kin, ()):
                found += [value for value in self._made(item, self._keys[item].type) if value not in found]
        self._known[place] = tuple(found) or (0,)
        return self._known[place]

    def saturating(self) -> Mapping[str, tuple[float, float]]:
        """Counters that only grow, or only shrink → the bounds past which no guard distinguishes their values.

        A copy of one that grows can shrink from beyond the bounds, and then its value makes a difference.
        """
        learned, found = self.learned, {}
        for key in learned.steps.keys() & learned.atoms.keys():
            steps = [each for kin in learned.kin_of(key) for each in learned.steps.get(kin, ())]
            linked = len(learned.kin_of(key)) > 1
            high = [_past(op, each, 1) for op, each in learned.constants(key) if isinstance(each, int | float)]
            low = [_past(op, each, -1) for op, each in learned.constants(key) if isinstance(each, int | float)]
            if linked:
                known = [each for each in learned.operands(key) if isinstance(each, int | float)]
                tried = {*SAMPLES, *_next_to([*known, *self._bounds(learned.kin_of(key))])}
                high, low = [*high, max(tried) + 1], [*low, min(tried) - 1]
            if high and min(steps) > 0:
                found[key] = (-math.inf, max(high))
            elif low and max(steps) < 0:
                found[key] = (min(low), math.inf)
        return found

    def counters(self) -> frozenset[str]:
        """Whole numbers to which whole numbers are added."""
        steps = self.learned.steps.items()
        return frozenset(
            key
            for key, added in steps
            if self._keys[key].type == "integer" and all(float(each).is_integer() for each in added)
        )

    def classes(self, mission: Mission) -> Mapping[str, Callable[[Any], Any]]:
        """Scalar keys that are only compared with constants → all that a rule can find out of a value."""
        learned = self.learned
        quoted = {path.split(".")[0] for each in parts(mission, Raise) for path in references(each.data)}
        quoted |= {path.split(".")[0] for path in (*learned.items, *learned.near, *learned.judged, *learned.judging)}
        return {
            key: partial(_found_out, tuple(learned.atoms.get(key, ())))
            for key, written in self._keys.items()
            if written.type in SCALARS
            and len(learned.kin_of(key)) < 2
            and not learned.within(key)
            and key not in quoted
            and not learned.is_sampled(key)
        }

    # -- how they are made ----------------------------------------------------------------------------------------

    def _made(self, path: str, kind: str) -> Iterator[Any]:
        key = self._keys.get(path)
        if kind == "image":
            yield PICTURE
        elif kind == "pose" or self.learned.is_pose(path):
            yield from self._poses(path, key)
        elif kind == "list":
            yield from self._lists(path)
        elif kind == "object":
            yield from self._objects(path, key)
        else:
            yield from self._scalars(path, kind)

    def _lists(self, path: str) -> Iterator[list[Any]]:
        """Lists of no, one or two items; of at most one where nothing goes through the list."""
        learned = self.learned
        most = 2 if any(kin in learned.items for kin in learned.kin_of(path)) else 1
        for many in range(most + 1):
            yield from (list(mixture) for mixture in product(self.item(path), repeat=many))

    def _poses(self, path: str, key: Key | None) -> Iterator[Any]:
        """One in each ring that guards distinguish around what it may be compared with, and one far from all."""
        learned = self.learned
        frames = sorted(learned.frames(path))
        frame = {"frame": frames[0]} if frames else {}
        if places := learned.places(path):
            yield from places.poses(path, frame)
            return
        fixed = [each for each in learned.operands(path) if isinstance(each, Mapping)]
        bases = fixed or [{"x": 0.0, "y": 0.0, **frame}]
        radii = sorted({radius for kin in learned.kin_of(path) for radius in learned.near.get(kin, ())})
        if radii and key is not None and not key.frame:
            yield {"x": 0.0, "y": 0.0, "frame": OTHER}  # it is in no frame of the mission: no distance is known
        offsets = [0.0, *((low + high) / 2 for low, high in pairwise(radii))]
        offsets += [FAR_M] if radii else []
        if self._is_met(path):
            offsets = [0.0]
        found = [
            {**base, "x": base.get("x", 0.0) + offset} if offset else dict(base)
            for base, offset in product(bases, offsets)
        ]
        if looked := learned.within(path):
            for pose in found:
                yield from self._looked_into(path, looked, pose)
        else:
            is_of_written = set(self._others(path)) == {"mission"}  # compared with constants alone
            yield from _distinct(found, bases, radii) if is_of_written else found

    def _looked_into(self, path: str, looked: list[str], pose: Mapping[str, Any]) -> Iterator[Any]:
        """A pose with each mixture of the fields that guards look at one by one; it has an x and a y."""
        choices = []
        for name in looked:
            own = [pose[name]] if name in pose else []
            if name != "frame" or not own:
                more = self.field(f"{path}.{name}", "string" if name == "frame" else "number")[name in ("x", "y") :]
                own += [each for each in more if each not in own]
            choices.append(own)
        for mixture in product(*choices):
            fields = {**pose, **dict(zip(looked, mixture, strict=True))}
            yield {name: value for name, value in fields.items() if value is not None}

    def _is_met(self, path: str) -> bool:
        """Whether a path is compared with one pose that the robot reports, which can be near or far from any pose."""
        robots = path in self._keys and self._keys[path].source == "robot"
        return self._others(path) == ["robot"] and not robots

    def _others(self, path: str) -> list[str]:
        """The sources of what it is compared with; empty for what is no key."""
        others = self.learned.kin_of(path) - {path}
        return [self._keys[each].source if each in self._keys else "" for each in others]

    def _objects(self, path: str, key: Key | None) -> Iterator[Any]:
        """Each mixture of what its fields can be, as far as anybody looks into them."""
        looked = self.learned.within(path)
        kinds = (key.fields or {}) if key is not None else {}
        choices = [self.field(f"{path}.{name}", kinds.get(name, "")) for name in looked]
        for whole in self._wholes(path):
            left = {name: value for name, value in whole.items() if name not in looked}
            own = [((whole[name],) if name in whole else ()) for name in looked]
            each = [[*some, *(one for one in more if one not in some)] for some, more in zip(choices, own, strict=True)]
            for mixture in product(*each):
                yield left | {name: value for name, value in zip(looked, mixture, strict=True) if value is not None}

    def _wholes(self, path: str) -> Sequence[Mapping[str, Any]]:
        """What is judged as a whole: goals, or what can be seen; for any other object one that has nothing in it."""
        if self.learned.is_goal(path):
            return (NO_GOAL, *self._goals)
        aspects = self.learned.asked_of_goals(path)
        return sights(self._goals, aspects) if aspects else ({},)

    @cached_property
    def _goals(self) -> Sequence[Mapping[str, Any]]:
        """Two, or one where it stays."""
        return GOALS if self.learned.goals_change else GOALS[:1]

    def _scalars(self, path: str, kind: str) -> Iterator[Any]:
        """The scalars of a path's type that its key takes."""
        return self._fitting(path, self._of_type(path, kind))

    def _fitting(self, path: str, values: Iterable[Any]) -> Iterator[Any]:
        key = self._keys.get(path)
        return (each for each in values if key is None or not type_error(key, each))

    def _of_type(self, path: str, kind: str) -> Iterator[Any]:
        learned = self.learned
        if "said" in learned.asked_of_goals(path) and kind == "string":
            yield from sorted({*requests(self._goals), *(e for e in learned.operands(path) if isinstance(e, str))})
        elif not learned.is_asked(path) or (not learned.atoms.get(path) and path not in learned.kin):
            plain = {"boolean": True, "string": OTHER, "number": 0.0, "integer": 0}.get(kind, OTHER)
            bounds = self._bounds([path])
            within = [*bounds, *map(math.ceil, bounds), *map(math.floor, bounds), *self._listed([path], []), plain]
            yield from islice(self._fitting(path, within), 1)
        elif kind == "boolean":
            yield from (False, True)
        elif kind in NUMBERS:
            whole = kind == "integer"
            for each in self._numbers(path, whole=whole):
                if not whole or each == int(each):
                    yield int(each) if whole else each
        else:
            others = len(learned.kin_of(path))
            known = sorted({each for each in learned.operands(path) if isinstance(each, str)})
            known += self._listed(learned.kin_of(path), known)
            known += [f"{OTHER} {number}" if number else OTHER for number in range(others)]
            yield from known if others > 1 or learned.is_sampled(path) else self._apart(path, known)

    def _bounds(self, kin: Iterable[str]) -> list[float]:
        """Where the ranges of these keys end."""
        ranges = [self.learned.range_of([path]) for path in sorted(kin)]
        return [each for ends in ranges for each in ends if math.isfinite(each)]

    def _listed(self, kin: Collection[str], known: Collection[str]) -> list[str]:
        """What these keys list besides what is known: of one list as many values as can all differ."""
        lists = {key.enum for path in kin if (key := self._keys.get(path)) is not None and key.enum is not None}
        others = sorted({each for listed in lists for each in listed if each not in known})
        return others[: len(kin)] if len(lists) == 1 else others

    def _numbers(self, path: str, *, whole: bool) -> Iterable[float]:
        """Every constant that it or its kin is compared with, and enough numbers between them to order the kin."""
        learned = self.learned
        kin = learned.kin_of(path)
        operands = {*filter(is_number, learned.operands(path))}
        constants = operands | {*self._bounds(kin)}
        if learned.is_sampled(path):
            return sorted({*SAMPLES, *_next_to([*constants])})
        if len(kin) == 1:
            return self._apart(path, Spots(constants, 0, 1, whole).of(stays=False))
        if not any(one in kin for one, _, _ in learned.met):  # copied alone; one that counts has some way to go
            many = 1 if learned.steps.keys().isdisjoint(kin) else len(kin)
            return Spots(constants, 0, many, self._is_whole(kin)).of(stays=False)
        return self._met(path, kin, operands)

    def _met(self, path: str, kin: set[str], operands: Collection[float]) -> Iterable[float]:
        """Numbers for one that stays or moves; of numbers that are alike to all that stay, and to it, one."""
        learned = self.learned
        staying, met = learned.staying(kin), [each for each in learned.met if path in each]
        if path in staying or learned.moving_apart(kin) > 1 or not all(op for _, op, _ in met):
            return self._lies(kin, operands, stays=path in staying)
        fixed = [*self._lies(kin, operands, stays=True)]
        ways = [(op, one == path, each) for one, op, _ in met for each in fixed]

        def found_out(value: float) -> tuple[Any, ...]:
            pairs = ((op, (value, each) if is_left else (each, value)) for op, is_left, each in ways)
            return _found_out(learned.atoms.get(path, ()), value), *[_truth(op, *pair) for op, pair in pairs]

        return first_of_each(self._fitting(path, self._lies(kin, operands, stays=False)), found_out)

    def _lies(self, kin: set[str], operands: Collection[float], *, stays: bool) -> Iterable[float]:
        """The numbers of those that stay or move; the ends of ranges count where there is no room within them."""
        staying, moving = len(self.learned.staying(kin)), self.learned.moving_apart(kin)
        within, is_whole = self.learned.range_of(kin), self._is_whole(kin)
        if self.learned.is_matched(kin) and (free := within.wholes(len(kin) + len(operands))):
            others = [each for each in free if each not in operands]
            return [*sorted(operands), *others[: staying if stays else len(kin)]]
        spots = Spots(operands, staying, moving, is_whole)
        if self.learned.is_counted(kin):
            every = chain.from_iterable(self.learned.range_of([each]).every for each in kin)
            return spots._replace(constants={*operands, *every}).of(stays=stays)
        if staying == 1:
            return spots._replace(within=within).of(stays=stays)
        if not operands and (free := within.wholes((moving + 1) * (staying - 1) + 1)):
            return spots._replace(first=free[0] - moving).of(stays=stays)
        return spots._replace(constants={*operands, *self._bounds(kin)}).of(stays=stays)

    def _is_whole(self, kin: Iterable[str]) -> bool:
        """Some of these take whole numbers only."""
        return any(self.learned.kind_of(path) == "integer" for path in kin)

    def _apart(self, path: str, candidates: Iterable[Any]) -> Iterable[Any]:
        """The candidates that some guard treats otherwise than all before."""
        return first_of_each(self._fitting(path, candidates), partial(_found_out, self.learned.atoms.get(path, ())))


def _distinct(poses: list[Any], others: list[Any], radii: list[float]) -> list[Any]:
    """The poses without those that lie to each of the others as an earlier one does."""

    def lies(pose: Any) -> tuple[int | None, ...]:
        metres = [distance(pose, other) for other in others]
        return tuple([None if each is None else bisect_left(radii, each) for each in metres])

    return first_of_each(poses, lies)


def _found_out(atoms: Iterable[tuple[str, Any]], value: Any) -> tuple[Any, ...]:
    """What each comparison makes of a value, and whether there is one."""
    return (value is None, *[_truth(op, value, operand) for op, operand in atoms])


def _truth(op: str, left: Any, right: Any) -> Truth:
    return truth(OPERATORS[op].apply, left, right, equality=op in ("==", "!="))


def _past(op: str, operand: float, step: int) -> float:
    """The first number, going up or down by ones, from which on a comparison is the same for all."""
    at_once = ("<", ">=") if step > 0 else (">", "<=")
    return operand if op in at_once else operand + step


def _next_to(constants: list[Any]) -> set[float]:
    return {each + step for each in constants for step in (-1, 0, 1)}
