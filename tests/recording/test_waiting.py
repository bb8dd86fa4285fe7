# SPDX-License-Identifier: Apache-2.0
"""What waits to be recorded: in which order it is taken, who is woken, and what it takes of memory."""

from __future__ import annotations

import datetime
import gc
import math
import resource
import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Reply
from rai_missions.image import Image
from rai_missions.plain_data import plain
from rai_missions.recording import queue as rooms
from rai_missions.recording.queue import MOST, Kind, QueuedItem, RecordingQueue, Route, packed, unpacked
from tests.recording.kept import kept, recording

PATIENCE_S = 30.0
ROUTES = tuple(Route(kind, print) for kind in MOST)


class Name(str):
    __slots__ = ()


@given(st.lists(st.tuples(st.integers(0, len(ROUTES) - 1), st.integers(0, 3)), max_size=40))
def test_what_waits_is_taken_in_the_order_in_which_it_came_whatever_its_kind(puts: list[tuple[int, int]]) -> None:
    queue, items = RecordingQueue(ROUTES), list[QueuedItem]()
    for number, (route, size) in enumerate(puts):
        items.append((route, size, number, 0.0, "/a", None))
        queue.put(items[-1])
    room = {kind: sum(ROUTES[item[0]].kind == kind for item in items) <= MOST[kind] for kind in MOST}
    if all(room.values()):
        assert queue.waiting == len(items)
        assert [queue.take() for _ in items] == items and queue.take() is None


def test_nothing_is_lost_or_left_unnoticed_where_threads_put_while_another_takes() -> None:
    queue, woken, taken = RecordingQueue(ROUTES), threading.Semaphore(0), dict[int, list[int]]()
    count, threads = 3_000, 4

    def put(thread: int) -> None:
        for number in range(count):
            if queue.put((0, number % 2, number, float(thread), "/a", None)):
                woken.release()

    def take() -> None:
        while sum(map(len, taken.values())) < count * threads and woken.acquire(timeout=PATIENCE_S):
            while (item := queue.take()) is not None:
                taken.setdefault(int(item[3]), []).append(item[2])

    workers = [threading.Thread(target=put, args=(each,)) for each in range(threads)] + [threading.Thread(target=take)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(PATIENCE_S)
    assert taken == {thread: list(range(count)) for thread in range(threads)} and not queue.dropped


class ComesLate(RecordingQueue):
    """A queue into which an item comes in the instant in which its thread falls asleep."""

    late: QueuedItem | None = None

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "_is_asleep" and value and self.late is not None:
            late, self.late = self.late, None
            assert not self.put(late), "the thread is awake, and no one wakes it"
        super().__setattr__(name, value)


def test_what_comes_while_the_thread_falls_asleep_is_taken() -> None:
    queue, first, late = ComesLate(ROUTES), (0, 0, 1, 0.0, "/a", None), (0, 0, 2, 0.0, "/a", None)
    assert queue.put(first) and queue.take() == first
    queue.late = late
    assert queue.take() == late and queue.take() is None
    assert queue.put(first), "it sleeps now"


@pytest.mark.parametrize(
    "value",
    [math.nan, math.inf, None, "null", 10**30, {1: 2}, OrderedDict(a=1), Name("a"), b"a", "\ud800",
     datetime.date(2026, 1, 1), Reply("failed", {}), float, {"deep": [{"x": math.nan}]}],
)  # fmt: skip
def test_what_json_would_alter_is_packed_as_it_is(value: Any) -> None:
    (found,) = unpacked(packed((value,)))
    assert repr(found) == repr(value) and type(found) is type(value)


@given(st.recursive(st.floats() | st.text() | st.integers(), lambda each: st.lists(each) | st.tuples(each, each)))
def test_what_waits_is_recorded_as_it_would_have_been_at_once(value: Any) -> None:
    (found,) = unpacked(packed((value,)))
    assert repr(plain(found)) == repr(plain(value))


def test_a_picture_waits_with_no_copy_of_its_bytes() -> None:
    image = Image("c", 1, 1, "rgb8", b"abc")
    values = ("/look", {}, 0.1, "succeeded", {"image": image}, "")
    assert packed(values) is values


def test_what_a_server_changes_afterwards_is_recorded_as_it_was(tmp_path: Any) -> None:
    made, request, data = recording(tmp_path / "run.mcap"), {"near": [1]}, {"found": ["a"]}
    made.called("/look", request, Reply("succeeded", data), 0.1)
    request["near"].append(2)
    data["found"].append("b")
    made.close()
    (message,) = kept(tmp_path / "run.mcap").messages["/rai_missions/calls"]
    assert message["request"] == '{"near": [1]}' and message["data"] == {"found": ["a"]}


def pages_of(values: list[Mapping[str, Any]]) -> float:
    """How many pages of memory each of these takes that waits, on average."""
    waiting = [packed(("/horn", {}, 0.0, "succeeded", value, "")) for value in values]  # so that room has been made
    before, waiting = resource.getrusage(resource.RUSAGE_THREAD).ru_minflt, []
    for value in values:
        waiting.append(packed(("/horn", {}, 0.0, "succeeded", value, "")))
    return (resource.getrusage(resource.RUSAGE_THREAD).ru_minflt - before) / len(waiting)


def test_what_waits_takes_no_page_of_memory_of_its_own() -> None:
    assert pages_of([{"success": True, "message": str(number)} for number in range(20_000)]) < 0.25


@pytest.mark.parametrize("kind", ["raw", "row", "picture"])
def test_room_in_bytes_is_given_back(monkeypatch: pytest.MonkeyPatch, kind: Kind) -> None:
    monkeypatch.setitem(rooms.MOST_BYTES, kind, 10)
    queue, item = RecordingQueue((Route(kind, print),)), (0, 4, 0, 0.0, "/a", None)
    for _ in range(5):
        assert [queue.put(item), queue.put(item), queue.put(item)] == [True, False, False]
        assert [queue.take() for _ in range(3)] == [item, item, None]
    assert queue.dropped == {"/a": 5}


def test_no_search_for_garbage_looks_at_what_waits() -> None:
    queue, text = RecordingQueue(ROUTES), packed(("/horn", {}, 0.1, "succeeded", {"success": True, "message": ""}, ""))
    gc.disable()
    try:
        before = len(gc.get_objects())
        for number in range(1_000):
            queue.put((0, 0, number, 0.5, "/calls", text))
        assert queue.waiting == 1_000 and len(gc.get_objects()) - before < 100
    finally:
        gc.enable()
