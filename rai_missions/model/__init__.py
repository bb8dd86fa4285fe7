# SPDX-License-Identifier: Apache-2.0
"""What the models of everything that is written are made of: the format's words, kinds and references.

Imports nothing of the other packages.
"""

from rai_missions.model.attribute_docs import explained
from rai_missions.model.family import FAMILY, AnyOf, TaggedModel, kind_of
from rai_missions.model.fields import (
    LISTED,
    ActionName,
    Bool,
    EventName,
    Format,
    HasPath,
    Integer,
    Json,
    KeyName,
    KeyPath,
    Name,
    Number,
    Path,
    Seconds,
    ServiceName,
    StateName,
    StateNames,
    Text,
    TimerName,
    TopicName,
    Value,
    Word,
    alike,
    fault,
    one_or_many,
)
from rai_missions.model.mission_model import MissionModel, without_schema

__all__ = (
    "FAMILY",
    "LISTED",
    "ActionName",
    "AnyOf",
    "Bool",
    "EventName",
    "Format",
    "HasPath",
    "Integer",
    "Json",
    "KeyName",
    "KeyPath",
    "MissionModel",
    "Name",
    "Number",
    "Path",
    "Seconds",
    "ServiceName",
    "StateName",
    "StateNames",
    "TaggedModel",
    "Text",
    "TimerName",
    "TopicName",
    "Value",
    "Word",
    "alike",
    "explained",
    "fault",
    "kind_of",
    "one_or_many",
    "without_schema",
)
