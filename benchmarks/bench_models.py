# SPDX-License-Identifier: Apache-2.0
"""What a model's own process costs, and what it saves: `python -m benchmarks.bench_models`.

The way there and back: one question to a model that answers at once, on a thread of this process and in a process of
its own, without pictures and with one of 640x480. The e-stop, under the load of `bench_stop`, while the model
holds its interpreter's lock: in a process of its own, and, for half a second at a time, on a thread of the engine's.
"""

from __future__ import annotations

import ctypes
import os
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from benchmarks.bench_stop import ACTION, Server, loaded, pictures, print_times
from rai_missions.answerers.model.agent import DecisionAgent
from rai_missions.answerers.model.process.model import ModelProcess
from rai_missions.answerers.test_models import DoubleModel
from rai_missions.connectors.local import LocalConnector
from rai_missions.engine.decision import Evidence
from rai_missions.image import Image
from rai_missions.testing import QUESTION, ReplyCollector

QUESTIONS, STOPS = 300, 100
HELD_S = 0.5
PROVIDERS = str(Path(__file__).parents[1] / "tests" / "providers")


class Prompt(DoubleModel):
    """Answers at once."""

    def reply_to(self, messages: list[Any]) -> str:
        return '{"option": "replan", "why": "as it was asked to"}'


class Holding(DoubleModel):
    """Holds the interpreter's lock of its process, again and again."""

    def reply_to(self, messages: list[Any]) -> str:
        for _ in range(20):
            ctypes.PyDLL(None).usleep(int(1e6 * HELD_S))
        return ""


def exchanges(agent: DecisionAgent, picture: Image | None) -> list[float]:
    """Seconds from each question to its answer."""
    shown = (*QUESTION.evidence, Evidence("camera", picture, 0.1, fresh=True)) if picture else QUESTION.evidence
    spent = []
    for number in range(QUESTIONS + 5):
        answer = ReplyCollector()
        began = time.perf_counter()
        agent.ask(QUESTION._replace(number=number + 1, evidence=shown), answer)
        reply = answer.wait(30)
        spent.append(time.perf_counter() - began)
        assert reply["option"] == "replan", reply
    return spent[5:]


def there_and_back() -> None:
    noise = Image("camera@1", 640, 480, "rgb8", os.urandom(640 * 480 * 3))
    for name, picture in (("no picture", None), ("one of 640x480", noise)):
        medians = {}
        for place, model in (("on a thread", Prompt()), ("in a process", ModelProcess("hostile:answers:replan"))):
            agent = DecisionAgent(model, images="yes" if picture else "auto")
            agent.run()
            spent = sorted(exchanges(agent, picture))
            agent.stop()
            medians[place] = statistics.median(spent)
            late = spent[int(len(spent) * 0.99)]
            figures = f"median {1e3 * medians[place]:.2f} ms, p99 {1e3 * late:.2f} ms"
            print(f"{name}, {place:<14}{len(spent)} questions: {figures}")
        cost_s = medians["in a process"] - medians["on a thread"]
        print(f"{name}: the way there and back costs {1e3 * cost_s:.2f} ms", flush=True)


def stops(name: str, agent_of: Any, count: int) -> None:
    """E-stops while the model holds its lock."""
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            held = Path(folder) / f"held-{number}"
            agent = agent_of(held)
            agent.run()
            connector, server, ended = LocalConnector(), Server(), threading.Event()
            connector.start()
            connector.offer("/move", ACTION, server)
            runner, journal = loaded(connector, "local", Path(folder), number, ended, agent)
            run = threading.Thread(target=runner.run)
            run.start()
            server.moves.wait(30)
            threading.Thread(target=pictures, args=(connector, ended), daemon=True).start()
            until = time.monotonic() + 30
            while not held.exists() and time.monotonic() < until:
                time.sleep(0.02)
            time.sleep(0.05 + 0.0007 * (number % 50))
            began = time.perf_counter()
            runner.kill("the button")
            assert server.stopped.wait(60)
            spent.append(server.at - began)
            ended.set()
            run.join()
            journal.close()
            agent.stop()
    print_times(name, spent)


class Noting(Holding):
    """Notes that it begins to hold the lock."""

    file: str

    def reply_to(self, messages: list[Any]) -> str:
        Path(self.file).touch()
        return super().reply_to(messages)


def main() -> None:
    sys.path.insert(0, PROVIDERS)
    there_and_back()
    stops(
        "a lock held in a process of its own",
        lambda held: DecisionAgent(ModelProcess(f"hostile:holds_once:{held}")),
        STOPS,
    )
    stops("a lock held on a thread, 0.5 s each", lambda held: DecisionAgent(Noting(file=str(held))), 10)


if __name__ == "__main__":
    main()
