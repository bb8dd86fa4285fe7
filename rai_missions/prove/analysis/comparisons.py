# SPDX-License-Identifier: Apache-2.0
"""What a mission compares with what: all that its guards can distinguish.

Rule: where a few values cannot represent all, `sampled` names the path, and nothing is called proved.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property
from itertools import permutations
from typing import Any

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.trees.node import STATUSES
from rai_missions.guards.compare import OPERATORS, ORDERED
from rai_missions.keys import Key
from rai_missions.mission.mission import Mission
from rai_missions.model.references import reference_word
from rai_missions.prove.analysis.parts import guards_in, parts, writes_in
from rai_missions.prove.analysis.places import AXES, Places, are_apart
from rai_missions.prove.analysis.spots import NumberRange
from rai_missions.states.action import GoalFields
from rai_missions.states.call import CallFields
from rai_missions.states.compound import Each
from rai_missions.states.effects import Call, Raise, Set, references
from rai_missions.states.tree.decorators import StatusToBlackboard

__all__ = ("Comparisons",)

NUMBERS = ("number", "integer")
LITERAL = frozenset({*NUMBERS, "string", "boolean", "list"})
"""The types of which guards compare values with literals."""
FEW = 20
"""An argument of so many whole numbers is tried with each, where something is counted up to it."""
UNORDERED = OPERATORS.keys() - ORDERED
OWN = frozenset({"set", "add", "from", "status"})
"""How a mission itself writes a key."""
MIRRORED = {"==": "==", "!=": "!=", "<": ">", "<=": ">=", ">": "<", ">=": "<="}
"""Operator → the one that is true with its sides exchanged."""


class Comparisons:
    """Paths (`key`, `key.field`, `event.field`, `answer.name`) and what each is compared with.

    Args:
        mission: Whose guards distinguish values.
        terms: The guards of a robot's composed actions count too.
    """

    def __init__(self, mission: Mission, terms: RobotFacts) -> None:
        self.keys: Mapping[str, Key] = mission.blackboard
        self.declared: dict[str, list[str]] = {}
        """Field of events → its types; each event may have another."""
        for event in mission.events.values():
            for name, kind in event.fields.items():
                self.declared.setdefault(name, []).append(kind)
        self.atoms: dict[str, list[tuple[str, Any]]] = {}
        """Path → operator and operand of each comparison with constants."""
        self.kin: dict[str, set[str]] = {}
        """Path → its kin, of each that was ever joined with another; see `kin_of`."""
        self.near: dict[str, set[float]] = {}
        """Path of a pose → the distances that guards ask for."""
        self.judged: dict[str, set[str]] = {}
        """Path of a goal → the paths that it is judged by."""
        self.judging: dict[str, set[str]] = {}
        """Path of what is seen, or of a request → what is asked of goals by it."""
        self.fresh: set[str] = set()
        """Paths that guards ask for, whatever the value."""
        self.items: dict[str, list[str]] = {}
        """Path of a list → the keys that hold its current item, one for each state that goes over it."""
        for each in parts(mission, Each):
            self.items.setdefault(each.each, []).append(each.item)
            if "." in each.each:
                self.atoms.setdefault(each.each, [])
        self.steps: dict[str, set[float]] = {}
        """Key → what is added to it."""
        self.met: set[tuple[str, str, str]] = set()
        """Path, operator and path of each comparison of two; the operator is empty where it is not known."""
        self.measured: set[tuple[str, str]] = set()
        """The two paths of each distance that a guard asks for."""
        self._mission = mission
        self._own: list[tuple[str, Any]] = []
        """Paths, and what each can be by the mission's own doing."""
        self._brought_as: list[tuple[str, str]] = []
        """A path that an event, a result or an answer brings, and what it was taken from or is kept under."""
        self._copied: set[str] = set()
        """Keys that are set from another path."""
        self._sources: set[str] = set()
        """What they are set from."""
        self._odd: set[str] = set()
        """Paths of which a few values represent less than all, by how they are compared."""
        self._learn(mission, terms)

    def _learn(self, mission: Mission, terms: RobotFacts) -> None:
        """Look for all that the mission and the robot's composed actions compare, and for what it may be by then."""
        for guard in guards_in((mission, terms.succeeded, terms.failed)):
            guard.distinguish(self)
        for _, _, state in mission.walk():
            state.distinguish(self)
        self._asked = {*self.atoms, *self.near, *self.fresh}
        for effect in writes_in(mission):
            self._learn_write(effect)
        self._learn_sent(mission)
        for raised in parts(mission, Raise):
            for field, value in raised.data.items():
                self._learn_raised(f"event.{field}", value)
        for name, key in self.keys.items():
            if key.initial is not None and key.source == "mission":
                self._constant(name, key.initial)
        for node in parts(mission, StatusToBlackboard):
            for status in STATUSES.values():
                self._constant(node.key, status)
        self._learn_results(mission)
        while self._join_brought() or self._join_fields():
            pass
        self._learn_constants()

    def compare(self, path: str, op: str, operand: Any) -> None:
        self.atoms.setdefault(path, []).append((op, operand))
        constants = operand if OPERATORS[op].takes_list else [operand]
        if any(isinstance(each, dict | list) or (isinstance(each, str) and op in ORDERED) for each in constants):
            self._odd.add(path)

    def join(self, path: str, other: str, op: str = "") -> None:
        for here, there, word in ((path, other, op), (other, path, MIRRORED.get(op, ""))):
            if word and (self._lasting.get(there) == "list") is OPERATORS[word].takes_list and there in self._lasting:
                self.compare(here, word, self.keys[there].initial)
                return
        self.atoms.setdefault(path, [])
        self.atoms.setdefault(other, [])
        self._join(path, other)
        self.met.add((path, op, other))
        whole = op in ("==", "!=") and {"object", "pose"} & {
            self.keys[each].type for each in (path, other) if each in self.keys
        }
        self._odd |= {path} if op == "in" or whole else set()

    def measure(self, path: str, other: str, within_m: float) -> None:
        for each in (path, other):
            self.near.setdefault(each, set()).add(within_m)
        self.measured.add((path, other))
        self._join(path, other)

    def ask(self, path: str) -> None:
        self.fresh.add(path)

    def judge(self, path: str, by: str, aspect: str) -> None:
        self.judged.setdefault(path, set()).add(by)
        self.judging.setdefault(by, set()).add(aspect)
        for each in (path, by):
            self.atoms.setdefault(each, [])

    def sample(self, path: str) -> None:
        self.atoms.setdefault(path, [])
        self._odd.add(path)

    @cached_property
    def _lasting(self) -> Mapping[str, str]:
        """Scalars and lists that are what they were at the start, and their types: a comparison is with their value."""
        if self._mission.uses:  # a kind of another package may write in its own way
            return {}
        lasting = ((name, self.keys[name]) for name in self._mission.lasting_keys())
        return {name: key.type for name, key in lasting if key.source == "mission" and key.type in LITERAL}

    def _learn_write(self, effect: Set) -> None:
        if effect.add is not None:
            self.steps.setdefault(effect.set, set()).add(effect.add)
        elif effect.source is not None:
            self._join(effect.set, effect.source)
            self._copied.add(effect.set)
            self._sources.add(effect.source)
        else:
            self._constant(effect.set, effect.value)

    def _constant(self, path: str, value: Any) -> None:
        """Note a value that a path can have by the mission's own doing."""
        self._own.append((path, value))

    def _learn_constants(self) -> None:
        """Each is compared with what its path is, an item with what is in a list, a field with what is in an object.

        That is known only once all copies are, in whatever order the mission has them.
        """
        for path, value in self._own:  # grows by what is in lists and objects
            if path in self.kin:
                self.atoms.setdefault(path, []).append(("==", value))
            if isinstance(value, list):
                items = dict.fromkeys(item for kin in sorted(self.kin_of(path)) for item in self.items.get(kin, ()))
                self._own += [(item, each) for item in items for each in value]
            if isinstance(value, Mapping):
                self._own += [(f"{path}.{field}", inner) for field, inner in value.items()]

    def _learn_sent(self, mission: Mission) -> None:
        """A field that a goal or a request is sent with: without it the start is rejected, or the call has failed."""
        sent: list[Any] = [each.goal for each in parts(mission, GoalFields)]
        sent += [each.request for kind in (CallFields, Call) for each in parts(mission, kind)]
        self.fresh |= {path for path in references(sent) if path.partition(".")[0] in self.keys and "." in path}

    def _learn_raised(self, path: str, value: Any) -> None:
        """What a raised event brings is what it was taken from, or as it was written."""
        found = list(references(value))
        self._brought_as += [(path, each) for each in found]
        if not found:
            self._constant(path, value)
        elif isinstance(value, Mapping) and reference_word(value) is None:
            for field, inner in value.items():
                self._learn_raised(f"{path}.{field}", inner)

    def _learn_results(self, mission: Mission) -> None:
        """A field of a result, and a parameter of an answer, may be read as such and kept under keys as well."""
        kept: dict[str, set[str]] = {
            f"answer.{name}": {name} for name, key in self.keys.items() if key.source == "answer"
        }
        for each in (*parts(mission, GoalFields), *parts(mission, CallFields)):
            for key, field in each.result.items():
                kept.setdefault(f"event.{field}", set()).add(key)
        for path, keys in kept.items():
            self._brought_as += [(path, key) for key in keys] + [*permutations(keys, 2)]

    def _join_brought(self) -> bool:
        """What anybody looks at is compared for all that it is, or is kept under; whether anything was joined."""
        met = {each for each in self._brought_as if self._is_looked_at(each[0])}
        self._brought_as = [each for each in self._brought_as if each not in met]
        for path, other in met:
            self._join(path, other)
        return bool(met)

    def _is_looked_at(self, path: str) -> bool:
        """Whether a guard or a copy names it, or a part of it."""
        found = (self.atoms, self.near, self.kin, self.fresh)
        return any(path in each for each in found) or bool(self.within(path))

    def _join(self, one: str, other: str) -> None:
        kin = self.kin_of(one) | self.kin_of(other)
        for each in kin:
            self.kin[each] = kin

    def kin_of(self, path: str) -> set[str]:
        """The paths that one is compared with or copied to, itself among them."""
        return self.kin.get(path, {path})

    def _join_fields(self) -> bool:
        """Objects that are copied are kin field by field, as far as anybody looks; whether anything was joined.

        What is copied out of itself, `set node from node.next`, is tried with some values: it may be so for ever.
        """
        asked = set(filter(self.is_asked, self.kin))
        below: dict[str, set[str]] = {}
        for path in {*self.atoms, *self.near, *self.fresh, *asked}:
            for at in _dots(path):
                below.setdefault(path[:at], set()).add(path[at:])
        endless = {path for path in asked if any(path[:at] in self.kin[path] for at in _dots(path))}
        self._odd |= endless
        found = {
            (one + inner, other + inner)
            for one in self.kin
            for inner in below.get(one, ())
            if endless.isdisjoint(self.kin[one])
            for other in self.kin[one]
            if other + inner not in self.kin_of(one + inner)
        }
        for one, other in found:
            self.atoms.setdefault(one, [])
            self.atoms.setdefault(other, [])
            self._join(one, other)
        for paths in (self._copied, self._sources):  # a part of a copy is one
            paths |= {path for path in self.kin if any(path[:at] in paths for at in _dots(path))}
        return bool(found)

    # -- what moves ------------------------------------------------------------------------------------------------

    def staying(self, kin: Collection[str]) -> frozenset[str]:
        """The paths of its kin around which the others lie: arguments, or one of two, where the other moves by itself.

        Of two that are reported the other can come to the same side of it in a report of its own, and what an event
        brings to any side. What an item or a result brings comes in a step in which rules look at both: before it, no
        reading moves past it unnoticed.
        """
        reported = sorted((each for each in kin if self._source(each) in ("robot", "")), key=self._by_source)
        if len(kin) == 2 and reported and (len(reported) == 2 or not self._source(reported[0])):
            return frozenset(each for each in kin if each != reported[0] and not self._is_written(each))
        return frozenset(each for each in kin if self._source(each) == "argument")

    def moving_apart(self, kin: Collection[str]) -> int:
        """How many of those that move are compared with each other; one where none is."""
        return len({each for one, _, other in self._met_moving(kin) for each in (one, other)}) or 1

    def range_of(self, kin: Iterable[str]) -> NumberRange:
        """In which all of these keys may lie."""
        keys = [key for path in kin if (key := self.keys.get(path)) is not None]
        low = max((each.minimum for each in keys if each.minimum is not None), default=-math.inf)
        return NumberRange(low, min((each.maximum for each in keys if each.maximum is not None), default=math.inf))

    def is_matched(self, kin: Collection[str]) -> bool:
        """Whether these numbers are compared to be equal or not alone: their order makes no difference."""
        ops = {op for path in kin for op, _ in self.atoms.get(path, ())}
        ops |= {op for one, op, _ in self.met if one in kin}
        return ops <= UNORDERED and self.steps.keys().isdisjoint(kin)

    def _met_moving(self, kin: Collection[str]) -> list[tuple[str, str, str]]:
        """The comparisons of two that move."""
        stay = self.staying(kin)
        moving = {each for each in kin if each not in stay and not self._is_written(each)}
        return [(one, op, other) for one, op, other in self.met if one in moving and other in moving]

    def _source(self, path: str) -> str:
        """The source of the key; empty for what an event or an answer brings, which is there for a step only."""
        root = path.partition(".")[0]
        return self.keys[root].source if root in self.keys else ""

    def _by_source(self, path: str) -> tuple[str, str]:
        return self._source(path), path

    def _is_written(self, path: str) -> bool:
        """Whether the mission gives constants alone to the key."""
        return path.partition(".")[0] in self._written

    @cached_property
    def _written(self) -> frozenset[str]:
        """Keys to which the mission gives constants alone."""
        others = self._brought | self._copied | self.steps.keys()
        return frozenset(name for name, key in self.keys.items() if key.source == "mission" and name not in others)

    def _crowded(self) -> Iterator[str]:
        """What moves, and is compared by its order with what moves as well; and words that are compared by theirs."""
        for kin in {frozenset(self.kin_of(path)) for one, _, other in self.met for path in (one, other)}:
            moving = {op for _, op, _ in self._met_moving(kin)}
            words = {
                op for one, op, _ in self.met if one in kin and one in self.keys and self.keys[one].type == "string"
            }
            if not moving | words <= UNORDERED:
                yield from kin

    # -- what came of it ------------------------------------------------------------------------------------------

    @property
    def compared(self) -> frozenset[str]:
        """The keys that any guard looks into, and what they are copied from and to."""
        found = (*self.atoms, *self.near, *self.kin, *self.fresh)
        return frozenset(path.split(".")[0] for path in found if self.is_asked(path))

    def is_asked(self, path: str) -> bool:
        """Whether any guard looks at the value there, at a part of it or at one that it is copied to.

        What no guard looks at, however often it is copied, makes no step another: one value represents all.
        """
        kin = self.kin_of(path)
        return any(each in kin or each.partition(".")[0] in kin for each in self._asked | self.fresh)

    @property
    def gone_over(self) -> frozenset[str]:
        """The keys of lists that some state goes over."""
        return frozenset(path.split(".")[0] for path in self.items)

    @cached_property
    def sampled(self) -> tuple[str, ...]:
        """The paths that a few values are tried of, though guards can distinguish more."""
        return tuple(
            sorted(
                {
                    *self._odd,
                    *self._reckoned(),
                    *self._crowded(),
                    *self._far(),
                    *self._looked_into(),
                    *self._wanted(),
                }
            )
        )

    def _reckoned(self) -> Iterator[str]:
        """Numbers that are compared with a key that is counted or copied, and those that are counted from what is free.

        How often a number has to be counted until it is equal to a constant is another question for each number.
        """
        yield from (key for key in self.steps if key in self._free)
        for path in {each for one, _, other in self.met for each in (one, other)}:
            kin = self.kin_of(path)
            is_reckoned = kin & (self.steps.keys() | self._copied) and self.kind_of(path) not in ("boolean", "string")
            if is_reckoned and not self.is_counted(kin):
                yield path

    def is_counted(self, kin: Collection[str]) -> bool:
        """Whether they are whole numbers that are counted, and arguments of so few numbers that each is tried."""
        given = {each for each in kin if self._source(each) == "argument"}
        counted = set(kin) - given - self._written
        kinds = {self.keys[each].type if each in self.keys else "" for each in kin}
        steps = [step for each in counted for step in self.steps.get(each, (math.inf,))]
        return (
            bool(counted)
            and kinds == {"integer"}
            and all(step.is_integer() for step in map(float, steps))
            and counted.isdisjoint(self._copied | self._brought)
            and all(0 < len(self.range_of([each]).every) <= FEW for each in given)
            and not self._met_moving(kin)
        )

    def _far(self) -> Iterator[str]:
        for kin in {frozenset(self.kin_of(path)) for path in self.near}:
            is_copied = not kin.isdisjoint(self._copied)
            odd = [path for path in kin & self.near.keys() if len(kin) > 2 or (is_copied and len(self.near[path]) > 1)]
            if odd and not self.places(odd[0]) and not self._is_among_constants(odd[0]):
                yield from odd

    def places(self, path: str) -> Places | None:
        """The places among which it is, or that it is one of; None where these do not represent all."""
        kin, reading = self.kin_of(path), self._reading_of(path)
        given = sorted(each for each in kin if reading and self.keys[each].source == "argument")
        is_bare = not any(self.atoms.get(each) or self.within(each) for each in kin)
        if reading is None or not 0 < len(given) <= len(AXES) or not is_bare:
            return None
        if any(self.keys[each].source == "answer" for each in kin):
            return None
        radii = {each: self.near.get(each) or self._radii(path) for each in given}
        if any(len(found) > 1 for found in radii.values()):
            return None
        return Places(reading, {each: min(found) for each, found in radii.items()})

    def _is_among_constants(self, path: str) -> bool:
        """Whether a path is a reading among poses that the mission wrote, which lie apart, or one of these poses."""
        reading = self._reading_of(path)
        sources = {self.keys[each].source for each in self.kin_of(path) if reading and each != reading}
        return sources == {"mission"} and are_apart(self.operands(path), max(self._radii(path)))

    def _radii(self, path: str) -> set[float]:
        """The distances that guards ask for among its kin."""
        return {radius for each in self.kin_of(path) for radius in self.near.get(each, ())}

    def _reading_of(self, path: str) -> str | None:
        """The robot's reading that each distance to its kin is one of; None where more is done with them.

        Where one of them is copied, all distances are alike: the copy is asked for by its own.
        """
        kin = self.kin_of(path)
        readings = [each for each in kin if each in self.keys and self.keys[each].source == "robot"]
        keys = [self.keys[each] for each in kin if each in self.keys and self.keys[each].type == "pose"]
        measured = [pair for pair in self.measured if kin & {*pair}]
        if len(readings) != 1 or len(keys) != len(kin) or {each.frame for each in keys} != self.frames(path):
            return None
        (reading,) = readings
        radii, is_copied = self._radii(path), bool(kin & self._copied)
        is_alone = reading not in self._copied | self._sources and all(reading in pair for pair in measured)
        is_odd = kin & (self._brought | {each for one, _, other in self.met for each in (one, other)})
        return (
            reading
            if is_alone and not is_odd and not (is_copied and len(radii) > 1) and min(radii, default=0) > 0
            else None
        )

    @cached_property
    def _brought(self) -> set[str]:
        """Keys that more than the start and `set` write: items of lists, results, what a package's kinds may write."""
        written = (each for thing in self._mission.everything() for each in thing.writes())
        return {each.key for each in written if each.by not in OWN} | set(self.keys if self._mission.uses else ())

    @cached_property
    def _free(self) -> set[str]:
        """Keys that can be anything: what is reported, given or brought, and what is copied from there."""
        free = {name for name, key in self.keys.items() if key.source != "mission"} | self._brought
        copies = {(each.set, each.source.partition(".")[0]) for each in writes_in(self._mission) if each.source}
        while more := {name for name, root in copies if root in free or root not in self.keys} - free:
            free |= more
        return free

    def _looked_into(self) -> Iterator[str]:
        """Poses of which guards ask for a distance, and for a field as well."""
        return (path for path in self.near if any(self.within(kin) for kin in self.kin_of(path)))

    def _wanted(self) -> Iterator[str]:
        """Goals that the author wrote, goals next to more than one other, and what is looked into besides."""
        if len(self.judged) > 2:
            yield from self.judged
        for path in self.judged:
            written = self.keys.get(path)
            is_fixed = written is not None and written.source == "mission" and written.initial
            if is_fixed or any(isinstance(each, Mapping) for each in self.operands(path)) or self.within(path):
                yield path
        yield from (path for path in self.judging if "things" in self.within(path))

    def asked_of_goals(self, path: str) -> frozenset[str]:
        """What is asked of goals by the value there, or by one that it is copied to; empty if it is no sight."""
        kin = self.kin_of(path)
        return frozenset[str]().union(*(self.judging.get(each, ()) for each in kin))

    def is_bare(self, key: str) -> bool:
        """Whether a key is compared with none, copied to none and judged by none, but for its fields by name."""
        is_alone = len(self.kin_of(key)) == 1 and not self.atoms.get(key) and key not in self.near
        is_judged = self.is_goal(key) or self.asked_of_goals(key)
        return is_alone and not is_judged and not any(self.within(f"{key}.{field}") for field in self.within(key))

    def is_goal(self, path: str) -> bool:
        """Whether the value there, or one that it is copied to, is judged as a goal."""
        return not self.judged.keys().isdisjoint(self.kin_of(path))

    def is_pose(self, path: str) -> bool:
        """Whether guards ask how far the value there, or one that it is copied to, is from another."""
        return not self.near.keys().isdisjoint(self.kin_of(path))

    def frames(self, path: str) -> frozenset[str]:
        """The frames in which it or its kin are given, as keys declare them."""
        return frozenset(self.keys[each].frame for each in self.kin_of(path) if each in self.keys) - {""}

    @property
    def goals_change(self) -> bool:
        """Whether a goal can be replaced in a run: not if all are given at the start."""
        goals = {each for path in self.judged for each in self.kin_of(path)}
        return any(each not in self.keys or self.keys[each].source != "argument" for each in goals)

    def is_sampled(self, path: str) -> bool:
        """Whether it or its kin are."""
        return not self.kin_of(path).isdisjoint(self.sampled)

    def kind_of(self, path: str) -> str:
        """The type of the value there: as written, or by what it is compared with, or goes into."""
        root, _, rest = path.partition(".")
        for kin in (path, *sorted(self.kin_of(path))):
            if kin in self.keys:
                return self.keys[kin].type
        if root in self.keys and (kind := (self.keys[root].fields or {}).get(rest)):
            return kind
        if path in self.items:
            return "list"
        if root == "event" and rest in self.declared:
            return self.declared[rest][0]
        operands = self.operands(path)
        if operands and all(isinstance(each, bool) for each in operands):
            return "boolean"
        return "number" if any(isinstance(each, int | float) for each in operands) else "string"

    def kinds_of(self, path: str) -> list[str]:
        """The types of a path; several where events of several types bring it."""
        root, _, rest = path.partition(".")
        several = self.declared.get(rest, []) if root == "event" else []
        return list(dict.fromkeys([self.kind_of(path), *several]))

    def operands(self, path: str) -> list[Any]:
        """The constants that it or its kin is compared with."""
        return [constant for kin in sorted(self.kin_of(path)) for _, constant in self.constants(kin)]

    def constants(self, path: str) -> Iterator[tuple[str, Any]]:
        """Operator and constant of each comparison; of a list each item, to which the value may be equal."""
        for op, operand in self.atoms.get(path, ()):
            yield from (("==", each) for each in operand) if OPERATORS[op].takes_list else ((op, operand),)

    def within(self, path: str) -> list[str]:
        """The next names below a path that anybody looks at."""
        start = f"{path}."
        found = (*self.atoms, *self.near, *self.kin, *self.fresh)
        return sorted({each[len(start) :].split(".")[0] for each in found if each.startswith(start)})


def _dots(path: str) -> Iterator[int]:
    return (at for at, sign in enumerate(path) if sign == ".")
