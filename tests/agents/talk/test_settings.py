# SPDX-License-Identifier: Apache-2.0
"""What a profile states of talk is checked before a robot talks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.talk.run_status import mission_view
from rai_missions.agents.talk.settings import conversation_faults, conversation_oddities, settings_of
from rai_missions.cli.main import main
from rai_missions.conversation import Dialogue, StatusView, TalkNote, Utterance
from rai_missions.mission.mission import Mission
from rai_missions.profile import ConversationPolicy, Robot, load_profile

MISSION: dict[str, Any] = {
    "format": 1, "name": "errand", "initial": "over", "states": {"over": {"final": "aborted"}},
    "blackboard": {
        "task": {"type": "string", "source": "argument", "initial": "find"},
        "seen": {"type": "object", "source": "robot", "fields": {"text": "string"}, "optional": True},
    },
}  # fmt: skip
FAULTS = {
    "language": ({"language": "fr"}, "/conversation/language: no language 'fr'"),
    "phrase": ({"phrases": {"find (the": {}}}, "/conversation/phrases/find (the: the phrase 'find (the' is not closed"),
    "part": ({"phrases": {"<fnd>": {}}}, "/conversation/phrases/<fnd>: the phrase '<fnd>' names no part"),
    "question": ({"questions": {"see (you": "seen"}}, "/conversation/questions/see (you: the phrase 'see (you' is not"),
    "field": (
        {"questions": {"what do you see": "seen.txt"}},
        "/conversation/questions/what do you see: 'seen' has no field 'txt'; did you mean 'text'?",
    ),
    "evidence": (
        {"asked_with": ["seen.txt"]},
        "/conversation/asked_with/0: 'seen' has no field 'txt'; did you mean 'text'?",
    ),
    "argument": (
        {"phrases": {"find {objct}": {"task": "find"}}}, "the mission takes no argument 'objct'; it takes: task"
    ),
    "spoken": (
        {"spoken": {"go to the {plce}": {"task": "go"}}},
        "/conversation/spoken/go to the {plce}: the mission takes no argument 'plce'; it takes: task",
    ),
    "value": (
        {"phrases": {"find something": {"task": 3}}},
        "/conversation/phrases/find something: the argument 'task': 3 is not of type 'string'",
    ),
    "value of a name": (
        {"names": {"task": {"search": True}}},
        "/conversation/names/task/search: the argument 'task': true is not of type 'string'",
    ),
    "value read back": (
        {"spoken": {"find it": {"task": ["find"]}}},
        "/conversation/spoken/find it: the argument 'task': [\"find\"] is not of type 'string'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_wrong_is_found_by_check(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words, sentence = FAULTS[name]
    mission, robot = tmp_path / "mission.json", tmp_path / "robot.json"
    mission.write_text(json.dumps(MISSION))
    robot.write_text(json.dumps({"format": 1, "name": "bench", "connector": {"kind": "local"}, "conversation": words}))
    assert main(["check", str(mission), "--robot", str(robot)]) == 2
    assert sentence in capsys.readouterr().err


def test_a_sentence_or_key_of_another_mission_is_no_fault() -> None:
    other = ConversationPolicy(
        phrases={"find {object}": {"place": "house"}}, questions={"how deep": "water.depth_m"}, results=["depth"]
    )
    robot, mission = Robot(name="bench", conversation=other), Mission.model_validate(MISSION)
    assert conversation_faults(robot, mission) == ()
    assert tuple(conversation_oddities(robot, mission)) == ()


def test_an_object_without_fields_may_have_any_and_other_types_have_none() -> None:
    robot = Robot(name="bench", conversation=ConversationPolicy(asked_with=["seen.text", "task.text"]))
    free = {**MISSION, "blackboard": {**MISSION["blackboard"], "seen": {"type": "object", "source": "robot"}}}
    faults = conversation_faults(robot, Mission.model_validate(free))
    assert [each.place for each in faults] == ["/conversation/asked_with/1"]


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ({"results": ["sean"]}, "results/0"),
        ({"asked_with": ["sean.text"]}, "asked_with/0"),
        ({"questions": {"what do you see": "sean"}}, "questions/what do you see"),
    ],
    ids=["results", "asked_with", "questions"],
)
def test_a_key_that_resembles_one_of_the_mission_is_warned_of(
    words: dict[str, Any], place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mission, robot = tmp_path / "mission.json", tmp_path / "robot.json"
    mission.write_text(json.dumps(MISSION))
    source = {"seen": {"topic": "/seen", "type": "std_msgs/msg/String", "json": True}}
    robot.write_text(json.dumps({"format": 1, "name": "bench", "blackboard": source, "conversation": words}))
    assert main(["check", str(mission), "--robot", str(robot)]) == 0
    why = "warning: the mission has no key 'sean', so it is never spoken; did you mean 'seen'?"
    assert f"{robot}: /conversation/{place}: {why}\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "place"),
    [
        ({"phrases": {"do {tsk}": {}}}, "phrases/do {tsk}"),
        ({"spoken": {"{tsk} it": {}}}, "spoken/{tsk} it"),
        ({"names": {"tsk": {"search": "find"}}}, "names/tsk"),
    ],
    ids=["phrases", "spoken", "names"],
)
def test_an_argument_that_resembles_one_of_the_mission_is_warned_of(words: dict[str, Any], place: str) -> None:
    robot = Robot(name="bench", conversation=ConversationPolicy(**words))
    why = "the mission takes no argument 'tsk', so it is not used; did you mean 'task'?"
    assert [*map(str, conversation_oddities(robot, Mission.model_validate(MISSION)))] == [
        f"/conversation/{place}: {why}"
    ]


@pytest.mark.parametrize(
    ("words", "is_used"),
    [
        ({}, False),
        ({"conversation": {}}, True),
        ({"rules": {"over": [{"when": {"key": "seen.text", "==": "cup"}, "answer": "go"}]}}, True),
        ({"actions": {"look": {"start": "/look", "succeeded": {"fresh": "seen"}}}}, True),
    ],
    ids=["nothing", "people", "rules", "action"],
)
def test_a_fact_that_the_profile_reads_or_people_may_ask_for_is_used(
    words: dict[str, Any], is_used: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mission, robot = tmp_path / "mission.json", tmp_path / "robot.json"
    mission.write_text(json.dumps(MISSION))
    source = {"seen": {"topic": "/seen", "type": "std_msgs/msg/String", "json": True}}
    robot.write_text(json.dumps({"format": 1, "name": "bench", "blackboard": source} | words))
    main(["check", str(mission), "--robot", str(robot)])
    printed = capsys.readouterr().err
    assert ("/blackboard/seen: warning: nothing uses 'seen'" in printed) is not is_used
    assert "/blackboard/task: warning: nothing uses 'task'" in printed, "an argument is no fact of the robot"


def test_a_place_for_topics_that_are_not_opened_is_warned_of() -> None:
    robot = Robot(name="bench", conversation=ConversationPolicy(hri_below="/alpha"))
    (odd,) = conversation_oddities(robot, Mission.model_validate(MISSION))
    assert str(odd) == '/conversation/hri_below: without "hri": true no topic is opened there'


@pytest.mark.parametrize("name", ["sim", "ros2"])
def test_the_house_is_ordered_about_in_sentences_that_fit_its_missions(name: str) -> None:
    folder = Path(__file__).parents[3] / "missions" / "rosbot"
    robot = load_profile(folder / f"robot.{name}.json")
    for mission in ("assist", "mission"):
        given = Mission.model_validate_json((folder / f"{mission}.json").read_text())
        assert conversation_faults(robot, given) == ()
        assert tuple(conversation_oddities(robot, given)) == ()


def test_listed_values_are_named_as_they_are_written_where_the_profile_has_no_names() -> None:
    argument: dict[str, Any] = {"type": "string", "source": "argument"}
    keys = {"vent": {**argument, "enum": ["half_open", "shut"]}, "bed": {**argument, "enum": ["b1"]}, "crop": argument}
    mission = Mission.model_validate({**MISSION, "blackboard": keys})
    phrases: dict[str, Any] = {"set the vent to {vent}": {}}
    policy = ConversationPolicy.model_validate({"phrases": phrases, "names": {"bed": {"first bed": "b1"}}})
    settings = settings_of(policy, [mission])
    assert settings.names == {"vent": {"half open": "half_open", "shut": "shut"}, "bed": {"first bed": "b1"}}
    view = StatusView(mode="ready", missions=(mission_view(mission),))
    out = Dialogue(settings, view).on_utterance(Utterance("set the vent to half open", "operator", "terminal"), view)
    mapped = [each.data["order"] for each in out if isinstance(each, TalkNote) and each.kind == "mapped"]
    assert [each["arguments"] for each in mapped] == [{"vent": "half_open"}]
