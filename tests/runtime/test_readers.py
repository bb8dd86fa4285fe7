# SPDX-License-Identifier: Apache-2.0
"""A run is read from any thread while it steps: nothing fails, whatever is entered and left meanwhile."""

from __future__ import annotations

import threading

import pytest

from rai_missions.engine.activities.goal_ledger import Goal, Goals, awaited, loose
from tests.rigs.runs import Plan, PlannedServer, Rig, mission

pytestmark = pytest.mark.usefixtures("changes_threads_often")


def test_goals_are_read_while_others_come_and_go() -> None:
    goals: Goals = {number: Goal(number, "moving", "move", 1.0, phase="orphaned") for number in range(50)}
    over = threading.Event()

    def come_and_go() -> None:
        number = 100
        while not over.is_set():
            goals[number] = Goal(number, "moving", "move", 1.0)
            goals.pop(number - 3, None)
            number += 1

    writer = threading.Thread(target=come_and_go, daemon=True)
    writer.start()
    try:
        for _ in range(2_000):
            assert len(loose(goals)) == 50
            assert awaited(goals) < 10
    finally:
        over.set()
        writer.join()


def test_a_run_is_read_while_it_steps() -> None:
    states = {
        "moving": {"action": "move", "timeout_s": 1, "transitions": [{"on": ["succeeded", "timed_out"], "to": "back"}]},
        "back": {"action": "turn", "timeout_s": 1, "transitions": [{"on": ["succeeded", "timed_out"], "to": "again"}]},
        "again": {"transitions": [{"when": {"key": "count", "<": 60}, "to": "moving"},
                                  {"when": {"key": "count", ">=": 60}, "to": "over"}]},
        "over": {"final": "aborted"},
    }  # fmt: skip
    states["moving"]["entry"] = [{"set": "count", "add": 1}]
    rig = Rig(mission(states))
    stage = rig.stage
    server = PlannedServer(
        lambda after, do: stage.play({stage.at + max(after, 0.1): do}),
        lambda: stage.at,
        *[Plan(accepts=0.1, ends=0.3)] * 130,
    )
    rig.move.accept, rig.move.cancel = server.accept, server.cancel  # type: ignore[method-assign]
    rig.turn.accept, rig.turn.cancel = server.accept, server.cancel  # type: ignore[method-assign]
    over, failed, count = threading.Event(), list[Exception](), [0]

    def read() -> None:
        view = rig.runner.view
        while not over.is_set():
            try:
                _ = (view.loose_goals, view.questions, view.awaited, view.awaited_goals, view.active, view.board)
                count[0] += 1
            except (RuntimeError, LookupError) as error:
                failed.append(error)
                return

    readers = [threading.Thread(target=read, daemon=True) for _ in range(2)]
    for reader in readers:
        reader.start()
    result = rig.run()
    over.set()
    for reader in readers:
        reader.join()
    assert result.outcome == "aborted", result.why
    assert not failed and count[0] > 10
