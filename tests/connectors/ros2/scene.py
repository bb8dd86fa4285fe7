# SPDX-License-Identifier: Apache-2.0
"""A mission whose states start goals on one action, over the real rclpy, and the laws that its run must keep.

Rule: the laws are read from two logs alone, the server's and the run's steps.
"""

from __future__ import annotations

import itertools
import signal
import threading
import uuid
from typing import Any

from rai_missions.connectors.contract import Inbox
from rai_missions.engine.step import StartGoal, Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.run_options import RunObserver
from rai_missions.runtime.runner import Runner
from tests.connectors.ros2.peer_process import FIBONACCI, Peer
from tests.connectors.ros2.scripted_server import PROGRAM, Script

__all__ = ("WINDOWS", "Scene", "ServerOnCall")

WINDOWS = ("at once", "asked", "runs", "over")
"""What is waited for before the next move: nothing, that the server was asked, that it pursues the goal, its end."""
HOLDS_S = 30.0
tokens = itertools.count(1)


def mission() -> Mission:
    """`left` and `right` pursue goals on the same action; `rest` pursues none."""
    go = [{"on": name, "to": name, "do": [{"set": "order", "from": "event.order"}]} for name in ("left", "right")]
    outcomes = ["succeeded", "failed", "rejected", "canceled", "timed_out"]
    pursuing = {
        "action": "move", "goal": {"order": {"from": "order"}}, "result": {"kept": "sequence"}, "cancel_s": 0.3,
        "timeout_s": 60, "transitions": [{"on": outcomes, "to": "rest"}],
    }  # fmt: skip
    return Mission.model_validate(
        {
            "format": 1,
            "name": "windows",
            "version": "1.0.0",
            "initial": "rest",
            "blackboard": {
                "order": {"type": "integer", "source": "mission", "initial": 0},
                "kept": {"type": "list", "source": "mission", "optional": True},
            },
            "events": {name: {} for name in ("left", "right", "halt", "enough")},
            "states": {"rest": {}, "left": pursuing, "right": pursuing, "done": {"final": "canceled"}},
            "transitions": [*go, {"on": "halt", "to": "rest"}, {"on": "enough", "to": "done"}],
        }
    )


class ServerOnCall:
    """The scripted server, which can be killed and started again; every life has a log of its own."""

    def __init__(self) -> None:
        self.name = f"scene_{uuid.uuid4().hex[:8]}"
        self.lives = [Peer(self.name, PROGRAM)]
        self.lives[0].__enter__()

    @property
    def lines(self) -> Inbox[Any]:
        return self.lives[-1].lines

    def kill(self) -> None:
        self.lives[-1].kill()

    def restart(self) -> None:
        self.lives.append(Peer(self.name, PROGRAM))
        self.lives[-1].__enter__()

    def freeze(self) -> None:
        self.lives[-1].signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self.lives[-1].signal(signal.SIGCONT)

    def close(self) -> None:
        for life in self.lives:
            life.__exit__()


class Scene:
    """One run of the mission against the server, and what is made to happen to it."""

    def __init__(self, connector: Any, server: ServerOnCall) -> None:
        self._server = server
        self.steps = Inbox[Step](HOLDS_S)
        self.tokens: list[int] = []
        robot = Robot.model_validate(
            {
                "name": "windows",
                "actions": {"move": {"action": f"/{server.name}/move", "type": FIBONACCI}},
                "events": {name: {"posted": True} for name in ("left", "right", "halt", "enough")},
            }
        )
        self._clock = WallClock()
        self._runner = Runner(
            mission(), robot=robot, connector=connector, clock=self._clock, observer=RunObserver(self.steps)
        )
        self._thread = threading.Thread(target=self._runner.run)
        self._thread.start()
        self.steps.wait(lambda steps: steps[-1].event.name == "start", "the run begins")  # what comes before is dropped

    def go(self, state: str, script: Script, window: str) -> int:
        """Enter a state that pursues a goal, and wait for a moment of the goal's life."""
        token = next(tokens)
        self.tokens.append(token)
        self.post(state, order=script.order(token))
        if window == "asked":
            self.wait_for(token, "asked", "runs", "over")
        elif window == "runs" or (window == "over" and script.end == "runs on" and script.cancel != "refused"):
            self.wait_for(token, "runs", "over")
        elif window == "over":
            self.wait_for(token, "over")
        return token

    def post(self, event: str, **data: Any) -> None:
        self._runner.post(Event(event, self._clock.now(), data))

    def wait_for(self, token: int, *words: str) -> None:
        """Wait until the server has reported one of these of a goal, or the run knows that it will not be asked."""
        came, is_there = threading.Event(), lambda: self._has_reported(token, words) or self._is_over(token)
        for _ in range(int(HOLDS_S / 0.01)):
            if is_there():
                return
            came.wait(0.01)
        raise AssertionError(f"goal {token} is not {words[0]}: {self.story()}")

    def wait_for_rest(self) -> None:
        """Wait until the run has the outcome of what it started, and is at rest."""
        self.steps.wait(lambda steps: _state_after(steps) == "rest", f"the run does not come to rest: {self.story()}")

    def end(self) -> None:
        """End the run; hold it to the laws, and the server to having no goal that is not over."""
        self.post("enough")
        self._thread.join(HOLDS_S)
        assert not self._thread.is_alive(), f"the run does not end: {self.story()}"
        self.check()
        self._server.lines.wait(
            lambda reported: all(["over", token] in [each[:2] for each in reported] for token in _asked(reported)),
            f"no goal runs that no state owns; {self.story()}",
        )

    def check(self) -> None:
        """Hold both logs to the laws; a goal that an earlier run has given up may come to the server at any time."""
        for log in self._logs():
            _one_after_the_other(log, self.story)
        _no_result_of_another(self.steps.all, self.story)
        _no_start_before_the_end(self.steps.all, self.story)

    def story(self) -> str:
        """Both logs, for the reader of a failure."""
        reported = self._logs()
        run = [
            (
                round(step.at, 3),
                step.event.kind,
                step.event.name,
                step.event.number,
                [(move.exited, move.entered) for move in step.moves],
                step.effects,
                step.notes,
            )
            for step in self.steps.all
        ]
        return f"\nserver: {reported}\nrun: " + "\n     ".join(map(str, run))

    def _has_reported(self, token: int, words: tuple[str, ...]) -> bool:
        return any(each[0] in words and each[1] == token for each in self._server.lines.all if len(each) > 1)

    def _logs(self) -> list[list[Any]]:
        """What each life of the server reported of this run's goals."""
        return [
            [each for each in life.lines.all if each[1:2] and each[1] in self.tokens] for life in self._server.lives
        ]

    def _is_over(self, token: int) -> bool:
        """The run has its outcome: it started the state's goal, or could not, and is back at rest."""
        steps = list(self.steps.all)
        reported = (at for at, step in enumerate(steps) if Script.read(step.event.data.get("order", 0))[0] == token)
        since = steps[next(reported, len(steps)) :]
        return "rest" in [state for step in since for move in step.moves for state in move.entered]


def _state_after(steps: list[Step]) -> str:
    entered = [state for step in steps for move in step.moves for state in move.entered]
    return entered[-1] if entered else ""


def _asked(lines: list[Any]) -> list[int]:
    return [each[1] for each in lines if each[0] == "asked"]


def _one_after_the_other(lines: list[Any], story: Any) -> None:
    """The server is asked for a goal only when every goal before it is over."""
    running: set[int] = set()
    for word, *rest in lines:
        if word == "asked":
            assert not running, f"goal {rest[0]} came while {running} ran{story()}"
            running.add(rest[0])
        elif word == "over":
            running.discard(rest[0])


def _no_result_of_another(steps: list[Step], story: Any) -> None:
    """A result that does anything is that of the last goal started in this visit of its owner, who is still active."""
    visits: dict[str, int] = {}
    active: set[str] = set()
    started: dict[int, tuple[str, int, int]] = {}
    newest: dict[str, int] = {}
    for step in steps:
        event = step.event
        is_moved = any(move.trigger == event.name for move in step.moves)  # else by an instant that was due before it
        if event.kind == "result" and (is_moved or step.writes):
            owner, visit, token = started[event.number]
            assert owner in active and visits[owner] == visit, f"{event} reached another visit of {owner}{story()}"
            assert newest[owner] == event.number, f"{event} reached another goal's state{story()}"
            written = dict(step.writes).get("kept", [token])
            assert list(written) == [token], f"{written} is the result of another goal than {token}{story()}"
        for move in step.moves:
            active -= set(move.exited)
            active |= set(move.entered)
            visits.update({state: visits.get(state, 0) + 1 for state in move.entered})
        for effect in step.effects:
            if isinstance(effect, StartGoal):
                token = Script.read(effect.goal["order"])[0]
                started[effect.number], newest[effect.owner] = (
                    (effect.owner, visits[effect.owner], token),
                    effect.number,
                )


def _no_start_before_the_end(steps: list[Step], story: Any) -> None:
    """In the run's own words: a goal is started only when the end of every earlier one was reported or given up."""
    open_goals: set[int] = set()
    for step in steps:
        if step.event.kind == "result":
            open_goals.discard(step.event.number)
        for note in step.notes:
            open_goals -= {number for number in open_goals if note.startswith(f"goal {number} ") and "orphaned" in note}
        for effect in step.effects:
            if isinstance(effect, StartGoal):
                assert not open_goals, f"goal {effect.number} was started while {open_goals} ran{story()}"
                open_goals.add(effect.number)
