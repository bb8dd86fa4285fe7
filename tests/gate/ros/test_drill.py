# SPDX-License-Identifier: Apache-2.0
"""Three processes contend for one robot: never two holders, never a command through from a non-holder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.gate.ros.drill import HOLDERS, Record, drill, figures, violations


def judged(record: Record) -> dict[str, Any]:
    """The figures of a drill that broke no rule."""
    assert violations(record) == []
    reported = figures(record)
    assert reported["received"] <= reported["sent"], "nothing is received that was not sent"
    assert reported["arrived"] <= reported["passed"]
    for word in ("passed", "refused"):
        counts = {who: sum(row["did"] == word and row["who"] == who for row in record.log) for who in HOLDERS}
        assert f"{word}: {', '.join(f'{who} {count}' for who, count in counts.items())}" in record.closing
    return reported


@pytest.mark.long
def test_three_processes_never_hold_control_together(domain: int, tmp_path: Path) -> None:
    reported = judged(drill(domain, 5.0, 1, tmp_path / "gate.jsonl"))
    assert reported["passed"] > 20 and reported["refused"] > 20 and reported["handovers"] > 2, reported


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(5))
def test_three_processes_never_hold_control_together_for_long(domain: int, tmp_path: Path, seed: int) -> None:
    reported = judged(drill(domain, 60.0, seed, tmp_path / "gate.jsonl"))
    assert reported["lapses"] > 2, reported
    print(json.dumps(reported))  # noqa: T201 - the figures are what a drill is for


def passed(grant: int, who: str, code: float, number: float, did: str = "passed") -> dict[str, Any]:
    return {"did": did, "grant": grant, "who": who, "topic": "/cmd_vel", "data": {"linear": {"x": code, "y": number}}}


HANDED = {"did": "changed", "grant": 1, "from": "autonomy", "to": "agent", "why": "agent asked for it"}
LOG = [
    passed(0, "autonomy", 1.0, 1.0),
    HANDED,
    passed(1, "agent", 2.0, 1.0),
    passed(1, "autonomy", 1.0, 2.0, "refused"),
]
ARRIVED = [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 0.0), (2.0, 1.0, 0.0)]


@pytest.mark.parametrize(
    ("log", "arrived", "status", "why"),
    [
        (LOG, ARRIVED, [], ""),
        ([*LOG, passed(1, "autonomy", 1.0, 3.0)], ARRIVED, [], "agent held control (grant 1)"),
        ([*LOG, passed(1, "agent", 2.0, 3.0, "refused")], ARRIVED, [], "agent held control (grant 1)"),
        ([*LOG, LOG[-1]], ARRIVED, [], "one command twice"),
        ([HANDED, HANDED], [], [], "control went from agent"),
        ([passed(0, "autonomy", 2.0, 1.0)], [], [], "a command of a stranger"),
        (LOG, [*ARRIVED, (3.0, 1.0, 0.0)], [], "the base received operator's 1, which the gate did not pass"),
        (LOG, [*ARRIVED, ARRIVED[1]], [], "the base received autonomy's 1 after what the gate passed later"),
        (
            LOG,
            [],
            [{"revision": 1, "holder": who} for who in ("agent", "operator")],
            "grant 1 was agent's and operator's",
        ),
        (LOG, [], [{"revision": each, "holder": "agent"} for each in (2, 1)], "revisions went backwards"),
    ],
)
def test_the_judge_sees_each_violation(log: Any, arrived: Any, status: Any, why: str) -> None:
    found = violations(Record(log, arrived, [], status, {}, ""))
    assert bool(found) == bool(why) and why in "".join(found)
