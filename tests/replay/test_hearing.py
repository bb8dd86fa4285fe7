# SPDX-License-Identifier: Apache-2.0
"""What the robot reported before a process died counts no more: it is received again first, or not known."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import Ask
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.open_run import open_run
from rai_missions.runtime.mailbox import Mailbox
from tests.replay.farm import FARMER, Farm
from tests.replay.mortal import Fate, live
from tests.replay.test_kills import Ended, has_ended, holds
from tests.replay.test_kinds import ALWAYS, KEYS
from tests.rigs.runs import ReplyingAnswerer, Rig, mission, robot

KNOWN = {**KEYS, "obstacle": {"type": "object", "source": "robot", "max_age_s": 3,
                              "fields": {"living": "boolean"}}}  # fmt: skip
OVER = Mission.model_validate({
    "name": "over", "initial": "asking", "blackboard": KNOWN, "transitions": ALWAYS,
    "states": {
        "asking": {"decision": {"question": "Over it?", "evidence": ["obstacle"], "options": {
            "over": {"about": "over it", "when": {"key": "obstacle.living", "==": False}}, "wait": {"about": "wait"}},
            "ask": ["someone"], "deadline_s": 60, "fallback": "wait"},
            "transitions": [{"on": "over", "to": "crossed"}, {"on": "wait", "to": "waited"}]},
        "crossed": {"final": "failed"}, "waited": {"final": "canceled"}, "lost": {"final": "aborted"}},
})  # fmt: skip


class Meadow(Farm):
    """Something lies there; while no one looks, something living takes its place."""

    def __init__(self, *given: Any, **words: Any) -> None:
        super().__init__(*given, **words)
        self.obstacle: Mapping[str, Any] | None = {"living": False}

    def live_on(self) -> None:
        super().live_on()
        if self.obstacle is not None:
            text = '{"living": true}' if self.obstacle["living"] else '{"living": false}'
            self.connector.publish("/obstacle", "std_msgs/msg/String", {"data": text})


def slow_answerer() -> ReplyingAnswerer:
    """Thinks until it is asked again, then wants to drive over it."""
    made = ReplyingAnswerer(lambda question: "over" if len(made.asked) > 1 else None)
    return made


def asked_and_killed(path: Path, meadow: Meadow, slow: ReplyingAnswerer) -> None:
    """Live until the question is asked, and die."""
    for at in range(100):
        if live(path, meadow, OVER, FARMER, {"someone": slow}, Fate(at)) is None and slow.asked:
            return
        assert not has_ended(path)
        path.unlink()
        path.with_name(f"{path.name}-wal").unlink(missing_ok=True)
    raise AssertionError("no one was asked")


def ended(path: Path, meadow: Meadow, slow: ReplyingAnswerer) -> Ended:
    result = live(path, meadow, OVER, FARMER, {"someone": slow}, Fate())
    assert result is not None
    holds(path, meadow)
    return Ended(result.outcome, result.why)


def test_no_one_acts_on_what_was_so_before_the_process_died(tmp_path: Path) -> None:
    path, meadow, slow = tmp_path / "run.journal", Meadow(), slow_answerer()
    asked_and_killed(path, meadow, slow)
    meadow.obstacle = {"living": True}
    assert ended(path, meadow, slow).outcome == "canceled", "what lives now is not driven over"


def test_what_no_one_reports_any_more_is_not_known(tmp_path: Path) -> None:
    path, meadow, slow = tmp_path / "run.journal", Meadow(), slow_answerer()
    asked_and_killed(path, meadow, slow)
    meadow.obstacle = None
    assert ended(path, meadow, slow).outcome == "canceled"


def test_what_is_as_it_was_is_answered_as_it_was(tmp_path: Path) -> None:
    path, meadow, slow = tmp_path / "run.journal", Meadow(), slow_answerer()
    asked_and_killed(path, meadow, slow)
    assert ended(path, meadow, slow).outcome == "failed"


def test_a_robot_that_is_received_again_is_never_taken_for_silent_and_one_that_is_not_is(tmp_path: Path) -> None:
    for silent, outcome in ((frozenset[str](), "failed"), (frozenset({"/battery"}), "aborted")):
        path, meadow, slow = tmp_path / f"{outcome}.journal", Meadow(), slow_answerer()
        asked_and_killed(path, meadow, slow)
        meadow.silent = silent
        assert ended(path, meadow, slow).outcome == outcome


def test_the_question_is_asked_again_under_its_number_and_counted_once(tmp_path: Path) -> None:
    path, meadow, slow = tmp_path / "run.journal", Meadow(), slow_answerer()
    asked_and_killed(path, meadow, slow)
    result = live(path, meadow, OVER, FARMER, {"someone": slow}, Fate())
    assert result is not None and result.decisions == 1
    assert [each.number for each in slow.asked[-2:]] == [slow.asked[-1].number] * 2
    with read(path) as record:
        assert sum(isinstance(each, Ask) for step in record.steps() for each in step.effects) == 1


def test_what_is_asked_of_a_run_that_waits_to_receive_the_robot_again_is_done_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is asked right before the run looks for what has come, and finds nothing."""
    path, idle = tmp_path / "run.journal", mission({"idle": {}})
    chart, done = Chart(idle), list[float]()
    with Journal.create(path, Header(dump(idle), dump_profile(robot()))) as journal:
        journal.write(chart.start(), since=0.0)
        journal.write(chart.write("battery", 0.5), since=0.0)
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Rig(idle, journal=journal, begin=taken.resumption)
        looks = Mailbox.take

        def take(mailbox: Mailbox) -> Event | None:
            if not done:
                rig.runner.call_soon(lambda: done.append(rig.clock.now()))
            return looks(mailbox)

        monkeypatch.setattr(Mailbox, "take", take)
        rig.stage.play({5.0: rig.runner.kill})
        assert rig.run().outcome == "aborted"
    taken.record.close()
    assert done[0] == 0.0, "not once the battery has sent nothing for too long"


def test_a_tree_looks_again_at_what_became_another_while_the_run_was_dead() -> None:
    looking = {"selector": [{"check": {"key": "door", "==": True}}, {"wait_s": 100}], "memory": False}
    waiting = Mission.model_validate({
        "name": "waiting", "initial": "looking",
        "blackboard": {"door": {"type": "boolean", "source": "robot", "max_age_s": 5}},
        "states": {"looking": {"tree": looking, "transitions": [{"on": "succeeded", "to": "through"}]},
                   "through": {"final": "canceled"}},
    })  # fmt: skip
    before = Chart(waiting, ticker=CompiledTrees())
    before.write("door", False)
    before.start()
    after = Chart.restore(waiting, before.snapshot(), ticker=CompiledTrees())
    step = after.send(Event("take_up", 1.0, {"heard": {"door": (True, 1.0)}}, "command"))
    assert step.entered == ("through",)
