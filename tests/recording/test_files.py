# SPDX-License-Identifier: Apache-2.0
"""A recording as a file: refused, full, killed, altered, and what there was no room for."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message, Report
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Header, Journal, read
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.recording import Recording, check_name, journal_of
from rai_missions.recording import queue as rooms
from rai_missions.recording import recording as pace
from rai_missions.recording.file import RecordingFile, make_file
from rai_missions.recording.queue import RecordingQueue, Route, packed, unpacked
from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.recording.kept import LAMP, kept, recording
from tests.rigs.journals import anomalies, raw_rows_of

mcap = pytest.importorskip("mcap")
PATIENCE_S = 30.0
FEEDBACK = Report("g", "feedback", {})


def journaled(folder: Path, made: Recording, count: int) -> Journal:
    with Journal.create(folder / "run.journal", Header(dump(LAMP)), witness=made.rows) as journal:
        for step in anomalies(count):
            journal.write(step, since=0.0)
    return journal


def until(is_so: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end, "it did not come to be so"
        time.sleep(0.01)


# -- refused -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "better"), [("run.bag", "run.mcap"), ("run", "run.mcap"), ("a.b.db3", "a.b.mcap")])
def test_a_recording_is_called_what_it_is(name: str, better: str) -> None:
    with pytest.raises(UsageError, match=f"'{name}' does not end so; name it '{better}'"):
        check_name(Path(name))


def test_without_the_library_one_sentence_states_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mcap", None)
    with pytest.raises(UsageError, match=r"needs the package mcap .*: pip install '\.\[record\]'"):
        check_name(Path("run.mcap"))


def test_the_library_is_loaded_by_no_run_that_is_not_recorded() -> None:
    reported = "import rai_missions.agents.mission, rai_missions.recording, sys; print('mcap' in sys.modules)"
    assert subprocess.check_output([sys.executable, "-c", reported], text=True) == "False\n"


def test_a_recording_is_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_text("mine")
    with pytest.raises(UsageError, match="is there already, and is no recording"):
        recording(path)
    assert path.read_text() == "mine"


def test_an_earlier_recording_is_renamed_and_has_its_name_again_where_none_is_made(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recording(path).close()
    earlier = path.read_bytes()
    made = recording(path)
    assert made.moved_aside == tmp_path / "run.1.mcap" and made.moved_aside.read_bytes() == earlier
    made.withdraw()
    assert path.read_bytes() == earlier and list(tmp_path.iterdir()) == [path]


def test_a_recording_that_is_being_written_keeps_its_name(tmp_path: Path) -> None:
    made = recording(tmp_path / "run.mcap")
    with pytest.raises(UsageError, match="is being written by another run"):
        recording(tmp_path / "run.mcap")
    assert list(tmp_path.iterdir()) == [made.path]
    made.close()
    assert recording(tmp_path / "run.mcap").moved_aside == tmp_path / "run.1.mcap"


def test_a_recording_that_another_run_has_just_begun_is_refused_as_one_that_is_being_written(tmp_path: Path) -> None:
    begun = make_file(tmp_path / "run.mcap")
    with pytest.raises(UsageError, match="is being written by another run"):
        make_file(tmp_path / "run.mcap")
    begun.give_back()
    assert list(tmp_path.iterdir()) == []


def test_where_none_can_be_written_it_is_reported(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").mkdir()
    with pytest.raises(UsageError, match="is there already"):
        recording(tmp_path / "run.mcap")


# -- no recording of ours ----------------------------------------------------------------------------------------------


def refused(path: Path) -> str:
    with pytest.raises(DefinitionError) as reported, journal_of(path):
        pass
    assert reported.value.source == str(path)
    return str(reported.value)


def test_what_is_no_recording_of_a_run_is_reported_so(tmp_path: Path) -> None:
    from mcap.writer import Writer

    other, text, old = tmp_path / "other.mcap", tmp_path / "text.mcap", tmp_path / "old.mcap"
    for path, words in ((other, None), (old, {"format": "9"})):
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start()
            if words:
                writer.add_metadata("rai_missions", words)
            writer.finish()
    text.write_text("notes of mine")
    assert "an MCAP file, but no recording of a mission; give one that `rai-missions run --record`" in refused(other)
    assert "no MCAP file" in refused(text)
    assert "a recording of format 9; this program reads format 1" in refused(old)


def test_whatever_is_no_recording_is_left_to_anyone_who_reads_journals(tmp_path: Path) -> None:
    with journal_of(tmp_path / "missing.mcap") as replayed:
        assert replayed.path == tmp_path / "missing.mcap"
    with journal_of(tmp_path / "run.journal") as replayed:
        assert replayed.path == tmp_path / "run.journal"


def rewritten(path: Path, change: Callable[[dict[str, Any]], dict[str, Any] | None]) -> None:
    """A recording with other rows, of which every checksum holds."""
    from mcap.writer import Writer

    whole = kept(path)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata("rai_missions", whole.metadata["rai_missions"])
        schema = writer.register_schema("row", "jsonschema", b"{}")
        channel = writer.register_channel("/rai_missions/journal", "json", schema)
        for row in whole.messages["/rai_missions/journal"]:
            changed = change(row)
            if changed is not None:
                writer.add_message(channel, 0, json.dumps(changed).encode(), 0)
        writer.finish()


@pytest.mark.parametrize(
    ("change", "reported"),
    [
        (lambda row: row | {"content": row["content"].replace('"n":3', '"n":4')}, "row 3: its hash"),
        (lambda row: None if row["row"] == 2 else row, "row 2: missing: row 3 comes next"),
        (lambda row: row | {"row": min(row["row"], 4)}, "row 4: no journal has such a row: UNIQUE"),
        (lambda row: row | {"row": "2"}, "is damaged before byte"),
        (lambda row: {"row": row["row"]}, "is damaged before byte"),
        (lambda row: None, "row 0: missing: the journal is empty"),
    ],
    ids=["content", "removed", "twice", "number", "nothing", "all"],
)
def test_rows_that_were_altered_are_reported_with_their_place(tmp_path: Path, change: Any, reported: str) -> None:
    path = tmp_path / "run.mcap"
    made = recording(path)
    made.close(journaled(tmp_path, made, 5).path)
    rewritten(path, change)
    with pytest.raises(DefinitionError) as error, journal_of(path) as replayed, read(replayed.path):
        pass
    assert reported in str(error.value)
    assert str(error.value).startswith(str(path))


# -- full, slow, killed ------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_a_full_disk_ends_the_recording_and_not_the_mission(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = make_file(tmp_path / "run.mcap")
    made = Recording(target, mission=LAMP, about={}, now=lambda: 0.0)
    with Path("/dev/full").open("wb") as full:
        os.dup2(full.fileno(), target.stream.fileno())
    mission = Mission.model_validate(
        {
            "name": "lamp",
            "initial": "on",
            "states": {"on": {"transitions": [{"after_s": 1, "to": "off"}]}, "off": {"final": "aborted"}},
        }
    )
    with Journal.create(tmp_path / "run.journal", Header(dump(mission)), witness=made.rows) as journal:
        runner = Runner(mission, clock=SimulatedClock(), journal=journal, observer=RunObserver(made.step))
        made.received(Message("/battery", {"percentage": 1.0}, 0.0), "")
        until(lambda: "the mission continues" in caplog.text)
        assert runner.run().outcome == "aborted"
    made.close(journal.path)
    assert made.summary is not None and "No space left on device" in made.summary.why
    assert "broken off" in str(made.summary)
    assert len(raw_rows_of(tmp_path / "run.journal")) == 3


def test_so_many_of_a_kind_wait_and_the_others_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(rooms.MOST, "message", 2)
    monkeypatch.setitem(rooms.MOST_BYTES, "picture", 100)
    queue = RecordingQueue((Route("message", print), Route("picture", print)))
    message, small, big = (0, 1, 0, 0.0, "/a", None), (1, 100, 0, 0.0, "/small", None), (1, 101, 0, 0.0, "/big", None)
    for item in (message, message, message, message, message, big, small):
        queue.put(item)
    assert queue.dropped == {"/a": 3, "/big": 1} and queue.is_filling
    assert [queue.take() for _ in range(4)] == [message, message, small, None]
    queue.put(message)
    queue.put(small)
    assert queue.dropped == {"/a": 3, "/big": 1}, "there is room again"


@given(st.lists(st.booleans(), max_size=60))
def test_what_waits_comes_in_its_order_and_wakes_a_thread_that_found_nothing(puts: list[bool]) -> None:
    queue, waiting, sleeps = RecordingQueue((Route("message", print),)), deque[Any](), True
    for number, is_put in enumerate(puts):
        if is_put:
            item = (0, 1, number, 0.0, "/a", None)
            assert queue.put(item) == sleeps
            waiting.append(item)
            sleeps = False
        else:
            sleeps = sleeps or not waiting
            assert queue.take() == (waiting.popleft() if waiting else None)


plain_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inside: st.lists(inside, max_size=3) | st.dictionaries(st.text(max_size=3), inside, max_size=3),
    max_leaves=8,
)


@given(st.lists(plain_values, max_size=4))
def test_what_waits_is_what_was_given_also_where_it_cannot_be_packed(values: list[Any]) -> None:
    unpackable = threading.Lock()
    assert unpacked(packed(tuple(values))) == tuple(values)
    assert unpacked(packed((*values, unpackable))) == (*values, unpackable)


class NotedWaits(threading.Event):
    """An event for which no one waits; it notes how long they would have."""

    def __init__(self) -> None:
        super().__init__()
        self.waits: list[float | None] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.waits.append(timeout)
        return self.is_set()


@given(st.lists(st.integers(0, 3), max_size=8))
def test_the_thread_rests_longer_as_long_as_more_comes_than_it_writes(
    tmp_path_factory: pytest.TempPathFactory, arrivals: list[int]
) -> None:
    """An item is written at a time; how many come meanwhile is drawn."""
    coming, written, waiting = iter(arrivals), 0, 1
    expected: list[float | None] = [pace.GATHER_S]
    while waiting:
        count = next(coming, 0)
        written, waiting = written + 1, waiting + count - 1
        expected += [pace.REST_S, pace.LONG_REST_S] if count > 1 else [pace.REST_S]
    coming, closing, until_written = iter(arrivals), NotedWaits(), list[list[float | None]]()

    def clean(value: Any) -> Any:
        until_written.append(closing.waits.copy())
        for _ in range(next(coming, 0)):
            made.reported("/tray", FEEDBACK)
        return value

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pace, "SPELL_S", 0.0)
        patch.setattr(pace, "LATE_S", PATIENCE_S)
        made = recording(tmp_path_factory.mktemp("run") / "run.mcap", clean=clean)
        patch.setattr(made, "_closing", closing)
        made.reported("/tray", FEEDBACK)
        until(lambda: len(until_written) == written)
        made.close()
    assert until_written[-1] == expected[:-1], "the last rest comes after the last item"


class SlowEnd(io.BufferedWriter):
    """A file that takes until an instant to be closed."""

    closes_at_s = 0.0

    def close(self) -> None:
        while time.monotonic() < self.closes_at_s:
            pass
        super().close()


def test_a_file_that_is_closed_is_flushed_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pace, "FLUSH_S", 0.05)
    is_written, path = threading.Event(), tmp_path / "run.mcap"
    stream = SlowEnd(io.FileIO(path, "xb"))

    def clean(value: Any) -> Any:
        is_written.set()
        return value

    made = Recording(RecordingFile(path, stream), mission=LAMP, about={}, now=lambda: 0.0, clean=clean)
    made.reported("/tray", FEEDBACK)
    assert is_written.wait(PATIENCE_S)
    stream.closes_at_s = time.monotonic() + 0.1  # the flush is due meanwhile
    assert made.close().why == ""


def test_a_picture_that_takes_long_holds_up_no_one_and_what_is_dropped_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made, rendered = recording(tmp_path / "run.mcap"), threading.Event()

    def render() -> bytes:
        assert rendered.wait(PATIENCE_S)
        return bytes(12)

    for number in range(50):
        made.received(Message("/camera", {"data": Image(f"c@{number}", 2, 2, "rgb8", render)}, 0.0), "")
    rendered.set()
    summary = made.close()
    count = len(kept(tmp_path / "run.mcap").messages["/camera"])
    assert count >= rooms.MOST["picture"] and summary.dropped == {"/camera": 50 - count}
    assert f"/camera {50 - count}" in caplog.text and f"{50 - count} dropped" in str(summary)


def test_pictures_that_were_written_on_the_blackboard_do_not_wait_with_their_bytes(tmp_path: Path) -> None:
    made, rendered = recording(tmp_path / "run.mcap"), threading.Event()
    made.received(
        Message(
            "/camera", {"data": Image("c", 1, 1, "rgb8", lambda: b"abc" if rendered.wait(PATIENCE_S) else b"")}, 0.0
        ),
        "",
    )
    held = list[weakref.ref[Any]]()
    for number in range(100):

        def render() -> bytes:
            return bytes(3_000_000)

        held.append(weakref.ref(render))
        image = Image(f"c@{number}", 1000, 1000, "rgb8", render)
        made.step(Step(number + 1, 0.0, Event("camera", 0.0), writes=(("camera", image),)))
    del image, render
    assert not [each for each in held if each() is not None]
    rendered.set()
    assert made.close().dropped == {}
    written = kept(tmp_path / "run.mcap").messages["/rai_missions/blackboard"]
    assert written[99]["value"] == {"picture": "c@99", "width": 1000, "height": 1000, "encoding": "rgb8"}


def test_rows_for_which_there_was_no_room_are_read_from_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(rooms.MOST, "row", 3)
    made, held = recording(tmp_path / "run.mcap"), threading.Event()
    made.received(
        Message("/camera", {"data": Image("c", 1, 1, "rgb8", lambda: b"abc" if held.wait(PATIENCE_S) else b"")}, 0.0),
        "",
    )
    journal = journaled(tmp_path, made, 20)
    held.set()
    made.close(journal.path)
    assert made.summary is not None and made.summary.dropped == {}
    with journal_of(tmp_path / "run.mcap") as replayed:
        rows = raw_rows_of(replayed.path)
        assert rows == raw_rows_of(tmp_path / "run.journal") and len(rows) == 21


def test_a_message_that_cannot_be_written_is_counted_and_the_others_are_kept(tmp_path: Path) -> None:
    made = recording(tmp_path / "run.mcap")

    def broken() -> bytes:
        raise ValueError("no picture today")

    made.received(Message("/camera", {"data": Image("c", 1, 1, "rgb8", broken)}, 0.0), "")
    made.received(Message("/battery", {"percentage": 0.5}, 0.0), "")
    assert made.close().dropped == {"/camera": 1}
    assert made.close().messages == 1, "closing twice changes nothing"
    assert list(kept(tmp_path / "run.mcap").messages) == ["/battery"]


WRITER = """
import sys, time
from pathlib import Path
from rai_missions.event import Event
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.recording import Recording
from rai_missions.engine.step import Step
from tests.recording.kept import LAMP
folder = Path(sys.argv[1])
made = Recording.create(folder / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0)
journal = Journal.create(folder / "run.journal", Header(dump(LAMP)), witness=made.rows)
for seq in range(1, 1_000_000):
    journal.write(Step(seq, float(seq), Event("anomaly", float(seq), {"text": "x" * 300})), since=0.0)
    time.sleep(0.001)
"""


def test_what_was_flushed_is_read_when_the_process_was_killed(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], cwd=Path(__file__).parents[2]) as process:
        try:
            until(lambda: path.exists() and path.stat().st_size > 10_000)
        finally:
            process.send_signal(signal.SIGKILL)
    with journal_of(path) as replayed, read(replayed.path) as record:
        rows = list(record.raw())
        assert len(rows) > 10 and rows == raw_rows_of(tmp_path / "run.journal")[: len(rows)]
        assert f"{path} is cut off" in replayed.warning and f"up to row {len(rows) - 1}" in replayed.warning
