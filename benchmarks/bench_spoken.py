# SPDX-License-Identifier: Apache-2.0
"""From the end of speech to an answer in sound, and from a spoken "stop" to a robot at standstill, part by part.

`python -m benchmarks.bench_spoken [answers | filler | stop …] [--count N]`. The robot patrols the simulated house at
the wall's speed; a person speaks by flite into a simulated room. All that is loaded shares the cores: the house, the
mission, the recognisers and the voice. The figures are those of the wall's clock, so other load falsifies them.
"""

from __future__ import annotations

import argparse
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from langchain_core.language_models import BaseChatModel

from benchmarks.slow_model import SlowModel
from rai_missions.agents.conversation import ConversationalAgent
from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.agents.talk.model import TalkModel
from rai_missions.agents.talk.voice_door import VoiceDoor
from rai_missions.connectors.sound.connector import RATE_HZ, SILENCE, SoundFrame
from rai_missions.connectors.sound.room import RoomSound
from rai_missions.engine.step import Step
from rai_missions.mission.files import load
from rai_missions.voice.setup import ListenNames
from rai_missions.voice.voices.flite import Flite

HOUSE = Path(__file__).parents[1] / "missions/rosbot"
SPEAKERS = ("slt", "rms", "awb")
QUESTIONS = ("What are you doing?", "How far are you?", "What is the battery level?", "Why did you stop?")
ROUNDS = 20
"""How often the patrol visits its waypoints: it lasts longer than any section."""
RECOGNISER = os.environ.get("RECOGNISER", "whisper")
"""The first recogniser, with its options: `whisper:weights=base`."""
DRIVES_MPS, STILL_MPS = 0.2, 0.02


class Talk:
    """A person and a robot in one room; what happened last, on the wall's clock."""

    def __init__(self, agent: ConversationalAgent) -> None:
        self.room = RoomSound(echo_db=None, paced=True)
        self.agent = agent
        self.door = VoiceDoor(self.room, self._receive, names=ListenNames(RECOGNISER))
        self.transcribed, self.sounded, self.stepped = (threading.Event() for _ in range(3))
        self.at = {"transcribed": 0.0, "sounded": 0.0, "stepped": 0.0}
        self.world: Any = None
        """The simulated house."""
        agent.add_door(self.door)
        self.room.listen(self._frame)

    def happened(self, what: str) -> None:
        event: threading.Event = getattr(self, what)
        if not event.is_set():
            self.at[what] = time.monotonic()
            event.set()

    def _receive(self, text: str, **words: object) -> str:
        self.happened("transcribed")
        return self.agent.receive(text, **words)  # type: ignore[arg-type]

    def _frame(self, frame: SoundFrame) -> None:
        if frame.played != SILENCE:
            self.happened("sounded")

    def step(self, step: Step) -> None:
        self.agent.step(step)
        if step.event.name == "stop":
            self.happened("stepped")

    @property
    def speed(self) -> float:
        """The base's in truth, m/s and rad/s together: odometry comes five times a second."""
        pose = self.world.pose
        return float(abs(pose.speed) + abs(pose.turn))

    def speak(self, text: str, speaker: str) -> float:
        """A person speaks; when the sentence will have ended."""
        sound = b"".join(Flite(speaker).speak(text))
        loud = np.nonzero(np.abs(np.frombuffer(sound, "<i2").astype(int)) > 200)[0]
        wait_for(lambda: not self.door.speech.speaking)
        threading.Event().wait(0.8)
        for name in self.at:
            getattr(self, name).clear()
        self.room.person_speaks(sound)
        return time.monotonic() + float(loud[-1]) / RATE_HZ


def wait_for(holds: Callable[[], bool], within_s: float = 60.0, *, look_s: float = 0.02) -> bool:
    end = time.monotonic() + within_s
    while not (held := holds()) and time.monotonic() < end:
        threading.Event().wait(look_s)
    return held


@contextmanager
def talking(model: BaseChatModel | None = None) -> Iterator[Talk]:
    agent = ConversationalAgent(model=TalkModel(model) if model is not None else None)
    talk = Talk(agent)
    mission = load(HOUSE / "mission.json")
    waypoints = mission.blackboard["waypoints"].initial
    assert isinstance(waypoints, Sequence)
    config = RunConfig(
        mission,
        HOUSE / "robot.sim.json",
        arguments={"waypoints": [*waypoints] * ROUNDS},
        speed=1.0,
        on_step=talk.step,
        on_status=agent.changed,
    )
    with prepare(config) as prepared:
        agent.attach(prepared.runner, prepared.journal)
        agent.run()
        talk.door.run()
        run = threading.Thread(target=prepared.runner.run, daemon=True)
        run.start()
        talk.world = prepared.world
        wait_for(lambda: prepared.runner.view.mode == "running")
        try:
            yield talk
        finally:
            prepared.runner.cancel()
            run.join(10.0)
            talk.door.stop()
            agent.stop()


def shown(name: str, values: Sequence[float]) -> None:
    if not values:
        print(f"  {name:<52} none", flush=True)
        return
    p50, p95 = np.percentile(np.array(values), (50, 95))
    print(f"  {name:<52} n={len(values):<3} p50 {p50:5.2f} s  p95 {p95:5.2f} s", flush=True)


def answers(count: int, texts: Sequence[str] = QUESTIONS, model: BaseChatModel | None = None) -> None:
    words, sounds, missed = list[float](), list[float](), 0
    with talking(model) as talk:
        for number in range(count):
            end = talk.speak(texts[number % len(texts)], SPEAKERS[number % len(SPEAKERS)])
            if not talk.sounded.wait(15.0):
                missed += 1
                continue
            words.append(talk.at["transcribed"] - end)
            sounds.append(talk.at["sounded"] - end)
    shown("end of speech to the transcript", words)
    shown("end of speech to the first audio", sounds)
    print(f"  {missed} of {count} without an answer", flush=True)


def filler(count: int) -> None:
    answers(count, ("Do mice like cheese?", "Who painted the ceiling?"), SlowModel(wait_s=3.0))


def stop(count: int) -> None:
    words, steps, stills, missed, unmoved = list[float](), list[float](), list[float](), 0, 0
    with talking() as talk:
        for number in range(count):
            if not wait_for(lambda: talk.speed > DRIVES_MPS):
                unmoved += 1
                continue
            end = talk.speak("Stop.", SPEAKERS[number % len(SPEAKERS)])
            if talk.stepped.wait(10.0) and wait_for(lambda: talk.speed < STILL_MPS, 10.0, look_s=0.005):
                still = time.monotonic()
                words.append(talk.at["transcribed"] - end)
                steps.append(talk.at["stepped"] - talk.at["transcribed"])
                stills.append(still - end)
            else:
                missed += 1
            talk.agent.receive("resume", role="operator", channel="terminal")
    shown('end of the spoken "stop" to its transcript', words)
    shown("transcript to the step that pauses and cancels", steps)
    shown('end of the spoken "stop" to a robot at standstill', stills)
    print(f"  {missed} of {count} not recognised; {unmoved} times the robot did not drive", flush=True)


SECTIONS: dict[str, Callable[[int], None]] = {"answers": answers, "filler": filler, "stop": stop}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sections", nargs="*", default=list(SECTIONS), help="which ones")
    parser.add_argument("--count", type=int, default=20, help="how many sentences each")
    given = parser.parse_args()
    for name in given.sections:
        print(f"{name}:", flush=True)
        SECTIONS[name](given.count)


if __name__ == "__main__":
    main()
