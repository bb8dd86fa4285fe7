# SPDX-License-Identifier: Apache-2.0
"""Where a key's values or an event come from: a topic, or a service that is asked again and again.

Rule: a source defines how a message is understood; who listens, and when, is the performer's affair.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any, Literal, Self, cast

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.errors import ConnectorError
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Truth, View
from rai_missions.image import Image
from rai_missions.keys import Key, Stamped
from rai_missions.model import AnyOf, Bool, Json, MissionModel, Name, Seconds, Text, Word, fault, refuse
from rai_missions.plain_data import at_path
from rai_missions.profile.convert import image_of, json_of, plain, pose_of
from rai_missions.redaction import cut_repr

__all__ = ("EventSource", "Source", "truth_of")

Read = Literal["plain", "pose", "image"]
READ_AS: Mapping[str, Read] = {
    "PoseStamped": "pose",
    "PoseWithCovarianceStamped": "pose",
    "Pose": "pose",
    "Odometry": "pose",
    "Image": "image",
    "CompressedImage": "image",
}
"""The last word of a message's type → how it is read where nothing else is reported."""
NUMBERS = ("Byte", "Int8", "Int16", "Int32", "Int64", "UInt8", "UInt16", "UInt32", "UInt64")
GIVES: Mapping[str, str] = {
    "Bool": "boolean",
    "String": "string",
    "Float32": "number",
    "Float64": "number",
    **dict.fromkeys(NUMBERS, "integer"),
}
"""Messages of std_msgs that hold one value in `data`, and its type."""
WORDS_OF_GUARDS = {word: Key(type="object") for word in ("event", "answer")}
"""In the guard of a message `event` and `answer` are fields like any other."""


class SourceFields(MissionModel):
    """A topic that is listened to, or a service that is asked again and again."""

    topic: Word | None = None
    service: Word | None = None
    type: Text = ""
    """The message's or service's type, `std_msgs/msg/String`."""
    every_s: Seconds | None = Field(default=None, gt=0)
    """How often the service is asked."""
    request: dict[Text, Json] = Field(default_factory=dict)
    """What the service is asked with."""

    @model_validator(mode="after")
    def _has_a_source(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[PydanticCustomError]:
        """Why a source is not one thing, with the words of that."""
        topic, service, every_s = self.topic, self.service, self.every_s
        is_topic = topic is not None and service is None
        if (topic is None) == (service is None):
            which = "neither" if topic is None else "both"
            yield fault("source", f"a source is a 'topic' or a 'service', this is {which}")
        elif service is not None and every_s is None:
            sentence = "is a service and is asked again and again: state how often with 'every_s'"
            yield fault("every_s", f"'{service}' {sentence}")
        if is_topic and every_s is not None:
            yield fault("every_s", f"'{topic}' is a topic and speaks by itself: drop 'every_s'")
        if is_topic and self.request:
            yield fault("request", "a topic is not asked; 'request' belongs to a 'service'")


class Source(SourceFields):
    """A topic, or a service polled `every_s`, and the part of its messages that counts."""

    field: Text = ""
    """The field that counts, `pose.pose` or `ranges.0`; empty for the whole message, and for `data` of the simple
    messages of std_msgs."""
    json_: Bool = Field(default=False, alias="json")
    """The field, or `data` where none is named, is a text with JSON; the value is read from that JSON."""
    read: Read | None = Field(default=None, alias="as")
    """`pose` or `image`; left out, it follows from the type of the message."""

    def _faults(self) -> Iterator[PydanticCustomError]:
        yield from super()._faults()
        if self.json_ and self.read is not None:
            yield fault("as", "'json' and 'as' are two ways to read one field; keep one")

    @property
    def reads(self) -> Read:
        """How its messages are read."""
        if self.read is not None:
            return self.read
        return "plain" if self.json_ or self.field else READ_AS.get(self._kind, "plain")

    @property
    def gives(self) -> str | None:
        """The blackboard's type of its values, where the message's type reports it."""
        if self.reads != "plain":
            return self.reads
        return GIVES.get(self._kind) if not self.json_ and self.path == "data" and self._is_simple else None

    @property
    def path(self) -> str:
        """The field that is read."""
        return self.field or ("data" if self.json_ or self._is_simple else "")

    def value(self, message: Mapping[str, Any], at: float = 0.0) -> Any:
        """What a message, or a service's reply, reports.

        Args:
            message: As a connector brings it.
            at: When it was received, seconds; it names a picture that has no name of its own.

        Returns:
            A value of the blackboard; None where the message leaves it open, which is as if nothing was received.

        Raises:
            ConnectorError: The message is not what the profile states it is.
        """
        part = at_path(message, self.path)
        if self.json_:
            return json_of(part)
        if self.reads == "image":
            return image_of(part, f"{self.topic or self.service}@{at:.3f}")
        if self.reads == "pose":
            pose = pose_of(part)
            frame = at_path(message, "header.frame_id")
            return pose if pose is None or pose["frame"] or not isinstance(frame, str) else {**pose, "frame": frame}
        return plain(part)

    @property
    def _kind(self) -> str:
        return self.type.rpartition("/")[2]

    @property
    def _is_simple(self) -> bool:
        return self.type.startswith("std_msgs/") and self._kind in GIVES


class EventSource(SourceFields):
    """What is received when an event happens: every message, or the first for which `when` becomes true."""

    json_: Bool = Field(default=False, alias="json")
    """`data` is JSON text; `when` and `fields` name fields of what it reports."""
    when: AnyOf[Guard] | None = None
    """Over the fields of the message: `{"key": "message", "==": "WAITING"}`."""
    fields: dict[Name, Text] = Field(default_factory=dict)
    """The payload's fields → where they are in the message; left out, the whole message."""
    during: Name | None = None
    """An action of the profile: received only from its start until the mission asks for its end. What was so before it
    began is no news."""
    posted: Bool = False
    """Nothing of the robot reports it: another program or a person posts it to the runner."""

    def _faults(self) -> Iterator[PydanticCustomError]:
        if not self.posted:
            yield from super()._faults()
            return
        if self.topic is not None or self.service is not None:
            yield fault("posted", "an event is 'posted' or received on a topic or service, not both; drop one")
        if self.during is not None:
            yield fault("during", "an event that is 'posted' is not listened for; drop 'during'")

    def fires(self, message: Mapping[str, Any]) -> Truth:
        """Whether `when` is true of a message; true without one.

        Raises:
            ConnectorError: The message is not what the profile states it is.
        """
        return True if self.when is None else truth_of(self.when, self._content(message))

    def happens(self, before: Truth, now: Truth) -> bool:
        """Whether it happens with a message for which `fires` is `now`, after one for which it was `before`."""
        return now is True and (self.when is None or before is not True)

    def payload(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """The event's data.

        Raises:
            ConnectorError: The message is not what the profile states it is.
        """
        content = self._content(message)
        if self.fields:
            return {name: plain(at_path(content, path)) for name, path in self.fields.items()}
        return cast("dict[str, Any]", plain(content))

    def _content(self, message: Mapping[str, Any]) -> Mapping[str, Any]:
        content = json_of(message.get("data")) if self.json_ else message
        if not isinstance(content, Mapping):
            raise ConnectorError(f"{cut_repr(content, 60)} is given where an object with fields belongs")
        return content


def truth_of(guard: Guard, message: Mapping[str, Any]) -> Truth:
    """What a guard reports whose keys are the fields of a message."""
    board = {name: Stamped(item, 0.0) for name, item in message.items() if not isinstance(item, Image | bytes)}
    view = SimpleNamespace(at=0.0, board=board, active=frozenset(), entered={}, held={}, event={}, answer={})
    return guard.compile(Site("", WORDS_OF_GUARDS))(cast(View, view))
