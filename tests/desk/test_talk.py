# SPDX-License-Identifier: Apache-2.0
"""What is ordered by talk at the desk: the profile's sentences start the mission with the person's own words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.talk.settings import conversation_faults, settings_of
from rai_missions.conversation import KeyView, MissionView, StatusView
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language
from rai_missions.mission.files import load
from rai_missions.profile import load_profile
from rai_missions.testing import play_conversation
from tests.desk.episodes import DESK_MISSIONS
from tests.desk.hostile import Trial
from tests.desk.scenes import Case

STORED = json.loads(
    (Path(__file__).parents[1] / "conversation/data/conversations/desk.json").read_text(encoding="utf-8")
)["conversations"]
POSES = ((0.5, -0.2), (0.5, 0.2), (0.4, 0.0), (0.55, 0.0))
THINGS = ("red_cube", "blue_cube", "tomato", "apple")
SCENE = {
    "objects": [
        {
            "name": name,
            "type": name.split("_")[-1],
            "colour": name[:-5] if "_" in name else "",
            "pose": {"x": x, "y": y, "yaw": 0.0},
        }
        for name, (x, y) in zip(THINGS, POSES, strict=True)
    ]
}
REFUSED = ("smash", "tomate")


class Obeying(Trial):
    """A person who adds nothing, and no model."""

    def of_model(self) -> dict[str, Any]:
        return {"option": "ask"}

    def of_person(self, question: Any) -> dict[str, Any]:
        return {"option": "leave"}


def test_the_shipped_profile_starts_the_mission_with_the_sentence() -> None:
    robot, mission = load_profile(DESK_MISSIONS / "robot.sim.json"), load(DESK_MISSIONS / "arrange.json")
    assert conversation_faults(robot, mission) == ()
    settings = settings_of(robot.conversation)
    grammar = Grammar(language("en"), StartPhrases(settings.phrases, settings.names, language("en")))
    view = StatusView(missions=(MissionView("desk_arrange", "", (KeyView("request", "string", "argument"),)),))
    for verb in ("put", "place", "stack", "swap", "sort", "group", "build", "tidy", "throw", "smash"):
        (sense,) = grammar.senses(f"Could you {verb} the red cube, please?", view)
        assert (sense.name, sense.arguments) == ("start", {"request": f"{verb} the red cube"})


@pytest.mark.parametrize("conversation", STORED, ids=[each["name"] for each in STORED])
def test_what_a_conversation_orders_moves_the_arm_unless_it_cannot_be(conversation: dict[str, Any]) -> None:
    ordered = [one for played in play_conversation(conversation) for one in played.shown() if "order" in one]
    for order in ordered:
        request = order["arguments"]["request"]
        end = Obeying(0, Case(0, request, {"scene": SCENE}, "")).run()
        assert end.acted == (not any(word in request for word in REFUSED)), request
        assert end.acted or end.outcome == "aborted"
