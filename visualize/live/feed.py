# SPDX-License-Identifier: Apache-2.0
"""Where steps come from: a run in this process, which leaves them in a queue and continues.

Rule: `step` runs on the engine's thread. It does no more than append, and wakes the server once however much there is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.step import Step
from visualize.live.scene import MOST_TALK, TAIL, RunScene

__all__ = ("Feed", "FollowedRun", "RunFeed")

MOST_WAITING = 512
"""Steps between the engine and the server; a server that falls behind looks again at the whole."""


class Feed(Protocol):
    """What a page follows. All of it is called on the server's loop."""

    async def begin(self, wake: Callable[[], None]) -> RunScene:
        """Someone watches: how it is, and `wake` (from any thread) once there is more."""

    async def take(self, scene: RunScene) -> RunScene:
        """Bring a scene up to date; a new one where what happened in between was not kept."""

    def end(self) -> None:
        """No one watches any more."""

    def closed(self) -> Mapping[int, Mapping[str, str]]:
        """Question → option → why it would be refused if it were taken now."""

    def now(self) -> float:
        """The run's clock."""


class FollowedRun(Protocol):
    """A run of this process, as its page looks at it; all of it is called from the page's thread."""

    def look(self) -> RunScene:
        """How the run is; at least as new as the step that the scene names."""

    def now(self) -> float:
        """Seconds on the run's clock."""

    def closed_options(self) -> Mapping[int, Mapping[str, str]]:
        """Question → option → why it would be refused if it were taken now."""

    def loose_goals(self) -> Sequence[OpenGoal]:
        """The goals that may still move the robot although nothing waits for them."""

    def awaited_facts(self) -> str:
        """The robot's keys that the run waits for, to start or to continue, in words; empty for none."""


class RunFeed:
    """Follows a run of this process.

    Args:
        run: Which one; after `renew` another.
    """

    def __init__(self, run: Callable[[], FollowedRun]) -> None:
        self._run = run
        self._waiting: deque[Step] = deque(maxlen=MOST_WAITING)
        self._past: deque[Step] = deque(maxlen=TAIL)
        self._wake: Callable[[], None] | None = None
        self._is_notified = self._is_renewed = False
        self._talk: deque[Mapping[str, Any]] = deque(maxlen=MOST_WAITING)
        self._spoken: dict[Any, Mapping[str, Any]] = {}
        """The last lines of the conversation, by number: for who comes later."""
        self._order: Step | None = None
        """What paused or ended the run last: for who comes later."""

    def step(self, step: Step) -> None:
        """The run has made a step; on its own thread."""
        if self._wake is not None:
            self._waiting.append(step)
            if not self._is_notified:
                self._is_notified = True
                self._wake()
        is_order = bool(step.outcome) or (step.event.kind == "command" and not step.refusal)
        if is_order and (self._order is None or not self._order.outcome):
            self._order = step
        if step.moves or step.effects or step.why:
            self._past.append(step)

    def renew(self) -> None:
        """Show another run from now on; called before its first step."""
        self._past.clear()
        self._order = None
        self._is_renewed = True
        self._notify()

    def look_again(self) -> None:
        """What is no part of a step has changed; from any thread."""
        self._notify()

    def talk(self, line: Mapping[str, Any]) -> None:
        """A line of the conversation; one of the same number replaces that. From any thread."""
        self._spoken[line.get("number")] = line
        while len(self._spoken) > MOST_TALK:
            self._spoken.pop(next(iter(tuple(self._spoken))), None)
        self._talk.append(line)
        self._notify()

    def _notify(self) -> None:
        if (wake := self._wake) is not None:
            wake()

    async def begin(self, wake: Callable[[], None]) -> RunScene:
        self._waiting.clear()
        self._talk.clear()
        self._is_notified, self._wake = False, wake
        return self._whole()

    async def take(self, scene: RunScene) -> RunScene:
        self._is_notified = False
        for _ in range(len(self._talk)):
            scene.add_talk(self._talk.popleft())
        if self._is_renewed:
            self._waiting.clear()
            return self._whole()
        while True:
            try:
                step = self._waiting.popleft()
            except IndexError:
                return self._outside_steps(scene)
            if step.seq > scene.seq + 1:
                self._waiting.clear()
                return self._whole()
            scene.take(step)

    def end(self) -> None:
        self._wake = None
        self._waiting.clear()

    def closed(self) -> Mapping[int, Mapping[str, str]]:
        return self._run().closed_options()

    def now(self) -> float:
        return self._run().now()

    def _whole(self) -> RunScene:
        self._is_renewed = False
        scene = self._run().look()
        for line in tuple(self._spoken.values()):
            scene.add_talk(line)
        self._outside_steps(scene)
        if self._order is not None:
            scene.recall_order(self._order)
        scene.recall(step for step in tuple(self._past) if step.seq <= scene.seq)
        return scene

    def _outside_steps(self, scene: RunScene) -> RunScene:
        """Bring up to date what no step holds."""
        run = self._run()
        scene.set_open_goals([goal.data() for goal in run.loose_goals()])
        scene.set_awaited_facts(run.awaited_facts())
        return scene
