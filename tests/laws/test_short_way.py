# SPDX-License-Identifier: Apache-2.0
"""A step on the short way is the step on the long way, and leaves the run where that does."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.semantics import short_way
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from tests.laws.drawn import KEYS, document, happenings, is_far, robot_facts
from tests.rigs.charts import ScriptedRobot
from tests.trees.growing import FACTS
from tests.trees.polling import lives, mission_of, polled_trees

seeds = st.integers(0, 2**32)
ROBOT_KEYS = [name for name, key in KEYS.items() if key.get("source") == "robot"]


class LongWay(Chart):
    """A chart that never takes the short way."""

    def send(self, event: Event) -> Step:
        self.state.quick = False
        return super().send(event)


def left(one: Chart) -> dict[str, Any]:
    """All that a run remembers, but for whether the short way is open."""
    return {**one.snapshot(), "_listening": frozenset(one.state.watched), "_quick": None, "quiet": one.quiet}


def agree(short: Chart, long: Chart, event: Event) -> Step:
    """Both make the same step; of an event that fires nothing the long way also notes the guards that need no event."""
    step, other = short.send(event), long.send(event)
    if event.kind == "event" and not step.moves:
        other = other._replace(guards=other.guards[: len(step.guards)])
    assert step == other
    assert left(short) == left(long)
    return step


def drawn_agree(seed: int) -> None:
    """A mission of every kind of state and guard, with what happens to it, and readings in between."""
    rng = random.Random(seed)
    mission, facts = Mission.model_validate(document(rng)), robot_facts(rng)
    named = {"is_far": is_far} if "is_far" in mission.model_dump_json() else {}
    short, long = (kind(mission, CompiledTrees(), robot_facts=facts, named=named) for kind in (Chart, LongWay))
    robot = ScriptedRobot("agent")
    assert robot.follow(short.start(0.0)) == long.start(0.0)
    for happening in happenings(rng):
        event = robot.event(*happening)
        for _ in range(rng.randint(0, 3)):
            at = short.at + rng.choice([0.0, 0.0, 0.1])
            robot.follow(agree(short, long, reading(rng, min(at, max(short.at, event.at)))))
        robot.follow(agree(short, long, event))


def reading(rng: random.Random, at: float) -> Event:
    """A reading of the robot: often what is known already, seldom older, of another type, or of no key."""
    key = rng.choice([*ROBOT_KEYS, "nothing"])
    value = rng.choice([0, 1, 2, True, False]) if key != "pose" else {"x": rng.choice([0.0, 3.0]), "y": 0.0}
    stamp = {"stamp": at - rng.choice([0.5, 5.0])} if rng.random() < 0.2 else {}
    return Event(key, at, {"value": value, **stamp}, "write")


@given(seeds)
@settings(max_examples=20)
def test_the_short_way_leads_where_the_long_one_does(seed: int) -> None:
    drawn_agree(seed)


@settings(max_examples=15, suppress_health_check=list(HealthCheck))
@given(polled_trees, lives, st.integers(0, 2**32))
def test_so_it_does_where_trees_look_at_what_is_written(tree: Any, life: Any, seed: int) -> None:
    trees_agree(tree, life, seed)


def trees_agree(tree: Any, life: Any, seed: int) -> None:
    rng, mission = random.Random(seed), mission_of(tree)
    short, long, half_s = Chart(mission), LongWay(mission), 0
    assert short.start(0.0) == long.start(0.0)
    for each in life:
        half_s += each.later
        agree(short, long, Tick(half_s / 2))
        for _ in range(rng.randint(0, 2)):
            key = rng.choice([*mission.blackboard, "nothing"])
            agree(short, long, Event(key, half_s / 2, {"value": rng.choice([True, False, True, False, 1])}, "write"))
        if each.fact is not None:
            agree(short, long, Event(each.fact[0], half_s / 2, {"value": each.fact[1]}, "write"))
        elif short.awaited:
            number, end = each.ends
            numbers = sorted(short.awaited)
            agree(short, long, Event(end, half_s / 2, {}, "result", numbers[number % len(numbers)]))


def looking_tree(rng: random.Random, depth: int = 3) -> dict[str, Any]:
    """A tree that looks at facts again and again: one of age, waits, deadlines, writes, and actions that run on.

    Of what its leaves run some look at facts as well: an action that was done, and of which it is to be seen.
    """
    word = rng.choice(
        ["sequence", "selector", "eternal_guard", "timeout", "inverter", "check", "act"] if depth else ["act"]
    )
    key = rng.choice(["f", "g", "old"])
    fact = {"key": key, rng.choice(["==", "!="]): True} if rng.random() < 0.8 else {"fresh": "old"}
    if word in ("sequence", "selector"):
        inside = [looking_tree(rng, depth - 1) for _ in range(rng.randint(1, 3))]
        return {word: [{"check": fact}, *inside] if rng.random() < 0.6 else inside, "memory": rng.random() < 0.3}
    if word == "eternal_guard":
        return {"eternal_guard": fact, "child": looking_tree(rng, depth - 1)}
    if word == "timeout":
        return {"timeout": rng.choice([0.5, 1.5]), "child": looking_tree(rng, depth - 1)}
    if word == "inverter":
        return {"inverter": looking_tree(rng, depth - 1)}
    settling = {"action": "go", "achieved": {"key": rng.choice(["f", "old"]), "==": True}, "settle_s": 2.0}
    leaf = rng.choice([{"action": "go"}, settling, {"wait_s": rng.choice([0.5, 2.0])}, {"set": "n", "add": 1}])
    return {"sequence": [{"check": fact}, leaf]} if word == "act" else {"check": fact}


def looking_agree(seed: int) -> None:
    """Two such trees next to each other, in regions, that begin again when they have ended."""
    rng, at = random.Random(seed), 0.0
    keys = {key: {"type": "boolean", "source": "robot", "optional": True} for key in ("f", "g")}
    keys |= {"old": {**keys["f"], "max_age_s": 1.0}, "n": {"type": "integer", "initial": 0}}
    regions = {
        name: {
            "initial": name * 2,
            "states": {
                name * 2: {
                    "tree": {"selector": [looking_tree(rng), {"action": "rest"}], "memory": False},
                    "transitions": [{"on": ["succeeded", "failed"], "to": name * 3}],
                },
                name * 3: {"transitions": [{"after_s": 0.75, "to": name * 2}]},
            },
        }
        for name in "ab"[: rng.randint(1, 2)]
    }
    mission = Mission.model_validate(
        {"name": "m", "initial": "p", "states": {"p": {"parallel": regions}}, "blackboard": keys}
    )
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for _ in range(25):
        at += rng.choice([0.0, 0.25, 0.25, 1.0])
        if short.awaited and rng.random() < 0.4:
            number = rng.choice(sorted(short.awaited))
            agree(short, long, Event("succeeded", at, {}, "result", number))
        agree(short, long, Event(rng.choice(["f", "g", "old"]), at, {"value": rng.random() < 0.6}, "write"))


@given(seeds)
@settings(max_examples=40)
def test_so_it_does_where_trees_run_on_and_look(seed: int) -> None:
    looking_agree(seed)


def plain_mission(rng: random.Random) -> Mission:
    """States without activities, between which events lead, with guards and effects of the simplest sorts."""
    effects = [
        {"set": "n", "add": 1}, {"set": "x", "add": 0.5}, {"set": "n", "value": 3}, {"set": "flag", "value": True},
        {"set": "x", "from": "fact"}, {"raise": "c"}, {"raise": "d", "after_s": 0.5}, {"drop": "later"},
        {"raise": "d", "after_s": 1.5, "id": "later"}, {"publish": "lamp", "message": {"n": {"from": "n"}}},
    ]  # fmt: skip
    guards = [
        {"key": "n", rng.choice(["<", ">=", "==", "!="]): rng.randint(0, 4)}, {"key": "flag", "==": True},
        {"key": "fact", ">": 1}, {"key": "x", "in": [0, 0.5, 3]}, {"key": "old", "<": 2},
    ]  # fmt: skip

    def transition() -> dict[str, Any]:
        on = {"on": rng.choice(["a", "a", "b", "c", "d"])} if rng.random() < 0.95 else {}
        guarded = {"when": rng.choice(guards)} if rng.random() < 0.5 or not on else {}
        to = {"to": rng.choice(["s", "t", "u"])} if rng.random() < 0.9 or not on else {}
        done = rng.choices(effects, k=rng.choice([0, 1, 1, 1, 2]))
        if on.get("on") != "a":  # so that nothing raises what raises it
            done = [each for each in done if "raise" not in each or "after_s" in each]
        return {**on, **guarded, **to, "do": done}

    keys = {
        "n": {"type": "integer", "initial": 0}, "x": {"type": "number", "initial": 0},
        "flag": {"type": "boolean", "initial": False}, "fact": {"type": "integer", "source": "robot", "optional": True},
        "old": {"type": "number", "source": "robot", "max_age_s": 1, "optional": True},
    }  # fmt: skip
    states = {name: {"transitions": [transition() for _ in range(rng.randint(1, 3))]} for name in "stu"}
    return Mission.model_validate(
        {"name": "m", "events": ["a", "b", "c", "d"], "initial": "s", "states": states, "blackboard": keys}
    )


def plain_agree(seed: int) -> None:
    rng = random.Random(seed)
    mission, at = plain_mission(rng), 0.0
    short, long = Chart(mission), LongWay(mission)
    assert short.start(0.0) == long.start(0.0)
    for _ in range(25):
        at += rng.choice([0.0, 0.25, 1.0])
        key, value = rng.choice(["fact", "old", "n"]), rng.choice([0, 1, 2, 5, "no"])
        event = Event(key, at, {"value": value}, "write") if rng.random() < 0.4 else Event(rng.choice("aabcde"), at)
        agree(short, long, event)


@given(seeds)
@settings(max_examples=50)
def test_so_it_does_where_events_lead_from_state_to_state(seed: int) -> None:
    plain_agree(seed)


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_so_it_does_for_many() -> None:
    @settings(max_examples=20_000, suppress_health_check=list(HealthCheck), deadline=None)
    @given(seeds)
    def missions(seed: int) -> None:
        drawn_agree(seed)

    @settings(max_examples=20_000, suppress_health_check=list(HealthCheck), deadline=None)
    @given(polled_trees, lives, seeds)
    def trees(tree: Any, life: Any, seed: int) -> None:
        trees_agree(tree, life, seed)

    missions()
    trees()
    for number in range(20_000):
        plain_agree(number)
        looking_agree(number)


def test_a_law_of_the_short_way_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of its forms is met by what the laws draw."""
    taken: dict[str, int] = {}

    def counted(name: str) -> Any:
        function = getattr(short_way, name)

        def call(*given: Any, **words: Any) -> Any:
            taken[name] = taken.get(name, 0) + 1
            return function(*given, **words)

        return call

    for name in ("short_step", "finish_move", "receive_reading", "_looked_at"):
        monkeypatch.setattr(short_way, name, counted(name))
    for seed in range(20):
        plain_agree(seed)
        looking_agree(seed)
    assert len(taken) == 4 and min(taken.values()) > 20, taken


def test_a_tree_alone_looks_at_what_is_written_on_the_short_way(monkeypatch: pytest.MonkeyPatch) -> None:
    chart = Chart(mission_of({"selector": [{"sequence": [{"check": {"key": FACTS[0], "==": True}}, {"call": "horn"}]},
                                           {"call": "bell"}], "memory": False}))  # fmt: skip
    chart.start(0.0)
    monkeypatch.setattr(short_way, "make_step", None)
    step = chart.write(FACTS[0], True, 1.0)
    assert [effect.describe() for effect in step.effects] == ["call horn (number 2)"]
    assert not chart.quiet and chart.write(FACTS[0], True, 2.0).effects == () and chart.quiet
