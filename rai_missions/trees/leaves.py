# SPDX-License-Identifier: Apache-2.0
"""The leaves of a tree, and the decision, as behaviours: what they do is handed to the round, never done here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from rai_missions.engine.templates import FilledTemplate
from rai_missions.engine.trees.tick import Tick
from rai_missions.guards.view import Test, View
from rai_missions.keys import Key, type_error
from rai_missions.trees.nodes import FAILURE, INVALID, RUNNING, SUCCESS, WORDS, TracedBehaviour

__all__ = (
    "ActivityLeaf",
    "AskBehaviour",
    "CheckBehaviour",
    "PublishBehaviour",
    "PythonLeaf",
    "WaitBehaviour",
    "WriteBehaviour",
)


class TreeLeaf(TracedBehaviour, Behaviour):
    """A behaviour without children. Ticked as py_trees does it, less the sentences that it makes for its log."""

    def tick(self) -> Iterator[Behaviour]:
        if self.status is not RUNNING:
            self.initialise()
        status = self.update()
        if status is not RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def stop(self, new_status: Status) -> None:
        self.terminate(new_status)
        self.status = new_status

    def update(self) -> Status:
        status = self.act()
        self.round.trace.append((self.path, "update", WORDS[status]))
        return status

    def act(self) -> Status:
        """What the leaf does when it is ticked."""
        raise NotImplementedError


class CheckBehaviour(TreeLeaf):
    """Whether a guard is true."""

    test: Test

    def act(self) -> Status:
        return SUCCESS if self.test(self.round.sight) is True else FAILURE


class WaitBehaviour(TreeLeaf):
    """Runs for so many seconds."""

    wait_s: float
    until: float

    def initialise(self) -> None:
        super().initialise()
        self.until = self.round.sight.at + self.wait_s

    def act(self) -> Status:
        return SUCCESS if self.round.sight.at >= self.until else RUNNING

    def kept(self) -> dict[str, Any]:
        return {"until": self.until} if self.status is RUNNING else {}

    def recall(self, memory: Mapping[str, Any]) -> None:
        self.until = memory.get("until", 0.0)

    def deadline(self) -> float | None:
        return self.until


class WriteBehaviour(TreeLeaf):
    """Writes a key; fails where the value is unknown or does not fit."""

    key: str
    definition: Key | None
    value: Callable[[View], Any]
    adds = False
    """It adds to what is there."""

    @property
    def looks(self) -> bool:
        """What it adds to is its own affair, as long as there is something to add to."""
        return not self.adds or self.status is not SUCCESS

    def act(self) -> Status:
        value = self.value(self.round.sight)
        if value is None or (self.definition is not None and type_error(self.definition, value)):
            return FAILURE
        self.round.write(self.key, value)
        return SUCCESS


class PublishBehaviour(TreeLeaf):
    """Publishes a message."""

    topic: str
    message: Callable[[View], FilledTemplate]

    def act(self) -> Status:
        self.round.published.append((self.topic, self.message(self.round.sight)))
        return SUCCESS


class ActivityLeaf(TreeLeaf):
    """An action or a call: the chart runs it, and this waits for what came of it."""

    run = 0
    """How often it was started."""
    refused = False
    """It was rejected the last time: for want of what it is sent with, of a server, or of what it needs."""

    @property
    def awaited(self) -> bool:
        """The chart runs it and has not been asked to end it."""
        return self.status is RUNNING

    @property
    def looks(self) -> bool:
        """What an action or call was sent with makes no difference any more, unless it was refused for that."""
        return self.refused

    def initialise(self) -> None:
        super().initialise()
        self.run, self.refused = self.run + 1, False
        self.round.start(self.path)

    def act(self) -> Status:
        outcome = self.round.take(self.path)
        if not outcome:
            return RUNNING
        self.refused = outcome == "rejected"
        return SUCCESS if outcome == "succeeded" else FAILURE

    def terminate(self, new_status: Status) -> None:
        super().terminate(new_status)
        if new_status is INVALID and self.awaited:
            self.round.end(self.path)

    def kept(self) -> dict[str, Any]:
        if not self.run:
            return {}
        return {"run": self.run, "refused": True} if self.refused else {"run": self.run}

    def recall(self, memory: Mapping[str, Any]) -> None:
        self.run, self.refused = memory.get("run", 0), memory.get("refused", False)


class PythonLeaf(ActivityLeaf):
    """A live behaviour of the user's program that is ticked next to the mission: this reports what it reported last."""

    def act(self) -> Status:
        result = self.round.take(self.path)
        if result in ("", "running"):
            return RUNNING
        return SUCCESS if result == "success" else FAILURE

    def terminate(self, new_status: Status) -> None:
        if self.round.outcomes.get(self.path) == "running":
            self.round.take(self.path)
        super().terminate(new_status)


class AskBehaviour(TracedBehaviour, composites.Composite):
    """A question that the chart asks, then the subtree of the option: a sequence with memory of the two."""

    round: Tick
    options: Collection[str]
    subtrees: Mapping[str, Behaviour]
    """Option → its subtree, where it has one."""
    run = 0
    option = ""
    """The answer, once there is one."""

    @property
    def awaited(self) -> bool:
        """The question is asked and there is no answer yet."""
        return self.status is RUNNING and not self.option

    def ahead(self) -> list[Any]:
        if self.status is not RUNNING:
            return self.children
        return [] if self.current_child is None else [self.current_child]

    def tick(self) -> Iterator[Behaviour]:
        if self.status is not RUNNING:
            self.begin()
        status = self.update() if not self.option else SUCCESS
        subtree = self.current_child = self.subtrees.get(self.option)
        if subtree is not None:
            yield from subtree.tick()
            status = subtree.status
        if status is not RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def begin(self) -> None:
        for child in self.children:
            if child.status is not INVALID:
                child.stop(INVALID)
        self.option, self.run = "", self.run + 1
        self.initialise()
        self.round.start(self.path)

    def update(self) -> Status:
        outcome = self.round.take(self.path)
        self.option = outcome if outcome in self.options else ""
        status = SUCCESS if self.option else FAILURE if outcome else RUNNING
        self.round.trace.append((self.path, "update", WORDS[status]))
        return status

    def terminate(self, new_status: Status) -> None:
        super().terminate(new_status)
        if new_status is INVALID and self.awaited:
            self.round.end(self.path)

    def kept(self) -> dict[str, Any]:
        chosen = {"option": self.option} if self.option and self.status is RUNNING else {}
        return {"run": self.run, **chosen} if self.run else {}

    def recall(self, memory: Mapping[str, Any]) -> None:
        self.run, self.option = memory.get("run", 0), memory.get("option", "")
        self.current_child = self.subtrees.get(self.option)
