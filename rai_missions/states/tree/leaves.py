# SPDX-License-Identifier: Apache-2.0
"""Nodes without children: what a tree does and asks, under the words that states and effects have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from rai_missions.errors import suggestion
from rai_missions.guards.guard import Guard, GuardOrKey
from rai_missions.model import WHOLE, AnyOf, Json, KeyPath, Name, Number, Path, Seconds, TopicName, Value, fault
from rai_missions.model.references import TEMPLATE, KeyValue, Refers
from rai_missions.states.action import GoalFields
from rai_missions.states.call import CallFields
from rai_missions.states.decision import BUDGET, Budget, DecisionFields, DecisionSpec, Option
from rai_missions.states.effects import Publish, Set, SetValue
from rai_missions.states.tree.node import TreeNode

__all__ = ("ActionLeaf", "CallLeaf", "CheckLeaf", "DecisionLeaf", "PublishLeaf", "SetLeaf", "WaitLeaf")


class ActionLeaf(GoalFields, TreeNode, word="action"):
    """A goal; as the state of the same word."""

    takes_time: ClassVar = True

    def __init__(
        self,
        action: str,
        *,
        goal: Mapping[str, Value] = {},
        result: Mapping[str, str] = {},
        achieved: GuardOrKey | None = None,
        settle_s: float = 0.0,
        cancel_s: float = 5.0,
        over_orphan: bool = False,
        timeout_s: float | None = None,
        name: str = "",
    ) -> None: ...

    def words(self) -> str:
        return "; ".join((f"action {self.action}", *self.goal_lines()))


class CallLeaf(CallFields, TreeNode, word="call"):
    """A call; as the state of the same word."""

    takes_time: ClassVar = True

    def __init__(
        self,
        call: str,
        *,
        request: Mapping[str, Value] = {},
        result: Mapping[str, str] = {},
        timeout_s: float | None = None,
        name: str = "",
    ) -> None: ...

    def words(self) -> str:
        return "; ".join((f"call {self.call}", *self.call_lines()))


class CheckLeaf(TreeNode, word="check"):
    """Success while a guard is true, failure while it is false or unknown."""

    check: AnyOf[Guard]
    """The guard, or a reference to a boolean key."""

    def __init__(self, check: GuardOrKey, *, name: str = "") -> None: ...

    def words(self) -> str:
        return f"check {self.check.words()}"


class WaitLeaf(TreeNode, word="wait_s"):
    """Running for so long, then success."""

    takes_time: ClassVar = True
    wait_s: Seconds
    """Seconds."""

    def __init__(self, wait_s: float, *, name: str = "") -> None: ...

    def words(self) -> str:
        return f"wait {self.wait_s:g} s"


class SetLeaf(TreeNode, word="set"):
    """Writes a key of the mission; words as the effect's. Without a value that fits it fails."""

    set: Annotated[Name, Refers("key", "set")]
    """The key that is written."""
    value: SetValue = None
    """The value that it takes, or a reference to where the value is read."""
    from_: Path | None = Field(default=None, alias="from")
    """The key, or the field of an answer, whose value it takes."""
    add: Number | None = None
    """The number by which it grows."""

    def __init__(
        self,
        set: KeyPath,
        value: Value = None,
        *,
        from_: KeyPath | None = None,
        add: float | None = None,
        name: str = "",
    ) -> None: ...

    def effect(self) -> Set:
        """The leaf as an effect of a transition."""
        given = {"value": self.value, "from_": self.from_, "add": self.add}
        return Set(set=self.set, **{word: value for word, value in given.items() if value is not None})

    def writes(self, place: str = "") -> Iterator[KeyValue]:
        return self.effect().writes(place)

    def words(self) -> str:
        return self.effect().words()

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if sum(given is not None for given in (self.value, self.from_, self.add)) != 1:
            raise fault("set", "'set' takes one of value, from, add")
        return self


class PublishLeaf(TreeNode, word="publish"):
    """Publishes a message and succeeds."""

    publish: TopicName
    """The topic, by the profile's name of it."""
    message: Annotated[dict[str, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """The message's fields; a reference takes a value from the blackboard."""

    def __init__(self, publish: str, message: Mapping[str, Value] = {}, *, name: str = "") -> None: ...

    def words(self) -> str:
        return Publish(self.publish, self.message).details()


class DecisionLeaf(DecisionFields, TreeNode, word="decision"):
    """Asks, then runs the subtree of the option; an option without one is success."""

    takes_time: ClassVar = True

    then: dict[Name, AnyOf[TreeNode]] = Field(default_factory=dict)
    """Option → what is done then."""

    def __init__(
        self,
        question: str,
        *,
        options: Mapping[str, Option],
        evidence: Sequence[KeyPath] = (),
        ask: Sequence[str] = ("agent", "operator", "rules"),
        attempts: int = 1,
        deadline_s: float | None = None,
        within_s: float | None = None,
        fallback: str | None = None,
        budget: Budget = BUDGET,
        tools: Sequence[str] = (),
        then: Mapping[str, TreeNode] = {},
        name: str = "",
    ) -> None: ...

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        for option, subtree in self.then.items():
            yield f"then/{option}", subtree

    def question(self) -> DecisionSpec:
        return self.decision

    def words(self) -> str:
        return "decision: " + "; ".join(self.decision.lines())

    def leads(self, option: str) -> str:
        then = self.then.get(option)
        return f"then {then.word}" if then is not None else super().leads(option)

    def option_of(self, branch: str) -> Option | None:
        return self.decision.options.get(branch.removeprefix("then/"))

    @model_validator(mode="after")
    def _then_names_options(self) -> Self:
        for option in self.then:
            if option not in self.decision.options:
                known = suggestion(option, self.decision.options)
                raise fault(
                    "then", f"'then' has a subtree for '{option}', which is no option{known}", at=("then", option)
                )
        return self
