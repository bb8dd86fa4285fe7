# SPDX-License-Identifier: Apache-2.0
"""A source whose clock is off is reported with the value, in either direction, and a refused start names it."""

from __future__ import annotations

import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.runtime.readings import Readings, SourceState, offset_words, refused
from tests.rigs.runs import KEYS, Rig, mission

NEEDED = {**KEYS, "battery": {**KEYS["battery"], "optional": False}}
BATTERY = "sensor_msgs/msg/BatteryState"
ages = st.none() | st.sampled_from([-3600.0, -2.0, -0.2, -0.05, 0.0, 0.05, 0.2, 0.21, 2.0, 3600.0]) | st.floats(-9, 9)


def offset_of(given_: list[tuple[float | None, bool]]) -> float | None:
    """Design: the smallest (receipt − stamp) of the last 20 readings, from 3 on; latched first ones do not count."""
    stamped = [age_s for age_s, kept in given_ if age_s is not None and not kept]
    return min(stamped[-20:]) if len(stamped) >= 3 and abs(min(stamped[-20:])) > 0.2 else None


@given(st.lists(st.tuples(ages, st.booleans()), max_size=60))
def test_an_offset_is_the_smallest_difference_of_the_last_readings(given_: list[tuple[float | None, bool]]) -> None:
    readings, reported = Readings(), 0
    for number, (age_s, kept) in enumerate(given_, 1):
        reported += readings.receive(age_s, kept=kept)
        assert readings.state.offset_s == offset_of(given_[:number])
        assert readings.state.received == number
    ever = any(offset_of(given_[:number]) is not None for number in range(len(given_) + 1))
    assert reported == ever, "it is reported once"


def publishes(rig: Rig, behind_s: float) -> None:
    """The battery, ten times a second, by a clock that is behind."""
    rig.stage.each = lambda: rig.connector.publish(
        "/battery", BATTERY, {"header": {"stamp": rig.stage.at - behind_s}, "percentage": 0.5}
    )


def test_a_refused_start_names_a_source_whose_stamps_are_behind(caplog: pytest.LogCaptureFixture) -> None:
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=NEEDED, ready_s=3))
    publishes(rig, 2.53)  # no stamp is zero by chance
    with caplog.at_level(logging.WARNING), pytest.raises(UsageError, match=r"received, but 2\.5 s old") as refused:
        rig.run()
    assert str(refused.value).endswith("; its stamps are 2.5 s behind.")
    assert next(each.getMessage().split(";")[0] for each in caplog.records) == "'battery': its stamps are 2.5 s behind"
    assert any("its stamps are 2.5 s behind" in note for note in rig.book.notes), "the journal has it too"


@pytest.mark.parametrize("behind_s", [-2.0, 0.5])
def test_a_source_that_is_off_and_fresh_all_the_same_is_reported_and_the_mission_starts(behind_s: float) -> None:
    rig = Rig(
        mission({"on": {"transitions": [{"after_s": 1, "to": "end"}]}, "end": {"final": "aborted"}}, blackboard=NEEDED)
    )
    publishes(rig, behind_s)
    assert rig.run().outcome == "aborted"
    state = rig.runner.view.source("battery")
    assert state.offset_s == pytest.approx(behind_s, abs=1e-6)


def test_a_source_that_is_right_is_not_reported(caplog: pytest.LogCaptureFixture) -> None:
    rig = Rig(
        mission({"on": {"transitions": [{"after_s": 1, "to": "end"}]}, "end": {"final": "aborted"}}, blackboard=NEEDED)
    )
    publishes(rig, 0.15)
    with caplog.at_level(logging.INFO):
        rig.run()
    assert rig.runner.view.source("battery").offset_s is None and rig.book.notes == []
    assert not [each for each in caplog.records if each.name.startswith("rai_missions")]


def test_what_was_received_and_not_understood_is_named_with_its_value() -> None:
    keys = {**NEEDED, "there": {**KEYS["there"], "optional": False}}
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=keys, ready_s=2))
    rig.stage.play(
        {
            0.5: lambda: rig.publish("/battery", percentage=float("nan")),
            0.6: lambda: rig.publish("/there", data="perhaps"),
        }
    )
    with pytest.raises(UsageError) as refused:
        rig.run()
    assert "battery was received and not understood: percentage is nan" in str(refused.value)
    assert "there was received and not understood: 'perhaps' is not of type 'boolean'" in str(refused.value)
    assert "has not reported" not in str(refused.value), "it is running"


def test_a_reading_that_is_understood_counts_although_one_before_was_not() -> None:
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=NEEDED))
    rig.stage.play(
        {
            0.5: lambda: rig.publish("/battery", percentage=float("nan")),
            0.7: lambda: rig.publish("/battery", percentage=0.5),
        }
    )
    assert rig.run().duration_s == pytest.approx(0.7)


def test_a_key_of_which_nothing_came_is_first_among_the_reasons() -> None:
    keys = {**NEEDED, "there": {**KEYS["there"], "optional": False}}
    rig = Rig(mission({"end": {"final": "aborted"}}, blackboard=keys, ready_s=2))
    rig.stage.play({0.5: lambda: rig.publish("/battery", percentage=float("inf"))})
    with pytest.raises(UsageError) as refused:
        rig.run()
    assert str(refused.value) == (
        "the robot has not reported within 2 s: there; is it running? "
        'A key that the start need not wait for is "optional". '
        "battery was received and not understood: percentage is inf."
    )


def test_a_source_is_named_where_its_name_is_not_that_of_its_key() -> None:
    silent = {"there": SourceState(name="/base/there"), "battery": SourceState(name="/batery"), "pose": SourceState()}
    sentence = refused(silent, {}, 10.0)
    assert sentence == ("the robot has not reported within 10 s: there, battery (/batery), pose; is it running?")


@pytest.mark.parametrize(("offset_s", "words"), [(0.3, "0.3 s behind"), (-0.3, "0.3 s ahead"), (2.5, "2.5 s behind")])
def test_an_offset_has_its_direction_in_words(offset_s: float, words: str) -> None:
    assert offset_words(offset_s) == f"its stamps are {words}"
