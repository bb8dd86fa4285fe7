# SPDX-License-Identifier: Apache-2.0
"""Invariants are evaluated whatever stops: a pause and a hold leave the time of their `held` as it is."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

PERIOD_S, FOR_S, LAST = 0.5, 2.0, 24
KEEPS_S = (None, 1.5)
"""For how long a reading counts."""
STOPS = {"pause": ("command", "pause", "resume"), "hold": ("control", "operator", "agent")}
scripts = st.dictionaries(
    st.integers(1, LAST - 1), st.sampled_from(["true", "true", "false", "stop", "go"]), max_size=12
)


def expected(script: dict[int, str], max_age_s: float | None) -> int | None:
    """The period in which the guard has held for long enough, worked out by looking at each."""
    held, is_true, written = 0.0, False, 0
    for period in range(1, LAST + 1):
        if max_age_s is not None and (period - written) * PERIOD_S >= max_age_s:
            is_true = False
        held = held + PERIOD_S if is_true else 0.0
        if held >= FOR_S:
            return period
        if script.get(period) in ("true", "false"):
            is_true, written = script[period] == "true", period
    return None


def found(script: dict[int, str], max_age_s: float | None, stop: str) -> int | None:
    """The period in which the chart has it so."""
    kind, *names = STOPS[stop]
    age = {} if max_age_s is None else {"max_age_s": max_age_s}
    chart = Chart(Mission.model_validate({
        "name": "held", "initial": "waiting", "states": {"waiting": {"control": "agent"}},
        "blackboard": {"clear": {"type": "boolean", "source": "robot", **age}},
        "invariants": {"short": {"not": {"held": {"key": "clear", "==": True}, "for_s": FOR_S}}},
    }))  # fmt: skip
    chart.send(Event("agent", 0.0, {"by": "operator", "role": "operator"}, "control"))
    chart.start(0.0)
    for period in range(1, LAST + 1):
        at, word = period * PERIOD_S, script.get(period)
        chart.send(Tick(at))
        if word in ("true", "false"):
            chart.write("clear", word == "true", at)
        elif word is not None:
            chart.send(Event(names[word == "go"], at, {"by": "operator", "role": "operator"}, kind))
        if chart.outcome is not None:
            return period
    return None


@given(scripts, st.sampled_from(KEEPS_S), st.sampled_from(sorted(STOPS)))
@example({1: "stop", 2: "true"}, None, "pause")
@example({1: "true", 3: "stop", 4: "go"}, None, "pause")
@example({1: "true", 3: "stop", 4: "false", 5: "true"}, None, "pause")
def test_the_time_of_an_invariant_does_not_stop(script: dict[int, str], max_age_s: float | None, stop: str) -> None:
    assert found(script, max_age_s, stop) == expected(script, max_age_s)
