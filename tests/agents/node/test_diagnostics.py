# SPDX-License-Identifier: Apache-2.0
"""How bad it is: OK while it runs, WARN where somebody should look, ERROR where it has failed."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.agents.node.bulletin import Bulletin, Open
from rai_missions.agents.node.diagnostics import ERROR, OK, WARN, array_of, level
from rai_missions.verdict import Question

RUNNING = Bulletin(3, "/errand", "ab", "active", "errand", "1.0", "r1", "running", "autonomy", ("moving",))
ASKED = (Open(Question(4, "asking", "operator", "Which way?", ()), 5.0),)


@pytest.mark.parametrize(
    ("changed", "around", "expected"),
    [
        ({}, {}, (OK, "running")),
        ({"mode": "idle"}, {}, (OK, "idle")),
        ({"mode": "succeeded", "outcome": "succeeded"}, {}, (OK, "succeeded")),
        ({"mode": "paused"}, {}, (WARN, "paused")),
        ({"mode": "canceling"}, {}, (WARN, "canceling")),
        ({"questions": ASKED}, {}, (WARN, "question 4 waits for operator: Which way?")),
        (
            {"questions": ASKED, "waits": "asking waits until control is with agent; autonomy has it"},
            {},
            (WARN, "asking waits until control is with agent; autonomy has it"),
        ),
        ({}, {"stale": ("battery", "pose")}, (WARN, "not fresh: battery, pose")),
        ({}, {"strangers": 1}, (WARN, "another node is called /errand too; give one of them another name with --node")),
        ({"mode": "failed", "why": "timed_out"}, {"stale": ("pose",)}, (ERROR, "failed: timed_out")),
        ({"mode": "aborted", "why": "killed by Ann"}, {}, (ERROR, "aborted: killed by Ann")),
        ({"fault": "/initial: no state 'x'"}, {}, (ERROR, "/initial: no state 'x'")),
    ],
)
def test_the_level_says_how_bad_it_is(
    changed: dict[str, Any], around: dict[str, Any], expected: tuple[int, str]
) -> None:
    bulletin = RUNNING._replace(**changed)
    assert level(bulletin, **around) == expected
    (status,) = array_of(bulletin, at=1.0, **around)["status"]
    assert (status["level"], status["message"]) == expected and status["name"] == "/errand: mission"


def test_a_bulletin_says_its_question_with_the_time_left() -> None:
    said = RUNNING._replace(questions=ASKED).data()
    assert said["question"] == said["questions"][0] and said["question"]["left_s"] == 5.0
