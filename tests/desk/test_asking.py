# SPDX-License-Identifier: Apache-2.0
"""The question "did you mean …?" and its answer, put to the mission's chart."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.event import Tick
from rai_missions.mission.files import load
from rai_missions.planning import Thing
from rai_missions.planning.reading import reading_of
from rai_missions.planning.tolerances import WALL_M
from rai_missions.trees import PyTrees
from tests.desk.episodes import DESK_MISSIONS
from tests.desk.hostile import Trial
from tests.desk.scenes import Case
from tests.planning.scenes import scene, thing

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


def test_what_was_meant_is_unclear_once_more_is_seen_so_no_success_is_claimed() -> None:
    """A second red cube comes into sight, and a second apple: which cube was meant is open, and an apple is missing."""
    placed = [
        thing("tray", 0.5, 0.3), thing("red_cube", 0.42, 0.3, level=WALL_M, colour="red"),
        thing("apple", 0.56, 0.3, level=WALL_M),
    ]  # fmt: skip
    later = [*placed, thing("red_cube_2", 0.5, -0.2, colour="red"), thing("apple_2", 0.5, -0.4)]
    assert settled(placed, placed).outcome == "succeeded"
    end = settled(placed, later)
    assert (end.outcome, end.view.board["report"].value) == ("failed", reading_of(BOTH_KINDS, scene(*later)).question)


BOTH_KINDS = "put the red cube and the apples in the tray"


def settled(first: list[Thing], later: list[Thing]) -> Chart:
    """The mission where all is so already, and other things are seen from 1.6 s on, while it settles."""
    chart, at = Chart(load(DESK_MISSIONS / "arrange.json"), ticker=PyTrees()), 0.0
    chart.write("request", BOTH_KINDS, at)
    for step in range(300):
        if chart.outcome is not None:
            break
        at = 0.2 * step
        things = [each.model_dump(mode="json") | {"looks": 30} for each in (first if at < 1.6 else later)]
        seen = {"things": things, "gripper": "empty", "unsure": 0, "looks": 30, "stamp_s": at}
        chart.write("objects", seen, at)
        chart.write("gripper", {"width_m": 0.08, "holding": False, "left_n": 0.0, "right_n": 0.0}, at)
        chart.start(at) if step == 0 else chart.send(Tick(at))
    return chart
