# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --watch`: the live page beside a run, and the file by which `rai-missions watch` finds it."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.errors import UsageError

if TYPE_CHECKING:
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.engine.decision import Question
    from rai_missions.engine.step import Step
    from rai_missions.node.run_session import RunSession
    from rai_missions.runtime.lifecycle import Status
    from rai_missions.runtime.runner import Result, Runner
    from visualize.live import LivePage, PageAddress, RunFeed, RunScene

__all__ = ("Watch", "opened", "place_of", "run_file", "sort_out", "watched")

LACKS = "the live page needs Starlette and uvicorn: pip install '.[watch]'"


def sort_out(given: argparse.Namespace) -> None:
    """`run --watch mission.json` means the mission, not a port.

    Raises:
        UsageError: Words that do not go together.
    """
    if given.watch is not None and not given.watch.isdigit():
        if given.mission or given.resume:
            raise UsageError(f"--watch {given.watch}: give a port, a number from 1 to 65535, or 0 for any that is free")
        given.mission, given.watch = given.watch, str(_default_port())
    if given.watch is None and (given.host or given.tls_cert or given.tls_key):
        raise UsageError("--host, --tls-cert and --tls-key say where the live page is served; give --watch, too")
    if given.watch is not None and given.managed:
        raise UsageError("--watch is of one run; a managed node has many: drop it or --managed")


def place_of(given: argparse.Namespace, port: str | int) -> PageAddress:
    """Where the page is to be served, by the words of the command line."""
    _door()
    from visualize.live import PageAddress

    return PageAddress(given.host or "127.0.0.1", int(port), given.tls_cert or "", given.tls_key or "")


def opened(place: PageAddress) -> LivePage:
    """An address for the page; nothing is shown there yet.

    Raises:
        UsageError: It is in use, or unprotected, or there is no server on this machine.
    """
    _door()
    from visualize.live import LivePage

    return LivePage(place)


@contextmanager
def watched(given: argparse.Namespace, setting: RunConfig) -> Iterator[Watch | None]:
    """The page that the command line asks for, for as long as the run lasts; nothing where it asks for none."""
    if given.watch is None:
        yield None
        return
    page = opened(place_of(given, given.watch))
    try:
        yield Watch(page, setting, operator=not given.no_operator)
    finally:
        page.stop()


class Watch:
    """A run and its page.

    Args:
        page: Where it is shown.
        setting: What the run is made of.
        operator: Whether the page may answer as the operator.
    """

    def __init__(self, page: LivePage, setting: RunConfig, *, operator: bool = True) -> None:
        self._page, self._operator = page, operator
        self._course: RunSession | None = None
        self._feed: RunFeed | None = None
        self._step, self._status = setting.on_step, setting.on_status
        self.setting = replace(setting, on_step=self._stepped, on_status=self._changed)
        """What the run is to be made of instead."""
        if operator:
            from rai_missions.node.web_operator import PageOperator

            here = PageOperator(setting.operator, lambda: page.viewers > 0)
            self.setting = replace(self.setting, operator=here)

    def run(self, prepared: PreparedRun, run: Callable[[Runner], Result]) -> Result:
        """Run it by `run`, with the page beside it."""
        from rai_missions.node.closed_options import Closed
        from rai_missions.node.run_session import RunSession
        from rai_missions.node.web_operator import PageDesk
        from visualize.live import RunFeed

        runner, journal = prepared.runner, prepared.journal
        self._course = RunSession(runner, prepared.robot)
        desk = PageDesk(self._course, answers=self._operator, note=runner.note)
        closed = Closed(prepared.mission)
        self._feed = RunFeed(
            self._look, runner.clock.now, lambda: closed.now(self._asked(), runner.chart, runner.clock.now()),
            lambda: runner.chart.loose_goals,
        )  # fmt: skip
        path = str(journal.path) if journal is not None else ""
        about = {"run": runner.run_id, "journal": path, "answers": self._operator}
        self._page.start(prepared.mission, self._feed, desk, about)
        print(f"watch: {self._page.url}", file=sys.stderr, flush=True)
        with run_file(path, {**about, "url": self._page.url, "mission": prepared.mission.name}):
            return self._course.run(lambda: run(runner))

    def _look(self) -> RunScene:
        """How the run stands; read while it goes on, so the step's number is read first."""
        from visualize.live import RunScene

        course = self._course
        assert course is not None
        chart = course.runner.chart
        seq, mode = chart.seq, course.mode
        questions = self._asked()
        board = {key: (entry.value, entry.at) for key, entry in dict(chart.view.board).items()}
        scene = RunScene(
            seq=seq, at=course.runner.clock.now(), mode=mode, control=chart.holder, active=chart.active, board=board,
            questions=questions, outcome=chart.outcome or "", why=chart.why if chart.outcome else "",
        )  # fmt: skip
        if mode == "paused" and chart.paused_at is not None:
            scene.paused_at = chart.paused_at
        scene.held_by, scene.held_since = chart.held_by, chart.held_since
        return scene

    def _asked(self) -> list[Question]:
        return [each.question for each in self._course.questions()] if self._course is not None else []

    def _stepped(self, step: Step) -> None:
        course, feed = self._course, self._feed
        if course is not None and feed is not None:
            course.step(step)
            feed.step(step)
            course.receive(step)
        if self._step is not None:
            self._step(step)

    def _changed(self, status: Status) -> None:
        if self._course is not None:
            self._course.follow(status)
        if self._status is not None:
            self._status(status)


@contextmanager
def run_file(journal: str, what: dict[str, Any]) -> Iterator[None]:
    """Beside a run's journal, while it lasts, where its page is; nobody else on the machine may read it."""
    if not journal:
        yield
        return
    path = Path(f"{journal}.watch")
    with suppress(FileNotFoundError):
        path.unlink()
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        json.dump({**what, "pid": os.getpid()}, file)
    try:
        yield
    finally:
        with suppress(FileNotFoundError):
            path.unlink()


def _default_port() -> int:
    _door()
    from visualize.live.server import PORT

    return PORT


def _door() -> None:
    from importlib.util import find_spec

    if find_spec("starlette") is None or find_spec("uvicorn") is None:
        raise UsageError(LACKS)
