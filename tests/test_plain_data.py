# SPDX-License-Identifier: Apache-2.0
"""Anyone who is asked or commanded may tinker with what it was given: the mission, and what is known, stay as they
are."""

from __future__ import annotations

import copy
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import FrameType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from langchain_core.messages import AIMessage
from langchain_core.tools import BaseTool, StructuredTool

from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.test_models import ScriptedModel
from rai_missions.engine.decision import Offer, Question
from rai_missions.image import Image
from rai_missions.journal.json_values import from_json, to_json
from rai_missions.mission.files import dump
from rai_missions.plain_data import apart, are_finite, json_object, json_value, listed, plain, quoted, rounded
from rai_missions.profile import dump_profile
from rai_missions.profile import plain as plain_message
from rai_missions.testing import QUESTION, ReplyCollector, call
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import Rig, mission, robot

SPEED = {"type": "object", "properties": {"speed": {"type": "number", "maximum": 1}}, "additionalProperties": False}
FAST = {"option": "go", "parameters": {"speed": 9, "state": "done"}}
STATES: dict[str, Any] = {
    "asking": {
        "decision": {
            "question": "How fast?",
            "evidence": ["route"],
            "options": {"go": {"parameters": SPEED}, "stop": {}},
            "ask": ["agent"],
            "attempts": 2,
            "deadline_s": 30,
            "fallback": "stop",
        },
        "transitions": [{"on": "go", "to": "lost"}, {"on": "stop", "to": "moving"}],
    },
    "moving": {
        "action": "move",
        "goal": {"route": {"from": "route"}, "limits": [1, 2]},
        "timeout_s": 5,
        "transitions": [{"on": "succeeded", "to": "over"}],
    },
    "over": {"final": "aborted"},
    "lost": {"final": "failed"},
}
KEYS = {"route": {"type": "list", "source": "mission", "initial": [{"x": 1}, [2, 3]]}}
ROUTE = [{"x": 1}, [2, 3]]
IMAGE = Image("camera@1", 1, 1, "rgb8", b"abc")
json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=3) | st.just(IMAGE),
    lambda inner: st.lists(inner) | st.tuples(inner) | st.dictionaries(st.text(max_size=3), inner),
)


def spoil(value: Any) -> None:
    """Take every bound out of a schema, and put something else into whatever can hold it."""
    for item in list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else ():
        spoil(item)
    if isinstance(value, dict):
        value.pop("maximum", None)
        value.pop("additionalProperties", None)
        value["spoilt"] = True
    elif isinstance(value, list):
        value.append("spoilt")


class Pruning(ScriptedModel):
    """Cuts what its server does not know out of the schemas that it is given, as packages of providers do."""

    def bind_tools(self, tools: Sequence[Any], **bound: Any) -> Any:
        self._given.append(copy.deepcopy(list(tools)))
        spoil(list(tools))
        return super().bind_tools(tools, **bound)

    def with_structured_output(self, schema: Any, **bound: Any) -> Any:
        self._given.append(copy.deepcopy(schema))
        spoil(schema)
        return super().with_structured_output(schema, **bound)

    _given: list[Any] = []  # noqa: RUF012 - pydantic's private attribute: each model has its own


class Tinkering:
    """Spoils what it is shown, then answers what that would allow."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        for each in question.evidence:
            spoil(each.value)
        for offer in question.options:
            spoil(offer.parameters)
        answer(FAST)

    def withdraw(self, number: int) -> None:
        pass


def parts(value: Any) -> Iterator[Any]:
    if isinstance(value, dict | list | tuple):
        if isinstance(value, dict | list):
            yield value
        for item in value.values() if isinstance(value, dict) else value:
            yield from parts(item)


@given(json_values)
def test_what_is_apart_is_equal_and_shares_nothing_that_can_be_changed(value: Any) -> None:
    made = apart(value)
    assert made == value
    assert not {id(part) for part in parts(made)} & {id(part) for part in parts(value)}


@given(json_values)
def test_what_is_plain_is_json(value: Any) -> None:
    made = plain(value)
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_what_json_has_not_becomes_text() -> None:
    assert plain([math.inf, -math.inf, b"\x00", {1: {2}}]) == ["inf", "-inf", "AA==", {"1": [2]}]
    assert plain(Tinkering) == str(Tinkering)
    assert plain(IMAGE) == {"picture": "camera@1", "width": 1, "height": 1, "encoding": "rgb8"}


@pytest.mark.parametrize("values", [[1.0, math.inf], [1.0, math.nan], [1.0, 2], [True], ["1"], [[1.0]], [None]])
def test_a_list_is_looked_at_item_by_item_unless_all_are_finite_numbers(values: list[Any]) -> None:
    assert not are_finite(values)
    assert are_finite([]) and are_finite([1.0, -2.5, 1e300])


@pytest.mark.parametrize(
    "read", [plain, plain_message, to_json, lambda value: from_json(value, lambda ref, digest: bytes)],
    ids=["for readers", "of a robot", "to a journal", "from a journal"],
)  # fmt: skip
def test_the_numbers_of_a_scan_are_read_at_once(read: Callable[[Any], Any]) -> None:
    calls, scan = [0], [0.5] * 1000

    def called(frame: FrameType, event: str, what: object) -> None:
        calls[0] += event == "call" and "rai_missions" in frame.f_code.co_filename  # none of a collection of garbage

    sys.setprofile(called)
    try:
        made = read(scan)
    finally:
        sys.setprofile(None)
    assert made == scan and made is not scan
    assert calls[0] < 10


@pytest.mark.parametrize("profile", [{}, {"tool_calling": True, "structured_output": False}])
def test_a_model_that_cuts_into_its_schemas_finds_them_whole_the_next_time(profile: dict[str, Any]) -> None:
    reported = AIMessage('{"option": "stop"}') if not profile else AIMessage("", tool_calls=[call("stop")])
    model = Pruning([reported, reported], profile=profile)
    question = QUESTION._replace(options=(Offer("go", parameters=copy.deepcopy(SPEED)), Offer("stop")))
    for number in (1, 2):
        agent, results = DecisionAgent(model), ReplyCollector()
        agent.ask(question._replace(number=number), results)
        assert results.wait()["option"] == "stop"
    first, second = model._given
    assert first == second
    assert question.options[0].parameters == SPEED


def test_a_model_is_given_no_tool_that_it_could_use_by_itself() -> None:
    look = StructuredTool.from_function(
        lambda: "a crate", name="look", description="Look.", metadata={"read_only": True}
    )
    model, reported = ScriptedModel([AIMessage("", tool_calls=[call("abort")])]), ReplyCollector()
    DecisionAgent(model, tools=[look]).ask(QUESTION._replace(tools=("look",)), reported)
    assert reported.wait()["option"] == "abort"
    offered = model.received[0][1]["tools"]
    assert not [each for each in offered if isinstance(each, BaseTool)]
    assert offered[0]["function"]["name"] == "look"


@pytest.mark.parametrize("who", ["model", "program"])
def test_no_one_widens_what_an_option_takes(who: str) -> None:
    given, book = mission(STATES, blackboard=KEYS), MemoryJournal()
    written = dump(given)
    fast = AIMessage("", tool_calls=[call("go", **FAST["parameters"])])
    model = Pruning([fast, fast], profile={"tool_calling": True, "structured_output": False})
    agent: Any = DecisionAgent(model) if who == "model" else Tinkering()
    rig = Rig(given, answerers={"agent": agent}, journal=book)
    rig.move.at_once = ("accepted", "succeeded")
    assert rig.run().outcome == "aborted", "the fallback, and on from there"
    assert len([note for step in book.steps for note in step.notes if "refused, the parameters of 'go'" in note]) == 2
    assert dump(given) == written
    assert rig.runner.view.board["route"].value == ROUTE


def test_a_server_that_changes_its_goal_changes_nothing_else() -> None:
    profile = robot(actions={"move": {"action": "/move", "type": "x/action/Move", "goal": {"via": [{"y": 0}]}}})
    given = mission({name: STATES[name] for name in ("moving", "over")}, blackboard=KEYS)
    before = dump(given), dump_profile(profile)
    rig = Rig(given, robot=profile)
    accept = rig.move.accept
    rig.move.accept = lambda goal_id, goal, report: (spoil(goal), accept(goal_id, goal, report))[1]
    rig.move.at_once = ("accepted", "succeeded")
    assert rig.run().outcome == "aborted"
    assert rig.move.given[0]["spoilt"]
    assert (dump(given), dump_profile(profile)) == before
    assert rig.runner.view.board["route"].value == ROUTE


@pytest.mark.parametrize(
    ("value", "name", "words"),
    [
        (0.1 + 0.2, "", "0.3"), (4.9411234, "distance_m", "4.941"), (-0.0001, "offset_m", "0"),
        (12.3456, "left_s", "12.35"),
        (1234.5678, "", "1234.568"), (0.000123456, "", "0.000123"), (100.0, "", "100"), (1e20, "", "1e+20"),
        (5e-324, "", "4.94e-324"), (0.0, "", "0"), (float("nan"), "", "nan"), (float("-inf"), "_m", "-inf"),
    ],
)  # fmt: skip
def test_a_number_is_rounded_to_its_meaning(value: float, name: str, words: str) -> None:
    assert rounded(value, name) == words


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_rounded_number_is_near_and_rounding_it_again_changes_nothing(value: float) -> None:
    again = float(rounded(value))
    assert abs(again - value) <= max(5.1e-4, abs(value) * 5.1e-3)
    assert rounded(again) == rounded(value)


def test_a_text_inside_a_value_cannot_look_like_another_field() -> None:
    assert quoted({"kind": "crate, living false", "height_m": 0.30000000000000004}) == (
        '{"kind": "crate, living false", "height_m": 0.3}'
    )
    assert listed({"held": None, "open": True, "at": [0.1 + 0.2, 2.0]}) == "held none, open true, at [0.3, 2]"
    assert listed({"beds": [{"x": 1, "y": 2}, {"x": 3, "y": 4}]}) == "beds [x 1, y 2; x 3, y 4]"


LEAVES = st.none() | st.booleans() | st.integers() | st.text()


@given(st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)))
def test_text_gives_the_json_that_it_holds_and_an_object_only_where_it_is_one(value: Any) -> None:
    text = json.dumps(value)
    assert json_value(text, "other") == json_value(text.encode()) == value
    assert json_object(text) == (value if isinstance(value, dict) else None)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, b"\xff", "nul"])
def test_text_that_holds_no_json_is_no_error(text: str | bytes) -> None:
    assert (json_value(text, "other"), json_object(text)) == ("other", None)
