# SPDX-License-Identifier: Apache-2.0
"""A chat model's server of OpenAI's shape on loopback, whose replies a test chooses."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from langchain_openai import ChatOpenAI

__all__ = ("Reply", "Server", "completion", "refused", "server")

Reply = Callable[[dict[str, Any]], tuple[int, Any, dict[str, str]]]
"""From what was asked to a status, a body and further headers."""


class Server(ThreadingHTTPServer):
    """Answers each request by a function, and keeps what was asked."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), ChatHandler)
        self.requests: list[dict[str, Any]] = []
        self.keys: list[str] = []
        self.replies: list[Reply] = []
        threading.Thread(target=self.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/v1"

    def model(self, **words: Any) -> ChatOpenAI:
        from langchain_openai import ChatOpenAI  # a second of every worker's, were it loaded with the file

        key = "sk-loopback-0123456789"
        settings = {"model": "gpt-4o", "base_url": self.url, "api_key": key, "max_retries": 0, "timeout": 10}
        return ChatOpenAI(**{**settings, **words})


@pytest.fixture
def server() -> Iterator[Server]:
    served = Server()
    yield served
    served.shutdown()
    served.server_close()


class ChatHandler(BaseHTTPRequestHandler):
    server: Server

    def do_POST(self) -> None:
        asked = json.loads(self.rfile.read(int(self.headers["content-length"])))
        self.server.requests.append(asked)
        status, reply, headers = self.server.replies.pop(0)(asked)
        body = reply if isinstance(reply, bytes) else json.dumps(reply).encode()
        self.send_response(status)
        for name, value in ({"content-type": "application/json"} | headers).items():
            self.send_header(name, value)
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        pass


def completion(content: str | None = None, calls: list[tuple[str, str]] | None = None) -> Reply:
    """A chat completion: a text, or calls of functions with their arguments as they are on the wire."""
    message: dict[str, Any] = {"role": "assistant", "content": content}
    if calls:
        message["tool_calls"] = [
            {"id": f"call_{number}", "type": "function", "function": {"name": name, "arguments": arguments}}
            for number, (name, arguments) in enumerate(calls)
        ]
    reply = {
        "id": "x", "object": "chat.completion", "created": 0, "model": "gpt-4o-2024-08-06",
        "choices": [{"index": 0, "message": message, "finish_reason": "stop"}],
        "usage": {"prompt_tokens": 90, "completion_tokens": 10, "total_tokens": 100},
    }  # fmt: skip
    return lambda _asked: (200, reply, {})


def refused(status: int, text: str, **headers: str) -> Reply:
    """A refusal; in the names of headers `_` is `-`."""
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return lambda _asked: (status, {"error": {"message": text, "type": "invalid_request_error"}}, named)
