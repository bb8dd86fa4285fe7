# SPDX-License-Identifier: Apache-2.0
"""The question "did you mean …?" and its answer, put to the mission's chart."""

from __future__ import annotations

from typing import Any

import pytest

from tests.desk.hostile import Trial
from tests.desk.scenes import Case

CUBES = ("red_cube", "blue_cube", "green_cube")
ASKED = "put the red cube on the blue or the green one"


def on(lower: str) -> dict[str, Any]:
    return {"all": [{"on": ["red_cube", lower]}]}


class Asked(Trial):
    """A person who is asked what is meant, and answers with these sentences; no model has a proposal."""

    def __init__(self, *answers: str, request: str = ASKED) -> None:
        poses = [{"x": 0.5, "y": 0.15 * number - 0.15, "yaw": 0.0} for number in range(len(CUBES))]
        objects = [
            {"name": name, "type": "cube", "colour": name[:-5], "pose": pose}
            for name, pose in zip(CUBES, poses, strict=True)
        ]
        super().__init__(0, Case(0, request, {"scene": {"objects": objects}}, "succeeded"))
        self.answers = list(answers)

    def of_model(self) -> dict[str, Any]:
        return {"option": "ask"}

    def of_person(self, question: Any) -> dict[str, Any]:
        if not self.answers:
            return {"option": "leave"}
        return {"option": "say", "parameters": {"request": self.answers.pop(0)}}


@pytest.mark.parametrize(
    ("answers", "wanted"),
    [
        (["the second"], on("green_cube")), (["das erste"], on("blue_cube")), (["the green one"], on("green_cube")),
        (["put the red cube on the blue cube"], on("blue_cube")), (["hm", "the second"], None),
        (["the third"], None), (["whatever"], None), (["no"], None),
        (["put the blue cube on the red cube"], {"all": [{"on": ["blue_cube", "red_cube"]}]}),
    ],
)  # fmt: skip
def test_an_answer_chooses_what_was_offered_or_is_a_request_of_its_own(answers: list[str], wanted: Any) -> None:
    one = Asked(*answers)
    end = one.run()
    assert (end.acted, one.wanted) == (wanted is not None, wanted)


def test_a_count_means_nothing_before_a_question() -> None:
    one = Asked("the second", request="blorp the red cube")
    assert not one.run().acted and one.wanted is None
