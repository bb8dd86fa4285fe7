# SPDX-License-Identifier: Apache-2.0
"""How fast a robot answers while a real mission runs, and how late the run's own steps are with and without talk.

The tractor drives in the simulated orchard at the wall's speed; a person asks, and asks again once it was answered. For
the lateness a mission on the wall's clock has a step due every 20 ms; silent runs and those with talk take turns, and
in the latter two persons ask questions of state as fast as a door takes them, while a model hangs. First, another
person asks what the robot's documents have, of which there is no index yet.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.slow_model import SlowModel
from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.agents.talk.doors import TalkLine, TextDoor
from rai_missions.agents.talk.model import TalkModel
from rai_missions.embodiment import Library
from rai_missions.engine.step import Step
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Status

TRACTOR = Path(__file__).parents[1] / "missions/tractor"
QUESTIONS = ("what are you doing?", "how far are you?", "what is the battery level?", "why did you stop?")
COUNT = 200


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


ROUND_S, ROUNDS, RUNS = 0.02, 250, 4
TIMED: dict[str, Any] = {
    "name": "timed",
    "initial": "even",
    "about": "step every 20 ms",
    "blackboard": {"rounds": {"type": "integer", "source": "mission", "initial": 0}},
    "states": {
        "even": {
            "transitions": [
                {"when": {"key": "rounds", ">=": ROUNDS}, "to": "over"},
                {"after_s": ROUND_S, "to": "odd"},
            ]
        },
        "odd": {"entry": [{"set": "rounds", "add": 1}], "transitions": [{"after_s": ROUND_S, "to": "even"}]},
        "over": {"final": "aborted"},
    },
}


def lateness(folder: Path, *, talks: bool) -> list[float]:
    """Seconds by which each step of a run was late, as the wall's clock has them when their effects are performed."""
    agent = ConversationalAgent(
        doors=[TextDoor("terminal", lambda line: None)], model=TalkModel(SlowModel(wait_s=60.0))
    )
    late, due, over = list[float](), [0.0], threading.Event()

    def stepped(step: Step) -> None:
        now = prepared.clock.now()
        if due[0] and step.moves:
            late.append(now - due[0])
        if step.moves:
            due[0] = step.at + ROUND_S
        if talks:
            agent.step(step)

    def chatter(number: int) -> None:
        while not over.wait(0.05):
            agent.receive(QUESTIONS[number], role="operator", channel=f"door{number}")

    journal = folder / f"{time.monotonic_ns()}.journal"
    config = RunConfig(
        Mission.model_validate(TIMED), journal=journal, on_step=stepped, on_status=agent.changed if talks else None
    )
    with prepare(config) as prepared:
        if talks:
            agent.attach(prepared.runner, prepared.journal)
            agent.run()
            agent.receive("please make up a song", role="operator", channel="terminal")
        threads = [threading.Thread(target=chatter, args=(number,)) for number in range(2 if talks else 0)]
        for thread in threads:
            thread.start()
        prepared.runner.run()
        over.set()
        for thread in threads:
            thread.join()
        agent.stop()
    return late


def side_by_side() -> None:
    """Silent runs and those with talk, in turns."""
    with TemporaryDirectory() as folder:
        silent, talked = list[float](), list[float]()
        for _ in range(RUNS):
            silent += lateness(Path(folder), talks=False)
            talked += lateness(Path(folder), talks=True)
    shown("a step's lateness, in a silent run", silent)
    shown("the same, while two persons ask and a model hangs", talked)
    print(f"{'p99 more with talk':<58} {1000 * (quantile(talked, 0.99) - quantile(silent, 0.99)):.1f} ms")


class Reader:
    """Asks what the documents have, again and again, at a door of its own."""

    def __init__(self) -> None:
        self.found = 0
        self._found_one, self._over = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    def show(self, line: TalkLine) -> None:
        if line.way == "documents":
            self.found += 1
            self._found_one.set()

    def begin(self, agent: ConversationalAgent) -> None:
        self._thread = threading.Thread(target=self._ask, args=(agent,))
        self._thread.start()

    def end(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()

    def _ask(self, agent: ConversationalAgent) -> None:
        while not self._over.is_set():
            self._found_one.clear()
            agent.receive("which tyre pressure is right?", role="person", channel="reader")
            self._found_one.wait(5.0)


def while_looked_up() -> None:
    """Questions of state, while the documents are indexed and looked up."""
    with TemporaryDirectory() as folder:
        asker, reader = Asker(), Reader()
        library = Library(TRACTOR / "identity", Path(folder) / "index")
        doors = [TextDoor("terminal", asker.show), TextDoor("reader", reader.show)]
        agent = ConversationalAgent(doors=doors, library=library)
        config = RunConfig(
            TRACTOR / "mission.json", TRACTOR / "robot.sim.json", speed=1.0, on_step=agent.step, on_status=agent.changed
        )
        with prepare(config) as prepared:
            agent.attach(prepared.runner, prepared.journal)
            agent.run()
            run = threading.Thread(target=prepared.runner.run, daemon=True)
            run.start()
            reader.begin(agent)
            times = [asker.ask(agent, QUESTIONS[n % 4]) for n in range(COUNT)]
            shown("question of state, while documents are looked up", times)
            print(f"{'the longest of them':<58} {1000 * max(times):.1f} ms; {reader.found} quotations meanwhile")
            reader.end()
            prepared.runner.kill("benchmark")
            run.join(10.0)
            agent.stop()


def main() -> None:
    while_looked_up()
    side_by_side()
    asker, paused, at = Asker(), threading.Event(), [0.0]
    agent = ConversationalAgent(doors=[TextDoor("terminal", asker.show)], model=TalkModel(SlowModel(wait_s=60.0)))

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
