# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --talk`: what a run needs for a conversation, and the doors to it: the terminal, the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rai_missions.cli.speech_faults import SpeechFaults
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.profile import ConversationPolicy
from rai_missions.runtime.run_options import RunObserver

if TYPE_CHECKING:
    from rai_missions.agents.mission import PreparedRun, RunConfig
    from rai_missions.agents.talk.doors import TalkDoor, TextDoor
    from rai_missions.agents.talk.voice_door import VoiceDoor
    from rai_missions.cli.progress import Lines
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.cli.run.talk_session import TalkSession
    from rai_missions.engine.decision import Question
    from rai_missions.engine.step import Step
    from rai_missions.profile import Robot
    from rai_missions.runtime.lifecycle import Status

__all__ = ("HeldOpen", "TalkSetup", "normalise_voice_args", "talk_of", "talking")


class HeldOpen:
    """The operator, who is met by talk: a question stays open until the conversation, or a page, answers it."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Do nothing: the conversation speaks and shows the question."""

    def withdraw(self, number: int) -> None:
        """The conversation sees that it is open no more."""


class TalkSetup:
    """What a run is to be made of so that it can be talked about; then it opens the conversation.

    Args:
        options: The options of the command.
        config: What the run is made of.
        profile: The robot's; None where it has none.
    """

    def __init__(self, options: RunOptions, config: RunConfig, profile: Robot | None) -> None:
        self._options = options
        self._policy = (profile and profile.conversation) or ConversationPolicy()
        self._waits = self._policy.begins == "ready"
        self._session: TalkSession | None = None
        self._faults = SpeechFaults("run")
        self._voice = self._voice_door(options.voice) if options.voice is not None else None
        self.config = replace(
            config.observed_by(RunObserver(self._follow_step, self._follow_status)),
            waits=self._waits,
            operator=None if options.no_operator else HeldOpen(),
            speed=1.0 if config.speed is None and profile is not None and profile.world else config.speed,
        )
        """What the run is to be made of instead: at the wall's speed, since a person takes part."""

    def run(self) -> None:
        """Open the microphone and the speaker of this machine, where they are asked for.

        Raises:
            UsageError: No voice or recogniser can be opened.
            ConnectorError: There is no such device.
        """
        if self._voice is not None:
            self._voice.run()
            self._faults.begin()

    def open(self, prepared: PreparedRun, config: RunConfig, doors: list[TalkDoor]) -> TalkSession:
        """Begin to talk about a run that is prepared; see `TalkSession`."""
        from rai_missions.cli.run.talk_session import TalkSession

        self._session = TalkSession(self._options, self._policy, prepared, config, waits=self._waits)
        self._session.run(prepared, doors, self._voice)
        return self._session

    def close(self) -> None:
        """Talk no more; closed already, nothing happens."""
        if self._session is not None:
            self._session.close()
        if self._voice is not None:
            self._voice.stop()

    def _voice_door(self, voice: str) -> VoiceDoor:
        """The microphone and the speaker of this machine."""
        from rai_missions.agents.talk.voice_door import VoiceDoor
        from rai_missions.connectors.sound.devices import DeviceSound
        from rai_missions.voice.setup import ListenNames

        names = ListenNames(self._options.recogniser, wake_word=self._options.wake_word)
        return VoiceDoor(DeviceSound(), self._receive, names=names, voice=voice, on_fault=self._faults.take)

    def _receive(self, text: str, **words: Any) -> str:
        """A sentence that is spoken."""
        return self._session.take(text, **words) if self._session is not None else "the run is not prepared yet"

    def _follow_step(self, step: Step) -> None:
        if self._session is not None:
            self._session.step(step)

    def _follow_status(self, status: Status) -> None:
        if self._session is not None:
            self._session.changed(status)


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
        from rai_missions.voice.setup import ListenNames, check_names, split_options

        check_names(ListenNames(options.recogniser))
        known("voice", split_options(options.voice or "flite")[0])
    return options


@contextmanager
def talk_of(options: RunOptions, config: RunConfig) -> Iterator[TalkSetup | None]:
    """What the conversation of a run needs, if the options ask for one."""
    if not options.talk:
        yield None
        return
    config = _executed(config)
    setup = TalkSetup(options, config, _checked_profile(config))
    try:
        setup.run()
        yield setup
    finally:
        setup.close()


@contextmanager
def talking(
    setup: TalkSetup,
    prepared: PreparedRun,
    config: RunConfig,
    lines: Lines,
    page_door: Callable[[], TextDoor] | None,
) -> Iterator[TalkSession]:
    """The conversation, with its doors, while its runs last.

    Args:
        setup: What it needs.
        prepared: The first of its runs.
        config: What a run is made of.
        lines: Where the run is printed.
        page_door: Makes the door of the live page, where there is one.
    """
    from rai_missions.agents.talk.doors import TextDoor
    from rai_missions.cli.run.talk_terminal import TalkLines, TypedLines, open_typing

    doors: list[TalkDoor] = []
    if isinstance(lines, TalkLines):
        doors.append(TextDoor("terminal", lines.talk))
    if page_door is not None:
        doors.append(page_door())
    session = setup.open(prepared, config, doors)
    typing = None
    if isinstance(lines, TalkLines):
        to = TypedLines(
            session.type,
            lambda why: lines.remark(f"not taken: {why}"),
            session.typed_to_the_end,
            session.wait_answered,
        )
        typing = open_typing(to, lines.foot)
    session.reach(is_typed_at=typing is not None, is_watched=page_door is not None)
    if typing is not None:
        typing.start()
    try:
        with session.interruptible():
            yield session
    finally:
        if typing is not None:
            typing.stop()


def _executed(config: RunConfig) -> RunConfig:
    """A run, with its robot in Python executed, since how it talks is there; one that resumes has that in its journal.

    Raises:
        DefinitionError: The robot's file cannot be executed.
    """
    from rai_missions.profile import is_program, read_program

    if config.resume is not None or not is_program(config.robot):
        return config
    return replace(config, robot=read_program(str(config.robot)))


def _checked_profile(config: RunConfig) -> Robot | None:
    """The robot's profile, of a run that is resumed that of its journal; None where it has none.

    Raises:
        DefinitionError: What it states of talk is at fault.
    """
    from rai_missions.agents.run_plan import profile_of
    from rai_missions.agents.talk.settings import conversation_faults
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import RobotProgram, is_program
    from rai_missions.profile import profile_of as profile_of_program

    robot, mission = config.robot, config.mission if isinstance(config.mission, Mission) else None
    profile: Robot | None
    if config.resume is None and isinstance(robot, RobotProgram):
        profile = profile_of_program(robot.ready(), mission, robot)
    elif isinstance(robot, RobotProgram) or is_program(robot):
        profile = profile_of(replace(config, robot=None))
    else:
        profile = profile_of(config)
    if faults := conversation_faults(profile, mission) if profile else ():
        raise DefinitionError(faults, str(robot.file if isinstance(robot, RobotProgram) else robot or config.resume))
    return profile
