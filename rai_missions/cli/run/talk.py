# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --talk`: the conversation next to a run, with its doors: the terminal, the page, topics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rai_missions.cli.inputs import warn
from rai_missions.cli.run.talk_runs import TalkRuns
from rai_missions.errors import ConnectorError, DefinitionError, MissionError, UsageError
from rai_missions.runtime.interrupts import on_interrupts
from rai_missions.runtime.run_options import RunObserver

if TYPE_CHECKING:
    from rai_missions.agents.conversation import ConversationalAgent
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.agents.talk.doors import TalkDoor, TalkLine, TextDoor
    from rai_missions.agents.talk.hri_door import HRIDoor
    from rai_missions.agents.talk.model import TalkModel
    from rai_missions.agents.talk.orders import OnOrderEnd
    from rai_missions.agents.talk.page_ear import PageEar
    from rai_missions.agents.talk.voice_door import VoiceDoor
    from rai_missions.cli.progress import Lines
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.conversation import BuildView, Order
    from rai_missions.embodiment.identity import Identity
    from rai_missions.engine.decision import Question
    from rai_missions.engine.step import Step
    from rai_missions.event import Role
    from rai_missions.profile import Robot
    from rai_missions.runtime.lifecycle import Status
    from rai_missions.runtime.runner import Result

__all__ = ("HeldOpen", "TalkSession", "normalise_voice_args", "talk_of", "talking")

END_REPORTED_S = 5.0
"""How long the program waits until the end of the mission is reported to those who talk with the robot."""

ANSWERED_S = 1.0
"""How long a script that is piped in waits for the answer to a line before the next is read."""


class HeldOpen:
    """The operator, who is met by talk: a question stays open until the conversation, or a page, answers it."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """It is spoken and shown by the conversation."""

    def withdraw(self, number: int) -> None:
        """The conversation sees that it is open no more."""


class TalkSession:
    """A conversation for one run.

    Args:
        options: Of the command.
        config: What the run is made of.
        profile: The robot's; None where it has none, or is a program.
    """

    def __init__(self, options: RunOptions, config: RunConfig, profile: Robot | None) -> None:
        self._options, self._policy = options, None if profile is None else profile.conversation
        policy = self._policy
        self.agent: ConversationalAgent | None = None
        self.earlier: tuple[TalkLine, ...] = ()
        """What was talked in the process that this one resumes."""
        self._doors: list[TalkDoor] = []
        self._hri: HRIDoor | None = None
        self._voice: VoiceDoor | None = None
        self._ear: PageEar | None = None
        self._begins_ready = policy is not None and policy.begins == "ready"
        self._is_typed_at = self._is_watched = False
        self._is_alone = options.node is None and not options.ros_args
        """No node serves the run; one that does has this run alone."""
        self._runs: TalkRuns | None = None
        self.config = replace(
            config.observed_by(RunObserver(self._follow_step, self._follow_status)), waits=self._begins_ready,
            operator=None if options.no_operator else HeldOpen(),
            speed=1.0 if config.speed is None and _is_simulated(profile) else config.speed,
        )  # fmt: skip
        """What the run is to be made of instead: at the wall's speed, since a person takes part."""

    def reach(self, *, is_typed_at: bool, is_watched: bool) -> None:
        """Where a sentence may come from; before `open`."""
        self._is_typed_at, self._is_watched = is_typed_at, is_watched

    def add_door(self, door: TalkDoor) -> None:
        """Another door; before `open`."""
        self._doors.append(door)

    def open(self, prepared: PreparedRun, config: RunConfig) -> ConversationalAgent:
        """Begin to talk about a run that is prepared.

        Args:
            prepared: The run.
            config: What it is made of, with the page and the node.

        Raises:
            UsageError: The model cannot be asked, or there is no such language.
            ConnectorError: The robot's connector cannot carry the messages of `/conversation/hri`.
        """
        from rai_missions.agents.conversation import ConversationalAgent
        from rai_missions.agents.talk.journal import earlier_lines, waiting_requests
        from rai_missions.agents.talk.run_status import RobotWords
        from rai_missions.agents.talk.settings import settings_of

        identity = _identity(prepared)
        name = prepared.robot.name if prepared.robot is not None else ""
        if self._options.voice is not None:
            self._doors.append(self._open_voice())
        robot = RobotWords(name)
        if identity is not None:
            robot = RobotWords(name, identity.first_sentence, _build(identity))
        if self._policy is not None and self._policy.hri:
            self._doors.append(self._open_topics(prepared, name))
        self.agent = agent = ConversationalAgent(
            settings_of(self._policy), model=_model(self._options, prepared, identity), doors=self._doors, robot=robot,
            start=self._order_next if self._is_alone else None,
        )  # fmt: skip
        self._runs = TalkRuns(config, waits=self._begins_ready, is_reachable=lambda: self._is_reachable)
        self._runs.begin(prepared)
        agent.attach(prepared.runner, prepared.journal)
        if prepared.plan.resumed is not None:
            notes = prepared.plan.resumed.record.notes()
            self.earlier = earlier_lines(notes)
            agent.continue_after(max((line.number for line in self.earlier), default=0))
            agent.report_lost(waiting_requests(notes))
        agent.run()
        if self._hri is not None:
            try:
                self._hri.open(agent.receive)
            except ConnectorError as fault:
                raise ConnectorError(f"the profile, /conversation/hri: {fault}") from None
        return agent

    def _open_voice(self) -> VoiceDoor:
        """The microphone and the speaker of this machine, running."""
        from rai_missions.agents.talk.voice_door import VoiceDoor
        from rai_missions.connectors.sound.devices import DeviceSound
        from rai_missions.voice.setup import ListenNames

        names = ListenNames(self._options.recogniser, wake_word=self._options.wake_word)
        self._voice = door = VoiceDoor(DeviceSound(), self._take, names=names, voice=self._options.voice or "flite")
        door.run()
        return door

    def _take(self, text: str, **words: Any) -> str:
        """A sentence from any door; why it is not taken, or empty."""
        return self.agent.receive(text, **words) if self.agent is not None else "too early"

    def _open_topics(self, prepared: PreparedRun, name: str) -> HRIDoor:
        from rai_missions.agents.talk.hri_door import HRIDoor
        from rai_missions.connectors.hri.connector import HRIConnector

        connector = prepared.connector
        if connector is None:
            raise UsageError('the profile\'s "hri" needs a robot that is reached over a connector; drop it')
        if not connector.running:
            connector.start()
            prepared.closing.closes(connector.stop)
        self._hri = HRIDoor(
            HRIConnector(connector), name, below=self._policy.hri_below if self._policy is not None else "",
            is_stop=self.is_stop,
        )  # fmt: skip
        return self._hri

    def type(self, text: str) -> str:
        """A line that is written on the terminal; why it is not taken, or empty."""
        return self._take(text, role="operator", channel="terminal")

    def wait_answered(self) -> None:
        """Wait until what was taken is answered, or for as long as an answer may take that needs no model."""
        if self.agent is not None:
            self.agent.wait_answered(ANSWERED_S)

    def receive(self, text: str, author: str, role: Role) -> str:
        """A sentence that is written on the page, whose token has a role."""
        return self._take(text, role=role, channel="page", author=author)

    @property
    def ear(self) -> PageEar:
        """Who listens to the page's microphone."""
        if self._ear is None:
            from rai_missions.agents.talk.page_ear import PageEar
            from rai_missions.voice.setup import ListenNames

            language = self._policy.language if self._policy is not None else "en"
            names = ListenNames(self._options.recogniser, echo=False)
            self._ear = PageEar(self._take, language=language, names=names)
        return self._ear

    def is_stop(self, text: str) -> bool:
        """Whether it is an order to stop."""
        return self.agent is not None and self.agent.is_stop(text)

    def doors_changed(self) -> None:
        """Someone has come to the page, or has gone."""
        if self.agent is not None:
            self.agent.doors_changed()

    # -- one run after the other -------------------------------------------------------------------------------

    def follow(self, prepared: PreparedRun, result: Result) -> PreparedRun | None:
        """A run is over: the one that follows, attached and ready; None: no other does, and there is no more talk.

        Args:
            prepared: The run.
            result: How it ended.
        """
        agent, runs = self.agent, self._runs
        if agent is None or runs is None:
            return None
        agent.conclude(0.0)
        if self._is_alone and self._is_reachable and not runs.is_interrupted:
            agent.wait_decided()
        if not (runs.is_continued and self._is_alone) and not agent.conclude(END_REPORTED_S):
            warn(f"no one could be reached to report how the mission ended: {result.outcome}: {result.why}")
        following = runs.following() if self._is_alone else None
        if following is None:
            self.close()
            return None
        agent.attach(following.runner, following.journal)
        prepared.close_files()
        runs.follow(following)
        return following

    def close(self) -> None:
        """Talk no more; closed already, nothing happens."""
        if self._runs is not None:
            self._runs.close()
        if self.agent is not None:
            self.agent.stop()
        self.close_voice()
        if self._hri is not None:
            with suppress(MissionError):
                self._hri.close()

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """The first interrupt cancels the run that there is and has no other follow, the second is an e-stop."""
        runs, agent = self._runs, self.agent
        assert runs is not None
        assert agent is not None

        def interrupt(by: str) -> None:
            runs.interrupt(by)
            agent.end_starts()

        with on_interrupts(interrupt, self.kill):
            yield

    def _order_next(self, order: Order, on_end: OnOrderEnd) -> None:
        assert self._runs is not None
        self._runs.order(order, on_end)

    def kill(self, by: str) -> None:
        """An e-stop: the run that there is ends at once, and no other follows; from any thread."""
        runs, agent = self._runs, self.agent
        if runs is not None and agent is not None:
            runs.kill(by)
            agent.end_starts()

    @property
    def _is_reachable(self) -> bool:
        """Whether an order may still come from somewhere."""
        doors = self._hri is not None or self._voice is not None
        return self._is_typed_at or self._is_watched or doors or not self._is_alone

    def typed_to_the_end(self) -> None:
        """Nothing more is typed; where there is no other door, a run that waits for an order ends."""
        self._is_typed_at = False
        agent, runs = self.agent, self._runs
        if agent is not None and runs is not None and not self._is_reachable:
            agent.after_all(runs.give_up)
            agent.after_all(agent.decide_nothing)

    def close_voice(self) -> None:
        """Listen and speak no more; closed already, nothing happens."""
        if self._voice is not None:
            self._voice.stop()
        if self._ear is not None:
            self._ear.stop()

    def _follow_step(self, step: Step) -> None:
        if self.agent is not None:
            self.agent.step(step)

    def _follow_status(self, status: Status) -> None:
        if self.agent is not None:
            self.agent.changed(status)
        if self._runs is not None:
            self._runs.changed()


def normalise_voice_args(options: RunOptions) -> RunOptions:
    """The options, where `run --voice mission.json` means the mission, not a voice.

    Raises:
        UsageError: There is no conversation to be spoken, no room for one, or no voice or recogniser of a name.
    """
    if options.voice is not None and not (options.mission or options.resume):
        options = options._replace(mission=options.voice, voice="flite")
    if options.voice is not None and not options.talk:
        raise UsageError("--voice is the sound of a conversation: give --talk too")
    if options.wake_word and options.voice is None:
        raise UsageError("--wake-word is of this machine's microphone: give --voice too")
    if options.talk and options.json:
        raise UsageError("--talk does not go with --json: it writes what is talked on standard output")
    if options.talk:
        from rai_missions.voice.kind import known
        from rai_missions.voice.setup import split_options

        known("recogniser", split_options(options.recogniser)[0])
        known("voice", split_options(options.voice or "flite")[0])
    return options


@contextmanager
def talk_of(options: RunOptions, config: RunConfig) -> Iterator[TalkSession | None]:
    """The conversation of a run, if the options ask for one."""
    if not options.talk:
        yield None
        return
    session = TalkSession(options, config, _checked_profile(config))
    try:
        yield session
    finally:
        session.close()


@contextmanager
def talking(
    session: TalkSession,
    prepared: PreparedRun,
    config: RunConfig,
    lines: Lines,
    page_door: Callable[[TalkSession], TextDoor] | None,
) -> Iterator[None]:
    """Open the doors of a conversation while its runs last.

    Args:
        session: The conversation.
        prepared: The first of its runs.
        config: What a run is made of.
        lines: Where the run is printed.
        page_door: Makes the door of the live page, where there is one.
    """
    from rai_missions.agents.talk.doors import TextDoor
    from rai_missions.cli.run.talk_terminal import TalkLines, TypedLines, open_typing

    typing = None
    if isinstance(lines, TalkLines):
        to = TypedLines(
            session.type,
            lambda why: lines.remark(f"not taken: {why}"),
            session.typed_to_the_end,
            session.wait_answered,
        )
        typing = open_typing(to, lines.foot)
        session.add_door(TextDoor("terminal", lines.talk))
    if page_door is not None:
        session.add_door(page_door(session))
    session.reach(is_typed_at=typing is not None, is_watched=page_door is not None)
    session.open(prepared, config)
    if typing is not None:
        typing.start()
    try:
        with session.interruptible():
            yield
    finally:
        if typing is not None:
            typing.stop()


def _checked_profile(config: RunConfig) -> Robot | None:
    """The robot's profile, of a run that is resumed that of its journal; None where it has none, or is a program.

    Raises:
        DefinitionError: What it states of talk is at fault.
    """
    from rai_missions.agents.run_plan import profile_of
    from rai_missions.agents.talk.settings import conversation_faults
    from rai_missions.mission.mission import Mission

    profile, mission = profile_of(config), config.mission
    faults = conversation_faults(profile, mission if isinstance(mission, Mission) else None) if profile else ()
    if faults:
        raise DefinitionError(faults, str(config.robot or config.resume))
    return profile


def _is_simulated(profile: Robot | None) -> bool:
    """Whether the run has the time of a simulated world."""
    return profile is not None and profile.connector["kind"] == "local" and profile.connector.get("world") is not None


def _identity(prepared: PreparedRun) -> Identity | None:
    from rai_missions.embodiment import Identity

    return Identity.read(prepared.plan.identity) if prepared.plan.identity is not None else None


def _build(identity: Identity) -> BuildView | None:
    """What follows from the robot's links and joints."""
    from rai_missions.conversation import BuildView
    from rai_missions.embodiment.extent import size_m, speed_m_s

    body = identity.body
    return None if body is None else BuildView(body.name, body.mass_kg or None, size_m(body), speed_m_s(body))


def _model(options: RunOptions, prepared: PreparedRun, identity: Identity | None) -> TalkModel | None:
    """The model of the conversation, in a process of its own: that of `--model`."""
    if options.model is None:
        return None
    from rai_missions.agents.talk.look_tools import look_tools
    from rai_missions.agents.talk.model import TalkModel
    from rai_missions.answerers.model.process.model import ModelProcess
    from rai_missions.answerers.model.providers import check_model
    from rai_missions.answerers.model.tools import open_toolbox

    check_model(options.model, memory_gib=options.model_memory)
    toolbox = open_toolbox(prepared.mission, prepared.robot, prepared.connector, prepared.clock.now)
    if toolbox is not None:
        prepared.closing.closes(toolbox.close)
    others = toolbox.read_only if toolbox is not None else ()
    process = ModelProcess(options.model, memory_gib=options.model_memory)
    return TalkModel(process, identity=identity, tools=lambda view: look_tools(identity, view, others))
