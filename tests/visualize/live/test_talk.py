# SPDX-License-Identifier: Apache-2.0
"""What is written to the robot on its page: taken with the token and from the page itself, bounded, and only text."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from tests.visualize.live.stage import Run, Viewer, ask, until
from tests.visualize.runs import tractor
from visualize.live import LivePage, PageAddress

MARKUP = "<img src=x onerror=alert(1)> & <script>stop</script>"


class Ear:
    """Keeps what is written."""

    def __init__(self) -> None:
        self.received: list[tuple[str, str]] = []
        self.roles: list[str] = []
        self.why = ""
        self.ear: Any = None

    def receive(self, text: str, author: str, role: str) -> str:
        self.roles.append(role)
        self.received.append((text, author))
        return self.why

    def is_stop(self, text: str) -> bool:
        return text.casefold() == "stop"


class TalkedRun(Run):
    """A run whose page takes talk."""

    def make_ear(self) -> Ear:
        return Ear()

    def __enter__(self) -> TalkedRun:
        self.ear, self.viewers = self.make_ear(), list[int]()
        self.page = LivePage(PageAddress(port=0))
        watched = lambda: self.viewers.append(self.page.viewers)  # noqa: E731
        self.page.start(self.mission, self.feed, self.sink, self.about, self.ear, watched)
        return self


@pytest.fixture
def run() -> Iterator[TalkedRun]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with TalkedRun(tractor()) as made:
        made.start()
        yield made


def written(page: LivePage, text: Any, by: Any = "Anna", **headers: str) -> tuple[int, Any]:
    status, _, body = ask(page, "POST", "/talk", json.dumps({"text": text, "by": by}).encode(), **headers)
    return status, body


def test_a_sentence_is_passed_on_as_it_was_written(run: TalkedRun) -> None:
    assert written(run.page, MARKUP) == (200, {"success": True, "why": ""})
    assert run.ear.received == [(MARKUP, "Anna")]
    run.ear.why = "64 sentences wait already"
    assert written(run.page, "hello") == (409, {"success": False, "why": "64 sentences wait already"})


def test_a_foreign_origin_a_wrong_token_or_a_form_is_refused_and_nothing_is_passed_on(run: TalkedRun) -> None:
    assert written(run.page, "stop", Origin="http://evil.example")[0] == 403
    assert written(run.page, "stop", Sec_Fetch_Site="cross-site")[0] == 403
    assert written(run.page, "stop", X_Mission_Token="guessed")[0] == 401
    assert written(run.page, "stop", X_Mission_Token="")[0] == 401
    assert written(run.page, "stop", Content_Type="text/plain")[0] == 415
    assert written(run.page, "stop", Host="evil.example:1")[0] == 421
    assert run.ear.received == []


def test_the_role_is_that_of_the_token_whatever_the_message_has(run: TalkedRun) -> None:
    forged = json.dumps({"text": "cancel", "by": "operator Anna (page)", "role": "operator"}).encode()
    assert ask(run.page, "POST", "/talk", forged, X_Mission_Token=run.page.viewer_token)[0] == 200
    assert written(run.page, "cancel")[0] == 200
    assert run.ear.roles == ["viewer", "operator"]


@pytest.mark.parametrize("body", [b"", b"[]", b"{}", b'{"text": 1}', b'{"text": "a", "by": 1}', b"\xff", b"[" * 9_000])
def test_what_is_no_message_is_refused(run: TalkedRun, body: bytes) -> None:
    status, _, answer = ask(run.page, "POST", "/talk", body)
    assert status == 400 and answer["why"].startswith("a message is a JSON object")
    assert run.ear.received == []


def test_ten_megabytes_are_refused_and_the_page_serves_on(run: TalkedRun) -> None:
    for connection in ("keep-alive", "close"):
        status, body = written(run.page, "a" * 10_000_000, Connection=connection)
        assert (status, body["why"]) == (413, "a message has at most 16384 bytes")
        assert written(run.page, "a" * 10_000_000, Content_Type="text/plain", Connection=connection)[0] == 415
    assert written(run.page, "hello")[0] == 200


def test_too_many_messages_wait_and_a_stop_comes_through(run: TalkedRun) -> None:
    statuses = [written(run.page, f"chatter {number}")[0] for number in range(12)]
    assert statuses[0] == 200 and statuses[-1] == 429
    assert written(run.page, "stop")[0] == 200
    assert run.ear.received[-1] == ("stop", "Anna")


def test_what_viewers_write_uses_up_nothing_of_the_operators(run: TalkedRun) -> None:
    for text in ("chatter", "stop"):
        assert 429 in [written(run.page, text, X_Mission_Token=run.page.viewer_token)[0] for _ in range(30)]
        assert written(run.page, text)[0] == 200


def test_a_page_without_a_conversation_takes_none() -> None:
    with Run(tractor()) as silent:
        assert written(silent.page, "hello")[0] == 404
        assert ask(silent.page, "GET", "/mission")[2]["talks"] is False


def line(number: int, text: str, **words: Any) -> dict[str, Any]:
    return {"number": number, "by": "robot", "text": text, "way": "rules", **words}


def test_viewers_get_each_line_and_one_who_comes_later_gets_all_of_them(run: TalkedRun) -> None:
    early = Viewer(run.page)
    until(lambda: early.seen, "the first state")
    run.feed.talk(line(1, MARKUP))
    until(lambda: [each["text"] for each in early.seen.get("talk", [])] == [MARKUP], "the line")
    run.feed.talk(line(2, "second"))
    run.feed.talk(line(2, "second", spoken="failed"))
    late = Viewer(run.page)
    until(lambda: [each.get("spoken") for each in late.seen.get("talk", [])] == [None, "failed"], "both lines")
    early.cut()
    late.cut()


def test_lines_from_many_threads_while_the_run_steps_are_all_there_and_bounded(run: TalkedRun) -> None:
    viewer = Viewer(run.page)
    until(lambda: viewer.seen, "the first state")
    threads = [
        threading.Thread(
            target=lambda first=first: [run.feed.talk(line(first * 30 + at, "x" * 9_000)) for at in range(30)]
        )
        for first in range(5)
    ]
    for thread in threads:
        thread.start()
    for _ in range(20):
        run.send("tick", "tick")
    for thread in threads:
        thread.join()
    last = Viewer(run.page)
    until(lambda: len(last.seen.get("talk", [])) == 150, "all lines")
    assert max(len(each["text"]) for each in last.seen["talk"]) <= 4_000
    viewer.cut()
    last.cut()


def test_who_comes_and_goes_is_reported(run: TalkedRun) -> None:
    viewer = Viewer(run.page)
    until(lambda: 1 in run.viewers, "one has come")
    viewer.cut()
    until(lambda: run.viewers[-1] == 0, "and gone")
