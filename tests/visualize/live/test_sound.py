# SPDX-License-Identifier: Apache-2.0
"""What is spoken into a page: taken with the token and from the page itself, bounded, and passed on as it came."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.visualize.live.stage import Run, ask
from tests.visualize.live.test_talk import TalkedRun
from tests.visualize.runs import tractor
from visualize.live import LivePage
from visualize.live.sound import LARGEST_PIECE, MOST

PIECE = bytes(range(256)) * 16


class Listener:
    """Keeps what is spoken."""

    deaf = ""

    def __init__(self) -> None:
        self.pieces: list[tuple[bytes, str, str, str, bool]] = []
        self.why = ""

    def listen(self, sound: bytes, *, key: str, author: str, role: str, is_last: bool = False) -> str:
        self.pieces.append((sound, key, author, role, is_last))
        return self.why


class SpokenRun(TalkedRun):
    """A run whose page has a microphone."""

    def __init__(self, deaf: str = "") -> None:
        super().__init__(tractor())
        self.listener = Listener()
        self.listener.deaf = deaf

    def make_ear(self) -> Any:
        ear = super().make_ear()
        ear.ear = self.listener
        return ear


@pytest.fixture
def run() -> Iterator[SpokenRun]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    with SpokenRun() as made:
        made.start()
        yield made


def spoken(page: LivePage, sound: bytes = PIECE, query: str = "key=1&by=Anna", **headers: str) -> int:
    given = {"Content_Type": "audio/l16"} | headers
    return ask(page, "POST", f"/sound?{query}", sound, **given)[0]


def test_a_piece_is_passed_on_as_it_came_with_the_role_of_the_token(run: SpokenRun) -> None:
    assert spoken(run.page) == 200
    assert spoken(run.page, b"", "key=1&by=operator&last=1&role=operator", X_Mission_Token=run.page.viewer_token) == 200
    assert run.listener.pieces == [(PIECE, "1", "Anna", "operator", False), (b"", "1", "operator", "viewer", True)]


def test_a_refusal_has_its_reason(run: SpokenRun) -> None:
    run.listener.why = "another microphone is open"
    status, _, body = ask(run.page, "POST", "/sound?key=2", PIECE, Content_Type="audio/l16")
    assert (status, body["why"]) == (409, "another microphone is open")


def test_a_foreign_origin_a_wrong_token_and_what_is_no_sound_are_refused(run: SpokenRun) -> None:
    assert spoken(run.page, Origin="http://evil.example") == 403
    assert spoken(run.page, Sec_Fetch_Site="cross-site") == 403
    assert spoken(run.page, X_Mission_Token="guessed") == 401
    assert spoken(run.page, Content_Type="application/json") == 415
    assert spoken(run.page, b"123") == 400
    assert spoken(run.page, bytes(LARGEST_PIECE + 2)) == 413
    assert run.listener.pieces == []


def test_more_sound_than_time_has_passed_is_refused(run: SpokenRun) -> None:
    statuses = [spoken(run.page, b"") for _ in range(3 * MOST)]
    assert statuses[:MOST] == [200] * MOST and 429 in statuses


def test_sound_counts_by_its_length_and_that_of_a_viewer_uses_up_none_of_the_operators(run: SpokenRun) -> None:
    viewer = {"X_Mission_Token": run.page.viewer_token}
    seconds = [spoken(run.page, bytes(LARGEST_PIECE), **viewer) for _ in range(MOST // 2)]
    passed = seconds.count(200)
    assert seconds[: MOST // 8] == [200] * (MOST // 8) and passed < MOST // 2 and set(seconds) == {200, 429}
    assert spoken(run.page, bytes(LARGEST_PIECE)) == 200


def test_the_page_states_whether_it_has_a_microphone_and_why_not() -> None:
    with SpokenRun("speech needs ctranslate2") as made:
        given = ask(made.page, "GET", "/mission")[2]
        assert (given["listens"], given["deaf"]) == (True, "speech needs ctranslate2")
    with Run(tractor()) as silent:
        assert ask(silent.page, "GET", "/mission")[2]["listens"] is False
        assert spoken(silent.page) == 404
