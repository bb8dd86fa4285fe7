# SPDX-License-Identifier: Apache-2.0
"""How fast a robot answers while a real mission runs: questions of state by rule, a typed stop, with a hanging model.

The tractor drives in the simulated orchard at the wall's speed; a person asks, and asks again once it was answered.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path

from langchain_core.callbacks import CallbackManagerForLLMRun
from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, BaseMessage
from langchain_core.outputs import ChatGeneration, ChatResult

from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.agents.talk.model import TalkModel
from rai_missions.engine.step import Step
from rai_missions.runtime.lifecycle import Status

TRACTOR = Path(__file__).parents[1] / "missions/tractor"
QUESTIONS = ("what are you doing?", "how far are you?", "what is the battery level?", "why did you stop?")
COUNT = 200


class Hangs(BaseChatModel):
    """Answers after a minute."""

    @property
    def _llm_type(self) -> str:
        return "hangs"

    def _generate(
        self, messages: list[BaseMessage], stop: list[str] | None = None,
        run_manager: CallbackManagerForLLMRun | None = None, **words: object,
    ) -> ChatResult:  # fmt: skip
        threading.Event().wait(60.0)
        return ChatResult(generations=[ChatGeneration(message=AIMessage("late"))])


class Asker:
    """Asks, and measures until the robot's next line is there."""

    def __init__(self) -> None:
        self.answered = threading.Event()

    def show(self, line: TalkLine) -> None:
        if line.by == "robot" and not line.report:
            self.answered.set()

    def ask(self, agent: ConversationalAgent, text: str) -> float:
        self.answered.clear()
        began = time.perf_counter()
        while agent.receive(text, role="operator", channel="terminal"):  # no person asks so fast
            threading.Event().wait(0.1)
            began = time.perf_counter()
        assert self.answered.wait(10.0), text
        return time.perf_counter() - began


def quantile(values: Sequence[float], part: float) -> float:
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


def shown(name: str, values: Sequence[float]) -> None:
    p50, p95, p99 = (1000 * quantile(values, part) for part in (0.5, 0.95, 0.99))
    print(f"{name:<58} n={len(values):<4} p50 {p50:7.1f} ms  p95 {p95:7.1f} ms  p99 {p99:7.1f} ms")


def main() -> None:
    asker, paused, at = Asker(), threading.Event(), [0.0]
    agent = ConversationalAgent(doors=[TextDoor("terminal", asker.show)], model=TalkModel(Hangs()))

    def stepped(step: Step) -> None:
        agent.step(step)
        if step.event.name == "stop":
            at[0] = time.perf_counter()
            paused.set()

    def changed(status: Status) -> None:
        agent.changed(status)

    config = RunConfig(
        TRACTOR / "mission.json", TRACTOR / "robot.sim.json", speed=1.0, on_step=stepped, on_status=changed
    )
    with prepare(config) as prepared:
        agent.attach(prepared.runner, prepared.journal)
        agent.run()
        run = threading.Thread(target=prepared.runner.run, daemon=True)
        run.start()
        while prepared.runner.view.mode != "running":
            threading.Event().wait(0.01)
        shown("question of state, by rule", [asker.ask(agent, QUESTIONS[n % 4]) for n in range(COUNT)])
        for text in ("please make up a song", "and a poem", "and a play"):
            agent.receive(text, role="operator", channel="terminal")
        shown("the same, while a model hangs", [asker.ask(agent, QUESTIONS[n % 4]) for n in range(COUNT)])
        stops = []
        for _ in range(20):
            paused.clear()
            began = time.perf_counter()
            agent.receive("stop", role="operator", channel="terminal")
            assert paused.wait(10.0)
            stops.append(at[0] - began)
            asker.ask(agent, "resume")
        shown("typed 'stop' to the step that pauses and cancels", stops)
        prepared.runner.kill("benchmark")
        run.join(10.0)
        agent.stop()


if __name__ == "__main__":
    main()
