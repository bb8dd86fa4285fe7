# SPDX-License-Identifier: Apache-2.0
"""A play of `alike.py` whose run is killed and continues in another process, and whose robot may die meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Connector, Data
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.profile import dump_profile
from rai_missions.replay.open_run import open_run
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner
from tests.connectors.ros2.alike import COMMANDS, POSTED, WITHIN_S, Act, Count, Pair, Play, mission, profile
from tests.replay.mortal import Dead, Fate, Mortal, MortalClock

__all__ = ("Death", "MortalPlay", "Ways")


class Death(NamedTuple):
    """Right before or after a process does such a thing for the n-th time; it lives where that never comes."""

    what: str = "nothing"
    nth: int = 0
    is_done: bool = False


class Ways(NamedTuple):
    """How the ends of a way are made, one for each process, and killed."""

    robot: Callable[[], Connector]
    run: Callable[[], Connector]
    crash: Callable[[Any], None]


class MortalPlay(Play):
    """A play whose run dies.

    Args:
        name: The name of the robot.
        ways: How robot and run are reached.
        sent: What the mission sends.
        path: The run's journal.
        deaths: How each of the run's processes dies, if it is not killed by an act.
        actions: Whether actions have a server.
    """

    def __init__(
        self, name: str, ways: Ways, sent: Data, path: Path, deaths: Sequence[Death], *, actions: bool
    ) -> None:
        self._ways, self._path, self._deaths, self._actions = ways, path, list(deaths), actions
        self._fate, self._taken = Fate(), set[str]()
        self._resumed = list[tuple[int, int]]()
        self._journal: Any = None
        self._open = list[Connector]()
        robot = ways.robot()
        robot.start()
        self._open.append(robot)
        super().__init__(name, Pair(robot, robot), sent, actions=actions)
        self._thread = threading.Thread()
        self._header = Header(dump(mission(actions=actions)), dump_profile(profile(name, actions=actions)), run=name)
        self._sent = sent
        self._live()

    def cancel(self, goal_id: str) -> None:
        """A robot that has taken a cancel does not refuse to cancel when it is asked again: ROS has no word for it."""
        refuses, self._refuses = self._refuses, self._refuses and goal_id not in self._taken
        self._taken |= set() if self._refuses else {goal_id}
        super().cancel(goal_id)
        self._refuses = refuses

    def _live(self) -> None:
        """Begin, or continue, in a process of its own."""
        self._bury()
        death = self._deaths.pop(0) if self._deaths else Death()
        self._fate = fate = Fate(death.nth, is_done=death.is_done, what=death.what)
        if self._path.exists():
            try:
                taken = open_run(self._path)
            except UsageError:  # it had ended
                fate.is_dead = True
                return
            begin: Any = taken.resumption
            self._journal = Journal.open(self._path, seal=taken.record.seal)
            taken.record.close()
        else:
            begin = NewRun({"sent": self._sent}, run=self._name)
            self._journal = Journal.create(self._path, self._header)
        run = self._ways.run()
        if not run.running:
            run.start()
        self._ends = Pair(run, self._ends.robot)
        self._runner = Runner(
            mission(actions=self._actions),
            robot=profile(self._name, actions=self._actions),
            connector=Mortal(run, fate),
            clock=MortalClock(self._clock, fate),
            journal=Mortal(self._journal, fate),
            observer=RunObserver(self.steps),
            begin=begin,
        )
        self._thread = threading.Thread(target=self._run, args=(self._runner,))

    def _run(self, runner: Runner) -> None:
        try:
            runner.run()
        except Dead:
            self.asked(("died",))

    @property
    def is_dead(self) -> bool:
        return self._fate.is_dead

    def do(self, act: Act, least: Count) -> Count:
        since, count = len(self.steps.all), self._do(act, least)
        if act.what == "continues":
            self._resumed.append((since, count.steps))
        return count

    def story(self) -> list[Any]:
        """What a process receives as it continues is in no order: each goal, call and service answers by itself."""
        steps = self.steps.all
        for since, until in self._resumed:
            steps[since:until] = sorted(steps[since:until], key=_answered)
        return super().story()

    def _do(self, act: Act, least: Count) -> Count:
        what = act.what
        if what == "dies":
            self._fate.is_dead = True
            self._clock.advance(0.0)
            self._thread.join(WITHIN_S)
        elif what == "continues":
            if self.is_dead:
                self._live()
                if not self.is_dead:
                    self._thread.start()
        elif what in ("robot_dies", "robot_restarts"):
            if self.is_dead:
                self._replace_robot(is_back=what == "robot_restarts")
        elif self.is_dead and what in (*COMMANDS, *POSTED, "seen", "alarm"):
            pass
        else:
            return super().do(act, least)
        return self.settle(least)

    def _bury(self) -> None:
        if self._journal is not None:
            self._thread.join(WITHIN_S)
            self._journal.close()
            self._journal = None
            if self._ends.run is not self._ends.robot:
                self._ways.crash(self._ends.run)

    def _replace_robot(self, *, is_back: bool) -> None:
        """The robot's process dies; another may begin, which knows nothing of what came before."""
        if self._ends.robot is not self._ends.run:
            self._ways.crash(self._ends.robot)
        robot = self._ways.robot()
        robot.start()
        self._open.append(robot)
        self._ends = Pair(self._ends.run, robot)
        self._goals = [(goal_id, lambda report: None) for goal_id, _ in self._goals]
        self._closes = list(self._serve(actions=self._actions)) if is_back else []

    def settle(self, least: Count) -> Count:
        count = super().settle(least)
        if self.is_dead:
            self._bury()
        return count

    def end(self) -> None:
        if not self.is_dead:
            super().end()
        else:
            self._bury()
        for each in self._open:
            if each.running:
                each.stop()


def _answered(step: Step) -> tuple[Any, ...]:
    """What a step's event answers."""
    event = step.event
    return (event.kind, event.number, event.name, str(event.data.get("name")))
