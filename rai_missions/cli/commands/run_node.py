# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --node`: a node beside a run, or, `--managed`, one that runs the mission when it is told to."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.cli.signals import on_signals
from rai_missions.errors import UsageError

if TYPE_CHECKING:
    from rai_missions.agents.mission import RunConfig
    from rai_missions.node import MissionNode
    from rai_missions.node.run_session import RunSession
    from rai_missions.runtime.runner import Result, Runner

__all__ = ("Stand", "beside", "managed", "refuse_words_of_one_run", "wants_node")


class Stand(NamedTuple):
    """A run, and what stands beside it."""

    setting: RunConfig
    run: Callable[[Runner], Result]


def wants_node(given: argparse.Namespace) -> bool:
    """A node is asked for; whoever gives a node's arguments wants one, too."""
    return given.node is not None or given.managed or bool(given.ros_args)


@contextmanager
def beside(given: argparse.Namespace, setting: RunConfig) -> Iterator[Stand]:
    """The node that the command line asks for, for as long as the run lasts; nothing where it asks for none."""
    if not wants_node(given):
        yield Stand(setting, lambda runner: runner.run())
        return
    from rai_missions.node import MissionNode

    node = MissionNode(
        setting, given.node or "", managed=False, ros_arguments=given.ros_args, operator=not given.no_operator
    )
    node.run()
    print(f"node: {node.name.path}", file=sys.stderr)
    try:
        yield Stand(node.joined(setting), lambda runner: node.attend(runner).run())
    finally:
        node.conclude()
        node.stop()


def refuse_words_of_one_run(given: argparse.Namespace) -> None:
    """A managed node has many runs.

    Raises:
        UsageError: A word is given that is of one run.
    """
    for word in ("picture", "resume", "migrate", "record", "json"):
        if getattr(given, word, None):
            raise UsageError(f"--{word} is of one run; a managed node has many: drop it or --managed")


def managed(given: argparse.Namespace, setting: RunConfig, journals: Callable[[], Path]) -> int:
    """Serve the mission until the node is shut down."""
    from rai_missions.node import MissionNode

    node = MissionNode(
        setting, given.node or "", ros_arguments=given.ros_args, operator=not given.no_operator, journals=journals,
        ended=_told,
    )  # fmt: skip
    with _interruptible(node):
        node.run()
        try:
            print(f"node: {node.name.path} waits to be configured and activated", file=sys.stderr, flush=True)
            node.wait()
        finally:
            node.stop()
    return 0


def _told(course: RunSession) -> None:
    result, run = course.result, course.runner.run_id
    if result is None:
        print(f"run {run}: broke off: {course.error}", flush=True)
    else:
        print(f"run {run}: {result.outcome}: {result.why} · journal: {result.journal}", flush=True)


@contextmanager
def _interruptible(node: MissionNode) -> Iterator[None]:
    """The first interrupt shuts the node down, which cancels what runs; the second is an emergency stop."""
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        pressed.append(number)
        if len(pressed) == 1:
            print("\nshutting down; once more for an emergency stop", file=sys.stderr)
        node.shut_down(at_once=len(pressed) > 1)

    with on_signals(interrupt):
        yield
