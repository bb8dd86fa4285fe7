# SPDX-License-Identifier: Apache-2.0
"""What a transition, an entry or an exit does, as an author writes it.

Rule: `set`, `raise` and `drop` are part of the step; the others are sent to the robot after it, and never waited for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, Field, model_validator

from rai_missions.errors import steps_of
from rai_missions.model import (
    WHOLE,
    EventName,
    Json,
    KeyPath,
    Name,
    Number,
    Path,
    Seconds,
    ServiceName,
    TaggedModel,
    Text,
    TimerName,
    TopicName,
    Value,
    fault,
)
from rai_missions.model.references import TEMPLATE, KeyValue, Refers, reference_word, template_paths, template_words

__all__ = (
    "Call",
    "Drop",
    "Effect",
    "Log",
    "Publish",
    "Raise",
    "Say",
    "Set",
    "SetValue",
    "call_lines",
    "references",
)


class Effect(TaggedModel, family="effect"):
    """Something done in passing."""

    sends: ClassVar[str] = ""
    """The field with what it sends along; empty for nothing."""

    def words(self) -> str:
        """As a person would put it, in a line."""
        raise NotImplementedError

    def details(self) -> str:
        """The effect in words, with what it sends along."""
        sent = getattr(self, self.sends) if self.sends else None
        return f"{self.words()} ({template_words(sent)})" if sent else self.words()


def _in_one_piece(value: Json) -> Json:
    """A constant, or a reference; a constant with a reference inside would be kept as it is written."""
    for path, place in template_paths(value):
        if inside := steps_of(place)[:-1]:
            raise fault(
                "set",
                f"'{path}' is a reference inside a value; 'set' takes a constant, or a reference as a whole",
                at=inside,
            )
    return value


SetValue = Annotated[Json, TEMPLATE, AfterValidator(_in_one_piece)]
"""What a `set` writes."""


class Set(Effect, word="set"):
    """Writes a key of the mission: a value, another key's value, or its own plus a number."""

    set: Annotated[Name, Refers("key", "set")]
    """The key that is written."""
    value: SetValue = None
    """The value that it takes, or a reference to where the value is read."""
    from_: Path | None = Field(default=None, alias="from")
    """The key, or the field of an event or answer, whose value it takes."""
    add: Number | None = None
    """The number by which it grows."""

    def __init__(
        self, set: KeyPath, value: Value = None, *, from_: KeyPath | None = None, add: float | None = None
    ) -> None: ...

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = [word for word in ("value", "from_", "add") if getattr(self, word) is not None]
        if len(given) != 1:
            raise fault("set", f"'set' takes one of value, from, add; this has {len(given)}")
        return self

    @property
    def source(self) -> str | None:
        """The path that the value is read from, if it is not written here."""
        if self.from_ is not None:
            return self.from_
        if reference_word(self.value) is not None:
            return str(self.value["from"])
        return None

    def writes(self, place: str = "") -> Iterator[KeyValue]:
        if self.add is not None:
            yield KeyValue(self.set, place, "add", self.add)
        else:
            yield KeyValue(self.set, place, *(("from", self.source) if self.source else ("set", self.value)))

    def words(self) -> str:
        if self.add is not None:
            return f"{self.set} += {self.add:g}"
        return f"{self.set} := {self.source or template_words(self.value)}"


class Raise(Effect, word="raise"):
    """Raises a declared event: at once inside the step, or from outside after a while."""

    sends: ClassVar = "data"

    event: EventName = Field(alias="raise")
    """The event, which the mission declares."""
    after_s: Seconds | None = None
    """Seconds until it is raised; without them it is raised inside the step."""
    id: TimerName | None = None
    """What `drop` calls it by; a second one of the same id replaces the first."""
    data: Annotated[dict[str, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """What it brings along; read as `event.<field>`."""

    def __init__(
        self, event: str, *, after_s: float | None = None, id: str | None = None, data: Mapping[str, Value] = {}
    ) -> None: ...

    def words(self) -> str:
        return f"raise {self.event}" + (f" after {self.after_s:g} s" if self.after_s is not None else "")


class Drop(Effect, word="drop"):
    """Takes back a delayed `raise` that has not come yet."""

    drop: TimerName
    """The `id` of the delayed `raise`."""

    def __init__(self, drop: str) -> None: ...

    def words(self) -> str:
        return f"drop {self.drop}"


class Call(Effect, word="call"):
    """Calls a service of the profile; its failure raises `call_failed`."""

    sends: ClassVar = "request"

    call: ServiceName
    """The service, by the profile's name of it."""
    request: Annotated[dict[str, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """The request's fields; a reference takes a value from the blackboard."""

    def __init__(self, call: str, request: Mapping[str, Value] = {}) -> None: ...

    def words(self) -> str:
        return f"call {self.call}"


class Publish(Effect, word="publish"):
    """Publishes a message on a topic of the profile."""

    sends: ClassVar = "message"

    publish: TopicName
    """The topic, by the profile's name of it."""
    message: Annotated[dict[str, Json], WHOLE, TEMPLATE] = Field(default_factory=dict)
    """The message's fields; a reference takes a value from the blackboard."""

    def __init__(self, publish: str, message: Mapping[str, Value] = {}) -> None: ...

    def words(self) -> str:
        return f"publish {self.publish}"


class Say(Effect, word="say"):
    """Speaks a sentence to people who are near."""

    say: Text
    """The sentence."""

    def __init__(self, say: str) -> None: ...

    def words(self) -> str:
        return f"say “{self.say}”"


class Log(Effect, word="log"):
    """Writes a line to the journal."""

    log: Text
    """The line."""

    def __init__(self, log: str) -> None: ...

    def words(self) -> str:
        return f"log “{self.log}”"


def call_lines(word: str, sent: Mapping[str, Any], result: Mapping[str, str], timeout_s: float | None) -> Iterator[str]:
    """What is sent, what is taken of the answer, and how long it may take."""
    if sent:
        yield f"{word}: {template_words(sent)}"
    if result:
        yield "result: " + ", ".join(f"{key} := {field}" for key, field in result.items())
    if timeout_s is not None:
        yield f"at most {timeout_s:g} s"


def references(template: Any) -> Iterator[str]:
    """The paths that a template takes values from."""
    return (path for path, _ in template_paths(template))
