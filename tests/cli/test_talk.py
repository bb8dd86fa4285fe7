# SPDX-License-Identifier: Apache-2.0
"""`run --talk` as a person at a terminal meets it, and one who writes through a pipe."""

from __future__ import annotations

import json
import os
import pty
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest

from rai_missions.agents.talk.journal import earlier_lines
from rai_missions.cli.main import main
from rai_missions.journal import read
from tests.rigs.chat_server import Server, completion

PROGRAM = Path(sys.executable).with_name("rai-missions")
PATIENCE_S = 60.0
WAITING: dict[str, Any] = {
    "format": 1, "name": "errand", "about": "wait for a while", "initial": "waiting",
    "blackboard": {"rounds": {"type": "integer", "source": "argument", "initial": 1, "about": "how many rounds"}},
    "states": {"waiting": {"about": "waits at the gate", "transitions": [{"after_s": 600, "to": "over"}]},
               "over": {"final": "aborted"}},
}  # fmt: skip


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "errand.json"
    path.write_text(json.dumps(WAITING))
    return path


class Terminal:
    """A terminal with the program in it."""

    def __init__(self, mission: Path, *more: str) -> None:
        self.main, side = pty.openpty()
        self.journal = mission.with_suffix(".journal")
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "200", "LINES": "40"}
        self.program = subprocess.Popen(
            [PROGRAM, "run", mission, "--talk", "--journal", self.journal, *more],
            stdin=side,
            stdout=side,
            stderr=side,
            env=environment,
            start_new_session=True,
            preexec_fn=lambda: _own_terminal(side),  # noqa: PLW1509 - this test has no other thread
        )
        os.close(side)
        self.text = ""

    def until(self, words: str) -> None:
        """Read on behind the next place at which this is printed."""
        end = time.monotonic() + PATIENCE_S
        while words not in self.text:
            assert time.monotonic() < end, self.text
            ready, _, _ = select.select([self.main], [], [], 0.2)
            if ready:
                try:
                    piece = os.read(self.main, 65_536).decode("utf-8", "replace")
                except OSError:
                    piece = ""
                assert piece, self.text
                self.text += piece
                if "\x1b[6n" in piece:  # it asks where the cursor is
                    os.write(self.main, b"\x1b[1;1R")
        self.text = self.text.partition(words)[2]

    def type(self, text: str) -> None:
        os.write(self.main, text.encode())


def _own_terminal(side: int) -> None:
    import fcntl
    import termios

    fcntl.ioctl(side, termios.TIOCSCTTY, 0)


@contextmanager
def terminal(mission: Path, *more: str) -> Iterator[Terminal]:
    made = Terminal(mission, *more)
    try:
        yield made
    finally:
        if made.program.poll() is None:
            os.killpg(made.program.pid, signal.SIGKILL)
        made.program.wait(PATIENCE_S)
        os.close(made.main)


def test_a_person_at_a_terminal_asks_edits_the_line_orders_and_confirms(mission: Path) -> None:
    with terminal(mission) as screen:
        screen.until("has started")
        screen.type("what are you duing\x7f\x7f\x7f\x7foing?\r")
        screen.until("waits at the gate")
        screen.type("cancel the mission\r")
        screen.until("Is that right?")
        screen.type("yes\r")
        screen.until("canceled: canceled by operator (terminal)")
        assert screen.program.wait(PATIENCE_S) == 1
    with read(screen.journal) as record:
        kinds = [each["kind"] for row in record.rows() for each in (getattr(row, "data", None) or {}).get("talk", ())]
    assert {"heard", "read_back", "confirmed", "ordered", "spoken"} <= set(kinds)


@pytest.mark.long
def test_ctrl_c_on_the_line_cancels_the_mission(mission: Path) -> None:
    with terminal(mission) as screen:
        screen.until("has started")
        screen.type("\x03")
        screen.until("canceled: canceled by operator (interrupt)")
        assert screen.program.wait(PATIENCE_S) == 1


@pytest.mark.long
def test_a_named_model_answers_what_the_rules_leave_open_and_its_order_counts_once_confirmed(
    mission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("langchain_openai")
    order = json.dumps({"order": {"order": "cancel"}})
    server = Server()
    server.replies = [
        completion("I have arrived at the gate. Roses like sunshine."),
        completion(calls=[("propose_order", order)]),
    ]
    monkeypatch.setenv("OPENAI_API_KEY", "sk-loopback-0123456789")
    monkeypatch.setenv("OPENAI_BASE_URL", server.url)
    with terminal(mission, "--model", "openai:gpt-4o") as screen:
        screen.until("has started")
        screen.type("which flowers like the sun?\r")
        screen.until("the model thinks: Roses like sunshine.")
        screen.type("I would rather do something else today\r")
        screen.until("Is that right?")
        screen.type("yes\r")
        screen.until("canceled: canceled by operator (terminal)")
        assert screen.program.wait(PATIENCE_S) == 1
    server.shutdown()
    server.server_close()
    with read(screen.journal) as record:
        talk = [each for row in record.rows() for each in (getattr(row, "data", None) or {}).get("talk", ())]
    texts = {kind: [each["text"] for each in talk if each["kind"] == kind] for kind in ("spoken", "replaced")}
    assert texts["replaced"] == ["I have arrived at the gate."]
    assert "Roses like sunshine." in texts["spoken"] and "I have arrived at the gate." not in texts["spoken"]


@pytest.mark.long
def test_a_terminal_that_goes_away_ends_no_mission_and_the_end_is_in_the_journal(mission: Path) -> None:
    states = WAITING["states"] | {"waiting": {"transitions": [{"after_s": 2, "to": "over"}]}}
    mission.write_text(json.dumps(WAITING | {"states": states}))
    journal = mission.with_suffix(".journal")
    result = subprocess.run(
        [PROGRAM, "run", mission, "--talk", "--journal", journal],
        input="what are you doing?\n",
        text=True,
        capture_output=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert result.returncode == 1 and "aborted" in result.stdout, result
    with read(journal) as record:
        lines = [each for row in record.rows() for each in (getattr(row, "data", None) or {}).get("lines", ())]
    assert any(line["report"].endswith(":end") for line in lines)


COUNTING: dict[str, Any] = {
    "format": 1, "name": "errand", "initial": "counting",
    "blackboard": {"rounds": {"type": "integer", "source": "argument", "initial": 1, "about": "how many rounds"},
                   "done": {"type": "integer", "source": "mission", "initial": 0}},
    "states": {"counting": {"transitions": [
                   {"when": {"key": "done", "<": {"key": "rounds"}}, "do": [{"set": "done", "add": 1}]},
                   {"after_s": 1, "to": "over"}]},
               "over": {"final": "aborted"}},
}  # fmt: skip


def profile(mission: Path, **conversation: Any) -> Path:
    path = mission.with_name("robot.json")
    given = {"format": 1, "name": "bench", "connector": {"kind": "local"}, "conversation": conversation}
    path.write_text(json.dumps(given))
    return path


def test_the_input_ends_by_a_key_that_is_pressed_before_a_line_is_asked_for(mission: Path) -> None:
    with terminal(mission, "--robot", str(profile(mission, begins="ready"))) as screen:
        screen.type("\x04")
        screen.until("was canceled: canceled by operator (end of input)")
        assert screen.program.wait(PATIENCE_S) == 1


PYTHON_ROBOT = """
from rai_missions import PythonRobot

print("executed")


def robot():
    return PythonRobot("turtle", conversation={"begins": "ready", "phrases": {"walk {rounds} rounds": {}}})
"""


def test_a_robot_in_python_talks_as_a_profile_does(mission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = mission.with_name("turtle.py")
    file.write_text(PYTHON_ROBOT)
    with terminal(mission, "--robot", str(file)) as screen:
        screen.until("executed")
        screen.until("waits for the order to start")
        screen.type("walk three rounds\r")
        screen.until("with rounds 3. Is that right?")
        screen.type("yes\r")
        screen.until("has started")
        os.killpg(screen.program.pid, signal.SIGKILL)
    file.write_text(PYTHON_ROBOT + "assert False, 'executed although it is another file'")
    assert main(["run", "--resume", str(screen.journal), "--robot", str(file), "--talk"]) == 2
    assert "resume with the file as it was" in capsys.readouterr().err


def test_what_is_wrong_in_how_a_robot_in_python_talks_comes_with_its_file(
    mission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = mission.with_name("turtle.py")
    file.write_text(PYTHON_ROBOT.replace("{}}", '{"laps": 2, "rounds": "two"}}'))
    assert main(["run", str(mission), "--robot", str(file), "--talk"]) == 2
    printed = capsys.readouterr().err
    assert f"{file}: /conversation/phrases/walk {{rounds}} rounds" in printed


@pytest.mark.long
def test_after_the_end_another_run_is_started_by_talk_with_its_arguments(mission: Path) -> None:
    mission.write_text(json.dumps(COUNTING))
    with terminal(mission, "--robot", str(profile(mission, begins="ready"))) as screen:
        screen.until("waits for the order to start")
        screen.type("start\r")
        screen.until("Is that right?")
        screen.type("yes\r")
        screen.until("'errand' was aborted")
        screen.until("waits for the order to start")
        screen.type("start with rounds 3\r")
        screen.until("with rounds 3. Is that right?")
        screen.type("yes\r")
        screen.until("done := 3")
        screen.until("'errand' was aborted")
        screen.until("errand-3.journal")
        screen.type("\x04")
        screen.until("was canceled: canceled by operator (end of input)")
        assert screen.program.wait(PATIENCE_S) == 1
    second = str(mission.with_name("errand-2.journal"))
    assert main(["verify", second]) == main(["replay", second]) == 0, "talk changes nothing in what is repeated"
    with read(mission.with_name("errand-3.journal")) as record:
        lines = [each for row in record.rows() for each in (getattr(row, "data", None) or {}).get("lines", ())]
    assert [line["report"].partition(":")[2] for line in lines if line["report"]] == ["ready", "end"], "it never began"


@pytest.mark.long
@pytest.mark.parametrize(("answer", "runs"), [("yes\r", 2), ("no\r", 1), ("\x03", 1)], ids=["yes", "no", "interrupt"])
def test_after_a_run_that_did_not_succeed_a_request_begins_by_a_yes_alone(
    mission: Path, answer: str, runs: int
) -> None:
    slower = COUNTING["states"]["counting"]["transitions"][0], {"after_s": 8, "to": "over"}
    mission.write_text(json.dumps(COUNTING | {"states": COUNTING["states"] | {"counting": {"transitions": slower}}}))
    with terminal(mission, "--robot", str(profile(mission))) as screen:
        screen.until("has started")
        screen.type("start with rounds 3\r")
        screen.until("with rounds 3. Is that right?")
        screen.type("yes\r")
        screen.until("waits as number 1")
        screen.until("Shall it begin now?")
        screen.type(answer)
        if runs == 2:
            screen.until("done := 3")
            screen.until("'errand' was aborted")
        elif answer == "\x03":
            screen.until("because the program ends")
        assert screen.program.wait(PATIENCE_S) == 1
    assert mission.with_name("errand-2.journal").exists() == (runs == 2)


def confirmed(command: Sequence[str | Path], typed: str) -> subprocess.CompletedProcess[str]:
    """Run a program to its end, which receives lines at its start, and a yes each time that it asks for one."""
    program = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert program.stdin and program.stdout and program.stderr
    with program, program.stdin as keys:
        keys.write(typed)
        keys.flush()
        shown = ""
        while "Order taken" not in shown and (line := program.stdout.readline()):
            shown += line
            if "Is that right?" in line:
                keys.write("yes\n")
                keys.flush()
        keys.close()
        shown += program.stdout.read()
        errors = program.stderr.read()
    return subprocess.CompletedProcess(command, program.wait(PATIENCE_S), shown, errors)


@pytest.mark.long
def test_a_yes_that_was_piped_before_the_order_was_read_back_confirms_nothing(mission: Path) -> None:
    mission.write_text(json.dumps(COUNTING))
    command = [PROGRAM, "run", mission, "--talk", "--robot", profile(mission, begins="ready")]
    result = subprocess.run(
        command,
        input="start with rounds 2\nyes\nyes\n",
        text=True,
        capture_output=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert result.stdout.count("Is that right?") >= 3 and "Order taken" not in result.stdout, result


@pytest.mark.long
def test_who_pipes_the_orders_of_a_run_that_waits_has_it_started_and_ended(mission: Path) -> None:
    mission.write_text(json.dumps(COUNTING))
    command = [PROGRAM, "run", mission, "--talk", "--robot", profile(mission, begins="ready"), "--journal"]

    def run(number: int, typed: str) -> str:
        result = subprocess.run(
            [*command, mission.with_suffix(f".{number}")],
            input=typed,
            text=True,
            capture_output=True,
            timeout=PATIENCE_S,
            check=False,
        )
        assert result.returncode == 1, result
        return result.stdout

    started = confirmed([*command, mission.with_suffix(".1")], "start with rounds 2\n")
    assert "'errand' was aborted" in started.stdout and started.returncode == 1, started
    assert "canceled by operator (end of input)" in run(2, "")
    assert "robot: Stop." in run(3, "stop"), "a last line without an end is lost"


@pytest.mark.long
def test_a_run_that_was_killed_before_its_start_waits_for_it_again(mission: Path) -> None:
    mission.write_text(json.dumps(COUNTING))
    robot = profile(mission, begins="ready")
    with terminal(mission, "--robot", str(robot), "--set", "rounds=2") as screen:
        screen.until("waits for the order to start")
        screen.program.kill()
    journal = mission.with_suffix(".journal")
    resumed = confirmed([PROGRAM, "run", "--talk", "--resume", journal], "what are you doing?\nstart\n")
    assert "is ready to start" in resumed.stdout and "done := 2" in resumed.stdout, resumed
    assert (
        "Again: The mission 'errand' is ready" in resumed.stdout
        and "Again: The mission 'errand' has" not in resumed.stdout
    )
    assert main(["verify", str(journal)]) == 0


@pytest.mark.long
def test_what_waited_when_a_run_was_killed_is_reported_by_the_one_that_resumes_it(mission: Path) -> None:
    with terminal(mission) as screen:
        screen.until("has started")
        for rounds in (2, 3):
            screen.type(f"start with rounds {rounds}\r")
            screen.until("Is that right?")
            screen.type("yes\r")
            screen.until("waits as number")
        screen.type("what are you doing\r")  # its answer is behind the note in the journal
        screen.until("waits at the gate")
        screen.program.kill()
    resumed = subprocess.run(
        [PROGRAM, "run", "--talk", "--resume", screen.journal],
        input="stop\n",
        text=True,
        capture_output=True,
        timeout=PATIENCE_S,
        check=False,
    )
    lost = next(line for line in resumed.stdout.splitlines() if "are lost with it" in line)
    assert "with rounds 2" in lost and "with rounds 3" in lost
    with read(screen.journal) as record:
        lines = [(line.by, line.text) for line in earlier_lines(record.notes())]
    asked = lines.index(("operator", "start with rounds 2"))
    assert asked < lines.index(("operator", "what are you doing")) < lines.index(("operator", "stop"))


WORDS = {"--json": "--talk does not go with --json", "--managed": "--talk is of one run; a managed node has many"}


@pytest.mark.parametrize("word", WORDS)
def test_what_does_not_go_with_talk_is_refused(mission: Path, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(mission), "--talk", word]) == 2
    assert WORDS[word] in capsys.readouterr().err


@pytest.mark.long
def test_the_end_is_reported_in_the_output_where_the_last_page_was_closed_before_it(mission: Path) -> None:
    """What is printed is kept wherever it goes, so it is no reason to wait for a reader who may never come."""
    journal = mission.with_suffix(".journal")
    with subprocess.Popen(
        [PROGRAM, "run", mission, "--talk", "--watch", "0", "--journal", journal],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as program:
        assert program.stdout is not None
        address = next(line for line in program.stdout if line.startswith("watch: ")).split()[1]
        page, _, token = address.partition("#token=")
        headers = {"X-Mission-Token": token, "Content-Type": "application/json", "Origin": page.rstrip("/")}
        with urlopen(Request(f"{page}events", headers=headers), timeout=PATIENCE_S) as viewer:
            assert viewer.readline()
        cancel = json.dumps({"command": "cancel"}).encode()
        with urlopen(Request(f"{page}orders", cancel, headers), timeout=PATIENCE_S) as reply:
            assert reply.status == 200
        out, _ = program.communicate(timeout=PATIENCE_S)
    assert "robot: The mission 'errand' was canceled" in out and "could be reached" not in out, out
    with read(journal) as record:
        lines = [each for row in record.rows() for each in (getattr(row, "data", None) or {}).get("lines", ())]
    assert [line["spoken"] for line in lines if line["report"].endswith(":end")] == [""], lines
