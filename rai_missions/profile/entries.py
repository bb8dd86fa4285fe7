# SPDX-License-Identifier: Apache-2.0
"""What is behind the names of actions, services and topics: whom to ask, and how a mission's words become theirs.

Rule: a template is data. `{"from": "pose"}` takes a field of what the mission gives, `"as"` states how it is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self, cast

from pydantic import BeforeValidator, Field, PlainSerializer, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.errors import ConnectorError
from rai_missions.guards.guard import Guard
from rai_missions.model import LISTED, AnyOf, Bool, Json, MissionModel, Name, Seconds, Text, Word, fault, refuse
from rai_missions.plain_data import apart, at_path
from rai_missions.profile.convert import plain, pose_message
from rai_missions.profile.sources import truth_of

__all__ = ("ActionEntry", "AliveEntry", "OneService", "ServiceEntry", "TopicEntry", "references")

TRIGGER = "std_srvs/srv/Trigger"
POSES = ("PoseStamped", "Pose")


class ServiceEntry(MissionModel):
    """A service: its type, what it is asked with, and when its reply is a success.

    Its name alone means one of std_srvs/srv/Trigger where it begins, ends or hands over something.
    """

    positional: ClassVar = ("service",)

    service: Word
    type: Text = TRIGGER
    request: dict[Text, Json] = Field(default_factory=dict)
    """What it is asked with, next to and below what the mission gives; or a template with `{"from": field}`."""
    good: AnyOf[Guard] | None = Field(default=None, alias="succeeded")
    """Over the fields of the reply; left out, a reply whose `success` is false has failed, any other has succeeded."""
    repeat: Bool = False
    """Asking twice does no harm: after a crash it may be asked again."""

    def request_of(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """The request for the robot from the mission's; raises `ConnectorError` as `given_to` does."""
        return given_to(self.request, request)

    def succeeded(self, outcome: str, reply: Mapping[str, Any]) -> bool:
        """Whether a call that ended so, with this reply, did what it should."""
        if outcome != "succeeded":
            return False
        return reply.get("success") is not False if self.good is None else truth_of(self.good, reply) is True


def _service(given: Any) -> Any:
    return {"service": given} if isinstance(given, str) else given


def _short(service: ServiceEntry) -> Any:
    written = service.written()
    return service.service if list(written) == ["service"] else written


class _OrItsName:
    """Adds to the JSON Schema that text may replace the object."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, handler(core)]}


OneService = Annotated[
    ServiceEntry,
    BeforeValidator(_service),
    PlainSerializer(_short, return_type=Any),
    _OrItsName(),
]
"""A service; in JSON its name alone where it has no other field."""


class ActionEntry(MissionModel):
    """An action with a server (`action`, `type`), or one composed of services and guards (`start`, `cancel`, …)."""

    action: Word | None = None
    type: Text = ""
    goal: dict[Text, Json] = Field(default_factory=dict)
    """What the goal has next to and below what the mission gives; or a template with `{"from": field}`."""
    result: dict[Text, Text] = Field(default_factory=dict)
    """Names for the mission → fields of the server's result; left out, the result as it is."""
    start: OneService | None = None
    """The service that begins a composed action; a reply that fails rejects the start."""
    cancel: OneService | None = None
    """The service that ends it."""
    succeeded: AnyOf[Guard] | None = None
    """Over the mission's blackboard: when a composed action has succeeded."""
    failed: AnyOf[Guard] | None = None
    """Over the mission's blackboard: when it has failed."""
    uses: Annotated[tuple[Name, ...], LISTED] = ()
    """What it occupies; two actions that share one conflict. None named: all."""
    keep: Bool = False
    """Its goal continues while the mission is paused."""
    repeat: Bool = False
    """Starting twice does no harm: after a crash it may be started again."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[PydanticCustomError]:
        if (self.action is None) == (self.start is None):
            which = "neither" if self.action is None else "both"
            yield fault("action", f"an action has a server, 'action', or is composed, 'start' …; this is {which}")
        elif self.start is None:
            given = [word for word in ("cancel", "succeeded", "failed") if getattr(self, word) is not None]
            if given:
                yield fault("action", f"the server of '{self.action}' reports how it ends: drop {', '.join(given)}")
        else:
            given = [word for word in ("type", "goal", "result") if getattr(self, word)]
            if given:
                yield fault("action", f"a composed action has no server: drop {', '.join(given)}")
            if self.succeeded is None:
                yield fault("succeeded", "a composed action needs 'succeeded': a guard that states when it has")

    def goal_of(self, goal: Mapping[str, Any]) -> dict[str, Any]:
        """The goal for the server from the mission's; raises `ConnectorError` as `given_to` does."""
        return given_to(self.goal, goal)

    def result_of(self, result: Mapping[str, Any]) -> dict[str, Any]:
        """The result for the mission from the server's.

        Raises:
            ConnectorError: There is something in it that is no plain data.
        """
        if self.result:
            return {name: plain(at_path(result, path)) for name, path in self.result.items()}
        return dict(plain(result))


class TopicEntry(MissionModel):
    """A topic that the mission publishes on."""

    positional: ClassVar = ("topic", "type")

    topic: Word
    type: Text
    message: dict[Text, Json] = Field(default_factory=dict)
    """What a message has next to and below what the mission gives; or a template with `{"from": field}`."""
    repeat: Bool = False
    """Publishing twice does no harm: after a crash it may be published again."""

    def message_of(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """The message for the robot from the mission's; raises `ConnectorError` as `given_to` does."""
        return given_to(self.message, message)


class AliveEntry(MissionModel):
    """A topic on which a run reports that it continues."""

    positional: ClassVar = ("topic",)

    topic: Word
    type: Text = "std_msgs/msg/Empty"
    every_s: Seconds = Field(default=0.1, gt=0)
    """Seconds between two messages; well below the lease of anyone who listens."""


def references(template: Any) -> Iterator[str]:
    """The fields that a template takes from the mission, as paths."""
    if isinstance(template, Mapping):
        if isinstance(template.get("from"), str) and template.keys() <= {"from", "as"}:
            yield template["from"]
            return
        template = list(template.values())
    if isinstance(template, list | tuple):
        for item in template:
            yield from references(item)


def given_to(template: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """What the robot is given, as values of its own: a template filled, or the mission's fields over the profile's.

    Raises:
        ConnectorError: A field that the template wants is not given, or does not fit where the template has it.
    """
    if not template or not any(True for _ in references(template)):
        return cast("dict[str, Any]", apart(_over(template, given)))
    return {name: apart(_filled(item, given)) for name, item in template.items()}


def _over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(below)
    for name, item in above.items():
        under = merged.get(name)
        both = isinstance(under, Mapping) and isinstance(item, Mapping)
        merged[name] = _over(under, item) if both else item  # type: ignore[arg-type]
    return merged


def _filled(template: Any, given: Mapping[str, Any]) -> Any:
    if isinstance(template, list | tuple):
        return [_filled(item, given) for item in template]
    if not isinstance(template, Mapping):
        return template
    if not (isinstance(template.get("from"), str) and template.keys() <= {"from", "as"}):
        return {name: _filled(item, given) for name, item in template.items()}
    value = at_path(given, template["from"])
    if value is None:
        raise ConnectorError(
            f"the robot needs '{template['from']}', and the mission gives: {', '.join(given) or 'nothing'}"
        )
    kind = str(template.get("as", "")).rpartition("/")[2]
    return pose_message(value, stamped=kind == "PoseStamped") if kind in POSES else value
