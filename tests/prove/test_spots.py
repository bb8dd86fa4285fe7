# SPDX-License-Identifier: Apache-2.0
"""What a run finds out of numbers that are compared with each other, their few representatives bring about as well."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.analysis.representatives import Values

Json = dict[str, Any]
Lie = tuple[float, ...]
"""A number for each key."""
APPLY: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
FLOOR: Json = {"type": "integer", "source": "argument", "initial": 4}
READ: Json = {"type": "integer", "source": "robot"}
LIMITS: list[Json] = [{}, {"minimum": 2}, {"maximum": 5}, {"minimum": 2, "maximum": 5}, {"minimum": 4, "maximum": 4}]


def mission(keys: Json, guards: list[Json]) -> Mission:
    ways = [{"when": guard, "to": "over"} for guard in guards]
    return Mission.model_validate({
        "name": "spots", "initial": "waiting", "blackboard": keys,
        "states": {"waiting": {"transitions": ways}, "over": {"final": "aborted"}},
    })  # fmt: skip


class Lies:
    """Numbers of keys that are compared, and how a run can change them: what the robot reports, one at a time."""

    def __init__(self, keys: Json, guards: list[Json], numbers: Mapping[str, list[float]]) -> None:
        self.names, self._keys, self._numbers = list(keys), keys, numbers
        self._asked = [
            (guard["key"], *next((op, each) for op, each in guard.items() if op in APPLY)) for guard in guards
        ]
        self.all = list(product(*(numbers[name] for name in self.names)))
        self.sees = {lie: self._truths(dict(zip(self.names, lie, strict=True))) for lie in self.all}

    def _truths(self, known: Mapping[str, float]) -> tuple[bool, ...]:
        return tuple(
            APPLY[op](known[key], known[other["key"]] if isinstance(other, dict) else other)
            for key, op, other in self._asked
        )

    def next(self, lie: Lie) -> Iterator[Lie]:
        for at, name in enumerate(self.names):
            if self._keys[name]["source"] == "robot":
                yield from ((*lie[:at], each, *lie[at + 1 :]) for each in self._numbers[name] if each != lie[at])

    def silent(self, lie: Lie) -> set[Lie]:
        """Where it can come to without a rule that notices."""
        found, left = {lie}, [lie]
        while left:
            for each in self.next(left.pop()):
                if each not in found and self.sees[each] == self.sees[lie]:
                    found.add(each)
                    left.append(each)
        return found


def unmatched(run: Lies, tried: Lies) -> list[Lie]:
    """What a run can begin with and no representative can follow: the greatest simulation leaves it out."""
    after = {lie: {each for here in tried.silent(lie) for each in (here, *tried.next(here))} for lie in tried.all}
    like = {lie: {each for each in tried.all if tried.sees[each] == run.sees[lie]} for lie in run.all}
    changes = True
    while changes:
        changes = False
        for lie in run.all:
            kept = {each for each in like[lie] if all(like[there] & after[each] for there in run.next(lie))}
            changes |= kept != like[lie]
            like[lie] = kept
    return [lie for lie in run.all if not like[lie]]


def assert_represented(keys: Json, guards: list[Json]) -> None:
    values = Values(mission(keys, guards), RobotFacts())
    if values.learned.sampled:
        return
    wide = {
        name: [each for each in range(7) if key.get("minimum", 0) <= each <= key.get("maximum", 9)]
        for name, key in keys.items()
    }
    tried = {name: [each for each in values.of(name) if each is not None] for name in keys}
    left = unmatched(Lies(keys, guards, wide), Lies(keys, guards, tried))
    assert not left, (tried, left[:3])


def drawn(seed: int) -> tuple[Json, list[Json]]:
    r = random.Random(seed)
    keys: Json = {"one": r.choice([READ, {**FLOOR, **r.choice(LIMITS)}]), "two": READ}
    if r.random() < 0.6:
        keys["three"] = r.choice([READ, {**FLOOR, **r.choice(LIMITS)}])
    ops = r.choice([["=="], ["==", "!="], ["<", ">="], list(APPLY)])
    names = sorted(keys)
    pairs = [r.sample(names, 2) for _ in range(r.randint(1, 3))]
    guards: list[Json] = [{"key": one, r.choice(ops): {"key": other}} for one, other in pairs]
    constants = [{"key": r.choice(names), r.choice(ops): r.choice([2, 4])} for _ in range(r.randint(0, 2))]
    return keys, guards + constants


@pytest.mark.parametrize("seed", range(40))
def test_what_a_run_finds_out_of_numbers_their_representatives_bring_about(seed: int) -> None:
    assert_represented(*drawn(seed))


@pytest.mark.parametrize(("keys", "guards"), [
    ({"a": FLOOR, "b": FLOOR, "c": READ},
     [{"key": "a", "<": {"key": "b"}}, {"key": "c", "<": {"key": "a"}}, {"key": "c", ">": {"key": "b"}}]),
    ({"a": FLOOR, "b": READ}, [{"key": "b", "<": {"key": "a"}}, {"key": "b", ">": {"key": "a"}}, {"key": "b", "<": 5}]),
    ({"a": READ, "b": READ}, [{"key": "b", "<": {"key": "a"}}, {"key": "b", "==": {"key": "a"}}]),
])  # fmt: skip
def test_what_moves_can_pass_what_stays(keys: Json, guards: list[Json]) -> None:
    assert_represented(keys, guards)


def test_the_range_of_an_argument_adds_no_values_to_what_is_compared_with_it_alone() -> None:
    guards: list[Json] = [{"key": each, "==": {"key": "floor"}} for each in ("here", "there")]
    for limits in LIMITS:
        keys = {"floor": {**FLOOR, **limits}, "here": READ, "there": READ}
        values = Values(mission(keys, guards), RobotFacts())
        assert [len(values.of(key)) for key in keys] == [1, 2, 2]


@pytest.mark.parametrize("limits", LIMITS)
def test_the_range_of_an_argument_adds_no_values_next_to_a_constant(limits: Json) -> None:
    guards: list[Json] = [{"key": "here", "<": {"key": "floor"}}, {"key": "here", ">": 7}]
    values = Values(mission({"floor": {**FLOOR, **limits}, "here": READ}, guards), RobotFacts())
    free = Values(mission({"floor": FLOOR, "here": READ}, guards), RobotFacts())
    assert len(values.of("here")) <= len(free.of("here")) and len(values.of("floor")) <= len(free.of("floor"))


def test_what_moves_among_what_moves_by_its_order_is_tried_with_some_values_only() -> None:
    guards: list[Json] = [{"key": "a", "<": {"key": "b"}}, {"key": "b", "<": {"key": "c"}}]
    assert prove(mission(dict.fromkeys("abc", READ), guards)).sampled == ("a", "b", "c")


def test_a_reading_that_was_below_two_arguments_can_be_above_them() -> None:
    leads = [
        ("first", {"key": "low", "<": {"key": "high"}}, "below"),
        ("below", {"key": "seen", "<": {"key": "low"}}, "above"),
        ("above", {"key": "seen", ">": {"key": "high"}}, "last"),
    ]
    states: Json = {
        name: {"transitions": [{"when": guard, "to": to}, {"on": "stop", "to": "over"}]} for name, guard, to in leads
    }
    climbing = Mission.model_validate({
        "name": "climbing", "initial": "first", "events": ["stop"],
        "blackboard": {"low": FLOOR, "high": {**FLOOR, "initial": 5}, "seen": READ},
        "states": {**states, "last": {"transitions": [{"after_s": 1, "to": "over"}]}, "over": {"final": "aborted"}},
    })  # fmt: skip
    chart = Chart(climbing)
    chart.write("seen", 4, at=0)
    chart.start(at=0)
    chart.write("seen", 0, at=1)
    assert chart.write("seen", 9, at=2).entered == ("last",)
    assert prove(climbing).never == ()
