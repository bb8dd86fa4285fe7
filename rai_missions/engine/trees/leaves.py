# SPDX-License-Identifier: Apache-2.0
"""The leaves of a compiled tree, and the decision: what they do is handed to the tick, never done here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Status
from rai_missions.engine.templates import FilledTemplate
from rai_missions.engine.trees.deadline import DeadlineNode
from rai_missions.engine.trees.node import FAILURE, INVALID, RUNNING, SUCCESS, CompiledNode
from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.view import Site, Test, View
from rai_missions.keys import Key, type_error

__all__ = (
    "CompiledActivity", "CompiledBehaviour", "CompiledCheck", "CompiledDecision", "CompiledPublish", "CompiledSet",
    "CompiledWait",
)  # fmt: skip


class CompiledCheck(CompiledNode):
    """Whether a guard is true; idle once it is known, until a key or the time that its guard depends on changes.

    Args:
        test: The guard.
        site: What it depends on.
        steady: It depends on nothing else.
    """

    __slots__ = ("quick", "steady", "test")

    def __init__(self, test: Test, site: Site, *, steady: bool) -> None:
        super().__init__()
        self.test, self.site, self.steady = test, site, steady
        self.quick = test if steady else None

    def tick(self, now: Tick) -> Status:
        status = SUCCESS if self.test(now.sight) is True else FAILURE
        if status is not self.status:
            self.status = status
            now.touched.append(self)
        self.idle = self.steady
        return status


class CompiledWait(DeadlineNode):
    """Runs for so many seconds.

    Args:
        wait_s: The seconds.
    """

    __slots__ = ("wait_s",)

    def __init__(self, wait_s: float) -> None:
        super().__init__()
        self.wait_s = wait_s

    def tick(self, now: Tick) -> Status:
        if self.status is not RUNNING:
            self.begin(now.sight.at + self.wait_s, now)
        status = SUCCESS if now.sight.at >= self.until else RUNNING
        self.idle = status is RUNNING
        return self.become(status, now)


class CompiledSet(CompiledNode):
    """Writes a key at each tick; fails where the value is unknown or does not fit.

    Args:
        key: Its name.
        definition: Its definition; None where the mission has none.
        value: What it is to be.
        site: What that depends on.
        adds: It adds to what is there.
    """

    __slots__ = ("adds", "definition", "key", "value")

    def __init__(
        self, key: str, definition: Key | None, value: Callable[[View], Any], site: Site, *, adds: bool
    ) -> None:
        super().__init__()
        self.key, self.definition, self.value, self.site, self.adds = key, definition, value, site, adds

    def tick(self, now: Tick) -> Status:
        value = self.value(now.sight)
        if value is None or (self.definition is not None and type_error(self.definition, value)):
            return self.become(FAILURE, now)
        now.write(self.key, value)
        return self.become(SUCCESS, now)

    @property
    def writes(self) -> tuple[str, ...]:  # type: ignore[override]
        """The one key that the leaf writes."""
        return (self.key,)

    @property
    def looks(self) -> bool:
        """What it adds to is its own affair, as long as there is something to add to."""
        return not self.adds or self.status is not SUCCESS


class CompiledPublish(CompiledNode):
    """Publishes a message at each tick.

    Args:
        topic: Its name.
        message: The message.
    """

    __slots__ = ("message", "topic")

    def __init__(self, topic: str, message: Callable[[View], FilledTemplate]) -> None:
        super().__init__()
        self.topic, self.message = topic, message

    def tick(self, now: Tick) -> Status:
        now.published.append((self.topic, self.message(now.sight)))
        return self.become(SUCCESS, now)


class CompiledActivity(CompiledNode):
    """An action or a call: the chart runs it, and this waits for what came of it; idle until then.

    Args:
        site: What it depends on when it begins.
    """

    __slots__ = ("refused", "run")
    role = "activity"

    def __init__(self, site: Site | None = None) -> None:
        super().__init__()
        self.site = site
        self.run = 0
        """How often it was started."""
        self.refused = False
        """It was rejected the last time: for want of what it is sent with, of a server, or of what it needs."""

    def tick(self, now: Tick) -> Status:
        if self.status is not RUNNING:
            self.run, self.refused = self.run + 1, False
            now.start(self.path)
            now.touched.append(self)
        status = self.report(now.take(self.path))
        self.idle = status is RUNNING
        return self.become(status, now)

    def report(self, outcome: str) -> Status:
        """The status that an outcome means; empty while there is none."""
        if not outcome:
            return RUNNING
        self.refused = outcome == "rejected"
        return SUCCESS if outcome == "succeeded" else FAILURE

    def stop(self, now: Tick) -> None:
        if self.status is RUNNING:
            now.end(self.path)
        super().stop(now)

    @property
    def awaited(self) -> bool:
        """The chart runs it and has not been asked to end it."""
        return self.status is RUNNING

    @property
    def looks(self) -> bool:
        """What an action or call was sent with makes no difference any more, unless it was refused for that."""
        return self.refused

    def memory(self) -> Mapping[str, Any] | None:
        if not self.run:
            return super().memory()
        kept = {"status": self.status, "run": self.run}
        return {**kept, "refused": True} if self.refused else kept

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.run, self.refused = memory.get("run", 0), memory.get("refused", False)


class CompiledBehaviour(CompiledActivity):
    """A live behaviour of the user's program that is ticked next to the mission: this reports what it reported last."""

    __slots__ = ()

    def report(self, outcome: str) -> Status:
        if outcome in ("", "running"):
            return RUNNING
        return SUCCESS if outcome == "success" else FAILURE

    def stop(self, now: Tick) -> None:
        if now.outcomes.get(self.path) == RUNNING:
            now.take(self.path)
        super().stop(now)


class CompiledDecision(CompiledNode):
    """A question that the chart asks, then the subtree of the option: a sequence with memory of the two.

    Args:
        options: What can be answered.
        subtrees: Option → its subtree, where it has one.
    """

    __slots__ = ("option", "options", "run", "subtrees")
    role = "activity"

    def __init__(self, options: Collection[str], subtrees: Mapping[str, Any]) -> None:
        super().__init__(tuple(subtrees.values()))
        self.options, self.subtrees = options, subtrees
        self.run = 0
        self.option = ""
        """The answer, once there is one."""

    def tick(self, now: Tick) -> Status:
        if self.status is not RUNNING:
            self._begin(now)
        status = SUCCESS if self.option else self._answer(now)
        subtree = self.subtrees.get(self.option)
        if subtree is not None:
            status = subtree.tick(now)
        self.idle = status is RUNNING and (subtree is None or subtree.idle)
        if status is not RUNNING:
            now.touched.append(self)
        return self.become(status, now)

    def _begin(self, now: Tick) -> None:
        for child in self.children:
            if child.status is not INVALID:
                child.stop(now)
        self.option, self.run = "", self.run + 1
        now.start(self.path)
        now.touched.append(self)

    def _answer(self, now: Tick) -> Status:
        outcome = now.take(self.path)
        self.option = outcome if outcome in self.options else ""
        if not outcome:
            return RUNNING
        now.touched.append(self)
        return SUCCESS if self.option else FAILURE

    def stop(self, now: Tick) -> None:
        is_awaited = self.awaited
        super().stop(now)
        if is_awaited:
            now.end(self.path)

    @property
    def awaited(self) -> bool:
        """The question is asked and there is no answer yet."""
        return self.status is RUNNING and not self.option

    def memory(self) -> Mapping[str, Any] | None:
        if not self.run:
            return super().memory()
        chosen = {"option": self.option} if self.option and self.status is RUNNING else {}
        return {"status": self.status, "run": self.run, **chosen}

    def recall(self, memory: Mapping[str, Any]) -> None:
        super().recall(memory)
        self.run, self.option = memory.get("run", 0), memory.get("option", "")

    def sees(self, child: Any) -> bool:
        return self.status is not RUNNING or child is self.subtrees.get(self.option)
