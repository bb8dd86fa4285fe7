# SPDX-License-Identifier: Apache-2.0
"""Who is asked in a cell: rules, a constant, the oracle, a script or a model, each through its own answerer.

Rule: an answerer is asked as a run asks it. What a model's provider raised is known by its type, never by its words.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.answerers.rules import RulesAnswerer
from rai_missions.answerers.script import ScriptAnswerer
from rai_missions.campaign.cells import digest
from rai_missions.campaign.file import ANY_KIND, CONSTANT, CampaignFile
from rai_missions.campaign.records import BEST_FIRST
from rai_missions.engine.decision import Answerer, Question
from rai_missions.profile import Robot

if TYPE_CHECKING:
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.answerers.model.chat import Chat
    from rai_missions.campaign.embodiments import RobotView
    from rai_missions.campaign.questions import AskedScene
    from rai_missions.campaign.watched_chat import WatchedChat
    from rai_missions.keys import Key

__all__ = ("CampaignModels", "CellReply", "is_chat", "model_digest", "provider_of")

PATIENCE_S = 10.0
"""How much longer than its question's time an answer is waited for; a `DecisionAgent` gives up long before."""
MEMORY_GIB = 4.0
"""What the process of a model may be resident in; a file of weights that is larger gets more."""


class CellReply(NamedTuple):
    """What came of a question."""

    answer: Mapping[str, Any]
    """As `Answerer.ask` has it; `failed` where nothing came."""
    raised: str = ""
    """The type of what kept the model from being asked; empty where it was."""
    texts: tuple[str, ...] = ()
    """What the model wrote, as it came."""
    after_s: float = 0.0
    """Seconds after which the provider wants to be asked again, where it refused; 0: it gave none."""


def is_chat(model: str, file: CampaignFile) -> bool:
    """Whether a name is that of a chat model, which costs and may be limited."""
    return model not in ("rules", "oracle") and not model.startswith(CONSTANT) and model not in file.scripts


def provider_of(model: str) -> str:
    """The part of a model's name to which a rate applies."""
    return model.partition(":")[0]


def model_digest(model: str, file: CampaignFile, robot: Robot) -> str:
    """The digest of what an answerer's answers depend on beyond its name.

    Args:
        model: Its name.
        file: Has the scripts.
        robot: Has the rules.
    """
    if model == "rules":
        return digest({name: [each.written() for each in rules] for name, rules in robot.rules.items()})
    if model == "oracle":
        return digest(["oracle", file.labels])
    if model.startswith("local:"):
        path = Path(model.removeprefix("local:")).expanduser()
        return digest([path.name, path.stat().st_size if path.is_file() else 0])
    return digest(file.scripts.get(model, {}))


class CampaignModels:
    """The answerers of one worker; a context manager, which ends the processes of models.

    Args:
        file: Names the models, and has the scripts.
        robot: Has the rules.
        keys: The mission's keys.
        open_chat: From a model's name to the model; left out: a process of its own, as `run --model` has it.
    """

    def __init__(
        self,
        file: CampaignFile,
        robot: Robot,
        keys: Mapping[str, Key],
        *,
        open_chat: Callable[[str], Chat] | None = None,
    ) -> None:
        self._file, self._robot, self._keys = file, robot, keys
        self._open_chat = open_chat or _chat_process
        self._chats: dict[str, WatchedChat] = {}
        self._agents: dict[tuple[str, str], DecisionAgent] = {}
        self._closing = ExitStack()

    def __enter__(self) -> CampaignModels:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()

    def open(self, model: str, question: Question, embodiment: tuple[str, RobotView]) -> None:
        """Wait until a model can be asked, or is known to be absent; other answerers are always there.

        Args:
            model: Its name in the campaign.
            question: What it is to be asked.
            embodiment: As for `ask`.
        """
        if is_chat(model, self._file):
            self._agent(model, embodiment)[0].wait_until_open(question)

    def ask(
        self,
        model: str,
        question: Question,
        asked: AskedScene,
        *,
        labels: Mapping[str, str],
        embodiment: tuple[str, RobotView],
    ) -> CellReply:
        """Put a question to a model and wait for the answer.

        Args:
            model: Its name in the campaign.
            question: As the answerer is to see it.
            asked: Where it is asked: for rules, which look at what is known, and for scripts.
            labels: Option → verdict in the scene, for the oracle.
            embodiment: The name of the embodiment, and what it shows.

        Raises:
            UsageError: The model cannot be opened, as far as that is known without asking it.
        """
        if not is_chat(model, self._file):
            return CellReply(_at_once(self._answerer(model, question, asked, labels), question))
        chat, agent = self._agent(model, embodiment)
        chat.forget()
        if absent := chat.wait_until_open(question):
            return CellReply({"absent": absent}, chat.raised)
        answers: queue.SimpleQueue[Mapping[str, Any]] = queue.SimpleQueue()
        agent.ask(question, answers.put)
        try:
            answer = answers.get(timeout=max(0.0, question.until - question.at) + PATIENCE_S)
        except queue.Empty:
            agent.withdraw(question.number)
            answer = {"failed": "no answer"}
        if "option" in answer or not chat.raised:
            return CellReply(answer, texts=tuple(chat.texts))
        return CellReply(answer, chat.raised, tuple(chat.texts), chat.after_s)

    def _answerer(self, model: str, question: Question, asked: AskedScene, labels: Mapping[str, str]) -> Answerer:
        if model == "rules":
            return RulesAnswerer.of(self._robot, keys=self._keys, view=asked.chart.view)
        if model == "oracle":
            return ScriptAnswerer({question.state: [_best(question, labels)]})
        if model.startswith(CONSTANT):
            return ScriptAnswerer({question.state: [model.removeprefix(CONSTANT)]})
        script = self._file.scripts[model]
        kind = asked.scene.kind
        line: Any = script.get(kind, script.get(ANY_KIND, {"absent": f"no line for '{kind}'"}))
        return ScriptAnswerer({question.state: [line]})

    def _agent(self, model: str, embodiment: tuple[str, RobotView]) -> tuple[WatchedChat, DecisionAgent]:
        from rai_missions.answerers.model.agent import DecisionAgent
        from rai_missions.campaign.watched_chat import WatchedChat

        name, body = embodiment
        if model not in self._chats:
            chat = WatchedChat(self._open_chat(model))
            chat.open()
            self._closing.callback(chat.close)
            self._chats[model] = chat
        chat = self._chats[model]
        if (model, name) not in self._agents:
            agent = DecisionAgent(chat, body.identity, images="auto" if body.pictures else "no")
            self._closing.callback(agent.stop)
            self._agents[model, name] = agent
        return chat, self._agents[model, name]


def _at_once(answerer: Answerer, question: Question) -> Mapping[str, Any]:
    """The answer of one that answers before it returns."""
    answers: list[Mapping[str, Any]] = []
    answerer.ask(question, answers.append)
    return answers[0] if answers else {"failed": "no answer"}


def _best(question: Question, labels: Mapping[str, str]) -> str | Mapping[str, str]:
    """An offered option that is best by its label; of several, the first by name, in whatever order they are shown."""
    known = sorted(each.name for each in question.options if each.name in labels)
    lacking = {"absent": "no option that is offered has a label, by which the oracle chooses"}
    return min(known, key=lambda option: BEST_FIRST.index(labels[option])) if known else lacking


def _chat_process(model: str) -> Chat:
    """A model that is named, in a process of its own."""
    from rai_missions.answerers.model.process.model import ModelProcess
    from rai_missions.answerers.model.providers import check_model

    check_model(model, memory_gib=MEMORY_GIB)
    return ModelProcess(model, memory_gib=MEMORY_GIB, isolated=True)
