# SPDX-License-Identifier: Apache-2.0
"""What the resumption of a run leaves behind: what became of what was unsure, its questions, and no open file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.talk.run_status import RobotWords, RunStatus
from rai_missions.engine import Chart
from rai_missions.engine.step import Ask
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import DefinitionError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import dump_profile
from rai_missions.replay.migrate import Map, migrate
from rai_missions.replay.open_run import open_run
from tests.rigs.runs import Rig, mission, robot

LIT = mission({
    "idle": {"transitions": [{"on": "go", "to": "lit", "do": [{"publish": "lamp", "message": {"data": True}}]}]},
    "lit": {"transitions": [{"after_s": 5, "to": "over"}]}, "over": {"final": "aborted"},
})  # fmt: skip
WHICH = {"question": "Which?", "options": {"left": {}}, "ask": ["agent"], "deadline_s": 30, "fallback": "left"}
STATES: dict[str, Any] = {
    "asking": {"tree": {"decision": WHICH}, "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "over"}]},
    "over": {"final": "aborted"},
}  # fmt: skip


def died(path: Path, given: Mission, *events: str) -> Path:
    """The journal of a process that died as soon as these events were written."""
    chart = Chart(given, CompiledTrees())
    with Journal.create(path, Header(dump(given), dump_profile(robot()))) as journal:
        journal.write(chart.start(), since=0.0)
        for name in events:
            journal.write(chart.send(Event(name)), since=0.0)
    return path


def test_what_is_done_again_in_a_world_that_starts_again_was_performed(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", LIT, "go")
    taken = open_run(path)
    with Journal.open(path) as journal:
        rig = Rig(LIT, journal=journal, begin=taken.resumption._replace(fresh=True))
        rig.run()
    taken.record.close()
    with read(path) as record:
        assert record.confirmations() == {2: "performed"}


def test_who_paused_a_run_is_known_to_the_process_that_resumes_it(tmp_path: Path) -> None:
    path, chart = died(tmp_path / "run.journal", LIT), Chart(LIT)
    chart.start()
    with Journal.open(path) as journal:
        journal.write(chart.send(Event("pause", 1.0, {"by": "operator Anna (page)"}, "command")), since=0.0)
    taken = open_run(path)
    taken.record.close()
    rig = Rig(LIT, begin=taken.resumption)
    view = RunStatus(rig.runner, RobotWords()).view()
    assert (view.mode, view.mode_by, view.mode_since) == ("paused", "operator Anna (page)", 1.0)


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="the system does not list a process's open files")
def test_a_run_that_is_not_resumed_leaves_its_journal_closed(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", LIT)
    with pytest.raises(DefinitionError, match="the mission has changed") as refused:
        open_run(path, mission=LIT.model_copy(update={"about": "changed"}))
    links = [os.path.realpath(f"/proc/self/fd/{number}") for number in os.listdir("/proc/self/fd")]
    assert str(path.resolve()) not in links, refused


def test_the_question_of_a_tree_is_asked_again_in_the_mission_to_which_its_run_is_moved(tmp_path: Path) -> None:
    path = died(tmp_path / "run.journal", mission(STATES))
    now = mission({**STATES, "over": {"final": "failed"}}, version="2.0.0")
    with read(migrate(path, now, Map(), to=tmp_path / "new.journal").journal) as record:
        (question,) = [each.question for step in record.steps() for each in step.effects if isinstance(each, Ask)]
    assert (question.text, question.owner) == ("Which?", "asking#")
