# SPDX-License-Identifier: Apache-2.0
"""No run of a drawn chain of states enters one that its proof has out of reach, whatever numbers come.

Numbers of every source are compared, copied as such and within objects, and counted; runs draw from a wide range.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove

Json = dict[str, Any]
SEEN: Json = {"type": "object", "fields": {"x": "integer"}}
KEYS: Json = {
    "n": {"type": "integer", "initial": 0}, "m": {"type": "integer", "initial": 0},
    "read": {"type": "integer", "source": "robot"}, "other": {"type": "integer", "source": "robot"},
    "given": {"type": "integer", "source": "argument", "initial": 2},
    "seen": {**SEEN, "source": "robot"}, "last": {**SEEN, "initial": {"x": 0}},
}  # fmt: skip
PATHS = {"event.x": "event.x", **{key: f"{key}.x" if key in ("seen", "last") else key for key in KEYS}}
OPS = ("<", ">", "==", "!=", ">=", "<=")
RUNS, LONG = 60, 60


class Drawn:
    """A chain of states, of few of the keys."""

    def __init__(self, seed: int) -> None:
        self.r = r = random.Random(seed)
        self.names = r.sample(sorted(PATHS), r.randint(2, 4))
        if {"seen", "last"} & {*self.names}:
            self.names = [*{*self.names, "seen", "last"}]
        self.names.sort()
        self.keys = [name for name in self.names if name in KEYS]
        self.ops = r.choice([OPS[:1], OPS[:2], OPS[2:3], OPS])

    def guard(self) -> Json:
        one, other = (PATHS[self.r.choice(self.names)] for _ in "ab")
        return {"key": one, self.r.choice(self.ops): {"key": other} if one != other else self.r.choice([0, 3, 8])}

    def do(self) -> Json:
        name = self.r.choice([*{*self.keys} & {"n", "m", "last"}] or ["n"])
        if name == "last":
            return {"set": name, "from": "seen"}
        others = [PATHS[each] for each in self.names if each != name]
        return self.r.choice(
            [{"set": name, "add": 1}, {"set": name, "add": -1}, {"set": name, "from": self.r.choice(others)}]
        )

    def link(self, to: str) -> Json:
        done = [self.do()] if {"n", "m", "last"} & {*self.keys} and self.r.random() < 0.6 else []
        when = {"when": self.guard()} if self.r.random() < 0.6 else {}
        return {"on": "next", **when, **({"do": done} if done else {}), "to": to}

    def mission(self) -> Mission:
        names = [f"s{number}" for number in range(self.r.randint(4, 8))]
        more = [{"on": "more", "do": [self.do()]}] if {"n", "m", "last"} & {*self.keys} else []
        stop = {"on": "stop", "to": "over"}
        states: Json = {
            one: {"transitions": [self.link(other), stop, *(more if self.r.random() < 0.3 else [])]}
            for one, other in zip(names, [*names[1:], "over"], strict=True)
        }
        return Mission.model_validate({
            "name": "chain", "initial": names[0], "blackboard": {key: KEYS[key] for key in self.keys},
            "events": {"next": {"fields": {"x": "integer"}}, "more": {"fields": {"x": "integer"}}, "stop": {}},
            "states": {**states, "over": {"final": "aborted"}},
        })  # fmt: skip


def entered(mission: Mission, r: random.Random) -> set[str]:
    """What a run enters, to which numbers come that are near each other, or far."""
    numbers = r.choice([range(-1, 4), range(-3, 13), range(-50, 50)])
    sources = {name: key.source for name, key in mission.blackboard.items() if key.source != "mission"}
    readings = [name for name, source in sources.items() if source == "robot"]

    def value(name: str) -> Any:
        return {"x": r.choice(numbers)} if name == "seen" else r.choice(numbers)

    chart = Chart(mission)
    for name in sources:
        chart.write(name, value(name), 0.0)
    found = {*chart.start(0.0).entered}
    for _ in range(LONG):
        if readings and r.random() < 0.4:
            name = r.choice(readings)
            event = Event(name, chart.at, {"value": value(name)}, "write")
        else:
            event = Event(r.choice(["next", "next", "more"]), chart.at, {"x": r.choice(numbers)})
        found.update(chart.send(event).entered)
        if chart.outcome is not None:
            break
    return found


def hold(seeds: Iterable[int]) -> Counter[str]:
    count = Counter[str]()
    for seed in seeds:
        mission = Drawn(seed).mission()
        proof = prove(mission, most=300, work=5_000)
        never = set(proof.never)
        for number in range(RUNS):
            wrong = never & entered(mission, random.Random(f"{seed} {number}"))
            assert not wrong, (seed, number, wrong)
        count.update(missions=1, exact=proof.is_whole and not proof.sampled, never=bool(never))
    return count


WRONG_ONCE = (85, 126, 160, 181, 230, 323, 356)


def test_no_run_of_a_chain_enters_what_is_called_out_of_reach() -> None:
    count = hold([*range(20), *WRONG_ONCE])
    assert count["exact"], count


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_no_run_of_thousands_of_chains_enters_what_is_called_out_of_reach() -> None:
    count = hold(range(1000, 6000))
    assert count["exact"] > 400 and count["never"], count
