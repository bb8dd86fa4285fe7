# SPDX-License-Identifier: Apache-2.0
"""What the client of a request receives, in whatever order the run comes to it, drops it or ends."""

from __future__ import annotations

from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.requests import RunRequests
from rai_missions.runtime.runner import Runner
from rai_missions.states import Final

Moment = Literal["stepped", "looked at", "taken"]
MOMENTS: st.SearchStrategy[list[Moment]] = st.lists(st.sampled_from(["stepped", "looked at", "taken"]))


class RequestLog:
    """A request that writes down what it receives."""

    def __init__(self) -> None:
        self.received: list[str] = []

    def take(self, step: Step) -> None:
        self.received.append("taken")

    def drop(self, waited_s: float) -> None:
        self.received.append("dropped")

    def end(self) -> None:
        self.received.append("ended")


def requests_of_run() -> RunRequests[RequestLog]:
    return RunRequests(Runner(Mission("idle", initial="done", states={"done": Final("aborted")})))


@given(MOMENTS, st.booleans(), st.booleans())
def test_a_request_is_reported_once_whatever_the_run_does(moments: list[Moment], lasts: bool, is_late: bool) -> None:
    requests, log, handed_over = requests_of_run(), RequestLog(), list[RequestLog]()
    event = Event("pause", 0.0, {"request": requests.add(log, lasts=lasts)}, "command")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rai_missions.runtime.requests.GOOD_FOR_S", -1.0 if is_late else 60.0)
        for moment in moments:
            if moment == "stepped":
                requests.step(Step(1, 0.0, event))
            elif moment == "looked at":
                requests.drops(event)
            elif found := requests.taken(event.data["request"]):
                handed_over.append(found)
    requests.close()
    assert len(log.received) + len(handed_over) == 1
    if is_late and not lasts and moments and moments[0] != "stepped":
        assert log.received == ["dropped"]
    elif "stepped" not in moments and "taken" not in moments:
        assert log.received == ["ended"]


def test_a_request_after_the_end_receives_that_at_once() -> None:
    requests, log = requests_of_run(), RequestLog()
    requests.close()
    assert requests.add(log, lasts=True) == "" and log.received == ["ended"]
