# SPDX-License-Identifier: Apache-2.0
"""What a robot profile holds of its ROS 2 connector, and its meaning where it is silent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, get_args, get_type_hints

from rai_missions.errors import UsageError, suggestion
from rai_missions.plain_data import is_numeric
from rai_missions.redaction import shown

__all__ = ("DEFAULT", "Options", "QosProfile", "is_conventional", "read_options")

RELIABILITIES = ("reliable", "best_effort")
DURABILITIES = ("volatile", "latched")


@dataclass(frozen=True)
class QosProfile:
    """How messages of one topic travel: ROS 2's quality of service."""

    reliability: str | None = None
    """`reliable` or `best_effort`; left out: reliable, and best effort where the publisher offers no better."""
    durability: str = "volatile"
    """`latched` (ROS 2's `transient_local`): who subscribes later receives the last messages. Or `volatile`."""
    depth: int = 10
    """How many messages wait for a slow reader; 1 means that the newest wins."""


@dataclass(frozen=True)
class Options:
    """A profile's `connector`, next to its `kind`."""

    node: str = ""
    """The node's name; left out, one that is unique in the graph."""
    namespace: str = ""
    domain_id: int | None = None
    """Left out, `ROS_DOMAIN_ID` gives it."""
    arguments: tuple[str, ...] = ()
    """What would follow `--ros-args`: `["-r", "/scan:=/front/scan"]`."""
    parameters: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    """The node's parameters, by name."""
    sim_time: bool = False
    """Time is what `/clock` reports."""
    discovery_s: float = 3.0
    """Seconds in which every peer that exists is found; one that is not found by then does not exist."""
    pictures: bool = False
    """This process publishes pictures; then Fast DDS is given the shared memory that they take."""
    qos: Mapping[str, QosProfile] = field(default_factory=lambda: MappingProxyType({}))
    """Topic → how its messages travel."""

    def quality(self, topic: str) -> QosProfile:
        """How messages of a topic travel."""
        return self.qos.get(topic) or CONVENTIONS.get(topic.rpartition("/")[2], DEFAULT)


DEFAULT = QosProfile()
"""How a topic travels where neither the profile nor a convention states it."""
MAP = QosProfile(durability="latched", depth=1)
TALK = QosProfile(depth=1000)
"""No part of a long message may be lost because another came at the same time."""
CONVENTIONS: Mapping[str, QosProfile] = {
    "tf_static": QosProfile(durability="latched", depth=100),
    "map": MAP,
    "costmap": MAP,
    "from_human": TALK,
    "to_human": TALK,
    "voice_commands": TALK,
}
"""The last word of a topic → how it travels by convention of tf2, map_server, Nav2 and RAI, unless the profile has it.

A publisher of such a topic that latches nothing is received all the same.
"""


def is_conventional(quality: QosProfile) -> bool:
    """The profile does not state how the topic travels: who publishes it otherwise is received too."""
    return any(quality is each for each in CONVENTIONS.values())


def read_options(given: Mapping[str, Any]) -> Options:
    """A profile's words as `Options`.

    Raises:
        UsageError: A word or a value that is not understood; the sentence states what would be right.
    """
    options = dict(_known(given, Options, "connector"))
    if "arguments" in options:
        options["arguments"] = _texts(options["arguments"])
    if "qos" in options:
        qos = options["qos"]
        options["qos"] = {topic: _quality(topic, each) for topic, each in _mapping(qos, "connector/qos").items()}
    if "parameters" in options:
        options["parameters"] = {
            name: _parameter(name, each)
            for name, each in _mapping(options["parameters"], "connector/parameters").items()
        }
    domain, patience = options.get("domain_id"), options.get("discovery_s", 3.0)
    if domain is not None and not 0 <= domain <= 232:
        raise UsageError(f"connector/domain_id: {domain} is no ROS domain; one goes from 0 to 232")
    if not patience > 0:
        raise UsageError(f"connector/discovery_s: {patience} is no time to be found in; give seconds above 0")
    return Options(**options)


def _quality(topic: str, given: Any) -> QosProfile:
    place = f"connector/qos/{topic}"
    quality = dict(_known(_mapping(given, place), QosProfile, place))
    if quality.get("durability") == "transient_local":
        quality["durability"] = "latched"
    for word, values in (("reliability", RELIABILITIES), ("durability", DURABILITIES)):
        if word in quality and quality[word] not in values:
            near = suggestion(str(quality[word]), values)
            raise UsageError(f"{place}/{word}: {shown(quality[word])} is not known{near}")
    if not 1 <= quality.get("depth", 1) <= 10_000:
        raise UsageError(
            f"{place}/depth: {quality['depth']} is no number of messages; give 1 (the newest wins) to 10000"
        )
    return QosProfile(**quality)


def _known(given: Mapping[str, Any], kind: type, place: str) -> Mapping[str, Any]:
    """The words of a dataclass, each of its type."""
    names, hints = [each.name for each in fields(kind)], get_type_hints(kind)
    for word, value in given.items():
        if word not in names:
            raise UsageError(f"{place}: no option {shown(word)}{suggestion(str(word), names)}")
        wanted = get_args(hints[word]) or (hints[word],)
        plain = [each for each in wanted if each in (str, int, float, bool, type(None))]
        if word in ("arguments", "parameters", "qos"):
            continue
        if not any(_is(value, each) for each in plain):
            raise UsageError(f"{place}/{word}: {shown(value)} is no {plain[0].__name__}")
    return given


def _is(value: Any, kind: type) -> bool:
    if kind is float:
        return is_numeric(value)
    return isinstance(value, kind) and (kind is bool or not isinstance(value, bool))


def _mapping(given: Any, place: str) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise UsageError(f"{place}: {shown(given)} is given where an object belongs")
    return given


def _parameter(name: str, value: Any) -> Any:
    """A value that a parameter of ROS may have: one of its kinds, or a list of one of them."""
    kinds = {type(each) for each in (value if isinstance(value, list | tuple) else [value])}
    if not name or len(kinds) > 1 or not kinds <= {str, bool, int, float}:
        words = "give a name, and text, true or false, a number, or a list of one of these"
        raise UsageError(f"connector/parameters/{name}: {shown(value)} is no parameter of ROS; {words}")
    if name == "use_sim_time":  # it would set the node's clock, and leave the run's timers on the wall's
        raise UsageError(f'connector/parameters/{name}: the run lives by it, too; give "sim_time" next to "kind"')
    return value


def _texts(given: Any) -> tuple[str, ...]:
    if not isinstance(given, list | tuple) or not all(isinstance(each, str) for each in given):
        raise UsageError(f'connector/arguments: {shown(given)} is no list of texts, such as ["-r", "/a:=/b"]')
    return tuple(given)
