# SPDX-License-Identifier: Apache-2.0
"""A model's server that harms or breaks costs an attempt: over a real socket and through the provider's package."""

from __future__ import annotations

import gzip
import json
import logging
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest

from rai_missions.agents.talk.model import TalkModel
from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.model.process.model import ModelProcess
from rai_missions.conversation import AskModel, ModelText, StatusView
from rai_missions.testing import QUESTION, Inbox, ReplyCollector
from tests.rigs.chat_server import completion

SECRET = "sk-proj-Zk3mQ9vT7wXyB2nC5dF8hJ1lP4rS6uA0"
ABORT = json.dumps({"why": "so", "option": "abort"})
ATTEMPT_S = 1.5
Deed = Callable[[socket.socket, threading.Event], object]
"""What a server does with a request on this socket; the event ends what would last."""


class RawServer:
    """Does to each request what a test chose, byte by byte."""

    def __init__(self) -> None:
        self._chosen: tuple[Deed, threading.Event] = (sends(b""), threading.Event())
        self.asked: list[bytes] = []
        """The heads of the requests."""
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()

    def does(self, deed: Deed) -> threading.Event:
        """From now on; what ends what it did to requests."""
        self._chosen = deed, threading.Event()
        return self._chosen[1]

    def close(self) -> None:
        self._socket.close()

    def _serve(self) -> None:
        while True:
            try:
                taken, _ = self._socket.accept()
            except OSError:
                return
            threading.Thread(target=self._answer, args=(taken,), daemon=True).start()

    def _answer(self, taken: socket.socket) -> None:
        with taken, suppress(OSError):  # the client may leave
            head, _, body = taken.recv(65_536).partition(b"\r\n\r\n")
            size = head.lower().partition(b"content-length:")[2].split(b"\r\n")[0]
            while len(body) < int(size):
                body += taken.recv(65_536)
            self.asked.append(head)
            deed, over = self._chosen
            deed(taken, over)


def reply(body: Any, status: int = 200, **headers: str) -> bytes:
    """A whole response of HTTP; in the names of headers `_` is `-`."""
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    given = {"content-type": "application/json", "connection": "close", "content-length": len(data)} | headers
    lines = [f"HTTP/1.1 {status} X", *(f"{name.replace('_', '-')}: {value}" for name, value in given.items())]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + data


def chosen(content: Any = ABORT, calls: Any = None) -> bytes:
    return reply(completion(content, calls)({})[1])


def sends(data: bytes) -> Deed:
    return lambda taken, _: taken.sendall(data)


def redirects(to: str) -> Deed:
    return sends(reply(b"", 307, location=f"{to}/v1/chat/completions"))


def resets(taken: socket.socket, _: threading.Event) -> None:
    taken.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def drips(taken: socket.socket, over: threading.Event) -> None:
    for byte in chosen():
        taken.sendall(bytes([byte]))
        if over.wait(0.1):
            return


def never_ends(taken: socket.socket, over: threading.Event) -> None:
    taken.sendall(b"HTTP/1.1 200 OK\r\ncontent-type: application/json\r\nconnection: close\r\n\r\n{")
    while not over.wait(0.005):
        taken.sendall(b" " * 4096)


def is_late(taken: socket.socket, over: threading.Event) -> None:
    over.wait(10 * ATTEMPT_S)
    taken.sendall(chosen())


REFUSAL = {"error": {"message": f"no: {SECRET}", "type": "x"}}
DEEDS: dict[str, tuple[Deed, str]] = {
    "closes at once": (sends(b""), "Connection error"),
    "closes in the midst": (sends(chosen()[:150]), "Connection error"),
    "resets": (resets, "Connection error"),
    "drips": (drips, "no answer within"),
    "garbage": (sends(reply(b"\x00\xff{{{]")), "gave no reply of a chat model"),
    "deep JSON": (sends(reply(b"[" * 100_000)), "RecursionError"),
    "an enormous number": (sends(reply(b'{"usage": 1' + b"0" * 5000 + b"}")), "gave no reply of a chat model"),
    "a call of what was not offered": (sends(chosen(None, [("set_state", '{"state": "done"}')])), "calls of tools"),
    "two calls": (sends(chosen(None, [("signal", "{}"), ("abort", "{}")])), "answered with 2 calls"),
    "a call with broken arguments": (sends(chosen(None, [("abort", '{"why":')])), "whose arguments are not JSON"),
    "an option that was not offered": (sends(chosen('{"option": "fly"}')), ""),
    "the key as an answer": (sends(chosen(SECRET)), "[hidden]"),
    "the key as a reason": (sends(chosen(json.dumps({"option": "fly", "why": f"Bearer {SECRET}"}))), ""),
    "limits the rate": (sends(reply(REFUSAL, 429, retry_after="3600")), "429 - no: [hidden]"),
    "limits it for ever": (sends(reply(REFUSAL, 429, retry_after="1e999")), "429 - no: [hidden]"),
    "refuses the key": (sends(reply(REFUSAL, 401)), "401 - no: [hidden]"),
    "never ends": (never_ends, "no answer within"),
    "a bomb": (sends(reply(gzip.compress(bytes(30_000_000)), content_encoding="gzip")), ""),
    "goes round in redirects": (redirects(""), ""),
    "answers late": (is_late, "no answer within"),
}  # fmt: skip


@pytest.fixture(scope="module")
def server() -> Iterator[RawServer]:
    served = RawServer()
    yield served
    served.close()


@pytest.fixture(scope="module")
def process(server: RawServer) -> Iterator[ModelProcess]:
    """The process of a named model, which has its key and its server from the environment."""
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("OPENAI_API_KEY", SECRET)
        environment.setenv("OPENAI_BASE_URL", f"http://127.0.0.1:{server.port}/v1")
        made = ModelProcess("openai:gpt-4o", isolated=True)
        server.does(sends(chosen()))
        assert asked(made, 120.0)["option"] == "abort"  # it is open now
        yield made
        made.close()


def asked(process: ModelProcess, seconds: float) -> dict[str, Any]:
    """What a decision gets of the model within so many seconds."""
    agent, collected = DecisionAgent(process), ReplyCollector()
    agent.ask(QUESTION._replace(until=seconds, budget=QUESTION.budget._replace(seconds=seconds)), collected)
    return dict(collected.wait(seconds + 30.0))


def spoken_of(process: ModelProcess, seconds: float) -> ModelText:
    """What a person's sentence gets of it."""
    given, model = Inbox[ModelText](), TalkModel(process)
    request = AskModel(1, "Sing.", "operator", "page", "Ada", (), "It waits.", (), 0.0, seconds)
    model.ask(request, StatusView, given)
    return given.wait(bool, "a reply")[0]


@pytest.mark.xdist_group("model server")
@pytest.mark.parametrize("name", DEEDS)
def test_a_server_that_harms_costs_an_attempt_and_shows_no_key(
    name: str, server: RawServer, process: ModelProcess, caplog: pytest.LogCaptureFixture
) -> None:
    deed, why = DEEDS[name]
    over = server.does(deed)
    with caplog.at_level(logging.DEBUG):
        answer, spoken = asked(process, ATTEMPT_S), spoken_of(process, ATTEMPT_S)
        assert answer.get("option") in (None, "fly"), "which was not offered, and is refused by the judge"
        assert why in answer.get("failed", why), answer
        assert spoken.is_end and spoken.order is None
        server.does(sends(chosen()))
        assert asked(process, 60.0)["option"] == "abort", "the next question is answered, also while that one lasts"
        over.set()
    for text in (json.dumps(answer), repr(spoken), caplog.text):
        assert SECRET not in text and SECRET[8:] not in text


@pytest.mark.xdist_group("model server")
def test_a_server_that_redirects_to_another_host_does_not_give_it_the_key(
    server: RawServer, process: ModelProcess
) -> None:
    other = RawServer()
    server.does(redirects(f"http://localhost:{other.port}"))
    other.does(sends(chosen()))
    asked(process, 60.0)
    other.close()
    assert SECRET.encode() in server.asked[-1], "the first host has it"
    assert not any(SECRET.encode() in head for head in other.asked)
