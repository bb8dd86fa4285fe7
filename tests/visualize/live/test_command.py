# SPDX-License-Identifier: Apache-2.0
"""`run --watch` and `watch` as a user meets them, and orders that reach a real run."""

from __future__ import annotations

import json
import os
import re
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.cli.commands.run import run
from rai_missions.cli.main import main
from rai_missions.cli.run.find_page import find_journal, run_file, running_page
from rai_missions.cli.run.live_page import RunPage, normalise_watch_args
from rai_missions.cli.run.options import RunOptions
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal import read
from rai_missions.runtime.result import Result
from tests.node.scenes import FakeRobot, mission, robot
from tests.visualize.live.stage import Viewer, ask, until
from visualize.live import LivePage, PageAddress

ROOT = Path(__file__).parents[3]


class Watched:
    """A run of the errand with its page, on a thread of its own."""

    def __init__(self, folder: Path, *, operator: bool = True, terminal: Any = None, **words: Any) -> None:
        import time

        begun = time.monotonic()
        connector = LocalConnector(now=lambda: time.monotonic() - begun)
        connector.start()
        self.robot, self.journal = FakeRobot(connector), folder / "a.journal"
        self.page = LivePage(PageAddress(port=0))
        setting = RunConfig(
            mission(), robot({"kind": "local"}), connector=connector, journal=self.journal, operator=terminal, **words
        )
        self._watch = RunPage(self.page, setting, operator=operator)
        self._prepared = prepare(self._watch.config)
        self.runner, self.result = self._prepared.runner, list[Result]()
        self._connector = connector
        self._thread = threading.Thread(target=self._work)
        self._thread.start()
        until(lambda: self.page.serves and self.page.viewers == 0 and self.mode == "running", "it runs")

    def _work(self) -> None:
        with self._prepared:
            self.result.append(self._watch.run(self._prepared, lambda runner: runner.run()))
        self.page.stop()
        self._connector.stop()

    @property
    def mode(self) -> str:
        return self.runner.view.mode

    def order(self, **words: Any) -> tuple[int, str]:
        status, _, reported = ask(self.page, "POST", "/orders", json.dumps(words).encode())
        return status, reported["why"]

    def post(self, name: str) -> None:
        self.runner.post(Event(name, self.runner.view.now()))

    def asked(self, viewer: Viewer) -> dict[str, Any]:
        until(lambda: viewer.seen.get("questions"), "a question is seen")
        found: dict[str, Any] = viewer.seen["questions"][0]
        return found

    def end(self) -> Result:
        self._thread.join(30)
        assert not self._thread.is_alive()
        return self.result[0]

    def journal_text(self) -> str:
        """The journal's events with who did them, and its notes."""
        with read(self.journal) as record:
            steps = [f"{step.event.kind} {step.event.name} by {step.event.data.get('by')}" for step in record.steps()]
            return "\n".join([*steps, *(note.text for note in record.notes())])


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[Callable[..., Watched]]:
    pytest.importorskip("uvicorn", reason="no server: pip install '.[watch]'")
    made: list[Watched] = []

    def make(**words: Any) -> Watched:
        made.append(Watched(tmp_path, **words))
        return made[-1]

    yield make
    for one in made:
        one.runner.kill("the test")
        one.end()


def test_every_act_is_an_event_in_the_journal_with_who_did_it(watched: Callable[..., Watched]) -> None:
    one = watched()
    for words in (
        {"command": "pause", "by": "operator Anna (page)"},
        {"command": "resume"},
        {"command": "control", "to": "operator"},
        {"command": "control", "to": "autonomy", "by": "Bert"},
    ):
        assert one.order(**words) == (200, ""), words
    until(lambda: one.runner.view.holder == "autonomy", "control is handed back")
    assert one.order(command="e_stop", by="Anna\n\u202e<script>")[0] == 200
    assert one.end().outcome == "aborted"
    reported = one.journal_text()
    for line in (
        "command pause by operator Anna (page)",
        "command resume by operator (page)",
        "control operator by operator (page)",
        "control autonomy by operator Bert (page)",
        "command kill by operator Anna",
    ):
        assert line in reported, reported


def test_what_is_refused_reports_why_and_is_in_the_journal(watched: Callable[..., Watched]) -> None:
    one = watched()
    assert one.order(command="resume") == (409, "only a paused mission can be resumed; it is running")
    for words, why in (
        ({"command": "start"}, "a page cannot 'start'"),
        ({"command": "post", "event": "go"}, "a page cannot 'post'"),
        ({"command": "control", "to": "king"}, "no one called 'king' can hold control"),
        ({"command": "answer", "question": 99, "option": "left"}, "question 99 is not open; open: none"),
        ({"command": "fly"}, "is none"),
        ({"command": "answer", "question": "1"}, "question"),
        ({}, "command"),
    ):
        status, reported = one.order(**words)
        assert (status, why in reported) == (409, True), (words, reported)
    assert one.mode == "running"
    for line in (
        "refused: control king by operator (page): no one called 'king'",
        "refused: answer left by operator (page): question 99 is not open",
    ):
        until(lambda line=line: line in one.journal_text(), line)  # type: ignore[misc]


def test_the_operator_answers_what_is_asked_and_the_run_continues(watched: Callable[..., Watched]) -> None:
    one = watched()
    viewer = Viewer(one.page)
    one.post("ask")
    question = one.asked(viewer)
    assert [option["name"] for option in question["options"]] == ["left", "right"]
    status, why = one.order(command="answer", question=question["number"], option="up")
    assert status == 409
    assert "'up' was not offered; offered: left, right" in why
    status, why = one.order(command="answer", question=question["number"], option="left", parameters={"far": True})
    assert (status, why) == (409, "the parameters of 'left' are not valid: 'left' takes none")
    assert one.asked(viewer)["number"] == question["number"], "a slip leaves the question open"
    assert one.order(command="answer", question=question["number"], option="right") == (200, "")
    stale = one.order(command="answer", question=question["number"], option="left")
    assert stale[0] == 409 and f"question {question['number']} is not open" in stale[1]
    viewer.cut()


def test_an_answer_ends_the_question_everywhere(watched: Callable[..., Watched]) -> None:
    class Terminal:
        def __init__(self) -> None:
            self.asked: list[Any] = []
            self.withdrawn: list[int] = []

        def ask(self, question: Any, answer: Any) -> None:
            self.asked.append((question, answer))

        def withdraw(self, number: int) -> None:
            self.withdrawn.append(number)

    terminal = Terminal()
    one = watched(terminal=terminal)
    viewer = Viewer(one.page)
    one.post("ask")
    question = one.asked(viewer)
    until(lambda: terminal.asked, "the terminal is asked too")
    assert one.order(command="answer", question=question["number"], option="right") == (200, "")
    until(lambda: terminal.withdrawn == [question["number"]], "the terminal is freed")
    until(lambda: viewer.seen["questions"] == [], "the page is freed")
    one.post("ask")
    until(lambda: len(terminal.asked) == 2, "asked again")
    second = one.asked(viewer)
    terminal.asked[1][1]({"option": "left"})
    assert one.end().outcome == "aborted"
    assert one.result[0].why == "'over' was reached"
    until(lambda: viewer.seen["questions"] == [], f"{second} is withdrawn")
    viewer.cut()


def test_who_joins_after_a_pause_sees_the_time_that_a_question_has_left(watched: Callable[..., Watched]) -> None:
    one = watched()
    viewer = Viewer(one.page)
    one.post("ask")
    until_ = one.asked(viewer)["until"]
    viewer.cut()
    until(lambda: one.page.viewers == 0 and one._watch._feed._wake is None, "no one looks")  # type: ignore[union-attr]
    assert one.order(command="pause") == (200, "")
    joins = Viewer(one.page)
    until(lambda: joins.sees(mode="paused"), f"{joins.seen}")
    paused_at = joins.seen["paused_at"]
    joins.cut()
    until(lambda: one.page.viewers == 0 and one._watch._feed._wake is None, "no one looks")  # type: ignore[union-attr]
    assert one.order(command="resume") == (200, "")
    late = Viewer(one.page)
    with read(one.journal) as record:
        at = {note: step.at for step in record.steps() for note in step.notes if note in ("paused", "resumed")}
    assert paused_at == at["paused"]
    assert one.asked(late)["until"] == pytest.approx(until_ + at["resumed"] - at["paused"])
    late.cut()


def test_a_question_for_someone_else_is_not_the_page_s_to_answer(watched: Callable[..., Watched]) -> None:
    thinks = type("Thinks", (), {"ask": lambda *_: None, "withdraw": lambda *_: None})()
    one = watched(answerers={"agent": thinks})
    viewer = Viewer(one.page)
    one.post("guess")
    question = one.asked(viewer)
    reported = one.order(command="answer", question=question["number"], option="left")
    assert reported == (409, f"question {question['number']} is not for the operator; agent is asked")
    viewer.cut()


def test_without_an_operator_the_page_answers_nothing(watched: Callable[..., Watched]) -> None:
    one = watched(operator=False)
    assert ask(one.page, "GET", "/mission")[2]["answers"] is False
    reported = one.order(command="answer", question=1, option="left")
    assert reported == (409, "no one answers as the operator in this run; it was begun with --no-operator")
    assert one.order(command="pause")[0] == 200


def test_the_run_file_is_its_owner_s_alone_and_goes_with_the_run(tmp_path: Path) -> None:
    journal = tmp_path / "a.journal"
    before = os.umask(0)
    try:
        with run_file(str(journal), {"url": "http://127.0.0.1:1/#token=x"}):
            path = tmp_path / "a.journal.watch"
            assert stat.S_IMODE(path.stat().st_mode) == 0o600
            assert running_page(journal) is None  # no server is there
            with LivePage(PageAddress(port=0))._socket as listening:
                path.write_text(json.dumps({"url": f"http://127.0.0.1:{listening.getsockname()[1]}/#token=x"}))
                assert running_page(journal) is not None
                path.chmod(0o644)
                assert running_page(journal) is None  # another user may have written it
        assert not path.exists()
    finally:
        os.umask(before)


def test_watch_prints_the_page_of_the_run_that_continues(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "journals").mkdir()
    for name in ("old", "new"):
        (tmp_path / f"journals/{name}.journal").write_text("")
    os.utime(tmp_path / "journals/old.journal", (1, 1))
    with LivePage(PageAddress(port=0))._socket as listening:
        url = f"http://127.0.0.1:{listening.getsockname()[1]}/#token=x"
        with run_file("journals/old.journal", {"url": url}):
            assert main(["watch"]) == 0
    assert capsys.readouterr().out == f"watch: {url}\n"
    assert find_journal(None) == Path("journals/new.journal")
    assert find_journal("old") == Path("journals/old.journal")
    with pytest.raises(UsageError, match=r"no journal 'nothing', and no run of that name in journals/: new, old"):
        find_journal("nothing")


def test_watch_finds_a_run_that_writes_its_journal_elsewhere_below(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("journals", "field/monday", "too/deep/by/far"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "journals/old.journal").write_text("")
    with LivePage(PageAddress(port=0))._socket as listening:
        url = f"http://127.0.0.1:{listening.getsockname()[1]}/#token="
        with ExitStack() as files:
            for name in ("field/monday/a", "b", "too/deep/by/far/c"):
                files.enter_context(run_file(f"{name}.journal", {"url": f"{url}{name[-1]}"}))
            os.utime("b.journal.watch", (1, 1))
            assert find_journal(None) == Path("field/monday/a.journal")
            os.utime("field/monday/a.journal.watch", (0, 0))
            assert find_journal(None) == Path("b.journal")
            assert main(["watch"]) == 0
    reported = capsys.readouterr()
    assert (reported.out, reported.err) == (f"watch: {url}b\n", "")
    assert find_journal(None) == Path("journals/old.journal")
    assert (
        "newest journal in journals/, and only that folder was searched for journals: journals/old"
        in capsys.readouterr().err
    )


def test_watch_without_any_run_reports_how_to_begin_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["watch"]) == 2
    assert "begin one with: rai-missions run --watch" in capsys.readouterr().err


def test_a_port_in_use_stops_a_run_before_it_begins(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LivePage(PageAddress(port=0))._socket as listening:
        port = str(listening.getsockname()[1])
        command = ["run", str(ROOT / "missions/tractor/mission.json"), "--journal", str(tmp_path / "a.journal")]
        command += ["--robot", str(ROOT / "missions/tractor/robot.sim.json"), "--watch", port]
        assert main(command) == 2
        assert re.search(f"port {port} is in use.*0 for any that is free", capsys.readouterr().err)
        assert not (tmp_path / "a.journal").exists()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["m.json", "--watch", "many"], "--watch many: give a port"),
        (["m.json", "--host", "0.0.0.0"], "give --watch, too"),
        (["m.json", "--watch", "--managed"], "--watch is of one run"),
    ],
)
def test_words_that_do_not_go_together_are_reported(words: list[str], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        normalise_watch_args(run.read(words)["options"])


def test_a_mission_behind_watch_is_the_mission() -> None:
    given = normalise_watch_args(RunOptions(watch="m.json"))
    assert (given.mission, given.watch) == ("m.json", "8765")
