# SPDX-License-Identifier: Apache-2.0
"""The process of a local pool that does a campaign's tasks, one after the other, and sends back each record at once.

Rule: a thread of its own takes orders, so that the order to stop is heeded while a model thinks.
"""

from __future__ import annotations

import base64
import os
import queue
import sys
import threading
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

from rai_missions.campaign.cells import Cell
from rai_missions.campaign.records import (
    CellRecord,
    LabelRecord,
    PictureRecord,
    QuestionRecord,
    SceneRecord,
    UnlabelledScene,
)
from rai_missions.connectors.process.frames import read_frame, write_frame
from rai_missions.errors import raised_text

if TYPE_CHECKING:
    from rai_missions.campaign.tasks import TaskRecord

__all__ = ("RECORDS", "record_words", "task_in", "task_words", "work")

RECORDS = {each.__name__: each for each in (CellRecord, LabelRecord, PictureRecord, QuestionRecord, UnlabelledScene)}
PIECE = 192 * 1024
"""Bytes of a picture in one message: a reply has a bound."""


def work(request_fd: int, reply_fd: int) -> None:
    """Do tasks until there are no more orders."""
    first = read_frame(request_fd)
    if first is None:
        return
    os.environ.update(first[0]["environment"])
    os.environ.setdefault("LP_NUM_THREADS", "1")  # one core a worker, also where pictures are rendered by the processor
    sys.path[:] = first[0]["path"]
    from rai_missions.redaction import Redaction

    _hidden = Redaction(first[0]["secrets"])  # hides what is secret for as long as it lives
    orders: queue.SimpleQueue[Mapping[str, Any] | None] = queue.SimpleQueue()
    is_over = threading.Event()
    given = (request_fd, orders, is_over)
    threading.Thread(target=_take_orders, args=given, name="orders", daemon=True).start()
    _do_tasks(first[0]["settings"], orders, is_over, reply_fd)


def _take_orders(
    request_fd: int, orders: queue.SimpleQueue[Mapping[str, Any] | None], is_over: threading.Event
) -> None:
    while (order := read_frame(request_fd)) is not None:
        if order[0]["do"] == "stop":
            is_over.set()
        else:
            orders.put(order[0])
    is_over.set()
    orders.put(None)


def _do_tasks(
    settings: list[Any], orders: queue.SimpleQueue[Mapping[str, Any] | None], is_over: threading.Event, reply_fd: int
) -> None:
    from rai_missions.campaign.tasks import Workplace, WorkSettings
    from rai_missions.errors import MissionError
    from rai_missions.redaction import cut

    try:
        with Workplace(WorkSettings(settings[0], tuple(settings[1]), *settings[2:]), is_over) as place:
            write_frame(reply_fd, {"ready": os.getpid()})
            while (order := orders.get()) is not None:
                for message in chain.from_iterable(map(record_words, place.work(task_in(order["task"])))):
                    write_frame(reply_fd, message)
                write_frame(reply_fd, {"done": order["number"]})
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is reported, and the campaign ends with it
        what = str(error) if isinstance(error, MissionError) else raised_text(error)
        write_frame(reply_fd, {"fault": cut(what, 2000)})


def record_words(record: TaskRecord) -> Iterator[dict[str, Any]]:
    """A record as messages of JSON; a picture in pieces, of which the last is marked."""
    kind = type(record).__name__
    if not isinstance(record, PictureRecord):
        yield {"record": kind, "of": list(record)}
        return
    for at in range(0, max(1, len(record.png)), PIECE):
        piece = base64.b64encode(record.png[at : at + PIECE]).decode()
        yield {"record": kind, "of": [record.scene, record.name, piece], "is_last": at + PIECE >= len(record.png)}


def task_words(task: Any) -> list[Any]:
    """A task as JSON."""
    return [list(task.scene), [[key, *cell] for key, cell in task.cells], dict(task.labels), task.shows, task.rates]


def task_in(words: list[Any]) -> Any:
    """The task that `task_words` wrote."""
    from rai_missions.campaign.tasks import SceneTask

    scene, cells, labels, *wants = words
    return SceneTask(SceneRecord(*scene), tuple((key, Cell(*cell)) for key, *cell in cells), labels, *wants)
