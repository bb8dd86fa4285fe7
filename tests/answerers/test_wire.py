# SPDX-License-Identifier: Apache-2.0
"""The decision agent over a provider's own package and a real socket: a loopback server of OpenAI's shape."""

from __future__ import annotations

import base64
import json
import threading
from typing import TYPE_CHECKING, Any

import pytest
from langchain_core.tools import StructuredTool

from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.model.foreign_server import address_of
from rai_missions.answerers.model.output_modes import calls_tools, fills_schemas, takes_images
from rai_missions.engine.decision import Evidence, Limits, Question
from rai_missions.image import Image
from rai_missions.testing import QUESTION, ReplyCollector, answer_fault
from tests.rigs.chat_server import Reply, Server, completion, refused, server
from tests.sampled import sampled

if TYPE_CHECKING:
    from langchain_openai import ChatOpenAI

__all__ = ("server",)


def answer(model: ChatOpenAI, question: Question = QUESTION, **words: Any) -> dict[str, Any]:
    agent, reported = DecisionAgent(model, **words), ReplyCollector()
    agent.ask(question, reported)
    reply = dict(reported.wait())
    agent.stop(within_s=0.1)
    assert not answer_fault(reply), answer_fault(reply)
    return reply


def test_a_schema_goes_out_and_one_object_comes_back(server: Server) -> None:
    server.replies = [completion('{"why": "a log", "option": "replan"}')]
    reply = answer(server.model())
    assert (reply["option"], reply["why"]) == ("replan", "a log")
    assert reply["usage"] | {"seconds": 0} == {
        "calls": 1,
        "tokens_in": 90,
        "tokens_out": 10,
        "seconds": 0,
        "model": "gpt-4o-2024-08-06",
    }
    form = server.requests[0]["response_format"]
    assert form["type"] == "json_schema"
    assert form["json_schema"]["schema"]["properties"]["option"]["enum"] == ["replan", "signal", "abort"]
    assert "tools" not in server.requests[0]


def test_functions_go_out_and_one_call_comes_back(server: Server) -> None:
    server.replies = [completion(calls=[("signal", '{"why": "a deer"}')])]
    reply = answer(server.model(), mode="tools")
    assert (reply["option"], reply["why"], reply["parameters"]) == ("signal", "a deer", {})
    (asked,) = server.requests
    assert [each["function"]["name"] for each in asked["tools"]] == ["replan", "signal", "abort"]
    assert asked["tool_choice"] == "required"


def test_two_calls_at_once_are_none(server: Server) -> None:
    server.replies = [completion(calls=[("signal", "{}"), ("abort", "{}")])]
    assert answer(server.model(), mode="tools")["failed"] == "answered with 2 calls; one was asked for"


def test_a_call_whose_arguments_are_broken_is_none(server: Server) -> None:
    server.replies = [completion(calls=[("signal", '{"why": ')])]
    assert answer(server.model(), mode="tools")["failed"] == "answered with 1 call whose arguments are not JSON"


def test_a_read_only_tool_is_looked_up_over_the_wire(server: Server) -> None:
    look = StructuredTool.from_function(
        lambda: "a crate", name="look", description="Look.", metadata={"read_only": True}
    )
    server.replies = [completion(calls=[("look", "{}")]), completion(calls=[("replan", "{}")])]
    reply = answer(server.model(), QUESTION._replace(tools=("look",)), tools=[look])
    assert (reply["option"], reply["usage"]["calls"], reply["usage"]["tokens_in"]) == ("replan", 3, 180)
    assert server.requests[1]["messages"][-1] == {"role": "tool", "tool_call_id": "call_0", "content": '"a crate"'}


def test_pictures_go_out_as_png(server: Server) -> None:
    camera = Image("camera@1.000", 2, 1, "rgb8", b"\xff\x00\x00\x00\xff\x00")
    question = QUESTION._replace(evidence=(Evidence("camera", camera, 0.1, fresh=True),))
    server.replies = [completion('{"option": "abort"}')]
    answer(server.model(), question)
    *_, caption, picture = server.requests[0]["messages"][-1]["content"]
    assert caption == {"type": "text", "text": "The picture camera: a picture, 0.1 s old:"}
    head, _, data = picture["image_url"]["url"].partition(",")
    assert head == "data:image/png;base64"
    assert base64.b64decode(data).startswith(b"\x89PNG\r\n\x1a\n")


def test_a_server_without_schemas_is_asked_in_the_next_way(server: Server) -> None:
    server.replies = [
        refused(400, "response_format is unknown"),
        refused(500, "tools need a template"),
        completion("abort"),
    ]
    reply = answer(server.model())
    assert (reply["option"], reply["usage"]["calls"]) == ("abort", 3)
    assert [sorted({"response_format", "tools"} & set(asked)) for asked in server.requests] == [
        ["response_format"],
        ["tools"],
        [],
    ]


@pytest.mark.parametrize(
    ("reply", "why"),
    [
        (
            refused(401, "Incorrect API key provided: sk-loopback-0123456789"),
            "Error code: 401 - Incorrect API key provided: [hidden]",
        ),
        (refused(429, "slow down"), "Error code: 429 - slow down"),
        (completion(""), "answered nothing"),
        (completion('{"option": "rep'), "answered with JSON that is broken"),
    ],
)
def test_a_server_at_fault_is_reported_without_its_key(server: Server, reply: Reply, why: str) -> None:
    server.replies = [reply]
    text = answer(server.model())
    assert why in text["failed"]
    assert "0123456789" not in json.dumps(text)


PAGE = {"content-type": "text/html"}
FOREIGN: dict[str, Reply] = {
    "a page": lambda _: (200, b"<html><body>Welcome</body></html>", PAGE),
    "a page that calls itself JSON": lambda _: (200, b"<html>", {}),
    "no text": lambda _: (200, b"", {}),
    "a text": lambda _: (200, b"ok", {"content-type": "text/plain"}),
    "JSON that is no object": lambda _: (200, [], {}),
    "no JSON value": lambda _: (200, None, {}),
    "JSON of another form": lambda _: (200, {"detail": "Hello"}, {}),
    "no choice": lambda _: (200, {"choices": []}, {}),
    "an empty choice": lambda _: (200, {"choices": [{}]}, {}),
    "no such page": lambda _: (404, b"<html>Not Found</html>", PAGE),
    "a page for those who are known": lambda _: (403, b"<html>Log in</html>", PAGE),
    "another place": lambda _: (301, b"<html>Moved</html>", PAGE),
}


@pytest.mark.parametrize("mode", sampled(["json_schema", "tools", "text"], 3))
@pytest.mark.parametrize("streaming", [False, True], ids=["whole", "streamed"])
@pytest.mark.parametrize("reply", FOREIGN.values(), ids=FOREIGN)
def test_a_server_of_another_kind_is_named_with_its_url(
    server: Server, reply: Reply, mode: str, *, streaming: bool
) -> None:
    server.replies = [reply]
    why = answer(server.model(streaming=streaming), mode=mode)["failed"]
    assert f"ForeignServer: '{server.url}' gave no reply of a chat model; name the URL of its API" in why
    assert "ends in /v1 (" in why


@pytest.mark.parametrize("status", [429, 502, 503])
def test_a_busy_servers_page_is_that_of_a_server_to_be_asked_again(server: Server, status: int) -> None:
    server.replies = [lambda _: (status, b"<html>", PAGE)]
    assert f"Error code: {status}" in answer(server.model())["failed"]


def test_the_url_of_a_model_is_named_without_its_password(server: Server) -> None:
    model = server.model(base_url="http://someone:a-password@127.0.0.1:8000/v1/?key=abc")
    assert address_of(model) == "http://127.0.0.1:8000/v1"


def test_a_server_that_hangs_is_given_up(server: Server) -> None:
    free = threading.Event()
    server.replies = [lambda asked: (free.wait(10), completion("abort")(asked))[1]]
    reply = answer(server.model(), QUESTION._replace(budget=Limits(seconds=0.2)))
    free.set()
    assert reply["failed"].startswith("no answer within 0.")


def test_what_a_model_can_do_is_found_out_without_asking_it(server: Server) -> None:
    for name, pictures in (("gpt-4o", True), ("of-no-profile", False)):
        model = server.model(model=name)
        assert (calls_tools(model), fills_schemas(model), takes_images(model)) == (True, True, pictures)
    assert server.requests == []
