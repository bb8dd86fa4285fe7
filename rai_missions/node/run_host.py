# SPDX-License-Identifier: Apache-2.0
"""Runs on a node: over its connector, reported by it, answered through it; begun by an order, or by someone else."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rai_missions.agents.mission import PreparedRun, RunConfig, prepare
from rai_missions.check import load_whole
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.mission.mission import Mission
from rai_missions.node.launched import arguments_of
from rai_missions.node.order import ClientOrder
from rai_missions.node.prerequisites import Clients, about, readied
from rai_missions.node.run_session import RunSession
from rai_missions.node.transport import Carrier
from rai_missions.profile import Robot
from rai_missions.redaction import logger
from rai_missions.runtime.clock import Clock, PublishedClock, WallClock
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner

__all__ = ("RunHost",)

log = logger(__name__)


class RunHost:
    """Where the runs of a node live.

    Args:
        setting: What a run is made of.
        robot: The profile as it is known before the node is configured; None where there is none.
        journals: Names a fresh journal for each run; else there is only the setting's.
        operator: Clients answer as the operator, where the setting names no one.
    """

    def __init__(
        self, setting: RunConfig, *, robot: Robot | None, journals: Callable[[], Path] | None, operator: bool
    ) -> None:
        self.setting, self.robot, self._journals, self._is_operator = setting, robot, journals, operator
        is_simulated = robot is not None and robot.connector.get("sim_time") is True
        self.published_clock = PublishedClock() if is_simulated else None
        """The time of a simulation, where the robot lives by it."""
        self._clock: Clock = self.published_clock or WallClock()
        self._threads: list[threading.Thread] = []
        self.called, self.about = about(setting.mission)
        """What the mission's node is called, and the mission's name and version as far as they are known."""
        self.mission: Mission | None = None
        """As it was read last; the setting's until then."""
        self.session: RunSession | None = None
        """The run that was begun last."""
        self._parameters: Mapping[str, Any] = {}

    def take_parameters(self, parameters: Mapping[str, Any]) -> None:
        """Take what the node was started with; each is an argument of the mission.

        Raises:
            UsageError: One is none; where the mission cannot be read yet, `arguments` raises it later.
        """
        self._parameters = parameters
        if parameters and self.setting.resume is not None:
            names = ", ".join(sorted(parameters))
            raise UsageError(f"parameters ({names}) cannot be given with --resume: the run continues as it began")
        with suppress(DefinitionError):
            self.arguments()

    def arguments(self) -> dict[str, Any]:
        """The mission's arguments: those of the setting, and the node's parameters.

        Raises:
            UsageError: A parameter is no argument of the mission, or is given twice.
            DefinitionError: The mission is at fault.
        """
        given = self.setting.arguments
        if not self._parameters:
            return dict(given)
        mission = self.mission or self.setting.mission
        read = mission if isinstance(mission, Mission) or mission is None else load_whole(mission)
        return {**given, **(arguments_of(self._parameters, read, given) if read is not None else {})}

    def read(self) -> None:
        """Read the mission and the profile, and see whether the arguments fit.

        Raises:
            DefinitionError: The mission or the profile is at fault.
            UsageError: As `arguments`.
        """
        mission, self.robot = readied(self.setting)
        self.mission = mission
        self.arguments()
        self.about = mission.name, mission.version

    def attend(self, runner: Runner) -> RunSession:
        """Follow a run that is about to begin."""
        session = self.session = RunSession(runner, self.robot)
        return session

    def now(self) -> float:
        """Seconds on the clock of the run that is under way; one that resumes counts on from where it was cut short."""
        resumed = self.session if self.setting.resume is not None else None
        return self._clock.now() if resumed is None else resumed.runner.view.now()

    def joined(
        self, setting: RunConfig, carrier: Carrier, *, on_step: Callable[[Step], None], on_wait: Callable[[], None]
    ) -> RunConfig:
        """A setting whose run the node carries, reports and answers for.

        Args:
            setting: What the run is made of.
            carrier: The node's connector.
            on_step: Called with each step.
            on_wait: Called when what the run waits for of the robot has changed, which may be without a step.
        """
        if carrier.robots:
            self._clock = self.published_clock or WallClock()
            setting = replace(setting, connector=None, opened=carrier.connector, clock=self._clock)
        setting = replace(setting, arguments={**self.arguments(), **setting.arguments})
        if setting.operator is None and self._is_operator:
            setting = replace(setting, operator=Clients())

        def follow(now: Status) -> None:
            if self.session is not None:
                self.session.follow(now)  # what it changes is published with its step, which follows at once
            if now.unreported:
                on_wait()

        return setting.observed_by(RunObserver(on_step, follow))

    def begin(
        self, order: ClientOrder, join: Callable[[RunConfig], RunConfig], ended: Callable[[RunSession], None]
    ) -> RunSession:
        """Begin a run on a thread of its own.

        Args:
            order: Who wants it, with which arguments.
            join: Makes the setting one of the node's.
            ended: Called when it is over.

        Raises:
            MissionError: It cannot be begun.
        """
        mission, arguments = self.mission or self.setting.mission, {**self.arguments(), **order.arguments}
        journal = self._journals() if self._journals is not None else self.setting.journal
        prepared = prepare(join(replace(self.setting, mission=mission, arguments=arguments, journal=journal)))
        try:
            if prepared.journal is not None:
                prepared.journal.note(f"started by {order.by}")
        except BaseException:
            prepared.close()
            raise
        session = self.session = RunSession(prepared.runner, prepared.robot)
        thread = threading.Thread(target=_conduct, args=(prepared, session, ended), name="mission", daemon=True)
        self._threads = [each for each in self._threads if each.is_alive()] + [thread]
        thread.start()
        return session

    def join(self, within_s: float) -> None:
        """Wait for the runs to end."""
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(within_s)


def _conduct(prepared: PreparedRun, session: RunSession, ended: Callable[[RunSession], None]) -> None:
    try:
        session.run()
    except Exception:
        log.exception("the run breaks off")
    finally:
        prepared.close()
        ended(session)
