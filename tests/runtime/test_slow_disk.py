# SPDX-License-Identifier: Apache-2.0
"""A disk that hangs: the robot is stopped all the same, nothing is done before it is written, and the run ends."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine.step import StartGoal
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Header, Journal, buffer, read
from rai_missions.runtime import mailbox as mailboxes
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.mailbox import MOST_BEFORE_PICTURE, MOST_BEFORE_WRITE, Mailbox
from rai_missions.runtime.result import Result
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import ReplyingAnswerer, Rig, robot

PATIENCE_S = 30.0
MOVING: dict[str, Any] = {
    "idle": {"transitions": [{"on": "go", "to": "moving"}]},
    "moving": {"action": "move", "timeout_s": 500, "transitions": [
        {"on": "again", "to": "moving", "internal": True, "do": [{"set": "count", "add": 1}]},
        {"on": "stop_now", "to": "turning"}]},
    "turning": {"action": "turn", "timeout_s": 500, "transitions": []},
}  # fmt: skip

DEADLINE_S = 0.3
ASKING: dict[str, Any] = {
    "asking": {"decision": {"question": "Which?", "options": {"left": {}, "right": {}}, "ask": ["operator"],
                            "deadline_s": DEADLINE_S, "fallback": "right"},
               "transitions": [{"on": "again", "do": [{"set": "count", "add": 1}]},
                               {"on": "left", "to": "over"}, {"on": "right", "to": "lost"}]},
    "over": {"final": "aborted"}, "lost": {"final": "failed"},
}  # fmt: skip


@pytest.fixture
def running() -> Iterator[Callable[[Rig], list[Result]]]:
    """Runs on a thread of their own."""
    threads: list[threading.Thread] = []

    def run(rig: Rig) -> list[Result]:
        results: list[Result] = []
        threads.append(threading.Thread(target=lambda: results.append(rig.run())))
        threads[-1].start()
        return results

    yield run
    for thread in threads:
        thread.join(PATIENCE_S)


def wait_for(holds: Callable[[], object]) -> None:
    """Wait until something holds."""
    slice_s = 0.005
    for _ in range(int(PATIENCE_S / slice_s)):
        if holds():
            return
        threading.Event().wait(slice_s)
    raise AssertionError("it never came to hold")


Running = Callable[[Rig], list[Result]]


def test_an_e_stop_reaches_the_robot_while_the_disk_hangs(running: Running) -> None:
    book = MemoryJournal(hangs_at="again")
    rig = Rig(MOVING, {1.0: lambda: rig.post("go"), 2.0: lambda: rig.post("again")}, journal=book)
    results = running(rig)
    assert book.hangs.wait(PATIENCE_S) and rig.move.canceled == []
    rig.runner.kill()
    wait_for(lambda: rig.move.canceled)
    assert not results and not book.answers.is_set(), "the disk has not answered"
    book.answers.set()
    wait_for(lambda: results)
    assert results[0].outcome == "aborted" and results[0].why.startswith("e-stop by operator")
    names = [step.event.name for step in book.steps]
    assert names.index("again") < names.index("kill"), "in the order in which it happened"


def test_what_waited_for_the_disk_while_an_e_stop_came_is_not_begun(running: Running) -> None:
    book = MemoryJournal(hangs_at="go")
    rig = Rig(MOVING, {1.0: lambda: rig.post("go")}, journal=book)
    results = running(rig)
    assert book.hangs.wait(PATIENCE_S)
    rig.runner.kill()
    book.answers.set()
    wait_for(lambda: results)
    assert results[0].outcome == "aborted" and rig.move.goals == []
    assert any(isinstance(effect, StartGoal) for step in book.steps for effect in step.effects), "it was written"
    assert not any("orphaned" in note for step in book.steps for note in step.notes)


def test_control_goes_to_no_one_while_the_disk_hangs(running: Running) -> None:
    asked: list[str] = []
    book = MemoryJournal(hangs_at="again")
    profile = robot(control={"nobody": {"service": "/let_go", "type": "std_srvs/srv/Trigger"}})
    rig = Rig(MOVING, {1.0: lambda: rig.post("go"), 2.0: lambda: rig.post("again")}, journal=book, robot=profile)

    def let_go(_: object) -> dict[str, object]:
        asked.append("nobody")
        return {"success": True}

    rig.connector.serve("/let_go", "std_srvs/srv/Trigger", let_go)
    results = running(rig)
    assert book.hangs.wait(PATIENCE_S)
    rig.runner.kill()
    wait_for(lambda: asked)
    assert not book.answers.is_set()
    book.answers.set()
    wait_for(lambda: results)
    assert asked == ["nobody"]


def test_a_disk_that_never_answers_is_one_that_cannot_be_written(
    running: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(buffer, "LONGEST_S", 0.3)
    book = MemoryJournal(hangs_at="stop_now")
    rig = Rig(MOVING, {1.0: lambda: rig.post("go"), 2.0: lambda: rig.post("stop_now")}, journal=book)
    results = running(rig)
    wait_for(lambda: results)
    assert not book.answers.is_set(), "it ended although the disk still hangs"
    assert results[0].why == "e-stop by the journal: its disk has not answered for 0.3 s"
    assert rig.move.canceled == rig.move.goals != [] and rig.turn.goals == []
    book.answers.set()


@pytest.mark.parametrize(("after_due_s", "outcome"), [(-0.01, "aborted"), (0.01, "failed")])
def test_a_deadline_that_passed_while_the_disk_hung_has_passed_and_what_came_before_it_counts(
    running: Running, after_due_s: float, outcome: str
) -> None:
    """The run's time continues; each thing has the time at which it came."""
    book, wall, asked = MemoryJournal(hangs_at="again"), PinnedClock(), threading.Event()
    rig = Rig(ASKING, journal=book, clock=wall, answerers={"operator": ReplyingAnswerer(lambda question: asked.set())})
    results = running(rig)
    assert asked.wait(PATIENCE_S)
    rig.post("again")
    assert book.hangs.wait(PATIENCE_S)
    (question,) = [step.question for step in book.steps if step.question is not None]
    wait_for(lambda: wall.now() > question.at + DEADLINE_S + 0.1)
    wall.here = question.at + DEADLINE_S + after_due_s
    rig.runner.answer(question.number, "left")
    book.answers.set()
    wait_for(lambda: results)
    assert results[0].outcome == outcome


class PinnedClock(WallClock):
    """Real time, but on the thread that made it what that thread reports, once it states something."""

    def __init__(self) -> None:
        super().__init__()
        self.here: float | None = None
        self._thread = threading.get_ident()

    def now(self) -> float:
        is_here = threading.get_ident() == self._thread
        return self.here if is_here and self.here is not None else super().now()


def test_what_a_robot_reports_to_a_run_that_takes_nothing_does_not_fill_its_memory() -> None:
    mailbox, picture = Mailbox(), Image("camera@1", 640, 480, "rgb8", bytes)
    for number in range(MOST_BEFORE_PICTURE + 50):
        mailbox.post(Event("camera", float(number), {"value": picture}, "write"))
    assert mailbox.waiting == MOST_BEFORE_PICTURE + 1, "and the newest"
    for number in range(MOST_BEFORE_WRITE):
        mailbox.post(Event("battery", float(number), {"value": 0.5}, "write"))
    assert mailbox.waiting == MOST_BEFORE_WRITE + 2
    mailbox.post(Event("stop_now"))
    assert mailbox.waiting == MOST_BEFORE_WRITE + 3, "what happens is never lost"
    last = {event.name: event.at for event in iter(mailbox.take, None)}
    assert last == {"camera": MOST_BEFORE_PICTURE + 49.0, "battery": MOST_BEFORE_WRITE - 1.0, "stop_now": 0.0}
    assert mailbox.empty and not mailbox.waiting


def test_what_a_robot_reports_once_while_far_too_much_waits_is_received(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its key never grows old: the run would believe what was so before, for ever."""
    monkeypatch.setattr(mailboxes, "MOST_BEFORE_WRITE", 50)
    states = {"moving": {"action": "move", "timeout_s": 500, "transitions": [
                  {"on": "again", "do": [{"set": "count", "add": 1}]},
                  {"when": {"key": "there", "==": True}, "to": "over"}]},
              "over": {"final": "aborted"}}  # fmt: skip
    rig = Rig(states)

    def flood() -> None:
        rig.publish("/there", data=False)
        for _ in range(100):
            rig.post("again")
        rig.publish("/there", data=False)
        rig.publish("/there", data=True)

    rig.stage.play({1.0: flood, 20.0: rig.runner.kill})
    assert rig.run().why == "'over' was reached"


def test_anyone_who_waits_is_woken_by_what_was_kept_for_later(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last of too much is taken just as another fact finds no room behind it."""
    monkeypatch.setattr(mailboxes, "MOST_BEFORE_WRITE", 0)
    mailbox, taken = Mailbox(), list[Event | None]()

    def wait() -> None:
        mailbox.wait(PATIENCE_S)
        taken.append(mailbox.take())

    waits = threading.Thread(target=wait)
    waits.start()
    mailbox.post(Event("there", 1.0, {"value": True}, "write"))
    waits.join(PATIENCE_S / 2)
    assert [event.name for event in taken if event is not None] == ["there"]


def test_a_disk_that_becomes_read_only_stops_the_robot(tmp_path: Path) -> None:
    journal = Journal.create(tmp_path / "run.journal", Header('{"format": 1}'))
    rig = Rig(MOVING, {1.0: lambda: rig.post("go"), 3.0: lambda: rig.post("again")}, journal=journal)
    rig.stage.play({2.0: lambda: journal._database.execute("PRAGMA query_only=ON")})
    result = rig.run()
    journal.close()
    assert result.outcome == "aborted" and "attempt to write a readonly database" in result.why
    assert rig.move.canceled == rig.move.goals != []
    with read(tmp_path / "run.journal") as record:
        assert [step.event.name for step in record.steps()][-1] == "accepted", "what was written is there"


def test_a_journal_is_closed_although_its_disk_hangs_and_stays_this_process_own(tmp_path: Path) -> None:
    hangs, answers, path = threading.Event(), threading.Event(), tmp_path / "run.journal"

    def witness(*_: object) -> None:
        hangs.set()
        assert answers.wait(PATIENCE_S)

    journal = Journal.create(path, Header('{"format": 1}'))
    journal._witness = witness
    writes = threading.Thread(target=lambda: journal.note("slowly"))
    writes.start()
    assert hangs.wait(PATIENCE_S)
    journal.close()
    with pytest.raises(UsageError, match="is being written by this process already"):
        Journal.open(path)
    answers.set()
    writes.join()
    journal.close()
    Journal.open(path).close()
