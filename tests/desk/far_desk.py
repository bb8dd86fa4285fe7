# SPDX-License-Identifier: Apache-2.0
"""A desk whose mission runs in another process, which is killed with SIGKILL while the arm lives on.

Rule: a life is killed from here, at an instant that a seed chooses; what it had sent by then may
arrive, and nothing more.
"""

from __future__ import annotations

import json
import os
import random
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal, NamedTuple

from rai_missions.connectors.connector import Close
from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds.desk.world import Desk
from tests.desk.onlooker import DeskVerdict, Onlooker

__all__ = ("Death", "FarDesk", "drawn_deaths")

ROOT = Path(__file__).parents[2]
GOALS = ("send_goal", "find_goal", "cancel_goal", "publish")
ALONE_S = (0.0, 0.0, 0.3, 2.0, 8.0, 40.0)
LONGEST_S = 600.0
"""Simulated; a run that takes longer does not end."""


class Death(NamedTuple):
    """When a life ends."""

    kind: Literal["any", "goal", "hand"]
    """What is counted: whatever is asked of the desk, what is asked of its servers, or steps with a thing in the
    hand."""
    nth: int
    when: Literal["before", "after", "later"]
    """Before it is carried out; after that, with the reply unsent; or some time after the reply."""
    later_s: float
    alone_s: float
    """How long the desk is alone then, simulated seconds."""


def drawn_deaths(rng: random.Random, most: int = 3) -> list[Death]:
    """How the lives of one run end."""
    found = []
    for _ in range(rng.randint(1, most)):
        kind: Any = rng.choice(("any", "goal", "hand", "hand"))
        nth = rng.randint(1, {"any": 400, "goal": 8, "hand": 60}[kind])
        when: Any = rng.choice(("before", "after", "later", "later"))
        found.append(Death(kind, nth, when, rng.uniform(0, 0.02), rng.choice(ALONE_S)))
    return found


class FarDesk:
    """A desk in this process, and lives of one run in others.

    Args:
        request: What is asked for.
        options: What the world takes.
        folder: Where the run's journal is.
    """

    def __init__(self, request: str, options: Mapping[str, Any], folder: Path) -> None:
        self.world = Desk(**{"camera": False, **options})
        self.onlooker = Onlooker(self.world)
        self.connector = LocalConnector(now=lambda: self.world.at)
        self.connector.start()
        self.world.open(self.onlooker.front(self.connector))
        self.journal = folder / "run.journal"
        self.errors = folder / "errors.txt"
        self.held_at_death: list[str] = []
        self._request = request

    def run(self, deaths: Sequence[Death], goal: Sequence[Mapping[str, Any]]) -> DeskVerdict:
        """One run, killed so, and then left alone to its end."""
        for death in (*deaths, None):
            if Life(self, death).is_over:
                break
            self.held_at_death.append(self.onlooker.truth.held)
            assert death is not None
            self.onlooker.is_alone = True
            for _ in range(round(death.alone_s / self.world.period_s)):
                self.onlooker.step()
            self.onlooker.is_alone = False
        return self.onlooker.verdict(self.journal, goal)

    @property
    def request(self) -> str:
        return self._request

    def close(self) -> None:
        self.connector.stop()
        self.world.close()


class Life:
    """One process, from its start to its end.

    Args:
        desk: Which it drives.
        death: How it ends; None: as it does by itself.
    """

    def __init__(self, desk: FarDesk, death: Death | None) -> None:
        self._desk, self._death = desk, death
        self._left = death.nth if death is not None else 0
        self._came: list[tuple[int, Any]] = []
        self._closes: list[Close] = []
        self._is_dead = False
        ours, theirs = socket.socketpair()
        with ours, desk.errors.open("ab") as errors:
            with theirs:
                words = ["-W", "ignore", "-m", "tests.desk.far_life", str(theirs.fileno()), str(desk.journal)]
                self._process = subprocess.Popen(
                    [sys.executable, *words], pass_fds=[theirs.fileno()], cwd=ROOT, env=dict(os.environ), stderr=errors
                )
            with ours.makefile("rw", encoding="utf-8") as lines:
                self._attend(lines)
        status = self._process.wait()
        for close in self._closes:
            close()
        assert self._is_dead or status == 0, desk.errors.read_text()
        self.is_over = not self._is_dead
        """It ended by itself, and with it the run."""

    def _attend(self, lines: Any) -> None:
        death = self._death
        for line in lines:
            wish = json.loads(line)
            is_due = death is not None and self._is_due(death, wish["do"])
            if death is not None and is_due and death.when == "before":
                self._kill()
                return
            reply = self._carry_out(wish)
            if death is not None and is_due and death.when == "after":
                self._kill()
                return
            self._reply(lines, reply)
            if death is not None and is_due:
                self._kill_later(lines, death.later_s)
                return

    def _is_due(self, death: Death, what: str) -> bool:
        if death.kind == "hand":
            counts = what == "step" and bool(self._desk.onlooker.truth.held)
        else:
            counts = death.kind == "any" or what in GOALS
        self._left -= counts
        return counts and self._left == 0

    def _kill(self) -> None:
        self._process.kill()
        self._is_dead = True

    def _kill_later(self, lines: Any, later_s: float) -> None:
        """Wait for its own next wish, and longer; what it had sent arrives."""
        try:
            self._process.wait(later_s)
        except subprocess.TimeoutExpired:
            self._kill()
        with suppress(ConnectionResetError):  # it died before it read a reply
            for line in lines:
                self._carry_out(json.loads(line))

    def _reply(self, lines: Any, value: Any) -> None:
        came, self._came = self._came, []
        try:
            lines.write(json.dumps({"at": self._desk.world.at, "came": came, "value": value}) + "\n")
            lines.flush()
        except BrokenPipeError:
            pass  # it has ended by itself, or is dead

    def _carry_out(self, wish: dict[str, Any]) -> Any:
        what, number = wish.pop("do"), wish.pop("number", -1)
        robot = self._desk.connector

        def on_message(each: Any) -> None:
            self._came.append((number, list(each)))

        if what == "hello":
            return {"period_s": self._desk.world.period_s, "request": self._desk.request}
        if what == "step":
            assert self._desk.world.at < LONGEST_S
            return self._desk.onlooker.step()
        if what == "subscribe":
            return self._closes.append(robot.subscribe(**wish, on_message=on_message))
        if what == "call":
            return robot.call(**wish, on_reply=on_message)
        if what in ("send_goal", "find_goal"):
            return getattr(robot, what)(**wish, on_report=on_message)
        return getattr(robot, what)(**wish)
