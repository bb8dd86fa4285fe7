# SPDX-License-Identifier: Apache-2.0
"""A run whose steps the tests make, the page that shows it, and viewers that speak HTTP as a browser does."""

from __future__ import annotations

import contextlib
import http.client
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.step import Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Lifecycle
from visualize.live import LivePage, PageAddress, RunFeed, RunScene

__all__ = ("PATIENCE_S", "Run", "Viewer", "ask", "folded", "until")

PATIENCE_S = 30.0


class Run:
    """A chart that receives events, and a feed that receives its steps.

    Args:
        mission: What runs.
        sink: Who takes orders.
        about: What the page shows of it in addition to its steps.
        place: Where the page is served.
    """

    def __init__(
        self,
        mission: Mission,
        sink: Any = None,
        about: Mapping[str, Any] | None = None,
        place: PageAddress | None = None,
    ) -> None:
        self.chart, self.life, self.steps = Chart(mission, ticker=CompiledTrees()), Lifecycle(), list[Step]()
        self.mode, self.control, self.run_id = "ready", "autonomy", ""
        self.closed: dict[int, dict[str, str]] = {}
        self.feed = RunFeed(lambda: self)
        self.mission, self.sink, self.about = mission, sink, dict[str, Any](about or {})
        self.place = place or PageAddress(port=0)

    def __enter__(self) -> Run:
        self.page = LivePage(self.place)
        self.page.start(self.mission, self.feed, self.sink, self.about)
        return self

    def __exit__(self, *_: object) -> None:
        self.page.stop()

    def look(self) -> RunScene:
        chart = self.chart
        seq = chart.seq
        board = {key: (entry.value, entry.at) for key, entry in dict(chart.view.board).items()}
        return RunScene(
            seq=seq,
            at=chart.at,
            mode=self.mode,
            control=chart.holder,
            active=set(chart.active),
            board=board,
            outcome=chart.outcome or "",
            why=chart.why if chart.outcome else "",
            run=self.run_id,
            questions={each.number: each for each in chart.questions},
        )

    def now(self) -> float:
        return self.chart.at

    def closed_options(self) -> Mapping[int, Mapping[str, str]]:
        return self.closed

    def loose_goals(self) -> Sequence[OpenGoal]:
        return ()

    def awaited_facts(self) -> str:
        return ", ".join(self.chart.unreported)

    def start(self) -> Step:
        return self._made(self.chart.start(at=self.chart.at))

    def send(self, name: str, kind: str = "event", number: int = 0, after_s: float = 1.0, **data: Any) -> Step:
        return self._made(self.chart.send(Event(name, self.chart.at + after_s, data, kind, number)))

    def write(self, key: str, value: Any) -> Step:
        return self.send(key, "write", value=value)

    def _made(self, step: Step) -> Step:
        self.steps.append(step)
        status = self.life.observe(step, self.chart)
        if status is not None:
            self.mode, self.control = status.mode, status.control
        self.feed.step(step)
        return step

    @property
    def whole(self) -> dict[str, Any]:
        """What every viewer has to end with."""
        board = {key: [entry.value, round(entry.at, 3)] for key, entry in self.chart.view.board.items()}
        return {"mode": self.mode, "control": self.chart.holder, "active": sorted(self.chart.active), "board": board}


def folded(seen: dict[str, Any], kind: str, data: Mapping[str, Any]) -> None:
    """What a browser makes of a message."""
    fields = {name: item for name, item in data.items() if name not in ("board", "steps", "talk", "now", "sent")}
    if kind == "state":
        seen.clear()
        seen.update(fields, board=dict(data["board"]), steps=list(data["steps"]), talk=list(data["talk"]))
    elif kind == "change":
        seen.update(fields)
        seen["board"].update(data.get("board", {}))
        seen["steps"] += data.get("steps", [])
        lines = {line["number"]: line for line in (*seen["talk"], *data.get("talk", []))}
        seen["talk"] = list(lines.values())


class Viewer:
    """One browser: it reads, can be cut off, and comes back where it was."""

    def __init__(self, page: LivePage, token: str = "") -> None:
        self.page, self.seen, self.last = page, dict[str, Any](), ""
        self.token = token or page.token
        self.kinds: list[str] = []
        self.sent = 0.0
        self.error = ""
        self._connection: http.client.HTTPConnection | None = None
        self._thread: threading.Thread | None = None
        self.come()

    def come(self) -> None:
        self._connection = http.client.HTTPConnection("127.0.0.1", self.page.port, timeout=PATIENCE_S)
        headers = {"X-Mission-Token": self.token, **({"Last-Event-ID": self.last} if self.last else {})}
        self._connection.request("GET", "/events", headers=headers)
        answer = self._connection.getresponse()
        assert answer.status == 200, answer.read()
        self._thread = threading.Thread(target=self._read, args=(answer,), daemon=True)
        self._thread.start()

    def cut(self) -> None:
        """The line is gone, whatever is on its way."""
        assert self._connection is not None and self._thread is not None
        with contextlib.suppress(OSError):
            if self._connection.sock is not None:
                self._connection.sock.shutdown(socket.SHUT_RDWR)
        self._thread.join(PATIENCE_S)
        self._connection.close()

    def sees(self, **fields: Any) -> bool:
        return all(self.seen.get(name) == value for name, value in fields.items())

    def _read(self, answer: http.client.HTTPResponse) -> None:
        try:
            for kind, number, data in messages(answer):
                folded(self.seen, kind, data)
                self.kinds.append(kind)
                self.sent = data["sent"]
                self.last = number or self.last
        except (OSError, ValueError, AttributeError, http.client.HTTPException) as error:
            self.error = str(error)
        finally:
            answer.close()


def messages(answer: http.client.HTTPResponse) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """The events of a stream: kind, id, data."""
    fields: dict[str, str] = {}
    while line := answer.readline():
        text = line.decode().rstrip("\n")
        if not text:
            yield fields["event"], fields.get("id", ""), json.loads(fields["data"])
            fields = {}
        else:
            name, _, value = text.partition(": ")
            fields[name] = value


def ask(page: LivePage, method: str, path: str, body: bytes | None = None, **headers: str) -> tuple[int, Any, Any]:
    """One request with the token, and with headers as given; an empty one is left out. Status, headers, body."""
    connection = http.client.HTTPConnection("127.0.0.1", page.port, timeout=PATIENCE_S)
    sent = {"X-Mission-Token": page.token, "Content-Type": "application/json"}
    sent |= {name.replace("_", "-"): value for name, value in headers.items()}
    try:
        connection.request(method, path, body, {name: value for name, value in sent.items() if value})
        answer = connection.getresponse()
        text = answer.read()
    finally:
        connection.close()
    is_json = answer.headers.get("Content-Type", "").startswith("application/json")
    return answer.status, answer.headers, json.loads(text) if is_json else text


def until(holds: Callable[[], object], what: str) -> None:
    """Wait for what another thread does."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, what
        threading.Event().wait(0.005)
