# SPDX-License-Identifier: Apache-2.0
"""Readings of which no rule that waits finds out more than one thing: a proof with them as one, and with each apart."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction.alike_readings import AlikeReadings
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.verdicts.circles import circling
from tests.prove.explored import RecordingSpace, true_or_not
from tests.sampled import sampled

Json = dict[str, Any]
STATES = ("work", "doubt", "wait")
ENDS = ["failed", "timed_out", "rejected"]
MOST, WORK = 400, 40


def compared(r: random.Random, kinds: Sequence[Json]) -> Json:
    """A guard that compares one reading, or two."""
    found: Json = dict(r.choice(kinds))
    if "<" in found:
        found[r.choice(["<", ">="])] = found.pop("<")
    return found


KINDS: tuple[Json, ...] = (
    {"key": "level", "<": 2}, {"key": "level", "<": 4}, {"key": "level", "<": {"key": "limit"}},
    {"key": "level", "<": {"key": "count"}}, {"key": "wind", "<": 1}, {"key": "wind", "<": 3},
    {"key": "wind", "<": {"key": "level"}}, {"key": "door", "==": "open"}, {"key": "door", "in": ["open", "shut"]},
    {"fresh": "level"},
)  # fmt: skip


def guard(r: random.Random, kinds: Sequence[Json], depth: int = 2) -> Json:
    if depth == 0 or r.random() < 0.5:
        return compared(r, kinds)
    inner = [guard(r, kinds, depth - 1) for _ in range(2)]
    held: Json = {"held": inner[0], "for_s": 5} if depth == 2 else {"possible": inner[0]}
    both: Json = {"all": [{"in": r.choice(STATES)}, inner[0]]}
    return r.choice([{"all": inner}, {"any": inner}, {"not": inner[0]}, held, both])


def drawn(seed: int) -> Mission:
    """What waits leads forward; what an event, an answer or time fires leads anywhere."""
    r = random.Random(seed)
    kinds = r.sample(KINDS, 3)
    keys: Json = {
        "level": {"type": "number", "source": "robot", "max_age_s": 5},
        "wind": {"type": "integer", "source": "robot"},
        "door": {"type": "string", "source": "robot", "max_age_s": 9, "optional": True},
        "limit": {"type": "integer", "source": "argument", "minimum": 1, "maximum": 2, "initial": 2},
        "count": {"type": "integer", "initial": 0},
    }  # fmt: skip
    states: Json = {}
    for at, name in enumerate(STATES):
        later = [*STATES[at + 1 :], "over"]
        waits: list[Json] = [{"when": guard(r, kinds), "to": r.choice(later)} for _ in range(r.randint(0, 1))]
        count: Json = {"set": "count", "value": r.choice([0, 3])}
        events: list[Json] = [
            {"on": "go", "when": guard(r, kinds), "to": r.choice(STATES), "do": [count]},
            {"after_s": 3, "when": guard(r, kinds), "to": r.choice([*STATES, "over"])},
        ]  # fmt: skip
        states[name] = {"transitions": waits + events}
    states["work"] |= {"action": "drive", "timeout_s": 9, "achieved": guard(r, kinds, 1), "settle_s": 1}
    states["work"]["transitions"] += [{"on": [*ENDS, "succeeded", "unverified"], "to": "wait"}]
    options: Json = {"on_again": {"when": guard(r, kinds)}, "give_up": {}}
    states["doubt"] |= {"decision": {"question": "?", "options": options, "ask": ["operator"], "deadline_s": 9,
                                     "fallback": "give_up"}}  # fmt: skip
    states["doubt"]["transitions"] += [{"on": "on_again", "to": "work"}, {"on": "give_up", "to": "over"}]
    states["over"] = {"final": "aborted"}
    asked = {"readings": {"not": {"all": [{"in": r.choice(STATES)}, guard(r, kinds, 1)]}}}
    return Mission.model_validate({
        "format": 1, "name": "drawn", "blackboard": keys, "events": {"go": {}}, "initial": r.choice(STATES),
        "states": states, "invariants": asked if r.random() < 0.5 else {},
    })  # fmt: skip


def apart(
    readings: AlikeReadings, state: Any, waiting: Sequence[Any], read: frozenset[str]
) -> Mapping[str, Sequence[Any]]:
    """Each value is kept by itself."""
    return {}


def explored(mission: Mission) -> RecordingSpace:
    space = RecordingSpace(Environment(mission, is_calm=True), MOST, WORK)
    space.explore()
    return space


def hold_against_each_apart(seed: int) -> tuple[int, int]:
    mission = drawn(seed)
    few = explored(mission)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AlikeReadings, "narrow", apart)
        every = explored(mission)
    if not every.is_whole:
        return 0, 0
    assert few.is_whole
    assert (few.seen, {*few.ends.values()}) == (every.seen, {*every.ends.values()})
    assert (few.findings.taken, few.findings.entered) == (every.findings.taken, every.findings.entered)
    assert few.findings.flaws.keys() == every.findings.flaws.keys()
    assert bool(circling(few)) == bool(circling(every))
    assert few.environment.instruments.answered == every.environment.instruments.answered
    assert true_or_not(few) == true_or_not(every)
    for name, flaw in few.findings.flaws.items():
        assert len(few.path(flaw.state)) <= len(every.path(every.findings.flaws[name].state))
    return few.states, every.states


@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_readings_that_are_alike_lead_where_each_of_them_leads(seed: int) -> None:
    hold_against_each_apart(seed)


def test_a_robot_of_which_a_reading_may_be_unknown_may_have_been_silent() -> None:
    low: Json = {"when": {"key": "battery", "<": 0.2}, "to": "over"}
    half: Json = {"on": "go", "when": {"key": "battery", "<": 0.5}, "to": "over"}
    mission = Mission.model_validate({
        "format": 1, "name": "round", "initial": "a", "events": {"go": {}},
        "blackboard": {"battery": {"type": "number", "source": "robot", "max_age_s": 5}},
        "states": {"a": {"transitions": [low, half, {"after_s": 1, "to": "b"}]},
                   "b": {"transitions": [low, {"after_s": 1, "to": "a"}]}, "over": {"final": "aborted"}},
    })  # fmt: skip
    space = explored(mission)
    assert space.is_whole and circling(space)
