# SPDX-License-Identifier: Apache-2.0
"""A run as one call, and as an agent with a life: what is used where a program has nothing else to do with a run."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.agents.agent import AgentHealth
from rai_missions.agents.launch import PreparedRun, prepare, prepare_next
from rai_missions.agents.run_claims import claiming
from rai_missions.agents.run_config import RunConfig, given_config
from rai_missions.connectors.connector import Connector
from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.errors import UsageError, raised_text, suggestion
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.redaction import logger
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import RunObserver

if TYPE_CHECKING:
    from rai_missions.agents.conversation import ConversationalAgent

log = logger(__name__)

MOMENT_S = 3.0
"""For what is closed after a run."""

TALK_S = 7.0
"""For the report of the end where a person may be reached."""

__all__ = ("MissionAgent", "PreparedRun", "RunConfig", "prepare", "prepare_next", "run")


def run(mission: Mission | str | Path, robot: Robot | PythonRobot | str | Path | None = None, **options: Any) -> Result:
    """Run a mission to its end.

    Args:
        mission: A `Mission`, or the file of one.
        robot: A profile or a robot in Python, or the file of one: `.json`, or `.py`, which is executed.
        options: The other fields of `RunConfig`: `model="openai:gpt-4o"`, `journal="out/run.journal"`, …

    Raises:
        DefinitionError: The mission or the profile is at fault.
        UsageError: Something named is not there, an option is none of a run, or the mission has to receive facts and
            there is no robot.
    """
    known = [each.name for each in fields(RunConfig) if each.name not in ("mission", "robot")]
    for name in options:
        if name not in known:
            raise UsageError(f"run takes no '{name}'{suggestion(name, known)}")
    with prepare(RunConfig(mission, robot, **options)) as prepared:
        return _run(prepared)


def _run(prepared: PreparedRun) -> Result:
    """Run it, and report to other programs meanwhile what it commands."""
    with claiming(prepared.runner, prepared.robot, prepared.connector):
        return prepared.runner.run()


class MissionAgent:
    """The paper's Agent around a run: `run()` begins it on a thread of its own, `stop()` cancels it and waits.

    Args:
        config: The run.
        talk: Who talks with people about it; an agent of its own, which begins before this one and stops after it.
    """

    def __init__(self, config: RunConfig, *, talk: ConversationalAgent | None = None) -> None:
        config = given_config(config)
        self._config = config if talk is None else config.observed_by(RunObserver(talk.step, talk.changed))
        self._talk = talk
        self._closes = False
        """Whether the end of the run closes everything."""
        self._prepare()
        self._thread: threading.Thread | None = None
        self.result: Result | None = None
        """How it ended; None until then, and where it broke off."""
        self.error: Exception | None = None
        """Why it broke off, if it did."""

    def run(self) -> None:
        """Begin; returns at once. A run that has begun is not begun again."""
        if self._thread is None:
            if self._is_closed:
                self._prepare()
            self._thread = threading.Thread(target=self._work, name="mission")
            self._thread.start()

    def stop(self) -> None:
        """Cancel, and wait until everything has ended.

        Called by what follows the run (`on_step`, `on_status`), it returns at once: the run's end closes everything.
        """
        if self._thread is not None and self._thread.is_alive():
            self._prepared.runner.cancel("stop")
            if self._thread is threading.current_thread():
                self._closes = True
                return
            self._thread.join()
        self._close()

    def _close(self) -> None:
        self._prepared.close()
        self._is_closed = True

    @property
    def health(self) -> AgentHealth:
        """How the run fares; died, where it broke off. How a mission ended is no health of its agent."""
        if self.error is not None:
            return AgentHealth("died", raised_text(self.error))
        if self.result is not None:
            return AgentHealth("ended", self.result.outcome)
        view = self._prepared.runner.view
        values = {"mission": self._prepared.mission.name, "mode": view.mode, "control": view.holder}
        return AgentHealth("ready" if self._thread is None else "running", "", values)

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """The way to the robot, which the run itself opens and closes."""
        connector = self._prepared.connector
        return {} if connector is None else {"robot": connector}

    @property
    def stop_s(self) -> float:
        """As long as the mission may take to bring the robot to rest, and a moment."""
        return self._prepared.mission.cancel_s + MOMENT_S + (TALK_S if self._talk is not None else 0)

    def _prepare(self) -> None:
        self._prepared, self._is_closed = prepare(self._config), False
        if self._talk is not None:
            self._talk.attach(self._prepared.runner, self._prepared.journal)

    def _work(self) -> None:
        try:
            result = _run(self._prepared)
            if self._talk is not None and self._talk.is_reachable:
                self._talk.conclude()
            self.result = result
        except Exception as error:
            log.exception("the run broke off")
            self.error = error
        if self._closes:
            self._close()
