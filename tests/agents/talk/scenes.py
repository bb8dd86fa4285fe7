# SPDX-License-Identifier: Apache-2.0
"""A conversation about a run on the rig, with a door that keeps what is shown, and models that behave badly."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, BaseMessage

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.talk.doors import TalkDoor, TalkLine, TextDoor
from rai_missions.agents.talk.model import TalkModel
from rai_missions.agents.talk.run_status import RobotWords
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.conversation import Settings
from rai_missions.embodiment import Library
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.event import Role
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result
from tests.rigs.journals import MemoryJournal
from tests.rigs.runs import Rig

PATIENCE_S = 20.0
SETTINGS, NO_NAMES = Settings(), RobotWords()


class Screen:
    """Shows lines, and waits for one."""

    def __init__(self) -> None:
        self.lines: dict[int, TalkLine] = {}
        self.every: list[TalkLine] = []
        """Each line as often as it was shown."""
        self.is_open = True
        self._changed = threading.Condition()

    def show(self, line: TalkLine) -> None:
        with self._changed:
            self.lines[line.number] = line
            self.every.append(line)
            self._changed.notify_all()

    def of_robot(self) -> list[TalkLine]:
        return [line for line in tuple(self.lines.values()) if line.by == "robot"]

    def texts(self) -> list[str]:
        return [line.text for line in self.of_robot()]

    def until(self, holds: Callable[[TalkLine], bool]) -> TalkLine:
        """The first line of the robot's for which this holds."""

        def found() -> TalkLine | None:
            return next((line for line in self.of_robot() if holds(line)), None)

        with self._changed:
            assert self._changed.wait_for(lambda: found() is not None, PATIENCE_S), self.texts()
        line = found()
        assert line is not None
        return line


def settle(agent: ConversationalAgent) -> None:
    """Wait until a conversation has done all that follows: what is spoken, its end, a look at the doors after that."""
    for _ in range(3):
        agent.wait_answered(PATIENCE_S)


class HeldOpen:
    """The operator, who is met by talk."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """The conversation answers."""

    def withdraw(self, number: int) -> None:
        """It sees that."""


class Book(MemoryJournal):
    """A journal in memory that keeps what its notes have for programs."""

    def __init__(self) -> None:
        super().__init__()
        self.data: list[Any] = []

    def note(self, text: str, data: Any = None) -> int:
        self.data.append(data)
        return super().note(text, data)


class Talk:
    """A run on the rig, and the conversation about it."""

    def __init__(
        self,
        given: Mission | Mapping[str, Any],
        *,
        model: Any = None,
        library: Library | None = None,
        settings: Settings = SETTINGS,
        doors: Sequence[TalkDoor] = (),
        names: RobotWords = NO_NAMES,
        **words: Any,
    ) -> None:
        self.screen = Screen()
        door = TextDoor("terminal", self.screen.show, lambda: self.screen.is_open)
        model = TalkModel(model) if isinstance(model, BaseChatModel) else model
        self.agent = ConversationalAgent(settings, doors=[door, *doors], model=model, library=library, robot=names)
        self.steps: list[Step] = []
        self.mode = "ready"
        """The run's mode, as the conversation knows it for what it receives from now on."""
        words.setdefault("answerers", {"operator": HeldOpen()})
        self.book: Any = words.pop("journal", None) or Book()
        self.rig = Rig(given, journal=self.book, on_step=self._step, on_status=self._changed, **words)  # type: ignore[arg-type]
        self.agent.attach(self.rig.runner, self.book)
        self.agent.run()
        self.result: Result | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _step(self, step: Step) -> None:
        self.agent.step(step)
        self.steps.append(step)

    def _changed(self, status: Status) -> None:
        self.agent.changed(status)
        self.mode = status.mode

    def _run(self) -> None:
        self.result = self.rig.run()

    def __enter__(self) -> Talk:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread.is_alive():
            self.rig.runner.kill()
        self._thread.join(PATIENCE_S)
        self.agent.stop()

    def order(self, text: str, role: Role = "operator", author: str = "Anna") -> None:
        assert self.agent.receive(text, role=role, channel="terminal", author=author) == ""

    def ask(self, text: str, role: Role = "operator") -> TalkLine:
        """A sentence, and the robot's next line once what came before is answered."""
        settle(self.agent)
        before = len(self.screen.of_robot())
        self.order(text, role)
        return self.screen.until(lambda line: self.screen.of_robot().index(line) >= before)

    def order_to_confirm(self, text: str, author: str = "Anna") -> None:
        """An order that is read back by now; a report may have come first."""
        self.order(text, author=author)
        self.screen.until(lambda line: "Is that right?" in line.text)

    def end(self) -> Result:
        self._thread.join(PATIENCE_S)
        assert self.result is not None
        return self.result

    def talk(self) -> list[Mapping[str, Any]]:
        """The rows of talk in the journal."""
        return [row for data in self.book.data if isinstance(data, Mapping) for row in data.get("talk", [])]

    def until(self, holds: Callable[[], object]) -> None:
        """Wait for what another thread does."""
        end = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end, self.screen.texts()
            threading.Event().wait(0.002)


class RepliesModel(DoubleModel):
    """Replies with what it was given, in plain text, or does something worse first."""

    reply: str = "I have finished the mission and all is well."
    before: Any = None
    calls: tuple[dict[str, Any], ...] = ()

    def bind_tools(self, tools: Any, **words: Any) -> Any:
        if not self.calls:
            raise NotImplementedError
        return self

    def reply_to(self, messages: list[BaseMessage]) -> AIMessage:
        if self.before is not None:
            self.before()
        return AIMessage(self.reply, tool_calls=list(self.calls))
