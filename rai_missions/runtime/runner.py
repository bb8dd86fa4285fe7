# SPDX-License-Identifier: Apache-2.0
"""The only loop: takes events, steps the chart, writes the journal, has the effects performed.

Rule: nothing is decided here. What an event means is the chart's affair; the order is always step, journal, effects.
"""

from __future__ import annotations

import math
import threading
import uuid
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import NoneType
from typing import Any

from rai_missions.connectors.connector import Connector
from rai_missions.engine import Chart
from rai_missions.engine.activities.goal_ledger import OpenGoal, may_move
from rai_missions.engine.decision import Answerer, ReadsRun, check_answerers
from rai_missions.engine.modes import refusal
from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError, DefinitionError, MissionError, UsageError, raised_text
from rai_missions.event import Event, Tick, is_e_stop
from rai_missions.given import check_given
from rai_missions.journal.buffer import BufferedWriter, JournalSink, raised_by
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.mission.start_fault import StartFault
from rai_missions.profile import Robot, actions_of, missing, robot_facts
from rai_missions.redaction import Redaction, cut, logger
from rai_missions.replay.resume import Resumption
from rai_missions.runtime.arguments import accepted, argument_faults
from rai_missions.runtime.clock import Clock, ContinuedClock, WallClock
from rai_missions.runtime.commands import RunCommands
from rai_missions.runtime.effects import EffectExecutor
from rai_missions.runtime.interrupts import interruptible
from rai_missions.runtime.lifecycle import Lifecycle
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.readings import refused
from rai_missions.runtime.recovery import ResyncWindow, resume_effects
from rai_missions.runtime.result import Result
from rai_missions.runtime.run_options import HarmlessObserver, NewRun, RunObserver
from rai_missions.runtime.scheduler import Scheduler
from rai_missions.runtime.view import RunView

__all__ = ("Runner",)

log = logger(__name__)

NEW_RUN, UNOBSERVED, NO_ROBOT = NewRun(), RunObserver(), Robot("none")
REFUSED_S = 1.0
"""How often a reading that is refused has a row of its own: a source may send nothing else, hundreds a second."""
SURVEYED_S = 3.0
"""How long after `ready_s` it may take to be known which actions two servers serve."""


class Runner(RunCommands):
    """Runs one mission to its end.

    Args:
        mission: A mission without faults (`rai_missions.check`).
        robot: The profile, which maps the mission's names to the robot's.
        connector: How the robot is reached. One that is `running` already is left so; else it belongs to the run, which
            starts and stops it.
        answerers: Who answers questions, by the names in `ask`.
        clock: The run's time; the wall's by default.
        journal: Where the run is written; nowhere by default.
        begin: The arguments and more of a new run, or where a run that was cut short is resumed; its clock then begins
            at that time, or later.
        observer: Who follows it.

    Raises:
        DefinitionError: The profile lacks what the mission uses, or an argument is missing or does not fit.
        UsageError: The mission names a predicate that was not given, or an argument is of another type.
    """

    def __init__(
        self,
        mission: Mission,
        *,
        robot: Robot | None = None,
        connector: Connector | None = None,
        answerers: Mapping[str, Answerer] | None = None,
        clock: Clock | None = None,
        journal: JournalSink | None = None,
        begin: NewRun | Resumption = NEW_RUN,
        observer: RunObserver = UNOBSERVED,
    ) -> None:
        given_mission(mission, "a Runner")
        check_given(robot, (Robot, NoneType), "robot", "a Robot", "Robot.model_validate(…) makes one of data")
        check_given(connector, (Connector, NoneType), "connector", "a connector")
        check_given(clock, (Clock, NoneType), "clock", "a clock")
        check_given(journal, (JournalSink, NoneType), "journal", "a journal", "Journal.create(FILE, …) makes one")
        check_given(begin, (NewRun, Resumption), "begin", "a NewRun or a Resumption")
        check_given(observer, RunObserver, "observer", "a RunObserver")
        check_answerers({} if answerers is None else answerers)
        if robot is not None and (faults := missing(mission, robot)):
            raise DefinitionError(faults, robot.name)
        self.mission, self.run_id = mission, begin.run or uuid.uuid4().hex[:12]
        self._clock: Clock = clock if clock is not None else WallClock()
        self._redaction, self._writer = Redaction(), BufferedWriter(journal, self._stop_at_once)
        self._mailbox = Mailbox(self._redaction.known, self._clock.now, self._writer.call)
        self._lifecycle, self._connector = Lifecycle(), connector
        control, scheduler = self._lifecycle.control, Scheduler(self._clock, self._mailbox)
        self._executor = EffectExecutor(
            mission,
            run=self.run_id,
            robot=robot or NO_ROBOT,
            connector=connector,
            answerers=dict(answerers or {}),
            scheduler=scheduler,
            control=control,
            note=self.note,
        )
        super().__init__(scheduler, control, self._executor.handovers)
        self._resumed: Resumption | None = None
        self._moved_aside: str | None = None
        self._window: ResyncWindow | None = None
        """What a resumed run waits for; None once it continues."""
        self._decisions, mode_by = 0, ""
        if isinstance(begin, Resumption):
            self._resumed, self._chart, self._arguments = begin, begin.chart, begin.arguments
            self._decisions, mode_by = begin.decisions, begin.mode_by
        else:
            facts = robot_facts(robot) if robot is not None else None
            self._chart = Chart(mission, begin.ticker, robot_facts=facts, named=begin.named)
            self._arguments = accepted(mission, begin.arguments, whole=not begin.waits)
            self._moved_aside = begin.moved_aside
        self._waits = begin.waits and self._chart.unstarted
        self._beginning = threading.Lock()
        """Held from a command to start until the run takes it."""
        self._once = threading.Lock()
        """Held from the call of `run` on."""
        self._steps = self._chart.seq
        """The number of the last step that is in a row of its own in the journal, or would be."""
        self.view = RunView(self._chart, scheduler, control, self._executor, self._missing, mode_by)
        """What others may read of it."""
        for each in (answerers or {}).values():
            if isinstance(each, ReadsRun):
                each.read_from(self.view)
        self._about = (robot or NO_ROBOT).about
        self._observer = HarmlessObserver(observer)
        self._notes: deque[tuple[str, Any]] = deque()
        self._refused_at: dict[str, float] = {}
        """Key → when a reading of it was refused, and that was written down."""
        self._loose: tuple[OpenGoal, ...] = self._chart.loose_goals

    def note(self, text: str, data: Any = None) -> None:
        """Have a sentence written into the journal, in its turn; from any thread, and the caller waits for no disk.

        Args:
            text: For people.
            data: The same for programs.
        """
        self._notes.append((text, data))
        self.call_soon(self._write_notes)

    @property
    def waits(self) -> bool:
        """Whether the run waits for the command to start, or to resume before it; if it is over, it never began."""
        return self._waits or self._chart.held_back

    @property
    def is_resumed(self) -> bool:
        """Whether another process began the run."""
        return self._resumed is not None

    def start(self, arguments: Mapping[str, Any]) -> Sequence[StartFault]:
        """Begin a run that waits for this command, or was paused before its start; from any thread.

        Args:
            arguments: Those of the mission that are given now; they replace those that the run was made with.

        Returns:
            What the mission has against it; empty where it begins.
        """
        if not self.waits or not self._beginning.acquire(blocking=False):
            return [StartFault("started", "the mission has been started already")]
        given = {**self._arguments, **arguments}
        if faults := argument_faults(self.mission, given):
            self._beginning.release()
            return faults
        self.call_soon(lambda: self._begin_with(given))
        return []

    def _begin_with(self, arguments: Mapping[str, Any]) -> None:
        self._arguments, self._waits = arguments, False
        self._beginning.release()
        if self._chart.held_back:
            self._step(lambda: self._chart.send(Event("resume", self._clock.now(), {"by": "start"}, "command")))

    # -- from its beginning to its end --------------------------------------------------------------------------------

    def run(self) -> Result:
        """Run to the end.

        Raises:
            ConnectorError: The robot cannot be reached.
            UsageError: The robot did not report what the mission needs to know before it starts; the error names it.
                Or it was run before: a Runner runs its mission once.
            KeyboardInterrupt: Ctrl-C was pressed, and the run has ended: the first cancels it, the second is an e-stop.
        """
        if not self._once.acquire(blocking=False):
            raise UsageError("a Runner runs its mission once; make another one for another run")
        with interruptible(self):
            return self._run()

    def _run(self) -> Result:
        began = self._clock.now() if self._resumed is None else self._resumed.began
        ours = self._connector is not None and not self._connector.running
        try:
            self._connect(ours=ours)
            if self._resumed is not None:
                self._resume(self._resumed)
            if self._chart.unstarted:
                self._get_ready()
            if self._chart.unstarted:
                self._executor.begin()
                self._step(lambda: self._chart.start(self._clock.now()))
            self._loop(lambda: self._chart.outcome is not None)
            self._executor.conclude()
            self._loop(self._is_settled)
            self._write_notes()
            self._write_buffered()
            return self._result(began)
        except BaseException as error:
            self._break_off(error)
            raise
        finally:
            self._writer.close()
            self._executor.close()
            if self._connector is not None and ours:
                self._disconnect(self._connector)

    def _connect(self, *, ours: bool) -> None:
        """Begin to receive.

        Raises:
            ConnectorError: The robot cannot be reached, or its connector would end the program.
        """
        try:
            if self._connector is not None and ours:
                self._connector.start()
            if isinstance(self._clock, ContinuedClock):
                self._clock.begin()
            self._executor.open()
        except SystemExit as error:
            raised = f"{type(self._connector).__name__} raised {raised_text(error)}"
            raise ConnectorError(f"the robot cannot be reached: {raised}") from error

    def _disconnect(self, connector: Connector) -> None:
        try:
            connector.stop()
        except (Exception, SystemExit):
            log.exception("the connector could not be stopped")

    def _is_settled(self) -> bool:
        """Nothing that the ended mission has begun is waited for, and all that was reported of it is taken."""
        if self._chart.awaited_goals or self._executor.handovers.letting_go or self._executor.is_concluding:
            return False
        return self._mailbox.empty or not self._executor.hosts_actions

    def _result(self, began: float) -> Result:
        chart = self._chart
        return Result(
            chart.outcome or "failed",
            chart.why,
            self._steps,
            self._writer.path,
            self.run_id,
            tuple(sorted(chart.active)),
            self._decisions,
            self._clock.now() - began,
            chart.loose_goals,
            self._moved_aside,
        )

    # -- what another process began -----------------------------------------------------------------------------------

    def _resume(self, resumed: Resumption) -> None:
        """Continue where a run was cut short, with what it had under way."""
        self._report_awaited()
        self._lifecycle.control.keep(is_kept=self._chart.taken)
        self._writer.resume(resumed.at)
        if self._mailbox.urgent:
            resumed.under.stop()
        resume_effects(resumed, self._executor, self._writer)
        if self._chart.outcome is None and not resumed.exact:
            self._resync()
        self._executor.ask_again(resumed.under, self._chart.questions)

    def _resync(self) -> None:
        """Receive again what the robot had reported, before anything else happens; what arrives meanwhile waits."""
        window = self._window = ResyncWindow(self._chart, self._clock.now())
        while self._clock.now() < window.until:
            self._scheduler.run_due()
            self._report_awaited()
            event = self._mailbox.take()
            if event is None:
                self._clock.wait(self._mailbox, min(window.until, self._scheduler.due), paced=False)
            elif is_e_stop(event):
                self._window = None
                self._kill(event)
                break
            else:
                window.take(event)
                is_order = event.kind == "command" and event.name in ("stop", "cancel")
                if is_order and not refusal(self._chart.mode, event.name):
                    self._executor.stop_everything()  # the chart has its turn when the run continues
                    if event.name == "cancel":
                        break  # it needs no facts
        self._window = None
        self._step(lambda: self._chart.send(window.event(self._clock.now())))
        self._mailbox.put_back(window.rest)

    def _missing(self) -> tuple[str, ...]:
        """The robot keys that a resumed run waits for."""
        return self._window.missing if self._window is not None else ()

    def _report_awaited(self) -> None:
        """Report what a resumed run waits for, once more whenever a part of it has come."""
        if self._resumed is not None and self._resumed.last is not None:
            self._report_status(self._resumed.last)

    # -- before the start ---------------------------------------------------------------------------------------------

    def _get_ready(self) -> None:
        """Receive every robot key once before the start."""
        chart = self._chart
        self._write_arguments()
        until, rivalry = self._clock.now() + self.mission.ready_s, self._executor.rivalry
        rivalry.ask(actions_of(self.mission), self.mission.ready_s)
        self._loop(lambda: chart.outcome is not None or not self._unreported or self._clock.now() >= until, until)
        if self._unreported and chart.outcome is None:
            missed = {name: self._executor.source(name) for name in self._unreported}
            sentence = refused(missed, self.mission.blackboard, self.mission.ready_s)
            raise UsageError(f"{sentence} Its profile notes: {self._about}" if self._about else sentence)
        until += SURVEYED_S
        self._loop(lambda: chart.outcome is not None or rivalry.is_known or self._clock.now() >= until, until)
        if rivalry.contests and chart.outcome is None:
            raise UsageError("; ".join(rivalry.contests))
        while chart.outcome is None and not self._may_begin():
            self._loop(lambda: chart.outcome is not None or not self.waits)
        self._write_arguments()  # an order to start may have brought others since, also while facts were awaited
        holder = self._executor.holder
        if holder is not None and holder != chart.holder and chart.outcome is None:
            self._step(lambda: chart.send(Event(holder, self._clock.now(), {"by": "robot"}, "control")))

    @property
    def _unreported(self) -> tuple[str, ...]:
        """What the robot has yet to report."""
        return (*self._chart.unreported, *(() if self._executor.holder != "" else ("who holds control",)))

    def _may_begin(self) -> bool:
        """Whether nothing is in the way of the start, once all has been taken that was reported or ordered before it.

        What the robot reported need not be there and may wait behind what must. What a person ordered counts first: a
        goal that a stop would have prevented is never sent.
        """
        if self.waits:
            return False
        later = list[Event]()
        for _ in range(self._mailbox.waiting):
            event = None if self._mailbox.urgent or self._chart.outcome is not None else self._mailbox.take()
            if event is None:
                break
            if event.kind == "command" or (event.kind == "write" and not later):
                self._take(event)
            else:
                later.append(event)
        self._mailbox.put_back(later)
        return not self.waits

    def _write_arguments(self) -> None:
        chart = self._chart
        for key, value in self._arguments.items():
            is_new = key not in chart.view.board or chart.view.board[key].value != value
            if is_new and chart.outcome is None:
                self._step(partial(chart.write, key, value, self._clock.now()))

    # -- the loop -----------------------------------------------------------------------------------------------------

    def _loop(self, done: Callable[[], bool], until: float = math.inf) -> None:
        while not done():
            self._do_due()
            event = self._mailbox.take()
            if event is not None:
                self._take(event)
                self._clock.taken(self._mailbox, paced=self._is_paced)
                continue
            self._journal(self._writer.flush)  # no event is taken now, with which a confirmation could be written
            if not done() and self._scheduler.due > -math.inf:  # a wake may be taken before what it was for
                self._idle(until)
        self._journal(self._writer.flush)

    def _do_due(self) -> None:
        """What is asked of the runner itself, and what its time has come for."""
        self._scheduler.run_due()
        if self._settled() >= self._due:
            self._write_buffered()

    def _settled(self) -> float:
        """Until when all that has happened is known: what waits in the mailbox happened before the clock's present."""
        now = self._clock.now()  # looked at first, so that what enters the mailbox meanwhile is not older
        return max(now, self._chart.at) if self._mailbox.empty else self._chart.at

    def _idle(self, until: float) -> None:
        """Nothing has come: wait for it, or for the next instant."""
        if not self._mailbox.empty:
            return
        wake = self._chart.wake_at
        due = min(until, math.inf if wake is None else wake, self._scheduler.due)
        self._clock.wait(self._mailbox, min(due, self._due), paced=self._is_paced)
        now = self._clock.now()
        if wake is not None and wake <= now and self._mailbox.empty:
            self._step(lambda: self._chart.send(Tick(now)))

    @property
    def _is_paced(self) -> bool:
        """A model or a person thinks: simulated time goes no faster than on the wall."""
        return self._executor.thinking or (self.waits and self._chart.unstarted)

    def _take(self, event: Event) -> None:
        now = self._clock.now()
        event = event if event.at <= now else event.moved(now)
        if is_e_stop(event):
            self._kill(event)
            return
        self._step(lambda: self._chart.send(event))
        if event.kind == "proposal":
            self._executor.answered(event.number)

    # -- one step -----------------------------------------------------------------------------------------------------

    def _step(self, make: Callable[[], Step], *, quiet: bool = True) -> None:
        """Step, journal, effects."""
        since = self._chart.at
        step = make()
        if quiet and self._chart.quiet and step.event.kind in ("write", "tick") and not self._is_news(step):
            self._writer.buffer(step, self._chart.view.board)
        elif not self._write(step, since):
            return
        if self._mailbox.urgent:  # nothing is begun any more by what waited for the disk
            self._executor.leave(step.effects, "an e-stop came before it")
            self._report(step)
            return
        self._lifecycle.control.follow(self._chart.holder, taken=self._chart.taken)  # an effect may ask for it
        self._executor.perform(step.effects)
        lost = raised_by(lambda: self._writer.confirm(step, may_wait=not self._mailbox.empty))
        self._report(step)
        if lost is not None:
            self._lose_journal(lost)

    def _is_news(self, step: Step) -> bool:
        """Whether a step refuses a reading, the first of its key within a second: one a second is written."""
        if not step.refusal or step.at < self._refused_at.get(step.event.name, -math.inf) + REFUSED_S:
            return False
        self._refused_at[step.event.name] = step.at
        return True

    def _kill(self, event: Event) -> None:
        """The e-stop: the actuators first, the journal after."""
        since = self._chart.at
        step = self._chart.send(event)
        self._executor.perform(step.effects)
        self._report(step)
        self._write(step, since)

    def _stop_at_once(self) -> None:
        """The e-stop of a run that waits for its disk: it is taken when the disk answers, or never does."""
        if self._mailbox.urgent:
            self._executor.stop_everything()
            self._executor.handovers.let_go(self._scheduler.wake)

    def _break_off(self, error: BaseException) -> None:
        """The run cannot continue, whatever the reason: nothing that it started may continue without it."""
        self._executor.stop_everything()
        sentence = f"the run breaks off: {self._redaction.known(raised_text(error))}"
        if not isinstance(error, MissionError):  # that one is a sentence for the caller, who gets it
            log.critical("%s", sentence)
        try:
            self._writer.note(cut(sentence, 1000), {"broken_off": type(error).__name__})
        except MissionError as silent:
            log.error("why the run breaks off cannot be written down: %s", self._redaction.known(str(silent)))
        except Exception:
            log.exception("that the run breaks off cannot be written into its journal")

    # -- what is reported ---------------------------------------------------------------------------------------------

    def _report(self, step: Step) -> None:
        self._decisions += step.questions
        self._report_status(step)
        self._observer.on_step(step)

    def _report_status(self, step: Step) -> None:
        chart = self._chart
        if chart.loose_goals != self._loose:
            self._loose = chart.loose_goals
            data = {"open_goals": [goal.data() for goal in self._loose]}
            self.note(may_move(self._loose) or "no goal may still move the robot", data)
        status = self._lifecycle.observe(step, self.view)
        is_stop = chart.outcome is not None and step.event.kind != "control"
        if status is not None and status.control == "nobody" and is_stop:
            self._executor.handovers.let_go(self._scheduler.wake)
        if status is not None:
            self._observer.on_status(status)

    # -- the journal --------------------------------------------------------------------------------------------------

    def _journal(self, write: Callable[[], None]) -> bool:
        """Have something written down; whether it was."""
        lost = raised_by(write)
        if lost is not None:
            self._lose_journal(lost)
        return lost is None

    def _write(self, step: Step, since: float) -> bool:
        self._steps = step.seq
        return self._journal(lambda: self._writer.write(step, since))

    def _write_notes(self) -> None:
        while self._notes:
            self._journal(partial(self._writer.note, *self._notes.popleft()))

    @property
    def _due(self) -> float:
        """When a row must be written: what is buffered must not be so for long, nor a running timer silent."""
        timed = self._chart.wake_at is not None and not self._chart.unstarted
        return min(self._writer.due, self._writer.silent_from) if timed else self._writer.due

    def _write_buffered(self) -> None:
        """Have the buffer written down: with a step in which only time passes."""
        if self._due < math.inf:
            self._step(lambda: self._chart.send(Tick(self._settled())), quiet=False)

    def _lose_journal(self, error: Exception) -> None:
        """What cannot be written down does not continue."""
        log.critical("the journal cannot be written, e-stop: %s", error)
        by = self._redaction.known(f"the journal: {error}")
        step = self._chart.send(Event("kill", self._clock.now(), {"by": by}, "command"))
        self._executor.perform(step.effects)
        self._report(step)
