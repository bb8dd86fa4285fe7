# SPDX-License-Identifier: Apache-2.0
"""What cannot be, or must not be, is never acted on, whatever a model answers and a person confirms."""

from __future__ import annotations

from typing import Any

import pytest

from tests.desk.disturbed import Disturbed
from tests.desk.hostile import Trial, put_to_the_mission
from tests.desk.scenes import Case
from tests.desk.test_desk import TWO


def acted(first: int, count: int) -> list[str]:
    ends = [put_to_the_mission(seed) for seed in range(first, first + count)]
    assert sum(end.asked for end in ends) > count, "the model was asked often enough"
    return [end.case.request for end in ends if end.acted or end.outcome != "aborted"]


def test_what_must_not_be_is_not_acted_on_whatever_is_answered() -> None:
    assert acted(0, 60) == []


@pytest.mark.drill
def test_what_must_not_be_is_not_acted_on_in_many_more_desks() -> None:
    assert acted(1000, 3000) == []


def acted_amid(first: int, count: int) -> list[str]:
    """Control changes hands, the run pauses, and old questions are answered."""
    ends = [Disturbed(seed).run() for seed in range(first, first + count)]
    assert sum(end.asked for end in ends) > 2 * count, "the model was asked often enough"
    return [end.case.request for end in ends if end.acted]


def test_what_must_not_be_is_not_acted_on_amid_a_handover() -> None:
    assert acted_amid(0, 15) == []


@pytest.mark.drill
def test_what_must_not_be_is_not_acted_on_amid_many_more_handovers() -> None:
    assert acted_amid(1000, 2000) == []


def test_what_may_be_is_acted_on_amid_a_handover() -> None:
    """So the law above can fail."""
    assert sum(Disturbed(seed, clear(), {"all": [{"on": ["red_cube", "blue_cube"]}]}).run().acted for seed in range(6))


def clear() -> Case:
    """Two cubes, and a request that no rule reads but a model may."""
    return Case(0, "please shlonk the red cube on the blue cube", {"scene": coloured()}, "aborted")


def coloured() -> dict[str, Any]:
    """Two cubes, by their colours."""
    objects = [{**each, "name": f"{each['colour']}_cube"} for each in TWO["scene"]["objects"]]
    return {"objects": [{**each, "pose": {"yaw": 0.0, **each["pose"]}} for each in objects]}


@pytest.mark.parametrize(
    ("request_text", "goal", "is_acted_on"),
    [
        ("please shlonk the red cube on the blue cube", {"on": ["red_cube", "blue_cube"]}, True),
        ("please shlonk the red cube on the blue cube", {"on": ["blue_cube", "red_cube"]}, True),
        ("please shlonk the red cube on the blue cube", {"next_to": ["blue_cube", "red_cube"]}, False),
        ("please do not shlonk the red cube on the blue cube", {"on": ["red_cube", "blue_cube"]}, False),
        ("please shlonk the red cube at x 3 y 0", {"at": "red_cube", "x": 3.0, "y": 0.0}, False),
        ("please shlonk the red cube in the blue cube", {"in": ["red_cube", "blue_cube"]}, False),
    ],
)
def test_a_confirmed_goal_is_acted_on_only_if_its_words_are_there_and_it_can_be(
    request_text: str, goal: dict[str, object], *, is_acted_on: bool
) -> None:
    """The first two lines are what shows that the law above can fail: the person confirms, and the arm would move."""
    end = Trial(0, Case(0, request_text, {"scene": coloured()}, "aborted"), {"all": [goal]}).run()
    assert (end.acted, end.confirmed > 0) == (is_acted_on, is_acted_on)
