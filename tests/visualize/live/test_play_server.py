# SPDX-License-Identifier: Apache-2.0
"""What the server of a play gives to whom, over real HTTP: behind the live page's door, one order at a time."""

from __future__ import annotations

import json
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from rai_missions.errors import UsageError
from tests.visualize.live.stage import ask
from tests.visualize.runs import tractor
from visualize.live import LivePage, PageAddress

DO = json.dumps({"do": "start", "revision": 0}).encode()
JSON = {"Content_Type": "application/json"}


class Play:
    """Keeps the orders; refuses the one that is called `wrong`."""

    def __init__(self) -> None:
        self.orders: list[dict[str, Any]] = []

    def look(self) -> dict[str, Any]:
        return {"revision": len(self.orders)}

    def act(self, order: dict[str, Any]) -> dict[str, Any]:
        if order.get("do") == "wrong":
            raise UsageError("it cannot happen now")
        self.orders.append(order)
        return self.look()


@pytest.fixture
def served() -> Iterator[Any]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    page, play = LivePage(PageAddress(port=0)), Play()
    page.start_play(tractor(), play)
    yield SimpleNamespace(page=page, play=play)
    page.stop()


def test_only_who_has_the_token_and_comes_from_the_page_sees_or_does_anything(served: Any) -> None:
    for path in ("/", "/live.js", "/live.css"):
        status, _, body = ask(served.page, "GET", path, X_Mission_Token="")
        assert status == 200
        assert b"tractor" not in body
    for method, path in (("GET", "/mission"), ("GET", "/play"), ("POST", "/play")):
        body = DO if method == "POST" else None
        assert ask(served.page, method, path, body, X_Mission_Token="wrong", **JSON)[0] == 401
        assert ask(served.page, method, path, body, Origin="http://evil.example", **JSON)[0] == 403
        assert ask(served.page, method, path, body, Sec_Fetch_Site="cross-site", **JSON)[0] == 403
        assert ask(served.page, method, path, body, Host="evil.example", **JSON)[0] == 421
    assert served.play.orders == []
    assert ask(served.page, "POST", "/play", DO, **JSON)[0] == 200
    assert served.play.orders == [{"do": "start", "revision": 0}]


def test_an_order_that_is_none_is_refused_with_where_the_play_is(served: Any) -> None:
    for body, headers, status in (
        (DO, {"Content_Type": "text/plain"}, 415),
        (b"[1]", JSON, 400),
        (b"{", JSON, 400),
        (b" " * 70_000, JSON, 413),
        (json.dumps({"do": "wrong"}).encode(), JSON, 409),
    ):
        found, _, reported = ask(served.page, "POST", "/play", body, **headers)
        assert (found, reported["revision"]) == (status, 0), reported
        assert reported["why_not"]
    assert served.play.orders == []
