# SPDX-License-Identifier: Apache-2.0
"""A robot that lives on while the runs which drive it die at chosen instants and continue.

Rule: anyone who is dead does nothing more: no row, no goal, no call, no answer received.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rai_missions.connectors.connector import Report
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.decision import ReadsRun
from rai_missions.engine.step import Step
from rai_missions.journal import Header, Journal
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, dump_profile
from rai_missions.replay.open_run import OpenedRun, open_run
from rai_missions.runtime.clock import Clock, ContinuedClock, SimulatedClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import NewRun, RunObserver
from rai_missions.runtime.runner import Runner

__all__ = ("ONLOOKER", "Coroner", "Dead", "Fate", "Land", "Wish", "live")

WATCHED = ("write", "confirm", "note", "send_goal", "find_goal", "cancel_goal", "call", "publish", "ask", "wait")


MOST_STEPS = 150
ONLOOKER = "any onlooker"
"""Who ends a run that never rests."""


class Dead(BaseException):
    """`kill -9`, as it looks from inside."""


class Fate:
    """When a process dies.

    Args:
        at: At which of the things it does, counted from 0; None: never.
        is_done: It dies right after that has taken effect, rather than right before.
        what: The kind of thing that counts, such as `write`; by default all do.
    """

    def __init__(self, at: int | None = None, *, is_done: bool = False, what: str = "") -> None:
        self.is_done, self._what, self._left = is_done, what, at
        self.count, self.is_dead = 0, False
        self.mourn: Callable[[], None] = lambda: None
        """Notified of the death at its instant."""
        self.doing: tuple[str, tuple[Any, ...]] = ("", ())
        """What it did last, and with what."""

    def around(self, what: str, given: tuple[Any, ...], do: Callable[[], Any]) -> Any:
        """Do something, unless death comes first."""
        if self.is_dead:
            raise Dead
        is_last = self._is_next(what)
        self.doing = (what, given)
        self.count += 1
        self.is_dead = is_last and not self.is_done
        made = None if self.is_dead else do()
        self.is_dead = self.is_dead or is_last
        if self.is_dead:
            self.mourn()
            raise Dead
        return made

    def _is_next(self, what: str) -> bool:
        if self._left is None or self._what not in ("", what):
            return False
        self._left -= 1
        return self._left < 0


class Mortal:
    """Something that a process uses, as long as it lives."""

    def __init__(self, what: Any, fate: Fate) -> None:
        self._what, self._fate = what, fate
        if isinstance(what, ReadsRun):  # from Python 3.12 on, a protocol looks past __getattr__
            self.read_from = what.read_from

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._what, name)
        if name not in WATCHED:
            return found

        def used(*given: Any, **words: Any) -> Any:
            given = tuple(self._while_alive(each) for each in given)
            words = {word: self._while_alive(each) for word, each in words.items()}
            return self._fate.around(name, given, lambda: found(*given, **words))

        return used

    def subscribe(self, topic: str, type_name: str, on_message: Callable[[Any], None]) -> Callable[[], None]:
        close: Callable[[], None] = self._what.subscribe(topic, type_name, self._while_alive(on_message))
        return close

    def _while_alive(self, given: Any) -> Any:
        """A callback that the dead do not receive."""
        if not callable(given):
            return given

        def on_message(*data: Any) -> None:
            if not self._fate.is_dead:
                given(*data)

        return on_message


class Wish(NamedTuple):
    """What someone outside wants of a run."""

    at: float
    """When, on the land's clock; not before the wish ahead of it is granted."""
    order: Callable[[Runner], object]
    is_granted: Callable[[Runner], bool]


class Coroner:
    """Looks into deaths; this one is not curious."""

    def wrote(self, runner: Runner) -> None:
        """A step has just been written down."""

    def found(self, taken: OpenedRun) -> None:
        """A process is about to continue with a run."""

    def died(self, runner: Runner, fate: Fate) -> None:
        """A process has died."""


class NotedJournal:
    """A journal of whose steps a coroner receives."""

    def __init__(self, journal: Journal, on_message: Callable[[], None]) -> None:
        self._journal, self._received = journal, on_message

    def __getattr__(self, name: str) -> Any:
        return getattr(self._journal, name)

    def write(self, *given: Any, **words: Any) -> int:
        number = self._journal.write(*given, **words)
        self._received()
        return number


class Land:
    """The robot and its surroundings: goals that take time, services, and moments, on a time of its own.

    Args:
        wishes: What someone outside wants, and reports again and again until it is so.
        lasts_s: Action → how long a goal takes.
        ends: Action → how its goals end.
    """

    period_s = 0.5
    accepts_s = 0.0
    """How long a server thinks about a goal before it accepts it."""
    keeps_time = False
    """A death costs no time at all: a run's clock continues with the land's."""
    connector_type: type[LocalConnector] = LocalConnector

    def __init__(self, wishes: Sequence[Wish], lasts_s: Mapping[str, float], ends: Mapping[str, str]) -> None:
        self._wishes = list(wishes)
        self._ticks = 0
        self._asked_at = -1.0
        self.runner: Runner | None = None
        self.connector = self.connector_type(now=lambda: self.at)
        self.connector.start()
        self.started: list[tuple[str, str]] = []
        self.ended: list[tuple[str, str]] = []
        self.called: Counter[str] = Counter()
        self.received: Counter[str] = Counter()
        self._goals: dict[str, tuple[str, float, Callable[[Report], None]]] = {}
        self.unaccepted: dict[str, float] = {}
        """Goal that its server thinks about → until when."""
        self.also: list[Callable[[], None]] = []
        """What else happens in each period."""
        self.most_at_once = 0
        for action, seconds in lasts_s.items():
            self.connector.offer(
                f"/{action}", "x/action/X", Worker(self, action, seconds, ends.get(action, "succeeded"))
            )
        for service in ("/horn", "/lamp"):
            self.connector.serve(service, "std_srvs/srv/Trigger", lambda _, name=service: self._serve(name))
        self.connector.subscribe(
            "/lamp_topic", "std_msgs/msg/Bool", lambda reported: self.received.update([str(reported.data["data"])])
        )

    @property
    def at(self) -> float:
        return self._ticks * self.period_s

    @property
    def running(self) -> list[str]:
        """The goals that run now."""
        return list(self._goals)

    def step(self) -> None:
        self._ticks += 1
        for goal_id in [goal_id for goal_id, due in self.unaccepted.items() if due <= self.at]:
            self._accepted(goal_id)
        for goal_id, (_, due, _) in list(self._goals.items()):
            if due <= self.at and goal_id in self._goals:
                self._end(goal_id)
        for each in self.also:
            each()
        self.live_on()
        self.wish()

    def wish(self) -> None:
        """State what is wanted next, if it is time."""
        if self.runner is not None and self._wishes and self._wishes[0].at <= self.at:
            if self._wishes[0].is_granted(self.runner):
                self._wishes.pop(0)
            else:
                self._asked_at = self.at
                self._wishes[0].order(self.runner)

    def wish_again(self) -> None:
        """State once more what was reported in this period to a process that has died since, unless it took it in."""
        runner = self.runner
        if runner is not None and self._asked_at == self.at and not self._wishes[0].is_granted(runner):
            self._wishes[0].order(runner)

    def look(self, step: Step) -> None:
        """Stop a run that goes round for ever without that any time passes."""
        if step.seq > MOST_STEPS and step.outcome is None and self.runner is not None:
            self.runner.kill(ONLOOKER)

    def live_on(self) -> None:
        """What else there is continues for a period."""

    def _serve(self, name: str) -> Mapping[str, Any]:
        self.called[name] += 1
        return {"success": True, "message": ""}

    def accept(self, action: str, goal_id: str, seconds: float, end: str, report: Callable[[Report], None]) -> None:
        self.started.append((action, goal_id))
        self._goals[goal_id] = (end, self.at + self.accepts_s + seconds, report)
        self.most_at_once = max(self.most_at_once, len(self._goals))
        self.unaccepted[goal_id] = self.at + self.accepts_s
        if not self.accepts_s:
            self._accepted(goal_id)

    def _accepted(self, goal_id: str) -> None:
        del self.unaccepted[goal_id]
        self._goals[goal_id][2](Report(goal_id, "accepted", {}))

    def cancel(self, goal_id: str) -> None:
        self._end(goal_id, "canceled")

    def _end(self, goal_id: str, status: str = "") -> None:
        end, _, report = self._goals.pop(goal_id)
        self.ended.append((goal_id, status or end))
        report(Report(goal_id, status or end, {}))  # type: ignore[arg-type]


class Worker:
    """One action of a land."""

    def __init__(self, land: Land, action: str, seconds: float, end: str) -> None:
        self._land, self._action, self._seconds, self._end = land, action, seconds, end

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Report], None]) -> None:
        self._land.accept(self._action, goal_id, self._seconds, self._end, report)

    def cancel(self, goal_id: str) -> None:
        self._land.cancel(goal_id)


class MortalClock:
    """A clock at which a process can die while it waits."""

    def __init__(self, clock: Clock, fate: Fate) -> None:
        self._clock, self._fate = clock, fate

    def __getattr__(self, name: str) -> Any:
        return getattr(self._clock, name)

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        self._fate.around("wait", (), lambda: self._clock.wait(mailbox, until, paced=False))

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        self._clock.taken(mailbox, paced=False)


def live(
    path: Path,
    land: Land,
    mission: Mission,
    robot: Robot,
    answerers: Mapping[str, Any],
    fate: Fate,
    named: Mapping[str, Any] | None = None,
    coroner: Coroner | None = None,
) -> Result | None:
    """One process: begins the run, or continues with the one that the journal holds; None if it died."""
    clock: Clock = SimulatedClock(land)
    coroner = coroner or Coroner()
    taken = open_run(path, mission=mission, named=named) if path.exists() else None
    if taken is None:
        text = "" if mission.behaviours() else dump(mission)
        journal = Journal.create(path, Header(text, dump_profile(robot), run="run", versions=mission.packages()))
    else:
        coroner.found(taken)
        journal = Journal.open(path, seal=taken.record.seal)
        clock = clock if land.keeps_time else ContinuedClock(clock, taken.resumption.at)
    connector: Any = Mortal(land.connector, fate)
    try:
        runner = land.runner = Runner(
            mission,
            robot=robot,
            connector=connector,
            clock=MortalClock(clock, fate),
            answerers={name: Mortal(each, fate) for name, each in answerers.items()},
            journal=Mortal(NotedJournal(journal, lambda: coroner.wrote(runner)), fate),
            observer=RunObserver(land.look),
            begin=taken.resumption if taken is not None else NewRun(named=named, run="run"),
        )
        fate.mourn = lambda: coroner.died(runner, fate)
        if land.keeps_time and taken is not None:
            land.wish_again()
        return runner.run()
    except Dead:
        return None
    finally:
        land.runner = None
        journal.close()
        if taken is not None:
            taken.record.close()
