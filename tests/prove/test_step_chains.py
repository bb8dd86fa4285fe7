# SPDX-License-Identifier: Apache-2.0
"""What a step repeats of an earlier one is not made again, and comes to the same."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from rai_missions.prove.abstraction import step_circles
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import WORK, RecordingSpace
from tests.prove.test_laws import hold_alike, lenient
from tests.sampled import sampled
from tests.strategies import mission_documents

Json = dict[str, Any]
ENDS = ["failed", "timed_out", "rejected", "unverified"]
MOST = 4_000
FEW = 150
NEVER = 1_000_000


def counting(most: int, again: list[str], do: list[Json] | None = None, **guard: Any) -> Json:
    """An action that is started again, and rejected at once while the goal before it has not ended."""
    when: Json = {"key": "n", **(guard or {"<": most})}
    again_transition = {"on": again, "when": when, "to": "going", "do": [{"set": "n", "add": 1}, *(do or [])]}
    return {
        "format": 1, "name": "counting", "initial": "going",
        "blackboard": {"n": {"type": "integer", "initial": 0}, "m": {"type": "integer", "initial": 0},
                       "ok": {"type": "boolean", "source": "robot"}},
        "events": {"look": {}},
        "states": {
            "going": {
                "action": "drive", "achieved": {"key": "ok", "==": True}, "timeout_s": 10,
                "transitions": [{"on": "succeeded", "to": "over"}, again_transition,
                                {"on": ENDS, "when": {"key": "m", ">=": 3}, "to": "looking"},
                                {"on": ENDS, "to": "lost"}],
            },
            "looking": {"transitions": [{"on": "look", "when": {"key": "m", "<": 9}, "to": "lost"}]},
            "over": {"final": "succeeded"}, "lost": {"final": "aborted"},
        },
    }  # fmt: skip


def space_of(document: Json, most: int = MOST, work: float = 1_000) -> RecordingSpace:
    mission = Mission.model_validate(document)
    space = RecordingSpace(Environment(mission), most, work, by_parts=False)
    space.explore()
    return space


def hold_against_every_microstep(document: Json, patience: int = 0, **limits: Any) -> bool:
    """What is explored where whatever a step repeats is looked for at once, and where every microstep is made.

    Returns:
        Whether all was explored.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(step_circles, "PATIENCE", NEVER)
        every = space_of(document, **limits)
        if every.meter.ended:
            return False
        patch.setattr(step_circles, "PATIENCE", patience)
        hold_alike(space_of(document, **limits), every)
    return True


@pytest.mark.parametrize("again", [["rejected"], ENDS], ids=["rejected", "every end"])
def test_a_counter_costs_as_much_as_it_has_values(again: list[str]) -> None:
    some, many = (space_of(counting(bound, again)) for bound in (60, 180))
    assert some.is_whole and many.is_whole and many.states < 3.1 * some.states
    assert many.meter.work < 3.1 * some.meter.work


SIDE_EFFECTS: dict[str, list[Json]] = {
    "nothing else": [], "another counter": [{"set": "m", "add": 1}], "a copy": [{"set": "m", "from": "n"}],
    "a constant": [{"set": "m", "value": 3}], "a message": [{"publish": "again"}],
}  # fmt: skip


@pytest.mark.parametrize("guard", [{"<": 25}, {"!=": 20}], ids=["less", "not equal"])
@pytest.mark.parametrize("do", sampled(SIDE_EFFECTS.values(), 2), ids=SIDE_EFFECTS)
def test_what_is_not_made_again_comes_to_the_same(do: list[Json], guard: Json) -> None:
    assert hold_against_every_microstep(counting(25, ENDS, do, **guard))


def test_what_begins_again_on_a_way_that_is_not_made_again_does_not_wait_on() -> None:
    """At 15, and there alone, another region moves: what it has waited for begins from the beginning."""
    document = counting(25, ENDS)
    document["transitions"] = [{"on": "look", "to": "lost"}]
    right: Json = {
        "here": {"transitions": [{"after_s": 5, "to": "there"}, {"when": {"key": "n", "==": 15}, "to": "there"}]},
        "there": {"transitions": [{"after_s": 5, "to": "here"}, {"when": {"key": "n", "==": 16}, "to": "here"}]},
    }
    going = document["states"].pop("going")
    document["states"]["both"] = {"parallel": {
        "left": {"initial": "going", "states": {"going": going}}, "right": {"initial": "here", "states": right},
    }}  # fmt: skip
    document["initial"] = "both"
    assert hold_against_every_microstep(document)


def test_a_counter_without_bound_reaches_the_limit_of_microsteps_from_each_value() -> None:
    document = counting(1, ["rejected"], [], **{">=": 0})
    document["states"]["going"]["transitions"][1]["on"] = "rejected"
    assert hold_against_every_microstep(document, 8)


@st.composite
def counting_documents(draw: st.DrawFn) -> Json:
    """A counter with other effects, and a value at which it goes another way."""
    effects = st.lists(st.sampled_from([each[0] for each in SIDE_EFFECTS.values() if each]), max_size=2)
    again = draw(st.sampled_from([["rejected"], ENDS]))
    found = counting(draw(st.integers(5, 25)), again, draw(effects))
    other: Json = {"on": again, "when": {"key": "n", "==": draw(st.integers(1, 20))}, "to": "going"}
    other["do"] = [{"set": "n", "add": draw(st.integers(1, 3))}, *draw(effects)]
    found["states"]["going"]["transitions"].insert(draw(st.integers(0, 2)), other)
    return found


@settings(lenient, max_examples=3)
@given(counting_documents())
def test_any_counter_is_counted_alike(document: Json) -> None:
    assume(hold_against_every_microstep(document, most=2_000))


@pytest.mark.drill
@settings(lenient, max_examples=1000)
@given(st.one_of(mission_documents(), counting_documents()))
def test_any_mission_is_explored_alike(document: Json) -> None:
    assume(hold_against_every_microstep(document, most=FEW, work=WORK))
