# SPDX-License-Identifier: Apache-2.0
"""How far a run is in its lists: what a conversation reports is what the mission itself has counted.

Lists within lists and next to each other, with equal items, that are written while their rounds are under way.
"""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.agents.talk.run_status import RunStatus
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

Json = dict[str, Any]
LISTS: tuple[list[str], ...] = ([], ["x"], ["x", "x"], ["x", "y", "x"], ["z", "y", "x", "w"])
NAMES = ("a", "b")


def rounds(name: str, inner: Json | None = None) -> Json:
    """An `each` that counts its rounds; one ends with an event, or with the list that is inside."""
    begin: Json = inner if inner is not None else {"transitions": [{"on": f"next_{name}", "to": f"over_{name}"}]}
    entry = [{"set": f"begun_{name}", "add": 1}, *begin.get("entry", [])]
    states = {f"in_{name}": {**begin, "entry": entry}, f"over_{name}": {"final": "succeeded"}}
    return {
        "each": name,
        "as": f"item_{name}",
        "entry": [{"set": f"begun_{name}", "value": 0}],
        "initial": f"in_{name}",
        "states": states,
    }


def listing(rng: random.Random) -> Json:
    """A mission with two lists, one in the other or next to it; events give the lists other values."""
    if rng.random() < 0.5:
        inner = rounds("b") | {"transitions": [{"on": "succeeded", "to": "over_a"}]}
        work = {"list_a": rounds("a", inner)}
    else:
        work = {"both": {"parallel": {"list_a": rounds("a"), "list_b": rounds("b")}}}
    (state,) = work.values()
    state["transitions"] = [{"on": "succeeded", "to": next(iter(work))}, {"on": "again", "to": next(iter(work))}]
    lists = {
        f"{name}_{number}": [{"set": name, "value": items}] for name in NAMES for number, items in enumerate(LISTS)
    }
    keys: Json = {name: {"type": "list", "initial": rng.choice(LISTS[1:])} for name in NAMES}
    keys |= {f"begun_{name}": {"type": "integer", "initial": 0} for name in NAMES}
    keys |= {f"item_{name}": {"type": "string", "initial": ""} for name in NAMES}
    return {
        "name": "listing", "blackboard": keys, "initial": next(iter(work)), "states": work,
        "events": ["again", *lists, *(f"next_{name}" for name in NAMES)],
        "transitions": [{"on": on, "do": do} for on, do in lists.items()],
    }  # fmt: skip


class Account:
    """What the mission itself has counted, held against what a conversation would report after each step."""

    def __init__(self, seed: int) -> None:
        rng, clock = random.Random(seed), SimulatedClock()
        made = listing(rng)
        self.mission = Mission.model_validate(made)
        self._at_entry: dict[str, int] = {}
        """List → the items that it had when its rounds were entered last."""
        self._now = {name: len(key["initial"]) for name, key in made["blackboard"].items() if name in NAMES}
        self.runner = Runner(
            self.mission,
            connector=LocalConnector(now=clock.now),
            clock=clock,
            observer=RunObserver(self._step, lambda status: self.status.status(status)),
        )
        self.status = RunStatus(self.runner)
        self.reports: list[tuple[Any, Any]] = []
        """What was reported of a list, and what the mission had counted, after each step; a run survives its
        observer, so they are compared at the end."""
        for _ in range(rng.randint(5, 30)):
            self.runner.post(Event(rng.choice([*made["events"], *["next_a", "next_b"] * 8])))
        self.runner.kill()
        self.runner.run()

    def _step(self, step: Step) -> None:
        self.status.step(step)
        self._now |= {key: len(value) for key, value in step.writes if key in NAMES}
        for name in NAMES:
            if f"in_{name}" in step.entered and f"begun_{name}" in [key for key, _ in step.writes]:
                self._entered(name, step)
        board = self.runner.view.board
        reported = {each.of: (each.done, each.total) for each in self.status.view().progress}
        for name in NAMES:
            if f"in_{name}" in self.runner.view.active:
                counted = board[f"begun_{name}"].value - 1, self._at_entry[name]
                self.reports.append((reported.get(name), counted))

    def _entered(self, name: str, step: Step) -> None:
        places = [found for move in step.moves for found in move.entered]
        if f"list_{name}" in places or "both" in places or (name == "b" and "in_b" in places and "in_a" in places):
            self._at_entry[name] = self._now[name]


def agree(seed: int) -> int:
    """Compare what was reported in a run with what its mission has counted; how often there was something."""
    reports = Account(seed).reports
    assert [reported for reported, _ in reports] == [counted for _, counted in reports], seed
    return len(reports)


@given(st.integers(0, 2**32))
def test_a_conversation_reports_how_far_the_lists_are_that_a_run_is_at(seed: int) -> None:
    agree(seed)


@pytest.mark.drill
def test_a_conversation_reports_how_far_the_lists_of_many_runs_are() -> None:
    assert sum(agree(seed) for seed in range(2_000)) > 6_000
