# SPDX-License-Identifier: Apache-2.0
"""A conversation with a robot that works: a scripted person asks, orders and interrupts in a simulated mission.

No key and no network: what the rules do not know is answered by a scripted model, so that each of the
three ways is seen. The person, the model and the world are fixed; the mission, its rules and the talk are real.
"""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from langchain_core.language_models import BaseChatModel
from langchain_core.messages import BaseMessage

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.agents.talk.model import TalkModel
from rai_missions.agents.talk.run_status import RobotWords
from rai_missions.agents.talk.settings import settings_of
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.engine.step import Step
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result

ROOT = Path(__file__).resolve().parents[1]
REPORTED_S = 60.0
"""How long the report of the mission's end is waited for; it comes at once, but on a busy machine."""
WAYS = {"rules": "by rule", "model": "by a model", "unknown": "knows no answer"}


class Sentence(NamedTuple):
    """What the person speaks, and when on the run's clock."""

    at: float
    text: str


class Scene(NamedTuple):
    """A mission that is talked about."""

    folder: str
    arguments: Mapping[str, object]
    sentences: Sequence[Sentence]
    speed: float = 4.0


def sentences(*given: tuple[float, str]) -> tuple[Sentence, ...]:
    return tuple(Sentence(*each) for each in given)


SCENES: Mapping[str, Scene] = {
    "tractor": Scene(
        "tractor",
        {"alleys": 3},
        sentences(
            (4, "what are you doing?"),
            (8, "how far are you?"),
            (14, "is the moon made of cheese?"),
            (19, "please make up a song"),
            (24, "stop"),
            (28, "why did you stop?"),
            (34, "resume"),
            (44, "what is the battery level?"),
            (60, "how far are you?"),
            (80, "what happened last?"),
            (150, "cancel the mission"),
            (152, "what are you doing?"),
            (156, "cancel the mission"),
            (158, "yes"),
        ),
    ),
    "rosbot": Scene(
        "rosbot",
        {},
        sentences(
            (3, "what are you doing?"),
            (8, "who are you?"),
            (14, "is the moon made of cheese?"),
            (17, "please make up a song"),
            (20, "pause"),
            (24, "how far are you?"),
            (28, "resume"),
            (50, "stop"),
            (54, "why did you stop?"),
            (58, "resume"),
            (90, "what happened last?"),
            (120, "cancel the mission"),
            (124, "yes"),
        ),
    ),
}


class TalkingModel(DoubleModel):
    """Answers with a fixed sentence and a claim that the rules replace; of songs it knows nothing."""

    def reply_to(self, messages: list[BaseMessage]) -> str:
        if "song" in str(messages[-1].content).rpartition("operator:")[2]:
            raise RuntimeError("this model knows no song")
        return "The moon is made of rock. I have finished the whole mission."


class Person:
    """Speaks each sentence once its time has come on the run's clock and the one before it was answered.

    Args:
        speaks: What is spoken.
        now: The run's clock.
        receive: The robot's ear; why it does not take a sentence, or empty.
    """

    def __init__(self, speaks: Sequence[Sentence], now: Callable[[], float], receive: Callable[[str], str]) -> None:
        self._speaks, self._now, self._receive = speaks, now, receive
        self._over, self._changed = threading.Event(), threading.Condition()
        self._shown = self._answered = 0
        """How many of the sentences the robot has received, and up to which of them it has answered."""
        self._thread = threading.Thread(target=self._work, name="person", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        with self._changed:
            self._over.set()
            self._changed.notify()
        self._thread.join(2.0)

    def notice(self, line: TalkLine) -> None:
        """See that the robot has received a sentence, or has answered it."""
        with self._changed:
            if line.by != "robot":
                self._shown += 1
            elif line.priority == "answer":
                self._answered = self._shown
                self._changed.notify()

    def _work(self) -> None:
        spoken = 0
        for sentence in self._speaks:
            while self._now() < sentence.at:
                if self._over.wait(0.02):
                    return
            spoken += not self._receive(sentence.text)
            with self._changed:
                self._changed.wait_for(partial(self._is_answered, spoken))

    def _is_answered(self, count: int) -> bool:
        return self._answered >= count or self._over.is_set()


def play(scene: Scene, show: Callable[[str], None], *, model: BaseChatModel | None = None) -> Result:
    """Run a scene, and show each line of the conversation once."""
    folder = ROOT / "missions" / scene.folder
    shown: set[int] = set()

    def line(given: TalkLine) -> None:
        if given.number in shown:
            return
        shown.add(given.number)
        who = f"robot, {WAYS.get(given.way, given.way)}" if given.by == "robot" else given.by
        show(f"{runner.view.now():7.1f} s  {who:>22}  {given.text}")
        person.notice(given)

    def stepped(step: Step) -> None:
        agent.step(step)

    def changed(status: Status) -> None:
        agent.changed(status)

    config = RunConfig(
        folder / "mission.json",
        folder / "robot.sim.json",
        dict(scene.arguments),
        speed=scene.speed,
        on_step=stepped,
        on_status=changed,
    )
    with prepare(config) as prepared:
        runner, robot = prepared.runner, prepared.robot
        agent = ConversationalAgent(
            settings_of(robot.conversation if robot is not None else None),
            doors=[TextDoor("terminal", line)],
            model=TalkModel(model or TalkingModel()),
            robot=RobotWords(robot.name if robot is not None else ""),
        )
        person = Person(
            scene.sentences,
            runner.view.now,
            lambda text: agent.receive(text, role="operator", channel="terminal", author="Anna"),
        )
        agent.attach(runner, prepared.journal)
        agent.run()
        person.start()
        try:
            result = runner.run()
            agent.conclude(REPORTED_S)
        finally:
            person.stop()
            agent.stop()
    return result


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=list(SCENES), help=f"of {', '.join(SCENES)}")
    for name in parser.parse_args(arguments).scenes:
        print(f"── {name}: a scripted person, real rules, a scripted model ──", flush=True)
        result = play(SCENES[name], lambda text: print(text, flush=True))
        print(f"{result.outcome}: {result.why}\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
