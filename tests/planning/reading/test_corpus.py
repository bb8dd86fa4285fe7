# SPDX-License-Identifier: Apache-2.0
"""The stored requests: most are read without asking, none is read wrongly, and none that must not be is acted on."""

from __future__ import annotations

from collections import Counter

import pytest

from benchmarks.bench_requests import LANGUAGES, Request, corpus, read_outcome, verdict
from rai_missions.planning.reading import RequestReading, is_said, reading_of
from tests.sampled import sampled


@pytest.mark.parametrize("code", sampled(LANGUAGES, 2))
@pytest.mark.parametrize("is_held_out", [False, True])
def test_the_stored_requests_are_read_and_what_is_read_is_said_in_them(code: str, is_held_out: bool) -> None:
    requests = [each for each in corpus(code) if each.is_held_out == is_held_out]
    read = [(each, reading_of(each.text, each.scene)) for each in requests]
    found = [(each, verdict(each, read_outcome(reading, each.scene))) for each, reading in read]
    assert [each.text for each, result in found if result in ("wrong", "acted")] == []
    can = Counter(result for each, result in found if "goals" in each.wanted)
    assert can["exact"] >= 0.7 * can.total()
    assert can["asked"] <= 0.25 * can.total()
    assert can["refused"] == 0
    assert [each.text for each, reading in read if is_unsaid(each, reading)] == []


def is_unsaid(request: Request, reading: RequestReading) -> bool:
    goal, text = reading.goal, request.text
    return goal is not None and not (is_said(goal, text, request.scene) and is_said(goal, text))
