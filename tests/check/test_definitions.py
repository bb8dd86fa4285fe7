# SPDX-License-Identifier: Apache-2.0
"""The rules that are worked out once for many states find what their plain definitions find."""

from __future__ import annotations

import random
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given

from rai_missions.check import check, shadowed_transitions
from rai_missions.check.index import MissionIndex
from rai_missions.check.rules import RULES
from rai_missions.mission.mission import Mission
from tests.check.definitions import DEFINITIONS
from tests.strategies import missions

Json = dict[str, Any]
NEAR = 3
"""Instead of 64 transitions, so that small missions have more."""
WORDS = ("go", "stop", "failed", "timed_out", "rejected", "succeeded", "*", "unheard")


def drawn(rng: random.Random) -> Mission:
    """A mission of states that mostly wait, with many transitions of a few triggers, guards and times."""
    counter = iter(range(100))
    states = _states(rng, counter, depth=0)
    names = [f"s{number}" for number in range(next(counter))]
    targets = [name for name in names if rng.random() < 0.6] or names[:1]
    _lead(rng, states, targets, names)
    states["good"], states["bad"] = {"final": "succeeded", "requires": {"key": "n", "==": 1}}, {"final": "failed"}
    own = [_transition(rng, [*targets, "bad", "good"], names, alone=True) for _ in range(rng.randrange(5))]
    return Mission.model_validate({
        "format": 1, "name": "m", "initial": next(iter(states)), "events": {"go": {}, "stop": {}},
        "blackboard": {"n": {"type": "integer", "source": "robot"}, "m": {"type": "integer", "source": "robot"}},
        "states": states, "transitions": own,
    })  # fmt: skip


def _states(rng: random.Random, counter: Any, *, depth: int) -> Json:
    made: Json = {}
    for _ in range(rng.randint(1, 4)):
        name, kind = f"s{next(counter)}", rng.random()
        if kind < 0.15 and depth < 3:
            inner = _states(rng, counter, depth=depth + 1)
            made[name] = {"initial": next(iter(inner)), "states": inner}
        elif kind < 0.3 and depth < 3:
            made[name] = {"parallel": {**_states(rng, counter, depth=depth + 1), **_states(rng, counter, depth=9)}}
        elif kind < 0.6:
            made[name] = {"action": "move"}
        else:
            made[name] = {}
        if rng.random() < 0.2:
            made[name]["timeout_s"] = 5
    return made


def _lead(rng: random.Random, states: Json, targets: list[str], names: list[str]) -> None:
    for state in states.values():
        if rng.random() < 0.6:
            state["transitions"] = [_transition(rng, targets, names) for _ in range(rng.randrange(7))]
        for word in ("states", "parallel"):
            _lead(rng, state.get(word, {}), targets, names)


def _transition(rng: random.Random, targets: list[str], names: list[str], *, alone: bool = False) -> Json:
    made: Json = {"to": rng.choice([*targets, "bad"])} if rng.random() < 0.9 else {"do": [{"log": "x"}]}
    trigger = rng.random()
    if trigger < 0.3:
        made["after_s"] = rng.randint(1, 4)
    elif trigger < 0.95:
        made["on"] = sorted(rng.sample(WORDS, rng.randint(1, 2)))
        if len(made["on"]) == 1 and made["on"][0] in WORDS[2:6] and not alone and rng.random() < 0.3:
            made["of"] = rng.choice(names)
    if rng.random() < 0.6 or trigger >= 0.95:
        made["when"] = _guard(rng, names, 2)
    return made


def _guard(rng: random.Random, names: list[str], depth: int) -> Json:
    kind = rng.random()
    if depth and kind < 0.3:
        parts = [_guard(rng, names, depth - 1) for _ in range(rng.randrange(3))]
        return {rng.choice(("all", "any")): parts}
    if kind < 0.45:
        return {"in": rng.choice(names)}
    if kind < 0.55:
        return {"not": {"fresh": "n"}}
    return {"key": rng.choice("nm"), rng.choice(("<", "<=", "==", "!=")): rng.choice((0, 1, {"key": "m"}))}


def differences(mission: Mission) -> Counter[str]:
    """How many findings of each rule there are; that they are those of the definitions is asserted."""
    index, counted = MissionIndex(mission), Counter[str]()
    rules = {rule.name: rule.find for rule in RULES}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(shadowed_transitions, "NEAR", NEAR)
        for name, definition in DEFINITIONS.items():
            found, wanted = list(rules[name](index)), definition(index, NEAR)
            assert [place for place, _ in found] == [place for place, _ in wanted], name
            for (_, sentence), (_, words) in zip(found, wanted, strict=True):
                assert all(word in sentence for word in words), (name, sentence, words)
            counted[name] += len(found)
    return counted


def test_the_rules_find_what_their_definitions_find_in_missions_full_of_faults() -> None:
    counted = Counter[str]()
    for seed in range(250):
        counted += differences(drawn(random.Random(seed)))
    assert all(counted[name] > 5 for name in DEFINITIONS), counted


@pytest.mark.drill
def test_the_rules_find_what_their_definitions_find_in_thousands_of_missions() -> None:
    for seed in range(1000, 21_000):
        differences(drawn(random.Random(seed)))


@given(missions())
def test_the_rules_find_what_their_definitions_find_in_generated_missions(mission: Mission) -> None:
    differences(mission)


def waiting(size: int) -> Json:
    """States that wait, few of them without a way out; the mission's own transitions come from none of them."""
    states: Json = {f"s{at}": {"transitions": [{"on": "go", "to": f"s{(at + 1) % size}"}]} for at in range(size)}
    states["s5"] = {}
    return {"states": states, "transitions": [{"on": "failed", "to": f"s{at}"} for at in range(0, size, 3)]}


def acting(size: int) -> Json:
    """States with an action, all of whose failures are handled."""
    ends = [{"on": ["failed", "timed_out", "rejected"], "to": "s0"}]
    states = {
        f"s{at}": {
            "action": "move",
            "timeout_s": 5,
            "transitions": [{"on": "succeeded", "to": f"s{(at + 1) % size}"}, *ends],
        }
        for at in range(size)
    }
    return {"states": states}


def timed(size: int) -> Json:
    """One state with as many transitions by time, and guards."""
    hub = [{"after_s": at + 1, "when": {"in": f"s{at}"}, "to": f"s{at}"} for at in range(1, size)]
    states = {f"s{at}": {"transitions": [{"on": "go", "to": "s0"}]} for at in range(1, size)}
    return {"states": {"s0": {"transitions": hub}, **states}}


def fanned(size: int) -> Json:
    """One state with as many transitions on one event, each with a guard of its own."""
    hub = [{"on": "go", "when": {"in": f"s{at}"}, "to": f"s{at}"} for at in range(1, size)]
    states = {f"s{at}": {"transitions": [{"on": "go", "to": "s0"}]} for at in range(1, size)}
    return {"states": {"s0": {"transitions": hub}, **states}}


@pytest.mark.long
@pytest.mark.parametrize("made", [waiting, acting, timed, fanned])
def test_a_mission_with_few_faults_takes_ten_times_as_long_with_ten_times_the_states(
    made: Callable[[int], Json],
) -> None:
    def seconds(size: int) -> float:
        document = {"format": 1, "name": "m", "initial": "s0", "events": {"go": {}}, **made(size)}
        mission = Mission.model_validate(document)
        begun = time.process_time()
        check(mission)
        return time.process_time() - begun

    assert seconds(3_000) < 40 * max(min(seconds(300) for _ in range(3)), 0.002)
