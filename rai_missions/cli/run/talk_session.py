# SPDX-License-Identifier: Apache-2.0
"""The conversation of `rai-missions run --talk` while it is open: one run after the other, and where people talk."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property
from typing import TYPE_CHECKING

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.journal import earlier_lines, waiting_requests
from rai_missions.agents.talk.meaning import likeness_in
from rai_missions.agents.talk.run_status import RobotWords
from rai_missions.agents.talk.settings import settings_of
from rai_missions.cli.inputs import warn
from rai_missions.cli.run.talk_runs import TalkRuns
from rai_missions.errors import ConnectorError, MissionError, UsageError
from rai_missions.runtime.interrupts import on_interrupts

if TYPE_CHECKING:
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.agents.talk.doors import TakesSentence, TalkDoor, TalkLine
    from rai_missions.agents.talk.hri_door import HRIDoor
    from rai_missions.agents.talk.model import TalkModel
    from rai_missions.agents.talk.page_ear import PageEar
    from rai_missions.agents.talk.voice_door import VoiceDoor
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.conversation import BuildView
    from rai_missions.embodiment.identity import Identity
    from rai_missions.engine.step import Step
    from rai_missions.event import Role
    from rai_missions.profile import ConversationPolicy
    from rai_missions.runtime.lifecycle import Status
    from rai_missions.runtime.result import Result

__all__ = ("TalkSession",)

END_REPORTED_S = 5.0
"""How long the program waits until the end of the mission is reported to those who talk with the robot."""

ANSWERED_S = 1.0
"""How long a script that is piped in waits for the answer to a line before the next is read."""


class TalkSession:
    """A conversation about one run after the other, which `run` begins.

    Args:
        options: The options of the command.
        policy: What the profile sets.
        prepared: The first run.
        config: What it is made of, with the page and the node.
        waits: A run waits for the order to start it.

    Raises:
        UsageError: The model cannot be asked, or there is no such language.
    """

    def __init__(
        self,
        options: RunOptions,
        policy: ConversationPolicy,
        prepared: PreparedRun,
        config: RunConfig,
        *,
        waits: bool,
    ) -> None:
        self._options, self._policy = options, policy
        self._is_typed_at = self._is_watched = False
        self.earlier: tuple[TalkLine, ...] = ()
        """What was talked in the process that this one resumes."""
        self._has_doors = False
        self._closing = ExitStack()
        self._is_alone = options.node is None and not options.ros_args
        """No node serves the run; one that does has this run alone."""
        identity = _identity(prepared)
        self._name = prepared.robot.name if prepared.robot is not None else ""
        words = RobotWords(self._name)
        if identity is not None:
            words = RobotWords(self._name, identity.first_sentence, _build(identity))
        self._runs = TalkRuns(config, waits=waits, is_reachable=lambda: self._is_reachable)
        settings = settings_of(policy, [prepared.mission])
        self._agent = ConversationalAgent(
            settings,
            model=_model(options, prepared, identity),
            robot=words,
            library=identity.library if identity is not None else None,
            start=self._runs.order if self._is_alone else None,
            likeness=likeness_in(settings.language),
        )

    def run(self, prepared: PreparedRun, doors: Iterable[TalkDoor], voice: VoiceDoor | None) -> None:
        """Begin to talk about the first run.

        Args:
            prepared: The run.
            doors: Where text is shown; the topics are opened here.
            voice: The microphone and the speaker, which run; None: there are none.

        Raises:
            UsageError: The profile's topics have no robot.
            ConnectorError: The robot's connector cannot carry the messages of `/conversation/hri`.
        """
        agent = self._agent
        for door in doors:
            agent.add_door(door)
        if voice is not None:
            self._has_doors = True
            agent.add_door(voice)
        topics = self._add_topics(prepared) if self._policy.hri else None
        self._runs.begin(prepared)
        agent.attach(prepared.runner, prepared.journal)
        if prepared.plan.resumed is not None:
            notes = prepared.plan.resumed.record.notes()
            self.earlier = earlier_lines(notes)
            agent.continue_after(max((line.number for line in self.earlier), default=0))
            agent.report_lost(waiting_requests(notes))
        agent.run()
        if topics is not None:
            try:
                topics.open(agent.receive)
            except ConnectorError as fault:
                raise ConnectorError(f"the profile, /conversation/hri: {fault}") from None

    def _add_topics(self, prepared: PreparedRun) -> HRIDoor:
        """The door of messages on topics, which is not open yet."""
        from rai_missions.agents.talk.hri_door import HRIDoor
        from rai_missions.connectors.hri.connector import HRIConnector

        connector = prepared.connector
        if connector is None:
            raise UsageError('the profile\'s "hri" needs a robot that is reached over a connector; drop it')
        if not connector.running:
            connector.start()
            prepared.closing.closes(connector.stop)
        hri = HRIConnector(connector)
        door = HRIDoor(hri, self._name, below=self._policy.hri_below, is_stop=self._agent.reception.is_stop)
        self._has_doors = True
        self._agent.add_door(door)
        self._closing.callback(door.close)
        return door

    # -- where people talk ---------------------------------------------------------------------------------------

    def reach(self, *, is_typed_at: bool, is_watched: bool) -> None:
        """Where a sentence may come from."""
        self._is_typed_at, self._is_watched = is_typed_at, is_watched

    @property
    def take(self) -> TakesSentence:
        """What takes a sentence, by whatever door."""
        return self._agent.receive

    def type(self, text: str, waited_s: float) -> str:
        """A line that is written on the terminal, and how long ago it came; why it is not taken, or empty."""
        return self._agent.receive(text, role="operator", channel="terminal", waited_s=waited_s)

    def wait_answered(self) -> None:
        """Wait until what was taken is answered, or for as long as an answer may take that needs no model."""
        self._agent.wait_answered(ANSWERED_S)

    def typed_to_the_end(self) -> None:
        """Nothing more is typed; where there is no other door, a run that waits for an order ends."""
        self._is_typed_at = False
        if not self._is_reachable:
            self._agent.reception.after_all(self._runs.give_up)
            self._agent.reception.after_all(self._agent.decide_nothing)

    def receive(self, text: str, author: str, role: Role) -> str:
        """A sentence that is written on the page, whose token has a role."""
        return self._agent.receive(text, role=role, channel="page", author=author)

    def is_stop(self, text: str) -> bool:
        """Whether it is an order to stop."""
        return self._agent.reception.is_stop(text)

    @cached_property
    def ear(self) -> PageEar:
        """Who listens to the page's microphone."""
        from rai_missions.agents.talk.page_ear import PageEar
        from rai_missions.voice.setup import ListenNames

        names = ListenNames(self._options.recogniser, echo=False)
        ear = PageEar(self._agent.receive, language=self._policy.language, names=names)
        self._closing.callback(ear.stop)
        return ear

    def doors_changed(self) -> None:
        """Someone has come to the page, or has gone."""
        self._agent.doors_changed()

    @property
    def _is_reachable(self) -> bool:
        """Whether an order may still come from somewhere."""
        return self._is_typed_at or self._is_watched or self._has_doors or not self._is_alone

    # -- one run after the other ---------------------------------------------------------------------------------

    def step(self, step: Step) -> None:
        """The run has made a step."""
        self._agent.step(step)

    def changed(self, status: Status) -> None:
        """The run's status has changed."""
        self._agent.changed(status)
        self._runs.changed()

    def follow(self, prepared: PreparedRun, result: Result) -> PreparedRun | None:
        """A run is over: the one that follows, attached and ready; None: no other does, and there is no more talk.

        Args:
            prepared: The run.
            result: How it ended.
        """
        agent, runs = self._agent, self._runs
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

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """The first interrupt cancels the run that there is and has no other follow, the second is an e-stop."""

        def interrupt(by: str) -> None:
            self._runs.interrupt(by)
            self._agent.end_starts()

        with on_interrupts(interrupt, self.kill):
            yield

    def kill(self, by: str) -> None:
        """An e-stop: the run that there is ends at once, and no other follows; from any thread."""
        self._runs.kill(by)
        self._agent.end_starts()

    def close(self) -> None:
        """Talk no more; closed already, nothing happens."""
        self._runs.close()
        self._agent.stop()
        with suppress(MissionError):
            self._closing.close()


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
