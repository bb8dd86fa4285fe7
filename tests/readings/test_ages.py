# SPDX-License-Identifier: Apache-2.0
"""A reading is as old as its own stamp reports, also where that lies before the run began; against a small oracle."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from tests.rigs.runs import KEYS, Rig, mission

MAX_AGE_S = 2.0
ENDS_AT = 9.0
BATTERY = "sensor_msgs/msg/BatteryState"


class Reading(NamedTuple):
    """One message of the battery: when it is received, and the stamp that it carries."""

    received: float
    stamp: float | None
    """None: it has no stamp; 0: its sender has not filled it in."""
    form: str
    """Where the stamp is in the message, and of which type."""

    def message(self) -> dict[str, Any]:
        if self.stamp is None:
            return {"percentage": 0.5}
        nanoseconds = round(self.stamp * 1e9)
        time = {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
        stamp: Any = time if self.form.endswith("time") else self.stamp
        return {
            "percentage": 0.5,
            **({"header": {"stamp": stamp}} if self.form.startswith("header") else {"stamp": stamp}),
        }


# A reading is received at a multiple of 0.1 s; no age ends at one, so that nothing depends on which of two comes first.
ticks = st.integers(0, 60).map(lambda tick: tick / 10)
behind = st.sampled_from([0.02, 0.42, 1.12, 1.92, 2.02, 3.52, 7.22, 60.02, 3600.02])
forms = st.sampled_from(["header time", "header number", "time", "number"])


@st.composite
def readings(draw: st.DrawFn) -> list[Reading]:
    """Stamped before, at and after the run's start, in the future, zero, not at all; going forward and backward."""
    made = []
    for received in sorted(draw(st.lists(ticks, min_size=1, max_size=8, unique=True))):
        kind = draw(st.sampled_from(["behind", "behind", "future", "now", "zero", "none"]))
        by_s = draw(behind)
        stamp = {"behind": received - by_s, "future": received + by_s, "now": received, "zero": 0.0, "none": None}[kind]
        made.append(Reading(received, stamp, draw(forms)))
    return made


def fresh_at(given_: list[Reading], at: float) -> bool:
    """Design: age counts from the stamp; zero is none, then receipt counts; the future is stamped with its receipt."""
    stamps = [
        each.received if not each.stamp or each.stamp > each.received else each.stamp
        for each in given_
        if each.received <= at
    ]
    return bool(stamps) and at - max(stamps) < MAX_AGE_S


def looked_at(given_: list[Reading]) -> dict[float, bool | None]:
    """When → whether the key was fresh for a run, asked half a tick after each tick."""
    asks = {"state": {"transitions": [{"on": "go", "when": {"fresh": "battery"}}, {"on": "stop_now", "to": "end"}]},
            "end": {"final": "aborted"}}  # fmt: skip
    rig = Rig(asks)
    rig.stage.period_s = 0.05
    rig.stage.play(
        {each.received: lambda each=each: rig.connector.publish("/battery", BATTERY, each.message()) for each in given_}
    )
    moments = [round(tick / 5 + 0.05, 6) for tick in range(round(ENDS_AT * 5))]
    rig.stage.play({at: lambda: rig.post("go") for at in moments})
    rig.stage.play({ENDS_AT: lambda: rig.post("stop_now")})
    rig.run()
    return {round(step.at, 6): step.guards[0][1] for step in rig.book.steps if step.event.name == "go"}


@given(readings())
def test_a_key_is_as_old_as_its_own_stamp(given_: list[Reading]) -> None:
    for at, fresh in looked_at(given_).items():
        assert fresh is fresh_at(given_, at), f"at {at} s after {given_}"


@pytest.mark.drill
@given(readings())
@settings(max_examples=1000)
def test_a_key_is_as_old_as_its_own_stamp_in_many_runs(given_: list[Reading]) -> None:
    for at, fresh in looked_at(given_).items():
        assert fresh is fresh_at(given_, at), f"at {at} s after {given_}"


def test_what_was_stamped_an_hour_ago_is_not_fresh() -> None:
    assert not any(looked_at([Reading(0.1, -3599.9, "header time")]).values())


def test_a_topic_that_lags_is_not_fresh_however_long_the_run_is() -> None:
    late = [Reading(tick / 10, tick / 10 - 60.05, "header time") for tick in range(1, 80)]
    assert not any(looked_at(late).values())


def test_a_start_that_waits_for_a_reading_that_is_too_old_is_refused() -> None:
    keys = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=keys, ready_s=2))
    old = Reading(0.5, -3599.5, "header time")
    rig.stage.play({0.5: lambda: rig.connector.publish("/battery", BATTERY, old.message())})
    with pytest.raises(UsageError, match=r"battery was received, but 3600\.0 s old"):
        rig.run()
