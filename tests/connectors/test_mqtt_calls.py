# SPDX-License-Identifier: Apache-2.0
"""The calls that wait for a reply from the broker."""

from __future__ import annotations

import logging
import threading

import pytest

from rai_missions.connectors.connector import Reply
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.mqtt.calls import MOST_ANSWERED, PendingCalls

DONE = Reply("succeeded", {"done": True})


def test_a_call_ends_once_whatever_else_comes() -> None:
    calls, replies = PendingCalls(), list[Reply]()
    calls.begin(b"1", "/horn", replies.append, None)

    calls.answered(b"1", DONE)
    calls.end(b"1", Reply("failed", {}))
    calls.give_up("the broker is gone")

    assert replies == [DONE]


def test_all_calls_have_one_thread_for_their_timeouts() -> None:
    calls, before, replies = PendingCalls(), set(threading.enumerate()), Inbox[Reply]()
    for key in (b"1", b"2", b"3"):
        calls.begin(key, "/horn", replies, 3600)
    calls.begin(b"4", "/horn", replies, 0.01)

    assert len(set(threading.enumerate()) - before) == 1
    assert [each.why for each in replies.wait(bool, "no one answers")] == ["/horn has not answered within 0.01 s"]


def test_calls_that_are_given_up_leave_no_thread_and_later_ones_have_their_timeout() -> None:
    calls, before, replies = PendingCalls(), set(threading.enumerate()), Inbox[Reply]()
    calls.begin(b"1", "/horn", replies, 3600)
    calls.answered(b"1", DONE)
    calls.give_up("the connector was stopped")
    assert set(threading.enumerate()) <= before
    calls.begin(b"2", "/horn", replies, 0.01)
    assert [each.outcome for each in replies.wait(lambda found: len(found) > 1, "no timeout")] == [
        "succeeded",
        "timed_out",
    ]


def test_a_second_server_is_known_by_one_of_the_last_answers(caplog: pytest.LogCaptureFixture) -> None:
    calls = PendingCalls()
    keys = [number.to_bytes(2, "big") for number in range(MOST_ANSWERED + 1)]
    for key in keys:
        calls.begin(key, "/horn", lambda reply: None, None)
        calls.answered(key, DONE)

    with caplog.at_level(logging.ERROR):
        calls.answered(keys[0], DONE)  # forgotten
        assert not caplog.messages
        calls.answered(keys[1], DONE)
        calls.answered(keys[2], DONE)  # logged once

    assert [line.split(":")[0] for line in caplog.messages] == ["two servers answer /horn"]
