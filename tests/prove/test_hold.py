# SPDX-License-Identifier: Apache-2.0
"""The operator takes control and gives it back in every state of an exploration: no run of the real chart leaves it."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from tests.prove.explored import HANDS, explored, scripts, walked
from tests.strategies import mission_documents

Json = dict[str, Any]
Script = list[tuple[tuple[Any, ...], float]]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
NEEDS = (None, None, "autonomy", "agent", "agent", "operator")


@st.composite
def controlled(draw: st.DrawFn) -> Json:
    """A mission whose states need the control of this one and that one."""
    given: Json = draw(mission_documents())
    needs = iter(draw(st.lists(st.sampled_from(NEEDS), min_size=40, max_size=40)))

    def dressed(room: Json) -> Json:
        return {name: dress(state) for name, state in room.items()}

    def dress(state: Json) -> Json:
        inner: Json = {word: dressed(state[word]) for word in ("states", "parallel") if word in state}
        need = next(needs, None) if not state.keys() & {"final", "history"} else None
        left = {word: value for word, value in state.items() if word != "control"}
        return {**left, **inner, **({"control": need} if need else {})}

    return {**given, "states": dressed(given["states"])}


@st.composite
def handed(draw: st.DrawFn) -> Script:
    """What happens, and in the midst of it control changes hands again and again."""
    hands = st.tuples(st.just("control"), st.sampled_from(HANDS), st.sampled_from(["operator", "operator", "robot"]))
    made: Script = []
    for each in draw(scripts()):
        made.append(each)
        if draw(st.integers(0, 2)) == 0:
            made.append((draw(hands), 0.5))
    return made


def stays_in_what_is_explored(given: Json, script: Script, most: int) -> None:
    mission = Mission.model_validate(given)
    space = explored(mission, most)
    assume(space.is_whole)
    for number, found in enumerate(walked(mission, script, space.environment.world.assumed)):
        assert found in space.seen, f"step {number} of {script}"


@settings(lenient, max_examples=4)
@given(controlled(), handed())
def test_no_run_with_an_operator_who_takes_and_gives_control_leaves_what_was_explored(
    given: Json, script: Script
) -> None:
    stays_in_what_is_explored(given, script, 60)


@pytest.mark.drill
@settings(lenient, max_examples=300)
@given(controlled(), handed())
def test_no_run_with_an_operator_leaves_what_was_explored_however_often_it_is_tried(
    given: Json, script: Script
) -> None:
    stays_in_what_is_explored(given, script, 1500)
