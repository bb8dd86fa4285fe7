# SPDX-License-Identifier: Apache-2.0
"""What a run comes to at one instant is in its proof: two regions of which each waits as long as the other."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import StartGoal
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import RecordingSpace, seen

Json = dict[str, Any]
FACTS = RobotFacts({"ax": frozenset({"one"}), "ay": frozenset({"two"})})
ENDS = ("succeeded", "failed", "unverified", "yes", "no")
STATES, WORK = 300, 5_000


class Instants:
    """A mission of two regions, drawn from a random generator."""

    def __init__(self, seed: int) -> None:
        self.r, self.many = random.Random(seed), {"x": 0, "y": 0}

    def write(self) -> Json:
        return {"set": self.r.choice("nm"), "value": self.r.choice([0, 1, 1])}

    def guard(self) -> Json:
        r = self.r
        return r.choice([{"key": r.choice("nm"), "==": r.choice([0, 1])}] * 3 + [{"in": r.choice("xy") + "1"}])

    def node(self, side: str, depth: int = 1) -> Json:
        r = self.r
        wait = r.choice([{"wait_s": 1}, {"action": f"a{side}", "timeout_s": 1}, {"call": "horn", "timeout_s": 1}])
        look = r.choice([self.write(), {"check": self.guard()}])
        until: Json = {"selector": [{"check": self.guard()}, {"wait_s": 9}], "memory": False}
        made: list[Json] = [{"sequence": [wait, look]}, {"selector": [wait, look]}, {"inverter": wait}]
        if depth:
            made += [{"parallel": [until, self.node(side, 0)], "policy": "success_on_one"}] * 2
        return r.choice(made)

    def first(self, side: str) -> Json:
        """A state that waits for a second."""
        r, tree = self.r, {"tree": self.node(side)}
        asked = {"question": "What now?", "options": {"yes": {}, "no": {}}, "ask": ["agent"], "deadline_s": 1}
        final: Json = {"final": "succeeded", "requires": self.guard(), "settle_s": 1}
        timer: Json = {"transitions": [{"after_s": 1, "do": [self.write()], **r.choice([{}, self.to(side)])}]}
        return r.choice([
            tree, tree, tree, timer, {"decision": {**asked, "fallback": r.choice(["yes", "no"])}},
            {"action": f"a{side}", "achieved": self.guard(), "settle_s": 1},
            {"initial": f"{side}f", "states": {f"{side}f": final}},
        ])  # fmt: skip

    def to(self, side: str) -> Json:
        """A way to a state of its own, so that the active states show which way a run has gone."""
        self.many[side] += 1
        return {"to": f"{side}{self.many[side]}"}

    def region(self, side: str, other: str) -> Json:
        r, first = self.r, self.first(side)
        made: list[Json] = [{"when": {"in": f"{other}1"}, **self.to(side)}] if r.random() < 0.5 else []
        for word in ENDS if "transitions" not in first else ():
            do = {"do": [r.choice([self.write(), {"raise": "e"}])]} if r.random() < 0.4 else {}
            made += [{"on": word, "when": self.guard(), **self.to(side), **do}, {"on": word, **self.to(side), **do}]
        first["transitions"] = [*first.get("transitions", ()), *made]
        later = {f"{side}{at}": self.later(side, other) for at in range(1, self.many[side] + 1)}
        ends: Json = {f"{side}{at}": {} for at in range(len(later) + 1, self.many[side] + 1)}
        return {"initial": f"{side}0", "states": {f"{side}0": first, **later, **ends}}

    def later(self, side: str, other: str) -> Json:
        r = self.r
        made: list[Json] = [{"on": r.choice(ENDS), "of": f"{other}0"}, {"on": "e", "when": self.guard()}]
        return {"transitions": [{**each, **self.to(side)} for each in r.sample(made, r.choice([0, 0, 1]))]}

    def document(self) -> Json:
        """The mission."""
        regions = {"x": self.region("x", "y"), "y": self.region("y", "x")}
        counts = {name: {"type": "integer", "initial": 0} for name in "nm"}
        return {
            "name": "instants", "initial": "a", "blackboard": counts, "events": ["e", "stop"],
            "states": {"a": {"parallel": regions, "transitions": [{"on": "stop", "to": "over"}]},
                       "over": {"final": "aborted"}},
        }  # fmt: skip


def hold(seeds: Iterable[int]) -> Counter[str]:
    """Explore drawn missions, as a whole and part by part, and let a second pass: goals have ended at once, or not."""
    count = Counter[str]()
    for seed in seeds:
        mission = Mission.model_validate(Instants(seed).document())
        space, parted = (
            RecordingSpace(Environment(mission, robot_facts=FACTS), STATES, WORK, by_parts=each)
            for each in (False, True)
        )
        for each in (space, parted):
            each.explore()
        if space.is_whole and parted.is_whole:
            assert (parted.states, len([*parted.edges()])) == (space.states, len([*space.edges()])), seed
        count["drawn"] += 1
        for ends in (False, True) if space.is_whole else ():
            chart = Chart(mission, robot_facts=FACTS)
            step = chart.start(0.0)
            for effect in step.effects if ends else ():
                if isinstance(effect, StartGoal):
                    chart.send(Event("succeeded", 0.0, {}, "result", effect.number))
            chart.send(Tick(1.0))
            assert seen(chart) in space.seen, (seed, ends, sorted(chart.active))
            count["runs"] += 1
    return count


def test_what_a_run_comes_to_at_one_instant_is_in_its_proof() -> None:
    assert hold([*range(12), 63, 79])["runs"] > 20


@pytest.mark.drill
@pytest.mark.timeout(7200)
def test_what_a_thousand_runs_come_to_at_one_instant_is_in_their_proofs() -> None:
    assert hold(range(1_000, 2_000))["runs"] > 1_000
