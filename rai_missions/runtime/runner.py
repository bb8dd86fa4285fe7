# SPDX-License-Identifier: Apache-2.0
"""The only loop: takes events, steps the chart, writes the journal, has the effects performed.

Rule: nothing is decided here. What an event means is the chart's affair; the order is always step, journal, effects.
"""

from __future__ import annotations

import heapq
import itertools
import math
import uuid
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rai_missions.connectors.connector import Connector
from rai_missions.engine import Chart, Named
from rai_missions.engine.activities.goal_ledger import OpenGoal, may_move
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.decision import Answerer
from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError, DefinitionError, UsageError
from rai_missions.event import Event, Tick
from rai_missions.journal.buffer import BufferedWriter, JournalSink, raised_by
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, actions_of, missing, terms
from rai_missions.redaction import cut, logger
from rai_missions.replay.rebuild import default_ticker
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.arguments import accepted
from rai_missions.runtime.clock import Clock, ContinuedClock, Mailbox, WallClock
from rai_missions.runtime.commands import RunCommands
from rai_missions.runtime.effects import EffectExecutor
from rai_missions.runtime.interrupts import interruptible
from rai_missions.runtime.lifecycle import Lifecycle, Status
from rai_missions.runtime.readings import refused
from rai_missions.runtime.recovery import ResyncWindow, resume_effects
from rai_missions.runtime.result import Commands, Result

__all__ = ("Commands", "Result", "Runner")

log = logger(__name__)

T = TypeVar("T")
SURVEYED_S = 3.0
"""How long after `ready_s` it may take to be known which actions two servers serve."""


class Runner(RunCommands):
    """Runs one mission to its end.

    Args:
        mission: A mission without faults (`rai_missions.check`).
        robot: The profile that says what stands behind the mission's names.
        connector: How the robot is reached. One that is `running` already is left so; else it is the run's, and is
            started and stopped by it.
        answerers: Who answers questions, by the names in `ask`.
        clock: The run's time; the wall's by default.
        journal: Where the run is written down; nowhere by default.
        arguments: Values for the mission's argument keys.
        ticker: Who ticks trees; py_trees by default, loaded when the mission has one.
        named: The predicates that the mission's guards name.
        run: The run's identity; made up by default.
        on_step: Told of each step after its effects, on the runner's thread.
        on_status: Told of each change of mode, control or active states.
        resumed: Where a run stood that was cut short, to go on from there; its clock must not be behind it.
        clean: Takes secrets out of what is heard, before it becomes a step.
        moved_aside: Where the journal of an earlier run is now, whose name this one's took; for the result.

    Raises:
        DefinitionError: The profile lacks what the mission uses.
        UsageError: An argument that the mission does not take.
    """

    def __init__(
        self, mission: Mission, *, robot: Robot | None = None, connector: Connector | None = None,
        answerers: Mapping[str, Answerer] | None = None, clock: Clock | None = None, journal: JournalSink | None = None,
        arguments: Mapping[str, Any] | None = None, ticker: Trees | None = None, named: Named | None = None,
        run: str | None = None, on_step: Callable[[Step], None] | None = None,
        on_status: Callable[[Status], None] | None = None, resumed: Resumption | None = None,
        clean: Callable[[Any], Any] | None = None, moved_aside: str | None = None,
    ) -> None:  # fmt: skip
        if robot is not None and (faults := missing(mission, robot)):
            raise DefinitionError(faults, robot.name)
        self.mission, self.run_id = mission, run or uuid.uuid4().hex[:12]
        self.clock: Clock = clock if clock is not None else WallClock()
        self.mailbox, self._clean = Mailbox(clean, self.clock.now), clean or (lambda said: said)
        self.lifecycle = Lifecycle()
        self._resumed, self._moved_aside = resumed, moved_aside
        self.chart = resumed.chart if resumed is not None else Chart(
            mission, ticker or default_ticker(mission), terms=terms(robot) if robot is not None else None, named=named
        )  # fmt: skip
        self.performer = EffectExecutor(
            run=self.run_id, robot=robot, connector=connector, answerers=dict(answerers or {}), post=self.post,
            later=self.later, now=self.clock.now, wake=self.mailbox.wake,
            allow=lambda to: self.lifecycle.control.request(to, "mission"), leaves=mission.behaviours(),
            keys=mission.blackboard, note=self.note, lost=self._lose_handover,
        )  # fmt: skip
        self._connector, self._scribe = connector, BufferedWriter(journal, self._stop_at_once)
        self.mailbox.alarm = self._scribe.call
        self._puzzled: set[str] = set()
        self._names = tuple(name for _, name, _ in mission.walk())
        self._about = robot.about if robot is not None else ""
        self._on_step, self._on_status = on_step, on_status
        self._arguments = accepted(mission, arguments or {})
        self._later: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._requests: deque[Callable[[], None]] = deque()
        self._notes: deque[tuple[str, Any]] = deque()
        self._loose: tuple[OpenGoal, ...] = self.chart.loose_goals
        self._decisions = resumed.decisions if resumed is not None else 0

    def later(self, at: float, do: Callable[[], None]) -> None:
        """Have something done on the runner's thread at an instant of the run's clock."""
        heapq.heappush(self._later, (at, next(self._order), do))

    # -- the loop -------------------------------------------------------------------------------------------------

    def run(self) -> Result:
        """Run to the end.

        Raises:
            ConnectorError: The robot cannot be reached.
            UsageError: The robot did not say what the mission needs to know before it starts; the names stand in it.
            KeyboardInterrupt: Ctrl-C was pressed, and the run has ended: the first cancels it, the second kills it.
        """
        with interruptible(self):
            return self._run()

    def _run(self) -> Result:
        began = self.clock.now() if self._resumed is None else self._resumed.began
        ours = self._connector is not None and not self._connector.running
        try:
            if self._connector is not None and ours:
                self._connector.start()
            if isinstance(self.clock, ContinuedClock):
                self.clock.begin()
            self.performer.open()
            if self._resumed is not None:
                self._take_up(self._resumed)
            if self.chart.mode == "ready":
                self._get_ready()
            if self.chart.mode == "ready" and self.chart.outcome is None:
                self.performer.begin()
                self._step(lambda: self.chart.start(self.clock.now()))
            self._loop(lambda: self.chart.outcome is not None)
            self._loop(lambda: not self.chart.open_goals and not self.performer.handovers.letting_go)
            self._write_notes()
            self._write_carried()
            return self._result(began)
        except BaseException as error:
            self._break_off(error)
            raise
        finally:
            self._scribe.close()
            self.performer.close()
            if self._connector is not None and ours:
                self._disconnect(self._connector)

    def _disconnect(self, connector: Connector) -> None:
        try:
            connector.stop()
        except Exception:
            log.exception("the connector could not be stopped")

    def _take_up(self, resumed: Resumption) -> None:
        """Go on where a run was cut short, with what it had under way."""
        if resumed.last is not None:
            self._tell_status(resumed.last)
        self.lifecycle.control.kept = self.chart.taken
        self._scribe.resume(resumed.at)
        if self.mailbox.urgent:
            resumed.under.stop()
        resume_effects(resumed, self.performer, self._scribe)
        if self.chart.outcome is None:
            self._hear_again()
        self.performer.ask_again(resumed.under, self.chart.questions)

    def _hear_again(self) -> None:
        """Receive again what the robot had reported, before anything else happens; what arrives meanwhile waits."""
        hearing = ResyncWindow(self.chart, self.clock.now())
        while self.clock.now() < hearing.until:
            self._do_asked()
            event = self.mailbox.take()
            if event is None:
                due = min(hearing.until, self._later[0][0] if self._later else math.inf)
                self.clock.wait(self.mailbox, due if not self._requests else -math.inf, paced=False)  # as in `_loop`
            elif event.kind == "command" and event.name == "kill":
                self._kill(event)
                break
            else:
                hearing.take(event)
        self._step(lambda: self.chart.send(hearing.event(self.clock.now())))
        self.mailbox.put_back(hearing.rest)

    def _get_ready(self) -> None:
        """Hear every robot key once before the start."""
        chart = self.chart
        for key, value in self._arguments.items():
            if key not in chart.view.board or chart.view.board[key].value != value:
                self._step(lambda key=key, value=value: chart.write(key, value, self.clock.now()))  # type: ignore[misc]
        until, rivalry = self.clock.now() + self.mission.ready_s, self.performer.rivalry
        rivalry.ask(actions_of(self.mission), self.mission.ready_s)
        self._loop(lambda: chart.outcome is not None or not self._unheard or self.clock.now() >= until, until)
        if self._unheard and chart.outcome is None:
            missed = {name: self.performer.source(name) for name in self._unheard}
            sentence = refused(missed, self.mission.blackboard, self.mission.ready_s)
            raise UsageError(f"{sentence} Its profile says: {self._about}" if self._about else sentence)
        until += SURVEYED_S
        self._loop(lambda: chart.outcome is not None or rivalry.is_known or self.clock.now() >= until, until)
        if rivalry.contests and chart.outcome is None:
            raise UsageError("; ".join(rivalry.contests))
        holder = self.performer.holder
        if holder is not None and holder != chart.holder and chart.outcome is None:
            self._step(lambda: chart.send(Event(holder, self.clock.now(), {"by": "robot"}, "control")))

    @property
    def _unheard(self) -> tuple[str, ...]:
        """What the robot has yet to say."""
        return (*self.chart.unheard, *(() if self.performer.holder != "" else ("who holds control",)))

    def _loop(self, done: Callable[[], bool], until: float = math.inf) -> None:
        while not done():
            self._do_due()
            event = self.mailbox.take()
            if event is not None:
                self._take(event)
                self.clock.taken(self.mailbox, paced=self.performer.thinking)
            elif not done() and not self._requests:  # a wake may just have been taken out, with what it was for undone
                self._idle(until)

    def _do_due(self) -> None:
        """What is asked of the runner itself, and what its time has come for."""
        self._do_asked()
        if self._settled() >= self._due:
            self._write_carried()

    def _settled(self) -> float:
        """Until when all that has happened is known: what waits in the mailbox happened before the clock's present."""
        now = self.clock.now()  # looked at first, so that what enters the mailbox meanwhile is not older
        return max(now, self.chart.at) if self.mailbox.empty else self.chart.at

    def _do_asked(self) -> None:
        while self._requests:
            self._requests.popleft()()
        now = self.clock.now()
        while self._later and self._later[0][0] <= now:
            heapq.heappop(self._later)[2]()

    def _idle(self, until: float) -> None:
        """Nothing has come: wait for it, or for the next instant."""
        if not self.mailbox.empty:
            return
        wake = self.chart.wake_at
        due = min(until, math.inf if wake is None else wake, self._later[0][0] if self._later else math.inf)
        self.clock.wait(self.mailbox, min(due, self._due), paced=self.performer.thinking)
        now = self.clock.now()
        if wake is not None and wake <= now and self.mailbox.empty:
            self._step(lambda: self.chart.send(Tick(now)))

    def _take(self, event: Event) -> None:
        now = self.clock.now()
        event = event if event.at <= now else event._replace(at=now)
        if event.kind == "command" and event.name == "kill":
            self._kill(event)
            return
        self._step(lambda: self.chart.send(event))
        if event.kind == "proposal":
            self.performer.answered(event.number)

    def _step(self, make: Callable[[], Step], *, quiet: bool = True) -> None:
        """Step, journal, effects."""
        since = self.chart.at
        step = make()
        if quiet and self.chart.quiet and step.event.kind in ("write", "tick"):
            self._scribe.carry(step, self.chart.view.board)
        elif not self._write(step, since):
            return
        if self.mailbox.urgent:  # nothing is begun any more by what waited for the disk
            self.performer.leave(step.effects, "an emergency stop came before it")
            self._tell(step)
            return
        self.lifecycle.control.follow(self.chart.holder, taken=self.chart.taken)  # an effect may ask for it
        self.performer.perform(step.effects)
        lost = raised_by(lambda: self._scribe.confirm(step))
        self._tell(step)
        if lost is not None:
            self._lose_journal(lost)

    def _kill(self, event: Event) -> None:
        """The emergency stop: the actuators first, the journal after."""
        since = self.chart.at
        step = self.chart.send(event)
        self.performer.perform(step.effects)
        self._tell(step)
        self._write(step, since)

    def _stop_at_once(self) -> None:
        """The emergency stop of a run that waits for its disk: it is taken when the disk answers, or never does."""
        if self.mailbox.urgent:
            self.performer.stop_everything()
            self.performer.handovers.let_go(self.mailbox.wake)

    def _break_off(self, error: BaseException) -> None:
        """The run cannot go on, whatever the reason: nothing that it started may go on without it."""
        self.performer.stop_everything()
        sentence = f"the run breaks off: {type(error).__name__}: {self._clean(str(error))}"
        if not isinstance(error, UsageError):
            log.critical("%s", sentence)
        try:
            self._scribe.note(cut(sentence, 1000))
        except (ConnectorError, UsageError) as silent:
            log.error("nor can that be written down: %s", self._clean(str(silent)))
        except Exception:
            log.exception("the journal cannot say why the run breaks off")

    def _tell(self, step: Step) -> None:
        self._decisions += step.question is not None
        self._tell_status(step)
        if self._on_step is not None:
            self._observe(self._on_step, step, "on_step")

    def _lose_handover(self, to: str, is_refused: bool) -> None:
        """A handover that was asked for does not come; from any thread.

        Where it is refused while the robot says that the operator holds control, the operator keeps it: the operator
        has taken what the mission gave.
        """

        def lose() -> None:
            self.lifecycle.control.give_up(to)
            if is_refused and to != "operator" and self.performer.holder == self.chart.holder == "operator":
                self.post(Event("operator", self.clock.now(), {"by": "operator"}, "control"))

        self.soon(lose)

    def _tell_status(self, step: Step) -> None:
        chart = self.chart
        if chart.loose_goals != self._loose:
            self._loose = chart.loose_goals
            data = {"open_goals": [goal.data() for goal in self._loose]}
            self.note(may_move(self._loose) or "no goal may still move the robot", data)
        status = self.lifecycle.observe(
            step,
            taken=chart.taken,
            held_by=chart.held_by,
            held_since=chart.held_since,
            mode=chart.mode,
            holder=chart.holder,
            waiting=chart.waiting,
            open_goals=chart.loose_goals,
            active=tuple(name for name in self._names if name in chart.active),
        )
        is_stop = chart.outcome is not None and step.event.kind != "control"
        if status is not None and status.control == "nobody" and is_stop:
            self.performer.handovers.let_go(self.mailbox.wake)
        if status is not None and self._on_status is not None:
            self._observe(self._on_status, status, "on_status")

    def _observe(self, observer: Callable[[T], None], what: T, name: str) -> None:
        """Whoever looks on cannot harm the run; the first thing that an observer raises is logged."""
        try:
            observer(what)
        except Exception:
            if name not in self._puzzled:
                self._puzzled.add(name)
                log.exception("%s raised; the run goes on", name)

    # -- the journal ----------------------------------------------------------------------------------------------

    def _write(self, step: Step, since: float) -> bool:
        lost = raised_by(lambda: self._scribe.write(step, since))
        if lost is not None:
            self._lose_journal(lost)
        return lost is None

    @property
    def _due(self) -> float:
        """When a row must be written: what travels must not travel for long, nor time that a timer is running."""
        timed = self.chart.wake_at is not None and self.chart.mode != "ready"
        return min(self._scribe.due, self._scribe.silent_from) if timed else self._scribe.due

    def _write_carried(self) -> None:
        """Have what travels written down: with a step in which only time passes."""
        if self._due < math.inf:
            self._step(lambda: self.chart.send(Tick(self._settled())), quiet=False)

    def _lose_journal(self, error: Exception) -> None:
        """What cannot be written down does not go on."""
        log.critical("the journal cannot be written, the mission is killed: %s", error)
        self._scribe.give_up()
        step = self.chart.send(Event("kill", self.clock.now(), {"by": self._clean(f"the journal: {error}")}, "command"))
        self.performer.perform(step.effects)
        self._tell(step)

    def _result(self, began: float) -> Result:
        chart = self.chart
        return Result(
            chart.outcome or "failed", chart.why, chart.seq, self._scribe.path, self.run_id,
            tuple(sorted(chart.active)), self._decisions, self.clock.now() - began, chart.loose_goals,
            self._moved_aside,
        )  # fmt: skip
