# SPDX-License-Identifier: Apache-2.0
"""A robot profile: what is behind the names that a mission uses.

Rule: a profile states where things are received and done, never what they mean for a mission.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.errors import suggestion
from rai_missions.guards.guard import Guard
from rai_missions.model import (
    LISTED,
    AnyOf,
    Format,
    Json,
    MissionModel,
    Name,
    Text,
    fault,
    is_recorded,
    refuse,
    without_schema,
)
from rai_missions.profile.conversation import ConversationPolicy
from rai_missions.profile.entries import ActionEntry, AliveEntry, OneService, ServiceEntry, TopicEntry
from rai_missions.profile.sources import EventSource, Source
from rai_missions.redaction import shown
from rai_missions.states.control import HOLDERS

__all__ = ("Place", "Robot", "Rule", "ToolPolicy", "robot_facts", "service_places")


class Rule(MissionModel):
    """One row of a policy: the option to answer with, and when."""

    when: AnyOf[Guard] | None = None
    """Over the mission's blackboard; left out, always."""
    answer: Name


Rules = Annotated[tuple[Rule, ...], LISTED]


Patterns = Annotated[tuple[Text, ...], LISTED]


class ToolPolicy(MissionModel):
    """What a model's tools may touch: patterns over names, `*` for any characters; never goes before the others."""

    read: Patterns = ("*",)
    """What may be looked at."""
    write: Patterns = ()
    """What may be published on, called and started, by tools that act; and looked at."""
    never: Patterns = ()
    """What is not touched, nor anything below it."""

    @model_validator(mode="after")
    def _has_patterns_of_whole_names(self, info: ValidationInfo) -> Self:
        refuse(() if is_recorded(info) else self._pattern_faults())
        return self

    def _pattern_faults(self) -> Iterator[PydanticCustomError]:
        for word in ("read", "write", "never"):
            for at, pattern in enumerate(getattr(self, word)):
                if not pattern:
                    yield fault(word, f"an empty pattern in '{word}' is no name; drop it", at=(word, at))
                elif not pattern.startswith(("/", "*", "?")):
                    why = f"{shown(pattern)} fits no name, since each begins with a slash; write {shown('/' + pattern)}"
                    yield fault(word, why, at=(word, at))


class Robot(MissionModel):
    """One robot, real or simulated, in the words of the missions that it can run."""

    positional: ClassVar = ("name",)

    format: Format = 1
    name: Text
    about: Text = ""
    connector: dict[Text, Json] = Field(default_factory=lambda: {"kind": "local"})
    """How it is reached: `kind`, and what that kind of connector takes."""
    blackboard: dict[Name, Source] = Field(default_factory=dict)
    """Key → where its values are received."""
    events: dict[Name, EventSource] = Field(default_factory=dict)
    actions: dict[Name, ActionEntry] = Field(default_factory=dict)
    services: dict[Name, ServiceEntry] = Field(default_factory=dict)
    topics: dict[Name, TopicEntry] = Field(default_factory=dict)
    """What the mission can publish on."""
    rules: dict[Name, Rules] = Field(default_factory=dict)
    """State → who answers as `rules` there, row by row."""
    control: dict[Text, OneService] = Field(default_factory=dict)
    """Who shall hold control → the service that hands it over; one that is not here has it at once.

    `{by}` in the service's name becomes `operator` where an operator asks, else `agent`: the mission asks as the agent.
    """
    holder: Source | None = None
    """Where it is received who holds control, by name; what is received there counts, whatever a handover's service
    reports."""
    alive: AliveEntry | None = None
    """Where the run reports again and again that it continues, so that control can be taken from one that hangs."""
    identity: Text = ""
    """The folder with the robot's identity, next to this file."""
    tools: ToolPolicy | None = None
    """What the tools of a model may touch; left out, it has none."""
    conversation: ConversationPolicy | None = None
    """How it talks with people."""

    _without_schema = model_validator(mode="before")(without_schema)

    @field_validator("control")
    @classmethod
    def _knows_its_controllers(cls, control: dict[str, ServiceEntry]) -> dict[str, ServiceEntry]:
        refuse(
            fault("control", f"no one called '{name}' can hold control{suggestion(name, HOLDERS)}", at=(name,))
            for name in control
            if name not in HOLDERS
        )
        return control

    @field_validator("connector")
    @classmethod
    def _has_a_kind(cls, connector: dict[str, Any]) -> dict[str, Any]:
        if not isinstance(connector.get("kind"), str):
            raise fault("connector", 'a connector has a \'kind\': "local", "ros2", …')
        return connector

    @model_validator(mode="after")
    def _knows_its_actions(self) -> Self:
        refuse(self._event_faults())
        return self

    def _event_faults(self) -> Iterator[PydanticCustomError]:
        for name, event in self.events.items():
            if event.during is not None and event.during not in self.actions:
                near = suggestion(event.during, self.actions)
                why = f"'{name}' is received during '{event.during}', which is no action here{near}"
                yield fault("events", why, at=("events", name, "during"))

    @property
    def world(self) -> str:
        """The simulated world in which it is, inside the process of its run; empty for none."""
        return str(self.connector.get("world") or "") if self.connector["kind"] == "local" else ""

    def written(self) -> dict[str, Any]:
        """As JSON has it."""
        return {"format": self.format, **super().written()}


def robot_facts(robot: Robot) -> RobotFacts:
    """What the pure engine needs to know of a robot."""
    actions = robot.actions
    return RobotFacts(
        uses={name: frozenset(action.uses) or None for name, action in actions.items()},
        keep=frozenset(name for name, action in actions.items() if action.keep),
        succeeded={name: action.succeeded for name, action in actions.items() if action.succeeded is not None},
        failed={name: action.failed for name, action in actions.items() if action.failed is not None},
        repeat=frozenset(
            [name for name, action in actions.items() if action.repeat]
            + [name for name, service in robot.services.items() if service.repeat]
        ),
    )


Place = tuple[str, ...]
"""Where something is in a profile, word by word: `("actions", "go", "start")`."""


def service_places(robot: Robot) -> Iterator[tuple[Place, ServiceEntry]]:
    """The services that a run may ask, each with its place: the mission's, those of composed actions, handovers."""
    for name, service in robot.services.items():
        yield ("services", name), service
    for name, action in robot.actions.items():
        for word, part in (("start", action.start), ("cancel", action.cancel)):
            if part is not None:
                yield ("actions", name, word), part
    for name, service in robot.control.items():
        yield ("control", name), service
