# SPDX-License-Identifier: Apache-2.0
"""A run that resumes with its page, and is recorded: what was asked before the old process died can be answered."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.run.live_page import RunPage, page_of
from rai_missions.cli.run.options import RunOptions
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.journal import Journal
from rai_missions.recording import journal_of
from rai_missions.replay.replay import replay
from rai_missions.runtime.result import Result
from rai_missions.runtime.runner import Runner
from tests.node.scenes import mission, robot
from tests.rigs.journals import raw_rows_of
from tests.visualize.live.stage import Viewer, ask, until
from visualize.live import LivePage, PageAddress


def cut_short(journal: Path, *names: tuple[str, str], there: bool | None = None) -> None:
    """A journal that ends while a question is open, or after the start.

    Args:
        journal: Its file.
        names: What happens after the start, with its kind.
        there: What the robot had reported before.
    """
    with prepare(RunConfig(mission(), robot({"kind": "local"}), journal=journal)) as prepared:
        chart = Chart(prepared.mission)
        assert isinstance(prepared.journal, Journal)
        if there is not None:
            prepared.journal.write(chart.write("there", there, at=0.0), since=0.0)
        for number, (name, kind) in enumerate((("start", "command"), *names)):
            at = float(number)
            step = chart.start(at) if name == "start" else chart.send(Event(name, at, {}, kind))
            prepared.journal.write(step, since=at)


@pytest.mark.parametrize("is_paused", [False, True])
def test_a_question_that_was_open_is_answered_on_the_page_of_the_process_that_continues(
    tmp_path: Path, is_paused: bool
) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    pytest.importorskip("mcap")
    journal, recording = tmp_path / "a.journal", tmp_path / "a.mcap"
    cut_short(journal, ("ask", "event"), *([("pause", "command")] if is_paused else []))
    page, ended = LivePage(PageAddress(port=0)), list[Result]()
    watch = RunPage(page, RunConfig(None, journal=journal, resume=journal, record=recording))

    def run() -> None:
        with prepare(watch.config) as prepared:
            assert ("it is paused" in prepared.resumption_notice) is is_paused
            ended.append(watch.run(prepared, lambda runner: runner.run()))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        until(lambda: page.serves, "the page is there")
        viewer = Viewer(page)
        until(lambda: viewer.seen.get("questions"), "the question is shown")
        (question,) = viewer.seen["questions"]
        assert question["until"] == pytest.approx(601.0)
        if is_paused:
            assert viewer.sees(mode="paused", paused_at=2.0)
            assert ask(page, "POST", "/orders", b'{"command": "resume"}')[0] == 200
            until(lambda: viewer.sees(mode="running"), "it continues")
        answer = f'{{"command": "answer", "question": {question["number"]}, "option": "left"}}'
        assert ask(page, "POST", "/orders", answer.encode())[2] == {"success": True, "why": ""}
        thread.join(30)
        viewer.cut()
    finally:
        page.stop()
    assert ended[0].outcome == "aborted"
    with journal_of(recording) as replayed:
        assert raw_rows_of(replayed.path) == raw_rows_of(journal)
        assert replay(replayed.path).outcome == "aborted"


def test_the_page_of_a_run_that_continues_shows_which_facts_it_waits_for(tmp_path: Path) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    journal, connector = tmp_path / "a.journal", LocalConnector()
    cut_short(journal, there=False)
    page, ended = LivePage(PageAddress(port=0)), list[Result]()
    watch = RunPage(page, RunConfig(None, journal=journal, resume=journal, opened=connector))
    connector.start()

    def run() -> None:
        with prepare(watch.config) as prepared:
            ended.append(watch.run(prepared, lambda runner: runner.run()))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        until(lambda: page.serves, "the page is there")
        viewer = Viewer(page)
        until(lambda: viewer.sees(mode="running", awaited_facts="there"), "what it waits for is shown")
        connector.publish("/robot/there", "std_msgs/msg/Bool", {"data": True})
        until(lambda: viewer.sees(mode="running", awaited_facts=""), "it continues")
        assert ask(page, "POST", "/orders", b'{"command": "cancel"}')[2] == {"success": True, "why": ""}
        thread.join(30)
        viewer.cut()
    finally:
        page.stop()
        connector.stop()
    assert ended[0].outcome == "canceled"


@pytest.mark.parametrize(
    ("mode", "words", "is_let_in"),
    [
        (0o600, {}, True),
        (0o644, {}, False),
        (0o600, {"viewer_url": "http://127.0.0.1:1/#token=short"}, False),
        (0o600, {"url": 7}, False),
    ],
)
def test_those_who_had_the_page_of_a_killed_run_open_are_let_in_by_the_one_that_resumes_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mode: int, words: dict[str, Any], is_let_in: bool
) -> None:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    journal = tmp_path / "a.journal"
    cut_short(journal, ("ask", "event"))
    killed = [f"http://127.0.0.1:1/#token={each * 43}" for each in "ab"]
    left = Path(f"{journal}.watch")
    left.write_text(json.dumps({"url": killed[0], "viewer_url": killed[1], **words}))
    left.chmod(mode)
    options = RunOptions(resume=str(journal), watch="0")
    with page_of(options, RunConfig(None, journal=journal, resume=journal)) as page:
        assert page is not None

        def cancel(runner: Runner) -> Result:
            runner.cancel("a test")
            return runner.run()

        with prepare(page.config) as prepared:
            page.run(prepared, cancel)
    tokens = [line.partition("#token=")[2] for line in capsys.readouterr().err.splitlines() if "#token=" in line]
    assert (tokens == ["a" * 43, "b" * 43]) is is_let_in
    assert len(set(tokens)) == 2 and {len(each) for each in tokens} == {43}
