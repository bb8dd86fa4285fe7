# SPDX-License-Identifier: Apache-2.0
"""The node of `rai-missions run`: one that serves a run (`--node`), or one that runs the mission (`--managed`)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rai_missions.agents.run_claims import claiming
from rai_missions.errors import UsageError
from rai_missions.mission.garbage import set_apart
from rai_missions.runtime.interrupts import on_interrupts

if TYPE_CHECKING:
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.node.run_session import RunSession
    from rai_missions.runtime.result import Result
    from rai_missions.runtime.runner import Runner

__all__ = ("NodeRun", "claiming_without_node", "reject_single_run_options", "serve_managed", "serve_node")


class NodeRun(NamedTuple):
    """A run that a node may serve."""

    config: RunConfig
    run: Callable[[Runner], Result]


def _wants_node(options: RunOptions) -> bool:
    """A node is asked for, by name or by its arguments."""
    return options.node is not None or options.managed or bool(options.ros_args)


@contextmanager
def serve_node(options: RunOptions, config: RunConfig) -> Iterator[NodeRun]:
    """Serve a run on a node while it lasts, if the options ask for a node."""
    if not _wants_node(options):
        yield NodeRun(config, lambda runner: runner.run())
        return
    from rai_missions.node import MissionNode

    node = MissionNode(
        config, options.node or "", managed=False, ros_arguments=options.ros_args, operator=not options.no_operator
    )
    node.run()
    print(f"node: {node.name.path}", file=sys.stderr)
    try:
        yield NodeRun(node.joined(config), lambda runner: node.attend(runner).run())
    finally:
        node.conclude()
        node.stop()


def claiming_without_node(options: RunOptions, prepared: PreparedRun, instance: str) -> AbstractContextManager[None]:
    """Have a run without a node report what it commands, and warn of others that command it too, while it lasts.

    Args:
        options: The options of the command.
        prepared: The run.
        instance: The instance of this program.
    """
    if _wants_node(options):
        return nullcontext()  # a node does so itself
    return claiming(prepared.runner, prepared.robot, prepared.connector, instance)


def reject_single_run_options(options: RunOptions) -> None:
    """Refuse what a managed node, which has many runs, cannot do.

    Raises:
        UsageError: An option is given that is about one run.
    """
    for word in ("picture", "resume", "migrate", "record", "json", "talk"):
        if getattr(options, word, None):
            raise UsageError(f"--{word} is of one run; a managed node has many: drop it or --managed")


def serve_managed(options: RunOptions, config: RunConfig, journals: Callable[[], Path]) -> int:
    """Serve the mission until the node is shut down."""
    from rai_missions.node import MissionNode

    node = MissionNode(
        config,
        options.node or "",
        ros_arguments=options.ros_args,
        operator=not options.no_operator,
        journals=journals,
        ended=_report,
    )
    with on_interrupts(lambda _: node.shut_down(), lambda _: node.shut_down(at_once=True), "shutting down"):
        node.run()
        try:
            print(f"node: {node.name.path} waits to be configured and activated", file=sys.stderr, flush=True)
            with set_apart():
                node.wait()
        finally:
            node.stop()
    return 0


def _report(session: RunSession) -> None:
    result, run = session.result, session.runner.run_id
    if result is None:
        print(f"run {run}: broke off: {session.error}", flush=True)
    else:
        print(f"run {run}: {result.outcome}: {result.why} · journal: {result.journal}", flush=True)
