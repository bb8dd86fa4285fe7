# SPDX-License-Identifier: Apache-2.0
"""What a person writes about a gate: in a file, or on the command line.

Rule: topics are named after who speaks on them, so that one rule of a network's security covers all that a holder
sends.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.errors import DefinitionError, Fault, UsageError, suggestion
from rai_missions.gate.state import COMMANDERS, GateRules
from rai_missions.mission.json_reader import read_json
from rai_missions.model import Bool, Format, Integer, Json, MissionModel, Seconds, Text, fault, refuse, without_schema
from rai_missions.model.validation_errors import validated
from rai_missions.redaction import shown

__all__ = ("CommandTopic", "GateWords", "command_topic", "gate_words", "leases_of", "read_gate")

ZERO_STOPS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
"""Types of which a message of zeros stops the robot."""
LEASES: Mapping[str, float] = {"agent": 0.5}
SHORTEST_LEASE_S = 0.01
TOPIC = r"^(/[A-Za-z_][A-Za-z0-9_]*)+$"


def _topic(given: str) -> str:
    """A topic's name, from the root on.

    Raises:
        PydanticCustomError: It is none.
    """
    if not re.fullmatch(TOPIC, given):
        whole = f"/{given}" if re.fullmatch(TOPIC, f"/{given}") else "/robot/cmd_vel"
        raise fault("topic", f"{shown(given)} is no topic's name from the root on; write it like '{whole}'")
    return given


Topic = Annotated[Text, AfterValidator(_topic), Field(json_schema_extra={"pattern": TOPIC})]


class CommandTopic(MissionModel):
    """A topic of the actuators: what arrives there has passed the gate."""

    positional: ClassVar = ("topic", "type")

    topic: Topic
    type: Text
    stop: Json = None
    """The message that stops what is commanded, `{}` for one of zeros; it is published before control changes.
    Left out, zeros for a Twist or TwistStamped, and no message for other types."""
    depth: Integer = Field(default=1, ge=1)
    """How many commands wait where the gate is slow; 1 means that the newest wins."""
    finite: Bool = True
    """A command with a number that is NaN or infinite is refused."""

    @field_validator("stop")
    @classmethod
    def _is_a_message(cls, stop: Any) -> Any:
        if stop is not None and not isinstance(stop, dict):
            raise fault("stop", f"{shown(stop)} is no message; give its fields, or {{}} for zeros")
        return stop

    @property
    def stop_message(self) -> Mapping[str, Any] | None:
        """What stops it; None if nothing does."""
        return {} if self.stop is None and self.type in ZERO_STOPS else self.stop


class GateWords(MissionModel):
    """The configuration of one gate, as its JSON file has it: name, command topics, leases, safe holder."""

    format: Format = 1
    name: Topic = "/gate"
    """What its topics and services are below."""
    commands: tuple[CommandTopic, ...] = Field(
        default_factory=lambda: (CommandTopic("/cmd_vel", "geometry_msgs/msg/Twist"),)
    )
    leases: dict[Text, Seconds] = Field(default_factory=lambda: dict(LEASES))
    """Holder → seconds of silence after which it loses control; 0 for a holder that may be silent for ever."""
    safe: Literal["autonomy", "nobody"] = "autonomy"
    """Who has control when its holder falls silent, and when the gate begins."""
    status_s: Annotated[Seconds, Field(gt=0)] = 1.0

    _without_schema = model_validator(mode="before")(without_schema)

    @field_validator("leases")
    @classmethod
    def _knows_its_holders(cls, leases: dict[str, float]) -> dict[str, float]:
        refuse(_lease_faults(leases))
        return leases

    @field_validator("commands")
    @classmethod
    def _guards_each_topic_once(cls, commands: tuple[CommandTopic, ...]) -> tuple[CommandTopic, ...]:
        if not commands:
            raise fault("commands", "a gate without command topics guards nothing; give at least one")
        times = Counter(each.topic for each in commands)
        refuse(fault("commands", f"'{topic}' is here twice; drop one") for topic, many in times.items() if many > 1)
        return commands

    @property
    def rules(self) -> GateRules:
        """What its rules need to know."""
        leases = {who: lease_s for who, lease_s in self.leases.items() if lease_s > 0}
        unlooked = frozenset(each.topic for each in self.commands if not each.finite)
        return GateRules(leases=leases, safe=self.safe, status_s=self.status_s, unlooked=unlooked)

    def options(self, **options: Any) -> dict[str, Any]:
        """What a connector of kind `ros2` is opened with: the quality of each topic, next to what is given."""
        latched = {"durability": "latched", "depth": 1}
        qos: dict[str, Any] = {f"{self.name}/status": latched, f"{self.name}/holder": latched}
        for each in self.commands:
            qos[each.topic] = {"depth": 1}
            qos |= {f"{self.name}/{who}{each.topic}": {"depth": each.depth} for who in COMMANDERS}
        return {"node": self.name.strip("/").replace("/", "_"), "qos": qos, **options}


def _lease_faults(leases: Mapping[str, float]) -> Iterator[PydanticCustomError]:
    for who, lease_s in leases.items():
        if who not in COMMANDERS:
            why = f"no one called '{who}' commands actuators{suggestion(who, COMMANDERS)}"
            yield fault("leases", why, at=(who,))
        if 0 < lease_s < SHORTEST_LEASE_S:
            why = f"{lease_s:g} s for '{who}' is shorter than a message's way; give 0.01 or more"
            yield fault("leases", why, at=(who,))


def read_gate(path: str | Path, **words: Any) -> GateWords:
    """The gate in a JSON file; words given here count instead of the file's.

    Raises:
        DefinitionError: The file is at fault, every fault with its place.
        UsageError: There is no such file.
    """
    data = read_json(Path(path))
    if not isinstance(data, Mapping):
        raise DefinitionError([Fault("", f"a gate is a JSON object, not {shown(data)}")], str(path))
    return gate_words({**data, **words}, str(path))


def gate_words(data: Mapping[str, Any], source: str = "") -> GateWords:
    """A gate from plain data.

    Raises:
        DefinitionError: It is at fault, every fault with its place.
    """
    return validated(GateWords, dict(data), source)


def command_topic(text: str) -> dict[str, str]:
    """`TOPIC=TYPE` as it is in a gate's file.

    Raises:
        UsageError: It is not written so.
    """
    topic, sign, kind = text.partition("=")
    if not sign or not topic or not kind:
        raise UsageError(f"--command {text}: write TOPIC=TYPE, such as /cmd_vel=geometry_msgs/msg/Twist")
    return {"topic": topic, "type": kind}


def leases_of(texts: Iterable[str]) -> dict[str, float]:
    """`HOLDER=SECONDS`, several of them, as they are in a gate's file.

    Raises:
        UsageError: One is not written so.
    """
    leases = {}
    for text in texts:
        who, _, seconds = text.partition("=")
        try:
            leases[who] = float(seconds)
        except ValueError:
            raise UsageError(f"--lease {text}: write HOLDER=SECONDS, such as agent=0.5") from None
    return leases
