# SPDX-License-Identifier: Apache-2.0
"""The live page of a run, while it lasts."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.cli.command import PAGE_PORT
from rai_missions.cli.run.find_page import left_tokens, run_file
from rai_missions.cli.run.open_page import open_page
from rai_missions.errors import UsageError
from rai_missions.runtime.readings import named_sources
from rai_missions.runtime.run_options import RunObserver

if TYPE_CHECKING:
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.agents.talk.doors import TalkLine, TextDoor
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.cli.run.talk_session import TalkSession
    from rai_missions.engine.activities.goal_ledger import OpenGoal
    from rai_missions.engine.decision import Question
    from rai_missions.engine.step import Step
    from rai_missions.mission.mission import Mission
    from rai_missions.node.closed_options import ClosedOptions
    from rai_missions.node.run_session import RunSession
    from rai_missions.node.web_operator import WebOrders
    from rai_missions.runtime.lifecycle import Status
    from rai_missions.runtime.result import Result
    from rai_missions.runtime.runner import Runner
    from rai_missions.runtime.view import RunView
    from visualize.live import LivePage, RunFeed, RunScene

__all__ = ("RunPage", "normalise_watch_args", "page_of")


def normalise_watch_args(options: RunOptions) -> RunOptions:
    """The options, where `run --watch mission.json` means the mission, not a port.

    Raises:
        UsageError: The options contradict each other.
    """
    if options.watch is not None and not options.watch.isdigit():
        if options.mission or options.resume:
            raise UsageError(
                f"--watch {options.watch}: give a port, a number from 1 to 65535, or 0 for any that is free"
            )
        options = options._replace(mission=options.watch, watch=PAGE_PORT)
    if options.watch is None and (options.host or options.tls_cert or options.tls_key):
        raise UsageError("--host, --tls-cert and --tls-key are of the live page; give --watch, too")
    if options.watch is not None and options.managed:
        raise UsageError("--watch is of one run; a managed node has many: drop it or --managed")
    return options


@contextmanager
def page_of(options: RunOptions, config: RunConfig) -> Iterator[RunPage | None]:
    """Serve a page of a run while it lasts, if the options ask for one."""
    if options.watch is None:
        yield None
        return
    page = open_page(
        options.watch,
        host=options.host,
        tls_cert=options.tls_cert,
        tls_key=options.tls_key,
        tokens=left_tokens(config.resume),
    )
    try:
        yield RunPage(page, config, operator=not options.no_operator)
    finally:
        page.stop()


class ShownRun(NamedTuple):
    """A run as a page shows it, from the page's thread."""

    session: RunSession
    closed: ClosedOptions
    orders: WebOrders
    """Carries orders to it."""
    where: str
    """Which it is, and its journal, in words."""

    @property
    def view(self) -> RunView:
        return self.session.runner.view

    def now(self) -> float:
        """Seconds on the run's clock."""
        return self.view.now()

    def loose_goals(self) -> Sequence[OpenGoal]:
        """The goals that may still move the robot although nothing waits for them."""
        return self.view.loose_goals

    def awaited_facts(self) -> str:
        """The robot's keys that the run waits for, to start or to continue, with their topics; empty for none."""
        return named_sources({key: self.view.source(key) for key in self.view.unreported})

    def questions(self) -> list[Question]:
        """The questions that are open."""
        return [each.question for each in self.session.questions()]

    def closed_options(self) -> Mapping[int, Mapping[str, str]]:
        """Question → option → why it would be refused now."""
        return self.closed.now(self.questions(), self.view, self.now(), self.view.still_since)

    def look(self) -> RunScene:
        """How the run is; read while it continues, so the number of the step that was reported last is read first."""
        from visualize.live import RunScene

        seq, mode, view = self.session.seq, self.session.mode, self.view
        at, paused_at = self.now(), view.paused_at
        is_paused = mode == "paused"
        return RunScene(
            seq=seq,
            at=at,
            mode=mode,
            control=view.holder,
            active=set(view.active),
            board={key: (entry.value, entry.at) for key, entry in view.board.items()},
            keys=view.mission.blackboard,
            questions={each.number: each for each in self.questions()},
            outcome=view.outcome or "",
            why=view.why if view.outcome else "",
            run=self.session.runner.run_id,
            where=self.where,
            held_by=view.held_by,
            held_since=view.held_since,
            paused_at=(at if paused_at is None else paused_at) if is_paused else None,
            paused_by=view.resumed_mode_by if is_paused and paused_at is not None else "",
        )


class RunPage:
    """A run and its page; where several follow each other, the page shows the last that was begun.

    Args:
        page: Where it is shown.
        config: What the run is made of.
        operator: Whether the page may answer as the operator.
    """

    def __init__(self, page: LivePage, config: RunConfig, *, operator: bool = True) -> None:
        self._page, self._operator = page, operator
        self._shown: ShownRun | None = None
        self._feed: RunFeed | None = None
        self._early: list[TalkLine] = []
        """What was talked before the page was served."""
        self.config = config.observed_by(RunObserver(self._follow_step, self._follow_status))
        """What the run is to be made of instead."""
        self._talk: TalkSession | None = None
        if operator:
            from rai_missions.node.web_operator import WebOperator

            here = WebOperator(config.operator, lambda: page.operators > 0)
            self.config = replace(self.config, operator=here)

    def talk_door(self) -> TextDoor:
        """The door of a conversation on this page; it is open while someone looks on."""
        from rai_missions.agents.talk.doors import TextDoor

        return TextDoor("page", self._show, lambda: self._page.viewers > 0)

    def join(self, session: TalkSession) -> None:
        """Take part in the conversation that is open now."""
        self._talk = session

    def _show(self, line: TalkLine) -> None:
        if self._feed is None:
            self._early.append(line)
        else:
            self._feed.talk(line._asdict())

    def run(self, prepared: PreparedRun, run: Callable[[Runner], Result]) -> Result:
        """Run it by `run`, with the page next to it; a later run takes the page over from the one before."""
        from rai_missions.node.closed_options import ClosedOptions
        from rai_missions.node.run_session import RunSession
        from rai_missions.node.web_operator import WebOrders

        runner, journal = prepared.runner, prepared.journal
        session = RunSession(runner, prepared.robot)
        path = str(journal.path) if journal is not None else ""
        about = {"run": runner.run_id, "journal": path, "answers": self._operator}
        shown = ShownRun(
            session,
            ClosedOptions(prepared.mission),
            WebOrders(session, answers=self._operator, note=runner.note, on_late_stop=self._stop_late),
            f"run {runner.run_id} · {path}",
        )
        self._shown, is_first = shown, self._shown is None
        if is_first:
            self._start(prepared.mission, about)
        elif self._feed is not None:
            self._feed.renew()
        with run_file(
            path,
            {**about, "url": self._page.url, "viewer_url": self._page.viewer_url, "mission": prepared.mission.name},
        ):
            return session.run(lambda: run(runner))

    def submit(self, text: str, on_reply: Callable[[bool, str], None]) -> None:
        """Carry a page's order to the run that it shows."""
        self._current.orders.submit(text, on_reply)

    def _stop_late(self, by: str) -> None:
        if self._talk is not None:
            self._talk.kill(by)

    def _start(self, mission: Mission, about: dict[str, Any]) -> None:
        """Serve the page from now on."""
        from visualize.live import RunFeed

        talk = self._talk
        self._feed = RunFeed(lambda: self._current)
        on_viewers = talk.doors_changed if talk is not None else lambda: None
        for line in (*(talk.earlier if talk is not None else ()), *self._early):
            self._feed.talk(line._asdict())
        self._page.start(mission, self._feed, self, about, talk, on_viewers)
        print(f"watch: {self._page.url}", file=sys.stderr, flush=True)
        print(f"watch, for viewers: {self._page.viewer_url}", file=sys.stderr, flush=True)

    @property
    def _current(self) -> ShownRun:
        """The run that is shown; a page is served once there is one."""
        assert self._shown is not None
        return self._shown

    def _follow_step(self, step: Step) -> None:
        shown, feed = self._shown, self._feed
        if shown is not None and feed is not None:
            shown.session.step(step)
            feed.step(step)
            shown.session.receive(step)

    def _follow_status(self, status: Status) -> None:
        if self._shown is not None:
            self._shown.session.follow(status)
        if self._feed is not None and status.unreported:
            self._feed.look_again()
